"""A run as its pictures need it: `Run`, from its files."""
import dataclasses
import pathlib

import numpy as np

from .curves import BINS, drawn_nodes, with_unit
from .files import ENERGIES, Contact, RunFiles, read_options, text_of
from .tools import UserError

INSTANTS = 12        # deflection curves
ROWS_BEFORE = 2      # of them, before the first contact
SHAPE = ("line_position", "mass_position")  # fields that a picture of a beam needs
IMPACT_COLUMNS = ("time", "node", "x", "support", "impulse")
REST_COLUMNS = ("time", "node", "x", "support", "release")


@dataclasses.dataclass
class Support:
    """One support; `low` to `high` is the part of the beam it can touch, one point if it has no width."""
    name: str
    low: float
    high: float
    position: float
    height: float
    side: float
    is_floor: bool
    x: np.ndarray     # outline of the contact face from left to right
    face: np.ndarray  # its height there
    normal: np.ndarray = None  # of a plane that does not look up: along it the height counts, from the origin
    box: np.ndarray = None     # rows of from and to along x, y, z that it touches [m]
    field: tuple = None        # x, z and rows of heights over them, one row for each z
    striker: int = None        # which one this is; it has no height of its own
    pair: int = None           # which pair of nodes touches here; it has no face, and its normal is not a number


@dataclasses.dataclass
class Extremes:
    """What a field reached over a run, at the points or in the cells of the line; `low` is None of a size."""
    label: str
    unit: str
    in_cells: bool
    low: np.ndarray
    high: np.ndarray


@dataclasses.dataclass
class Run:
    folder: pathlib.Path
    filter_frequency: float   # nan: modes alone move
    options: dict    # keys without dash
    summary: dict    # summary.json; empty before the end
    elements: int    # 0: imported matrices
    x: np.ndarray
    place: np.ndarray        # x, y, z of each
    gauge_node: np.ndarray
    supports: list
    gauges: dict     # columns of gauges.csv
    strikers: dict   # columns of strikers.csv; empty without
    energy: dict     # columns of energy.csv
    impacts: dict
    rests: dict
    finished: bool
    structure: str           # beam, network, or points of imported matrices
    gauge_names: list        # of junctions; empty where a gauge has a place alone
    contact: Contact = None
    lift: tuple = None       # (times, what motion adds to the height of each support); None where none moves
    cells: np.ndarray = None   # rows of /x at the corners of the line's cells
    envelope: dict = None      # Extremes of /envelope by the field's name; written when a run ends
    gauge_at: np.ndarray = None  # x, y, z of the gauges' nodes, which need not be among those above: -1 in gauge_node
    instants: np.ndarray = None  # times of the rows below; None when not asked for
    line_rows: np.ndarray = None
    mass_rows: np.ndarray = None

    def __post_init__(self):
        if self.gauge_at is None:
            self.gauge_at = self.place[self.gauge_node] if len(self.place) else np.zeros((len(self.gauge_node), 3))

    @property
    def along_line(self):
        """Points follow each other along x."""
        return self.structure == "beam"

    def gauge_place(self, gauge):
        x, y, z = (with_unit(value, "m") for value in self.gauge_at[gauge])
        return self.gauge_names[gauge] or f"x = {x}" + ("" if self.along_line else f", y = {y}, z = {z}")

    @property
    def begin(self):
        return self._extreme(min, 0)

    @property
    def end(self):
        return self._extreme(max, -1)

    def _extreme(self, choose, row):
        known = [table["time"][row] for table in (self.gauges, self.energy, self.impacts) if len(table["time"])]
        return float(choose(known)) if known else 0.0

    @property
    def by_modes(self):
        return self.options.get("ts_type") == "modal"

    @property
    def filtered(self):
        """Without filter the file has the frequency that belongs to the time step."""
        return (self.options.get("filter_frequency") != "none" and not self.by_modes and self.filter_frequency > 0.0
                and bool(np.isfinite(self.filter_frequency)))

    @property
    def filter_label(self):
        if self.by_modes:
            return "by modes"
        return f"wf = {self.filter_frequency:.4g} rad/s" if self.filtered else "unfiltered"

    @property
    def doubts(self):
        """What the run said against itself: the findings of its warnings, without the advice, and an early end."""
        found = [str(text).split("; ")[0] for text in self.summary.get("warnings", ())]
        if self.summary and not self.finished:
            found.append(f"stopped early, at t = {self.end:.4g} s")
        return found

    def lift_of(self, support, time):
        """What motion has added to the height of a support, or of one of each time, at these times."""
        time, support = np.broadcast_arrays(np.asarray(time, float), support)
        lift = np.zeros(time.shape)
        for number in np.unique(support) if self.lift is not None else ():
            lift[support == number] = np.interp(time[support == number], self.lift[0], self.lift[1][:, number])
        return lift

    def first_contacts(self):
        """(time, side of the support) of the first impact and of the first rest, as far as there are any."""
        found = [(float(table["time"][0]), self.supports[int(table["support"][0])].side)
                 for table in (self.impacts, self.rests) if len(table["time"])]
        at = self.summary.get("first_contact_time")
        if not found and at is not None:  # the line touches without impacts
            spans = self.contact.spans() if self.contact is not None else []
            first = min(((own[0][0], number) for number, own in enumerate(spans) if len(own)), default=(at, 0))
            found = [(float(at), self.supports[min(first[1], len(self.supports) - 1)].side)]
        return found

    def supports_of_gauge(self, gauge):
        """Numbers of the supports the mass of its node can touch."""
        x = self.gauge_at[gauge, 0]

        def touches(support):
            if support.normal is not None:
                return False  # heights are not along y
            if support.high > support.low:
                return support.low - 1e-9 <= x <= support.high + 1e-9
            return x == self.x[np.argmin(np.abs(self.x - support.position))]
        return [number for number, support in enumerate(self.supports) if touches(support)]


