#!/usr/bin/env python3
# ranks: 1; size: long
"""Impacts and gauges against an independent event-driven solution without time-step error (data/README.md)."""

import json
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import UdarTest, case, grouped_by_node, read_csv

DATA = pathlib.Path(__file__).resolve().parent / "data"
TIME_TOLERANCE = 1e-7  # [s]
POSITION_TOLERANCE = 1e-6  # [m]
VELOCITY_TOLERANCE = 1e-5  # [m/s]: the largest acceleration before an impact, about 100 m/s^2, times the time tolerance

INTEGRATORS = {
    "rk": {"ts_type": "rk", "ts_rtol": 1e-12, "ts_atol": 1e-13},
    "chebyshev": {"ts_type": "chebyshev"},
    "impact": {"ts_type": "impact", "ts_rtol": 1e-11},
}
SUPPORTS = {
    "points": {"support_position": "2,8"},
    "ends": {"support_position": "0,10"},
    "pads": {"support_position": "2,8", "support_width": 1, "support_weighting": "inclusive"},
    "floor": {"support_position": None, "floor": True},
}


class Oracle(UdarTest):
    def check(self, reference, integrator):
        window = reference["window"]
        run = self.run_case(
            case(
                filter_frequency=reference["filter_frequency"],
                contact_restitution=reference["restitution"],
                contact_tolerance=1e-12,
                initial_slope=reference["initial_slope"],
                output_interval=0.02,
                ts_max_time=window,
                **INTEGRATORS[integrator],
                **SUPPORTS[reference["supports"]],
            )
        )
        self.compare_impacts(reference, run)
        self.compare_gauges(reference, run)

    def compare_impacts(self, reference, run):
        expected = grouped_by_node(read_csv(DATA / f"{reference['name']}_impacts.csv"))
        found = grouped_by_node(run.csv("impacts.csv"))
        for node, rows in expected.items():
            got = found.get(node, np.empty((0, 2)))
            common = min(len(rows), len(got))
            late = np.abs(rows[:common, 0] - got[:common, 0])
            if (late > TIME_TOLERANCE).any():
                first = int(np.argmax(late > TIME_TOLERANCE))
                (time, velocity), (found_time, found_velocity) = rows[first], got[first]
                self.fail(
                    f"node {node}, impact {first + 1} of {len(rows)}: expected at {time:.9f} s with {velocity:.6f} m/s,"
                    f" found at {found_time:.9f} s with {found_velocity:.6f} m/s, off by {late[first]:.2e} s{run}"
                )
            off = np.abs(rows[:common, 1] - got[:common, 1])
            self.assertLess(off.max(initial=0), VELOCITY_TOLERANCE, f"node {node}: velocity at impact [m/s]{run}")
            self.assertEqual(len(got), len(rows), f"node {node}: impacts up to {reference['window']} s{run}")
        self.assertEqual(sorted(found), sorted(expected), f"nodes that touch{run}")

    def compare_gauges(self, reference, run):
        expected = read_csv(DATA / f"{reference['name']}_gauges.csv")
        found = run.csv("gauges.csv")
        rows = len(expected["time"])
        np.testing.assert_allclose(found["time"][:rows], expected["time"], rtol=0, atol=1e-12)
        for name, values in expected.items():
            off = np.abs(found[name][:rows] - values)
            self.assertLess(off.max(), POSITION_TOLERANCE, f"{name} at {expected['time'][off.argmax()]:.2f} s [m]{run}")


def add(reference, integrator):
    setattr(Oracle, f"test_{reference['name']}_by_{integrator}", lambda self: self.check(reference, integrator))


for entry in json.loads((DATA / "cases.json").read_text()):
    for kind in INTEGRATORS:
        add(entry, kind)

if __name__ == "__main__":
    unittest.main()
