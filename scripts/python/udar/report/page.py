"""The page: what was gathered as data for the scripts, tables and the sketch, in one HTML file."""
import base64
import importlib.resources
import json
import math
import re

import jinja2
import numpy as np
from markupsafe import Markup

from ..curves import prefixed, with_unit
from ..palette import ENERGY_LINES, SERIES
from ..results import match_gauge, run_labels
from .faces import support_faces
from .sketch import sketch_of
from .verdict import judge, key_results, spaced

MOST_TOUCHES = 40        # rows of a table of touches
SCRIPTS = ("core", "curves", "contacts", "line", "space", "main")
STAGES = (("set_up", "set-up"), ("line_solve", "line solves"), ("local_motion", "motion of masses"),
          ("contact", "contact"), ("reduction", "waiting for other ranks"), ("output", "output"),
          ("other", "other stepping"))


def packed(values, kind="f4"):
    """An array as JSON has it: its bytes in base64, little-endian."""
    return {"kind": kind, "bytes": base64.b64encode(np.ascontiguousarray(values, "<" + kind).tobytes()).decode("ascii")}


def plain(value):
    """Nothing but what JSON has: numbers that are not finite are null."""
    if isinstance(value, dict):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    if isinstance(value, (bool, np.bool_)) or value is None or isinstance(value, str):
        return bool(value) if isinstance(value, np.bool_) else value
    if isinstance(value, (int, np.integer)):
        return int(value)
    return float(value) if math.isfinite(value) else None


def with_gauges(sheets):
    """The first run that has any, or the first."""
    return next((sheet for sheet in sheets if sheet.gauges), sheets[0])


def matching(sheets, gauge):
    """Pairs (number of a run, its gauge at the place of a gauge of the first that has any)."""
    first = with_gauges(sheets).run
    for number, sheet in enumerate(sheets):
        known = len(first.x) and len(sheet.run.x) and sheet.run is not first
        yield number, match_gauge(sheet.run, first.gauge_at[gauge]) if known else gauge


def gauge_data(sheets):
    """A chart for each gauge of the first run that has any, with what other runs have at the same place."""
    charts = []
    first = with_gauges(sheets).run
    for gauge in (table["gauge"] for table in with_gauges(sheets).gauges):
        curves = []
        for number, own in matching(sheets, gauge):
            found = next((entry for entry in sheets[number].gauges if entry["gauge"] == own), None)
            if found is not None:
                curves.append({"run": number, "t": packed(found["t"], "f8"),
                               **{kind: packed(found[kind]) for kind in ("line", "mass", "velocity")}})
        place = first.gauge_place(gauge) if len(first.x) else first.gauge_names[gauge]
        x = first.gauge_at[gauge, 0]
        under = [k for k, support in enumerate(first.supports) if support.normal is None and support.striker is None
                 and len(first.x) and support.low - 1e-9 <= x <= support.high + 1e-9]
        heights = sorted({first.supports[k].height for k in under if first.along_line})
        charts.append({"name": f"g{gauge}", "title": f"Gauge g{gauge}" + (f", {place}" if place else ""),
                       "supports": heights, "curves": curves})
    return charts


def spectrum_data(sheets):
    charts = []
    for entry in with_gauges(sheets).gauges:
        curves = []
        for number, own in matching(sheets, entry["gauge"]):
            spectra = sheets[number].spectra or {"amplitude": []}
            found = next((part for part in spectra["amplitude"] if part["gauge"] == own), None)
            if found is not None:
                curves.append({"run": number, "frequency": packed(spectra["frequency"], "f8"),
                               "amplitude": packed(found["values"])})
        if curves:
            charts.append({"title": f"g{entry['gauge']}", "curves": curves})
    return charts


def contact_data(sheet):
    if sheet.contact is None:
        return None
    contact = sheet.contact
    return {"impacts": {name: packed(values, "f8" if name == "t" else "f4")
                        for name, values in contact["impacts"].items()},
            "cell": contact["cell"], "count": contact["count"],
            "rests": {name: packed(values, "f8" if name != "x" else "f4") for name, values in contact["rests"].items()},
            "spans": {name: packed(values, "f8") for name, values in contact["spans"].items()},
            "together": contact["together"]}


def line_data(sheet):
    if sheet.line is None:
        return None
    line = sheet.line
    return {"t": packed(line["t"], "f8"), "x": packed(line["x"], "f8"), "line": packed(line["line"]),
            "masses": packed(line["masses"]) if "masses" in line else None,
            "lift": None if line["lift"] is None else packed(line["lift"])}


