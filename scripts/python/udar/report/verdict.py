"""May one believe a run: what it and its numbers say for and against it, and what it comes to."""
import numpy as np

from ..curves import with_unit
from ..palette import ENERGY_LINES

OK, NOTE, WARN, UNKNOWN = "ok", "note", "warn", "unknown"
HEADLINES = {OK: "Nothing speaks against this run", NOTE: "Read the notes before use",
             WARN: "Doubtful: read the warnings before use", UNKNOWN: "Not enough is known to judge this run"}
DRIFT_OK = 1e-3          # of the energy balance, as the program's own guard has it
FEW_PERCENT, MANY_PERCENT = 1.0, 10.0
MOST_SUPPORTS = 4


def percent(share):
    return f"{100.0 * share:.2g} %" if abs(share) < 0.995 else f"{100.0 * share:.0f} %"


def spaced(count):
    """A whole number in groups of three digits."""
    return f"{count:,}".replace(",", "\u202f")


def finite(value):
    return value is not None and np.isfinite(value)


def grade(size, few, many):
    return OK if size <= few else NOTE if size <= many else WARN


def check_end(sheet):
    if sheet.run.finished:
        return OK, f"reached its end, t = {with_unit(sheet.run.summary.get('end_time', sheet.end), 's')}"
    return WARN, sheet.remarks[0] if sheet.remarks else "not finished"


def check_energy(sheet):
    if sheet.energy is None:
        return UNKNOWN, "no energies are known"
    drift = np.abs(sheet.energy["drift"])
    if not np.isfinite(drift).any():
        return UNKNOWN, "the balance is not a number"
    worst = int(np.nanargmax(drift))
    when = with_unit(sheet.energy["t"][worst], "s")
    text = f"off by {drift[worst]:.1e} at most, at t = {when}; {DRIFT_OK:g} is allowed"
    return grade(float(drift[worst]), DRIFT_OK, DRIFT_OK), text


def gives_way(sheet):
    options, stiffness = sheet.run.options, sheet.parameters.get("supports, stiffness [N/m]", "")
    laws = {"contact_law", "support_stiffness", "striker_law", "contact_stiffness", "pair_law"} & set(options)
    return bool(laws) or any(word != "inf" for word in stiffness.split())


def check_penetration(sheet):
    gap = sheet.run.summary.get("min_line_gap")
    if not sheet.run.supports and sheet.run.structure != UNKNOWN:
        return OK, "there are no supports"
    if not finite(gap):
        return UNKNOWN, "how near the line comes to its supports is not known"
    at = [f"{name} = {with_unit(value, unit)}" for name, value, unit in
          (("x", sheet.run.summary.get("min_line_gap_x"), "m"), ("t", sheet.run.summary.get("min_line_gap_time"), "s"))
          if finite(value)]
    where = f" at {', '.join(at)}" if at else ""
    if gap >= -1e-9:
        return OK, "the line does not sink into its supports" if gap < 1e-9 else \
            f"the line stays {with_unit(gap, 'm', 3)} away from its supports"
    depth = with_unit(-gap, "m", 3)
    if gives_way(sheet):
        touched = {"pairs" if support.pair is not None else "strikers" if support.striker is not None else "supports"
                   for support in sheet.run.supports}
        what = " and ".join(kind for kind in ("supports", "strikers", "pairs") if kind in touched)
        return OK, f"the line goes {depth} into {what} that give way{where}"
    moved = next((np.nanmax(entry["high"]) - np.nanmin(entry["low"]) for entry in sheet.envelope
                  if entry["name"] == "position"), np.nan)
    share = -gap / moved if finite(moved) and moved > 0.0 else np.nan
    text = f"the line sinks {depth} into rigid supports{where}"
    if finite(share):
        return grade(100.0 * share, FEW_PERCENT, MANY_PERCENT), f"{text}, {percent(share)} of its way"
    return NOTE, text


