#!/usr/bin/python3
"""udar-plot: pictures of one run of udar, or of several runs laid over each other.

Reads the files described in docs/output.md and nothing else. One run gives gauges, energy, contacts, deflection,
impulses, forces and envelope in RUN/plots; several runs give gauges, energy and contacts in ./plots. A study
of udar-study gives its results against each axis, and work against precision, in DIR/plots.
"""
import argparse
import dataclasses
import json
import os
import pathlib
import sys

os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")  # a run that is still writing may be looked at

import h5py
import numpy as np

# Okabe and Ito's palette: told apart with any kind of colour vision.
BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)
GREY, SUPPORT_GREY = "#595959", "#9a9a9a"
BINS = 1500          # a curve keeps the least and the greatest value of so many bins: more than a figure has pixels
MAX_DOTS = 20_000    # above this many impacts or rests the contact diagram counts them in cells
MAX_GAUGES = 12      # panels that are still readable; more only when --gauges asks for them
INSTANTS = 12        # deflection curves
ROWS_BEFORE = 2      # of them, before the first contact

ENERGY_LINES = (
    ("kinetic", "kinetic", BLUE, "-"),
    ("line_strain", "strain of the line", VERMILLION, "-"),
    ("fictitious_springs", "fictitious springs", GREEN, "-"),
    ("load_potential", "potential of the load", ORANGE, "-"),
    ("lost_in_impacts", "lost in impacts", PURPLE, "-"),
    ("load_work", "brought in by changing loads", SKY, "-"),
    ("support_springs", "springs of the supports", GREEN, ":"),
    ("support_work", "brought in by moving supports", SKY, ":"),
    ("lost_in_dampers", "lost in dampers", PURPLE, ":"),
    ("total", "total", BLACK, "--"),
)
SELDOM = ("load_work", "support_springs", "support_work", "lost_in_dampers")  # shown where there is any
IMPACT_COLUMNS = ("time", "node", "x", "support", "impulse")
REST_COLUMNS = ("time", "node", "x", "support", "release")


class PlotError(Exception):
    """Something the user must mend; its text is the one line that is printed."""


# ------------------------------------------------------------------------------------------------ reading


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


@dataclasses.dataclass
class Run:
    folder: pathlib.Path
    filter_frequency: float
    elements: int
    x: np.ndarray
    gauge_node: np.ndarray
    supports: list
    gauges: dict     # columns of gauges.csv
    energy: dict     # columns of energy.csv
    impacts: dict
    rests: dict
    finished: bool
    contact: dict = None     # columns of contact.csv
    lift: tuple = None       # (times, what motion adds to the height of each support); None where none moves
    envelope: dict = None    # datasets of /envelope; written when a run ends
    instants: np.ndarray = None  # times of the rows below; None when not asked for
    line_rows: np.ndarray = None
    mass_rows: np.ndarray = None

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
    def filter_label(self):
        if self.filter_frequency > 0.0 and np.isfinite(self.filter_frequency):
            return f"wf = {self.filter_frequency:g} rad/s"
        return "unfiltered"

    def lift_of(self, support, time):
        """What motion has added to the height of a support, or of one of each time, at these times."""
        time, support = np.broadcast_arrays(np.asarray(time, float), support)
        lift = np.zeros(time.shape)
        for number in np.unique(support) if self.lift is not None else ():
            lift[support == number] = np.interp(time[support == number], self.lift[0], self.lift[1][:, number])
        return lift

    def first_contacts(self):
        """(time, side of the support) of the first impact and of the first rest, as far as there are any."""
        return [(float(table["time"][0]), self.supports[int(table["support"][0])].side)
                for table in (self.impacts, self.rests) if len(table["time"])]

    def supports_of_node(self, node):
        """Numbers of the supports the mass of this node can touch."""
        def touches(support):
            if support.high > support.low:
                return support.low - 1e-9 <= self.x[node] <= support.high + 1e-9
            return node == int(np.argmin(np.abs(self.x - support.position)))
        return [number for number, support in enumerate(self.supports) if touches(support)]


def read_csv(path, needed):
    """Columns of a CSV file by name. A last line without its newline is a row still being written: left out."""
    try:
        with open(path, encoding="utf-8") as file:
            header = file.readline().strip().split(",")
            body = file.read()
    except FileNotFoundError:
        raise PlotError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise PlotError(f"{path}: not a text file") from None
    missing = [name for name in needed if name not in header]
    if missing:
        raise PlotError(f"{path}: the first line has no column '{missing[0]}'")
    body = body[:body.rfind("\n") + 1]
    if "event" in header:
        body = body.replace("release", "1").replace("rest", "0")
        header[header.index("event")] = "release"
    lines = body.splitlines()
    try:
        values = np.loadtxt(lines, delimiter=",", ndmin=2, comments=None) if lines else np.empty((0, len(header)))
    except ValueError as error:
        raise PlotError(f"{path}: {first_line(error)}") from None
    if values.shape[1] != len(header):
        raise PlotError(f"{path}: {values.shape[1]} columns below {len(header)} names")
    return {name: values[:, column] for column, name in enumerate(header)}


def completed(summary):
    """Whether the run reached its end; one that was stopped also leaves a summary."""
    try:
        return bool(json.loads(summary.read_text()).get("completed", True))
    except (OSError, ValueError):
        return False


def read_records(file, folder, name, columns, finished):
    """Impacts or rests: from results.h5 once the run is finished, before that from the CSV file, which is complete."""
    csv = folder / f"{name}.csv"
    if name in file and (finished or not csv.exists()):
        records = file[name][()]
        if records.dtype.names is None or any(column not in records.dtype.names for column in columns):
            raise PlotError(f"{folder}/results.h5: /{name} lacks one of the columns {', '.join(columns)}")
        return {column: records[column] for column in columns}
    return read_csv(csv, [column if column != "release" else "event" for column in columns])


