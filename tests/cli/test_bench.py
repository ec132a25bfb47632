#!/usr/bin/env python3
# size: medium
"""udar-bench prints what its manual says, and its figures hang together."""

import csv
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from common import MPIEXEC, UDAR, environment_of

BENCH = str(pathlib.Path(UDAR).with_name("udar-bench"))


def bench(*arguments, ranks=1):
    start = [MPIEXEC, "-n", str(ranks)] if ranks > 1 else []
    line = start + [BENCH, "-skip_petscrc", *arguments]
    return subprocess.run(line, capture_output=True, text=True, env=environment_of(line), timeout=120, check=False)


class Laws(unittest.TestCase):
    def test_each_law_has_a_time(self):
        result = bench("-bench_kind", "laws", "-bench_repeats", "3")
        self.assertEqual(result.returncode, 0, result.stderr)
        told = json.loads(result.stdout)
        times = told["nanoseconds_per_mass_and_sweep"]
        self.assertEqual(list(times), ["none", "rigid", "spring", "hertz", "hunt_crossley", "bilinear", "crush",
                                       "table"])
        for name, best in times.items():
            self.assertGreater(best, 5, name)
            self.assertGreaterEqual(told["median"][name], best, name)
            away = told["mean_velocity_at_the_end"][name] > 0
            self.assertEqual(away, name != "none", f"{name} has sent the masses back")


class Network(unittest.TestCase):
    def test_members_are_faster_than_the_assembled_frame(self):
        result = bench("-bench_kind", "network", "-bench_repeats", "2", "-bench_networks", "grillage-10",
                       "-bench_largest_frame", "3000", "-bench_grading", "4")
        self.assertEqual(result.returncode, 0, result.stderr)
        entries = json.loads(result.stdout)
        self.assertEqual([entry["elements"] for entry in entries], [4, 16, 64])
        for entry in entries:
            self.assertEqual(entry["nodes"], 100 + 180 * (entry["elements"] - 1))
            self.assertGreater(entry["nanoseconds_per_node"], 0.0)
            self.assertGreater(entry["graded_over_equal"]["one_column"], 0.0)
            self.assertEqual("cholmod_over_members" in entry, entry["nodes"] <= 3000)
        for entry in entries[:2]:
            for other in ("cholmod_over_members", "mumps_over_members"):
                self.assertGreater(entry[other]["one_column"], 1.0, entry)


class Solve(unittest.TestCase):
    def check(self, ranks, *arguments):
        result = bench("-bench_kind", "solve", "-beam_elements", "3000", "-bench_repeats", "3", *arguments, ranks=ranks)
        self.assertEqual(result.returncode, 0, result.stderr)
        found = json.loads(result.stdout)
        self.assertEqual((found["elements"], found["ranks"]), (3000, ranks))
        for key in ("error", "error_offset_and_tilt"):
            self.assertGreater(found[key], 0.0, key)  # round-off is never exactly nothing
            self.assertLess(found[key], 1e-12, key)
        # Displacements read twice and stretches written once, and something for the joints.
        self.assertGreater(found["bytes_per_node"], 24.0)
        stream = found["bytes_per_node"] / found["triad_bandwidth"] * 1e9
        self.assertAlmostEqual(found["nanoseconds_per_node"] / stream / found["ratio_to_stream"], 1.0, places=6)
        self.assertGreater(found["petsc_best"], 0.0)
        self.assertLess(found["petsc"][found["petsc_best_name"]]["error"], 1e-11)
        self.assertEqual(found["petsc_over_chain"], found["petsc"][found["petsc_best_name"]]["over_chain"])
        return found

    def test_one_rank(self):
        self.assertEqual(self.check(1)["petsc_best_name"], "block-lu")

    def test_two_ranks(self):
        found = self.check(2, "-bench_petsc", "repeated-lu,mumps")
        self.assertEqual(set(found["petsc"]), {"repeated-lu", "mumps"})
        self.assertIn("one_rank_over_these", found)

    def test_masses_over_decades(self):
        uniform, spread = self.check(1), self.check(1, "-bench_mass_decades", "6")
        # Every node is a joint then; 3000 equal ones share the factors of a few stretches.
        self.assertGreater(spread["factor_bytes_per_node"], 5.0 * uniform["factor_bytes_per_node"])

    def test_line_that_the_chain_cannot_carry(self):
        result = bench("-beam_tension", "1e5")
        self.assertEqual(result.returncode, 1)
        self.assertIn("tension", result.stderr)


