#!/usr/bin/env python3
# ranks: 1; size: medium
"""Imported matrices through the program: a beam's own, a solid bar's, bad ones."""

import pathlib
import re
import subprocess
import sys
import unittest

import h5py
import numpy as np

from common import ENVIRONMENT, ROOT, STOPPED_BY_STEPS, UDAR, UdarTest, arguments, datasets, run

EXAMPLE = ROOT / "examples" / "01-falling-beam" / "case.yaml"
STUDY = pathlib.Path(UDAR).with_name("udar-study")
MAKE_BAR = ROOT / "examples" / "05-bar" / "make_bar.py"
SIDE = 0.1 * np.sqrt(3)  # of the bar [m]
# Example 01 at 50 rad/s is not chaotic in its 1.5 s: from a height that differs by 1e-15 of itself its curves are
# 2e-13 m apart at the end. (At 100 rad/s 1e-10 m/s, with the first impact of another order at 1.4 s: before it the
# imported beam is 3e-11 m away, after it 2e-10 m.)
BEFORE_CHAOS = 1.5
# [m] The rounding of assembled entries, which rigid motions do not cancel: (w_max / wf)^2 eps = 4e-9 of the line's
# stretch of 4 mm under gravity in flight; 4e-11 m measured. Velocities by wf.
APART = 1e-10


def imported(prefix, **changes):
    return {
        "structure_type": "import",
        "structure_stiffness": f"{prefix}-stiffness.mtx",
        "structure_mass": f"{prefix}-mass.mtx",
        "structure_points": f"{prefix}-points.csv",
        **changes,
    }


def read_state(path):
    """Positions and velocities of the masses in a restart file."""
    with h5py.File(path) as file:
        return np.concatenate([file[f"node_fields/{name}"][()] for name in ("mass_position", "mass_velocity")])