def read_gauge_names(options, gauges):
    """Those at junctions come last."""
    names = [name.strip() for name in options.get("gauge_junction", "").split(",") if name.strip()]
    return ([""] * gauges + names)[-gauges:] if gauges else []


def read_box(file, number, low, high):
    """What a support touches; one without width what it finds."""
    box = np.array([[low, high] if high > low else [-np.inf, np.inf], [-np.inf, np.inf], [-np.inf, np.inf]])
    for row, axis in ((1, "y"), (2, "z")):
        if f"support_{axis}_from" in file:
            box[row] = file[f"support_{axis}_from"][number], file[f"support_{axis}_to"][number]
    return box


def read_supports(file, x):
    columns = [np.atleast_1d(file[f"support_{name}"][()]) for name in ("position", "width", "height", "side")]
    strikers = np.atleast_1d(file["support_striker"][()]) if "support_striker" in file else np.full(len(columns[0]), -1)
    pairs = np.atleast_1d(file["support_pair"][()]) if "support_pair" in file else np.full(len(columns[0]), -1)
    ground = [np.atleast_1d(file[name][()]) for name in ("ground_x", "ground_height")] if "ground_x" in file else None
    supports = []
    normals = (np.column_stack([file[f"support_normal_{axis}"][()] for axis in "xyz"])
               if "support_normal_x" in file else np.tile([0.0, 1.0, 0.0], (len(columns[0]), 1)))
    for number, (position, width, height, side) in enumerate(zip(*columns)):
        low, high = position - width / 2, position + width / 2
        box = read_box(file, number, low, high)
        is_wide = not np.isfinite([low, high]).all() or (low <= x.min() and high >= x.max())
        is_floor = is_wide and normals[number, 1] == 1.0
        if is_wide:
            low, high, position = x.min(), x.max(), (x.min() + x.max()) / 2
        if pairs[number] >= 0:
            pair = int(pairs[number])
            supports.append(Support(f"pair {pair} of nodes", low, high, position, height, side, False,
                                    np.array([position]), np.full(1, height), np.full(3, np.nan), box, pair=pair))
            continue
        if f"height_field_{number}_x" in file:
            grid = [file[f"height_field_{number}_{part}"][()] for part in ("x", "z", "height")]
            supports.append(Support(f"support {number}, height field", low, high, position, height, side, False,
                                    np.array([low, high]), np.full(2, height), normals[number], box,
                                    (grid[0], grid[1], grid[2].reshape(len(grid[1]), len(grid[0])))))
            continue
        if normals[number, 1] != 1.0:
            supports.append(Support(f"support {number}, plane", low, high, position, height, side, False,
                                    np.array([low, high]), np.full(2, height), normals[number], box))
            continue
        if strikers[number] >= 0:
            striker = int(strikers[number])
            supports.append(Support(f"striker {striker}, x = {with_unit(position, 'm')}", low, high, position, height,
                                    side, False, np.array([position]), np.full(1, height), box=box, striker=striker))
            continue
        where = (" below" if side > 0 else " above") if min(columns[3]) < 0 else ""
        name = f"floor{where}" if is_floor else f"support {number}{where}, x = {with_unit(position, 'm')}"
        outline = np.array([low, high] if high > low else [position])
        face = np.full(len(outline), height)
        if is_floor and ground and number == len(columns[0]) - 1:
            outline = np.unique(np.concatenate([outline, ground[0][(ground[0] > low) & (ground[0] < high)]]))
            face = np.interp(outline, *ground)
        supports.append(Support(name, low, high, position, height, side, is_floor, outline, face, box=box))
    return supports


