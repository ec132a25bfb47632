#!/usr/bin/env python3
"""tune.py: tries option sets on a case, checks each against a reference, ranks them, writes the fastest as best.opts.

Reads what udar writes (docs/output.md) and nothing else. README.md beside this file says what the figures mean.
"""
import argparse
import dataclasses
import datetime
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import statistics
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
sys.path.insert(0, str(TOP / "scripts" / "python"))  # of the sources
sys.path += map(str, TOP.parents[1].glob("lib/python3*/dist-packages"))  # of an installation

from udar.tools import Parser, UserError, one_line, read_csv  # noqa: E402, its place and its settings come first
import h5py  # noqa: E402
import numpy as np  # noqa: E402

OWN_CASE = TOP / "examples" / "01-falling-beam" / "case.yaml"
OWN_OPTIONS = "-filter_frequency 100 -beam_elements 1000 -support_width 0.2 -contact_restitution 0.5 -ts_max_time 0.6"
DEFAULT_RTOL = {"chebyshev": 1e-14, "impact": 1e-7}  # of udar, docs/options.md; any other integrator: 1e-8
SMALLEST_RTOL = 1e-14                                # below it a step ends in round-off
LEAST_LIMIT, TIMES_THE_FASTEST = 30.0, 20.0          # of a run [s], and of the fastest run so far
REPEATED_WITHIN = 10.0                               # sets slower than this times the fastest are run once
STOPPED_BY_STEPS = 3                                 # exit code of udar
# Keys that print or check and leave the motion alone: a set of nothing else is a diagnostic.
DIAGNOSTIC = re.compile(r"(_view|_monitor)(_|$)|^log_|^options_|^info$|^filter_check_interval$|^filter_residual_tol")

QUALIFIED, DIAGNOSTICS, DISQUALIFIED, FAILED = "qualified", "diagnostics", "disqualified", "failed"
VERDICTS = (QUALIFIED, DIAGNOSTICS, DISQUALIFIED, FAILED)


class RunFailed(Exception):
    """A run without usable result; its text is the reason."""


# ------------------------------------------------------------------------------------------------ option sets


@dataclasses.dataclass
class OptionSet:
    name: str
    path: pathlib.Path | None  # None: the case as it stands
    lines: list                # its keys, one -key value a line

    @property
    def keys(self):
        return [line.split()[0].lstrip("-") for line in self.lines]

    def kept_from(self, fixed):
        """Lines of the set that the command line keeps from having an effect: it wins over every file."""
        return [line for line, key in zip(self.lines, self.keys) if key in fixed and line.split()[1:] != fixed[key]]

    @property
    def only_prints(self):
        return bool(self.lines) and all(DIAGNOSTIC.search(key) for key in self.keys)

    @property
    def arguments(self):
        return ["-options_file", str(self.path)] if self.path else []


def read_set(path, name=None):
    path = pathlib.Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"option set {path}: {getattr(error, 'strerror', None) or 'not a text file'}") from None
    lines = [line.strip() for line in text.splitlines() if line.strip() and line.strip()[0] not in "#!%"]
    for line in lines:
        if not line.startswith("-"):
            raise UserError(f"option set {path}: '{line}' does not start with '-'; give one '-key value' a line")
    return OptionSet(name or path.stem, path, lines)


def read_sets(paths):
    sets = [OptionSet("none", None, [])] + [read_set(path) for path in paths]
    seen = {}
    for one in sets:
        if one.name in seen:
            other = seen[one.name] or "'none' is the case without any set"
            raise UserError(f"two option sets are called '{one.name}': {other} and {one.path}")
        seen[one.name] = one.path
    return sets


# ------------------------------------------------------------------------------------------------ one run


@dataclasses.dataclass
class Result:
    """What one run left behind: `curves` are the columns of gauges.csv and energy.csv without the time."""
    time: np.ndarray
    curves: dict
    summary: dict
    unused: list   # keys that nothing read
    elapsed: float  # [s], with the start of the program

    @property
    def seconds(self):
        return self.summary["wall_seconds"]["total"]


