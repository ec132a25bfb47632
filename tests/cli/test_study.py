#!/usr/bin/env python3
# size: long
"""udar-study runs a case over a grid: the same tables however the runs are dealt, failures shown, bad input refused."""

import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import time
import unittest

import numpy as np
from common import BEAM, MPIEXEC, STEEL_MASS, UDAR, UdarTest, arguments, environment_of, read_csv, start

STUDY = str(pathlib.Path(UDAR).with_name("udar-study"))
PLOT = os.environ.get("UDAR_PLOT", str(pathlib.Path(UDAR).with_name("udar-plot")))
CASE = {**BEAM, "ts_max_time": 0.55, "output_field_interval": 0, "output_interval": 0.002}
# Three frequencies and two meshes; -ts_type impact so that masses at many nodes cost no more.
GRID = {"filter_frequency": "100,200,400", "beam_elements": "20,40", "support_width": 1}


def line_of(options, ranks):
    begin = [MPIEXEC, "-n", str(ranks)] if ranks > 1 else []
    return [*begin, STUDY, "-skip_petscrc", *arguments(options)]


def finished(line):
    return subprocess.run(line, capture_output=True, text=True, env=environment_of(line), timeout=240, check=False)


class StudyTest(UdarTest):
    def study(self, options, ranks=1, name="study", code=0):
        """Runs a study into <scratch>/<name>; gives study.json, the rows of study.csv and what was printed."""
        folder = self.scratch / name
        result = finished(line_of({**CASE, "output_directory": folder, **options}, ranks))
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return json.loads((folder / "study.json").read_text()), read_csv(folder / "study.csv"), result.stdout


def without_times(json_text, folder):
    """study.json without what differs from run to run of the same study."""
    json_text = json_text.replace(str(folder), "")
    return re.sub(r'"wall_seconds": [^,\n}]+', '"wall_seconds": 0', json_text)