def read_supports(file, x):
    columns = [np.atleast_1d(file[f"support_{name}"][()]) for name in ("position", "width", "height", "side")]
    ground = [np.atleast_1d(file[name][()]) for name in ("ground_x", "ground_height")] if "ground_x" in file else None
    supports = []
    for number, (position, width, height, side) in enumerate(zip(*columns)):
        low, high = position - width / 2, position + width / 2
        is_floor = not np.isfinite([low, high]).all() or (low <= x[0] and high >= x[-1])
        if is_floor:
            low, high, position = x[0], x[-1], (x[0] + x[-1]) / 2
        name = "floor" if is_floor else f"support {number}, x = {position:g} m"
        outline = np.array([low, high] if high > low else [position])
        face = np.full(len(outline), height)
        if is_floor and ground and number == len(columns[0]) - 1:
            outline = np.unique(np.concatenate([outline, ground[0][(ground[0] > low) & (ground[0] < high)]]))
            face = np.interp(outline, *ground)
        supports.append(Support(name, low, high, position, height, side, is_floor, outline, face))
    return supports


def read_instants(file, run):
    """Rows of the fields around the first contact: two before it, the others over the time it lasts."""
    fields = file["fields"]
    rows = min(len(fields[name]) for name in ("time", "line_position", "mass_position"))  # may differ in a cut run
    time = fields["time"][:rows]
    contacts = run.first_contacts()
    if contacts and rows > INSTANTS:
        contact = min(contacts)[0]
        first = int(np.searchsorted(time, contact))
        begin = max(0, min(first - ROWS_BEFORE, rows - INSTANTS))
        # Masses on point supports stay in contact for about 10/wf, whatever wf.
        filtered = np.isfinite(run.filter_frequency) and run.filter_frequency > 0.0
        end = int(np.searchsorted(time, contact + 10.0 / run.filter_frequency)) if filtered else 0
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
                                    for name in ("line_position", "mass_position"))


def read_run(folder, with_fields):
    folder = pathlib.Path(folder)
    path = folder / "results.h5"
    if not folder.is_dir():
        raise PlotError(f"{folder}: no such folder")
    if not path.is_file():
        raise PlotError(f"{folder}: not a run folder of udar, it has no results.h5")
    try:
        with h5py.File(path, "r") as file:
            x = np.atleast_1d(file["x"][()])
            if len(x) < 2:
                raise PlotError(f"{path}: /x has fewer than two nodes")
            finished = (folder / "summary.json").exists()
            run = Run(
                folder=folder,
                filter_frequency=float(np.ravel(file.attrs["filter_frequency"])[0]),
                elements=int(np.ravel(file.attrs["elements"])[0]),
                x=x,
                gauge_node=np.atleast_1d(file["gauge_node"][()]).astype(int),
                supports=read_supports(file, x),
                gauges={}, energy={},
                impacts=read_records(file, folder, "impacts", IMPACT_COLUMNS, finished),
                rests=read_records(file, folder, "rests", REST_COLUMNS, finished),
                finished=finished and completed(folder / "summary.json"))
            if np.any((run.gauge_node < 0) | (run.gauge_node >= len(x))):
                raise PlotError(f"{path}: /gauge_node names a node that /x does not have")
            for table in (run.impacts, run.rests):
                if np.any((table["support"] < 0) | (table["support"] >= len(run.supports))):
                    raise PlotError(f"{path}: an impact or rest names a support that is not in /support_position")
            if "supports/lift" in file:
                lift = file["supports/lift"][()]
                run.lift = file["contact"]["time"][:len(lift)], lift
            if with_fields:
                read_instants(file, run)
                if "envelope" in file:
                    run.envelope = {name: values[()] for name, values in file["envelope"].items()}
                    if any(len(run.envelope[f"{name}_{side}"]) != len(x) - (name == "shear")
                           for name in ("moment", "shear") for side in ("min", "max")):
                        raise PlotError(f"{path}: /envelope does not have one value per node or element")
                for name, rows in (("line_position", run.line_rows), ("mass_position", run.mass_rows)):
                    if len(rows) and rows.shape[1:] != (len(drawn_nodes(run)),):
                        raise PlotError(f"{path}: /fields/{name} does not have one value per node of /x")
    except (OSError, KeyError, ValueError, TypeError, IndexError, RuntimeError) as error:
        raise PlotError(f"{path}: cannot be read: {first_line(error)}") from None
    columns = [f"{kind}_{k}" for k in range(len(run.gauge_node)) for kind in ("mass", "line")]
    if len(run.gauge_node):
        run.gauges = read_csv(folder / "gauges.csv", ["time", *columns])
    else:
        run.gauges = {"time": np.empty(0)}
    if with_fields and (folder / "contact.csv").exists():
        run.contact = read_csv(folder / "contact.csv", ["time", "masses", "x_min", "x_max"])
    run.energy = read_csv(folder / "energy.csv", ["time", "drift", *(name for name, *_ in ENERGY_LINES)])
    return run


def first_line(error):
    text = error.args[0] if isinstance(error, KeyError) and error.args else error
    return str(text).strip().splitlines()[0] if str(text).strip() else type(error).__name__


# ------------------------------------------------------------------------------------------------ thinning


def thin(time, values):
    """At most 2 BINS points of a curve: the least and the greatest of each bin, so no peak is lost."""
    width = len(time) // BINS
    if width < 3:
        return time, values
    whole = len(time) // width * width
    blocks = np.nan_to_num(values[:whole]).reshape(-1, width)
    start = np.arange(0, whole, width)
    peaks = [start + blocks.argmin(axis=1), start + blocks.argmax(axis=1)]
    kept = np.unique(np.concatenate([[0], *peaks, np.arange(whole, len(time))]))
    return time[kept], values[kept]


def thin_steps(time, values):
    """As `thin` for a curve that grows in steps: the last value of each of 2 BINS stretches of time."""
    if len(time) <= 4 * BINS:
        return time, values
    cell = np.floor((time - time[0]) / max(np.ptp(time), 1e-300) * 2 * BINS).astype(int)
    kept = np.concatenate([np.flatnonzero(np.diff(cell)), [len(time) - 1]])
    return time[kept], values[kept]