def read_result(folder, text, elapsed):
    try:
        summary = json.loads((folder / "summary.json").read_text())
        gauges, energy = read_csv(folder / "gauges.csv"), read_csv(folder / "energy.csv")
    except (OSError, ValueError, UserError) as error:
        raise RunFailed(f"files cannot be read: {error}") from None
    instants = energy.pop("time")
    if len(gauges) > 1 and not np.array_equal(gauges.pop("time"), instants):
        raise RunFailed("gauges.csv and energy.csv have different times")
    energy.pop("drift")  # the relative error of the total, which is compared itself
    gauges.pop("time", None)
    curves = {**gauges, **energy}
    for name, values in curves.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise RunFailed(f"not finite: {name} at t = {instants[bad[0]]:g} s")
    unused = re.findall(r"^Option left: name:-(\S+)", text, re.MULTILINE)
    return Result(instants, curves, summary, unused, elapsed)


def end_group(process):
    """SIGTERM, which mpirun passes on to its ranks, and SIGKILL to whatever is left of the group after 10 s."""
    for number, patience in ((signal.SIGTERM, 10), (signal.SIGKILL, None)):
        try:
            os.killpg(process.pid, number)
        except ProcessLookupError:
            pass
        try:
            process.wait(timeout=patience)
            return
        except subprocess.TimeoutExpired:
            continue


def reason_of(code, error_text):
    """Why a run ended: udar's own line where there is one."""
    lines = [line.strip() for line in error_text.replace("\r", "\n").splitlines() if line.strip()]
    own = [line for line in lines if line.startswith("udar: error:")]
    if own:
        return own[0].removeprefix("udar: error:").strip()
    if code == STOPPED_BY_STEPS:
        return "ended by -ts_max_steps before -ts_max_time"
    words = [line for line in lines if re.search(r"[A-Za-z]{3}", line) and not line.startswith("udar: warning:")]
    return f"exit code {code}" + (f": {words[0]}" if words else "")


class Runner:
    """Starts udar on the case, one run at a time, and keeps the time limit."""

    def __init__(self, options):
        self.case, self.extra, self.udar, self.launcher = options.case, options.options, options.udar, options.launcher
        self.folder, self.limit, self.fastest = options.output / "runs", options.time_limit, None

    @property
    def fixed(self):
        """Keys and values of --options."""
        found, key = {}, None
        for word in self.extra:
            if re.match(r"-[A-Za-z]", word):
                key = word.lstrip("-")
                found[key] = []
            elif key:
                found[key].append(word)
        return found

    def launch(self, ranks):
        return shlex.split(self.launcher.format(ranks=ranks))

    def command(self, ranks, arguments):
        return [*self.launch(ranks), str(self.udar), "-options_file", str(self.case), *self.extra, *arguments]

    def allowed(self):
        if self.limit is not None:
            return self.limit
        return None if self.fastest is None else max(LEAST_LIMIT, TIMES_THE_FASTEST * self.fastest)

    def run(self, name, ranks, arguments):
        folder = self.folder / f"{name}-np{ranks}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        command = self.command(ranks, arguments)
        command += ["-output_directory", str(folder), "-output_overwrite", "-options_left"]
        begin, allowed = time.monotonic(), self.allowed()
        with open(folder / "stdout.txt", "wb") as out, open(folder / "stderr.txt", "wb") as err:
            try:
                process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                           start_new_session=True)
            except OSError as error:
                raise UserError(f"cannot start '{command[0]}': {error.strerror}") from None
            try:
                code = process.wait(timeout=allowed)
            except subprocess.TimeoutExpired:
                end_group(process)
                raise RunFailed(f"time limit of {allowed:.3g} s") from None
            except BaseException:
                end_group(process)
                raise
        elapsed = time.monotonic() - begin
        out_text, err_text = ((folder / f"std{kind}.txt").read_text(errors="replace") for kind in ("out", "err"))
        if code != 0:
            raise RunFailed(reason_of(code, err_text))
        result = read_result(folder, out_text, elapsed)
        if not result.summary.get("completed", True):
            raise RunFailed("did not reach its end")
        self.fastest = min(elapsed, self.fastest or elapsed)
        return result


# ------------------------------------------------------------------------------------------------ errors


@dataclasses.dataclass
class Distance:
    value: float      # relative to the scale of its kind
    curve: str = ""
    instant: float = 0.0

    def __str__(self):
        return f"{self.value:.1e}" + (f" ({self.curve} at t = {self.instant:g} s)" if self.curve else "")


def kind_of(name):
    """Curves of one kind share one scale: positions (masses and line), velocities, energies."""
    return {"mass": "position", "line": "position", "velocity": "velocity"}.get(
        name.rsplit("_", 1)[0] if re.search(r"_\d+$", name) else "", "energy")


