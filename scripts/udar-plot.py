#!/usr/bin/env python3
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
import textwrap

os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")  # a run that is still writing may be looked at

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import collections, colors, pyplot, ticker  # noqa: E402, the backend comes first
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

# Okabe and Ito's palette: told apart with any kind of colour vision.
BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)
DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.5, 1.5)))
GREY, SUPPORT_GREY = "#595959", "#9a9a9a"
BINS = 1500          # a curve keeps the least and the greatest value of so many bins: more than a figure has pixels
MAX_DOTS = 20_000    # above this many impacts or rests the contact diagram counts them in cells
MAX_GAUGES = 12      # panels that are still readable; more only when --gauges asks for them
INSTANTS = 12        # deflection curves
ROWS_BEFORE = 2      # of them, before the first contact
MAX_SHADES = 50      # supports whose place is marked in a picture
MAX_DOUBTS = 4       # warnings in a picture
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "\u00b5"), (1e-9, "n"),
            (1e-12, "p"))
LARGEST_UNITS = ("m", "s")  # neither km nor ks; and a tenth of them is not yet told in the next smaller one

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
class Contact:
    """Rows of contact.csv; forces and impulses of each support, or of all together, by row."""
    time: np.ndarray
    x_min: np.ndarray
    x_max: np.ndarray
    force: np.ndarray
    impulse: np.ndarray
    window: float     # forces are means over so long [s]; None if not known
    together: bool    # one column for all supports

    def spans(self):
        """Of each column the times, rows of (begin, end), in which it gave anything."""
        return [stretches(self.time, np.append(False, np.diff(column) != 0.0) if len(column) else np.empty(0, bool))
                for column in self.impulse.T]


@dataclasses.dataclass
class Run:
    folder: pathlib.Path
    filter_frequency: float
    options: dict    # keys without dash
    summary: dict    # summary.json; empty before the end
    elements: int
    x: np.ndarray
    gauge_node: np.ndarray
    supports: list
    gauges: dict     # columns of gauges.csv
    energy: dict     # columns of energy.csv
    impacts: dict
    rests: dict
    finished: bool
    contact: "Contact" = None
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
    def filtered(self):
        """Without filter the file has the frequency that belongs to the time step."""
        return (self.options.get("filter_frequency") != "none" and self.filter_frequency > 0.0
                and bool(np.isfinite(self.filter_frequency)))

    @property
    def filter_label(self):
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


def read_summary(path):
    """summary.json; empty while the run goes on. One that was stopped also leaves a summary."""
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
        return summary if isinstance(summary, dict) else {}
    except (OSError, ValueError):
        return {}


def read_options(file):
    text = file.attrs.get("options", "")
    text = text.decode() if isinstance(text, bytes) else str(text)
    words = [line.split(None, 1) for line in text.splitlines() if line.startswith("-")]
    return {word[0][1:]: word[1].strip() if len(word) > 1 else "" for word in words}


def read_contact(folder, file):
    """contact.csv, and with more supports than it has columns for those of results.h5; None without either."""
    path = folder / "contact.csv"
    if not path.exists():
        return None
    table = read_csv(path, ["time", "masses", "x_min", "x_max"])
    window = np.ravel(file["supports"].attrs.get("force_window", np.nan))[0] if "supports" in file else np.nan
    together = "force" in table
    names = [""] if together else [f"_{k}" for k in range(sum(name.startswith("force_") for name in table))]
    force, impulse = (np.array([table[kind + name] for name in names]).T.reshape(len(table["time"]), len(names))
                      for kind in ("force", "impulse"))
    if together and "supports/force" in file and "supports/impulse" in file:
        rows = min(len(table["time"]), len(file["supports/force"]), len(file["supports/impulse"]))
        force, impulse = file["supports/force"][:rows], file["supports/impulse"][:rows]
        table, together = {name: values[:rows] for name, values in table.items()}, False
    return Contact(table["time"], table["x_min"], table["x_max"], force, impulse,
                   float(window) if np.isfinite(window) else None, together)


