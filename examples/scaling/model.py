"""The cost model: what a run must compute, move and tell, times what the machine block says these cost.

Constants of the machine (triad bandwidth by footprint, messages, reductions, flops) come from `udar-bench -bench_kind
machine`; a few constants of the kernels are fitted to the points of FITTED and to no other.
"""

import itertools
import math

import numpy as np

FITTED = "every second point of the growth series and of the pipelines on one rank; output: strong scaling on the " \
         "fewest and the most ranks, too; batch: one rank"
STAGES = ("line_solve", "local_motion", "output", "other")
SOLVE_BYTES = 26.0    # a node and solve (docs/theory.md, "Stretches")
MOTION_BYTES = 176.0  # a node and sweep besides the solves (docs/theory.md, "The impact integrator")
OTHER_BYTES = 400.0   # a node and step: new step's polynomial, start and end of a step
WORKING_SET = 200.0   # bytes a node that a step comes back to
CHECK_INTERVAL = 50   # solves between two checks of the residual (-filter_check_interval), unless a point says
DECAY = {"floor.yaml": 2.27, "pipeline.yaml": 6.0}  # m: (4 EI / rhoA wf^2)^(1/4)
LENGTHS_TO_NOTHING = 39.0  # exp(-39) = 1e-17: beyond, ranks talk to neighbours alone
WIDTH = 16            # numbers that a joint shows for four columns


def checks_among(solves, point):
    interval = point.get("check_interval", CHECK_INTERVAL)
    return solves / interval if interval > 0 else 0.0


def batches(point):
    """Line solves count four at a time: sweeps, rows of output, start and loads; a residual check splits one."""
    counts = point["counts"]
    checks = int(checks_among(counts["line_solves"], point))
    return counts["sweeps"] + counts["rows"] + 3 + 2 * checks, checks


def neighbours_only(point):
    return point["ranks"] == 2 or point["length"] / point["ranks"] > LENGTHS_TO_NOTHING * DECAY[point["case"]]


def communication(point):
    """Messages and reductions of a rank with two neighbours in the stepping, output left out, from the algorithm."""
    ranks, counts = point["ranks"], point["counts"]
    if ranks == 1:
        return {"messages": 0.0, "reductions": 0.0, "gathers": 0.0}
    # Of the residual, those that do not fall into output: four norms and, with PETSc 3.18 but not with 3.22, four
    # meetings to make its vectors.
    meetings = 4 if point.get("petsc", [3, 18]) < [3, 22] else 0
    checks = checks_among(counts["line_solves"] - counts["rows"], point)
    flights = 2 * counts.get("rigid_flights", 0)  # two solves, and two reductions: where it ends, whether it is rigid
    solves = counts["sweeps"] + 2 + 2 * checks + flights  # the start and the loads are solved for, too
    sides = 1.0 if ranks == 2 else 2.0
    near = neighbours_only(point)
    return {"messages": solves * (0.5 * sides + (sides if near else 0.0)) + sides * 2 * checks,
            "reductions": counts["sweeps"] + counts["steps"] + counts["event_steps"] + flights +
            (5 + meetings) * checks,
            "gathers": 0.0 if near else float(solves)}


class Machine:
    """The machine blocks by number of ranks."""

    def __init__(self, blocks):
        self.blocks = {int(ranks): block for ranks, block in blocks.items()}
        self.most_exclusive = max([ranks for ranks, block in self.blocks.items() if not self.shared(block)] or [1])

    @staticmethod
    def shared(block):
        return block["ranks_per_host"] > block["cores_per_host"]

    def block(self, ranks):
        return self.blocks[ranks]

    def turns(self, ranks):
        """How many ranks take turns on a core: one that waits gives it away, so the work of all is what counts."""
        block = self.blocks[ranks]
        return max(1.0, block["ranks_per_host"] / block["cores_per_host"])

    def exclusive(self, ranks):
        """The number of ranks whose block says what the cores of these can do."""
        return ranks if ranks == 1 or self.turns(ranks) == 1.0 else self.most_exclusive

    def bandwidth(self, ranks, footprint):
        """Of one rank, all ranks at work [bytes/s]; footprint in bytes per rank. A core's cache serves its ranks."""
        turns, alike = self.turns(ranks), self.exclusive(ranks)
        table = self.blocks[alike]["triad"]
        sizes = np.log([row["bytes_per_rank"] for row in table])
        place = math.log(max(footprint * turns, 1.0))
        return float(np.interp(place, sizes, [row["bandwidth"] for row in table])) / alike / turns

    def slowdown(self, ranks):
        """Of work on data in the nearest cache, by ranks that take turns and by what cores that all work share."""
        alike = self.exclusive(ranks)
        first = [self.blocks[count]["triad"][0]["bandwidth"] / count for count in (1, alike)]
        return self.turns(ranks) * first[0] / first[1]

    def reduction(self, ranks):
        return self.blocks[ranks]["reduction_seconds"]["step"]["median"] if ranks > 1 else 0.0

    def reduction_law(self):
        """a + b log2 P through the reductions of all ranks that have a core each [s]."""
        known = [(ranks, block["reduction_seconds"]["sweep"]["median"]) for ranks, block in sorted(self.blocks.items())
                 if ranks > 1 and (not self.shared(block) or ranks == 2)]  # two at least, were they to share a core
        if not known:
            return None
        levels = np.array([math.log2(ranks) for ranks, _ in known])
        seconds = np.array([value for _, value in known])
        if len(known) == 1:
            return 0.0, float(seconds[0] / levels[0])
        b, a = np.polyfit(levels, seconds, 1)
        if b <= 0.0 or a < 0.0:
            return 0.0, float(levels @ seconds / (levels @ levels))
        return float(a), float(b)


