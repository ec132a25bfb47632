#!/usr/bin/env python3
# size: long
"""The answer does not depend on the number of ranks."""

import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import STEEL_MASS, STOPPED_BY_STEPS, UdarTest, case
from hard_cases import CORRECTED, CORRECTED_LINE, CROSSED, DAMPED, GIVING, LAWS, LINE_CONTACT, MODAL, MODAL_LOADED
from hard_cases import MOTION, MOVING_LINE, SHAKEN, TOLERANCE

INTEGRATORS = ("rk", "chebyshev", "impact")
FREE_FLIGHT = {"support_position": None, "initial_velocity": 2, "initial_angular_velocity": 0.3, "initial_slope": 0.1}
CASES = {
    "elastic": {"contact_restitution": 1},
    "plastic": {"contact_restitution": 0.5},
    "tilted_floor": {"support_position": None, "floor": True, "contact_restitution": 0.5, "initial_slope": 0.02},
    "parallel_factorisation": {"filter_pc_type": "lu", "filter_pc_factor_mat_solver_type": "mumps"},
    "pads_and_ceiling": {
        "support_position": "2,8,5",
        "support_width": "1,0,2",
        "support_height": "0,0.1,1.3",
        "support_side": "below,below,above",
        "contact_restitution": "0.5,1,0.7",
        "initial_velocity": 1,
    },
    "contact_laws": {**LAWS, "integrators": ("impact",)},
    "line_contact": {**LINE_CONTACT, "integrators": ("chebyshev", "impact")},
    "line_on_springs": {**LINE_CONTACT, "support_stiffness": 2e6, "integrators": ("chebyshev",)},
    # In flight round-off alone is the error that adapted steps go by, and a kink of the line is met by another step.
    "line_contact_by_rk": {**LINE_CONTACT, "ts_adapt_type": "none", "ts_dt": 1e-3, "integrators": ("rk",)},
    "line_contact_of_many": {
        "support_position": None,
        "floor": True,
        "contact_surface": "line",
        "contact_line_dense_max": 0,
        "initial_slope": 0.02,
        "ts_adapt_type": "none",
        "ts_dt": 1e-3,
        "integrators": ("rk",),
    },
    "moving_and_giving_line": {**MOVING_LINE, "integrators": ("impact",)},
    "moving_and_giving_line_by_rk": {
        **MOVING_LINE,
        "ts_adapt_type": "none",
        "ts_dt": 1e-3,
        "integrators": ("rk",),
    },
    "unfiltered_on_moving_supports": {
        "filter_frequency": "none",
        "ts_dt": 2e-4,
        "support_motion": f"{MOTION},none",
        "support_width": "0,1",
        "support_stiffness": "inf,2e6",
        "support_damping": "0,1e3",
        "integrators": ("moreau",),
    },
    # Steps may be cut elsewhere where the last digits of forces decide who touches: right to the integrator's error.
    "line_contact_of_many_by_impact": {
        "support_position": None,
        "floor": True,
        "contact_surface": "line",
        "contact_line_dense_max": 0,
        "initial_slope": 0.02,
        "integrators": ("impact",),
        "tolerance": 2e-6,  # found: 1e-12
    },
    "unfiltered": {"filter_frequency": "none", "ts_dt": 2e-4, "support_width": "0,1", "integrators": ("moreau",)},
    "damped": {**GIVING, **DAMPED, "integrators": ("rk", "impact")},
    "crossed": {**CROSSED, "contact_restitution": 0.5, "integrators": ("chebyshev", "impact")},
    "shaken": {**SHAKEN, "contact_restitution": 0.5},
    "moving_and_giving": {**GIVING, "integrators": ("rk", "impact")},
    "corrected_modes": {**CORRECTED, "contact_restitution": 0.5},
    "corrected_line": {**CORRECTED_LINE, "integrators": ("chebyshev", "impact")},
    "corrected_line_by_rk": {**CORRECTED_LINE, "ts_adapt_type": "none", "ts_dt": 5e-4, "integrators": ("rk",)},
    "unfiltered_with_many": {
        "filter_frequency": "none",
        "ts_dt": 2e-4,
        "support_width": "0,1",
        "contact_line_dense_max": 0,
        "integrators": ("moreau",),
    },
    "modal_rigid_points": {**MODAL, "integrators": ("modal",)},
    "modal_springs": {**MODAL, "support_stiffness": 1e8, "integrators": ("modal",)},
    "modal_all": {**MODAL_LOADED, "integrators": ("modal",)},
    "free_flight": FREE_FLIGHT,
    "free_flight_with_vibration": {**FREE_FLIGHT, "initial_shape": True},
}