def space_data(sheet):
    if sheet.space is None:
        return None
    space = sheet.space
    faces = [{"support": number, "corners": packed(corners)} for number, corners in support_faces(sheet.run)]
    return {"t": packed(space["t"], "f8"), "place": packed(space["place"]), "edges": packed(space["edges"], "i4"),
            "radius": packed(space["radius"]), "rigid": packed(space["rigid"], "f8"),
            "deformation": packed(space["deformation"]), "faces": faces,
            "lift": None if space["lift"] is None else packed(space["lift"]),
            "gauges": sheet.run.gauge_at,
            "colours": [{"label": entry["label"], "unit": entry["unit"], "values": packed(entry["values"])}
                        for entry in space["colours"].values()]}


def run_data(sheet, label, colour):
    run = sheet.run
    supports = [{"name": support.name, "position": support.position, "low": support.low, "high": support.high,
                 "floor": support.is_floor, "side": support.side, "striker": support.striker, "x": support.x,
                 "face": support.face, "flat": support.normal is None} for support in run.supports]
    modes = [run.summary.get(f"mode_{name}") or [] for name in ("frequency", "filtered")]
    energy = sheet.energy
    return {
        "label": label, "colour": colour, "known": bool(len(run.x)), "supports": supports,
        "x": [run.x.min(), run.x.max()] if len(run.x) else None, "touched": sheet.touched,
        "energy": energy and {"t": packed(energy["t"], "f8"), "drift": packed(energy["drift"]),
                              "parts": {name: packed(values) for name, values in energy["parts"].items()}},
        "forces": sheet.forces and {"t": packed(sheet.forces["t"], "f8"), "window": sheet.forces["window"],
                                    "curves": [{"label": curve["label"], "values": packed(curve["values"])}
                                               for curve in sheet.forces["curves"]]},
        "peaks": run.summary.get("peak_support_force") or [],
        "contact": contact_data(sheet), "line": line_data(sheet), "space": space_data(sheet),
        "strikers": sheet.strikers and {"t": packed(sheet.strikers["t"], "f8"),
                                        "positions": [packed(values) for values in sheet.strikers["positions"]]},
        "envelope": [{**entry, **{name: None if entry[name] is None else packed(entry[name])
                                  for name in ("x", "low", "high")}} for entry in sheet.envelope],
        "wf": run.filter_frequency if run.filtered else None, "modes": modes[0], "filtered": modes[1]}


def facts(sheet):
    """(what, value) of the case in a few rows."""
    run, known = sheet.run, sheet.parameters
    rows = []

    def add(label, name, unit=None, unless=()):
        text = known.get(name)
        if text and text not in ("none", *unless) and "values with hash" not in text:
            if len(set(text.split())) == 1:
                text = text.split()[0]  # the same of all supports
            try:
                rows.append((label, with_unit(float(text), unit) if unit else text))
            except ValueError:
                rows.append((label, text))

    if len(run.x):
        if run.along_line:
            rows.append(("Beam", f"{with_unit(np.ptp(run.x), 'm')} long, {run.elements} elements"))
        else:
            size = " x ".join(with_unit(length, "m") for length in np.ptp(run.place, axis=0))
            what = "Network" if run.structure == "network" else "Structure from matrices"
            elements = f", {run.elements} elements" if run.elements else ""
            nodes = "points" if run.structure == "points" else "nodes"
            rows.append((what, f"{size} (x, y, z), {len(run.x)} {nodes}{elements}"))
    if sheet.mass and run.structure != "points":
        rows.append(("Mass", f"{sheet.mass:.4g} kg"))
    add("Bending stiffness EI", "bending stiffness EI [N m^2]", "N m²")
    add("Mass per length", "mass per length rhoA [kg/m]", "kg/m")
    add("Gravity", "gravity [m/s^2]", "m/s²")
    add("Starts above y = 0 at", "initial height [m]", "m")
    for key, label, unit in (("initial_velocity", "Starts with", "m/s"), ("striker_mass", "Striker", "kg"),
                             ("striker_velocity", "Velocity of the striker", "m/s")):
        if key in run.options:
            rows.append((label, f"{run.options[key]} {unit}"))
    heights = [support for support in run.supports if support.striker is None and support.pair is None]
    if heights:
        rows.append(("Supports", ", ".join(support.name for support in heights[:6])
                     + (f" and {len(heights) - 6} more" if len(heights) > 6 else "")))
        add("Restitution", "supports, restitution")
        add("Contact of", "contact surface")
    add("Law of contact", "contact law")
    rows.append(("Filter", run.filter_label if len(run.x) else run.options.get("filter_frequency", "unknown")))
    rows.append(("Integrator", run.summary.get("integrator") or run.options.get("ts_type") or "unknown"))
    return [(label, together(shorten(value))) for label, value in rows]