class Designs(StudyTest):
    LATIN = {"study_vary": "initial_height: 0.1..2; support_stiffness: 1e7..1e9 log; support_position: 2 8, 3 7",
             "study_design": "latin", "study_samples": 12, "support_width": 1, "beam_yield_stress": 235e6}

    def test_latin_hypercube(self):
        study, rows, out = self.study(self.LATIN, 2)
        self.assertEqual(list(rows["state"]), ["finished"] * 12)
        strata = np.sort(np.floor((np.array(rows["initial_height"], float) - 0.1) / 1.9 * 12))
        np.testing.assert_array_equal(strata, np.arange(12))
        strata = np.sort(np.floor(np.log10(np.array(rows["support_stiffness"], float) / 1e7) / 2 * 12))
        np.testing.assert_array_equal(strata, np.arange(12))
        runs = study["runs"]
        self.assertEqual(sorted(run["axes"]["support_position"] for run in runs), ["2,8"] * 6 + ["3,7"] * 6)
        spread = study["design"][0]["spread"]
        for name in ("peak_force", "max_moment", "max_stress", "utilisation", "sag", "penetration"):
            values = [run["quantities"][name] for run in runs]
            self.assertEqual((spread[name]["least"], spread[name]["largest"]), (min(values), max(values)), name)
            self.assertEqual(values[spread[name]["largest_run"]], max(values))
            self.assertAlmostEqual(spread[name]["mean"] / np.mean(values), 1, places=12)
            self.assertAlmostEqual(spread[name]["deviation"] / np.std(values, ddof=1), 1, places=9)
            follows = spread[name]["rank_correlation"]
            self.assertIsNone(follows["support_position"], "two numbers have no order")
            ranks = [(column[:, None] > column).sum(1) + (column[:, None] == column).sum(1) / 2
                     for column in (np.array(rows["initial_height"], float), np.array(values))]
            self.assertAlmostEqual(follows["initial_height"], np.corrcoef(*ranks)[0, 1], places=9)
        summary = json.loads((pathlib.Path(runs[5]["directory"]) / "summary.json").read_text())
        self.assertEqual(runs[5]["quantities"]["peak_force"], max(map(abs, summary["peak_support_force"])))
        self.assertNotIn("limit", out)
        self.assertNotIn("series", study)

    def test_goes_on_where_it_was_stopped(self):
        folder = self.scratch / "study"
        whole, *_ = self.study(self.LATIN, 1)
        for name in ("study.json", "study.csv", "run-003/summary.json"):
            (folder / name).unlink()
        kept = (folder / "finished-0.jsonl").read_text()
        (folder / "finished-0.jsonl").write_text(kept[:-100])  # its last line is cut short
        again, _, out = self.study({**self.LATIN, "study_resume": True}, 2)
        self.assertRegex(out, r"\n11 of them have finished before\n")
        for study in (whole, again):
            del study["design"][0]["spread"]["wall_seconds"]
        self.assertEqual(without_times(json.dumps(whole), ""), without_times(json.dumps(again), ""))
        other, _, out = self.study({**self.LATIN, "gravity": 9, "study_resume": True})
        self.assertNotIn("before", out, "with other options nothing is kept")
        self.assertNotEqual(whole["runs"][0]["quantities"]["impulse"], other["runs"][0]["quantities"]["impulse"])

    def test_grid_failures_and_pictures(self):
        study, *_ = self.study({"study_vary": "initial_height: 0.5, 1, -1; beam_radius: 0.08, 0.1"}, code=1)
        self.assertEqual([run["state"] for run in study["runs"]], ["finished"] * 4 + ["failed"] * 2)
        self.assertEqual(study["design"][0]["spread"]["impulse"]["runs"], 4)
        drawn = subprocess.run([PLOT, str(self.scratch / "study"), "--format", "png", "--dpi", "40", "--objectives",
                                "peak_force,max_stress"], capture_output=True, text=True, check=False)
        self.assertEqual(drawn.returncode, 0, drawn.stderr)
        self.assertEqual([pathlib.Path(line).name for line in drawn.stdout.split()],
                         ["study-tornado.png", "study-pareto.png"])

    def test_random_depends_on_the_seed_alone(self):
        options = {"study_vary": "initial_height: 0.1..1", "study_design": "random", "study_samples": 5,
                   "ts_max_time": 0.01}
        first, second, third = (self.study({**options, **more}, ranks, f"seed-{ranks}-{len(more)}")[1]
                                for more, ranks in (({}, 1), ({}, 2), ({"study_seed": 2}, 1)))
        np.testing.assert_array_equal(first["initial_height"], second["initial_height"])
        self.assertFalse(set(first["initial_height"]) & set(third["initial_height"]))

    def test_refusals(self):
        for options, words in (
            ({"study_vary": "initial_height 1"}, ["-study_vary", "initial_height 1", "key: values"]),
            ({"study_vary": "initial_height: 1, 1"}, ["-study_vary", "initial_height", "differ"]),
            ({"study_vary": "initial_height: 2..1", "study_design": "latin", "study_samples": 3}, ["2..1", "rise"]),
            ({"study_vary": "initial_height: 0..1 log", "study_design": "latin", "study_samples": 3}, ["0..1 log"]),
            ({"study_vary": "initial_height: 1..2"}, ["initial_height", "-study_design latin or random"]),
            ({"study_vary": "initial_height: 1, 2", "study_design": "lines"}, ["-study_design", "lines"]),
            ({"study_vary": "initial_height: 1, 2", "study_design": "latin"}, ["-study_samples", "0"]),
            ({"study_vary": "initial_height: 1, 2", "study_samples": 4}, ["-study_samples", "4"]),
            ({"study_vary": "initial_height: 1, 2", "ts_rtol": "1e-6,1e-7"}, ["-study_vary", "-ts_rtol", "one value"]),
            ({"study_vary": "study_seed: 1, 2"}, ["-study_vary", "keys of udar"]),
            ({"study_design": "random", "study_samples": 4}, ["-study_design", "-study_vary"]),
        ):
            with self.subTest(**options):
                result = finished(line_of({**CASE, "output_directory": self.scratch / "none", **options}, 1))
                self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
                errors = [line for line in result.stderr.splitlines() if "error:" in line]
                self.assertEqual(len(errors), 1, result.stderr)
                for word in words:
                    self.assertIn(word, errors[0])
                self.assertFalse((self.scratch / "none").exists())