def non_negative(columns, values):
    """Least squares of relative errors with constants >= 0: the best of all subsets of the few columns."""
    columns = np.asarray(columns, dtype=float)
    scaled = columns / np.asarray(values)[:, None]
    best, found = math.inf, np.zeros(columns.shape[1])
    for count in range(1, columns.shape[1] + 1):
        for chosen in itertools.combinations(range(columns.shape[1]), count):
            part = scaled[:, chosen]
            if len(values) < count:
                continue
            solution, *_ = np.linalg.lstsq(part, np.ones(len(values)), rcond=None)
            error = float(np.sum((part @ solution - 1.0) ** 2))
            if np.all(solution >= 0.0) and error < best * (1.0 - 1e-9):
                best, found = error, np.zeros(columns.shape[1])
                found[list(chosen)] = solution
    return found


class Model:
    def __init__(self, result):
        self.machine = Machine(result["machine"])
        growth = sorted((p for p in result["points"] if p["series"] == "growth"), key=lambda p: p["elements"])
        single = sorted((p for p in result["points"] if p["case"] == "pipeline.yaml" and p["ranks"] == 1),
                        key=lambda p: p["elements"])
        self.fitted = growth[::2] + single[::2]
        strong = sorted((p for p in result["points"] if p["series"] == "strong" and p["ranks"] > 1),
                        key=lambda p: p["ranks"])
        ends = strong[:1] + strong[1:][-1:]  # one rank cannot tell what several pay for one file
        self.constants = {}
        for stage in STAGES:
            points = self.fitted + (ends if stage == "output" else [])
            values = [self.measured(point, stage) for point in points]
            self.constants[stage] = non_negative([self.columns(point, stage) for point in points], values)
        self.fitted += ends
        self.batch_rate = next((b["beams_per_second"]["median"] for b in result["batch"] if b["ranks"] == 1), None)

    @staticmethod
    def measured(point, stage):
        own = {name: value["median"] for name, value in point["own_seconds"].items()}
        if stage != "other":
            return own[stage]
        return sum(value for name, value in own.items() if name not in STAGES) + own["other"]

    def columns(self, point, stage, rate=None, slow=None):
        """What a stage does on one rank, in units of its constants."""
        counts, ranks = point["counts"], point["ranks"]
        nodes = point["elements"] / ranks
        per_byte = 1.0 / (rate or self.machine.bandwidth(ranks, WORKING_SET * nodes))
        slow = slow or self.machine.slowdown(ranks)
        calls = counts["sweeps"] + counts["steps"]
        if stage == "line_solve":
            solves = counts["line_solves"]
            return np.array([batches(point)[0] * slow, solves * nodes * slow, solves * nodes * SOLVE_BYTES * per_byte])
        if stage == "local_motion":
            return np.array([calls * slow, calls * nodes * slow, calls * nodes * MOTION_BYTES * per_byte,
                             counts["impacts"] / ranks * slow])
        if stage == "output":
            # Computing a row; bytes into one file, impacts with them; meetings of the ranks.
            return np.array([slow, nodes * slow, float(point["elements"]), self.machine.reduction(ranks)])
        return np.array([counts["steps"] * slow, counts["steps"] * nodes * slow,
                         counts["steps"] * nodes * OTHER_BYTES * per_byte, counts["impacts"] / ranks * slow])

    def parts(self, point):
        """Seconds of the stepping by part."""
        found = {stage: float(self.columns(point, stage) @ self.constants[stage]) for stage in STAGES}
        if point["ranks"] > 1:
            block = self.machine.block(point["ranks"])
            told = communication(point)
            solves, _ = batches(point)
            step = block["reduction_seconds"]["step"]["median"]
            found["reductions"] = (point["counts"]["sweeps"] * block["reduction_seconds"]["sweep"]["median"]
                                   + (told["reductions"] - point["counts"]["sweeps"]) * step)
            joint = block["exchange_seconds"]["median"] if told["gathers"] == 0.0 else block["gather_seconds"]["median"]
            found["joints"] = solves * (block["message"]["latency"]["median"] + joint)
        return found

    def seconds(self, point):
        return sum(self.parts(point).values())

    def bound(self, point):
        """The roofline: seconds that the bytes a run must move would take at the triad's bandwidth."""
        counts, nodes = point["counts"], point["elements"] / point["ranks"]
        streamed = point.get("streamed_bytes")
        if streamed is None:
            streamed = point["elements"] * (counts["line_solves"] * SOLVE_BYTES
                                            + (counts["sweeps"] + counts["steps"]) * MOTION_BYTES)
        return streamed / (point["ranks"] * self.machine.bandwidth(point["ranks"], WORKING_SET * nodes))

    def is_fitted(self, point):
        return any(point is other for other in self.fitted)

    def batch(self, batch):
        if self.batch_rate is None:
            return None
        return self.batch_rate * batch["ranks"] / self.machine.slowdown(batch["ranks"])

    # Beyond what was measured

    def beyond(self, template, elements, ranks):
        """Parts of one step of a pipeline of so many elements on so many ranks [s], output left out."""
        nodes = elements / ranks
        full = self.machine.most_exclusive
        counts = dict(template["counts"])
        counts["impacts"] = template["counts"]["impacts"] * elements / template["elements"]
        point = {**template, "elements": elements, "ranks": ranks, "counts": counts,
                 "length": template["length"] * elements / template["elements"]}
        rate = self.machine.bandwidth(full, WORKING_SET * nodes)
        parts = {stage: float(self.columns(point, stage, rate, self.machine.slowdown(full)) @ self.constants[stage])
                 for stage in STAGES if stage != "output"}
        slowdown = self.machine.slowdown(full)
        overhead = sum(float(self.columns(point, stage, rate, slowdown)[0] * self.constants[stage][0])
                       for stage in STAGES if stage != "output")
        found = {"computing and memory": sum(parts.values()) - overhead, "calls": overhead}
        law = self.machine.reduction_law()
        if ranks > 1 and law is not None:
            block = self.machine.block(full if full > 1 else 2)
            latency, bandwidth = block["message"]["latency"]["median"], block["message"]["bandwidth"]
            reduction = law[0] + law[1] * math.log2(ranks)
            told = communication(point)
            solves, _ = batches(point)
            found["reductions"] = told["reductions"] * reduction
            found["messages"] = solves * latency
            if told["gathers"]:
                work = 2.0 * 16.0 * 4.0 * ranks / block["flops_per_rank"]  # four rows over what all ranks show
                found["joints of all ranks"] = solves * (reduction + 8.0 * WIDTH * ranks / bandwidth + work)
            else:
                found["messages"] += solves * 2.0 * latency
        return {name: value / counts["steps"] for name, value in found.items()}

    def limits(self, template, sizes=(1e6, 1e7, 1e8, 1e9, 1e10), most=10_000):
        """For each size: efficiency at `most` ranks, the most ranks above one half, and what bounds it there."""
        rows = []
        for elements in sizes:
            one = sum(self.beyond(template, elements, 1).values())

            def efficiency(ranks, elements=elements, one=one):
                return one / (ranks * sum(self.beyond(template, elements, ranks).values()))

            ladder = sorted({round(10 ** (0.05 * k)) for k in range(121)})
            good = [ranks for ranks in ladder if ranks * 4 <= elements and efficiency(ranks) >= 0.5]
            last = max(good)
            beyond = ladder[ladder.index(last) + 1] if last != ladder[-1] else last
            parts = self.beyond(template, elements, beyond)
            bound = max((name for name in parts if name != "computing and memory"), key=parts.get)
            parts = self.beyond(template, elements, most)
            rows.append({"elements": elements, "ranks_at_half": last, "at_the_end_of_the_ladder": last == ladder[-1],
                         "bound": bound, "seconds_per_step": sum(parts.values()), "parts": parts,
                         "efficiency": efficiency(most),
                         "memory_per_rank": elements / most * template["bytes_per_element"]})
        return rows


def check(result):
    """Errors of the prediction: [point, measured, predicted, relative error, fitted or not]."""
    model = Model(result)
    rows = []
    for point in result["points"]:
        measured, predicted = point["seconds"]["stepping"]["median"], model.seconds(point)
        rows.append({"series": point["series"], "elements": point["elements"], "ranks": point["ranks"],
                     "measured": measured, "predicted": predicted, "error": predicted / measured - 1.0,
                     "fitted": model.is_fitted(point)})
    for batch in result["batch"]:
        predicted = model.batch(batch)
        if predicted is not None:
            measured = batch["beams_per_second"]["median"]
            rows.append({"series": "batch", "elements": batch["elements"], "ranks": batch["ranks"],
                         "measured": measured,
                         "predicted": predicted, "error": predicted / measured - 1.0, "fitted": batch["ranks"] == 1})
    return model, rows