def together(text):
    """With numbers and units that stay on one line."""
    return re.sub(r"(?<=[0-9]) (?=[A-Za-zµ%])| (?==)|(?<==) ", "\u00a0", text)


def verdict_of(sheet):
    verdict = judge(sheet)
    return {**verdict, "rows": [(status, what, together(finding)) for status, what, finding in verdict["rows"]]}


def shorten(text, most=160):
    return text if len(text) <= most else f"{text[:most]} …"


def differing(tables):
    """Rows (name, value of each run, whether they differ) of all the runs' dictionaries."""
    names = sorted(set().union(*tables))
    return [(name, [shorten(str(table.get(name, "-")), 400) for table in tables],
             len({table.get(name) for table in tables}) > 1) for name in names]


def aligned(lists):
    """Rows (label, value of each run): those of the first, then what others have besides."""
    labels = list(dict.fromkeys(label for rows in lists for label, _ in rows if label))
    known = [dict(rows) for rows in lists]
    return [(together(label), [together(table.get(label, "-")) for table in known]) for label in labels]


def short_name(run, number):
    """The number of a support, or which striker or pair it is."""
    support = run.supports[number]
    if support.pair is not None:
        return f"pair {support.pair}"
    return f"{number}" if support.striker is None else f"striker {support.striker}"


def impact_table(sheet):
    """Title, heads with units and rows of the first impacts, or of the first touches where forces hold the line."""
    if sheet.first_impacts is not None:
        columns = sheet.first_impacts
        scale, unit = prefixed(float(np.max(np.abs(columns["time"]))), "s")
        heads = [f"t [{unit}]", "node", "x [m]", "support", "velocity before [m/s]", "after [m/s]", "impulse [N s]",
                 "energy lost [J]"]
        rows = [[f"{time / scale:.6g}", f"{node:.0f}", f"{x:.4g}", short_name(sheet.run, int(support)),
                 *(f"{value:.4g}" for value in rest)] for time, node, x, support, *rest in zip(*columns.values())]
        count = sheet.contact["count"] if sheet.contact else len(rows)
        return {"title": f"The first {len(rows)} of {spaced(count)} impacts", "heads": heads, "rows": rows}
    if sheet.contact is None or not len(sheet.contact["all_spans"]):
        return None
    spans = sheet.contact["all_spans"]
    spans = spans[np.lexsort((spans[:, 0], spans[:, 1]))]
    number, t0, t1, impulse = spans[:MOST_TOUCHES].T
    lasting = t1 - t0
    mean = np.divide(impulse, lasting, out=np.full(len(lasting), np.nan), where=lasting > 0.0)
    (time, second), (push, newton_second), (force, newton) = (
        prefixed(float(np.nanmax(np.abs(values))), unit) for values, unit in ((t1, "s"), (impulse, "N s"), (mean, "N")))
    heads = ["support", f"from [{second}]", f"to [{second}]", f"lasts [{second}]", f"impulse [{newton_second}]",
             f"mean force [{newton}]"]
    rows = [["all" if sheet.contact["together"] else short_name(sheet.run, int(k)), f"{a / time:.6g}",
             f"{b / time:.6g}", f"{(b - a) / time:.4g}", f"{i / push:.4g}", f"{f / force:.4g}"]
            for k, a, b, i, f in zip(number, t0, t1, impulse, mean)]
    short = f", pauses up to {with_unit(sheet.contact['pause'], 's', 3)} left out" if sheet.contact["pause"] else ""
    return {"title": f"The first {len(rows)} of {len(spans)} touches, as the rows of output tell them{short}",
            "heads": heads, "rows": rows}


def worst_places(sheet):
    """Rows (what, largest value, where) of a structure in space."""
    if sheet.space is None:
        return []
    return [(label[0].upper() + label[1:], with_unit(value, unit),
             together((f"member {member}, " if member is not None else "")
                      + ", ".join(f"{axis} = {with_unit(x, 'm')}" for axis, x in zip("xyz", place))))
            for label, unit, value, member, place in sheet.space["worst"]]


