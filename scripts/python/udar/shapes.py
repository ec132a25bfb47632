"""Shapes in space: what of a displacement is deformation, and how much larger it is drawn."""
import numpy as np


def rigid_motion(place, displacement, mass):
    """(turn, first, second): the whole moves best as `(place - first) @ turn + second` (Kabsch)."""
    weight = mass / mass.sum()
    there = place + displacement
    first, second = weight @ place, weight @ there
    u, _, vt = np.linalg.svd((place - first).T @ (weight[:, None] * (there - second)))
    return u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0]) @ vt, first, second


def lift_of_held(file, place):
    """As `rigid_motion`, of what is held: from where it stands in its own axes to where nothing strains it."""
    given = file["parameters"].attrs if "parameters" in file else {}
    height, slope = (float(given.get(name, 0.0)) for name in ("initial height [m]", "initial slope"))
    turn = np.eye(3)
    turn[0, 1] = slope
    middle = 0.5 * (place[:, 0].min() + place[:, 0].max())
    return turn, np.array([middle, 0.0, 0.0]), np.array([middle, height, 0.0])


def without_motion(place, displacement, motion):
    """What is left of displacements when a motion of the whole, (turn, first, second), has been taken back."""
    turn, first, second = motion
    return place + displacement - ((place - first) @ turn + second)


def round_factor(value):
    """The largest of 1, 2, 5, 10, ... that is no larger; 1 at least."""
    if not value > 1.0:
        return 1
    scale = 10.0 ** np.floor(np.log10(value))
    return int(scale * max(step for step in (1, 2, 5) if step * scale <= value * (1 + 1e-9)))
