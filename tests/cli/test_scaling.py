#!/usr/bin/env python3
# size: long
"""The scaling driver of examples/scaling measures, counts, compares and reports."""

import copy
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

from common import ENVIRONMENT, ROOT, UDAR, read_csv

FOLDER = ROOT / "examples" / "scaling"
RANKS = [1, 2, 3, 4]
PICTURES = """time-per-step solves-per-second bytes-per-element strong-efficiency weak-efficiency share-of-step
    extrapolation""".split()
sys.path.insert(0, str(FOLDER))

import measure  # noqa: E402
import model  # noqa: E402
import networks  # noqa: E402


def scaling(*arguments):
    line = [sys.executable, str(FOLDER / "scaling.py"), *(str(argument) for argument in arguments)]
    return subprocess.run(line, capture_output=True, text=True, env=ENVIRONMENT, timeout=300, check=False)


class Quick(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="udar-test-"))
        cls.addClassCleanup(shutil.rmtree, cls.scratch, ignore_errors=True)
        cls.out = cls.scratch / "out"
        launcher = os.environ.get("MPIEXEC", "mpiexec") + " -n {ranks}"
        found = scaling("run", "--quick", "--udar", UDAR, "--bench", pathlib.Path(UDAR).with_name("udar-bench"),
                        "--launcher", launcher, "--name", "here", "--output", cls.out)
        if found.returncode != 0:
            raise RuntimeError(found.stdout + found.stderr)
        cls.text = found.stdout
        cls.result = json.loads((cls.out / "result.json").read_text())

    def series(self, name):
        points = [point for point in self.result["points"] if point["series"] == name]
        return sorted(points, key=lambda point: (point["ranks"], point["elements"]))

    def test_files(self):
        for name in PICTURES:
            self.assertGreater((self.out / f"{name}.png").stat().st_size, 5000, name)
            self.assertIn("</svg>", (self.out / f"{name}.svg").read_text()[-100:], name)
        self.assertEqual([path for path in self.out.iterdir() if path.is_dir()], [])  # nothing of the runs is left

    def test_rows(self):
        table = read_csv(self.out / "table.csv")
        expected = ["growth"] * 3 + ["strong"] * 4 + ["weak"] * 4 + ["alone"] * 3
        self.assertEqual(list(table["series"]), expected)
        self.assertEqual([int(r) for r, s in zip(table["ranks"], table["series"]) if s == "weak"], RANKS)
        for name in ("step_s", "bound_s", "model_s", "solves_per_s"):
            self.assertGreater(min(table[name]), 0.0, name)
        # The memory of a few hundred elements drowns in that of the program, which varies by some pages.
        large = table["elements"] == max(table["elements"])
        self.assertGreater(min(table["bytes_per_element"][large]), 100.0)
        self.assertEqual((self.out / "table.txt").read_text().splitlines()[0], self.text.split("\nhere: ")[1].join(
            ["here: ", ""]).splitlines()[0])
        self.assertEqual([batch["ranks"] for batch in self.result["batch"]], RANKS)
        self.assertEqual(sorted(self.result["machine"]), [str(rank) for rank in RANKS])

    def test_messages_and_reductions_stay_constant(self):
        weak = self.series("weak")
        self.assertEqual({p["counts"]["steps"] for p in weak}, {weak[0]["counts"]["steps"]})
        self.assertEqual(weak[0]["per_step"]["without_output"]["messages"], 0)
        told = [p["per_step"]["without_output"] for p in weak]
        self.assertEqual(told[2]["messages"], told[3]["messages"])  # two neighbours
        # One neighbour. Quick runs check no residual, so nothing is a matter of chance.
        steps = weak[0]["counts"]["steps"]
        messages = [2.0 * steps * told[1]["messages"], steps * told[2]["messages"]]
        self.assertAlmostEqual(messages[0], messages[1], delta=0.02 * messages[1])
        for name, constant in (("reductions", told[1]["reductions"]), ("message_bytes", told[3]["message_bytes"])):
            self.assertAlmostEqual(told[2][name] / constant, 1.0, delta=0.05)
        self.assertAlmostEqual(told[2]["reductions"], told[3]["reductions"], delta=0.05 * told[3]["reductions"])

    def test_the_model_counts_what_petsc_counts(self):
        for point in self.series("weak")[1:] + self.series("strong")[1:]:
            told, counted = model.communication(point), point["per_step"]["without_output"]
            steps = point["counts"]["steps"]
            place = f"{point['series']} on {point['ranks']}"
            self.assertAlmostEqual(told["messages"], steps * counted["messages"], msg=place,
                                   delta=0.02 * told["messages"] + 2)
            per_step = (told["reductions"] + told["gathers"]) / steps
            self.assertAlmostEqual(per_step / counted["reductions"], 1.0, delta=0.1,
                                   msg=place)

    def test_a_residual_check_costs_what_the_model_says(self):
        programs = measure.Programs(UDAR, UDAR, os.environ.get("MPIEXEC", "mpiexec") + " -n {ranks}", self.scratch)
        case = ["-beam_elements", "4000", "-filter_check_interval"]
        without, checked = (programs.run(2, "floor.yaml", [*case, interval]) for interval in ("0", "5"))
        point = {"ranks": 2, "length": 10.0, "case": "floor.yaml", "check_interval": 5,
                 "petsc": [int(word) for word in checked["versions"]["petsc"].split(".")],
                 "counts": {**dict.fromkeys(("rows", "sweeps", "steps", "event_steps"), 0),
                            "line_solves": checked["stepping_line_solves"]}}
        told = model.communication(point)["reductions"]
        counted = [run["communication"]["stepping"]["reductions"] for run in (without, checked)]
        self.assertEqual(without["stepping_line_solves"], checked["stepping_line_solves"])
        self.assertAlmostEqual(told / (counted[1] - counted[0]), 1.0, delta=0.05)

    def test_results_do_not_depend_on_ranks(self):
        compared = [p for p in self.result["points"] if p["equal"] is not None]
        self.assertEqual(len(compared), 6)
        for point in compared:
            self.assertLess(point["difference"], measure.AGREEMENT)
            self.assertTrue(point["equal"])
        weak, strong = self.series("weak"), self.series("strong")
        self.assertEqual([p["counts"]["impacts"] for p in weak], [150, 300, 450, 600])
        self.assertEqual({p["counts"]["impacts"] for p in strong}, {4001})

    def test_stages_add_up(self):
        for point in self.result["points"]:
            own = sum(value["median"] for value in point["own_seconds"].values())
            self.assertLess(own, 1.01 * point["seconds"]["stepping"]["median"])
            self.assertGreater(own, 0.9 * point["seconds"]["stepping"]["median"])
            self.assertGreaterEqual(point["imbalance"]["local_motion"], 1.0)

    def test_a_lattice_falls_alike_on_all_ranks(self):
        lattice = self.result["networks"]["lattice"]
        self.assertEqual([point["ranks"] for point in lattice], RANKS)
        self.assertEqual([point["equal"] for point in lattice], [None, True, True, True])
        self.assertGreater(lattice[0]["counts"]["impacts"], 16)
        self.assertEqual({point["elements"] for point in lattice}, {8 * 3 * 4 * 4 * 3})

    def test_solves_of_a_net_that_grows(self):
        solves = self.result["networks"]["solves"]
        self.assertEqual([entry["elements"] for entry in solves], [64 * ranks for ranks in RANKS])
        self.assertEqual(solves[0]["interface"], 0)
        self.assertGreater(min(entry["interface"] for entry in solves[1:]), 0)
        told = networks.Model(self.result["networks"], model.Machine(self.result["machine"]))
        # The point that the model is made from, and what it says must grow with the interface.
        self.assertAlmostEqual(told.seconds(solves[0]), solves[0]["seconds"]["median"], places=12)
        self.assertIn("above one half up to", self.text)

    def test_where_nets_stop(self):
        """On a machine of one's own: 1 ns a node, 1e10 flops, no time for messages."""
        block = {"flops_per_rank": 1e10, "message": {"bandwidth": 1e300}, "gather_seconds": {"median": 0.0}}
        machine = types.SimpleNamespace(blocks={1: block, 2: block}, block=lambda ranks: block, most_exclusive=2,
                                        bandwidth=lambda ranks, footprint: 1e10)
        solves = [{"ranks": ranks, "nodes": 1000, "junctions": 100, "interface": 0 if ranks == 1 else 14,
                   "seconds": {"median": 1e-6}} for ranks in (1, 2)]
        told = networks.Model({"solves": solves}, machine)
        self.assertAlmostEqual(told.cut, 14 / (10 * 2 ** 0.5))
        self.assertAlmostEqual(told.parts(1000, 4, 20, 2)["interface"], 2 * 6 * 10 * 6 * 20 / 1e10)
        # The product, 144 (cut side)^2 / flops whatever the ranks, takes as long as a rank's members.
        net = told.limit(300, 1024)
        self.assertEqual(net["bound"], "interface")
        ranks = net["nodes"] * 1e-9 / (144 * told.cut ** 2 * 300 ** 2 / 1e10)
        self.assertAlmostEqual(net["ranks_at_half"] / ranks, 1.0, delta=0.13)  # a step of the ladder
        few = told.limit(10, 100_000)  # 180 members: on 360 ranks half of the ranks have none
        self.assertEqual(few["bound"], "whole members")
        self.assertAlmostEqual(few["ranks_at_half"] / 360, 1.0, delta=0.13)

    def test_a_wrong_result_is_loud(self):
        wrong = copy.deepcopy(self.result)
        point = next(p for p in wrong["points"] if p["series"] == "weak" and p["ranks"] == 3)
        point["equal"], point["difference"] = False, 1e-3
        path = self.scratch / "wrong.json"
        path.write_text(json.dumps(wrong))
        found = scaling("table", path, "--output", self.scratch / "wrong")
        self.assertEqual(found.returncode, 2, found.stderr)
        self.assertIn("WRONG", found.stdout)
        self.assertIn("weak, 3000 elements on 3 ranks", found.stderr)

    def test_collect(self):
        other = copy.deepcopy(self.result)
        other["name"] = "there"
        path = self.scratch / "there.json"
        path.write_text(json.dumps(other))
        folder = self.scratch / "all"
        found = scaling("collect", self.out, path, "--output", folder)
        self.assertEqual(found.returncode, 0, found.stderr)
        table = read_csv(folder / "table.csv")
        self.assertEqual(set(table["machine"]), {"here", "there"})
        self.assertEqual(len(table["machine"]), 2 * len(self.result["points"]))
        for name in ("machines-weak", "machines-strong", "machines-time-per-step", "there-weak-efficiency"):
            self.assertTrue((folder / f"{name}.png").is_file(), name)
        self.assertEqual(len(json.loads((folder / "results.json").read_text())), 2)


