#!/usr/bin/env python3
# size: medium
"""The examples run as their READMEs say, cut short, and do what these say of them."""

import os
import pathlib
import re
import subprocess
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from common import ROOT, UdarTest, run

EXAMPLES = ROOT / "examples"


class Examples(UdarTest):
    def example(self, folder, ranks=0, name="run", **changes):
        """One run of an example's case, from a folder of its own."""
        return self.run_case({"options_file": EXAMPLES / folder / "case.yaml", **changes}, ranks, name=name,
                             cwd=self.scratch)

    def test_02_line_stays_on_the_supports_that_masses_sink_through(self):
        gaps = {}
        for name, changes in {
            "points": {"filter_frequency": 100},
            "patches": {"filter_frequency": 100, "support_width": 0.5},
            "line": {"filter_frequency": 100, "contact_surface": "line"},
            "unfiltered": {"filter_frequency": "none", "ts_dt": 2e-4},
        }.items():
            run = self.example("02-supports", name=name, **changes)
            gaps[name] = run.summary()["min_line_gap"]
            self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-5, run)
        # README: 20 cm, 12 cm, on them, below 1 mm.
        self.assertAlmostEqual(gaps["points"], -0.20, delta=0.01)
        self.assertAlmostEqual(gaps["patches"], -0.118, delta=0.005)
        self.assertGreater(gaps["line"], -1e-12)
        self.assertGreater(gaps["unfiltered"], -1e-3)

    def test_03_tip_stays_between_its_stops(self):
        run = self.example("03-stops", ts_max_time=0.2)
        tip = run.csv("gauges.csv")["line_1"]
        self.assertLess(np.abs(tip).max(), 0.002 + 1e-12, run)
        self.assertGreater(np.abs(tip).max(), 0.0019, "it touches")
        impulse = run.summary()["support_impulse"]
        self.assertGreater(impulse[0], 0)
        self.assertLess(impulse[1], 0)
        energy = run.csv("energy.csv")
        late = energy["time"] > 0.1  # before, there is next to no energy to relate the drift to
        self.assertLess(np.abs(energy["drift"][late]).max(), 1e-4, run)

    def test_tables_are_looked_for_from_here_then_beside_the_case(self):
        folder = self.scratch / "case"
        folder.mkdir()
        case = folder / "case.yaml"
        case.write_text((EXAMPLES / "03-stops" / "case.yaml").read_text())
        beside = {"options_file": case, "ts_max_time": 0.01, "output_overwrite": True}
        missing = run({"output_directory": self.scratch / "run", **beside}, cwd=self.scratch)
        self.assertEqual(missing.code, 1, missing)
        for text in ("-load_table", "'force.csv'", "working directory", f"'{folder}/force.csv'"):
            self.assertIn(text, missing.err)
        deflections = []
        for place, force in ((folder, 4.0), (self.scratch, 8.0)):  # the second found before the first
            (place / "force.csv").write_text(f"0,{force}\n1,{force}\n")
            found = self.run_case(beside, cwd=self.scratch)
            deflections.append(found.csv("gauges.csv")["line_1"][-1])
        self.assertGreater(abs(deflections[0]), 0.0)
        self.assertAlmostEqual(deflections[1] / deflections[0], 2.0, delta=1e-6)  # linear: no stop is reached

    def test_04_pipeline_touches_its_highest_sleepers_first(self):
        run = self.example("04-pipeline", ranks=2, beam_elements=4000, ts_max_time=0.25)
        summary = run.summary()
        self.assertAlmostEqual(summary["first_contact_time"], 0.2389, delta=1e-3)
        touched = np.array(summary["support_impulse"]) > 0
        self.assertTrue(0 < touched.sum() < 200, touched.sum())
        self.assertGreater(summary["min_line_gap"], -1e-10, run)

    def test_04_case_is_what_its_script_writes(self):
        script = EXAMPLES / "04-pipeline" / "make_case.py"
        written = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout
        self.assertEqual(written, (script.parent / "case.yaml").read_text())

    def test_06_feet_land_together(self):
        run = self.example("06-grillage", filter_frequency=500, ts_max_time=0.16)
        summary = run.summary()
        # The massless grillage hangs lower than its masses by their weight over their springs.
        fall = 0.1 - 9.81 / 500**2
        self.assertAlmostEqual(summary["first_contact_time"], np.sqrt(2 * fall / 9.81), delta=1e-6)
        self.assertGreater(summary["min_line_gap"], -1e-12, run)
        left, right = summary["support_impulse"]
        self.assertGreater(left, 1000)
        self.assertAlmostEqual(left / right, 1.0, delta=1e-8)  # README: to nine digits
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-6, run)
        # Members lie over each other along x: they are drawn in space.
        self.assertFalse(run.file("envelope.csv").exists())
        drawn = subprocess.run([os.environ["UDAR_PLOT"], run.directory], capture_output=True, text=True, check=True)
        self.assertEqual(drawn.stderr, "")
        pictures = {path.stem for path in (run.directory / "plots").iterdir()}
        self.assertEqual(pictures, {"gauges", "energy", "contacts", "impulses", "forces", "structure", "deformation"})

    def test_06_network_is_what_its_script_writes(self):
        script = EXAMPLES / "06-grillage" / "make_network.py"
        written = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout
        self.assertEqual(written, (script.parent / "network.yaml").read_text())

    def test_07_wave_lifts_one_portal_after_the_other(self):
        run = self.example("07-pipe-rack", ts_max_time=0.8)
        self.assertIn("modes     10.94, 13.94, 14.53 rad/s", run.out)
        rows = run.csv("contact.csv")
        before = np.argmin(np.abs(rows["time"] - 0.5))
        impulses = np.array([rows[f"impulse_{portal}"] for portal in range(4)])
        # Before the wave the rack is its own mirror image, and swings about its weight.
        np.testing.assert_allclose(impulses[:2, before], impulses[:1:-1, before], rtol=1e-8)
        weight = float(re.search(r"network +(\d+) kg", run.out).group(1)) * 9.81
        self.assertAlmostEqual(impulses[:, before].sum() / (0.5 * weight), 1.0, delta=0.02)
        # README: 0.62 s, where the ground stops faster than what it carries falls; the others later.
        pressed = [rows["time"][1:][np.diff(impulse) > 0].max() for impulse in impulses]
        self.assertAlmostEqual(pressed[0], 0.62, delta=0.01)
        self.assertLess(pressed[0] + 0.03, pressed[1])
        self.assertLess(pressed[1] + 0.03, min(pressed[2:]))
        self.assertGreater(run.summary()["min_line_gap"], -1e-12, run)
        energy = run.csv("energy.csv")
        self.assertLess(np.abs(energy["drift"]).max(), 1e-6, run)
        self.assertGreater(energy["support_work"][-1], 1e3)

    def test_07_ground_is_what_its_script_writes(self):
        script = EXAMPLES / "07-pipe-rack" / "make_ground.py"
        subprocess.run([sys.executable, script, self.scratch], check=True)
        for portal in range(4):
            name = f"ground-{portal}.csv"
            self.assertEqual((self.scratch / name).read_text(), (script.parent / name).read_text())

    def test_08_runs_of_an_upright_bar_are_drawn_over_each_other(self):
        runs = [self.example("08-bar-on-wall", name=f"N{n}", filter_frequency=1e4, network_elements=n, ts_max_time=2e-3)
                for n in (20, 30)]
        for run in runs:
            self.assertAlmostEqual(run.summary()["first_contact_time"], 1e-3, delta=1e-9)
        drawn = subprocess.run([os.environ["UDAR_PLOT"], *(run.directory for run in runs), "--output", self.scratch],
                               capture_output=True, text=True, check=True)
        self.assertNotIn("Warning", drawn.stderr)
        self.assertTrue((self.scratch / "gauges.png").exists())

    def test_10_load_cell_shows_the_closed_form(self):
        run = self.example("10-drop-weight", name="fine", beam_elements=60, ts_max_time=1.5e-3)
        rows = self.table("10-drop-weight", run)
        self.assertEqual([row[0] for row in rows], ["closed form", "fine"])
        self.assertAlmostEqual(float(rows[0][1]), 10.38, delta=0.01)
        self.assertLess(float(rows[1][5]), 0.3)  # README: 0.18 %
        # Bar and weight part, and meet again.
        touch = run.csv("contact.csv")["force_0"] > 0
        self.assertEqual(np.count_nonzero(np.diff(touch.astype(int)) == 1), 2)

    def table(self, folder, *runs):
        """What the table of an example prints, without its head."""
        printed = subprocess.run([sys.executable, EXAMPLES / folder / "table.py", *(run.directory for run in runs)],
                                 capture_output=True, text=True, check=True)
        return [[cell.strip() for cell in line.split("|")[1:-1]] for line in printed.stdout.splitlines()[2:]]

    def test_11_restraint_takes_the_work_of_crushing(self):
        run = self.example("11-pipe-whip", beam_elements=40, filter_frequency=5e3, ts_max_time=0.15)
        row = self.table("11-pipe-whip", run)[0]
        self.assertEqual(float(row[1]), 30.0)
        self.assertGreater(float(row[3]), 600)
        self.assertAlmostEqual(float(row[3]), float(row[4]), delta=0.5)
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-5)  # while next to nothing moves
        self.assertLess(np.abs(run.csv("energy.csv")["drift"][-1]), 1e-8)

    def test_12_bearings_carry_the_weight_and_let_go(self):
        run = self.example("12-bridge", beam_elements=40, filter_frequency=200, load_axles_start=5, ts_max_time=5.6)
        statics, left, middle, far = self.table("12-bridge", run)
        self.assertEqual(statics[2], "44.13")
        for bearing, share in ((left, 0.375), (middle, 1.25), (far, 0.375)):
            self.assertAlmostEqual(float(bearing[2]), share * 599.74 * 9.81 * 20 / 1e3, delta=0.3)
        self.assertEqual(float(left[4]), 0)
        self.assertGreater(float(far[4]), 0.1)
        self.assertAlmostEqual(float(far[6]), float(statics[6]), delta=1.0)
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-8)

    def test_12_carries_axles_on_springs(self):
        run = self.example("12-bridge", options_file=EXAMPLES / "12-bridge" / "carried.yaml", beam_elements=80,
                           filter_frequency=200)
        gauges, axles = run.csv("gauges.csv"), run.csv("axles.csv")
        for gauge, sag in ((0, 82.0), (1, 114.7)):  # README; so coarse the second is found 0.7 mm less
            self.assertAlmostEqual(-1e3 * gauges[f"line_{gauge}"].min(), sag, delta=1.0)
        on = (axles["x_3"] > 0) & (axles["x_3"] < 40)
        self.assertAlmostEqual(-axles["force_3"][on].min() / 1e3, 586, delta=10)
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-8)

    def test_13_frames_meet_when_they_would_pass(self):
        runs = [self.example("13-pounding", name=name, pair_gap=gap, ts_max_time=1.25)
                for name, gap in (("near", 0.015), ("free", 0.1))]
        near, free = self.table("13-pounding", *runs)
        self.assertEqual((near[1], free[1]), ("2", "0"))
        self.assertAlmostEqual(float(near[2]), float(near[3]), delta=1.5e-4)  # digits; rows of 2 ms by straight lines
        self.assertAlmostEqual(float(near[2]), 0.5642, delta=1e-3)  # README
        self.assertGreater(float(near[8]), 3 * float(free[8]))
        self.assertLess(np.abs(runs[0].csv("energy.csv")["drift"]).max(), 1e-6)
        page = self.scratch / "page.html"
        subprocess.run([os.environ["UDAR_REPORT"], runs[0].directory, "--output", page], check=True, timeout=120)
        said = re.search(r"into [\w ]+ that give way", page.read_text(encoding="utf-8"))
        self.assertEqual(said and said[0], "into pairs that give way")


if __name__ == "__main__":
    unittest.main()
