"""What all pictures have in common: colours, units of axes, curves no denser than a screen, labels, legends."""
import textwrap

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot, ticker  # noqa: E402, the backend comes first

from .curves import prefixed  # noqa: E402
from .palette import SERIES, VERMILLION  # noqa: E402
from .results import run_labels  # noqa: E402

DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1.5, 1.5)))
GREY, SUPPORT_GREY = "#595959", "#9a9a9a"
MAX_DOUBTS = 4       # warnings in a picture


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


def with_title(pen, text):
    return f"{pen.title}: {text[0].lower()}{text[1:]}" if pen.title else text


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
    if runs[0].elements and len(set(run.elements for run in runs)) == 1:
        parts.append(f"N = {runs[0].elements} elements")
    if len(set(run.filter_label for run in runs)) == 1:
        parts.append(runs[0].filter_label)
    begin, end = times or (min(run.begin for run in runs), max(run.end for run in runs))
    scale, unit = prefixed(max(abs(begin), abs(end)), "s")
    unfinished = "" if all(run.finished for run in runs) else " (not finished)"
    return ", ".join([*parts, f"t = {begin / scale:.4g} to {end / scale:.4g} {unit}{unfinished}"])


def line_of(number):
    """Colour and dash of one of several curves; colours come round after seven, then with another dash."""
    return {"color": SERIES[number % len(SERIES)], "linestyle": DASHES[number // len(SERIES) % len(DASHES)]}


def set_time_axis(axis, runs, labelled=True):
    begin, end = min(run.begin for run in runs), max(run.end for run in runs)
    axis.set_xlim(begin, end if end > begin else begin + 1.0)
    name_axis(axis.xaxis, "time", "s", labelled)


def set_beam_axis(axis, run, which="y", labelled=True):
    pad = 0.03 * np.ptp(run.x) or 1.0  # upright
    getattr(axis, f"set_{which}lim")(run.x.min() - pad, run.x.max() + pad)
    name_axis(getattr(axis, f"{which}axis"), "x along the beam" if run.along_line else "x", "m", labelled)


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