def stretches(time, holds):
    """Rows (begin, end) of the times over which `holds` is true; a row tells of the time since the one before it."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]]).astype(int)))
    first, last = edges[::2], edges[1::2] - 1
    return np.column_stack([time[np.maximum(first - 1, 0)], time[last]]) if len(first) else np.empty((0, 2))


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
        where = (" below" if side > 0 else " above") if min(columns[3]) < 0 else ""
        name = f"floor{where}" if is_floor else f"support {number}{where}, x = {with_unit(position, 'm')}"
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
                                    for name in ("line_position", "mass_position"))


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
            summary = read_summary(folder / "summary.json")
            finished = bool(summary)
            run = Run(
                folder=folder,
                options=read_options(file),
                summary=summary,
                filter_frequency=float(np.ravel(file.attrs["filter_frequency"])[0]),
                elements=int(np.ravel(file.attrs["elements"])[0]),
                x=x,
                gauge_node=np.atleast_1d(file["gauge_node"][()]).astype(int),
                supports=read_supports(file, x),
                gauges={}, energy={},
                impacts=read_records(file, folder, "impacts", IMPACT_COLUMNS, finished),
                rests=read_records(file, folder, "rests", REST_COLUMNS, finished),
                finished=finished and bool(summary.get("completed", True)))
            if np.any((run.gauge_node < 0) | (run.gauge_node >= len(x))):
                raise PlotError(f"{path}: /gauge_node names a node that /x does not have")
            for table in (run.impacts, run.rests):
                if np.any((table["support"] < 0) | (table["support"] >= len(run.supports))):
                    raise PlotError(f"{path}: an impact or rest names a support that is not in /support_position")
            run.contact = read_contact(folder, file)
            if run.contact is not None and run.contact.force.shape[1] not in (1, len(run.supports)):
                raise PlotError(f"{folder}/contact.csv: forces of {run.contact.force.shape[1]} supports, "
                                f"results.h5 has {len(run.supports)}")
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


def drawn_nodes(run):
    return run.x[::max(1, len(run.x) // (2 * BINS))]


def prefixed(peak, unit):
    """Scale and name of the unit in which something up to `peak` reads well: N, kN, MN; m, mm, \u00b5m."""
    if not np.isfinite(peak) or peak <= 0.0:
        return 1.0, unit
    for scale, prefix in PREFIXES:
        if unit in LARGEST_UNITS and scale >= 1.0:
            if scale == 1.0 and peak >= 0.1 * (1.0 - 1e-9):
                return 1.0, unit
        elif peak >= scale * (1.0 - 1e-9):
            return scale, prefix + unit
    return PREFIXES[-1][0], PREFIXES[-1][1] + unit


def with_unit(value, unit, digits=4):
    scale, name = prefixed(abs(value), unit)
    return f"{value / scale:.{digits}g} {name}"


class Ticks(ticker.Formatter):
    """Numbers at ticks in a unit that is `scale` of the data's, with as many decimals as tell them apart."""

    def __init__(self, scale):
        self.scale = scale

    def __call__(self, value, pos=None):
        steps = np.diff(np.unique(self.locs)) / self.scale
        step = steps.min() if len(steps) else abs(value) / self.scale
        decimals = 0
        while decimals < 9 and abs(step * 10**decimals - round(step * 10**decimals)) > 0.01 * step * 10**decimals:
            decimals += 1
        text = f"{value / self.scale:.{decimals}f}"
        return text[1:] if text.startswith("-") and not text.strip("-0.") else text


def name_axis(axis, quantity, unit, labelled=True):
    """What an `XAxis` or `YAxis` shows; its unit is chosen when all that is drawn is known."""
    axis.udar_quantity = (quantity if labelled else None, unit)


def choose_units(figure):
    """Every axis that has a quantity is told in the unit that suits its limits."""
    for axes in figure.axes:
        if hasattr(axes.yaxis, "udar_quantity") and axes.dataLim.height == 0.0 and axes.dataLim.y0 == 0.0:
            axes.set_ylim(-1.0, 1.0)  # nothing but zeros
        for axis in (axes.xaxis, axes.yaxis):
            if hasattr(axis, "udar_quantity"):
                quantity, unit = axis.udar_quantity
                scale, name = prefixed(np.abs(axis.get_view_interval()).max(), unit)
                axis.set_major_formatter(Ticks(scale))
                if quantity:
                    axis.set_label_text(f"{quantity} [{name}]")


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
        return pyplot.subplots(rows, columns, figsize=(width, height), squeeze=False, constrained_layout=True,
                               **options)

    def write(self, figure, name, headline, runs, times=None):
        """Titles, what the runs said against themselves, saves and closes a figure; prints each file written."""
        choose_units(figure)
        width = figure.get_figwidth()
        found = {}
        for run, label in zip(runs, run_labels(runs)):
            for doubt in reversed(run.doubts):  # those at the end of a run know its result
                found.setdefault(doubt, []).append(label)
        doubts = [doubt if len(labels) == len(runs) else f"{', '.join(labels)}: {doubt}"
                  for doubt, labels in found.items()]
        if doubts:
            shown = doubts[:MAX_DOUBTS] + ([f"{len(doubts) - MAX_DOUBTS} more"] if len(doubts) > MAX_DOUBTS else [])
            text = "\n".join(textwrap.fill(f"Warning: {doubt}", int(width * 13)) for doubt in shown)
            figure.supxlabel(text, x=0.01, ha="left", fontsize=9, color=VERMILLION)
        self.save(figure, name, f"{with_title(self, headline)}\n{describe(runs, times)}")

    def save(self, figure, name, title):
        lines = [textwrap.fill(line, int(figure.get_figwidth() * 10.5)) for line in title.splitlines()]
        figure.suptitle("\n".join(lines), fontsize=12, linespacing=1.5)
        for kind in self.formats:
            path = self.output / f"{name}.{kind}"
            metadata = {"Date": None} if kind == "svg" else None
            figure.savefig(path, dpi=self.dpi, metadata=metadata)
            print(path, flush=True)
        pyplot.close(figure)


