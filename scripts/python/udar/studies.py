"""The pictures of a study: its results against each axis, and work against precision; of a design study what its
quantities follow, and which runs nothing else beats in two of them."""
import json
import pathlib

import numpy as np
from matplotlib import ticker

from .curves import prefixed
from .palette import SERIES
from .style import GREY, SUPPORT_GREY, Pen, Ticks, choose_units, name_axis, say_empty, with_title
from .tools import UserError, first_line

DESIGNED = ("peak_force", "max_moment", "max_stress", "utilisation", "sag", "penetration", "rebound_velocity",
            "impulse", "energy_lost")
STUDIED = ("impulse", "rebound_velocity", "penetration", "deflection_down", "deflection_up", "energy_centre",
           "energy_vibration", "energy_springs", "energy_lost")
AXES = {"filter_frequency": ("filter frequency wf", "rad/s"), "ts_dt": ("time step", "s"),
        "ts_rtol": ("relative tolerance", ""), "ts_atol": ("absolute tolerance", ""), "beam_elements": ("elements", ""),
        "modal_modes": ("modes", ""),
        "output_interval": ("time between rows", "s")}
QUANTITIES = {"peak_force": "largest force of a support", "max_moment": "largest moment",
              "max_stress": "largest bending stress", "sag": "largest deflection",
              "deflection_down": "deflection down", "deflection_up": "deflection up",
              "energy_centre": "energy of the centre of mass", "energy_vibration": "energy of vibration",
              "energy_springs": "energy in filter springs", "energy_lost": "energy lost"}
MARKERS = "osD^vP*"


def read_study(folder):
    path = folder / "study.json"
    try:
        study = json.loads(path.read_text(encoding="utf-8"))
        known = [run["quantities"] for run in study["runs"] if run["state"] == "finished"]
        study["shown"] = [name for name in (DESIGNED if "design" in study else STUDIED)
                          if any(isinstance(values.get(name), (int, float)) for values in known)]
        study["units"] = {name: entry["unit"] for name, entry in study["quantities"].items()}
        study["folder"] = folder
        if "design" not in study:
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


def draw_tornado(pen, study):
    """For each quantity a bar for each variable, the one it follows most on top."""
    figure, panels = study_panels(pen, study)
    for axis, name in panels:
        axis.axvline(0.0, color=GREY, linewidth=0.8)
        labels = []
        for number, design in enumerate(study["design"]):
            follows = design["spread"][name].get("rank_correlation", {})
            known = sorted(((value, key) for key, value in follows.items() if value is not None),
                           key=lambda one: abs(one[0]))
            for value, key in known:
                axis.barh(len(labels), value, color=SERIES[number % len(SERIES)], height=0.6)
                labels.append(key if len(study["design"]) == 1 else f"{key} ({design['series']})")
        axis.set_yticks(range(len(labels)), labels)
        axis.set_xlim(-1.05, 1.05)
        axis.set_title(in_words(name), loc="left", pad=3, fontsize=10)
        axis.set_xlabel("rank correlation")
        if not labels:
            say_empty(axis, "does not vary")
    pen.save(figure, "study-tornado", with_title(pen, "What results follow\nSpearman's rank correlation with each "
                                                      "variable over all finished runs"))


def unbeaten(points):
    """Which of (a, b) no other is below in one and not above in the other."""
    order = sorted(range(len(points)), key=lambda i: points[i])
    front, least = [], np.inf
    for i in order:
        if points[i][1] < least:
            front.append(i)
            least = points[i][1]
    return front


def draw_pareto(pen, study, names):
    first, second = names
    runs = [run for run in study["runs"] if run["state"] == "finished"
            and all(isinstance(run["quantities"].get(name), (int, float)) for name in names)]
    points = [(abs(run["quantities"][first]), abs(run["quantities"][second])) for run in runs]
    figure, axes = pen.figure(8.0, 6.0)
    axis = axes.flat[0]
    axis.scatter(*zip(*points), s=14, color=SUPPORT_GREY, label=f"{len(points)} finished runs")
    front = unbeaten(points)
    axis.plot(*zip(*(points[i] for i in front)), color=SERIES[0], marker="o", markersize=5, drawstyle="steps-post",
              label="no other run is smaller in both")
    for i in front[::max(1, len(front) // 12)]:
        axis.annotate(f"run {runs[i]['number']}", points[i], xytext=(5, 5), textcoords="offset points", fontsize=9)
    name_axis(axis.xaxis, in_words(first), study["units"][first])
    name_axis(axis.yaxis, in_words(second), study["units"][second])
    axis.legend(loc="best")
    choose_units(figure)
    pen.save(figure, "study-pareto", with_title(pen, f"{in_words(first).capitalize()} and {in_words(second)}"))


def draw_design(options, pen, study):
    draw_tornado(pen, study)
    varied = [name for name in study["shown"] if len({run["quantities"].get(name) for run in study["runs"]
                                                      if run["state"] == "finished"}) > 1]
    names = options.objectives or [name for name in varied if name in ("peak_force", "max_stress", "sag")][:2]
    unknown = [name for name in names if name not in study["units"]]
    if unknown:
        raise UserError(f"--objectives: there is no quantity {unknown[0]}, expected two of "
                        f"{', '.join(study['units'])}")
    if len(names) == 2:
        draw_pareto(pen, study, names)


def draw_study(options, folder):
    study = read_study(folder)
    output = pathlib.Path(options.output or folder / "plots")
    output.mkdir(parents=True, exist_ok=True)
    pen = Pen(output, options.format, options.dpi, options.title)
    if "design" in study:
        draw_design(options, pen, study)
        return
    for key in dict.fromkeys(axis["key"] for series in study["series"] for axis in series["axes"]):
        draw_study_axis(pen, study, key)
    draw_work_precision(pen, study, "line_solves", "line solves")
    draw_work_precision(pen, study, "wall_seconds", "wall time [s]")