def check_filter(sheet):
    run, summary = sheet.run, sheet.run.summary
    if run.by_modes:
        return OK, "none: the lowest modes move exactly"
    if run.structure == UNKNOWN:
        return UNKNOWN, f"wf = {run.options.get('filter_frequency', 'not known')}, as it was asked for"
    if not run.filtered:
        return OK, "none"
    frequency, filtered = (summary.get(f"mode_{name}") or [] for name in ("frequency", "filtered"))
    wf = f"wf = {run.filter_frequency:.4g} rad/s"
    if not frequency:
        return UNKNOWN, f"{wf}; what it does to the frequencies is not in the files"
    lowered = 1.0 - filtered[0] / frequency[0]
    return (grade(100.0 * lowered, FEW_PERCENT, MANY_PERCENT),
            f"{wf} lowers the first frequency, {frequency[0]:.4g} rad/s, by {percent(max(lowered, 0.0))}")


def check_convergence(sheet):
    summary = sheet.run.summary
    estimate = summary.get("modal_estimate")
    if not estimate:
        return UNKNOWN, "one run does not tell how far it is from the limit: udar-study, or a finer run beside it"
    off = {}
    for name, words in (("support_impulse", "impulses"), ("peak_support_force", "peak forces"),
                        ("max_bending_stress", "stress")):
        sizes, changes = (np.abs(np.atleast_1d(np.array(table.get(name), float))) for table in (summary, estimate))
        if np.isfinite(sizes).all() and np.isfinite(changes).all() and np.max(sizes, initial=0.0) > 0.0:
            off[words] = float(changes.max() / sizes.max())
    if not off:
        return UNKNOWN, "nothing to compare"
    told = ", ".join(f"{words} {percent(share)}" for words, share in off.items())
    return grade(100.0 * max(off.values()), 2.0, MANY_PERCENT), f"off a run with {estimate['modes']} modes by: {told}"


CHECKS = (("End", check_end), ("Energy balance", check_energy), ("Penetration", check_penetration),
          ("Filter", check_filter), ("Convergence", check_convergence))


def judge(sheet):
    """The headline, its status, and rows (status, what, finding)."""
    rows = [(*check(sheet)[:1], what, check(sheet)[1]) for what, check in CHECKS]
    warnings = [str(text) for text in sheet.run.summary.get("warnings", ())]
    rows += [(WARN, "Warning", text) for text in warnings]
    rows += [(NOTE, "Remark", text) for text in sheet.remarks if text != rows[0][2]]
    states = [status for status, *_ in rows]
    worst = next((status for status in (WARN, NOTE) if status in states), OK)
    if worst == OK and UNKNOWN in states[:3]:
        worst = UNKNOWN
    return {"status": worst, "headline": HEADLINES[worst], "rows": rows}


def peaks_of_forces(sheet):
    summary = sheet.run.summary
    forces, window = summary.get("peak_support_force") or [], summary.get("peak_force_window")
    order = sorted(range(len(forces)), key=lambda k: (-float(f"{abs(forces[k]):.3g}"), k))
    for k in order[:MOST_SUPPORTS]:
        name = sheet.run.supports[k].name if k < len(sheet.run.supports) else f"support {k}"
        over = f", mean over {with_unit(window, 's', 3)}" if finite(window) else ""
        yield f"Largest force, {name}", f"{with_unit(forces[k], 'N')}{over}"
    if len(order) > MOST_SUPPORTS:
        yield "", f"and {len(order) - MOST_SUPPORTS} supports with less"
    pushes = list(zip(sheet.run.supports, summary.get("support_impulse") or []))
    own = [impulse for support, impulse in pushes if support.striker is None and support.pair is None]
    if own:
        yield ("Impulse of the supports" if len(own) > 1 else "Impulse of the support",
               with_unit(sum(own), "N s") + (" in all" if len(own) > 1 else ""))
    for support, impulse in pushes:
        if support.striker is not None:
            yield f"Impulse of striker {support.striker}", with_unit(impulse, "N s")
        if support.pair is not None:
            yield f"Impulse of pair {support.pair}", with_unit(impulse, "N s")


