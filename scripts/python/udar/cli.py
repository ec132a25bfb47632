"""udar-plot: pictures of one run of udar, or of several runs laid over each other.

Reads the files described in docs/output.md and nothing else. One run gives gauges, energy, contacts, deflection,
impulses, forces and envelope in RUN/plots, of a network structure and deformation in place of deflection and
envelope; several runs give gauges, energy and contacts in ./plots. A study of udar-study gives its results against each
axis, and work against precision, in DIR/plots, one of a design what its quantities follow and which runs nothing beats.
"""
import argparse
import pathlib
import sys

from .figures import (draw_contacts, draw_deflection, draw_energy, draw_energy_of_several, draw_envelope, draw_forces,
                      draw_gauges, draw_impulses)
from .networks import draw_deformation, draw_structure, read_network
from .results import read_run
from .studies import draw_study
from .style import Pen
from .tools import Parser, UserError, gauge_list, run_program

PICTURES = ("gauges", "energy", "contacts", "deflection", "structure", "deformation", "impulses", "forces", "envelope")
MAX_GAUGES = 12      # panels that are still readable; more only when --gauges asks for them


def list_of(*words):
    """The type of an argument that lists some of these words."""
    def parsed(text):
        chosen = list(dict.fromkeys(text.split(",")))
        unknown = [part for part in chosen if part not in words]
        if unknown:
            raise argparse.ArgumentTypeError(f"'{unknown[0]}' is none of {', '.join(words)}")
        return chosen
    return parsed


def two_names(text):
    names = text.split(",")
    if len(names) != 2 or not all(names) or names[0] == names[1]:
        raise argparse.ArgumentTypeError(f"'{text}' is not two names like peak_force,sag")
    return names


def dpi_number(text):
    if not text.isdigit() or not 20 <= int(text) <= 1200:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 20 to 1200")
    return int(text)


def parse(arguments):
    parser = Parser(
        prog="udar-plot", description="Draws the results of one run of udar, or of several runs laid over each other.",
        epilog="One run: gauges, energy, contacts, deflection, impulses, forces, envelope; of a network structure and "
               "deformation in place of deflection and envelope. Several runs: gauges, energy, contacts. A folder of "
               "udar-study (also written: study DIR): its results against each axis, work against precision. Prints "
               "the files written, one per line. Exit code 2: a run or an option is not as it should be.")
    parser.add_argument("run", nargs="+", metavar="RUN", help="output folder of a run")
    parser.add_argument("--output", metavar="DIR",
                        help="where the pictures go (default: RUN/plots; for several runs ./plots)")
    parser.add_argument("--gauges", metavar="LIST", type=gauge_list,
                        help=f"numbers of the gauges to draw, like 0,2,4 (default: the first {MAX_GAUGES})")
    parser.add_argument("--pictures", metavar="LIST", type=list_of(*PICTURES),
                        help="which pictures to draw, like gauges,forces (default: all)")
    parser.add_argument("--format", metavar="LIST", type=list_of("png", "svg"), default=["png", "svg"],
                        help="png, svg or png,svg (default: both)")
    parser.add_argument("--dpi", metavar="N", type=dpi_number, default=130,
                        help="resolution of the PNG files (default: 130)")
    parser.add_argument("--objectives", metavar="A,B", type=two_names,
                        help="of a design study: two quantities of study.json that are to be small (default: the "
                             "first two that vary of peak_force, max_stress, sag)")
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
            raise UserError(f"--gauges: {run.folder} has no gauge {gauge}, it has {available} numbered from 0")
    return wanted


def note(text):
    print(f"udar-plot: note: {text}", file=sys.stderr)


def main(arguments):
    options = parse(arguments)
    if options.run[0] == "study" and len(options.run) > 1:
        del options.run[0]
    if any((pathlib.Path(folder) / "study.json").is_file() for folder in options.run):
        if len(options.run) > 1:
            raise UserError("a study is drawn by itself, not with other folders")
        if options.pictures is not None:
            raise UserError("--pictures: the pictures of a study are drawn all")
        draw_study(options, pathlib.Path(options.run[0]))
        return
    several = len(options.run) > 1
    runs = [read_run(folder, with_fields=not several) for folder in options.run]
    network = read_network(runs[0]) if not several and runs[0].structure == "network" else None
    chosen = choose_gauges(runs[0], options.gauges)
    output = pathlib.Path(options.output or ("plots" if several else runs[0].folder / "plots"))
    output.mkdir(parents=True, exist_ok=True)
    pen = Pen(output, options.format, options.dpi, options.title)
    pictures = [*pictures_of_all(runs, chosen), *([] if several else pictures_of_one(runs[0], network))]
    for name, draw, missing in pictures:
        if options.pictures is not None and name not in options.pictures:
            continue
        if missing:
            note(missing)
        else:
            draw(pen)
    for name in set(options.pictures or ()) - {name for name, _, _ in pictures}:
        note(f"--pictures: there is no picture {name} of {'several runs' if several else runs[0].folder}")


def pictures_of_all(runs, gauges):
    """The pictures of one run or several, in their order: name, what draws it, why it is missing."""
    folder = runs[0].folder
    yield ("gauges", lambda pen: draw_gauges(pen, runs, gauges),
           not gauges and f"{folder} has no gauges: no picture of them")
    yield "energy", lambda pen: draw_energy_of_several(pen, runs) if len(runs) > 1 else draw_energy(pen, runs[0]), ""
    yield ("contacts", lambda pen: draw_contacts(pen, runs),
           not any(run.supports for run in runs) and "no supports: no picture of contacts")


def pictures_of_one(run, network):
    """The pictures that several runs do not have, as above."""
    if run.along_line:
        yield ("deflection", lambda pen: draw_deflection(pen, run),
               run.instants is None and f"{run.folder} was written without positions: no picture of the deflection")
    elif network is not None:
        yield "structure", lambda pen: draw_structure(pen, run, network), ""
        yield ("deformation", lambda pen: draw_deformation(pen, run, network),
               not len(network.rows) and f"{run.folder} has no rows of fields: no picture of the deformation")
    else:
        yield ("deflection", None,
               f"{run.folder} is no beam: no pictures along a line; results.vtkhdf has its shape")
    if run.supports:
        missing = run.contact is None and f"{run.folder} has no contact.csv: no picture of"
        yield "impulses", lambda pen: draw_impulses(pen, run), missing and f"{missing} impulses"
        yield "forces", lambda pen: draw_forces(pen, run), missing and f"{missing} forces"
    if run.along_line or run.envelope:
        yield ("envelope", lambda pen: draw_envelope(pen, run), not run.envelope and
               f"{run.folder} has no envelopes, which are written when a run ends: no picture of them")


def run():
    run_program("udar-plot", main)