def read_envelope(group, points, cells):
    """All fields that have extremes: pairs of x_min and x_max, or x_max alone."""
    envelope = {}
    for name in (name.removesuffix("_max") for name in group if name.endswith("_max")):
        high = group[f"{name}_max"]
        low = group[f"{name}_min"] if f"{name}_min" in group else None
        in_cells = text_of(high, "where", "points") == "cells"
        envelope[name] = Extremes(text_of(high, "label", name), text_of(high, "units", "1"), in_cells,
                                  None if low is None else low[()], high[()])
        if any(len(values) != (cells if in_cells else points)
               for values in (envelope[name].low, envelope[name].high) if values is not None):
            raise UserError(f"{group.file.filename}: /envelope does not have one value per point or cell")
    return envelope


def read_instants(file, run):
    """Rows of the fields around the first contact: two before it, the others over the time it lasts."""
    fields = file["fields"]
    rows = min(len(fields[name]) for name in ("time", *SHAPE))  # may differ in a cut run
    time = fields["time"][:rows]
    contacts = run.first_contacts()
    if contacts and rows > INSTANTS:
        contact = min(contacts)[0]
        first = int(np.searchsorted(time, contact))
        begin = max(0, min(first - ROWS_BEFORE, rows - INSTANTS))
        end = int(np.searchsorted(time, end_of_contact(run, contact)))
        end = min(max(end, begin + INSTANTS - 1), rows - 1)
        first = min(first, begin + ROWS_BEFORE)
        after = np.linspace(first, end, INSTANTS - ROWS_BEFORE)
        step = max(1, round(after[1] - after[0]) // 2)
        before = [max(0, first - (k + 1) * step) for k in range(ROWS_BEFORE)]
        chosen = np.unique(np.concatenate([before, np.rint(after)]).astype(int))
    else:
        chosen = np.unique(np.rint(np.linspace(0, rows - 1, min(rows, INSTANTS))).astype(int))
    run.instants = time[chosen]
    every = max(1, len(run.x) // (2 * BINS))
    run.line_rows, run.mass_rows = (np.array([fields[name][row][::every] for row in chosen])
                                    for name in SHAPE)


def end_of_contact(run, begin):
    """When the first contact ends: touches follow each other in less time than it lasts so far, or 10 / wf.

    Masses on point supports hop for about so long, whatever wf.
    """
    pause = 10.0 / run.filter_frequency if run.filtered else 0.0
    spans = sorted(map(tuple, np.concatenate(run.contact.spans()))) if run.contact is not None else []
    end = begin if spans else begin + pause
    for first, last in spans:
        if first > end + max(pause, end - begin):
            break
        end = max(end, last)
    rests = spans and end >= run.contact.time[-1]  # the fall is then what there is to see
    return begin + pause if rests else end


def read_run(folder, with_fields, with_tables=True):
    """`with_tables` off: what does not grow with the length of the run; tables stay empty."""
    files = RunFiles(folder)
    with files.results() as file:
        run = read_motion(files, file, with_tables)
        if not with_tables:
            return run
        if with_fields and run.along_line:
            read_line(files, file, run)
    columns = [f"{kind}_{k}" for k in range(len(run.gauge_node)) for kind in ("mass", "line")]
    run.gauges = files.table("gauges", ["time", *columns]) if len(run.gauge_node) else {"time": np.empty(0)}
    struck = sum(support.striker is not None for support in run.supports)
    run.strikers = files.table("strikers", ["time", *(f"position_{k}" for k in range(struck))]) if struck else {}
    run.energy = files.table("energy", ["time", "drift", *ENERGIES])
    return run


def read_motion(files, file, with_tables):
    """What results.h5 and contact.csv have of a run, but for its fields."""
    x = np.atleast_1d(file["x"][()])
    if len(x) < 2:
        raise UserError(f"{files.path}: /x has fewer than two nodes")
    options = read_options(file)
    by_modes = options.get("ts_type") == "modal" and "filter_frequency" not in file.attrs
    gauge_node = np.atleast_1d(file["gauge_node"][()]).astype(int)
    run = Run(
        folder=files.folder,
        options=options,
        summary=files.summary,
        filter_frequency=np.nan if by_modes else float(np.ravel(file.attrs["filter_frequency"])[0]),
        elements=int(np.ravel(file.attrs["elements"])[0]),
        x=x,
        place=np.column_stack([x, *(file[axis][()] if axis in file else np.zeros(len(x)) for axis in "yz")]),
        gauge_node=gauge_node,
        gauge_at=np.zeros((len(gauge_node), 3)),
        supports=read_supports(file, x),
        gauges={}, strikers={}, energy={},
        impacts=files.impacts(file, IMPACT_COLUMNS) if with_tables else {},
        rests=files.records(file, "rests", REST_COLUMNS) if with_tables else {},
        finished=files.finished,
        structure=text_of(file, "structure", "beam"),
        gauge_names=read_gauge_names(options, len(gauge_node)),
        contact=files.contact(file) if with_tables else None)
    number_by_rows(files, file, run)
    if not with_tables:
        return run
    if run.contact is not None and run.contact.force.shape[1] not in (1, len(run.supports)):
        raise UserError(f"{files.folder}/contact.csv: forces of {run.contact.force.shape[1]} supports, "
                        f"results.h5 has {len(run.supports)}")
    if "supports/lift" in file:
        lift = file["supports/lift"][()]
        run.lift = file["contact"]["time"][:len(lift)], lift
    return run


def number_by_rows(files, file, run):
    """Nodes of gauges, impacts and rests by their row in the file, in place of the user's number."""
    numbers = file["node"][()] if "node" in file else np.arange(len(run.x))
    known = np.isin(run.gauge_node, numbers)
    if not known.all() and "gauge_place" not in file:
        raise UserError(f"{files.path}: /gauge_node names a node that /x does not have")
    run.gauge_node = np.where(known, np.searchsorted(numbers, run.gauge_node), -1)
    run.gauge_at = file["gauge_place"][()].reshape(-1, 3) if "gauge_place" in file else run.place[run.gauge_node]
    for table in filter(None, (run.impacts, run.rests)):  # a stride leaves nodes out
        table["node"] = np.maximum(np.searchsorted(numbers, table["node"], side="right") - 1, 0)
        if np.any((table["support"] < 0) | (table["support"] >= len(run.supports))):
            raise UserError(f"{files.path}: an impact or rest names a support that is not in /support_position")


def read_line(files, file, run):
    """Instants and envelopes of a beam."""
    if all(name in file["fields"] for name in SHAPE):
        read_instants(file, run)
    run.cells = file["cells"][()].reshape(len(file["cells"]), -1)
    if "envelope" in file:
        run.envelope = read_envelope(file["envelope"], len(run.x), len(run.cells))
    for name, rows in zip(SHAPE, (run.line_rows, run.mass_rows)):
        if rows is not None and len(rows) and rows.shape[1:] != (len(drawn_nodes(run)),):
            raise UserError(f"{files.path}: /fields/{name} does not have one value per node of /x")


def rest_intervals(run):
    """Arrays x, begin, end, one entry for each time a mass rested; still resting at the end: until the end."""
    rests = run.rests
    order = np.lexsort((rests["release"], rests["time"], rests["node"]))
    node, time = np.asarray(rests["node"])[order], np.asarray(rests["time"])[order]
    x, release = np.asarray(rests["x"])[order], np.asarray(rests["release"])[order] > 0
    if not len(node):
        return np.empty(0), np.empty(0), np.empty(0)
    same_next = np.append(node[1:] == node[:-1], False)
    closed = same_next & np.append(release[1:], False)
    end = np.where(closed, np.append(time[1:], 0.0), run.end)
    begins = ~release
    # A release without a rest before it: the mass was resting when this run took over from a restart file.
    orphan = release & ~np.append(False, closed[:-1] & ~release[:-1])
    return (np.concatenate([x[begins], x[orphan]]),
            np.concatenate([time[begins], np.full(orphan.sum(), run.begin)]),
            np.concatenate([end[begins], time[orphan]]))


def match_gauge(run, place):
    """Number of the gauge of `run` at a place, or None: runs laid over each other may differ in mesh and gauges."""
    if not len(run.gauge_node):
        return None
    distance = np.linalg.norm(run.gauge_at - place, axis=1)
    nearest = int(np.argmin(distance))
    near = 0.51 * np.min(np.diff(np.unique(run.x))) if run.along_line else 0.01 * np.ptp(run.place, axis=0).max()
    return nearest if distance[nearest] <= near else None


def run_labels(runs):
    """What tells the runs apart: filter frequency, mesh and, where that is not enough, the name of the folder."""
    parts = [[] for _ in runs]
    for words in ([run.filter_label for run in runs], [f"N = {run.elements}" for run in runs]):
        if len(set(words)) > 1:
            for part, word in zip(parts, words):
                part.append(word)
    if len(set(map(tuple, parts))) < len(parts):
        parts = [[run.folder.resolve().name, *part] for run, part in zip(runs, parts)]
    return [", ".join(part) for part in parts]
