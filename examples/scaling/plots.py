"""Pictures of a result, each as PNG and SVG."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

import model as cost
import report

# Okabe and Ito's palette: told apart with any kind of colour vision.
BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)


def figure():
    drawing, axes = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
    axes.grid(True, which="major", color="#dddddd", linewidth=0.8)
    axes.set_axisbelow(True)
    return drawing, axes


def finish(drawing, axes, folder, name, legend=True):
    if legend:  # above the picture: never over data
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=3, frameon=False, fontsize=9)
    for kind in ("png", "svg"):
        drawing.savefig(folder / f"{name}.{kind}", dpi=130)
    plt.close(drawing)


def of(result, series):
    order = "elements" if series == "growth" else "ranks"
    return sorted((p for p in result["points"] if p["series"] == series), key=lambda p: p[order])


def bars(axes, x, points, value, colour, label):
    """Median with the span from the least to the greatest."""
    middle = np.array([value(p, "median") for p in points])
    low = np.array([value(p, "low") for p in points])
    high = np.array([value(p, "high") for p in points])
    axes.errorbar(x, middle, yerr=[np.maximum(middle - low, 0), np.maximum(high - middle, 0)], color=colour, marker="o",
                  markersize=4, capsize=3, label=label)


def ranks_axis(axes, ranks):
    axes.set_xscale("log", base=2)
    axes.set_xticks(ranks, [str(rank) for rank in ranks])
    axes.minorticks_off()
    axes.set_xlabel("ranks")


def growth(result, model, folder, prefix):
    points = of(result, "growth")
    sizes = [p["elements"] for p in points]
    drawing, axes = figure()
    bars(axes, sizes, points, lambda p, which: 1e3 * report.per_step(p, which), BLUE, "measured, one rank")
    axes.plot(sizes, [1e3 * model.seconds(p) / p["counts"]["steps"] for p in points], color=ORANGE, linestyle="--",
              label="model")
    axes.plot(sizes, [1e3 * model.bound(p) / p["counts"]["steps"] for p in points], color=BLACK, linestyle=":",
              label="roofline: bytes / triad bandwidth")
    axes.set(xscale="log", yscale="log", xlabel="elements", ylabel="time per step [ms]")
    finish(drawing, axes, folder, prefix + "time-per-step")

    drawing, axes = figure()
    bars(axes, sizes, points, lambda p, which: p["counts"]["line_solves"] / p["seconds"]["stepping"][
        {"low": "high", "high": "low", "median": "median"}[which]], BLUE, "line solves, whole stepping")
    axes.set(xscale="log", yscale="log", xlabel="elements", ylabel="line solves per second")
    finish(drawing, axes, folder, prefix + "solves-per-second", legend=False)

    drawing, axes = figure()
    axes.plot(sizes, [p["bytes_per_element"] for p in points], color=BLUE, marker="o", markersize=4)
    axes.set(xscale="log", xlabel="elements", ylabel="memory beyond the program's own [bytes per element]")
    axes.set_ylim(bottom=0)
    finish(drawing, axes, folder, prefix + "bytes-per-element", legend=False)


def efficiencies(result, model, folder, prefix):
    for series in ("strong", "weak"):
        points = of(result, series)
        ranks = [p["ranks"] for p in points]
        first = points[0]
        factor = (lambda p: p["ranks"]) if series == "strong" else (lambda p: 1)

        def predicted(p, first=first, factor=factor):
            start = model.seconds(first) / first["counts"]["steps"]
            return start / (factor(p) * model.seconds(p) / p["counts"]["steps"])

        def measured(p, which, first=first, factor=factor):
            other = {"low": "high", "high": "low", "median": "median"}[which]
            return report.per_step(first) / (factor(p) * report.per_step(p, other))

        drawing, axes = figure()
        bars(axes, ranks, points, measured, BLUE, "measured")
        axes.plot(ranks, [predicted(p) for p in points], color=ORANGE, linestyle="--", label="model")
        cores = result["machine"]["1"]["cores_per_host"] * max(b["hosts"] for b in result["machine"].values())
        axes.plot(ranks, [min(1.0, cores / rank) for rank in ranks], color=BLACK, linestyle=":",
                  label=f"ideal on {cores} cores")
        ranks_axis(axes, ranks)
        axes.set_ylabel(f"{series} efficiency, time per step")
        axes.set_ylim(bottom=0)
        finish(drawing, axes, folder, prefix + series + "-efficiency")


def shares(result, folder, prefix):
    points = [p for series in ("growth", "strong", "weak") for p in of(result, series)]
    names = ["line_solve", "local_motion", "reduction", "contact", "output", "other"]
    drawing, axes = plt.subplots(figsize=(9.0, 5.0), layout="constrained")
    bottom = np.zeros(len(points))
    totals = np.array([sum(p["own_seconds"][name]["median"] for name in names) for p in points])
    for name, colour in zip(names, SERIES):
        share = 100 * np.array([p["own_seconds"][name]["median"] for p in points]) / totals
        axes.bar(range(len(points)), share, bottom=bottom, color=colour, label=name.replace("_", " "), width=0.8)
        bottom += share
    labels = [f"{p['series']}\n{p['elements']:.0e} / {p['ranks']}".replace("e+0", "e") for p in points]
    axes.set_xticks(range(len(points)), labels, rotation=90, fontsize=8)
    axes.set_ylabel("share of the stepping [%]")
    axes.set_xlabel("series, elements / ranks")
    axes.set_ylim(0, 100)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=6, frameon=False, fontsize=9)
    for kind in ("png", "svg"):
        drawing.savefig(folder / f"{prefix}share-of-step.{kind}", dpi=130)
    plt.close(drawing)


def extrapolation(result, model, folder, prefix):
    if model.machine.reduction_law() is None:
        return
    template = report.template_of(result)
    drawing, axes = figure()
    ranks = np.unique(np.round(np.logspace(0, 4, 60)))
    for elements, colour in zip((1e6, 1e7, 1e8, 1e9, 1e10), SERIES):
        allowed = ranks[ranks * 4 <= elements]
        seconds = [sum(model.beyond(template, elements, int(count)).values()) for count in allowed]
        axes.plot(allowed, seconds, color=colour,
                  label=f"{elements:.0e} elements".replace("e+0", "e").replace("e+", "e"))
        axes.plot(allowed, seconds[0] / allowed, color=colour, linestyle=":", linewidth=0.8)
    axes.set(xscale="log", yscale="log", xlabel="ranks (dotted: ideal)", ylabel="time per step, model [s]")
    finish(drawing, axes, folder, prefix + "extrapolation")


def draw_all(result, folder, prefix=""):
    model = cost.Model(result)
    growth(result, model, folder, prefix)
    efficiencies(result, model, folder, prefix)
    shares(result, folder, prefix)
    extrapolation(result, model, folder, prefix)


def draw_machines(results, folder):
    """Several machines in one picture each."""
    for series, name, value, label in (
            ("growth", "machines-time-per-step", lambda r, p: 1e3 * report.per_step(p), "time per step [ms]"),
            ("strong", "machines-strong", report.efficiency, "strong efficiency, time per step"),
            ("weak", "machines-weak", report.efficiency, "weak efficiency, time per step")):
        drawing, axes = figure()
        every = set()
        for result, colour in zip(results, SERIES * (len(results) // len(SERIES) + 1)):
            points = of(result, series)
            x = [p["elements" if series == "growth" else "ranks"] for p in points]
            every |= set(x)
            axes.plot(x, [value(result, p) for p in points], color=colour, marker="o", markersize=4,
                      label=result["name"])
        axes.set_ylabel(label)
        if series == "growth":
            axes.set(xscale="log", yscale="log", xlabel="elements")
        else:
            ranks_axis(axes, sorted(every))
            axes.set_ylim(bottom=0)
        finish(drawing, axes, folder, name)
