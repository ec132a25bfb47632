"""Tables of a result: text for people, CSV for programs."""

import csv

import model as cost
import networks

WRONG = "WRONG"


def efficiency(result, point):
    """Against one rank: strong for the same elements; weak for one rank's share, per step."""
    first = next((p for p in result["points"] if p["series"] == point["series"] and p["ranks"] == 1), None)
    if first is None or point["series"] not in ("strong", "weak"):
        return None
    if point["series"] == "strong":
        return per_step(first) / (point["ranks"] * per_step(point))
    return per_step(first) / per_step(point)


def per_step(point, which="median"):
    return point["seconds"]["stepping"][which] / point["counts"]["steps"]


def rows(result, model):
    """One flat row for every point."""
    found = []
    for point in result["points"]:
        told = cost.communication(point)
        counts, steps = point["counts"], point["counts"]["steps"]
        row = {"machine": result["name"], "series": point["series"], "elements": point["elements"],
               "ranks": point["ranks"], "repeats": point["repeats"], "steps": steps, "sweeps": counts["sweeps"],
               "line_solves": counts["line_solves"], "impacts": counts["impacts"],
               "total_s": point["seconds"]["total"]["median"], "stepping_s": point["seconds"]["stepping"]["median"],
               "step_s": per_step(point), "step_low_s": per_step(point, "low"), "step_high_s": per_step(point, "high"),
               "bound_s": model.bound(point) / steps, "model_s": model.seconds(point) / steps,
               "fitted": model.is_fitted(point),
               "solves_per_s": counts["line_solves"] / point["seconds"]["stepping"]["median"],
               "efficiency": efficiency(result, point), "bytes_per_element": point["bytes_per_element"],
               "messages_per_step": point["per_step"]["without_output"]["messages"],
               "message_bytes_per_step": point["per_step"]["without_output"]["message_bytes"],
               "reductions_per_step": point["per_step"]["without_output"]["reductions"],
               "model_messages_per_step": told["messages"] / steps,
               "model_reductions_per_step": (told["reductions"] + told["gathers"]) / steps,
               "imbalance": point["imbalance"]["local_motion"], "difference": point["difference"],
               "equal": point["equal"]}
        for stage, seconds in sorted(point["own_seconds"].items()):
            row[f"own_{stage}_s"] = seconds["median"]
        found.append(row)
    return found


def write_csv(path, table):
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]))
        writer.writeheader()
        writer.writerows({key: "" if value is None else value for key, value in row.items()} for row in table)


def machine_text(result):
    lines = [f"{'ranks':>6} {'cores':>6} {'triad 32 kB':>12} {'largest':>9} {'latency':>9} {'message':>9} {'sweep':>8} "
             f"{'gather':>8} {'flops':>9}", f"{'':>6} {'/host':>6} {'GB/s':>12} {'GB/s':>9} {'us':>9} {'GB/s':>9} "
             f"{'us':>8} {'us':>8} {'G/s rank':>9}"]
    for ranks, block in sorted(result["machine"].items(), key=lambda item: int(item[0])):
        triad = [row["bandwidth"] / 1e9 for row in block["triad"]]
        message = block["message"]
        told = [message["latency"]["median"] * 1e6, message["bandwidth"] / 1e9,
                block["reduction_seconds"]["sweep"]["median"] * 1e6,
                block["gather_seconds"]["median"] * 1e6] if message else [float("nan")] * 4
        lines.append(f"{ranks:>6} {block['cores_per_host']:>6} {triad[0]:>12.1f} {triad[-1]:>9.1f} {told[0]:>9.2f} "
                     f"{told[1]:>9.1f} {told[2]:>8.2f} {told[3]:>8.2f} {block['flops_per_rank'] / 1e9:>9.1f}")
    return lines


def table_text(result, model):
    head = (f"{'series':7} {'elements':>10} {'ranks':>5} {'steps':>5} {'impacts':>9} {'step':>10} {'low .. high':>19} "
            f"{'bound':>9} {'model':>9} {'solves/s':>9} {'effic.':>6} {'B/elem':>7} {'msg':>6} {'model':>6} {'red':>6} "
            f"{'model':>6} {'equal':>12}")
    units = f"{'':7} {'':>10} {'':>5} {'':>5} {'':>9} {'ms':>10} {'ms':>19} {'ms':>9} {'ms':>9}"
    lines = [head, units]
    for row in rows(result, model):
        equal = "" if row["equal"] is None else (f"{row['difference']:.0e}" if row["equal"] else
                                                 f"{WRONG} {row['difference']:.0e}")
        share = "" if row["efficiency"] is None else f"{row['efficiency']:.2f}"
        lines.append(
            f"{row['series']:7} {row['elements']:>10} {row['ranks']:>5} {row['steps']:>5} {row['impacts']:>9} "
            f"{1e3 * row['step_s']:>10.4g} {1e3 * row['step_low_s']:>8.4g} .. {1e3 * row['step_high_s']:<7.4g} "
            f"{1e3 * row['bound_s']:>9.3g} {1e3 * row['model_s']:>9.3g} {row['solves_per_s']:>9.3g} {share:>6} "
            f"{row['bytes_per_element']:>7.0f} {row['messages_per_step']:>6.2f} {row['model_messages_per_step']:>6.2f} "
            f"{row['reductions_per_step']:>6.2f} {row['model_reductions_per_step']:>6.2f} {equal:>12}")
    if result["batch"]:
        lines += ["", f"{'batch':7} {'elements':>10} {'ranks':>5} {'beams':>6} {'beams/s':>9} {'low .. high':>19}"]
        for batch in result["batch"]:
            rate = batch["beams_per_second"]
            lines.append(f"{'':7} {batch['elements']:>10} {batch['ranks']:>5} {batch['beams']:>6} "
                         f"{rate['median']:>9.4g} "
                         f"{rate['low']:>8.4g} .. {rate['high']:<8.4g}")
    return lines


