"""Curves no denser than a screen, and units that suit them."""
import numpy as np

BINS = 1500          # a curve keeps the least and the greatest value of so many bins: more than a figure has pixels
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "\u00b5"), (1e-9, "n"),
            (1e-12, "p"))
LARGEST_UNITS = ("m", "s")  # neither km nor ks; and a tenth of them is not yet told in the next smaller one


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
