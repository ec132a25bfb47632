"""Runs udar and udar-bench and keeps what they tell: one record for every point of every series."""

import csv
import json
import os
import pathlib
import shlex
import shutil
import subprocess
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ELEMENT = 0.5       # m, of the pipeline
SPACING = 250.0     # m, between its supports
AGREEMENT = 1e-9    # relative, of energies and impulses on any number of ranks
TINY = 200          # elements of the run whose memory is the programs' and libraries' own


class Failure(Exception):
    """Something the user must mend; its text is the line that is printed."""


def spread(values):
    """Median, least and greatest."""
    ordered = sorted(values)
    half = len(ordered) // 2
    median = ordered[half] if len(ordered) % 2 else 0.5 * (ordered[half - 1] + ordered[half])
    return {"median": median, "low": ordered[0], "high": ordered[-1]}


def middle(blocks):
    """One value out of several of the same form: medians of numbers, the first of all else."""
    first = blocks[0]
    if isinstance(first, dict):
        return {key: middle([block[key] for block in blocks]) for key in first}
    if isinstance(first, list):
        return [middle(list(row)) for row in zip(*blocks)]
    if isinstance(first, float):
        return spread(blocks)["median"]
    return first


class Programs:
    """How the programs are started, and where they may write."""

    def __init__(self, udar, bench, launcher, scratch):
        self.udar, self.bench, self.launcher, self.scratch = udar, bench, launcher, pathlib.Path(scratch)

    def _call(self, ranks, program, options):
        line = shlex.split(self.launcher.format(ranks=ranks)) + [str(program), "-skip_petscrc"] + options
        begin = time.perf_counter()
        found = subprocess.run(line, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
        if found.returncode != 0:
            raise Failure(f"exit code {found.returncode} of: {shlex.join(line)}\n{found.stderr[-2000:]}")
        return found.stdout, time.perf_counter() - begin

    def machine(self, ranks, largest, repeats):
        options = ["-bench_kind", "machine", "-bench_repeats", str(repeats), "-bench_largest", str(largest)]
        return json.loads(self._call(ranks, self.bench, options)[0])

    def batch(self, ranks, beams, elements):
        options = ["-options_file", str(HERE / "floor.yaml"), "-beam_elements", str(elements), "-bench_kind", "batch",
                   "-bench_beams", str(beams)]
        return json.loads(self._call(ranks, self.bench, options)[0])

    def network(self, ranks, structure, elements, repeats):
        """Solves of a regular network by all ranks."""
        options = ["-bench_kind", "network", "-bench_networks", structure, "-bench_member_elements", str(elements),
                   "-bench_largest_frame", "0", "-bench_repeats", str(repeats), "-bench_partition", "metis"]
        return json.loads(self._call(ranks, self.bench, options)[0])[0]

    def run(self, ranks, case, options):
        """One run of udar: its summary, and the energies of the last row."""
        with tempfile.TemporaryDirectory(dir=self.scratch) as folder:
            out = pathlib.Path(folder) / "run"
            line = ["-options_file", str(HERE / case), "-output_directory", str(out)] + options
            self._call(ranks, self.udar, line)
            summary = json.loads((out / "summary.json").read_text())
            with (out / "energy.csv").open() as rows:
                *_, last = csv.DictReader(rows)
            summary["energy"] = {name: float(last[name]) for name in ("kinetic", "total", "lost_in_impacts")}
        return summary


def floor_point(series, elements, ranks):
    return {"series": series, "case": "floor.yaml", "elements": elements, "ranks": ranks, "length": 10.0,
            "options": ["-beam_elements", str(elements)]}


def pipeline_point(series, per_rank, pieces, ranks, scratch):
    """`pieces` times `per_rank` elements; the supports are a file, for there may be very many."""
    elements = per_rank * pieces
    length = elements * ELEMENT
    supports = pathlib.Path(scratch) / f"supports-{elements}.yaml"
    count = max(1, round(length / SPACING))
    positions = ", ".join(f"{(index + 0.5) * length / count:.10g}" for index in range(count))
    supports.write_text(f"beam: {{length: {length}, elements: {elements}}}\nsupport: {{position: [{positions}]}}\n")
    return {"series": series, "case": "pipeline.yaml", "elements": elements, "ranks": ranks, "length": length,
            "options": ["-options_file", str(supports)]}


def plan(sizes, ranks, strong, per_rank, check_interval, scratch):
    """All points: growth on one rank, strong and weak scaling, and the weak cases on one rank for comparison."""
    points = [floor_point("growth", size, 1) for size in sizes]
    points += [floor_point("strong", strong, count) for count in ranks]
    points += [pipeline_point("weak", per_rank, count, count, scratch) for count in ranks]
    points += [pipeline_point("alone", per_rank, count, 1, scratch) for count in ranks if count > 1]
    for point in points:
        point["check_interval"] = check_interval
        point["options"] += ["-filter_check_interval", str(check_interval)]
    return points


def invariants(summary):
    return {"end_time": summary["end_time"], "impacts": summary["impacts"], "rests": summary["rests"],
            "energy": summary["energy"], "support_impulse": summary["support_impulse"]}


def difference(one, other):
    """Largest relative difference of two results; infinite where counts differ."""
    if (one["impacts"], one["end_time"]) != (other["impacts"], other["end_time"]):
        return float("inf")
    scale = max(abs(value) for value in one["energy"].values())
    worst = max(abs(one["energy"][name] - other["energy"][name]) / scale for name in one["energy"])
    largest = max((abs(value) for value in one["support_impulse"]), default=0.0)
    if largest > 0.0:
        pairs = zip(one["support_impulse"], other["support_impulse"])
        worst = max([worst] + [abs(a - b) / largest for a, b in pairs])
    return worst


def record(point, summaries, tiny_memory):
    """What several runs of one point come to."""
    def over(key):
        return {stage: spread([run[key][stage] for run in summaries]) for stage in summaries[0][key]}

    first = summaries[0]
    steps = first["steps"]
    mean = over("wall_seconds_mean")
    kept = {key: point[key] for key in ("series", "case", "elements", "ranks", "length", "check_interval")}
    kept["options"] = [option for option in point["options"] if not option.endswith(".yaml")]
    kept["repeats"] = len(summaries)
    kept["petsc"] = [int(word) for word in first["versions"]["petsc"].split(".")]
    kept["seconds"] = over("wall_seconds")
    kept["own_seconds"] = over("own_seconds")
    kept["imbalance"] = {stage: value["median"] / mean[stage]["median"] if mean[stage]["median"] > 0.0 else 1.0
                         for stage, value in kept["seconds"].items()}
    kept["counts"] = {"steps": steps, "rejected_steps": first["rejected_steps"],
                      "line_solves": first["stepping_line_solves"],
                      "sweeps": first["integrator_counts"].get("sweeps", 0),
                      "rigid_flights": first["integrator_counts"].get("rigid_flights", 0), "impacts": first["impacts"],
                      "event_steps": first["event_steps"],
                      "rows": first["row_line_solves"]}  # and samples of extremes between rows
    kept["per_step"] = {stage: {name: value / steps for name, value in counts.items()}
                        for stage, counts in first["communication"].items()}
    # What the steps themselves tell: output, by its own schedule, taken off.
    kept["per_step"]["without_output"] = {
        name: value - kept["per_step"]["output"][name] for name, value in kept["per_step"]["stepping"].items()}
    memory = spread([run["peak_memory_bytes"] for run in summaries])["median"]
    kept["bytes_per_element"] = max(0.0, memory - tiny_memory) / point["elements"]
    kept["memory_per_rank"] = first["memory_per_rank"]
    kept["streamed_bytes"] = first.get("streamed_bytes")
    kept["invariants"] = invariants(first)
    kept["same_counts"] = len({json.dumps(invariants(run)["impacts"]) for run in summaries}) == 1
    return kept


def measure(programs, points, batches, settings, log):
    """All repeats of all points in turn, with the machine measured beside them."""
    summaries = [[] for _ in points]
    batch_runs = [[] for _ in batches]
    machines = {}
    tiny = {}
    spent = [0.0] * len(points)
    ranks = sorted({point["ranks"] for point in points} | {batch["ranks"] for batch in batches})
    for repeat in range(settings["repeats"]):
        for count in ranks:
            found = programs.machine(count, settings["largest_footprint"], settings["machine_repeats"])
            machines.setdefault(str(count), []).append(found)
            memory = programs.run(count, "floor.yaml", ["-beam_elements", str(max(TINY, 2 * count))])
            tiny.setdefault(count, []).append(memory["peak_memory_bytes"])
        for index, point in enumerate(points):
            if spent[index] > settings["budget"]:
                continue
            begin = time.perf_counter()
            summaries[index].append(programs.run(point["ranks"], point["case"], point["options"]))
            spent[index] += time.perf_counter() - begin
            log(f"  {repeat + 1}/{settings['repeats']}  {point['series']:7} N = {point['elements']:<10} "
                f"ranks = {point['ranks']:<5} {time.perf_counter() - begin:8.2f} s")
        for index, batch in enumerate(batches):
            batch_runs[index].append(programs.batch(**batch))
    records = [record(point, runs, spread(tiny[point["ranks"]])["median"]) for point, runs in zip(points, summaries)]
    compare(records)
    batch_records = []
    for batch, runs in zip(batches, batch_runs):
        rate = spread([run["beams_per_second"] for run in runs])
        batch_records.append({"series": "batch", **batch, "groups": runs[0]["groups"], "repeats": len(runs),
                              "beams_per_second": rate, "seconds_per_beam": runs[0]["seconds_per_beam"],
                              "line_solves": runs[0]["line_solves"], "impacts": runs[0]["impacts"]})
    return records, batch_records, {count: middle(blocks) for count, blocks in machines.items()}, \
        summaries[0][0]["versions"]


def compare(records):
    """Enters how far each result is from that of one rank: strong from its first, weak from its twin alone."""
    alone = {(entry["case"], entry["elements"]): entry for entry in records
             if entry["ranks"] == 1 and entry["series"] != "growth"}
    alone.update({key: entry for entry in records
                  if entry["ranks"] == 1 and (key := (entry["case"], entry["elements"])) not in alone})
    for entry in records:
        twin = alone.get((entry["case"], entry["elements"])) if entry["ranks"] > 1 else None
        entry["difference"] = difference(twin["invariants"], entry["invariants"]) if twin else None
        entry["equal"] = entry["difference"] <= AGREEMENT and entry["same_counts"] if twin else None
    for entry in records:  # one number for each support is kept no longer than needed
        impulses = entry["invariants"].pop("support_impulse")
        entry["invariants"]["support_impulse_sum"] = sum(impulses)


def description():
    """The state of this checkout, if it is one and git is there."""
    if shutil.which("git") is None:
        return None
    found = subprocess.run(["git", "-C", str(HERE), "describe", "--always", "--dirty"], capture_output=True, text=True,
                           check=False)
    return found.stdout.strip() or None


def environment():
    """Beside scripts/env.sh, so that one forgotten `source` does not end the first day."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
