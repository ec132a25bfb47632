#!/usr/bin/env python3
# ranks: 1; size: medium
"""Masses that rest: runs of rk that once stood for ever at a release, and the work of a load on a node that rests."""

import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import UdarTest

# The pull that ends a rest was known to rounding only, and an event corrected onto the start of its step left nothing
# due there: found among a hundred random cases.
ON_GROUND = {
    "beam_length": 4.276,
    "beam_elements": 14,
    "beam_section": "circle",
    "beam_radius": 0.1028,
    "beam_point_mass_position": "1.65,3.962",
    "beam_point_mass": "1307.3,607.3",
    "filter_frequency": 1168.5,
    "initial_angular_velocity": 0.297,
    "initial_height": 0.1959,
    "ground_profile": "0.0,0.19099 2.51,0.19056 3.73,0.19029 3.79,0.19106 4.276,0.19074",
    "contact_restitution": 0,
    "ts_max_time": 0.04,
    "output_interval": 0.001,
}
ON_MOVING_SUPPORTS = {
    "beam_length": "3.764,4.454,1.262",
    "beam_elements": "6,3,6",
    "beam_section": "direct",
    "beam_area": "0.004151,0.002285,0.015425",
    "beam_inertia": "1.271906e-06,5.39314e-07,3.1119281e-05",
    "filter_frequency": 1027.3,
    "initial_velocity": -0.624,
    "initial_height": 0.2971,
    "support_position": "6.631,7.488",
    "support_height": "0.31504,0.26055",
    "support_side": "above,below",
    "support_motion": "0.0,0.0 0.052,-0.01044 0.0917,0.00363 0.1376,0.0192 0.1544,0.00399 0.2393,-0.01588; "
    "0.0,0.0 0.0466,0.00415 0.1659,-0.01855 0.1836,0.00723",
    "contact_restitution": "0,0",
    "ts_max_time": 0.253,
    "output_interval": 0.0253,
}
HERMITE = {
    "beam_length": "3.511,4.184",
    "beam_elements": "3,5",
    "beam_section": "circle",
    "beam_radius": "0.04,0.1298",
    "beam_theory": "timoshenko",
    "beam_formulation": "hermite",
    "filter_frequency": 144.6,
    "initial_height": 0.2173,
    "support_position": 4.289,
    "support_height": 0.10902,
    "support_motion": "0.0,0.0 0.0909,0.01754 0.3736,0.02066 0.5999,0.00331 0.875,-0.02657",
    "contact_restitution": 0.3,
    "ts_max_time": 0.9,
    "output_interval": 0.03,
}
# A bar lies on two points from 0.14 s on, and the force acts on a node that rests.
LOADED = {
    "beam_length": 4,
    "beam_elements": 8,
    "filter_frequency": 30,
    "initial_height": 0.1,
    "support_position": "1.0,3.0",
    "contact_restitution": 0,
    "load_position": 1.0,
    "load_table": "0.0,0.0 0.15,-50000.0 0.3,-20000.0 0.6,-60000.0 0.9,0.0",
    "ts_max_time": 0.9,
    "output_interval": 0.1,
}


class Releases(UdarTest):
    def with_tables(self, options):
        """Tables of a row per word, one table per part, in files."""
        options = {"gauge_position": 0, **options}
        for key in ("ground_profile", "support_motion", "load_table"):
            files = []
            for text in options.get(key, "").split(";") if key in options else []:
                files.append(self.scratch / f"{key}_{len(files)}.csv")
                files[-1].write_text("\n".join(text.split()) + "\n")
            if files:
                options[key] = ",".join(map(str, files))
        return options

    def events(self, run):
        rests = run.csv("rests.csv")
        return {
            int(node): [
                (time, event) for time, of, event in zip(rests["time"], rests["node"], rests["event"]) if of == node
            ]
            for node in sorted(set(rests["node"]))
        }

    def check(self, options, reference, tolerance):
        """By rk as by another integrator: the same rests and releases of every node."""
        options = self.with_tables(options)
        expected = self.events(self.run_case({**options, **reference}, name="expected"))
        found = self.events(self.run_case({**options, "ts_type": "rk", "ts_rtol": 1e-10}, name="rk", timeout=60))
        self.assertEqual(list(found), list(expected))
        for node, events in expected.items():
            self.assertEqual([event for _, event in found[node]], [event for _, event in events], f"node {node}")
            for (time, _), (right, _) in zip(found[node], events):
                self.assertLess(abs(time - right), tolerance, f"node {node} at {right} s")
        return found

    def test_on_ground(self):
        # Steps of 1e-10 of the motion: the pull is off by wf^2 of it, and changes by some hundred m/s^3.
        found = self.check(ON_GROUND, {"ts_type": "chebyshev"}, 1e-10)
        self.assertAlmostEqual(found[1][1][0], 0.03101226075984, delta=1e-10)

    def test_on_moving_supports(self):
        # Where a pull just turns round its instant is known to the root of the error.
        self.check(ON_MOVING_SUPPORTS, {"ts_type": "impact", "ts_rtol": 1e-10}, 1e-6)

    def test_hermite(self):
        self.check(HERMITE, {"ts_type": "impact", "ts_rtol": 1e-10}, 1e-7)

    def test_work_on_a_resting_node(self):
        """Of fourth order by rk, as its dense output of a resting mass."""
        options = self.with_tables(LOADED)
        exact = self.run_case({**options, "ts_type": "chebyshev"}, name="exact").csv("energy.csv")["load_work"][-1]
        self.assertAlmostEqual(exact, 40680.94, delta=0.01)

        def error(name, **changes):
            run = self.run_case({**options, "ts_type": "rk", **changes}, name=name)
            return abs(run.csv("energy.csv")["load_work"][-1] / exact - 1)

        self.assertLess(error("adapted"), 5e-8)  # found: 1e-8, the default tolerance
        errors = [error(f"fixed{step}", ts_adapt_type="none", ts_dt=step) for step in (8e-3, 4e-3, 2e-3)]
        orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
        self.assertGreater(orders.min(), 3.8, errors)


if __name__ == "__main__":
    unittest.main()