def scales(reference):
    """The motion's own scale: range of the positions [m], largest velocity [m/s], largest energy [J]."""
    found = {}
    for kind in ("position", "velocity", "energy"):
        curves = [values for name, values in reference.curves.items() if kind_of(name) == kind]
        if curves and kind == "position":
            found[kind] = float(max(values.max() for values in curves) - min(values.min() for values in curves))
        elif curves:
            found[kind] = float(max(np.abs(values).max() for values in curves))
    return found


def distance(result, reference):
    """The largest difference of any curve at any time, relative to the scale of its kind."""
    if list(result.curves) != list(reference.curves):
        raise RunFailed("other gauges than the reference")
    if len(result.time) != len(reference.time) or not np.allclose(result.time, reference.time, rtol=1e-12, atol=0):
        raise RunFailed("other output times than the reference")
    unit, worst = scales(reference), Distance(0.0)
    for name, values in result.curves.items():
        difference = np.abs(values - reference.curves[name])
        row = int(difference.argmax())
        relative = float(difference[row]) / (unit[kind_of(name)] or 1.0)
        if relative > worst.value:
            worst = Distance(relative, name, float(reference.time[row]))
    return worst


# ------------------------------------------------------------------------------------------------ reference


@dataclasses.dataclass
class Reference:
    result: Result
    rtol: float
    check_rtol: float
    error: Distance
    text: str


def options_of(folder):
    """What a run was given, by key: the attribute `options` of results.h5."""
    with h5py.File(folder / "results.h5", "r") as file:
        text = file.attrs["options"]
    text = text.decode() if isinstance(text, bytes) else str(text)
    pairs = [line.split(maxsplit=1) for line in text.splitlines() if line.strip()]
    return {pair[0].lstrip("-"): pair[1] if len(pair) > 1 else "" for pair in pairs}


def make_reference(runner, chosen, ranks):
    """Runs the case at a tight tolerance and at ten times that one; their distance is the reference's own error."""
    what = f"the set {chosen.name}" if chosen else "the case as it stands"
    arguments = chosen.arguments if chosen else []

    def attempt(name, more):
        try:
            return runner.run(name, ranks, [*arguments, *more])
        except RunFailed as failure:
            raise UserError(f"no reference: {what}, {' '.join(more) or 'unchanged'}, on {ranks} rank(s): {failure}; "
                            f"see {runner.folder / name}-np{ranks}") from None

    pilot = attempt("reference-pilot", [])
    given = options_of(runner.folder / f"reference-pilot-np{ranks}")
    if given.get("ts_adapt_type") == "none":
        raise UserError(f"no reference: {what} runs with fixed steps (-ts_adapt_type none), "
                        "which no tolerance changes; "
                        "name a set with error control: --reference petsc-options/rk-tight.opts")
    integrator = pilot.summary["integrator"]
    own = float(given.get("ts_rtol", DEFAULT_RTOL.get(integrator, 1e-8)))
    rtol = own if chosen else max(own / 100, min(own, SMALLEST_RTOL))

    def tightened(value):
        more = ["-ts_rtol", f"{value:.3g}"]
        if "ts_atol" in given:
            more += ["-ts_atol", f"{float(given['ts_atol']) * value / own:.3g}"]
        return more

    result, check = attempt("reference", tightened(rtol)), attempt("reference-check", tightened(10 * rtol))
    try:
        error = distance(check, result)
    except RunFailed as failure:
        raise UserError(f"no reference: at -ts_rtol {10 * rtol:.3g} and {rtol:.3g} there are {failure}") from None
    text = (f"{what} ({integrator}, -ts_rtol {own:g}) at -ts_rtol {rtol:.3g} on {ranks} rank(s); "
            f"its own error, by the distance to -ts_rtol {10 * rtol:.3g}: {error}")
    return Reference(result, rtol, 10 * rtol, error, text)


# ------------------------------------------------------------------------------------------------ trials


