#!/usr/bin/env python3
"""Measures how udar scales on a machine, and says what bounds it.

  scaling.py run      measure, then write everything below into --output
  scaling.py table    text and CSV of a result.json
  scaling.py plot     PNG and SVG of a result.json
  scaling.py model    errors of the cost model and its extrapolation
  scaling.py collect  several results in one table and one set of plots
"""

import argparse
import datetime
import json
import pathlib
import platform
import shlex
import sys
import tempfile

import measure
import networks
import report

ROOT = measure.HERE.parents[1]
QUICK = {"sizes": [500, 2000, 8000], "ranks": [1, 2, 3, 4], "strong": 4000, "per_rank": 1000, "beams": 8,
         "batch_elements": 200, "lattice": 4, "member_elements": 64, "check_interval": 0, "repeats": 1,
         "machine_repeats": 3, "largest_footprint": 1 << 22, "budget": 60}
FULL = {"sizes": [10 ** 3, 10 ** 4, 10 ** 5, 10 ** 6, 10 ** 7], "ranks": [1, 2, 4, 8, 16], "strong": 10 ** 6,
        "per_rank": 50_000, "beams": 200, "batch_elements": 1000, "lattice": 17, "member_elements": 1024,
        "check_interval": 50, "repeats": 5, "machine_repeats": 15, "largest_footprint": 1 << 28,
        "budget": 300}


def whole_numbers(text):
    try:
        found = sorted({int(float(word)) for word in text.split(",")})
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no list of whole numbers") from None
    if not found or found[0] < 1:
        raise argparse.ArgumentTypeError(f"'{text}': every number must be at least 1")
    return found


def program(given, name):
    for path in [pathlib.Path(given)] if given else [ROOT / "build" / name]:
        if path.is_file():
            return path.resolve()
    raise measure.Failure(f"no program {given or ROOT / 'build' / name}: build it, "
                          "or say where with --udar and --bench")


def write_all(result, output):
    """Text, CSV and plots of one result."""
    output.mkdir(parents=True, exist_ok=True)
    (output / "result.json").write_text(json.dumps(result, indent=1) + "\n")
    write_tables([result], output)
    write_plots([result], output)


def write_tables(results, output):
    import model
    output.mkdir(parents=True, exist_ok=True)
    (output / "table.txt").write_text("\n".join(report.text(result) for result in results))
    report.write_csv(output / "table.csv", [row for r in results for row in report.rows(r, model.Model(r))])


def write_plots(results, output):
    import plots
    output.mkdir(parents=True, exist_ok=True)
    for result in results:
        plots.draw_all(result, output, "" if len(results) == 1 else result["name"] + "-")
    if len(results) > 1:
        plots.draw_machines(results, output)


def run(arguments):
    settings = dict(QUICK if arguments.quick else FULL)
    for key in ("sizes", "ranks", "strong", "per_rank", "repeats", "beams", "lattice", "budget"):
        if getattr(arguments, key) is not None:
            settings[key] = getattr(arguments, key)
    settings["ranks"] = sorted({1, *settings["ranks"]})

    def tell(text):
        print(text, flush=True)

    output = pathlib.Path(arguments.output)
    output.mkdir(parents=True, exist_ok=True)
    measure.environment()
    with tempfile.TemporaryDirectory(dir=output) as scratch:
        scratch = pathlib.Path(scratch).resolve()
        programs = measure.Programs(program(arguments.udar, "udar"), program(arguments.bench, "udar-bench"),
                                    arguments.launcher, scratch)
        points = measure.plan(settings["sizes"], settings["ranks"], settings["strong"], settings["per_rank"],
                              settings["check_interval"], scratch)
        batches = [{"ranks": count, "beams": settings["beams"] * count, "elements": settings["batch_elements"]}
                   for count in settings["ranks"]]
        records, batch, machines, versions = measure.measure(programs, points, batches, settings,
                                                             tell)
        nets = networks.run(programs, settings, tell)
    result = {"name": arguments.name, "date": datetime.date.today().isoformat(),
              "command": "examples/scaling/scaling.py " + shlex.join(arguments.words), "version": measure.description(),
              "versions": versions, "launcher": arguments.launcher, "settings": settings, "machine": machines,
              "points": records, "batch": batch, "networks": nets}
    write_all(result, output)
    print(report.text(result))
    print(f"written to {output}: result.json, table.txt, table.csv, plots")
    return tell_wrong([result])