def when_largest(summary, name):
    when = summary.get(f"max_{name}_time")
    return f", t = {with_unit(when, 's')}" if finite(when) else ""


def peaks_of_fields(sheet):
    summary = sheet.run.summary
    for entry in sheet.envelope:
        if entry["name"] in ("utilisation", "position"):
            continue
        name = "bending_stress" if entry["name"] == "stress" else entry["name"]
        yield (f"Largest {entry['label']}", f"{with_unit(entry['worst'], entry['unit'])} at x = "
               f"{with_unit(entry['worst_x'], 'm')}{when_largest(summary, name)}")
    used = summary.get("max_utilisation")
    if finite(used):
        yield "Largest utilisation", f"{percent(used)} of the yield stress"
    if sheet.line is not None:
        position = next(entry for entry in sheet.envelope if entry["name"] == "position")
        begin = np.nanmax(sheet.line["line"][0]) if len(sheet.line["line"]) else np.inf
        for word, values, choose in (("Lowest", position["low"], np.nanargmin),
                                     ("Highest", position["high"], np.nanargmax)):
            at = int(choose(values))
            if word == "Highest" and values[at] <= begin + 1e-9:
                continue  # where it fell from
            place = f"x = {with_unit(position['x'][at], 'm')}"
            yield f"{word} point of the line", f"y = {with_unit(values[at], 'm')} at {place}"
    if sheet.space is not None:
        for name, colour in sheet.space["colours"].items():
            if not np.nanmax(colour["values"]) > 0.0:
                continue
            member = summary.get(f"max_{name}_member")
            yield (f"Largest {colour['label'].removeprefix('largest ')}",
                   with_unit(np.nanmax(colour["values"]), colour["unit"])
                   + (f" in member {member}" if member is not None else "") + when_largest(summary, name))


def rebound(sheet):
    """Velocity of the centre of mass after the last contact of what nothing else acts on."""
    run, last = sheet.run, sheet.touched
    free = all(word in ("0", "") for word in " ".join(
        sheet.parameters.get(name, "") for name in ("ends, stiffness against displacement [N/m]",
                                                    "line supports, stiffness [N/m]")).replace("none", "").split(" "))
    acted = {"load_position", "load_axles", "striker_mass", "base_motion", "initial_velocity_table",
             "damping_mass", "beam_foundation"} & set(run.options)
    gravity = sheet.parameters.get("gravity [m/s^2]")
    if not (free and run.along_line and last and sheet.mass and gravity and not acted and run.finished):
        return
    try:
        begin = float(run.options.get("initial_velocity", 0.0))
    except ValueError:
        return
    speed = begin - float(gravity) * last[1] + sum(run.summary.get("support_impulse") or [0.0]) / sheet.mass
    if run.summary.get("end_time", 0.0) > 1.001 * last[1]:
        way = "upwards" if speed > 0.0 else "downwards"
        yield "Centre of mass after the last contact", f"{abs(speed):.4g} m/s {way}"


def energy_at_end(sheet):
    if sheet.energy is None:
        return
    labels = {name: label for name, label, *_ in ENERGY_LINES}
    parts = {labels[name]: values[-1] for name, values in sheet.energy["parts"].items()
             if name in ("kinetic", "line_strain", "fictitious_springs", "lost_in_impacts", "lost_in_dampers",
                         "support_springs") and values[-1] > 0.0}
    for label, value in sorted(parts.items(), key=lambda part: -part[1])[:3]:
        yield f"Energy at the end, {label}", with_unit(value, "J")


def key_results(sheet):
    """(label, value) of what an engineer asks first."""
    summary = sheet.run.summary
    times = [(label, with_unit(summary[key], "s")) for label, key in
             (("First contact", "first_contact_time"), ("Last contact", "last_contact_time"))
             if finite(summary.get(key))]
    if sheet.contact is not None and sheet.contact["count"]:
        times.append(("Impacts", spaced(sheet.contact["count"])))
    return [*times, *peaks_of_forces(sheet), *peaks_of_fields(sheet), *rebound(sheet), *energy_at_end(sheet)]