class Integrators(unittest.TestCase):
    def test_work_and_precision(self):
        result = bench("-bench_kind", "integrators", "-bench_quick")
        self.assertEqual(result.returncode, 0, result.stderr)
        first = result.stdout.split("\n\n")[0].strip().splitlines()
        self.assertIn("fall on two points, N = 20, e = 1.0", first[0])
        fields = [line.rsplit(None, 6) for line in first[2:]]
        rows = {name: [float(value) for value in values] for name, *values in fields}
        solves, error = ({name: row[column] for name, row in rows.items()} for column in (2, 3))
        self.assertLess(error["chebyshev rtol 1e-8"], 1e-8)
        self.assertLess(error["impact rtol 1e-7"], 1e-7)
        self.assertLess(4 * solves["chebyshev rtol 1e-8"], solves["5dp rtol 1e-8"])
        self.assertGreater(error["5dp rtol 1e-8"], 0.1 * error["chebyshev rtol 1e-8"])
        self.assertGreater(error["leapfrog wf h 0.0125"], 1e-4)


class Accuracy(unittest.TestCase):
    def test_table(self):
        result = bench("-bench_kind", "accuracy", "-bench_elements", "100,10000", "-bench_repeats", "1")
        self.assertEqual(result.returncode, 0, result.stderr)
        errors = {
            line[:34].strip(): [float(error) for error in re.findall(r"(\S+) /", line[34:])]
            for line in result.stdout.splitlines()[2:]
        }
        self.assertLess(max(errors["chain (default)"]), 1e-12)
        self.assertLess(max(errors["mixed, BAIJ LU + refinement"]), 1e-12)
        # What the page on performance says of the others.
        self.assertGreater(errors["hermite, BAIJ LU + refinement"][1], 1e-5)
        self.assertGreater(errors["mixed, AIJ LU (pointwise)"][1], 1e-9)


