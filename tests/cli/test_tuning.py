#!/usr/bin/env python3
# size: long
"""examples/tuning/tune.py ranks sets by time, disqualifies wrong ones, says why others failed, writes best.opts."""

import contextlib
import csv
import io
import json
import pathlib
import subprocess
import sys
import unittest

import numpy as np

from common import ENVIRONMENT, ROOT, UDAR, UdarTest, case, read_csv

TUNE = str(ROOT / "examples" / "tuning" / "tune.py")
BEAM = case(beam_elements=200, support_width=0.2, contact_restitution=0.5, ts_max_time=0.5, ts_rtol=1e-9)
SETS = {
    "good": "# solved more often than needed\n-ts_type rk\n-ts_rk_type 5dp\n-ts_rtol 1e-11\n",
    "coarse": "-ts_type rk\n-ts_rk_type 3bs\n-ts_rtol 1e-2\n",  # fewer steps than any other, and wrong
    "typo": "-filter_frequecny 100\n",
    "ignored": "-ts_theta_theta 0.7\n",  # a key of PETSc that nobody reads
    "short": "-ts_max_time 0.3\n",
    "printing": "-ts_view\n-filter_check_interval 1\n",
}


class Tuning(UdarTest):
    def tune(self, *arguments, sets=SETS, options=BEAM, launcher="", code=0):
        """Runs tune.py on one rank without mpirun, into <scratch>/out."""
        file = self.scratch / "case.yaml"
        file.write_text("".join(f"{key}: {value}\n" for key, value in options.items()))
        paths = []
        for name, text in sets.items():
            paths.append(self.scratch / f"{name}.opts")
            paths[-1].write_text(text)
        command = [sys.executable, TUNE, file, "--udar", UDAR, "--launcher", launcher,
                   "--output", self.scratch / "out", *arguments, *(["--sets", *paths] if paths else [])]
        words = [str(word) for word in command]
        run = subprocess.run(words, capture_output=True, text=True, env=ENVIRONMENT, timeout=120)
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        self.assertNotIn("Traceback", run.stderr)
        return run

    def trials(self):
        record = json.loads((self.scratch / "out" / "tuning.json").read_text())
        return record, {row["set"]: row for row in record["trials"]}

    def test_ranks_disqualifies_and_writes_the_winner(self):
        run = self.tune("--repeats", "2")
        record, trials = self.trials()
        self.assertEqual({name: row["verdict"] for name, row in trials.items()}, {
            "none": "qualified", "good": "qualified", "coarse": "disqualified", "ignored": "disqualified",
            "printing": "diagnostics", "typo": "failed", "short": "failed"})
        self.assertIn("error above 1e-06", trials["coarse"]["reason"])
        self.assertGreater(trials["coarse"]["error"], 1e-6)
        self.assertIn("-ts_theta_theta", trials["ignored"]["reason"])
        self.assertIn("-filter_frequecny", trials["typo"]["reason"])
        self.assertIn("-filter_frequency", trials["typo"]["reason"])  # udar's own line names the nearest key
        self.assertIn("other output times", trials["short"]["reason"])
        for name in SETS:
            self.assertIn(name, run.stdout)

        # The qualified come first, by time; the winner is the first of them.
        qualified = [row for row in record["trials"] if row["verdict"] == "qualified"]
        self.assertEqual(record["trials"][: len(qualified)], qualified)
        times = [row["seconds_median"] for row in qualified]
        self.assertEqual(times, sorted(times))
        best = record["best"]
        self.assertEqual(best["set"], qualified[0]["set"])
        for row in qualified:
            self.assertEqual(row["runs"], 2)
            self.assertLessEqual(row["seconds_low"], row["seconds_median"])
            self.assertLessEqual(row["seconds_median"], row["seconds_high"])
        # The reference's own error is known, and below what it judges.
        self.assertGreater(record["reference"]["error"], 0)
        self.assertLess(record["reference"]["error"], 1e-7)
        self.assertAlmostEqual(record["reference"]["rtol"] / 1e-11, 1)

        # An error in the table is the one its files show.
        reference, coarse = (read_csv(self.scratch / "out" / "runs" / f"{name}-np1" / "gauges.csv")
                             for name in ("reference", "coarse"))
        positions = [name for name in reference if name.startswith(("mass_", "line_"))]
        size = max(reference[name].max() for name in positions) - min(reference[name].min() for name in positions)
        by_hand = max(np.abs(coarse[name] - reference[name]).max() for name in positions) / size
        self.assertGreater(by_hand, 0)
        self.assertGreaterEqual(trials["coarse"]["error"], by_hand * (1 - 1e-9))

        # best.opts holds the winner's keys, udar takes it and the curves are the winner's.
        file = self.scratch / "out" / "best.opts"
        keys = [line for line in file.read_text().splitlines() if not line.startswith("#")]
        wanted = [line for line in SETS.get(best["set"], "").splitlines() if not line.startswith("#")]
        self.assertEqual(keys, wanted)
        for word in ("case:", "ranks:", "time:", "error:", "found by:", "date:"):
            self.assertIn(f"# {word}", file.read_text())
        self.assertEqual(best["again"]["difference"], 0.0)
        again = self.run_case({"options_file": self.scratch / "case.yaml"}, extra=["-options_file", str(file)])
        gauges = again.csv("gauges.csv")
        winner = read_csv(self.scratch / "out" / "runs" / f"{best['set']}-np1" / "gauges.csv")
        for name, column in winner.items():
            np.testing.assert_array_equal(gauges[name], column, err_msg=name)

        with (self.scratch / "out" / "tuning.csv").open() as table:
            self.assertEqual([row["set"] for row in csv.DictReader(table)], [row["set"] for row in record["trials"]])
        for name in ("tuning.png", "tuning.svg"):
            self.assertGreater((self.scratch / "out" / name).stat().st_size, 5000)

    def test_the_faster_set_wins_under_the_options_given(self):
        # A solve by MUMPS takes a hundred times that of the chain, and the run several times as long.
        slow = {**BEAM, "beam_elements": 500, "filter_pc_type": "lu", "filter_pc_factor_mat_solver_type": "mumps"}
        self.tune("--repeats", "1", "--options", "-ts_rtol 1e-10", options=slow,
                  sets={"fast": "-filter_ksp_type preonly\n-filter_pc_type chain\n-ts_rtol 1e-11\n"})
        record, trials = self.trials()
        self.assertEqual(record["best"]["set"], "fast")
        self.assertLess(10 * trials["fast"]["line_solve_seconds_median"], trials["none"]["line_solve_seconds_median"])
        self.assertIn("--options wins over its -ts_rtol", trials["fast"]["reason"])
        text = (self.scratch / "out" / "best.opts").read_text()
        self.assertIn("\n-filter_pc_type chain\n", text)
        self.assertNotIn("-ts_rtol 1e-11", text)

    def test_no_winner_is_an_error_and_leaves_no_file_and_a_slow_set_is_stopped(self):
        (self.scratch / "out").mkdir()
        (self.scratch / "out" / "best.opts").write_text("-ts_type rk\n")  # of an earlier call
        # The case as it stands is too coarse for the tolerance, its reference is not.
        coarse = {**BEAM, "ts_type": "rk", "ts_rk_type": "3bs", "ts_rtol": 1e-3}
        tight = self.scratch / "tight.opts"
        tight.write_text("-ts_rk_type 8vr\n-ts_rtol 1e-11\n")
        run = self.tune("--repeats", "1", "--tolerance", "1e-7", "--reference", tight, "--time-limit", "3",
                        options=coarse, code=1,
                        sets={"typo": SETS["typo"], "slow": "-ts_adapt_type none\n-ts_dt 1e-7\n"})
        self.assertIn("no set qualifies", run.stderr)
        self.assertFalse((self.scratch / "out" / "best.opts").exists())
        trials = self.trials()[1]
        self.assertEqual({name: row["verdict"] for name, row in trials.items()},
                         {"none": "disqualified", "typo": "failed", "slow": "failed"})
        self.assertIn("time limit of 3 s", trials["slow"]["reason"])

    def test_a_reference_that_is_not_good_enough_is_refused(self):
        run = self.tune("--tolerance", "1e-15", sets={}, code=1)
        self.assertIn("no reference: it is known to", run.stderr)
        run = self.tune(sets={}, options={**BEAM, "beam_radius": -1}, code=1)
        self.assertIn("-beam_radius", run.stderr)
        run = self.tune(sets={}, options={**BEAM, "ts_type": "rk", "ts_adapt_type": "none", "ts_dt": 1e-3}, code=1)
        self.assertIn("fixed steps", run.stderr)

    def test_two_ranks_by_the_launcher(self):
        launcher = f"{ENVIRONMENT.get('MPIEXEC', 'mpiexec')} -n {{ranks}}"
        self.tune("--ranks", "1,2", "--repeats", "1", sets={"good": SETS["good"]}, launcher=launcher)
        self.assertEqual({(row["set"], row["ranks"], row["verdict"]) for row in self.trials()[0]["trials"]},
                         {(name, ranks, "qualified") for name in ("none", "good") for ranks in (1, 2)})

    def test_bad_arguments_name_what_is_wrong(self):
        sys.path.insert(0, str(pathlib.Path(TUNE).parent))
        import tune

        file = self.scratch / "case.yaml"
        file.write_text("beam_length: 10\n")
        missing = str(self.scratch / "missing")
        for arguments, words in (
            (["--ranks", "0"], ["--ranks", "'0'"]),
            (["--ranks", "1,two"], ["--ranks", "'1,two'"]),
            (["--repeats", "0"], ["--repeats", "'0'"]),
            (["--tolerance", "small"], ["--tolerance", "'small'"]),
            (["--time-limit", "-3"], ["--time-limit", "'-3'"]),
            (["--udar", missing], ["--udar", missing]),
            (["--reference", missing], [missing]),
            (["--sets", missing], [missing]),
            (["--ranks", "2"], ["--launcher", "{ranks}"]),
            (["--launcher", "no-such-launcher -n {ranks}"], ["--launcher", "no-such-launcher"]),
            (["--launcher", "mpirun {rank}"], ["--launcher", "{rank}"]),
            (["--colour", "red"], ["--colour"]),
        ):
            with self.subTest(arguments=arguments):
                said = io.StringIO()
                with contextlib.redirect_stderr(said):
                    code = tune.main([str(file), "--udar", UDAR, "--launcher", "", *arguments])
                self.assertEqual(code, 2, said.getvalue())
                for word in words:
                    self.assertIn(word, said.getvalue())
                self.assertEqual(len(said.getvalue().splitlines()), 1, said.getvalue())
        wrong = self.tune(sets={"wrong": "ts_type rk\n"}, code=2)
        self.assertIn("'ts_type rk'", wrong.stderr)
        self.assertFalse((self.scratch / "out").exists())


if __name__ == "__main__":
    unittest.main()
