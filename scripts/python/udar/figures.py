"""The pictures of one run, or of several laid over each other."""
import itertools

import numpy as np
from matplotlib import collections, colors, pyplot, ticker
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .curves import BINS, drawn_nodes, prefixed, thin, with_unit
from .palette import BLACK, BLUE, ENERGY_LINES, GREEN, ORANGE, PURPLE, SELDOM, SERIES, SKY, VERMILLION
from .results import match_gauge, rest_intervals, run_labels
from .style import (DASHES, GREY, SUPPORT_GREY, legend_above, legend_columns, line_of, name_axis, say_empty,
                    set_beam_axis, set_time_axis)

MAX_DOTS = 20_000    # above this many impacts or rests the contact diagram counts them in cells
MAX_SHADES = 50      # supports whose place is marked in a picture


def mark_impacts(axis, run, node, marker, colour):
    """Marks the impacts of one mass at the height of the support it hit; says whether there are any."""
    upward = np.array([support.normal is None for support in run.supports], bool)
    hits = (np.asarray(run.impacts["node"]) == node) & upward[np.asarray(run.impacts["support"]).astype(int)]
    time, support = run.impacts["time"][hits], np.asarray(run.impacts["support"])[hits].astype(int)
    height = np.array([support.height for support in run.supports])[support] if len(time) else time
    height = height + run.lift_of(support, time)
    for number in np.unique(support):
        if run.supports[number].striker is not None:
            hit = support == number
            place = run.strikers[f"position_{run.supports[number].striker}"]
            height[hit] = np.interp(time[hit], run.strikers["time"], place)
    cell = np.rint((time - run.begin) / max(run.end - run.begin, 1e-300) * BINS)
    _, kept = np.unique(cell + 1j * height, return_index=True)
    axis.plot(time[kept], height[kept], linestyle="none", marker=marker, markersize=4.5, markerfacecolor=colour,
              markeredgecolor="white", markeredgewidth=0.4, zorder=4)
    return len(time) > 0


def draw_gauges(pen, runs, chosen):
    reference, several = runs[0], len(runs) > 1
    height = min(1.75, max(1.0, 30.0 / len(chosen)))
    figure, axes = pen.figure(9.5, 1.2 + height * len(chosen), len(chosen), sharex=True,
                              sharey=reference.along_line)
    marked = held = struck = False
    for axis, gauge in zip(axes[:, 0], chosen):
        heights = set()
        for number, run in enumerate(runs):
            own = gauge if run is reference else match_gauge(run, reference.gauge_at[gauge])
            if own is None:
                continue
            time = run.gauges["time"]
            mass_colour = SERIES[number % len(SERIES)] if several else BLUE
            line_colour = mass_colour if several else ORANGE
            axis.plot(*thin(time, run.gauges[f"line_{own}"]), color=line_colour, linewidth=0.9 if several else 1.2,
                      linestyle=(0, (1.5, 1.2)) if several else (0, (4, 1.2)), zorder=3)
            axis.plot(*thin(time, run.gauges[f"mass_{own}"]), color=mass_colour, linewidth=1.3, zorder=2.5)
            own_node = run.gauge_node[own]
            for k in run.supports_of_gauge(own):
                if run.supports[k].striker is not None:
                    struck = True
                    axis.plot(*thin(run.strikers["time"], run.strikers[f"position_{run.supports[k].striker}"]),
                              color=mass_colour if several else GREEN, linewidth=1.0, linestyle=":", zorder=2.7)
                elif run.lift is not None and np.any(run.lift[1][:, k]):
                    held = True
                    axis.plot(*thin(run.lift[0], run.supports[k].height + run.lift[1][:, k]), color=GREY, linewidth=1.0,
                              zorder=1.8)
                else:
                    heights.add(run.supports[k].height)
            marked |= mark_impacts(axis, run, own_node, "^v"[number % 2], mass_colour if several else VERMILLION)
        for level in sorted(heights):
            held = True
            axis.axhline(level, color=GREY, linewidth=1.0, linestyle="-", zorder=1.8)
        where = f"gauge {gauge}, {reference.gauge_place(gauge)}"
        under = [reference.supports[k] for k in reference.supports_of_gauge(gauge)]
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
    if struck:
        handles.append(Line2D([], [], color=GREY if several else GREEN, linewidth=1.0, linestyle=":"))
        labels.append("striker")
    legend_above(axes[0, 0], handles, labels)
    set_time_axis(axes[-1, 0], runs)
    pen.write(figure, "gauges", "Positions of masses and line at the gauges", runs)


def place_of(supports):
    """What a node stands on or under, in brackets."""
    if not supports:
        return ""
    if supports[0].striker is not None:
        return " (struck)"
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


def draw_extremes(axis, run, field, colour):
    """The band between least and greatest values along x: at points curves, in cells steps."""
    x = run.x if not field.in_cells else run.x[run.cells].min(axis=1)
    order = np.argsort(x, kind="stable")
    first = np.arange(0, len(x), max(1, len(run.x) // (2 * BINS)))
    low, high = np.minimum.reduceat(field.low[order], first), np.maximum.reduceat(field.high[order], first)
    axis.use_sticky_edges = False
    shade_supports_upright(axis, run)
    if field.in_cells:
        edges = np.append(x[order][first], run.x[run.cells].max())
        axis.stairs(high, edges, baseline=low, fill=True, color=colour, alpha=0.25)
        axis.stairs(high, edges, baseline=None, color=colour)
        axis.stairs(low, edges, baseline=None, color=colour)
    else:
        axis.fill_between(x[order][first], low, high, color=colour, alpha=0.25, linewidth=0)
        axis.plot(x[order][first], high, x[order][first], low, color=colour)
    axis.axhline(0.0, color=GREY, linewidth=0.8)
    name_axis(axis.yaxis, field.label, field.unit)


def draw_envelope(pen, run):
    """Least and greatest values of all fields that have them, and what the moments stress."""
    fields = [field for field in run.envelope.values() if field.low is not None]
    stressed = "stress" in run.envelope and bool(np.isfinite(run.envelope["stress"].high).any())
    rows = len(fields) + stressed
    figure, axes = pen.figure(9.5, 2.5 + 2.0 * rows, rows, sharex=True)
    for axis, field, colour in zip(axes[:, 0], fields, itertools.cycle((BLUE, VERMILLION, ORANGE, PURPLE, SKY))):
        draw_extremes(axis, run, field, colour)
    if stressed:
        draw_stress(axes[-1, 0], run)
    set_beam_axis(axes[-1, 0], run, "x")
    labels = [field.label for field in fields]
    what = " and ".join([", ".join(labels[:-1]), labels[-1]] if len(labels) > 1 else labels)
    pen.write(figure, "envelope", f"Envelopes of {what}{', and the bending stress' if stressed else ''}", [run])


def draw_stress(axis, run):
    """Largest bending stress at the nodes, where it was largest, and the yield stress if that is not far away."""
    first = np.arange(0, len(run.x), max(1, len(run.x) // (2 * BINS)))
    stress = run.envelope["stress"].high
    used = run.envelope["utilisation"].high if "utilisation" in run.envelope else np.full_like(stress, np.nan)
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
