"""udar-compare: what tells two runs apart, or a run and curves from elsewhere, on a page or as JSON."""
import argparse
import dataclasses
import json
import math

from .comparing import compare
from .tools import Parser, run_program

MOST_ROWS = 20       # of a table, unless --all asks for every one
WITHIN, BEYOND = 0, 1  # exit codes; 2 of an error


def tolerance_of(text):
    """`1e-3` is relative, `m=1e-6` and `line_2=1e-6` absolute."""
    name, _, number = text.rpartition("=")
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    if not value >= 0.0:
        raise argparse.ArgumentTypeError(f"'{text}' is neither a number >= 0, like 1e-3, nor that of a unit or column, "
                                         "like m=1e-6")
    return name, value


def columns_of(text):
    pairs = [part.partition("=") for part in text.split(",")]
    if not all(name and other for name, _, other in pairs):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list like line_2=deflection,force_0=load")
    return {name.strip(): other.strip() for name, _, other in pairs}


def parse(arguments):
    parser = Parser(
        prog="udar-compare", description="Compares a run of udar with another run, or with the curves of a CSV file: "
        "measured ones, or those of another program.",
        epilog="Exit code 0: within the tolerance; 1: beyond it; 2: something cannot be read or compared.")
    parser.add_argument("first", metavar="RUN", help="output folder of a run")
    parser.add_argument("second", metavar="RUN2|FILE.csv",
                        help="output folder of another, or a CSV file with a column 'time' [s] and a line of names, SI "
                             "units unless a name has another in brackets behind it, like 'line_2 [mm]'")
    parser.add_argument("--tolerance", metavar="NUMBER|NAME=NUMBER", type=tolerance_of, action="append", default=[],
                        help="relative: of the range of a curve, the size of a number, for times of impacts of the "
                             "time compared (default: 0.01); NAME=NUMBER: absolute in SI units, for all that has this "
                             "unit, like m=1e-6, or for one column; may be given several times")
    parser.add_argument("--columns", metavar="A=B,...", type=columns_of,
                        help="compare curve A of the first with B of the second, and nothing but these; of a CSV file "
                             "time=B names the column of times")
    parser.add_argument("--all", action="store_true",
                        help="list what is within the tolerance, too; a few curves always are")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    return parser.parse_args(arguments)


def aligned(rows, indent="  "):
    """Rows of text in columns, the first to the left, the others to the right."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return [(indent + "  ".join(part.ljust(width) if k == 0 else part.rjust(width)
                                for k, (part, width) in enumerate(zip(row, widths)))).rstrip() for row in rows]


def number(value, digits=4):
    return "-" if value is None else f"{value:.{digits}g}"


def share(value):
    return "-" if math.isnan(value) else f"{100 * value:.3g} %"


def listed(head, entries, row, everything):
    """A table of entries beyond the tolerance, or of all."""
    shown = [entry for entry in entries if everything or not entry.within]
    some = shown if everything else shown[:MOST_ROWS]
    lines = aligned([head, *map(row, some)]) if some else []
    return lines + ([f"  and {len(shown) - len(some)} more, which --all shows"] if len(some) < len(shown) else [])


def impacts_line(impacts):
    line = (f"{impacts.first} and {impacts.second}: {impacts.matched} matched within {number(impacts.window, 3)} s, "
            f"{impacts.missing} missing, {impacts.extra} extra")
    if impacts.first_alone is not None:
        line += f", the first of these at {number(impacts.first_alone)} s"
    return [f"impacts    {line}", *([f"           matched ones differ by up to {number(impacts.time, 3)} s and "
                                     f"{number(impacts.speed, 3)} m/s"] if impacts.matched else [])]


def page(result, everything=False):
    """The comparison as lines of text."""
    absolute = "".join(f", {name}: {value:g}" for name, value in result.tolerance.absolute.items())
    lines = [f"first      {result.first}", f"second     {result.second}",
             f"tolerance  {result.tolerance.relative:g} of a curve's range, of a number's size{absolute}"]
    lines += [f"options    -{key}: {' and '.join(value or '(none)' for value in values)}"
              for key, values in result.options.items()]
    lines += [f"note       {note}" for note in result.notes]
    good = sum(curve.within for curve in result.curves)
    grid = "the same times" if result.same_times else "at the times of both, linear between rows"
    lines.append(f"curves     {good} of {len(result.curves)} within; {result.rows[0]} and {result.rows[1]} rows, "
                 f"{grid}, {result.begin:g} to {result.end:g} s")
    lines += listed(("column", "unit", "largest", "at [s]", "rms", "of range", "apart from [s]"), result.curves,
                    lambda curve: (curve.name, curve.unit, number(curve.largest), number(curve.time),
                                   number(curve.rms), share(curve.relative), number(curve.apart_from)),
                    everything or len(result.curves) <= MOST_ROWS)
    for which, names in (("first", result.only_first), ("second", result.only_second)):
        shown = ", ".join(names[:MOST_ROWS]) + (f" and {len(names) - MOST_ROWS} more" if len(names) > MOST_ROWS else "")
        lines += [f"  only in the {which}: {shown}"] if names else []
    if result.impacts:
        lines += impacts_line(result.impacts)
    judged = [scalar for scalar in result.scalars if scalar.judged]
    if judged:
        lines.append(f"numbers    {sum(scalar.within for scalar in judged)} of {len(judged)} within")
        lines += listed(("of summary.json", "unit", "first", "second", "difference"), result.scalars,
                        lambda scalar: (scalar.name + ("" if scalar.judged else " (not judged)"), scalar.unit,
                                        number(scalar.first, 7), number(scalar.second, 7), share(scalar.relative)),
                        everything)
    return [*lines, f"verdict    {'within' if result.within else 'beyond'} the tolerance"]


def finite(value):
    """JSON has no nan and no infinity."""
    if isinstance(value, dict):
        return {key: finite(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def main(arguments):
    options = parse(arguments)
    relative = [value for name, value in options.tolerance if not name]
    result = compare(options.first, options.second, relative[-1] if relative else 0.01,
                     {name: value for name, value in options.tolerance if name}, options.columns)
    if options.json:
        print(json.dumps(finite({**dataclasses.asdict(result), "within": result.within}), indent=1))
    else:
        print("\n".join(page(result, options.all)))
    return WITHIN if result.within else BEYOND


def run():
    run_program("udar-compare", main)