def shares_text(result):
    """Share of the stepping by stage, stages within others taken off."""
    names = sorted(result["points"][0]["own_seconds"])
    lines = [f"{'series':7} {'elements':>10} {'ranks':>5} " + " ".join(f"{name:>12}" for name in names)]
    for point in result["points"]:
        total = sum(point["own_seconds"][name]["median"] for name in names)
        lines.append(f"{point['series']:7} {point['elements']:>10} {point['ranks']:>5} " + " ".join(
            f"{100 * point['own_seconds'][name]['median'] / total:>10.1f} %" for name in names))
    return lines


def mend(bound):
    return {"reductions": "fewer or overlapped reductions: one for two sweeps, or one that is awaited a sweep later",
            "messages": "more elements a rank; ranks of several threads each, so that fewer of them talk",
            "calls": "more elements a rank: what remains is the fixed cost of a call",
            "joints of all ranks": "longer pieces (neighbours alone), or a tree over the joints instead of one gather "
                                   "of all: log P numbers instead of P"}[bound]


def model_text(result):
    model, errors = cost.check(result)
    lines = [f"fitted: {cost.FITTED}", "", "constants >= 0 of the kernels, in seconds:"]
    names = {"line_solve": "a call, a node and solve, the bandwidth's share",
             "local_motion": "a call, a node and call, the bandwidth's share, an impact",
             "output": "once, a node, an element of the file, a reduction's time",
             "other": "a step, a node and step, the bandwidth's share, an impact"}
    for stage, values in model.constants.items():
        lines.append(f"  {stage:13} {', '.join(f'{value:.3g}' for value in values):45} ({names[stage]})")
    lines += ["", f"{'series':7} {'elements':>10} {'ranks':>5} {'measured':>10} {'predicted':>10} {'error':>7}"]
    for row in errors:
        lines.append(f"{row['series']:7} {row['elements']:>10} {row['ranks']:>5} {row['measured']:>10.4g} "
                     f"{row['predicted']:>10.4g} {100 * row['error']:>5.1f} %{'  fitted' if row['fitted'] else ''}")
    free = [row for row in errors if not row["fitted"]]
    if free:
        worst = max(free, key=lambda row: abs(row["error"]))
        within = sum(abs(row["error"]) <= 0.2 for row in free)
        lines += ["", f"largest error of a point that was not fitted: {100 * worst['error']:.1f} % ({worst['series']}, "
                  f"{worst['elements']} elements, {worst['ranks']} ranks); within 20 %: {within} of {len(free)}"]
    lines += [""] + extrapolation_text(result, model)
    return lines, errors


def extrapolation_text(result, model):
    law = model.machine.reduction_law()
    if law is None:
        return ["no extrapolation: measure two ranks at least"]
    template = template_of(result)
    lines = [f"pipeline of elements of 0.5 m beyond what was measured; reduction {law[0] * 1e6:.2f} + "
             f"{law[1] * 1e6:.2f} log2(ranks) us, output left out:",
             f"{'elements':>9} {'above one half up to':>21} {'bound there':>20} {'step on 10 000':>15} {'effic.':>7} "
             f"{'MB a rank':>10}"]
    limits = model.limits(template)
    for row in limits:
        ranks = ("more than " if row["at_the_end_of_the_ladder"] else "") + f"{row['ranks_at_half']} ranks"
        lines.append(f"{row['elements']:>9.0e} {ranks:>21} {row['bound']:>20} "
                     f"{1e6 * row['seconds_per_step']:>12.0f} us "
                     f"{row['efficiency']:>7.2f} {row['memory_per_rank'] / 1e6:>10.1f}")
    lines += ["what would have to change:"]
    lines += [f"  {bound}: {mend(bound)}" for bound in dict.fromkeys(row["bound"] for row in limits)]
    return lines


def template_of(result):
    """The largest weak point: its counts a step are those of longer pipelines."""
    return max((p for p in result["points"] if p["series"] in ("weak", "alone")), key=lambda p: p["elements"])


def text(result):
    model = cost.Model(result)
    lines = [f"{result['name']}: {result['machine']['1']['processor']}, {result['date']}, udar {result['version']}",
             f"command: {result['command']}", "", *machine_text(result), "", *table_text(result, model), "",
             "share of the stepping", *shares_text(result), "", "model", *model_text(result)[0]]
    if "networks" in result:
        lines += ["", *networks.text(result["networks"], model.machine)]
    return "\n".join(line.rstrip() for line in lines) + "\n"


def wrong(result):
    points = result["points"] + result.get("networks", {}).get("lattice", [])
    return [point for point in points if point["equal"] is False]