class Grid(StudyTest):
    def test_groups_give_the_same_tables(self):
        studies = [self.study(GRID, ranks, f"np{ranks}") for ranks in (1, 2)]
        texts = [without_times((self.scratch / f"np{ranks}/study.json").read_text(), self.scratch / f"np{ranks}")
                 for ranks in (1, 2)]
        self.assertEqual(*texts)  # every digit: each run is on one rank in both
        last_column = r"(?m)^((?:\s*\d|case).*?)\s+\S+$"
        tables = [re.sub(last_column, r"\1", out.partition("\nruns of")[2].partition("\nwork")[0])
                  for *_, out in studies]
        self.assertEqual(tables[0], tables[1].replace(str(self.scratch / "np2"), str(self.scratch / "np1")))
        self.assertIn("2 side by side", studies[1][2])

        study, rows, out = studies[0]
        self.assertEqual(len(study["runs"]), 6)
        self.assertEqual(set(rows["state"]), {"finished"})
        self.assertEqual(list(rows["filter_frequency"]), [100, 100, 200, 200, 400, 400])
        self.assertEqual(list(rows["beam_elements"]), [20, 40] * 3)
        self.assertEqual(study["series"][0]["finest_run"], 5)
        for word in ("case along filter_frequency = 100, 200, 400, beam_elements = 40",
                     "case along beam_elements = 20, 40, filter_frequency = 400", "error budget of run 5",
                     "work and error against the limit of case"):
            self.assertIn(word, out)

    def test_quantities_agree_with_the_files_of_the_run(self):
        study, *_ = self.study(GRID | {"ts_rtol": "1e-9"}, 2)
        for run in study["runs"]:
            folder = pathlib.Path(run["directory"])
            summary = json.loads((folder / "summary.json").read_text())
            found = run["quantities"]
            with self.subTest(run=run["number"]):
                self.assertEqual(found["impulse"], sum(summary["support_impulse"]))
                self.assertEqual(found["impacts"], summary["impacts"])
                self.assertEqual(found["line_solves"], summary["stepping_line_solves"] - summary["row_line_solves"])
                self.assertEqual(found["wall_seconds"], summary["wall_seconds"]["stepping"])
                self.assertEqual(found["penetration"], max(0.0, -summary["min_line_gap"]))
                self.assertEqual(summary["elements"], int(run["axes"]["beam_elements"]))
                # Momentum: M (v + g t) is what the supports gave; v from the energy of the centre of mass at the end,
                # in flight after the rebound. 1e-7: relative error of the integration at -ts_rtol 1e-9.
                speed = np.sqrt(2 * found["energy_centre"] / STEEL_MASS)
                self.assertAlmostEqual(STEEL_MASS * (speed + 9.81 * 0.55) / found["impulse"], 1.0, delta=1e-7)
                # The same speed back at the height of the first contact, 1 m below the start: v^2 + 2 g y there and
                # here. Height now from the impulse of gravity alone is not known: between the two bounds of the
                # contact's duration the velocity falls by at most g times the time since the first contact.
                since = 0.55 - summary["first_contact_time"]
                self.assertGreater(found["rebound_velocity"], speed)
                self.assertLess(found["rebound_velocity"], speed + 9.81 * since)
                gauges = read_csv(folder / "gauges.csv")
                lowest = min(gauges[f"line_{g}"].min() for g in range(5))
                deepest = min(found[f"gauge_{g}_lowest"] for g in range(5))
                self.assertLessEqual(deepest, lowest)
                self.assertAlmostEqual(deepest, lowest, delta=0.002)  # of one row more
                energy = read_csv(folder / "energy.csv")
                split = found["energy_centre"] + found["energy_vibration"] + found["energy_springs"]
                inside = sum(energy[part][-1] for part in ("kinetic", "line_strain", "fictitious_springs"))
                self.assertAlmostEqual(split / inside, 1.0, delta=1e-12)
                self.assertEqual(found["energy_lost"], energy["lost_in_impacts"][-1])
                # What udar itself says goes into the run's folder.
                self.assertIn("udar: finished", (folder / "log.txt").read_text())

    def test_ranks_of_a_run_do_not_matter(self):
        one, *_ = self.study({**GRID, "beam_elements": 40}, 2, "one")
        two, *_ = self.study({**GRID, "beam_elements": 40, "study_ranks": 2}, 2, "two")
        for left, right in zip(one["runs"], two["runs"]):
            for name, kind in one["quantities"].items():
                if kind["compared"]:
                    # Round-off of differently ordered sums through some 30 impacts with e = 1.
                    a, b = left["quantities"][name], right["quantities"][name]
                    self.assertLess(abs(a - b), 1e-6 * max(abs(a), 1e-3), name)

    def test_lines_leave_out_what_the_analysis_does_not_need(self):
        whole, *_ = self.study(GRID, 2, "whole")
        lines, *_ = self.study({**GRID, "study_design": "lines"}, 2, "lines")
        self.assertEqual((len(whole["runs"]), len(lines["runs"])), (6, 4))
        for name, entry in whole["series"][0]["analysis"].items():
            other = lines["series"][0]["analysis"][name]
            self.assertEqual((entry["limit"], entry["error"]), (other["limit"], other["error"]), name)

    def test_segments_are_refined_together(self):
        study, *_ = self.study({"beam_length": "4,6", "beam_elements": "8,24", "filter_frequency": 200,
                                "study_refine": "1,2"})
        elements = [json.loads((pathlib.Path(run["directory"]) / "summary.json").read_text())["elements"]
                    for run in study["runs"]]
        self.assertEqual(elements, [32, 64])

    def test_case_file_comes_first(self):
        file = self.scratch / "case.yaml"
        file.write_text("\n".join(f"{key}: {value}" for key, value in CASE.items() if "," not in str(value)) +
                        "\nsupport: {position: [2.0, 8.0], width: 1.0}\nstudy: {series: 'a: -beam_elements 10; b:'}\n")
        line = [STUDY, str(file), "-skip_petscrc", "-filter_frequency", "50,100", "-output_directory",
                str(self.scratch / "out")]
        result = finished(line)
        self.assertEqual(result.returncode, 0, result.stderr)
        study = json.loads((self.scratch / "out/study.json").read_text())
        self.assertEqual([(run["series"], run["axes"]) for run in study["runs"]],
                         [(name, {"filter_frequency": wf}) for name in "ab" for wf in ("50", "100")])