@dataclasses.dataclass
class Trial:
    """One set on one number of ranks."""
    set: OptionSet
    ranks: int
    results: list = dataclasses.field(default_factory=list)
    errors: list = dataclasses.field(default_factory=list)
    verdict: str = ""
    reason: str = ""

    @property
    def label(self):
        return f"{self.set.name} on {self.ranks} rank{'s' if self.ranks > 1 else ''}"

    @property
    def seconds(self):
        return [result.seconds for result in self.results]

    @property
    def median(self):
        return statistics.median(self.seconds) if self.results else float("inf")

    @property
    def error(self):
        return max(self.errors, key=lambda error: error.value)

    def row(self):
        row = {"set": self.set.name, "ranks": self.ranks, "verdict": self.verdict, "reason": self.reason}
        if self.results:
            summary = self.results[0].summary
            row |= {
                "seconds_median": self.median, "seconds_low": min(self.seconds), "seconds_high": max(self.seconds),
                "line_solve_seconds_median": statistics.median(
                    result.summary["wall_seconds"]["line_solve"] for result in self.results),
                "runs": len(self.results), "line_solves": summary["line_solves"], "steps": summary["steps"],
                "integrator": summary["integrator"],
                "peak_memory_bytes": max(result.summary["peak_memory_bytes"] for result in self.results)}
        if self.errors:
            row |= {"error": self.error.value, "error_curve": self.error.curve, "error_time": self.error.instant}
        return row


def measure(runner, trials, reference, repeats):
    """Interleaved: every round runs each set once, backwards every second time, so that a busy minute meets all."""
    for turn in range(repeats):
        fastest = min((trial.median for trial in trials), default=0.0)
        for trial in trials if turn % 2 == 0 else reversed(trials):
            if trial.verdict or (trial.results and trial.median > REPEATED_WITHIN * fastest):
                continue
            show(f"  round {turn + 1} of {repeats}: {trial.label}")
            try:
                result = runner.run(trial.set.name, trial.ranks, trial.set.arguments)
                trial.errors.append(distance(result, reference.result))
                trial.results.append(result)
            except RunFailed as failure:
                trial.verdict, trial.reason = FAILED, str(failure)
    show("")


def judge(trial, tolerance, fixed):
    if trial.verdict:
        return
    unused = [f"-{key}" for key in trial.set.keys if key in trial.results[0].unused]
    if not trial.error.value <= tolerance:
        trial.verdict = DISQUALIFIED
        trial.reason = f"error above {tolerance:g}: {trial.error.curve} at t = {trial.error.instant:g} s"
    elif trial.set.only_prints:
        trial.verdict, trial.reason = DIAGNOSTICS, "only prints or checks"
    elif unused:
        trial.verdict, trial.reason = DISQUALIFIED, f"nothing reads {', '.join(unused)}"
    else:
        trial.verdict = QUALIFIED
        kept = trial.set.kept_from(fixed)
        if kept:
            trial.reason = f"--options wins over its {', '.join(line.split()[0] for line in kept)}"


def order(trial):
    return VERDICTS.index(trial.verdict), trial.median, trial.set.name, trial.ranks


# ------------------------------------------------------------------------------------------------ report


def show(text):
    """One line of progress that replaces itself on a terminal and is left out elsewhere."""
    if sys.stderr.isatty():
        print(f"\r{text:<78}", end="" if text else "\r", file=sys.stderr, flush=True)


def table(trials):
    head = ("", "set", "ranks", "time [s] (low, high)", "line solves [s]", "solves", "steps", "error", "MB", "verdict")
    rows = [head]
    for place, trial in enumerate(trials, 1):
        row = trial.row()
        if trial.results:
            spread = f"{row['seconds_low']:.3g}, {row['seconds_high']:.3g}" if row["runs"] > 1 else "one run"
            figures = [f"{row['seconds_median']:.3g} ({spread})",
                       f"{row['line_solve_seconds_median']:.2g}", str(row["line_solves"]), str(row["steps"]),
                       f"{row['error']:.1e}", f"{row['peak_memory_bytes'] / 1e6:.0f}"]
        else:
            figures = ["-"] * 6
        verdict = trial.verdict + (f": {trial.reason}" if trial.reason else "")
        shown = str(place) if trial.verdict == QUALIFIED else ""
        rows.append((shown, trial.set.name, str(trial.ranks), *figures, verdict))
    widths = [max(len(row[column]) for row in rows) for column in range(len(head))]
    left = (1, len(head) - 1)  # names and verdicts; figures end on the right
    return "\n".join(
        "  ".join(text.ljust(width) if column in left else text.rjust(width)
                  for column, (text, width) in enumerate(zip(row, widths))).rstrip() for row in rows)