def describe(runs, times=None):
    """What the runs have in common and the times shown, as the second line of a title."""
    parts = [f"{len(runs)} runs"] if len(runs) > 1 else []
    if len(set(run.elements for run in runs)) == 1:
        parts.append(f"N = {runs[0].elements} elements")
    if len(set(run.filter_label for run in runs)) == 1:
        parts.append(runs[0].filter_label)
    begin, end = times or (min(run.begin for run in runs), max(run.end for run in runs))
    scale, unit = prefixed(max(abs(begin), abs(end)), "s")
    unfinished = "" if all(run.finished for run in runs) else " (not finished)"
    return ", ".join([*parts, f"t = {begin / scale:.4g} to {end / scale:.4g} {unit}{unfinished}"])


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


def line_of(number):
    """Colour and dash of one of several curves; colours come round after seven, then with another dash."""
    return {"color": SERIES[number % len(SERIES)], "linestyle": DASHES[number // len(SERIES) % len(DASHES)]}


def set_time_axis(axis, runs, labelled=True):
    begin, end = min(run.begin for run in runs), max(run.end for run in runs)
    axis.set_xlim(begin, end if end > begin else begin + 1.0)
    name_axis(axis.xaxis, "time", "s", labelled)


def set_beam_axis(axis, run, which="y", labelled=True):
    pad = 0.03 * np.ptp(run.x)
    getattr(axis, f"set_{which}lim")(run.x.min() - pad, run.x.max() + pad)
    name_axis(getattr(axis, f"{which}axis"), "x along the beam", "m", labelled)


def say_empty(axis, text):
    axis.text(0.5, 0.5, text, transform=axis.transAxes, ha="center", va="center", color=GREY, fontsize=13)


def legend_columns(width, labels):
    """How many columns of a legend fit into so many inches."""
    room = width * 9.5  # characters of its size
    return int(min(len(labels), max(1, room // (max(map(len, labels)) + 7)))) if labels else 1


def legend_above(axis, handles, labels):
    """A legend between the figure's title and that of the panel, in as many columns as the figure is wide."""
    columns = legend_columns(axis.figure.get_figwidth(), labels)
    axis.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=columns,
                borderaxespad=1.9 if axis.get_title("left") else 0.2, borderpad=0.0, handlelength=2.0,
                columnspacing=1.4)


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
    reference, several = runs[0], len(runs) > 1
    height = min(1.75, max(1.0, 30.0 / len(chosen)))
    figure, axes = pen.figure(9.5, 1.2 + height * len(chosen), len(chosen), sharex=True, sharey=True)
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
        for level in sorted(heights):
            held = True
            axis.axhline(level, color=GREY, linewidth=1.0, linestyle="-", zorder=1.8)
        where = f"gauge {gauge}, x = {with_unit(reference.x[node], 'm')}"
        under = [reference.supports[k] for k in reference.supports_of_node(node)]
        axis.set_title(where + place_of(under), loc="left", pad=3)
        name_axis(axis.yaxis, "y", "m")
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
    legend_above(axes[0, 0], handles, labels)
    set_time_axis(axes[-1, 0], runs)
    pen.write(figure, "gauges", "Positions of masses and line at the gauges", runs)


def place_of(supports):
    """What a node stands on or under, in brackets."""
    if not supports:
        return ""
    if len({support.side for support in supports}) > 1:
        return " (between supports below and above)"
    if supports[0].is_floor:
        return " (on the floor)"
    return " (on a support)" if supports[0].side > 0 else " (under a support)"


def draw_drift(axis, time, drift, **style):
    """|drift| in log scale; exact zeros, which a log scale cannot show, sit on the axis at 1e-17."""
    time, size = thin(time, np.abs(drift))
    axis.plot(time, np.maximum(size, 1e-17), linewidth=1.0, **style)
    axis.set_yscale("log")


def draw_energy(pen, run):
    energy = run.energy
    shown = [line for line in ENERGY_LINES if line[0] not in SELDOM or np.any(energy[line[0]])]
    figure, axes = pen.figure(9.5, 6.5, 2, sharex=True, gridspec_kw={"height_ratios": [3.2, 1]})
    upper, lower = axes[:, 0]
    for name, label, colour, dash in shown:
        upper.plot(*thin(energy["time"], energy[name]), color=colour, linestyle=dash, label=label,
                   marker="." if len(energy["time"]) == 1 else None, linewidth=1.6 if name == "total" else 1.3)
    name_axis(upper.yaxis, "energy", "J")
    legend_above(upper, *upper.get_legend_handles_labels())
    draw_drift(lower, energy["time"], energy["drift"], color=BLACK)
    lower.set_ylabel("|drift| [-]")
    if not len(energy["time"]):
        say_empty(upper, "no rows yet")
    set_time_axis(lower, [run])
    pen.write(figure, "energy", "Energy, and error of its balance", [run])


def draw_energy_of_several(pen, runs):
    shown = [line for line in ENERGY_LINES if line[0] in
             ("kinetic", "line_strain", "fictitious_springs", "load_potential", "lost_in_impacts")]
    peak = max(np.nanmax(np.abs(run.energy[name]), initial=0.0) for run in runs for name, *_ in shown)
    labels = run_labels(runs)
    columns = legend_columns(11.5, labels)
    strip = -(-len(runs) // columns) * 0.25  # a row of its own for the legend, which is wider than a panel
    figure = pyplot.figure(figsize=(11.5, 8.0 + strip), constrained_layout=True)
    grid = figure.add_gridspec(4, 2, height_ratios=[strip, 2.5, 2.5, 2.5])
    axes = np.array([[figure.add_subplot(grid[row, column]) for column in range(2)] for row in range(1, 4)])
    for axis, (name, label, *_) in zip(axes.flat, shown):
        axis.set_title(label, loc="left", pad=3)
        for number, run in enumerate(runs):
            axis.plot(*thin(run.energy["time"], run.energy[name]), **line_of(number))
        if not any(np.any(run.energy[name]) for run in runs):
            axis.set_ylim(-0.05 * peak, 1.05 * peak if peak else 1.0)
        name_axis(axis.yaxis, "energy", "J")
    drift = axes.flat[len(shown)]
    for number, run in enumerate(runs):
        draw_drift(drift, run.energy["time"], run.energy["drift"], **line_of(number))
    drift.set_title("error of the energy balance", loc="left", pad=3)
    drift.set_ylabel("|drift| [-]")
    for row, axis in zip((0, 0, 1, 1, 2, 2), axes.flat):
        set_time_axis(axis, runs, labelled=row == 2)
        axis.tick_params(labelbottom=row == 2)
    above = figure.add_subplot(grid[0, :])
    above.axis("off")
    above.legend(axes[0, 0].get_lines(), labels, loc="center", ncol=columns, borderaxespad=0.0)
    pen.write(figure, "energy", "Energy, and error of its balance", runs)


def shade_supports(axis, run):
    for support in run.supports if len(run.supports) <= MAX_SHADES else ():
        if support.high > support.low:
            axis.axhspan(support.low, support.high, color="#e4e4e4", linewidth=0, zorder=0.5)
        else:
            axis.axhline(support.position, color=SUPPORT_GREY, linewidth=0.8, zorder=0.6)


def shade_supports_upright(axis, run):
    for support in run.supports:
        if support.is_floor or len(run.supports) > MAX_SHADES:
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


def draw_spans(axis, run):
    """When each support gave an impulse, as bars at its place; of wide ones the outermost nodes in contact, as dots.

    Returns the handles of a legend.
    """
    contact, length = run.contact, np.ptp(run.x)
    spans = contact.spans() if contact is not None else []
    if not any(map(len, spans)):
        say_empty(axis, "no contact")
        return []
    handles = {}
    reach = apart(run, 0.022 * length)
    both = len({support.side for support in run.supports}) > 1
    for own, support in zip(spans, [None] if contact.together else run.supports):
        if not len(own):
            continue
        if support is None or support.high - support.low > 0.1 * length:
            seen = np.isfinite(contact.x_min)
            if support is not None:
                seen &= (contact.x_max >= support.low) & (contact.x_min <= support.high)
            step = max(1, int(seen.sum()) // BINS)
            for edge in (contact.x_min, contact.x_max):
                axis.plot(contact.time[seen][::step], edge[seen][::step], ".", color=BLUE, markersize=2.5, zorder=2)
            handles["outermost nodes in contact"] = Line2D([], [], linestyle="none", marker=".", color=BLUE)
            continue
        # A point, and an impact, would not be seen.
        low, high = support.low - reach, support.high + reach
        if both:  # two of them may share a place
            low, high = (low, support.high) if support.side > 0 else (support.low, high)
        begin, end = widened(own, 0.003 * (run.end - run.begin)).T
        colour = ORANGE if both and support.side < 0 else SKY
        bars = [[(a, low), (b, low), (b, high), (a, high)] for a, b in zip(begin, end)]
        axis.add_collection(collections.PolyCollection(bars, color=colour, linewidth=0.0, zorder=1))
        side = (", below" if support.side > 0 else ", above") if both else ""
        handles[f"in contact{side}"] = Patch(color=colour)
    for label, handle in handles.items():
        handle.set_label(label)
    return list(handles.values())


def apart(run, wanted):
    """`wanted`, or as much less as keeps what is drawn about different supports apart."""
    gaps = np.diff(np.unique([support.position for support in run.supports]))
    return min(wanted, 0.4 * gaps.min()) if len(gaps) else wanted


def widened(spans, least):
    """Rows (begin, end), each at least so long about its middle."""
    half = np.maximum(np.diff(spans), least) / 2
    return spans.mean(axis=1)[:, None] + half * [-1.0, 1.0]


def draw_contacts(pen, runs):
    sizes = [np.abs(run.impacts["impulse"]) for run in runs]
    coarse = any(len(run.impacts["time"]) > MAX_DOTS or len(run.rests["time"]) > MAX_DOTS for run in runs)
    height = 3.7 if len(runs) == 1 else min(2.6, max(1.3, 12.0 / len(runs)))
    figure, axes = pen.figure(9.5, 1.3 + height * len(runs), len(runs), sharex=True)
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
    scale, unit = 1.0, "N s"
    if len(positive):
        low, high = positive.min(), positive.max()
        wide = high > 30 * low
        scale, unit = prefixed(high, "N s")
        norm = colors.LogNorm(max(low, 1e-6 * high), high) if wide else colors.Normalize(0.0, high)
    coloured, handles = None, {}
    # Without its palest end, which is lost on white.
    warm = colors.ListedColormap(pyplot.get_cmap("inferno_r")(np.linspace(0.15, 0.95, 256)))
    for number, (axis, run) in enumerate(zip(axes[:, 0], runs)):
        shade_supports(axis, run)
        if run.supports and len(run.supports) <= MAX_SHADES:
            handles["support"] = Patch(color="#d0d0d0", label="support")
        if not len(run.impacts["time"]) and not len(run.rests["time"]):
            handles |= {handle.get_label(): handle for handle in draw_spans(axis, run)}
        elif coarse:
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
        if len(run.rests["time"]):
            handles["mass at rest"] = Patch(color=SKY, label="mass at rest")
        set_beam_axis(axis, run, labelled=len(runs) <= 4 or number == len(runs) // 2)
        count = f"{len(run.impacts['time'])} impacts"
        if run.options.get("contact_surface") == "line" or (not run.filtered and not len(run.impacts["time"])):
            count = "contact on the line" if not len(run.impacts["time"]) else f"contact on the line, {count}"
        axis.set_title(f"{run_labels(runs)[number]}: {count}" if len(runs) > 1 else count, loc="left", pad=3)
    if coloured is not None:
        label = f"impulse of the impact [{unit}]"
        if coarse:
            label = (f"impulse per cell [{unit}]\n({with_unit((end - begin) / 600, 's', 2)} by "
                     f"{with_unit(np.diff(cells[0][0])[0], 'm', 2)})")
        bar = figure.colorbar(coloured, ax=list(axes[:, 0]), label=label, pad=0.015, fraction=0.05, aspect=30)
        bar.formatter = ticker.FuncFormatter(lambda value, _: f"{value / scale:g}")
        if wide:
            bar.locator = ticker.LogLocator(subs=(1.0,) if norm.vmax > 300 * norm.vmin else (1.0, 2.0, 5.0))
            bar.ax.yaxis.set_minor_formatter(ticker.NullFormatter())
        bar.update_ticks()
    legend_above(axes[0, 0], list(handles.values()), list(handles))
    set_time_axis(axes[-1, 0], runs)
    pen.write(figure, "contacts", "Contacts: which masses hit, when, how hard", runs)


def draw_supports_side(axis, run, time, thickness):
    """Supports seen from the side, on their side of the beam: points as wedges, those with a width as blocks."""
    half = apart(run, 0.012 * np.ptp(run.x))
    for number, support in enumerate(run.supports):
        face = support.face + run.lift_of(number, time)
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
    span = (np.ptp(heights) if len(heights) else 0.0) or 0.1 * np.ptp(run.x)
    x, show_masses, count = drawn_nodes(run), len(run.x) <= 81, len(run.instants)
    # Towards the support and away from it in panels of their own: laid over each other they cannot be read.
    turn = int(np.argmin(side * np.nan_to_num(run.line_rows).mean(axis=1))) + 1 if count else 0
    halves = [(0, turn, "down to the lowest position" if side > 0 else "up to the highest position"),
              (turn, count, "back up" if side > 0 else "back down")]
    if not contacts or turn >= count:
        halves = [(0, count, "")]
    figure, axes = pen.figure(11.5 if len(halves) > 1 else 9.5, 5.4, 1, len(halves), sharey=True)
    shades = pyplot.get_cmap("viridis")(np.linspace(0.0, 0.92, max(2, count)))
    since = run.instants - origin if contacts else run.instants
    scale, unit = prefixed(np.abs(since).max() if count else 0.0, "s")
    decimals = max(0, 1 - int(np.floor(np.log10(np.diff(since).min() / scale)))) if count > 1 else 1
    for axis, (first, last, title) in zip(axes[0], halves):
        draw_supports_side(axis, run, origin, 0.09 * span)
        for row in range(first, last):
            label = f"{since[row] / scale:{'+' if contacts else ''}.{decimals}f} {unit}"
            axis.plot(x, run.line_rows[row], color=shades[row], linewidth=1.5, label=label, zorder=3)
            if show_masses:
                axis.plot(x, run.mass_rows[row], linestyle="none", marker="o", markersize=3,
                          color=shades[row], zorder=3.5)
        axis.set_title(title, loc="left", pad=3)
        set_beam_axis(axis, run, "x")
    name_axis(axes[0, 0].yaxis, "y", "m")
    if count:
        handles, labels = (sum(parts, []) for parts in zip(*(axis.get_legend_handles_labels() for axis in axes[0])))
        axes[0, -1].legend(handles, labels, loc="center left", bbox_to_anchor=(1.01, 0.5),
                           title=f"time from the first\ncontact, t = {with_unit(origin, 's')}" if contacts else "time")
    else:
        say_empty(axes[0, 0], "no field rows" if run.finished else "no field rows yet")
    headline = "Line around the first contact" if contacts else "Line"
    pen.write(figure, "deflection", headline + (", masses as dots" if show_masses else ""), [run],
              times=(run.instants[0], run.instants[-1]) if count else None)


def draw_supports_in_time(pen, figure, axis, run, values, quantity, unit):
    """What each support gave over time: curves, or with many supports a map over time and place."""
    names = [support.name for support in run.supports] if not run.contact.together else ["all supports together"]
    time = run.contact.time
    if len(names) <= len(SERIES):
        for number, name in enumerate(names):
            axis.plot(*thin(time, values[:, number]), color=SERIES[number], linestyle=DASHES[number % len(DASHES)],
                      label=name)
        name_axis(axis.yaxis, quantity, unit)
        legend_above(axis, *axis.get_legend_handles_labels())
        return
    order = np.argsort([support.position for support in run.supports], kind="stable")
    place = np.array([support.position for support in run.supports])[order]
    between = (place[1:] + place[:-1]) / 2
    edges = np.concatenate([[place[0] - (between[0] - place[0])], between, [place[-1] + (place[-1] - between[-1])]])
    width = max(1, len(time) // BINS)
    first = np.arange(0, len(time), width)
    both = [reduce.reduceat(values[:, order], first, axis=0) for reduce in (np.minimum, np.maximum)]
    shown = np.where(np.abs(both[0]) > np.abs(both[1]), *both)  # of each bin the value of largest size
    peak = np.abs(shown).max(initial=0.0)
    scale, name = prefixed(peak, unit)
    signed = shown.min(initial=0.0) < 0.0 and shown.max(initial=0.0) > 0.0
    limit = {"vmin": -peak, "vmax": peak} if signed else {"vmin": 0.0, "vmax": peak or 1.0}
    begin = np.concatenate([time[:1] - np.diff(time[:2]).sum(), time[:-1]])[first]
    shown = np.ma.masked_equal(shown if signed else np.abs(shown), 0.0)  # none is white
    filled = axis.pcolormesh(np.append(begin, time[-1]), edges, shown.T, rasterized=True,
                             cmap="RdBu_r" if signed else "viridis_r", **limit)
    bar = figure.colorbar(filled, ax=axis, label=f"{quantity} [{name}]", pad=0.015, fraction=0.05, aspect=20)
    bar.formatter = ticker.FuncFormatter(lambda value, _: f"{value / scale:g}")
    bar.update_ticks()
    set_beam_axis(axis, run)


def draw_impulses(pen, run):
    """What each support has given so far, by impacts and by forces."""
    contact = run.contact
    figure, axes = pen.figure(9.5, 4.6 if len(run.supports) <= len(SERIES) else 7.0,
                              1 if len(run.supports) <= len(SERIES) else 2)
    axis = axes[0, 0]
    if len(contact.time):
        draw_supports_in_time(pen, figure, axis, run, contact.impulse, "impulse so far", "N s")
    if not np.any(contact.impulse):
        say_empty(axis, "no contact")
    set_time_axis(axis, [run])
    if len(axes) > 1:
        lower = axes[1, 0]
        if not contact.together and len(contact.time):
            place = [support.position for support in run.supports]
            lower.bar(place, contact.impulse[-1], width=0.6 * np.ptp(run.x) / len(place), color=BLUE)
        lower.axhline(0.0, color=GREY, linewidth=0.8)
        name_axis(lower.yaxis, "impulse in all", "N s")
        set_beam_axis(lower, run, "x")
    pen.write(figure, "impulses", "Impulse each support gave to the beam, by impacts and forces (up is positive)",
              [run])


def draw_forces(pen, run):
    """Mean force of each support over the window, and when which support was in contact."""
    contact = run.contact
    figure, axes = pen.figure(9.5, 6.5, 2, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    upper, lower = axes[:, 0]
    if len(contact.time):
        draw_supports_in_time(pen, figure, upper, run, contact.force, "mean force, up", "N")
    if not np.any(contact.force):
        say_empty(upper, "no force")
    shade_supports(lower, run)
    handles = draw_spans(lower, run)
    if handles:
        legend_above(lower, handles, [handle.get_label() for handle in handles])
    set_beam_axis(lower, run)
    set_time_axis(lower, [run])
    window = f", mean over {with_unit(contact.window, 's', 3)}" if contact.window else ""
    pen.write(figure, "forces", f"Forces of the supports{window}, and where the beam was in contact", [run])


def draw_envelope(pen, run):
    """Least and greatest bending moment at the nodes and shear force in the elements, and what the moments stress."""
    stress = run.envelope.get("stress_max", np.array([np.nan]))
    stressed = bool(np.isfinite(stress).any())
    figure, axes = pen.figure(9.5, 8.5 if stressed else 6.5, 3 if stressed else 2, sharex=True)
    first = np.arange(0, len(run.x), max(1, len(run.x) // (2 * BINS)))
    for axis, name, label, unit, colour in ((axes[0, 0], "moment", "bending moment", "N m", BLUE),
                                            (axes[1, 0], "shear", "shear force", "N", VERMILLION)):
        own = first[first < len(run.envelope[f"{name}_min"])]
        low = np.minimum.reduceat(run.envelope[f"{name}_min"], own)
        high = np.maximum.reduceat(run.envelope[f"{name}_max"], own)
        axis.use_sticky_edges = False
        shade_supports_upright(axis, run)
        if name == "shear":  # constant in an element
            edges = run.x[np.append(own, len(run.x) - 1)]
            axis.stairs(high, edges, baseline=low, fill=True, color=colour, alpha=0.25)
            axis.stairs(high, edges, baseline=None, color=colour)
            axis.stairs(low, edges, baseline=None, color=colour)
        else:
            axis.fill_between(run.x[own], low, high, color=colour, alpha=0.25, linewidth=0)
            axis.plot(run.x[own], high, run.x[own], low, color=colour)
        axis.axhline(0.0, color=GREY, linewidth=0.8)
        name_axis(axis.yaxis, label, unit)
    if stressed:
        draw_stress(axes[2, 0], run, first)
    set_beam_axis(axes[-1, 0], run, "x")
    what = ", and the bending stress" if stressed else ""
    pen.write(figure, "envelope", f"Envelopes of bending moment and shear force{what}", [run])


def draw_stress(axis, run, first):
    """Largest bending stress at the nodes, where it was largest, and the yield stress if that is not far away."""
    stress = run.envelope["stress_max"]
    used = run.envelope.get("utilisation_max", np.full_like(stress, np.nan))
    shade_supports_upright(axis, run)
    axis.plot(run.x[first], np.fmax.reduceat(stress, first), color=GREEN)
    with np.errstate(invalid="ignore", divide="ignore"):
        yields = np.where(used > 0.0, stress / used, np.nan)[first]
    if np.nanmax(np.append(used, 0.0)) > 0.3:
        axis.plot(run.x[first], yields, color=BLACK, linestyle=(0, (5, 1.5)), linewidth=1.0)
    axis.set_ylim(bottom=0.0)
    worst = int(np.nanargmax(stress))
    text = f"largest {with_unit(stress[worst], 'Pa', 3)} at x = {with_unit(run.x[worst], 'm')}"
    at = run.summary.get("max_bending_stress_time")
    text += f", t = {with_unit(at, 's')}" if at is not None else ""
    if np.isfinite(used).any():
        text += f"; at most {100 * np.nanmax(used):.3g} % of the yield stress"
    axis.set_title(text, loc="left", pad=3)
    name_axis(axis.yaxis, "bending stress", "Pa")


# ------------------------------------------------------------------------------------------------ studies


STUDIED = ("impulse", "rebound_velocity", "penetration", "deflection_down", "deflection_up", "energy_centre",
           "energy_vibration", "energy_springs", "energy_lost")
AXES = {"filter_frequency": ("filter frequency wf", "rad/s"), "ts_dt": ("time step", "s"),
        "ts_rtol": ("relative tolerance", ""), "ts_atol": ("absolute tolerance", ""), "beam_elements": ("elements", ""),
        "output_interval": ("time between rows", "s")}
QUANTITIES = {"deflection_down": "deflection down", "deflection_up": "deflection up",
              "energy_centre": "energy of the centre of mass", "energy_vibration": "energy of vibration",
              "energy_springs": "energy in filter springs", "energy_lost": "energy lost"}
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


def in_words(name):
    return QUANTITIES.get(name, name.replace("_", " "))


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
    words, unit = AXES.get(key, (key.replace("_", " "), ""))
    figure, panels = study_panels(pen, study)
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
        zero = axis.dataLim.height == 0.0 and axis.dataLim.y0 == 0.0
        scale, named = prefixed(1.0 if zero else np.abs(axis.get_ylim()).max(), study["units"][name])
        axis.yaxis.set_major_formatter(Ticks(scale))
        title = f"{in_words(name)} [{named}]"
        axis.set_title("\n".join([title, *verdicts]), loc="left", pad=3, fontsize=10)
        ticks = sorted({float(run["axes"][key]) for run in study["runs"] if key in run["axes"]})
        scale, named = prefixed(ticks[-1], unit) if unit == "s" else (1.0, unit)
        axis.set_xlabel(f"{words} [{named}]" if unit else words)
        axis.set_xticks(ticks, [f"{tick / scale:g}" for tick in ticks])
        axis.minorticks_off()
    series_legend(panels)
    pen.save(figure, f"study-{key}", with_title(pen, f"Results against {words}\ndashed: extrapolated limit"))


def draw_work_precision(pen, study, cost, label):
    figure, panels = study_panels(pen, study)
    for axis, name in panels:
        empty = True
        for number, series in enumerate(study["series"]):
            points = sorted((entry[cost], entry["errors"].get(name)) for entry in study["work_precision"]
                            if entry["series"] == series["name"] and entry["errors"].get(name) and entry[cost])
            if points:
                empty = False
                joined = len(points) <= 8 and cost != "wall_seconds"  # that of a shared machine orders nothing
                axis.plot(*zip(*points), color=SERIES[number % len(SERIES)], marker=MARKERS[number % len(MARKERS)],
                          markersize=5, linestyle="-" if joined else "none", label=series["name"])
        axis.set_title(in_words(name), loc="left", pad=3, fontsize=10)
        axis.set_xlabel(label)
        axis.set_ylabel(f"error [{study['units'][name]}]")
        if empty:
            say_empty(axis, "no error")
        else:
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.xaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.xaxis.set_major_formatter("{x:g}")
            axis.xaxis.set_minor_formatter(ticker.NullFormatter())
    series_legend(panels)
    of = "each series' own limit" if study["reference"] == "own" else f"the limit of the series '{study['reference']}'"
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
               "energy, contacts. A folder of udar-study (also written: study DIR): its results against each axis, "
               "work against precision. Prints the files written, one per line. Exit code 2: a run or an option is not "
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
            if runs[0].contact is not None:
                draw_impulses(pen, runs[0])
                draw_forces(pen, runs[0])
            else:
                note(f"{runs[0].folder} has no contact.csv: no pictures of impulses and forces")
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