class ImportedBeam(UdarTest):
    """Example 01, written by udar and imported again."""

    def setUp(self):
        super().setUp()
        text = EXAMPLE.read_text()
        self.file = self.scratch / "case.yaml"  # the same without its beam
        self.file.write_text("gravity" + text.split("gravity", 1)[1])
        self.times = {"filter_frequency": 50, "ts_max_time": BEFORE_CHAOS}
        self.beam = self.run_case(
            {"options_file": EXAMPLE, "structure_write": self.scratch / "beam", **self.times}, name="beam")

    def test_it_moves_as_the_beam_that_wrote_it(self):
        for ranks in (1, 2, 3):
            # All of it on one rank; on more past the first contact, which lasts 0.21 s: messages of MUMPS take time.
            until = BEFORE_CHAOS if ranks == 1 else 0.7
            again = self.run_case({"options_file": self.file, **self.times, "ts_max_time": until,
                                   **imported(self.scratch / "beam")}, ranks, name=f"np{ranks}")
            for name in ("mass", "velocity", "line"):
                for gauge in range(5):
                    column = f"{name}_{gauge}"
                    curve = again.csv("gauges.csv")[column]
                    apart = np.abs(curve - self.beam.csv("gauges.csv")[column][:len(curve)]).max()
                    allowed = APART * (50 if name == "velocity" else 1)
                    self.assertLess(apart, allowed, f"{column} on {ranks} ranks")
            there, here = (datasets(run.file("results.h5")) for run in (self.beam, again))
            for name in ("mass_position", "mass_velocity", "line_position"):
                rows = here[f"fields/{name}"]
                apart = np.abs(rows - there[f"fields/{name}"][:len(rows)]).max()
                self.assertLess(apart, APART * (50 if name == "mass_velocity" else 1), f"{name} on {ranks} ranks")

    def test_all_that_a_beam_does_it_does(self):
        motion = self.scratch / "motion.csv"
        motion.write_text("0,0\n0.2,0.01\n0.6,-0.02\n2,0\n")
        load = self.scratch / "load.csv"
        load.write_text("0,0\n0.1,2000\n0.3,2000\n0.3,-500\n1,0\n")
        loads = {"load_position": 3, "load_table": load}
        springs = {"support_stiffness": 2e6, "support_damping": 1e4}
        # Where impacts are many or on what moves, the run's own tolerance shows: at -ts_rtol 1e-11 the beam's curves
        # are 8e-10 m off with the motion, 7e-9 m with the tilted fall on a floor, 9e-10 m with the line on springs.
        cases = [
            ({"ts_type": "rk", "damping_mass": 0.5}, APART),
            ({"ts_type": "chebyshev", **loads}, APART),
            ({"damping_mass": 0.5, "damping_stiffness": 1e-3}, APART),
            (springs, APART),
            ({"support_motion": motion}, 1e-8),
            ({"floor": True, "floor_height": 0.1, "initial_slope": 0.01, "initial_angular_velocity": 0.2}, 1e-8),
            ({"contact_restitution": 0.5, "support_yield_speed": 0.5, **loads}, APART),
            ({"filter_correct_modes": 3}, APART),
            ({"filter_frequency": "auto"}, APART),
            ({"contact_surface": "line", "support_stiffness": 2e6}, 1e-8),
            ({"contact_surface": "line", "support_motion": motion}, APART),
        ]
        for number, (changes, apart) in enumerate(cases):
            asked = {**self.times, "ts_max_time": 0.6, "output_field_interval": 0, **changes}
            beam = self.run_case({"options_file": EXAMPLE, **asked}, name=f"beam{number}").csv("gauges.csv")
            again = self.run_case({"options_file": self.file, **asked, **imported(self.scratch / "beam")},
                                  name=f"import{number}").csv("gauges.csv")
            for column in (f"{name}_{gauge}" for name in ("mass", "line") for gauge in range(5)):
                self.assertEqual(len(again[column]), len(beam[column]), changes)
                self.assertLess(np.abs(again[column] - beam[column]).max(), apart, f"{column} of {changes}")

    def test_a_study_runs_on_it(self):
        options = {**imported(self.scratch / "beam"), "filter_frequency": "50,100", "ts_max_time": 0.5}
        done = subprocess.run([STUDY, self.file, *arguments({**options, "output_directory": self.scratch / "study"})],
                              capture_output=True, text=True, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"impulse \[N s\] +[0-9.]+")

    def test_a_restart_goes_on_with_another_number_of_ranks(self):
        options = {"options_file": self.file, **self.times, "ts_max_time": 0.6, "output_field_interval": 0,
                   **imported(self.scratch / "beam")}
        whole = self.run_case(options, name="whole")
        self.run_case({**options, "ts_max_steps": 4}, 3, name="part", code=STOPPED_BY_STEPS)
        rest = self.run_case({**options, "restart_file": self.scratch / "part" / "restart.h5"}, 2, name="rest")
        for column in ("mass_0", "line_2", "velocity_4"):
            apart = rest.csv("gauges.csv")[column][-1] - whole.csv("gauges.csv")[column][-1]
            self.assertLess(abs(apart), 1e-10, column)
        files = [read_state(run.file("restart.h5")) for run in (whole, rest)]
        np.testing.assert_allclose(files[1], files[0], rtol=0, atol=1e-10)  # in the order of the matrices


