"""udar-report: one HTML file about a run of udar, or about several laid over each other, that needs nothing else."""
import pathlib
import sys

from ..tools import Parser, UserError, gauge_list, run_program
from .gather import Gatherer
from .page import render

MOST_GAUGES = 12


def parse(arguments):
    parser = Parser(
        prog="udar-report", description="Writes one HTML file about a run of udar, or about several laid over each "
        "other: case, verdict, curves, contacts, motion, envelopes, spectra, cost. It opens in any browser without "
        "network.",
        epilog="Prints the file written. A run that was stopped or killed is reported as far as its files go, with a "
               "remark. Exit code 2: a run or an option is not as it should be.")
    parser.add_argument("run", nargs="+", metavar="RUN", help="output folder of a run")
    parser.add_argument("--output", metavar="FILE",
                        help="the file to write (default: RUN/report.html; for several runs ./report.html)")
    parser.add_argument("--gauges", metavar="LIST", type=gauge_list,
                        help=f"numbers of the gauges to show, like 0,2,4 (default: the first {MOST_GAUGES})")
    parser.add_argument("--title", metavar="TEXT", default="", help="the title (default: the names of the runs)")
    return parser.parse_args(arguments)


def main(arguments):
    options = parse(arguments)
    gatherers = [Gatherer(folder) for folder in options.run]
    available = max(len(gatherer.sheet.run.gauge_node) for gatherer in gatherers)
    for gauge in options.gauges or ():
        if not 0 <= gauge < available:
            raise UserError(f"--gauges: there is no gauge {gauge}, there are {available} numbered from 0")
    shown = options.gauges or list(range(min(available, MOST_GAUGES)))
    sheets = [gatherer.gather(shown) for gatherer in gatherers]
    if available > len(shown) and options.gauges is None:
        sheets[0].remarks.append(f"{available} gauges, of which the first {len(shown)} are shown; "
                                 "--gauges chooses others")
    usual = "report.html" if len(sheets) > 1 else sheets[0].run.folder / "report.html"
    output = pathlib.Path(options.output or usual)
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(render(sheets, options.title), encoding="utf-8")
    print(output, flush=True)
    for sheet in sheets:
        for remark in sheet.remarks:
            print(f"udar-report: note: {sheet.run.folder}: {remark}", file=sys.stderr)


def run():
    run_program("udar-report", main)