def write_csv(path, trials):
    rows = [trial.row() for trial in trials]
    names = list(dict.fromkeys(name for row in sorted(rows, key=len, reverse=True) for name in row))

    def cell(value):
        text = f"{value:.9g}" if isinstance(value, float) else str(value)
        return '"' + text.replace('"', '""') + '"' if re.search(r'[",\n]', text) else text

    lines = [",".join(names)] + [",".join(cell(row.get(name, "")) for name in names) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


# Okabe and Ito's palette: told apart with any kind of colour vision.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = "osD^vP*X<>"


def draw(folder, trials, reference, tolerance, title):
    """Error against time, one panel for each number of ranks; filled: qualified, hollow: not."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot, ticker
    from matplotlib.lines import Line2D

    shown = [trial for trial in trials if trial.results]
    if not shown:
        return []
    pyplot.rcParams.update({"font.size": 11, "axes.grid": True, "grid.color": "#dddddd", "axes.axisbelow": True,
                            "axes.spines.top": False, "axes.spines.right": False, "svg.fonttype": "none",
                            "svg.hashsalt": "udar"})
    names = list(dict.fromkeys(trial.set.name for trial in shown))  # the fastest first
    style = {name: (COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]) for k, name in enumerate(names)}
    ranks = sorted({trial.ranks for trial in shown})
    positive = [error for error in (*(trial.error.value for trial in shown), reference.error.value) if error > 0]
    least = min([*positive, tolerance]) / 10  # curves equal to the last bit are drawn here
    figure = pyplot.figure(layout="constrained", figsize=(2.9 + 3.7 * len(ranks), max(4.4, 2.0 + 0.27 * len(names))))
    grid = figure.add_gridspec(1, len(ranks) + 1, width_ratios=[3.7] * len(ranks) + [2.1])
    axes = []
    for column in range(len(ranks)):
        first = axes[0] if axes else None
        axes.append(figure.add_subplot(grid[column], sharex=first, sharey=first))
        axes[-1].tick_params(labelleft=not first)
    for axis, count in zip(axes, ranks):
        for trial in (trial for trial in shown if trial.ranks == count):
            colour, marker = style[trial.set.name]
            spread = [[trial.median - min(trial.seconds)], [max(trial.seconds) - trial.median]]
            axis.errorbar(trial.median, max(trial.error.value, least), xerr=spread, color=colour, marker=marker,
                          markersize=8, capsize=3, linewidth=1, markeredgewidth=1.4,
                          markerfacecolor=colour if trial.verdict == QUALIFIED else "white")
        axis.axhline(tolerance, color="#595959", linewidth=1, linestyle="--")
        axis.axhspan(least / 2, max(reference.error.value, least / 2), color="#eeeeee", zorder=0)
        axis.set_title(f"{count} rank{'s' if count > 1 else ''}", fontsize=11)
        axis.set_xlabel("time of the run [s], median and range")
    axes[0].set(xscale="log", yscale="log", ylabel="error, relative to the motion's scale")
    axes[0].set_ylim(bottom=least / 2)
    low, high = min(min(trial.seconds) for trial in shown), max(max(trial.seconds) for trial in shown)
    axes[0].set_xlim(low / 1.3, high * 1.3)
    axes[0].xaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5) if high < 20 * low else (1,)))
    axes[0].xaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))
    axes[0].xaxis.set_minor_formatter(ticker.NullFormatter())
    handles = [Line2D([], [], color=style[name][0], marker=style[name][1], linestyle="", label=name) for name in names]
    handles += [Line2D([], [], color="#595959", marker="o", markerfacecolor="white", linestyle="",
                       label="hollow: cannot win"),
                Line2D([], [], color="#595959", linestyle="--", linewidth=1, label="tolerance"),
                Line2D([], [], color="#dddddd", linewidth=7, label="reference's own error")]
    beside = figure.add_subplot(grid[len(ranks)])
    beside.set_axis_off()
    beside.legend(handles=handles, loc="center left", frameon=False, fontsize=10, borderaxespad=0)
    failed = sum(trial.verdict == FAILED and not trial.results for trial in trials)
    figure.suptitle(title + (f" ({failed} failed, not shown)" if failed else ""), fontsize=11)
    paths = [folder / f"tuning.{kind}" for kind in ("png", "svg")]
    for path in paths:
        figure.savefig(path, dpi=130)
    pyplot.close(figure)
    return paths


def write_best(path, best, reference, runner, command, now):
    row = best.row()
    use = shlex.join([*runner.command(best.ranks, []), "-options_file", str(path)])
    header = [
        "The fastest option set that agrees with the reference, found by examples/tuning/tune.py",
        f"set:       {best.set.name}" + ("" if best.set.path else " (the case as it stands: no option is better)"),
        f"case:      {runner.case} {shlex.join(runner.extra)}",
        f"ranks:     {best.ranks}",
        f"time:      {row['seconds_median']:.3g} s, median of {row['runs']} "
        f"({row['seconds_low']:.3g} to {row['seconds_high']:.3g} s)",
        f"error:     {row['error']:.1e} of the motion's scale; of the reference itself {reference.error.value:.1e}",
        f"found by:  {command}",
        f"date:      {now}",
        f"use:       {use}"]
    lines = [f"# {one_line(line)}" if ":  " not in line else f"# {line[:11]}{one_line(line[11:])}" for line in header]
    kept = best.set.kept_from(runner.fixed)
    lines += [line for line in best.set.lines if line not in kept]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


# ------------------------------------------------------------------------------------------------ command line


def rank_list(text):
    if not re.fullmatch(r"[1-9]\d*(,[1-9]\d*)*", text):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of numbers of ranks like 1,2,4")
    return list(dict.fromkeys(int(part) for part in text.split(",")))


def positive(kind):
    def convert(text):
        try:
            value = kind(text)
        except ValueError:
            value = 0
        if not 0 < value < float("inf"):
            what = "a whole number > 0" if kind is int else "a number > 0"
            raise argparse.ArgumentTypeError(f"'{text}' is not {what}")
        return value
    return convert


def words(text):
    try:
        return shlex.split(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"'{text}': {error}") from None


def parse(arguments):
    parser = Parser(
        prog="tune.py", description="Tries option sets on a case and ranks those that agree with a reference by time.",
        epilog="Exit code 0: best.opts is written; 1: no set qualifies, or there is no reference; "
               "2: an argument is wrong.")
    parser.add_argument("case", nargs="?", metavar="CASE.yaml", type=pathlib.Path,
                        help="the case (default: example 01 with " + OWN_OPTIONS + ")")
    parser.add_argument("--options", metavar="TEXT", type=words,
                        help="options of every run; as always they win over the case and the sets")
    parser.add_argument("--sets", nargs="+", metavar="FILE", default=None,
                        help="option sets (default: petsc-options/*.opts and those beside this script); "
                             "the case without any is always tried as 'none'")
    parser.add_argument("--ranks", metavar="LIST", type=rank_list, default=[1], help="like 1,2 (default: 1)")
    parser.add_argument("--repeats", metavar="N", type=positive(int), default=3, help="runs of each (default: 3)")
    parser.add_argument("--tolerance", metavar="E", type=positive(float), default=1e-6,
                        help="largest error of a winner, relative to the motion's scale (default: 1e-6)")
    parser.add_argument("--reference", metavar="FILE", default=None,
                        help="option set of the reference, at its own -ts_rtol (default: the case, -ts_rtol / 100)")
    parser.add_argument("--time-limit", metavar="S", type=positive(float), default=None,
                        help="seconds a run may take (default: 20 times the fastest so far, at least 30)")
    parser.add_argument("--udar", metavar="PATH", default=None,
                        help="the program (default: build/udar, else from the PATH)")
    parser.add_argument("--launcher", metavar="TEXT", default="mpirun -n {ranks}",
                        help="how to start it (default: 'mpirun -n {ranks}')")
    parser.add_argument("--output", metavar="DIR", type=pathlib.Path, default=pathlib.Path("out/tuning"),
                        help="where everything goes (default: out/tuning)")
    options = parser.parse_args(arguments)
    if options.options is None:
        options.options = words("" if options.case else OWN_OPTIONS)
    options.case = options.case or OWN_CASE
    if not options.case.is_file():
        raise UserError(f"{options.case}: no such case file")
    if options.sets is None:
        options.sets = sorted(TOP.glob("petsc-options/*.opts")) + sorted(HERE.glob("*.opts"))
    options.sets = read_sets(options.sets)
    options.reference = read_set(options.reference) if options.reference else None
    options.udar = find_program(options.udar)
    try:
        launch = shlex.split(options.launcher.format(ranks=1))
    except (ValueError, KeyError, IndexError) as error:
        raise UserError(f"--launcher: '{options.launcher}' cannot be used: {error}") from None
    if "{ranks}" not in options.launcher and options.ranks != [1]:
        raise UserError(f"--launcher: '{options.launcher}' has no {{ranks}}, needed for --ranks other than 1")
    if launch and not shutil.which(launch[0]):
        raise UserError(f"--launcher: there is no program '{launch[0]}'")
    return options


def find_program(given):
    candidates = [given] if given else [TOP / "build" / "udar", shutil.which("udar")]
    for candidate in filter(None, candidates):
        if os.access(candidate, os.X_OK) and pathlib.Path(candidate).is_file():
            return pathlib.Path(candidate).resolve()
    raise UserError(f"--udar: {given} is not a program" if given else
                    "no build/udar and no udar in the PATH: give --udar")


def tune(options, command):
    now = datetime.datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %z")
    options.output.mkdir(parents=True, exist_ok=True)
    for name in ("best.opts", "tuning.csv", "tuning.json", "tuning.png", "tuning.svg"):
        (options.output / name).unlink(missing_ok=True)  # of an earlier call: a call that fails leaves no winner
    runner = Runner(options)
    print(f"case:      {options.case} {shlex.join(options.options)}")
    reference = make_reference(runner, options.reference, options.ranks[0])
    print(f"reference: {reference.text}", flush=True)
    if reference.error.value > options.tolerance:
        raise UserError(
            f"no reference: it is known to {reference.error} only, --tolerance is {options.tolerance:g}. Impacts with "
            "restitution 1 multiply errors: end earlier (-ts_max_time), raise --tolerance "
            "or name a tighter --reference")
    if reference.error.value > options.tolerance / 10:
        print("note:      the reference's own error is more than a tenth of the tolerance")

    trials = [Trial(one, ranks) for ranks in options.ranks for one in options.sets]
    measure(runner, trials, reference, options.repeats)
    for trial in trials:
        judge(trial, options.tolerance, runner.fixed)
    trials.sort(key=order)
    print("\n" + table(trials) + "\n")

    best = trials[0] if trials[0].verdict == QUALIFIED else None
    record = {
        "command": command, "date": now, "case": str(options.case), "options": options.options,
        "udar": reference.result.summary["versions"], "repeats": options.repeats, "tolerance": options.tolerance,
        "reference": {"text": reference.text, "rtol": reference.rtol, "check_rtol": reference.check_rtol,
                      "error": reference.error.value, "scales": scales(reference.result)},
        "trials": [trial.row() for trial in trials], "best": None}
    if best:
        path = options.output / "best.opts"
        write_best(path, best, reference, runner, command, now)
        again = confirm(runner, best, path, options.tolerance)
        record["best"] = {**best.row(), "again": {"difference": again[0].value, "seconds": again[1].seconds}}
        close = [trial.label for trial in trials[1:]
                 if trial.verdict == QUALIFIED and min(trial.seconds) <= max(best.seconds)]
        print(f"best:      {best.label}, {best.median:.3g} s, error {best.error}")
        if close:
            print(f"           not told apart from it by these times: {', '.join(close)}")
        print(f"again:     with best.opts {again[1].seconds:.3g} s, difference to the winning run {again[0]}")
    write_csv(options.output / "tuning.csv", trials)
    (options.output / "tuning.json").write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    written = [options.output / name for name in ("tuning.csv", "tuning.json")]
    case_title = f"{options.case.parent.name}/{options.case.name}, {options.repeats} runs each"
    written += draw(options.output, trials, reference, options.tolerance, case_title)
    print("written:   " + " ".join(str(path) for path in [*written, *([options.output / "best.opts"] if best else [])]))
    if not best:
        raise UserError("no set qualifies: none runs to its end within the tolerance, see the verdicts above")


def confirm(runner, best, path, tolerance):
    """The file as written must be accepted and give what the winner gave."""
    try:
        result = runner.run("best", best.ranks, ["-options_file", str(path)])
        difference = distance(result, best.results[0])
    except RunFailed as failure:
        path.unlink()
        raise UserError(f"best.opts was written but its run failed: {failure}") from None
    if not difference.value <= tolerance:
        path.unlink()
        raise UserError(f"best.opts gives other curves than the winner: {difference}")
    return difference, result


def main(arguments):
    command = shlex.join([os.path.basename(__file__), *arguments])
    try:
        options = parse(arguments)
    except UserError as problem:
        print(f"tune.py: error: {problem}", file=sys.stderr)
        return 2
    try:
        tune(options, command)
    except (UserError, OSError) as problem:
        print(f"tune.py: error: {problem}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("tune.py: stopped", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
