#!/usr/bin/env python3
# ranks: 1 2; size: long
"""A restarted run goes on as if it had never stopped: bit for bit on the same number of ranks."""

import os
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import STOPPED_BY_STEPS, UdarTest, case, datasets
from hard_cases import CORRECTED, CORRECTED_LINE, CROSSED, DAMPED, FORMULAS, GIVING, LAWS, LINE_CONTACT, MODAL
from hard_cases import MODAL_LOADED, MOTION, MOVING_LINE, SHAKEN

RANKS = int(os.environ.get("UDAR_RANKS", "1"))


# What each run knows of its own files.
OF_OWN_FILES = ("tables/results.h5 extents", "tables/pictures")


def lines(path):
    return path.read_text().splitlines()


class Restart(UdarTest):
    def check(self, steps, **changes):
        """A run to the end, against one stopped after some steps and gone on with from its restart file."""
        options = case(ts_max_time=0.8, restart_interval=0.1, output_field_interval=0.1, **changes)
        whole = self.run_case(options, RANKS, name="whole")
        first = self.run_case({**options, "ts_max_steps": steps}, RANKS, name="first", code=STOPPED_BY_STEPS)
        second = self.run_case({**options, "restart_file": first.file("restart.h5")}, RANKS, name="second")
        for name in ("gauges.csv", "energy.csv", "impacts.csv", "rests.csv", "contact.csv"):
            all_rows, head, tail = (lines(run.file(name)) for run in (whole, first, second))
            self.assertEqual(tail[0], all_rows[0], f"header of {name}")
            if name == "gauges.csv":
                self.assertLess(len(head), len(all_rows), f"the first run was stopped before its end{first}")
            self.assertEqual(tail[1:], all_rows[len(all_rows) - len(tail) + 1 :], f"{name} after the restart{second}")
            self.assertGreaterEqual(len(head) + len(tail) - 1, len(all_rows), f"{name}: rows are missing{second}")
        self.assertEqual(lines(second.file("envelope.csv")), lines(whole.file("envelope.csv")), "of both runs together")
        expected, found = datasets(whole.file("restart.h5")), datasets(second.file("restart.h5"))
        self.assertEqual(sorted(found), sorted(expected))
        for name, value in expected.items():
            if not name.startswith(("texts/", *OF_OWN_FILES)):
                np.testing.assert_array_equal(found[name], value, err_msg=f"restart.h5:/{name} at the end")
        for key in ("impacts", "rests", "releases", "first_contact_time", "last_contact_time", "min_line_gap",
                    "support_impulse", "force_window", "peak_support_force"):
            self.assertEqual(second.summary()[key], whole.summary()[key], f"summary.json: {key}{second}")


def add_test(name, steps, changes):
    setattr(Restart, f"test_{name}_after_{steps}_steps", lambda self: self.check(steps, **changes))


# Steps after which some mass has hit or rests, and before the end.
UNFILTERED = {"filter_frequency": "none", "ts_dt": 5e-4, "contact_restitution": 0.5}
DAMPED_SPRINGS = {"contact_restitution": 1, "support_stiffness": 2e6, "support_damping": 1e3}
STOPS = {1: {"rk": 60, "chebyshev": 5, "impact": 15}, 2: {"rk": 150, "chebyshev": 8, "impact": 20}}[RANKS]
for name, changes in {
    "elastic": {"contact_restitution": 1},
    "plastic": {"contact_restitution": 0.5},
    "tilted_floor": {"support_position": None, "floor": True, "contact_restitution": 0.5, "initial_slope": 0.02},
    "moving_and_giving": {**GIVING, "ts_rtol": 1e-8},
    "damped": {**GIVING, **DAMPED, "ts_rtol": 1e-8},
    "corrected_modes": {**CORRECTED, "contact_restitution": 0.5},
    "shaken": {**SHAKEN, "contact_restitution": 0.5},
}.items():
    for integrator, steps in STOPS.items():
        if name in ("moving_and_giving", "damped") and integrator == "chebyshev":
            continue
        add_test(f"{name}_by_{integrator}", steps, {**changes, "ts_type": integrator})

