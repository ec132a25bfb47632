"""Networks: a lattice that falls, on all ranks, and solves of nets whose members grow with the ranks.

A solve on P ranks is the members' sweeps, the product with a rank's rows of the interface's inverse, and a message of
all ranks; one to neighbours travels meanwhile. The first is measured on one rank; the others are counted and take what
the machine block says they cost.
"""

import math

import measure

NUMBERS = 6          # a junction and column
SOLVE_BYTES = 96.0   # a node and solve: displacements twice, stretches written and read
GRILLAGE = "grillage-10"
MEMBERS = 180        # of it
SIDES = (30, 100, 300)  # junctions along a side of the square nets beyond what was measured


def lattice_points(side, ranks):
    members = 3 * side * side * (side - 1)
    options = ["-network_lattice", f"{side},{side},{side}", "-filter_check_interval", "0"]
    return [{"series": "lattice", "case": "lattice.yaml", "elements": 8 * members, "ranks": count, "length": 0.0,
             "check_interval": 0, "options": options} for count in ranks]


def run(programs, settings, log):
    """All repeats in turn: [lattice's points, solves by number of ranks]."""
    ranks = settings["ranks"]
    points = lattice_points(settings["lattice"], ranks)
    summaries = [[] for _ in points]
    solves = {count: [] for count in ranks}
    tiny = {}
    for repeat in range(settings["repeats"]):
        for point, runs in zip(points, summaries):
            small = programs.run(point["ranks"], "lattice.yaml", ["-network_lattice", "3,3,3", "-ts_max_time", "0.01"])
            tiny.setdefault(point["ranks"], []).append(small["peak_memory_bytes"])
            runs.append(programs.run(point["ranks"], point["case"], point["options"]))
            log(f"  {repeat + 1}/{settings['repeats']}  lattice N = {point['elements']:<10} ranks = "
                f"{point['ranks']:<5} {runs[-1]['wall_seconds']['stepping']:8.2f} s")
        for count in ranks:
            solves[count].append(programs.network(count, GRILLAGE, settings["member_elements"] * count,
                                                  settings["machine_repeats"]))
    records = [measure.record(point, runs, measure.spread(tiny[point["ranks"]])["median"])
               for point, runs in zip(points, summaries)]
    measure.compare(records)
    return {"lattice": records, "solves": [solve_record(count, found) for count, found in sorted(solves.items())]}


def solve_record(ranks, found):
    seconds = measure.spread([entry["nodes"] * entry["nanoseconds_per_node"] * 1e-9 for entry in found])
    return {"ranks": ranks, "nodes": found[0]["nodes"], "elements": found[0]["elements"],
            "junctions": found[0]["junctions"], "interface": found[0]["interface_junctions"], "seconds": seconds}