class Honesty(StudyTest):
    def test_sag_of_point_supports_does_not_converge_with_the_mesh(self):
        study, _, out = self.study({"filter_frequency": 50, "beam_elements": "20,40,80", "ts_max_time": 0.7}, 2)
        sag = study["series"][0]["analysis"]["penetration"]
        along = sag["along"]["beam_elements"]
        self.assertEqual((along["verdict"], along["error_is"], along["limit"]), ("does not converge", "at least", None))
        self.assertEqual(sag["error_is"], "at least")
        # docs/theory.md: 0.25, 0.42 and 0.69 m, given to two digits.
        for value, expected in zip(along["values"], (0.25, 0.42, 0.69)):
            self.assertAlmostEqual(value, expected, delta=0.006)
        self.assertRegex(out, r"penetration \[m\].*does not converge")
        self.assertIn("not every quantity converges along: beam_elements", out)

    def test_time_step_of_a_bouncing_ball_is_of_the_order_of_the_integrator(self):
        # Stiff beam on one wide patch of springs below: between impacts the classical method
        # of order 4 with fixed steps.
        study, *_ = self.study({"filter_frequency": 50, "support_position": None, "floor": None, "initial_slope": 0,
                                "beam_left_end": "spring", "beam_left_spring": 1e4, "beam_right_end": "spring",
                                "beam_right_spring": 2e4, "ts_type": "rk", "ts_rk_type": "4", "ts_adapt_type": "none",
                                "ts_dt": "8e-3,4e-3,2e-3,1e-3", "ts_max_time": 0.4, "initial_height": 0}, 2)
        centre = study["series"][0]["analysis"]["energy_centre"]["along"]["ts_dt"]
        self.assertEqual(centre["verdict"], "converges")
        self.assertAlmostEqual(centre["orders"][-1], 4.0, delta=0.25)
        # The limit is what an integrator without error gives: better than the finest value by this factor at least.
        exact, *_ = self.study({"filter_frequency": 50, "support_position": None, "beam_left_end": "spring",
                                "beam_left_spring": 1e4, "beam_right_end": "spring", "beam_right_spring": 2e4,
                                "ts_type": "chebyshev", "ts_max_time": 0.4, "initial_height": 0}, 1, "exact")
        truth = exact["runs"][0]["quantities"]["energy_centre"]
        finest = centre["values"][-1]
        self.assertLess(abs(centre["limit"] - truth), 0.2 * abs(finest - truth))
        self.assertAlmostEqual(centre["error"] / abs(finest - truth), 1.0, delta=0.2)