def tell_wrong(results):
    bad = [(result["name"], point) for result in results for point in report.wrong(result)]
    for name, point in bad:
        print(f"scaling: {report.WRONG}: {name}: {point['series']}, {point['elements']} elements "
              f"on {point['ranks']} ranks "
              f"differs from one rank by {point['difference']:.1e}", file=sys.stderr)
    return 2 if bad else 0


def load(paths):
    found = []
    for path in paths:
        path = pathlib.Path(path)
        path = path / "result.json" if path.is_dir() else path
        try:
            found.append(json.loads(path.read_text()))
        except (OSError, json.JSONDecodeError) as error:
            raise measure.Failure(f"cannot read {path}: {error}") from None
    names = [result["name"] for result in found]
    for index, result in enumerate(found):
        if names.count(result["name"]) > 1:
            result["name"] += f"-{index + 1}"
    return found


def show(arguments):
    results = load(arguments.result)
    output = pathlib.Path(arguments.output)
    if arguments.task in ("table", "collect"):
        write_tables(results, output)
        print("\n".join(report.text(result) for result in results))
    if arguments.task in ("plot", "collect"):
        write_plots(results, output)
    if arguments.task == "model":
        for result in results:
            print("\n".join(report.model_text(result)[0]))
    if arguments.task == "collect":
        (output / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    return tell_wrong(results)


def parse(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    tasks = parser.add_subparsers(dest="task", required=True)
    runs = tasks.add_parser("run", help="measure and report")
    runs.add_argument("--udar", help="the program (default: build/udar)")
    runs.add_argument("--bench", help="the benchmark (default: build/udar-bench)")
    runs.add_argument("--launcher", default="mpirun -n {ranks}", help="how to start ranks (Slurm: srun -n {ranks})")
    runs.add_argument("--ranks", type=whole_numbers, help="numbers of ranks, e.g. 1,2,4,8")
    runs.add_argument("--sizes", type=whole_numbers, help="elements of the growth on one rank, e.g. 1e3,1e4,1e5")
    runs.add_argument("--strong", type=lambda text: whole_numbers(text)[0], help="elements of the strong scaling")
    runs.add_argument("--per-rank", type=lambda text: whole_numbers(text)[0], help="elements a rank, weak scaling")
    runs.add_argument("--beams", type=lambda text: whole_numbers(text)[0], help="beams a rank of the batch")
    runs.add_argument("--lattice", type=lambda text: whole_numbers(text)[0],
                      help="junctions along an edge of the lattice on all ranks")
    runs.add_argument("--repeats", type=lambda text: whole_numbers(text)[0], help="of everything, in turn")
    runs.add_argument("--budget", type=lambda text: whole_numbers(text)[0],
                      help="seconds after which a point is not repeated again (default 300)")
    runs.add_argument("--quick", action="store_true", help="small sizes, once: to see that everything works")
    runs.add_argument("--name", default=platform.node().split(".")[0] or "machine", help="of the machine")
    runs.add_argument("--output", default="scaling-out", help="folder for the results")
    for task, text in (("table", "text and CSV"), ("plot", "PNG and SVG"), ("model", "errors and extrapolation"),
                       ("collect", "all of several results")):
        shows = tasks.add_parser(task, help=text)
        shows.add_argument("result", nargs="+", help="result.json, or its folder")
        shows.add_argument("--output", default="scaling-out", help="folder for what is made")
    arguments = parser.parse_args(words)
    arguments.words = list(words)
    return arguments


def main(words):
    arguments = parse(words)
    try:
        return run(arguments) if arguments.task == "run" else show(arguments)
    except measure.Failure as failure:
        print(f"scaling: error: {failure}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