class Model:
    """Seconds of a solve of one column."""

    def __init__(self, networks, machine):
        one = networks["solves"][0]
        self.per_node = one["seconds"]["median"] / one["nodes"]
        self.footprint = SOLVE_BYTES * one["nodes"]
        self.machine = machine
        parted = [entry for entry in networks["solves"] if entry["ranks"] > 1]
        # A cut through a square net of side^2 junctions in P parts of one size passes constant side sqrt(P) of them.
        side = math.sqrt(one["junctions"])
        self.cut = max((e["interface"] / (side * math.sqrt(e["ranks"])) for e in parted), default=1.0)

    def parts(self, nodes, ranks, interface, like=None):
        """By what takes them, with cores and messages as measured on `like` ranks, by default as many. A junction of
        the interface is that of two ranks."""
        like = like or ranks
        slow = self.machine.bandwidth(1, self.footprint) / self.machine.bandwidth(like, self.footprint)
        found = {"members": nodes / ranks * self.per_node * slow}
        if ranks > 1:
            like = max(like, 2)
            block = self.machine.block(like)
            rows = NUMBERS * min(interface, 2.0 * interface / ranks)
            found["interface"] = 2.0 * rows * NUMBERS * interface / block["flops_per_rank"]
            told = 8.0 * (NUMBERS + NUMBERS / 2.0) * interface / block["message"]["bandwidth"]
            found["messages"] = block["gather_seconds"]["median"] * math.log2(ranks) / math.log2(like) + told
        return found

    def seconds(self, entry):
        return sum(self.parts(entry["nodes"], entry["ranks"], entry["interface"]).values())

    def limit(self, side, elements):
        """A square net on more and more ranks: how many have an efficiency above one half, and what bounds it."""
        members = 2 * side * (side - 1)
        nodes = members * (elements - 1) + side * side
        ladder = sorted({round(10 ** (0.05 * k)) for k in range(121)})
        last, bound = 1, "members"
        for ranks in ladder[1:]:
            interface = min(side * side, self.cut * side * math.sqrt(ranks))
            parts = self.parts(nodes, ranks, interface, min(ranks, self.machine.most_exclusive))
            # A member is on one rank: the fullest has a whole number of them.
            share = math.ceil(members / ranks) / (members / ranks)
            parts["whole members"] = parts["members"] * (share - 1.0)
            efficiency = nodes * self.per_node / ranks / sum(parts.values())
            if efficiency < 0.5:
                bound = max((name for name in parts if name != "members"), key=parts.get)
                break
            last = ranks
        return {"side": side, "elements": elements, "nodes": nodes, "ranks_at_half": last, "bound": bound}


def text(networks, machine):
    """The tables: the lattice, solves that grow with the ranks, and how far the model carries them."""
    lines = ["networks", f"{'lattice':>8} {'elements':>9} {'ranks':>5} {'steps':>5} {'impacts':>8} {'solves':>7} "
             f"{'stepping':>9} {'low .. high':>17} {'speedup':>8} {'B/elem':>7} {'equal':>12}",
             f"{'':>8} {'':>9} {'':>5} {'':>5} {'':>8} {'':>7} {'s':>9} {'s':>17}"]
    first = networks["lattice"][0]["seconds"]["stepping"]["median"]
    for point in networks["lattice"]:
        seconds, counts = point["seconds"]["stepping"], point["counts"]
        equal = "" if point["equal"] is None else f"{'' if point['equal'] else 'WRONG '}{point['difference']:.0e}"
        lines.append(f"{'':>8} {point['elements']:>9} {point['ranks']:>5} {counts['steps']:>5} {counts['impacts']:>8} "
                     f"{counts['line_solves']:>7} {seconds['median']:>9.3g} "
                     f"{seconds['low']:>7.3g} .. {seconds['high']:<6.3g} {first / seconds['median']:>8.2f} "
                     f"{point['bytes_per_element']:>7.0f} {equal:>12}")
    model = Model(networks, machine)
    lines += ["", f"{'solve':>8} {'nodes':>9} {'ranks':>5} {'elements':>8} {'interface':>9} {'ms':>8} "
              f"{'low .. high':>17} {'model':>8} {'effic.':>6}"]
    one = networks["solves"][0]["seconds"]["median"]
    for entry in networks["solves"]:
        seconds = entry["seconds"]
        lines.append(f"{'':>8} {entry['nodes']:>9} {entry['ranks']:>5} {entry['elements']:>8} {entry['interface']:>9} "
                     f"{1e3 * seconds['median']:>8.3g} {1e3 * seconds['low']:>7.3g} .. {1e3 * seconds['high']:<6.3g} "
                     f"{1e3 * model.seconds(entry):>8.3g} {one / seconds['median']:>6.2f}")
    if len(networks["solves"]) > 1:
        lines += ["", "square nets beyond what was measured, by the model:"]
        for side in SIDES:
            for elements in (16, 1024):
                row = model.limit(side, elements)
                lines.append(f"{side:>5} x {side:<4} {elements:>5} elements a member, {row['nodes']:>9} nodes: above "
                             f"one half up to {row['ranks_at_half']} ranks; bound there: {row['bound']}")
    return lines