def drawn_nodes(run):
    return run.x[::max(1, len(run.x) // (2 * BINS))]


def energy_unit(peak):
    """Scale and name of the unit in which an energy up to `peak` joules reads well."""
    for scale, name in ((1e6, "MJ"), (1e3, "kJ")):
        if peak >= scale:
            return scale, name
    return 1.0, "J"


def length_unit(span):
    return (1e-3, "mm") if span < 0.1 else (1.0, "m")


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


# ------------------------------------------------------------------------------------------------ drawing


class Pen:
    """Makes the figures: holds what all of them share, writes them and keeps the list of files."""

    def __init__(self, output, formats, dpi, title):
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        self.plt = pyplot
        self.output, self.formats, self.dpi, self.title = output, formats, dpi, title
        pyplot.rcParams.update({
            "font.size": 11, "axes.titlesize": 11, "axes.labelsize": 11, "legend.fontsize": 10,
            "xtick.labelsize": 10, "ytick.labelsize": 10, "axes.grid": True, "grid.color": "#dddddd",
            "grid.linewidth": 0.6, "axes.axisbelow": True, "axes.spines.top": False, "axes.spines.right": False,
            "legend.frameon": False, "lines.linewidth": 1.3, "savefig.facecolor": "white",
            "figure.constrained_layout.w_pad": 0.09, "svg.fonttype": "none",
            "svg.hashsalt": "udar", "path.simplify": True})

    def figure(self, width, height, rows=1, columns=1, **options):
        """A figure and its axes, always as a rows-by-columns array."""
        figure, axes = self.plt.subplots(rows, columns, figsize=(width, height), squeeze=False,
                                         constrained_layout=True, **options)
        return figure, axes

    def write(self, figure, name, headline, runs, times=None):
        """Titles, saves and closes a figure; prints each file written."""
        self.save(figure, name, f"{with_title(self, headline)}\n{describe(runs, times)}")

    def save(self, figure, name, title):
        figure.suptitle(title, fontsize=12, linespacing=1.5)
        for kind in self.formats:
            path = self.output / f"{name}.{kind}"
            metadata = {"Date": None} if kind == "svg" else None
            figure.savefig(path, dpi=self.dpi, metadata=metadata)
            print(path, flush=True)
        self.plt.close(figure)


def describe(runs, times=None):
    """N, wf and the times shown, as the second line of a title."""
    def joined(values):
        return ", ".join(dict.fromkeys(values))
    elements, filters = joined(str(run.elements) for run in runs), joined(run.filter_label for run in runs)
    begin, end = times or (min(run.begin for run in runs), max(run.end for run in runs))
    unfinished = "" if all(run.finished for run in runs) else " (not finished)"
    return f"N = {elements} elements, {filters}, t = {begin:.4g} to {end:.4g} s{unfinished}"


def run_labels(runs):
    labels = [run.filter_label for run in runs]
    if len(set(run.elements for run in runs)) > 1:
        labels = [f"{label}, N = {run.elements}" for label, run in zip(labels, runs)]
    if len(set(labels)) < len(labels):
        labels = [f"{label} ({run.folder.resolve().name})" for label, run in zip(labels, runs)]
    return labels


def set_time_axis(axis, runs):
    begin, end = min(run.begin for run in runs), max(run.end for run in runs)
    axis.set_xlim(begin, end if end > begin else begin + 1.0)


def say_empty(axis, text):
    axis.text(0.5, 0.5, text, transform=axis.transAxes, ha="center", va="center", color=GREY, fontsize=13)


def legend_above(axis, handles, labels, columns):
    """A legend between the figure's title and the panel, at the right."""
    axis.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=columns,
                borderaxespad=0.1, handlelength=2.0, columnspacing=1.4)


def match_gauge(run, x):
    """Number of the gauge of `run` at x, or None: runs laid over each other may differ in mesh and gauges."""
    if not len(run.gauge_node):
        return None
    distance = np.abs(run.x[run.gauge_node] - x)
    nearest = int(np.argmin(distance))
    return nearest if distance[nearest] <= 0.51 * np.min(np.diff(np.sort(run.x))) else None


def mark_impacts(axis, run, node, marker, colour):
    """Marks the impacts of one mass at the height of the support it hit; says whether there are any."""
    hits = np.asarray(run.impacts["node"]) == node
    time, support = run.impacts["time"][hits], np.asarray(run.impacts["support"])[hits].astype(int)
    height = np.array([support.height for support in run.supports])[support] if len(time) else time
    height = height + run.lift_of(support, time)
    cell = np.rint((time - run.begin) / max(run.end - run.begin, 1e-300) * BINS)
    _, kept = np.unique(cell + 1j * height, return_index=True)
    axis.plot(time[kept], height[kept], linestyle="none", marker=marker, markersize=4.5, markerfacecolor=colour,
              markeredgecolor="white", markeredgewidth=0.4, zorder=4)
    return len(time) > 0


def draw_gauges(pen, runs, chosen):
    from matplotlib.lines import Line2D
    reference, several = runs[0], len(runs) > 1
    figure, axes = pen.figure(9.5, 1.2 + 1.75 * len(chosen), len(chosen), sharex=True, sharey=True)
    marked = held = False
    for axis, gauge in zip(axes[:, 0], chosen):
        node = reference.gauge_node[gauge]
        heights = set()
        for number, run in enumerate(runs):
            own = gauge if run is reference else match_gauge(run, reference.x[node])
            if own is None:
                continue
            time = run.gauges["time"]
            mass_colour = SERIES[number % len(SERIES)] if several else BLUE
            line_colour = mass_colour if several else ORANGE
            axis.plot(*thin(time, run.gauges[f"line_{own}"]), color=line_colour, linewidth=0.9 if several else 1.2,
                      linestyle=(0, (1.5, 1.2)) if several else (0, (4, 1.2)), zorder=3)
            axis.plot(*thin(time, run.gauges[f"mass_{own}"]), color=mass_colour, linewidth=1.3, zorder=2.5)
            own_node = run.gauge_node[own]
            for k in run.supports_of_node(own_node):
                if run.lift is not None and np.any(run.lift[1][:, k]):
                    held = True
                    axis.plot(*thin(run.lift[0], run.supports[k].height + run.lift[1][:, k]), color=GREY, linewidth=1.0,
                              zorder=1.8)
                else:
                    heights.add(run.supports[k].height)
            marked |= mark_impacts(axis, run, own_node, "^v"[number % 2], mass_colour if several else VERMILLION)
        for height in sorted(heights):
            held = True
            axis.axhline(height, color=GREY, linewidth=1.0, linestyle="-", zorder=1.8)
        where = f"gauge {gauge}, x = {reference.x[node]:g} m"
        names = [reference.supports[k] for k in reference.supports_of_node(node)]
        where += "".join(" (on the floor)" if s.is_floor else " (on a support)" for s in names[:1])
        axis.set_title(where, loc="left", pad=3)
        axis.set_ylabel("y [m]")
    if several:
        handles = [Line2D([], [], color=SERIES[k % len(SERIES)]) for k in range(len(runs))]
        labels = run_labels(runs)
        handles.append(Line2D([], [], color=GREY, linewidth=0.9, linestyle=(0, (1.5, 1.2))))
        labels.append("line")
    else:
        handles = [Line2D([], [], color=BLUE), Line2D([], [], color=ORANGE, linestyle=(0, (4, 1.2)))]
        labels = ["mass", "line"]
    if marked:
        handles.append(Line2D([], [], linestyle="none", marker="^", color=GREY if several else VERMILLION))
        labels.append("impact")
    if held:
        handles.append(Line2D([], [], color=GREY, linewidth=1.0))
        labels.append("support")
    legend_above(axes[0, 0], handles, labels, columns=min(6, len(labels)))
    axes[-1, 0].set_xlabel("time [s]")
    set_time_axis(axes[-1, 0], runs)
    pen.write(figure, "gauges", "Positions of masses and line at the gauges", runs)


def draw_drift(axis, time, drift, **style):
    """|drift| in log scale; exact zeros, which a log scale cannot show, sit on the axis at 1e-17."""
    time, size = thin(time, np.abs(drift))
    axis.plot(time, np.maximum(size, 1e-17), linewidth=1.0, **style)
    axis.set_yscale("log")


def draw_energy(pen, run):
    energy = run.energy
    shown = [line for line in ENERGY_LINES if line[0] not in SELDOM or np.any(energy[line[0]])]
    peak = max((np.nanmax(np.abs(energy[name]), initial=0.0) for name, *_ in shown), default=0.0)
    scale, unit = energy_unit(peak)
    figure, axes = pen.figure(9.5, 6.5, 2, sharex=True, gridspec_kw={"height_ratios": [3.2, 1]})
    upper, lower = axes[:, 0]
    for name, label, colour, dash in shown:
        upper.plot(*thin(energy["time"], energy[name] / scale), color=colour, linestyle=dash, label=label,
                   linewidth=1.6 if name == "total" else 1.3)
    upper.set_ylabel(f"energy [{unit}]")
    upper.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=3, borderaxespad=0.2)
    draw_drift(lower, energy["time"], energy["drift"], color=BLACK)
    lower.set_ylabel("|drift| [-]")
    lower.set_xlabel("time [s]")
    if not len(energy["time"]):
        say_empty(upper, "no rows yet")
    set_time_axis(lower, [run])
    pen.write(figure, "energy", "Energy, and error of its balance", [run])