class Ranks(UdarTest):
    def check(self, changes, ranks_to_try):
        changes = dict(changes)
        self.tolerance = changes.pop("tolerance", TOLERANCE)
        for integrator in changes.pop("integrators", INTEGRATORS):
            with self.subTest(integrator=integrator):
                self.check_one({**changes, "ts_type": integrator}, ranks_to_try, integrator)

    def check_one(self, changes, ranks_to_try, integrator):
        if changes.get("initial_shape"):
            shape = self.scratch / "shape.csv"
            rows = [f"{x},{0.01 * np.cos(2 * np.pi * x / 10):.17g}\n" for x in np.linspace(0, 10, 81)]
            shape.write_text("x,offset\n" + "".join(rows))
            changes = {**changes, "initial_shape": shape}
        options = case(ts_max_time=0.6, **changes)
        serial = self.run_case(options, name=f"{integrator}_serial")
        expected, impacts = serial.csv("gauges.csv"), serial.csv("impacts.csv")
        for ranks in ranks_to_try:
            with self.subTest(ranks=ranks):
                run = self.run_case(options, ranks, name=f"{integrator}{ranks}")
                found = run.csv("gauges.csv")
                self.assertEqual(list(found), list(expected), run)
                for name, values in expected.items():
                    if not name.startswith("velocity_"):  # a velocity jumps at an impact: its time differs by round-off
                        off = np.abs(found[name] - values)
                        self.assertLess(off.max(), self.tolerance, f"{name} at {expected['time'][off.argmax()]} s{run}")
                hits = run.csv("impacts.csv")
                self.assertEqual(len(hits["time"]), len(impacts["time"]), f"impacts{run}")
                self.assertEqual(sorted(hits["node"]), sorted(impacts["node"]), f"nodes hit{run}")
                np.testing.assert_array_equal(np.sort(hits["time"]), hits["time"], err_msg="impacts in order of time")
                self.assertEqual(run.summary()["ranks"], ranks, run)
                taken = np.diff(run.csv("energy.csv")["lost_in_dampers"])
                self.assertGreaterEqual(taken.min(), 0, f"a damper gives energy{run}")
                if changes.get("floor") or changes.get("support_position", True) is not None:
                    self.check_forces(run, serial)
                # Masses off by the tolerance: forces of the springs off by wf^2 m of it, moments by that times 10 m.
                error = self.tolerance * 100**2 * STEEL_MASS * 10
                for name, values in serial.csv("envelope.csv").items():
                    np.testing.assert_allclose(run.csv("envelope.csv")[name], values, rtol=0, atol=error, err_msg=name)

    def check_forces(self, run, serial):
        """Masses off by the tolerance swing off by wf = 100 times that: so much velocity of 2466 kg is the error."""
        error = self.tolerance * 100 * STEEL_MASS
        expected, found = serial.csv("contact.csv"), run.csv("contact.csv")
        self.assertEqual(list(found), list(expected), run)
        self.assertGreater(expected["masses"].max(), 0)
        for name, values in expected.items():
            atol = error if name.startswith("impulse") else error / serial.summary()["force_window"]
            np.testing.assert_allclose(found[name], values, rtol=0, atol=2 * atol, err_msg=f"contact.csv: {name}")

    def test_free_flight_is_exact(self):
        """No contact: a rigid beam flies on a parabola and turns evenly, on any number of ranks."""
        for ranks in (1, 3):
            run = self.run_case(case(ts_max_time=1.0, ts_rtol=1e-10, **FREE_FLIGHT), ranks, name=f"ranks{ranks}")
            found = run.csv("gauges.csv")
            t = found["time"]
            for gauge, x in enumerate((0, 2.5, 5, 7.5, 10)):
                mass = 1 + 0.1 * (x - 5) + (2 + 0.3 * (x - 5)) * t - 9.81 * t**2 / 2
                line = mass - 9.81 / 100**2
                place = f"{ranks} ranks, x = {x}"
                np.testing.assert_allclose(found[f"mass_{gauge}"], mass, rtol=0, atol=1e-9, err_msg=place)
                np.testing.assert_allclose(found[f"line_{gauge}"], line, rtol=0, atol=1e-9, err_msg=place)
            self.assertEqual(len(run.csv("impacts.csv")["time"]), 0)

    def test_restart_on_another_number_of_ranks(self):
        options = case(ts_max_time=0.6, contact_restitution=0.5, ts_type="rk")
        whole = self.run_case(options, name="whole")
        first = self.run_case({**options, "ts_max_steps": 150}, 2, name="first", code=STOPPED_BY_STEPS)
        second = self.run_case({**options, "restart_file": first.file("restart.h5")}, 3, name="second")
        expected, found = whole.csv("gauges.csv"), second.csv("gauges.csv")
        rows = len(found["time"])
        self.assertGreater(rows, 1)
        for name, values in expected.items():
            if not name.startswith("velocity_"):
                np.testing.assert_allclose(found[name], values[-rows:], rtol=0, atol=TOLERANCE, err_msg=name)


for key, value in CASES.items():
    tried = {"plastic": (1, 2, 3, 4), "pads_and_ceiling": (2, 3)}.get(key, (3,))
    setattr(Ranks, f"test_{key}", lambda self, value=value, tried=tried: self.check(value, tried))

if __name__ == "__main__":
    unittest.main()