class Strikers(StudyTest):
    FAR = {"support_position": None, "initial_height": 0, "gravity": 0, "striker_position": 5, "striker_mass": 80,
           "striker_gap": 1, "filter_frequency": "100,200"}

    def test_a_beam_that_none_has_touched_is_at_rest(self):
        study, *_ = self.study({**self.FAR, "striker_velocity": -1, "ts_max_time": 0.02})
        for run in study["runs"]:
            found = run["quantities"]
            for name in ("deflection_down", "deflection_up", "energy_centre", "impulse"):
                self.assertAlmostEqual(found[name], 0, delta=1e-12, msg=name)
            # 40 J of the striker, known to the rounding of the difference.
            self.assertAlmostEqual(found["energy_vibration"], 0, delta=1e-12)

    def test_what_a_striker_gives_the_beam_has(self):
        study, *_ = self.study({**self.FAR, "striker_velocity": -20, "striker_restitution": 0.5, "ts_max_time": 0.06,
                                "ts_rtol": 1e-10})
        for run in study["runs"]:
            found = run["quantities"]
            self.assertEqual(found["impulse"], 0)
            self.assertGreater(found["impulse_0"], 1)
            speed = np.sqrt(2 * found["energy_centre"] / STEEL_MASS)
            self.assertAlmostEqual(STEEL_MASS * speed / found["impulse_0"], 1, delta=1e-8)
            self.assertIsNone(found["rebound_velocity"])