def draw_energy_of_several(pen, runs):
    shown = [line for line in ENERGY_LINES if line[0] in
             ("kinetic", "line_strain", "fictitious_springs", "load_potential", "lost_in_impacts")]
    peak = max(np.nanmax(np.abs(run.energy[name]), initial=0.0) for run in runs for name, *_ in shown)
    scale, unit = energy_unit(peak)
    figure, axes = pen.figure(11.5, 8.0, 3, 2, sharex=True)
    for axis, (name, label, *_) in zip(axes.flat, shown):
        for number, run in enumerate(runs):
            axis.plot(*thin(run.energy["time"], run.energy[name] / scale), color=SERIES[number % len(SERIES)],
                      linestyle="-" if number % 2 == 0 else (0, (4, 1.2)))
        if not any(np.any(run.energy[name]) for run in runs):
            axis.set_ylim(-0.05 * peak / scale, 1.05 * peak / scale if peak else 1.0)
        axis.set_title(label, loc="left", pad=3)
        axis.set_ylabel(f"energy [{unit}]")
    drift = axes.flat[len(shown)]
    for number, run in enumerate(runs):
        draw_drift(drift, run.energy["time"], run.energy["drift"], color=SERIES[number % len(SERIES)])
    drift.set_title("error of the energy balance", loc="left", pad=3)
    drift.set_ylabel("|drift| [-]")
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    set_time_axis(drift, runs)
    legend_above(axes[0, 1], axes[0, 0].get_lines(), run_labels(runs), columns=min(3, len(runs)))
    pen.write(figure, "energy", "Energy, and error of its balance", runs)


def shade_supports(axis, run):
    for support in run.supports:
        if support.high > support.low:
            axis.axhspan(support.low, support.high, color="#e4e4e4", linewidth=0, zorder=0.5)
        else:
            axis.axhline(support.position, color=SUPPORT_GREY, linewidth=0.8, zorder=0.6)


def shade_supports_upright(axis, run):
    for support in run.supports:
        if support.is_floor:
            continue
        if support.high > support.low:
            axis.axvspan(support.low, support.high, color="#e4e4e4", linewidth=0, zorder=0.5)
        else:
            axis.axvline(support.position, color=SUPPORT_GREY, linewidth=0.8, zorder=0.6)


