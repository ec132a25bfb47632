"""Faces of supports in space, as far as they are near the structure."""
import numpy as np

CELLS = 16               # of a height field along each of its axes


def surroundings(place):
    room = 0.06 * (np.linalg.norm(np.ptp(place, axis=0)) or 1.0)
    return place.min(axis=0) - room, place.max(axis=0) + room


def support_faces(run):
    """Pairs (number of the support, corners) of what is near."""
    low, high = surroundings(run.place)
    reach = 0.8 * np.linalg.norm(high - low)
    found = []
    for number, support in enumerate(run.supports):
        if support.field is not None:
            corners = field_faces(support, low, high)
        elif support.pair is not None:
            continue
        elif support.normal is not None:
            corners = plane_face(support, low, high, reach)
        elif support.striker is None:
            corners = strips(support, low, high, reach)
        else:
            continue
        found += [(number, face) for face in corners]
    return found


def strips(support, low, high, reach):
    z = max(low[2], support.box[2, 0]), min(high[2], support.box[2, 1])
    face, x = np.asarray(support.face, float), np.array(support.x, float)
    if not np.isfinite(face).all() or face.min() > high[1] + reach or face.max() < low[1] - reach:
        return []
    if support.is_floor:
        if len(x) == 1:
            x, face = np.repeat(x, 2), np.repeat(face, 2)
        x[[0, -1]] = low[0], high[0]
    if len(x) == 1:
        return [np.array([(x[0], face[0], z[0]), (x[0], face[0], z[1])])]
    return [np.array([(a, c, z[0]), (b, d, z[0]), (b, d, z[1]), (a, c, z[1])])
            for a, b, c, d in zip(x[:-1], x[1:], face[:-1], face[1:])]


def plane_face(support, low, high, reach):
    low, high = np.maximum(low, support.box[:, 0]), np.minimum(high, support.box[:, 1])
    middle = 0.5 * (low + high)
    centre = middle + (support.height - support.normal @ middle) * support.normal
    if not np.isfinite(centre).all() or np.linalg.norm(centre - middle) > reach:
        return []
    across = np.cross(support.normal, (0.0, 0.0, 1.0) if abs(support.normal[2]) < 0.9 else (1.0, 0.0, 0.0))
    first = across / np.linalg.norm(across)
    along = [0.5 * (np.abs(axis) @ (high - low)) * axis for axis in (first, np.cross(support.normal, first))]
    return [np.array([centre + a * along[0] + b * along[1] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])]


def field_faces(support, low, high):
    x, z, height = support.field

    def chosen(axis, k):
        near = np.flatnonzero((axis >= max(low[k], support.box[k, 0])) & (axis <= min(high[k], support.box[k, 1])))
        near = near if len(near) > 1 else np.arange(len(axis))
        return np.unique(np.rint(np.linspace(near[0], near[-1], CELLS)).astype(int))

    columns, rows = chosen(x, 0), chosen(z, 2)
    faces = [np.array([(x[i], height[k, i], z[k]) for k, i in ((a, c), (a, d), (b, d), (b, c))])
             for a, b in zip(rows[:-1], rows[1:]) for c, d in zip(columns[:-1], columns[1:])]
    return [face for face in faces if np.isfinite(face).all()]