class Series(StudyTest):
    SERIES = "points: ; pads: -support_width 1; fine: -support_width 1 -filter_frequency 800"

    def test_series_against_the_limit_of_one(self):
        study, _, out = self.study({"filter_frequency": "100,200,400", "study_series": self.SERIES,
                                    "study_reference": "fine"}, 2)
        self.assertEqual([run["series"] for run in study["runs"]], ["points"] * 3 + ["pads"] * 3 + ["fine"])
        truth = study["runs"][-1]["quantities"]
        self.assertEqual(len(study["work_precision"]), 7)
        for entry in study["work_precision"]:
            run = study["runs"][entry["run"]]
            self.assertEqual(entry["line_solves"], run["quantities"]["line_solves"])
            for name in ("impulse", "deflection_down", "energy_vibration"):
                self.assertEqual(entry["errors"][name], abs(run["quantities"][name] - truth[name]))
        self.assertIn("work and error against the limit of fine", out)
        self.assertEqual(study["series"][0]["axes"][0]["values"], ["100", "200", "400"])

    def test_contact_laws_on_one_table(self):
        study, *_ = self.study({"filter_frequency": "100,200", "study_series":
                                "points: ; pads: -support_width 1; line: -contact_surface line; "
                                "unfiltered: -ts_type moreau -filter_frequency none -ts_dt 4e-4,2e-4"}, 2)
        self.assertEqual({run["state"] for run in study["runs"]}, {"finished"})
        found = {name: [run["quantities"] for run in study["runs"] if run["series"] == name]
                 for name in ("points", "pads", "line", "unfiltered")}
        for runs in found.values():
            self.assertEqual(len(runs), 2)
            for one in runs:
                # Whatever the law: the momentum of a beam in flight is what the supports gave. 1e-6: -ts_rtol 1e-7.
                speed = np.sqrt(2 * one["energy_centre"] / STEEL_MASS)
                self.assertAlmostEqual(STEEL_MASS * (speed + 9.81 * 0.55) / one["impulse"], 1.0, delta=1e-6)
        self.assertGreater(found["points"][1]["penetration"], 0.01)
        self.assertLess(found["line"][1]["penetration"], 1e-12)
        self.assertEqual(found["unfiltered"][0]["energy_springs"], 0.0)

    def test_pictures(self):
        self.study({"filter_frequency": "100,200,400", "study_series": self.SERIES}, 2)
        result = subprocess.run([sys.executable, PLOT, "study", str(self.scratch / "study")], capture_output=True,
                                text=True, timeout=240, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        drawn = {pathlib.Path(line).name for line in result.stdout.splitlines()}
        self.assertEqual(drawn, {f"{name}.{kind}" for kind in ("png", "svg") for name in
                                 ("study-filter_frequency", "study-work-line_solves", "study-work-wall_seconds")})
        svg = (self.scratch / "study/plots/study-filter_frequency.svg").read_text(encoding="utf-8")
        for text in ("points", "pads", "impulse [kN s]", "penetration [m]", "filter frequency wf [rad/s]"):
            self.assertIn(text, svg)
        chosen = subprocess.run([sys.executable, PLOT, str(self.scratch / "study"), "--pictures", "gauges"],
                                capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(chosen.returncode, 2)
        self.assertIn("--pictures: the pictures of a study are drawn all", chosen.stderr)
        self.assertGreater((self.scratch / "study/plots/study-work-line_solves.png").stat().st_size, 20_000)


class Failures(StudyTest):
    def test_failed_run_is_shown_and_the_others_finish(self):
        for ranks, group in ((1, 1), (2, 1), (2, 2)):
            with self.subTest(ranks=ranks, group=group):
                name = f"np{ranks}-{group}"
                study, rows, out = self.study(
                    {"filter_frequency": "100,200", "study_ranks": group, "study_series":
                     "good: ; low: -support_height 1.5; wild: -ts_type rk -ts_adapt_type none -ts_dt 0.1; last: "},
                    ranks, name, code=1)
                self.assertEqual(list(rows["state"]), ["finished"] * 2 + ["failed"] * 4 + ["finished"] * 2)
                reasons = [run["reason"] for run in study["runs"]]
                self.assertEqual(reasons[:2] + reasons[6:], [None] * 4)
                for reason in reasons[2:4]:
                    self.assertIn("-support_height", reason)
                for reason in reasons[4:6]:
                    self.assertIn("unstable", reason)
                self.assertRegex(out, r"run 2 failed: option -support_height")
                # Those that finish are not touched by those that fail.
                self.assertEqual(study["runs"][0]["quantities"]["impulse"], study["runs"][6]["quantities"]["impulse"])

    def test_run_without_an_end_is_not_compared(self):
        study, rows, _ = self.study({"filter_frequency": "100,200", "ts_max_steps": 5}, code=3)
        self.assertEqual(set(rows["state"]), {"stopped"})
        self.assertEqual(study["work_precision"], [])

    def test_interrupted_study_shows_what_is_there(self):
        folder = self.scratch / "study"
        process = start(line_of({**CASE, "output_directory": folder, "filter_frequency": "100,20000",
                                 "beam_elements": 2000, "floor": True, "support_position": None, "initial_slope": 0.01,
                                 "ts_max_time": 1000, "study_series": "a: -ts_max_time 0.1; b: "}, 1))
        deadline = time.monotonic() + 60
        while not (folder / "run-003" / "energy.csv").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, out + err)
        states = [run["state"] for run in json.loads((folder / "study.json").read_text())["runs"]]
        self.assertIn("stopped", states)
        self.assertIn("not run", states)
        self.assertIn("udar-study: results in", out)


class BadInput(StudyTest):
    def refused(self, options, expected, ranks=1, code=1):
        folder = self.scratch / "none"
        result = finished(line_of({**CASE, "output_directory": folder, **options}, ranks))
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        errors = [line for line in result.stderr.splitlines() if line.startswith("udar: error:")]
        self.assertEqual(len(errors), 1, result.stderr)
        self.assertIn(expected, errors[0])
        self.assertFalse((folder / "study.json").exists())

    def test_each_is_one_line(self):
        for ranks in (1, 2):
            for options, expected in (
                    ({"study_axes": "suport_width"}, "-study_axes: -suport_width"),
                    ({"filter_frequency": "100,,200"}, "-filter_frequency: ''"),
                    ({"filter_frequency": "100,a"}, "-filter_frequency: 'a'"),
                    ({"study_ranks": 3}, "-study_ranks: 3"),
                    ({"study_ranks": 0}, "-study_ranks"),
                    ({"study_series": "nameless"}, "-study_series"),
                    ({"study_reference": "nobody"}, "'nobody'"),
                    ({"study_design": "cube"}, "-study_design"),
                    ({"study_sries": "a:"}, "-study_sries; the nearest known option is -study_series")):
                with self.subTest(ranks=ranks, options=options):
                    self.refused(options, expected, ranks)

    def test_keeps_a_study_that_is_there(self):
        self.study({"filter_frequency": "100,200"})
        before = (self.scratch / "study/study.json").read_text()
        self.refused({"output_directory": self.scratch / "study"}, "already holds a study")
        self.assertEqual((self.scratch / "study/study.json").read_text(), before)
        self.study({"filter_frequency": 100, "output_overwrite": True})

    def test_without_arguments_it_says_how_it_is_used(self):
        result = finished([STUDY])
        self.assertEqual(result.returncode, 1)
        self.assertIn("usage:  udar-study case.yaml", result.stdout)

    def test_help(self):
        result = finished([STUDY, "-help"])
        self.assertEqual(result.returncode, 0, result.stderr)
        for key in ("axes", "series", "reference", "design", "refine", "ranks"):
            self.assertIn(f"-study_{key}", result.stdout)


if __name__ == "__main__":
    unittest.main()