def contact_cells(run, time_edges, x_edges):
    """Sum of impulses, and whether a mass rests, in each cell of a grid (x, time)."""
    impulse, _, _ = np.histogram2d(run.impacts["x"], run.impacts["time"], bins=(x_edges, time_edges),
                                   weights=np.abs(run.impacts["impulse"]))
    x, begin, end = rest_intervals(run)
    row = np.clip(np.searchsorted(x_edges, x, side="right") - 1, 0, len(x_edges) - 2)
    change = np.zeros((len(x_edges) - 1, len(time_edges)))
    for time, sign, shift in ((begin, 1, 0), (end, -1, 1)):
        column = np.clip(np.searchsorted(time_edges, time, side="right") - 1, 0, len(time_edges) - 2) + shift
        np.add.at(change, (row, column), sign)
    return impulse, np.cumsum(change[:, :-1], axis=1) > 0


def draw_contacts(pen, runs):
    from matplotlib import colors, ticker
    from matplotlib.patches import Patch
    sizes = [np.abs(run.impacts["impulse"]) for run in runs]
    coarse = any(len(run.impacts["time"]) > MAX_DOTS or len(run.rests["time"]) > MAX_DOTS for run in runs)
    figure, axes = pen.figure(9.5, 1.3 + (3.7 if len(runs) == 1 else 2.9) * len(runs), len(runs), sharex=True)
    begin, end = min(run.begin for run in runs), max(run.end for run in runs)
    end = end if end > begin else begin + 1.0
    cells = []
    if coarse:
        time_edges = np.linspace(begin, end, 601)
        for run in runs:
            margin = 1e-9 * np.ptp(run.x)
            x_edges = np.linspace(run.x.min() - margin, run.x.max() + margin, min(len(run.x), 250) + 1)
            cells.append((x_edges, *contact_cells(run, time_edges, x_edges)))
        sizes = [impulse[impulse > 0] for _, impulse, _ in cells]
    positive = np.concatenate([size[size > 0] for size in sizes])
    norm, wide = None, False
    if len(positive):
        low, high = positive.min(), positive.max()
        wide = high > 30 * low
        norm = colors.LogNorm(max(low, 1e-6 * high), high) if wide else colors.Normalize(0.0, high)
    coloured = None
    # Without its palest end, which is lost on white.
    warm = colors.ListedColormap(pen.plt.get_cmap("inferno_r")(np.linspace(0.15, 0.95, 256)))
    for number, (axis, run) in enumerate(zip(axes[:, 0], runs)):
        shade_supports(axis, run)
        if coarse:
            x_edges, impulse, resting = cells[number]
            axis.pcolormesh(time_edges, x_edges, np.ma.masked_where(~resting, resting), rasterized=True,
                            cmap=colors.ListedColormap([SKY]), zorder=1)
            if norm:
                coloured = axis.pcolormesh(time_edges, x_edges, np.ma.masked_less_equal(impulse, 0.0), norm=norm,
                                           cmap=warm, rasterized=True, zorder=2)
        else:
            axis.hlines(*rest_intervals(run), color=SKY, linewidth=5 if len(run.x) <= 60 else 2.5, zorder=1)
            if norm:
                size = sizes[number]
                strong_last = np.argsort(size)
                coloured = axis.scatter(run.impacts["time"][strong_last], run.impacts["x"][strong_last],
                                        s=8 + 42 * size[strong_last] / norm.vmax,
                                        c=np.clip(size[strong_last], norm.vmin, None), norm=norm, cmap=warm,
                                        edgecolors="white", linewidths=0.4, zorder=2, rasterized=len(size) > 3000)
        if not len(run.impacts["time"]) and not len(run.rests["time"]):
            say_empty(axis, "no impacts")
        pad = 0.03 * np.ptp(run.x)
        axis.set_ylim(run.x.min() - pad, run.x.max() + pad)
        axis.set_ylabel("x along the beam [m]")
        count = f"{len(run.impacts['time'])} impacts"
        axis.set_title(f"{run_labels(runs)[number]}: {count}" if len(runs) > 1 else count, loc="left", pad=3)
    if coloured is not None:
        label = "impulse of the impact [N s]"
        if coarse:
            label = f"impulse per cell [N s]\n({(end - begin) / 600:.2g} s by {np.diff(cells[0][0])[0]:.2g} m)"
        bar = figure.colorbar(coloured, ax=list(axes[:, 0]), label=label, pad=0.015, fraction=0.05, aspect=30)
        if wide:
            bar.ax.yaxis.set_minor_formatter(ticker.LogFormatterSciNotation(minor_thresholds=(2.5, 0.6)))
    handles = [Patch(color="#d0d0d0", label="support")]
    if any(len(run.rests["time"]) for run in runs):
        handles.append(Patch(color=SKY, label="mass at rest"))
    legend_above(axes[0, 0], handles, [handle.get_label() for handle in handles], columns=2)
    axes[-1, 0].set_xlabel("time [s]")
    axes[-1, 0].set_xlim(begin, end)
    pen.write(figure, "contacts", "Contacts: which masses hit, when, how hard", runs)


def draw_supports_side(axis, run, time, unit, thickness):
    """Supports seen from the side, on their side of the beam: points as wedges, those with a width as blocks."""
    half = 0.012 * np.ptp(run.x)
    for number, support in enumerate(run.supports):
        face = (support.face + run.lift_of(number, time)) / unit
        top, foot = face[0], np.min(support.side * face) * support.side - support.side * thickness
        if support.high > support.low:
            outline = [*support.x, support.high, support.low], [*face, foot, foot]
        else:
            outline = [support.position, support.position + half, support.position - half], [top, foot, foot]
        axis.fill(*outline, facecolor="#d0d0d0", edgecolor=GREY, linewidth=0.8, zorder=1)