def cost_of(sheet):
    """Seconds by stage for bars, and what else the run took."""
    summary = sheet.run.summary
    own = {**(summary.get("own_seconds") or {}), "set_up": (summary.get("wall_seconds_mean") or {}).get("set_up", 0.0)}
    total = sum(value for value in own.values() if value)
    bars = [{"label": label, "seconds": f"{own[name]:.3g} s", "share": 100.0 * own[name] / total}
            for name, label in STAGES if own.get(name)] if total else []
    rows = [(label, spaced(summary[key])) for key, label in
            (("ranks", "Ranks"), ("steps", "Steps"), ("line_solves", "Line solves"), ("impacts", "Impacts"),
             ("rests", "Rests")) if key in summary]
    wall = (summary.get("wall_seconds") or {}).get("total")
    rows = ([("Wall time", with_unit(wall, "s"))] if wall else []) + rows
    if summary.get("peak_memory_bytes"):
        rows.append(("Memory", f"{summary['peak_memory_bytes'] / 1e6:.0f} MB"))
    return {"bars": bars, "rows": rows}


def kept_rows(sheets):
    """How the curves were thinned, in words."""
    width = max(sheet.gauge_width for sheet in sheets)
    if width < 3:
        return "Curves have every row of the files."
    return (f"Of each {width} successive rows curves keep those with the least and the greatest values: "
            "no peak is lost, but between two of them a zoomed curve is drawn straight.")


def shown_motion(sheet):
    """What of the fields the motion shows, in words; nothing where it is all of them."""
    motion = sheet.line or sheet.space
    if motion is None:
        return ""
    parts = []
    if len(motion["t"]) < motion["of_rows"]:
        parts.append(f"{len(motion['t'])} of {motion['of_rows']} rows of fields")
    if sheet.line and len(sheet.line["x"]) < len(sheet.run.x):
        parts.append(f"{len(sheet.line['x'])} of {len(sheet.run.x)} nodes")
    if sheet.space and sheet.space["every"] > 1:
        parts.append(f"one of {sheet.space['every']} members")
    return ", ".join(parts)


def whole_options(text):
    """HTML of a text whose option names are not broken at their hyphen."""
    return Markup(re.sub(r"(?<![^\s(])-[a-z]\w+", r'<span class="whole">\g<0></span>', str(Markup.escape(text))))


def render(sheets, title):
    """The whole page as text."""
    folder = importlib.resources.files("udar.report") / "web"

    def text_of(name):
        return (folder / name).read_text(encoding="utf-8")

    labels = run_labels([sheet.run for sheet in sheets])
    labels = [label if len(sheets) > 1 else sheet.run.folder.resolve().name for label, sheet in zip(labels, sheets)]
    colours = [SERIES[k % len(SERIES)] for k in range(len(sheets))]
    data = plain({"runs": [run_data(*each) for each in zip(sheets, labels, colours)], "gauges": gauge_data(sheets),
                  "spectra": spectrum_data(sheets),
                  "energy_lines": [{"name": name, "label": label, "colour": colour, "dash": dash}
                                   for name, label, colour, dash in ENERGY_LINES]})
    runs = [{"label": label, "colour": colour, "folder": str(sheet.run.folder), "verdict": verdict_of(sheet),
             "sketch": Markup(sketch_of(sheet)), "table": impact_table(sheet), "worst": worst_places(sheet),
             "motion": shown_motion(sheet), "cost": cost_of(sheet), "facts": facts(sheet)}
            for sheet, label, colour in zip(sheets, labels, colours)]
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True,
                                     undefined=jinja2.StrictUndefined)
    environment.filters["whole_options"] = whole_options
    return environment.from_string(text_of("page.html")).render(
        title=title or ", ".join(labels), runs=runs, sheets=sheets, thinned=kept_rows(sheets),
        results=aligned([key_results(sheet) for sheet in sheets]),
        options=differing([sheet.run.options for sheet in sheets]),
        parameters=differing([sheet.parameters for sheet in sheets]),
        versions=differing([sheet.run.summary.get("versions") or sheet.versions for sheet in sheets]),
        data=Markup(json.dumps(data, allow_nan=False, separators=(",", ":"))
                                            .replace("<", "\\u003c")),
        styles=Markup(text_of("vendor/uPlot.min.css") + text_of("report.css")),
        licence=Markup(text_of("vendor/LICENSE.uPlot")), library=Markup(text_of("vendor/uPlot.iife.min.js")),
        scripts=Markup("\n".join(text_of(f"{name}.js") for name in SCRIPTS)))