MANY = {"contact_line_dense_max": 0, "floor": True, "initial_slope": 0.02}
for integrator, steps, changes, name in (
    ("rk", 150, LINE_CONTACT, "line_contact"),
    ("impact", 15, LINE_CONTACT, "line_contact"),
    ("chebyshev", 3, LINE_CONTACT, "line_contact"),
    ("chebyshev", 4, {**LINE_CONTACT, "support_stiffness": 2e6}, "line_on_springs"),
    ("rk", 150, CORRECTED_LINE, "corrected_line"),
    ("impact", 15, CORRECTED_LINE, "corrected_line"),
    ("chebyshev", 5, CORRECTED_LINE, "corrected_line"),
    ("moreau", 950, UNFILTERED, "unfiltered"),
    ("moreau", 950, {**UNFILTERED, "support_motion": MOTION}, "unfiltered_on_moving_supports"),
    ("moreau", 950, {**UNFILTERED, **DAMPED_SPRINGS}, "unfiltered_on_springs"),
    ("rk", 150, MOVING_LINE, "moving_and_giving_line"),
    ("impact", 20, MOVING_LINE, "moving_and_giving_line"),
    ("impact", 60, {**LAWS, "ts_rtol": 1e-8, "contact_restitution": 1}, "contact_laws"),
    ("rk", 150, {**MOVING_LINE, "contact_line_dense_max": 0}, "moving_and_giving_many"),
    ("impact", 20, {**MOVING_LINE, "contact_line_dense_max": 0}, "moving_and_giving_many"),
    ("rk", 150, {**LINE_CONTACT, **MANY}, "many_contact_nodes"),
    ("impact", 20, {**LINE_CONTACT, **MANY}, "many_contact_nodes"),
    ("modal", 3, MODAL, "rigid_points"),
    ("modal", 2, {**MODAL, "support_stiffness": 1e8}, "springs"),
    ("modal", 6, MODAL_LOADED, "all"),
    ("modal", 6, {**MODAL, **SHAKEN, "support_stiffness": 1e7}, "shaken"),
    ("moreau", 950, {**UNFILTERED, **SHAKEN}, "shaken"),
    ("impact", 20, {**CROSSED, "contact_restitution": 0.5}, "crossed"),
    ("chebyshev", 25, {**FORMULAS, "contact_restitution": 0.5}, "formulas"),
    ("impact", 30, {**FORMULAS, "contact_restitution": 0.5}, "formulas"),
    ("modal", 25, {**MODAL, **FORMULAS, "support_stiffness": 1e7}, "formulas"),
):
    add_test(f"{name}_by_{integrator}", steps, {**changes, "ts_type": integrator})



ALL = ("chebyshev", "impact", "rk")


class TakeOver(UdarTest):
    """A run goes on by another integrator from masses and contact: as exactly as both of them are."""

    def check(self, writers, readers, steps, error, **changes):
        options = case(ts_max_time=0.8, **changes)
        exact = self.run_case({**options, "ts_type": writers[0]}, RANKS, name="exact").csv("gauges.csv")
        for writer in writers:
            first = self.run_case(
                {**options, "ts_type": writer, "ts_max_steps": steps[writer]}, RANKS, name=f"by_{writer}",
                code=STOPPED_BY_STEPS,
            )
            for reader in readers:
                if reader == writer:
                    continue
                with self.subTest(writer=writer, reader=reader):
                    second = self.run_case(
                        {**options, "ts_type": reader, "restart_file": first.file("restart.h5")}, RANKS,
                        name=f"from_{writer}_by_{reader}",
                    )
                    self.assertRegex(second.out, rf"written by -ts_type {writer}: {reader} takes over", second)
                    found = second.csv("gauges.csv")
                    self.assertGreater(len(found["time"]), 5, second)
                    self.assertLess(first.csv("gauges.csv")["time"][-1], found["time"][0], second)
                    for name, values in found.items():
                        if not name.startswith("velocity_"):
                            off = np.abs(values - exact[name][-len(values):]).max()
                            self.assertLess(off, error, f"{name}{second}")
                    self.assertLess(abs(second.csv("energy.csv")["drift"]).max(), 1e-4, second)

    def test_masses_that_rest_and_bounce(self):
        self.check(ALL, ALL, {"chebyshev": 3, "impact": 15, "rk": 70}, 1e-3, contact_restitution=0, ts_rtol=1e-10)

    def test_masses_on_springs_with_dampers(self):
        self.check(("rk", "impact"), ("impact", "rk"), {"rk": 120, "impact": 60}, 1e-5, support_stiffness=1e5,
                   support_damping=1e3, contact_restitution=1, ts_rtol=1e-9)

    def test_line(self):
        self.check(ALL, ALL, {"chebyshev": 3, "impact": 15, "rk": 95}, 1e-5, contact_surface="line", ts_rtol=1e-9)

    def test_euler_takes_what_rk_keeps(self):
        options = case(ts_max_time=0.5, ts_adapt_type="none", ts_dt=1e-4)
        first = self.run_case({**options, "ts_type": "rk", "ts_max_steps": 40}, RANKS, name="rk", code=STOPPED_BY_STEPS)
        second = self.run_case(
            {**options, "ts_type": "euler", "ts_max_time": 0.01, "restart_file": first.file("restart.h5")}, RANKS
        )
        self.assertNotIn("takes over", second.out)


if __name__ == "__main__":
    unittest.main()