def draw_deflection(pen, run):
    contacts = run.first_contacts()
    origin, side = min(contacts, default=(0.0, 1.0))
    heights = np.concatenate([run.line_rows.ravel(), *[support.face for support in run.supports]])
    heights = heights[np.isfinite(heights)]
    span = np.ptp(heights) if len(heights) else 1.0
    unit, unit_name = length_unit(span)
    span = span / unit if span > 0 else 1.0
    x, show_masses, count = drawn_nodes(run), len(run.x) <= 81, len(run.instants)
    # Towards the support and away from it in panels of their own: laid over each other they cannot be read.
    turn = int(np.argmin(side * np.nan_to_num(run.line_rows).mean(axis=1))) + 1 if count else 0
    halves = [(0, turn, "down to the lowest position" if side > 0 else "up to the highest position"),
              (turn, count, "back up" if side > 0 else "back down")]
    if not contacts or turn >= count:
        halves = [(0, count, "")]
    figure, axes = pen.figure(11.5 if len(halves) > 1 else 9.5, 5.4, 1, len(halves), sharey=True)
    colours = pen.plt.get_cmap("viridis")(np.linspace(0.0, 0.92, max(2, count)))
    for axis, (first, last, title) in zip(axes[0], halves):
        draw_supports_side(axis, run, origin, unit, 0.09 * span)
        for row in range(first, last):
            after = run.instants[row] - origin
            label = f"{after * 1e3:+.1f} ms" if contacts else f"{run.instants[row]:.4g} s"
            axis.plot(x, run.line_rows[row] / unit, color=colours[row], linewidth=1.5, label=label, zorder=3)
            if show_masses:
                axis.plot(x, run.mass_rows[row] / unit, linestyle="none", marker="o", markersize=3,
                          color=colours[row], zorder=3.5)
        axis.set_title(title, loc="left", pad=3)
        axis.set_xlabel("x along the beam [m]")
        axis.set_xlim(run.x.min() - 0.02 * np.ptp(run.x), run.x.max() + 0.02 * np.ptp(run.x))
    axes[0, 0].set_ylabel(f"y [{unit_name}]")
    if count:
        handles, labels = (sum(parts, []) for parts in zip(*(axis.get_legend_handles_labels() for axis in axes[0])))
        axes[0, -1].legend(handles, labels, loc="center left", bbox_to_anchor=(1.01, 0.5),
                           title=f"time from the first\ncontact, t = {origin:.4g} s" if contacts else "time")
    else:
        say_empty(axes[0, 0], "no field rows yet")
    headline = "Line around the first contact" if contacts else "Line"
    pen.write(figure, "deflection", headline + (", masses as dots" if show_masses else ""), [run],
              times=(run.instants[0], run.instants[-1]) if count else None)


def draw_impulses(pen, run):
    from matplotlib import cm, colors
    time, support = run.impacts["time"], np.asarray(run.impacts["support"]).astype(int)
    count = len(run.supports)
    curves = []
    for number in range(count):
        hits = support == number
        total = np.concatenate([[0.0], np.cumsum(run.impacts["impulse"][hits])])
        curves.append((np.concatenate([[run.begin], time[hits], [run.end]]), np.append(total, total[-1])))
    peak = max(np.nanmax(np.abs(total)) for _, total in curves)
    unit, name = (1e3, "kN s") if peak >= 1e4 else (1.0, "N s")
    figure, axes = pen.figure(9.5, 4.6)
    axis = axes[0, 0]
    few = count <= len(SERIES)
    dashes = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.5, 1.5)))
    shades = pen.plt.get_cmap("viridis")
    for number, (own, total) in enumerate(curves):
        axis.step(*thin_steps(own, total / unit), where="post", linestyle=dashes[number % len(dashes)] if few else "-",
                  color=SERIES[number] if few else shades(number / (count - 1)),
                  label=f"{run.supports[number].name}\n({len(own) - 2} impacts)")
    if few:
        axis.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    else:
        figure.colorbar(cm.ScalarMappable(colors.Normalize(0, count - 1), shades), ax=axis,
                        label="number of the support", pad=0.015, fraction=0.05, aspect=30)
    if not len(time):
        say_empty(axis, "no impacts")
    axis.set_xlabel("time [s]")
    axis.set_ylabel(f"sum of impulses [{name}]")
    set_time_axis(axis, [run])
    pen.write(figure, "impulses", "Impulse each support gave to the beam in impacts (up is positive)", [run])