class SolidBar(UdarTest):
    """The bar of example 05 on a coarse mesh: 1107 unknowns."""

    def setUp(self):
        super().setUp()
        self.prefix = self.scratch / "bar"
        subprocess.run([sys.executable, MAKE_BAR, "--elements", "40", "2", "2", self.prefix], check=True,
                       capture_output=True)
        self.options = {
            "structure_type": "import",
            "structure_stiffness": f"{self.prefix}-stiffness.bin",
            "structure_mass": f"{self.prefix}-mass.bin",
            "structure_points": f"{self.prefix}-points.csv",
            "initial_height": 1 + SIDE / 2,
            "support_position": "2,8",
            "gauge_position": "0,5",
            "ts_max_time": 0.5,
        }

    def test_its_bending_frequencies_are_those_of_the_beam(self):
        shown = self.run_case({**self.options, "filter_frequency": "auto", "filter_band": 320, "udar_view": True,
                               "ts_max_time": 1e-3})
        rows = re.findall(r"^ +[1-6] +([0-9.]+) +[0-9.]+ +-?[0-9.]+ %", shown.out.split("as built")[1], re.MULTILINE)
        found = np.array(rows, float)
        bending = np.sqrt(2.1e11 / 7850) * 0.05 * (np.array([4.730041, 7.853205, 10.995608]) / 10) ** 2
        # Bending in both planes of the square; a solid gives way to shear and turns its sections: -0.3, -0.5, -0.8 %.
        np.testing.assert_allclose(found, np.repeat(bending, 2), rtol=0.012)
        self.assertIn("unknowns                                    1107", shown.out)
        self.assertRegex(shown.out, "the filter with impact +(pays|does not pay)")

    def test_its_underside_lands_on_the_supports(self):
        drop, fall = 0.01, {"filter_frequency": 200, "initial_height": 0.01 + SIDE / 2, "ts_max_time": 0.047}
        for name, changes in (("mass", {}), ("line", {"contact_surface": "line"})):
            fallen = self.run_case({**self.options, **fall, **changes}, name=name)
            summary = fallen.summary()
            # The underside starts above the supports by the drop, the massless solid by its weight's stretch less.
            way = drop - (9.81 / 200**2 if changes else 0)
            # Forces on the solid begin at a kink that is estimated from the gaps at the points of a step.
            located = 1e-6 if changes else 1e-9
            self.assertAlmostEqual(summary["first_contact_time"], np.sqrt(2 * way / 9.81), delta=located)
            self.assertLess(abs(summary["energy_drift"]), 1e-6)
            with h5py.File(fallen.file("results.h5")) as file:
                down = file["direction"][()] == 2
                self.assertEqual(len(down), 1107)
                self.assertAlmostEqual(file["mass"][()][down].sum(), 2355, delta=1e-6)
                impacts = file["impacts"][()]  # none with forces on the solid
                touched = impacts["node"][impacts["time"] < summary["first_contact_time"] + 1e-4]
                for node in touched:
                    self.assertLess(file["y"][node], -SIDE / 2 + 1e-12)
                    self.assertTrue(down[node])
        self.assertGreater(summary["min_line_gap"], -1e-12, "contact forces hold the solid off")

    def test_a_restart_knows_its_matrices_on_any_number_of_ranks(self):
        options = {**self.options, "filter_frequency": 200, "ts_max_time": 0.01, "output_field_interval": 0,
                   "ts_adapt_dt_max": 0.002}  # else it is one rigid flight
        self.run_case({**options, "ts_max_steps": 2}, 3, name="part", code=STOPPED_BY_STEPS)
        rest = {**options, "restart_file": self.scratch / "part" / "restart.h5"}
        self.run_case(rest, 2, name="rest")
        other = run({**rest, "structure_lumping": "hrz", "output_directory": self.scratch / "other"})
        self.assertEqual(other.code, 1, other)
        self.assertIn("stiffness and masses, checksum", other.errors[0])


class BadMatrices(UdarTest):
    """What is refused; the kinds of bad matrices are in tests/mpi/imported_test.cpp."""

    def refused(self, *words, **changes):
        options = {"structure_type": "import", "structure_stiffness": self.scratch / "k.mtx",
                   "structure_mass": self.scratch / "m.mtx", "filter_frequency": 10, **changes}
        for ranks in (0, 2):
            failed = run({"output_directory": self.scratch / "run", **options}, ranks)
            self.assertEqual(failed.code, 1, failed)
            self.assertEqual(len(failed.errors), 1, failed)
            for word in words:
                self.assertIn(word, failed.errors[0])

    def test_are_refused_by_name(self):
        head = "%%MatrixMarket matrix coordinate real general\n2 2 "
        (self.scratch / "m.mtx").write_text(head + "2\n1 1 1\n2 2 1\n")
        (self.scratch / "k.mtx").write_text(head + "4\n1 1 1\n2 2 1\n1 2 -2\n2 1 -2\n")
        self.refused("-structure_stiffness", "unknown 1", "indefinite")
        (self.scratch / "k.mtx").write_text(head + "2\n1 1 1\n2 2 1\n")
        (self.scratch / "points.csv").write_text("0,0,0\n")
        self.refused("-structure_points", "1 places", "2 unknowns", structure_points=self.scratch / "points.csv")
        (self.scratch / "points.csv").write_text("0,0,0,1\n1,0,0,3\n")
        self.refused("-structure_points", "along y", structure_points=self.scratch / "points.csv")
        (self.scratch / "points.csv").write_text("0,0,0,2\n1,0,0,4\n")
        self.refused("-structure_points", "row 2", structure_points=self.scratch / "points.csv")
        self.refused("-structure_mass", "missing.mtx", structure_mass=self.scratch / "missing.mtx")
        self.refused("-filter_frequency", "none", filter_frequency="none", ts_dt=0.1)
        self.refused("-ts_type", "modal", "imported", ts_type="modal", filter_frequency=None)
        self.refused("-beam_length", "import", beam_length=3)
        self.refused("-gauge_position", gauge_position=7)


if __name__ == "__main__":
    unittest.main()
