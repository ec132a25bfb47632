"""The pictures of a study: its results against each axis, and work against precision."""
import json
import pathlib

import numpy as np
from matplotlib import ticker

from .curves import prefixed
from .style import SERIES, Pen, Ticks, say_empty, with_title
from .tools import UserError, first_line

STUDIED = ("impulse", "rebound_velocity", "penetration", "deflection_down", "deflection_up", "energy_centre",
           "energy_vibration", "energy_springs", "energy_lost")
AXES = {"filter_frequency": ("filter frequency wf", "rad/s"), "ts_dt": ("time step", "s"),
        "ts_rtol": ("relative tolerance", ""), "ts_atol": ("absolute tolerance", ""), "beam_elements": ("elements", ""),
        "modal_modes": ("modes", ""),
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
        raise UserError(f"{path}: cannot be read: {first_line(error)}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{path}: not a study: {first_line(error)} is missing") from None
    if not study["shown"]:
        raise UserError(f"{path}: no run of the study has finished")
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


def draw_study(options, folder):
    study = read_study(folder)
    output = pathlib.Path(options.output or folder / "plots")
    output.mkdir(parents=True, exist_ok=True)
    pen = Pen(output, options.format, options.dpi, options.title)
    for key in dict.fromkeys(axis["key"] for series in study["series"] for axis in series["axes"]):
        draw_study_axis(pen, study, key)
    draw_work_precision(pen, study, "line_solves", "line solves")
    draw_work_precision(pen, study, "wall_seconds", "wall time [s]")
