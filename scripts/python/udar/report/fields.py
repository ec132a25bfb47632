"""How the structure moved, and the extremes of its fields: rows of results.h5, some of many."""
import numpy as np

from ..results import read_envelope
from ..shapes import lift_of_held, rigid_motion, without_motion
from ..tools import UserError
from .streams import row_blocks

FRAMES = 300
LINE_NODES = 400          # of a beam in an animation
MASSES = 81               # of a beam that are drawn as dots
FRAME_BYTES = 5_000_000   # of a structure in space
PIECES = 16_000           # lines of a structure in space
ENVELOPE_NODES = 1500
HEXAHEDRON = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))


def choose_frames(time, touched, most):
    """Rows of an animation: all, or up to half of them while something is touched and the others over all time."""
    if len(time) <= most:
        return np.arange(len(time))
    first, last = np.searchsorted(time, touched if touched else (time[0], time[0]))
    first, last = max(0, first - 2), min(len(time) - 1, last + 2)
    close = np.linspace(first, last, min(last - first + 1, most // 2))
    return np.unique(np.rint(np.concatenate([np.linspace(0, len(time) - 1, most - len(close)), close])).astype(int))


def rows_of(file, *names):
    """Rows that all these fields and the time have: they may differ in a run that was cut."""
    missing = [name for name in names if name not in file["fields"]]
    if missing:
        raise UserError(f"the run has no field {missing[0]}")
    return min(len(file["fields"][name]) for name in ("time", *names))


def lift_at(file, time):
    """What motion adds to the height of each support at some times; None where none moves."""
    if "supports/lift" not in file:
        return None
    lift = file["supports/lift"]
    known = file["contact"]["time"][:len(lift)]
    before = np.clip(np.searchsorted(known, time), 0, max(0, len(known) - 1))
    return np.array([lift[row] for row in before])


def gather_line(file, run, touched):
    """A beam's motion: y of line and masses over x in each frame."""
    rows = rows_of(file, "line_position", "mass_position")
    if not rows:
        return None
    time = file["fields/time"][:rows]
    frames = choose_frames(time, touched, FRAMES)
    nodes = np.unique(np.rint(np.linspace(0, len(run.x) - 1, min(len(run.x), LINE_NODES))).astype(int))
    shown = {"t": time[frames], "x": run.x[nodes],
             "line": np.array([file["fields/line_position"][row][nodes] for row in frames]),
             "of_rows": rows}
    if len(run.x) <= MASSES:
        shown["masses"] = np.array([file["fields/mass_position"][row] for row in frames])
    shown["lift"] = lift_at(file, time[frames])
    return shown


def edges_of(cells):
    """Pairs of corners that lines are drawn between, and the cell of each; none of single points."""
    corners = cells.shape[1] if cells.ndim > 1 else 1
    if corners == 1:
        return np.empty((0, 2), int), np.empty(0, int)
    pairs = HEXAHEDRON if corners == 8 else [(k, (k + 1) % corners) for k in range(corners if corners > 2 else 1)]
    edges = np.concatenate([cells[:, pair] for pair in pairs])
    return edges, np.tile(np.arange(len(cells)), len(pairs))


def member_pieces(cells, member):
    """Pairs of nodes along members with as few of their elements as can be drawn, and the cells behind each."""
    first = np.flatnonzero(np.append(True, np.diff(member) != 0))
    last = np.append(first[1:], len(member))
    every = -(-len(first) // PIECES)  # of more members than lines some are left out
    first, last = first[::every], last[::every]
    each = max(1, PIECES // len(first))
    begins = np.concatenate([np.unique(np.linspace(a, b, min(b - a, each) + 1).astype(int))[:-1]
                             for a, b in zip(first, last)])
    ends = np.append(begins[1:], len(cells))
    ends = np.minimum(ends, last[np.searchsorted(first, begins, side="right") - 1])
    return np.column_stack([cells[begins, 0], cells[ends - 1, 1]]), begins, ends, every


def largest_over(values, begins, ends):
    """Of each range of cells the value of largest size."""
    low = np.array([np.nanmin(values[0][a:b], initial=np.inf) for a, b in zip(begins, ends)])
    high = np.array([np.nanmax(values[1][a:b], initial=-np.inf) for a, b in zip(begins, ends)])
    return np.fmax(np.abs(low), np.abs(high))


def worst_of(file, run, field, cells):
    """(label, unit, largest value, its member or None, its place) of a field that has extremes."""
    size = np.abs(field.high) if field.low is None else np.fmax(np.abs(field.low), np.abs(field.high))
    at = int(np.nanargmax(size))
    place = run.place[cells[at]].reshape(-1, 3).mean(axis=0) if field.in_cells else run.place[at]
    value = field.high[at] if field.low is None or abs(field.high[at]) >= abs(field.low[at]) else field.low[at]
    return (field.label, field.unit, float(value),
            int(file["member"][at]) if field.in_cells and "member" in file else None, place)


def displacement_rows(file, run):
    """(rows, function that gives the displacement of all nodes in a row) of a structure in space."""
    fields = file["fields"]
    if "displacement_of_line" in fields:
        return rows_of(file, "displacement_of_line"), lambda row: fields["displacement_of_line"][row]

    def upward(row):
        moved = np.zeros_like(run.place)
        moved[:, 1] = fields["line_position"][row] - run.place[:, 1]
        return moved
    return rows_of(file, "line_position"), upward


def joined_points(place, displacement):
    """Points at one place as one that moves in all their directions, and the first of them at each place."""
    joined, first, which = np.unique(np.round(place, 9), axis=0, return_index=True, return_inverse=True)
    which = which.ravel()

    def moved(row):
        whole = np.zeros_like(joined)
        np.add.at(whole, which, displacement(row))
        return whole
    return joined, moved, first


def gather_space(file, run, touched):
    """A structure in space: lines between nodes, rigid motion and deformation of them in each frame."""
    cells = file["cells"][()]
    colours, worst = {}, []
    if "member" in file:
        edges, begins, ends, every = member_pieces(cells, file["member"][()])
        radius = file["member_radius"][()][begins]
    else:
        edges, owner = edges_of(cells)
        kept = np.unique(np.rint(np.linspace(0, len(edges) - 1, min(len(edges), PIECES))).astype(int))
        edges, begins, every, radius = edges[kept], owner[kept], 1, np.zeros(len(kept))
        ends = begins + 1
    for name, field in (read_envelope(file["envelope"], len(run.x), len(cells)) if "envelope" in file else {}).items():
        both = (field.high if field.low is None else field.low, field.high)
        if not field.in_cells:
            of_edge = np.abs(np.concatenate(both)).reshape(2, -1).max(axis=0)[edges].max(axis=1)
        else:
            of_edge = largest_over(both, begins, ends)
        if np.nanmax(np.abs(field.high), initial=0.0) > 0.0 and len(edges):
            worst.append(worst_of(file, run, field, cells))
        if np.nanmax(of_edge, initial=0.0) > 0.0:
            colours[name] = {"label": field.label, "unit": field.unit, "values": of_edge}
    nodes, edges = np.unique(edges, return_inverse=True) if len(edges) else (np.arange(len(run.x)), edges)
    rows, displacement = displacement_rows(file, run)
    place, mass = run.place, file["mass"][()] if "mass" in file else np.ones(len(run.x))
    if "direction" in file:  # a point for each direction
        place, displacement, first = joined_points(run.place, displacement)
        mass = mass[first]
        nodes, edges = np.arange(len(place)), np.empty((0, 2), int)
    time = file["fields/time"][:rows]
    most = int(np.clip(FRAME_BYTES / (12 * len(nodes)), 8, FRAMES))
    frames = choose_frames(time, touched, most)
    held = "held" in file and bool(np.any(file["held"][()]))
    rigid, deformation, largest = [], [], np.zeros(len(nodes))
    for row in frames:
        moved = displacement(row)
        turn, first, second = motion = lift_of_held(file, place) if held else rigid_motion(place, moved, mass)
        bent = without_motion(place[nodes], moved[nodes], motion)
        rigid.append(np.concatenate([turn.ravel(), second - first @ turn]))
        deformation.append(bent)
        largest = np.fmax(largest, np.linalg.norm(bent, axis=1))
    edges = edges.reshape(-1, 2)
    if len(frames) and len(edges):
        colours["deformation"] = {"label": "largest deformation in the frames", "unit": "m",
                                  "values": largest[edges].max(axis=1)}
    return {"t": time[frames], "place": place[nodes], "edges": edges, "radius": radius, "colours": colours,
            "rigid": np.array(rigid).reshape(-1, 12), "deformation": np.array(deformation).reshape(len(frames), -1),
            "of_rows": rows, "every": every, "worst": worst,
            "lift": lift_at(file, time[frames])}


def gather_envelope(file, run):
    """Of each field that has extremes the least and the greatest along a beam; besides of the line's position."""
    found = []
    cells = file["cells"][()].reshape(-1, 2)
    if "envelope" in file:
        for name, field in read_envelope(file["envelope"], len(run.x), len(cells)).items():
            if not np.isfinite(field.high).any():
                continue
            x = run.x if not field.in_cells else run.x[cells].mean(axis=1)
            found.append({"name": name, "label": field.label, "unit": field.unit,
                          **thin_extremes(x, field.low, field.high)})
    rows = rows_of(file, "line_position") if "line_position" in file["fields"] else 0
    if rows:
        low, high = np.full(len(run.x), np.inf), np.full(len(run.x), -np.inf)
        for _, values in row_blocks(file["fields/line_position"], rows):
            np.fmin(low, values.min(axis=0), out=low)
            np.fmax(high, values.max(axis=0), out=high)
        found.append({"name": "position", "label": "height of the line, in the rows of fields", "unit": "m",
                      **thin_extremes(run.x, low, high)})
    return found


def thin_extremes(x, low, high):
    """Of so many neighbours the least and the greatest, and where the greatest size of all is."""
    size = np.abs(high) if low is None else np.fmax(np.abs(low), np.abs(high))
    worst = int(np.nanargmax(size))
    first = np.arange(0, len(x), -(-len(x) // ENVELOPE_NODES))
    values = high if low is None or abs(high[worst]) >= abs(low[worst]) else low
    return {"x": x[first], "low": None if low is None else np.fmin.reduceat(low, first),
            "high": np.fmax.reduceat(high, first), "worst": float(values[worst]), "worst_x": float(x[worst])}