def draw_forces(pen, run):
    """Mean force of each support over the window, and which part of the beam was in contact."""
    contact = run.contact
    names = [name for name in contact if name.startswith("force")]
    peak = max((np.nanmax(np.abs(contact[name]), initial=0.0) for name in names), default=0.0)
    unit, unit_name = (1e3, "kN") if peak >= 1e4 else (1.0, "N")
    figure, axes = pen.figure(9.5, 6.5, 2, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    upper, lower = axes[:, 0]
    dashes = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.5, 1.5)))
    few = len(names) <= len(SERIES)
    for number, name in enumerate(names):
        label = run.supports[number].name if name != "force" else "all supports together"
        upper.plot(*thin(contact["time"], contact[name] / unit), linestyle=dashes[number % len(dashes)] if few else "-",
                   color=SERIES[number % len(SERIES)], linewidth=1.3 if few else 0.7, label=label)
    if few and names:
        legend_above(upper, *upper.get_legend_handles_labels(), columns=min(3, len(names)))
    upper.set_ylabel(f"mean force, up [{unit_name}]")
    touched = contact["masses"] > 0
    shade_supports(lower, run)
    # A row tells of the time since the row before it.
    begin = np.concatenate([contact["time"][:1], contact["time"][:-1]])[touched]
    end, low, high = (contact[name][touched] for name in ("time", "x_min", "x_max"))
    if len(end):
        pad = 0.006 * np.ptp(run.x)  # one mass alone would not be seen
        step = max(1, len(end) // (2 * BINS))
        parts = np.arange(0, len(end), step)
        low, high = np.minimum.reduceat(low, parts) - pad, np.maximum.reduceat(high, parts) + pad
        last = np.append(parts[1:], len(end)) - 1
        joined = end[last] - begin[parts] <= 1.5 * (end - begin).max() * step  # not over a time without contact
        lower.bar(begin[parts][joined], (high - low)[joined], (end[last] - begin[parts])[joined], low[joined],
                  align="edge", color=SKY, linewidth=0)
    else:
        say_empty(lower, "no contact")
    lower.set_ylim(run.x.min() - 0.03 * np.ptp(run.x), run.x.max() + 0.03 * np.ptp(run.x))
    lower.set_ylabel("contact zone, x [m]")
    lower.set_xlabel("time [s]")
    set_time_axis(lower, [run])
    pen.write(figure, "forces", "Forces of the supports, and the part of the beam in contact", [run])


def draw_envelope(pen, run):
    """Least and greatest bending moment at the nodes and shear force in the elements."""
    figure, axes = pen.figure(9.5, 6.5, 2, sharex=True)
    for axis, name, label, kilo, colour in ((axes[0, 0], "moment", "bending moment", "kN m", BLUE),
                                            (axes[1, 0], "shear", "shear force", "kN", VERMILLION)):
        first = np.arange(0, len(run.envelope[f"{name}_min"]), max(1, len(run.x) // (2 * BINS)))
        low = np.minimum.reduceat(run.envelope[f"{name}_min"], first)
        high = np.maximum.reduceat(run.envelope[f"{name}_max"], first)
        peak = np.nanmax(np.abs([low, high]))
        unit, unit_name = (1e3, kilo) if peak >= 1e4 else (1.0, kilo[1:])
        axis.use_sticky_edges = False
        shade_supports_upright(axis, run)
        if name == "shear":  # constant in an element
            edges = run.x[np.append(first, len(run.x) - 1)]
            axis.stairs(high / unit, edges, baseline=low / unit, fill=True, color=colour, alpha=0.25)
            axis.stairs(high / unit, edges, baseline=None, color=colour)
            axis.stairs(low / unit, edges, baseline=None, color=colour)
        else:
            axis.fill_between(run.x[first], low / unit, high / unit, color=colour, alpha=0.25, linewidth=0)
            axis.plot(run.x[first], high / unit, run.x[first], low / unit, color=colour)
        axis.axhline(0.0, color=GREY, linewidth=0.8)
        axis.set_ylabel(f"{label} [{unit_name}]")
    axes[1, 0].set_xlabel("x along the beam [m]")
    pen.write(figure, "envelope", "Envelopes of bending moment and shear force", [run])


# ------------------------------------------------------------------------------------------------ studies


STUDIED = ("impulse", "rebound_velocity", "penetration", "deflection_down", "deflection_up", "energy_centre",
           "energy_vibration", "energy_springs", "energy_lost")
AXIS_UNITS = {"filter_frequency": " [rad/s]", "ts_dt": " [s]"}
MARKERS = "osD^vP*"


def read_study(folder):
    path = folder / "study.json"
    try:
        study = json.loads(path.read_text(encoding="utf-8"))
        known = [run["quantities"] for run in study["runs"] if run["state"] == "finished"]
        study["shown"] = [name for name in STUDIED
                          if any(isinstance(values.get(name), (int, float)) for values in known)]
        study["units"] = {name: entry["unit"] for name, entry in study["quantities"].items()}
        study["folder"] = folder
        for series in study["series"]:
            series["name"], series["axes"], series["analysis"]
        study["work_precision"], study["reference"]
    except (OSError, ValueError) as error:
        raise PlotError(f"{path}: cannot be read: {first_line(error)}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise PlotError(f"{path}: not a study: {first_line(error)} is missing") from None
    if not study["shown"]:
        raise PlotError(f"{path}: no run of the study has finished")
    return study


def study_panels(pen, study):
    """A figure with a panel for each quantity; yields them with their names."""
    columns = min(3, len(study["shown"]))
    rows = -(-len(study["shown"]) // columns)
    figure, axes = pen.figure(4.3 * columns + 0.5, 2.9 * rows + 1.4, rows, columns)
    for axis in axes.flat[len(study["shown"]):]:
        axis.remove()
    return figure, list(zip(axes.flat, study["shown"]))


def series_legend(panels):
    """One legend for all panels, to the right of the first row; none for a single series."""
    entries = {}
    for axis, _ in panels:
        for handle, label in zip(*axis.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    if len(entries) > 1:
        panels[min(3, len(panels)) - 1][0].legend(entries.values(), entries.keys(), loc="upper left",
                                                  bbox_to_anchor=(1.01, 1.0))


def draw_study_axis(pen, study, key):
    """Each quantity against one axis, the others at their finest; what the verdict is, in the legend of the panel."""
    figure, panels = study_panels(pen, study)
    unit = AXIS_UNITS.get(key, "")
    for axis, name in panels:
        verdicts = []
        for number, series in enumerate(study["series"]):
            along = series["analysis"].get(name, {}).get("along", {}).get(key)
            if not along or not along["values"]:
                continue
            colour = SERIES[number % len(SERIES)]
            x = [float(study["runs"][run]["axes"][key]) for run in along["runs"]]
            axis.plot(x, along["values"], color=colour, marker=MARKERS[number % len(MARKERS)], markersize=5,
                      label=series["name"])
            if along["limit"] is not None:
                axis.axhline(along["limit"], color=colour, linestyle=(0, (4, 1.5)), linewidth=1.0)
            order = along["orders"][-1] if along["verdict"] == "converges" else None
            verdict = along["verdict"] if order is None else f"order {order:.2f}"
            verdicts.append(f"{series['name']}: {verdict}" if len(study["series"]) > 1 else verdict)
        axis.set_xscale("log")
        axis.set_title("\n".join([f"{name} [{study['units'][name]}]", *verdicts]), loc="left", pad=3, fontsize=10)
        axis.set_xlabel(key + unit)
        ticks = sorted({float(run["axes"][key]) for run in study["runs"] if key in run["axes"]})
        axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.minorticks_off()
    series_legend(panels)
    pen.save(figure, f"study-{key}", with_title(pen, f"Results against {key}\ndashed: extrapolated limit"))


def draw_work_precision(pen, study, cost, label):
    from matplotlib.ticker import LogLocator, NullFormatter
    figure, panels = study_panels(pen, study)
    for axis, name in panels:
        empty = True
        for number, series in enumerate(study["series"]):
            points = sorted((entry[cost], entry["errors"].get(name)) for entry in study["work_precision"]
                            if entry["series"] == series["name"] and entry["errors"].get(name) and entry[cost])
            if points:
                empty = False
                axis.plot(*zip(*points), color=SERIES[number % len(SERIES)], marker=MARKERS[number % len(MARKERS)],
                          markersize=5, linestyle="none" if len(points) > 8 else "-", label=series["name"])
        axis.set_title(name, loc="left", pad=3, fontsize=10)
        axis.set_xlabel(label)
        axis.set_ylabel(f"error [{study['units'][name]}]")
        if empty:
            say_empty(axis, "no error")
        else:
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.xaxis.set_major_formatter("{x:g}")
            axis.xaxis.set_minor_formatter(NullFormatter())
    series_legend(panels)
    of = "each series' own limit" if study["reference"] == "own" else f"the limit of {study['reference']}"
    pen.save(figure, f"study-work-{cost}", with_title(pen, f"Work and precision\nerror against {of}"))


def with_title(pen, text):
    return f"{pen.title}: {text[0].lower()}{text[1:]}" if pen.title else text


def draw_study(options, folder):
    study = read_study(folder)
    output = pathlib.Path(options.output or folder / "plots")
    output.mkdir(parents=True, exist_ok=True)
    pen = Pen(output, options.format, options.dpi, options.title)
    for key in dict.fromkeys(axis["key"] for series in study["series"] for axis in series["axes"]):
        draw_study_axis(pen, study, key)
    draw_work_precision(pen, study, "line_solves", "line solves")
    draw_work_precision(pen, study, "wall_seconds", "wall time [s]")




# ------------------------------------------------------------------------------------------------ command line


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise PlotError(message)


def number_list(text):
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of gauge numbers like 0,2,4") from None


def format_list(text):
    formats = list(dict.fromkeys(text.split(",")))
    unknown = [part for part in formats if part not in ("png", "svg")]
    if unknown:
        raise argparse.ArgumentTypeError(f"'{unknown[0]}' is neither png nor svg")
    return formats


def dpi_number(text):
    if not text.isdigit() or not 20 <= int(text) <= 1200:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 20 to 1200")
    return int(text)


def parse(arguments):
    parser = Parser(
        prog="udar-plot", description="Draws the results of one run of udar, or of several runs laid over each other.",
        epilog="One run: gauges, energy, contacts, deflection, impulses, forces, envelope. Several runs: gauges, "
               "energy, contacts. A folder of udar-study (also written: study DIR): its results against each axis, work "
               "against precision. Prints the files written, one per line. Exit code 2: a run or an option is not "
               "as it should be.")
    parser.add_argument("run", nargs="+", metavar="RUN", help="output folder of a run")
    parser.add_argument("--output", metavar="DIR",
                        help="where the pictures go (default: RUN/plots; for several runs ./plots)")
    parser.add_argument("--gauges", metavar="LIST", type=number_list,
                        help=f"numbers of the gauges to draw, like 0,2,4 (default: the first {MAX_GAUGES})")
    parser.add_argument("--format", metavar="LIST", type=format_list, default=["png", "svg"],
                        help="png, svg or png,svg (default: both)")
    parser.add_argument("--dpi", metavar="N", type=dpi_number, default=130,
                        help="resolution of the PNG files (default: 130)")
    parser.add_argument("--title", metavar="TEXT", default="", help="put before the title of every picture")
    return parser.parse_args(arguments)


def choose_gauges(run, wanted):
    available = len(run.gauge_node)
    if wanted is None:
        if available > MAX_GAUGES:
            note(f"{run.folder} has {available} gauges; the first {MAX_GAUGES} are drawn, --gauges chooses others")
        return list(range(min(available, MAX_GAUGES)))
    for gauge in wanted:
        if not 0 <= gauge < available:
            raise PlotError(f"--gauges: {run.folder} has no gauge {gauge}, it has {available} numbered from 0")
    return wanted


def note(text):
    print(f"udar-plot: note: {text}", file=sys.stderr)


def main(arguments):
    options = parse(arguments)
    if options.run[0] == "study" and len(options.run) > 1:
        del options.run[0]
    if any((pathlib.Path(folder) / "study.json").is_file() for folder in options.run):
        if len(options.run) > 1:
            raise PlotError("a study is drawn by itself, not with other folders")
        draw_study(options, pathlib.Path(options.run[0]))
        return
    several = len(options.run) > 1
    runs = [read_run(folder, with_fields=not several) for folder in options.run]
    chosen = choose_gauges(runs[0], options.gauges)
    output = pathlib.Path(options.output or ("plots" if several else runs[0].folder / "plots"))
    output.mkdir(parents=True, exist_ok=True)
    pen = Pen(output, options.format, options.dpi, options.title)
    if chosen:
        draw_gauges(pen, runs, chosen)
    else:
        note(f"{runs[0].folder} has no gauges: no picture of them")
    if several:
        draw_energy_of_several(pen, runs)
    else:
        draw_energy(pen, runs[0])
    if any(run.supports for run in runs):
        draw_contacts(pen, runs)
    else:
        note("no supports: no picture of contacts")
    if not several:
        draw_deflection(pen, runs[0])
        if runs[0].supports:
            draw_impulses(pen, runs[0])
            if runs[0].contact is not None:
                draw_forces(pen, runs[0])
            else:
                note(f"{runs[0].folder} has no contact.csv: no picture of forces")
        if runs[0].envelope is not None:
            draw_envelope(pen, runs[0])
        else:
            note(f"{runs[0].folder} has no envelopes, which are written when a run ends: no picture of them")


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (PlotError, OSError) as problem:
        print(f"udar-plot: {problem}", file=sys.stderr)
        sys.exit(2)