class Parts(unittest.TestCase):
    def test_differences_are_found(self):
        one = {"end_time": 1.0, "impacts": 3, "energy": {"total": 100.0}, "support_impulse": [5.0, 1.0]}
        same = copy.deepcopy(one)
        self.assertEqual(measure.difference(one, same), 0.0)
        same["support_impulse"][1] += 1e-6
        self.assertAlmostEqual(measure.difference(one, same), 2e-7, delta=1e-12)
        same["impacts"] = 4
        self.assertEqual(measure.difference(one, same), float("inf"))

    def test_constants_are_fitted_and_not_negative(self):
        columns = [[1.0, 10.0, 3.0], [1.0, 100.0, 1.0], [1.0, 1000.0, 2.0], [1.0, 5000.0, 2.0]]
        values = [2.0 * a + 0.5 * b for a, b, _ in columns]
        found = model.non_negative(columns, values)
        for constant, expected in zip(found, (2.0, 0.5, 0.0)):
            self.assertAlmostEqual(constant, expected, delta=1e-9)
        falling = model.non_negative([[1.0, 1.0], [1.0, 2.0], [1.0, 3.0]], [3.0, 2.0, 1.0])
        self.assertGreaterEqual(min(falling), 0.0)

    def test_spread(self):
        self.assertEqual(measure.spread([3.0, 1.0, 2.0]), {"median": 2.0, "low": 1.0, "high": 3.0})
        self.assertEqual(measure.middle([{"a": [1.0]}, {"a": [3.0]}, {"a": [2.0]}]), {"a": [2.0]})

    def test_refused(self):
        found = scaling("run", "--ranks", "0")
        self.assertEqual(found.returncode, 2)
        self.assertIn("at least 1", found.stderr)
        found = scaling("run", "--quick", "--udar", "/nowhere/udar", "--output", tempfile.gettempdir())
        self.assertEqual(found.returncode, 1)
        self.assertIn("no program /nowhere/udar", found.stderr)
        found = scaling("table", "/nowhere/result.json")
        self.assertEqual(found.returncode, 1)
        self.assertIn("/nowhere/result.json", found.stderr)


if __name__ == "__main__":
    unittest.main()