class Machine(unittest.TestCase):
    def check(self, ranks):
        result = bench("-bench_kind", "machine", "-bench_largest", "1000000", "-bench_repeats", "3", ranks=ranks)
        self.assertEqual(result.returncode, 0, result.stderr)
        found = json.loads(result.stdout)
        self.assertEqual((found["hosts"], found["ranks"], found["ranks_per_host"]), (1, ranks, ranks))
        self.assertLessEqual(found["cores_per_host"], os.cpu_count())
        turns = -(-ranks // found["cores_per_host"])
        sizes = [32768 << i for i in range(5) if 32768 << i <= 1000000 // turns]
        self.assertEqual([row["bytes_per_rank"] for row in found["triad"]], sizes)
        for row in found["triad"]:
            self.assertLessEqual(row["low"], row["bandwidth"])
            self.assertLessEqual(row["bandwidth"], row["high"])
        self.assertGreater(found["triad"][-1]["bandwidth"], 1e8)
        self.assertGreater(found["flops_per_rank"], 1e7)
        return found

    def test_one_rank_has_no_neighbours(self):
        found = self.check(1)
        for key in ("message", "exchange_seconds", "gather_seconds", "reduction_seconds"):
            self.assertIsNone(found[key], key)

    def test_three_ranks(self):
        found = self.check(3)
        self.assertGreater(found["message"]["bandwidth"], 1e6)
        for times in (found["message"]["latency"], found["exchange_seconds"], found["gather_seconds"],
                      found["reduction_seconds"]["sweep"], found["reduction_seconds"]["step"]):
            self.assertGreater(times["low"], 1e-9)
            self.assertLessEqual(times["low"], times["median"])
            self.assertLessEqual(times["median"], times["high"])


class Batch(unittest.TestCase):
    CASE = ("-bench_kind", "batch", "-beam_length", "10", "-beam_elements", "20", "-beam_radius", "0.1",
            "-beam_young_modulus", "2.1e11", "-beam_density", "7850", "-initial_height", "1", "-support_position",
            "2,8", "-filter_frequency", "100", "-ts_max_time", "0.5")

    def run_batch(self, ranks, *arguments):
        result = bench(*self.CASE, *arguments, ranks=ranks)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def test_a_damped_beam_is_damped(self):
        free, damped = (
            self.run_batch(1, "-bench_beams", "1", "-ts_type", "impact", "-damping_mass", alpha) for alpha in ("0", "5")
        )
        self.assertNotEqual(free["line_solves"], damped["line_solves"])
        self.assertLess(damped["impacts"], free["impacts"])

    def test_groups_do_the_same_work(self):
        alone = self.run_batch(1, "-bench_beams", "7")
        for ranks, group in ((2, 1), (2, 2)):
            with self.subTest(ranks=ranks, group=group):
                found = self.run_batch(ranks, "-bench_beams", "7", "-bench_group", str(group))
                self.assertEqual((found["groups"], found["ranks_per_group"]), (ranks // group, group))
                for key in ("elements", "beams", "impacts"):
                    self.assertEqual(found[key], alone[key], key)
                self.assertAlmostEqual(found["line_solves"] / alone["line_solves"], 1.0, delta=0.02)
                times = found["seconds_per_beam"]
                self.assertGreater(times["low"], 0.0)
                self.assertLessEqual(times["median"], times["high"])
                self.assertLessEqual(times["high"], found["seconds"])
                self.assertAlmostEqual(found["beams_per_second"] * found["seconds"], 7.0, delta=1e-6)
        self.assertGreater(alone["impacts"], 0)

    def test_group_that_does_not_divide(self):
        for ranks, group in ((1, "2"), (1, "0")):
            result = bench(*self.CASE, "-bench_group", group, ranks=ranks)
            self.assertEqual(result.returncode, 1)
            self.assertIn("-bench_group", result.stderr)


class Contact(unittest.TestCase):
    def test_work_and_precision(self):
        with tempfile.TemporaryDirectory() as folder:
            result = bench("-bench_kind", "contact", "-bench_stiffness", "2e9", "-bench_methods",
                           "masses-impact,line-impact,line-chebyshev,unfiltered,modal", "-bench_frequencies", "400",
                           "-bench_steps", "4e-4", "-bench_modes", "16,24,32", "-bench_reference", "44,48",
                           "-bench_repeats", "1", "-bench_directory", folder)
            self.assertEqual(result.returncode, 0, result.stderr)
            table = json.loads(pathlib.Path(folder, "contact.json").read_text())["tables"][0]
            with open(pathlib.Path(folder, "contact.csv"), newline="") as file:
                rows = list(csv.DictReader(file))
        self.assertEqual(table["stiffness"], 2e9)
        # Of another code, N = 160 and a continuous beam (docs/verification.md).
        truth = table["reference"]
        self.assertAlmostEqual(truth["second_landing"], 0.67620, delta=2e-5)
        self.assertAlmostEqual(truth["rebound"], 0.7267, delta=3e-4)  # of which the mesh has two thirds
        self.assertAlmostEqual(truth["lowest_at_0"], -3.20e-2, delta=1e-4)
        self.assertAlmostEqual(truth["lowest_at_5"], -3.674e-2, delta=1e-4)
        for name in ("second_landing", "rebound"):
            self.assertLess(truth[f"scatter_of_{name}"], 1e-5, name)
        found = {(row["method"], row["parameter"]): row for row in table["rows"]}
        self.assertEqual([row["method"] for row in rows], [row["method"] for row in table["rows"]])
        self.assertEqual(len(result.stdout.strip().splitlines()), 3 + len(rows))
        for row, of_csv in zip(table["rows"], rows):
            self.assertEqual(row["refusal"], "")
            self.assertEqual(float(of_csv["rebound"]), row["rebound"])
            self.assertAlmostEqual(abs(row["rebound"] - truth["rebound"]), row["error_of_rebound"], places=12)
            self.assertGreater(row["stepping_cpu_seconds"] + row["set_up_cpu_seconds"], 0.0)
            if row["method"] != "unfiltered":  # whose springs take and give within a step
                self.assertLess(abs(row["energy_drift"]), 1e-4, row["method"])
        modes = [found["modal", count] for count in ("16", "24", "32")]
        for coarse, fine in zip(modes, modes[1:]):
            self.assertLess(fine["distance"], 0.5 * coarse["distance"])
        self.assertLess(modes[-1]["distance"], 1e-4)
        self.assertLess(modes[-1]["line_solves"], 100)
        self.assertGreater(found["unfiltered", "0.0004"]["line_solves"], 3000)
        self.assertGreater(found["unfiltered", "0.0004"]["distance"], 10.0 * modes[-1]["distance"])
        # Each change of contact exactly against sweeps over steps.
        self.assertLess(4 * found["line-chebyshev", "400"]["line_solves"],
                        found["line-impact", "400"]["line_solves"])

    def test_what_a_method_does_not_know_is_told(self):
        with tempfile.TemporaryDirectory() as folder:
            result = bench("-bench_kind", "contact", "-bench_stiffness", "1e7", "-bench_methods",
                           "line-chebyshev,unfiltered", "-bench_frequencies", "200", "-bench_steps", "4e-4",
                           "-bench_reference", "8", "-bench_neighbours", "1", "-beam_elements", "40",
                           "-support_position", "5", "-support_width", "4", "-ts_max_time", "0.5",
                           "-bench_directory", folder)
            self.assertEqual(result.returncode, 0, result.stderr)
            refused, run = json.loads(pathlib.Path(folder, "contact.json").read_text())["tables"][0]["rows"]
        self.assertIn("8 contact points", refused["refusal"])
        self.assertIn("8 contact points", result.stdout)
        self.assertIsNone(refused["line_solves"])
        self.assertEqual(run["refusal"], "")
        self.assertIsNone(run["second_landing"])  # after the end
        self.assertGreaterEqual(run["line_solves"], 1250)
        self.assertGreater(run["distance"], 0.0)

    def test_lists_stand_for_options(self):
        for key, value in (("-filter_frequency", "100"), ("-support_stiffness", "1e9"), ("-ts_type", "modal")):
            result = bench("-bench_kind", "contact", key, value)
            self.assertEqual(result.returncode, 1)
            for word in (key, value, "-bench_"):
                self.assertIn(word, result.stderr)


class Output(unittest.TestCase):
    def test_rows_against_plain_writes(self):
        row = 20001 * (4 * 8 + 1) + 20000 * 8  # four numbers and a flag at each node, shear between them
        with tempfile.TemporaryDirectory() as folder:
            for ranks in (1, 2):
                run = bench("-bench_kind", "output", "-beam_elements", "20000", "-bench_repeats", "3",
                            "-bench_directory", folder, ranks=ranks)
                self.assertEqual(run.returncode, 0, run.stderr)
                result = json.loads(run.stdout)
                self.assertEqual(result["ranks"], ranks)
                self.assertEqual(result["bytes_per_row"], row)
                for kind in ("fields", "plain"):
                    seconds = result[f"{kind}_seconds"]
                    self.assertTrue(0.0 < seconds["low"] <= seconds["median"] <= seconds["high"])
                    self.assertAlmostEqual(result[f"{kind}_bandwidth"] * seconds["median"] / row, 1.0)
                ratio = result["plain_seconds"]["median"] / result["fields_seconds"]["median"]
                self.assertAlmostEqual(result["fields_over_plain"] / ratio, 1.0)
                self.assertEqual(os.listdir(folder), [])


class Refused(unittest.TestCase):
    def test_bad_values(self):
        for arguments, words in (
            (["-bench_petsc", "lapack"], ["-bench_petsc", "lapack", "block-lu"]),
            (["-bench_repeats", "0"], ["-bench_repeats", "0", ">= 1"]),
            (["-bench_kind", "machine", "-bench_largest", "100"], ["-bench_largest", "100", "32768"]),
            (["-bench_kind", "batch", "-bench_beams", "0"], ["-bench_beams", "0"]),
            (["-bench_mass_decades", "6", "-beam_length", "1,2"], ["-beam_length", "one segment"]),
            (["-beam_elements", "100", "-bench_repeat", "3"], ["-bench_repeat", "-bench_repeats"]),
        ):
            with self.subTest(arguments=arguments):
                result = bench(*arguments)
                self.assertEqual(result.returncode, 1)
                for word in words:
                    self.assertIn(word, result.stderr)


if __name__ == "__main__":
    unittest.main()
