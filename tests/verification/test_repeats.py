#!/usr/bin/env python3
# ranks: 3; size: medium
"""Runs of one case on as many ranks are the same to the bit, however the machine deals its cores.

UDAR_REPEATS says how many runs of each case there are; 3 unless it is given.
"""

import os
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import same_run
from common import UdarTest, case
from hard_cases import GIVING

RANKS = int(os.environ.get("UDAR_RANKS", "3"))
REPEATS = int(os.environ.get("UDAR_REPEATS", "3"))
# What is no time and no memory must be the same here, where both runs are whole.
SPENT = ("line_solves", "stepping_line_solves", "streamed_bytes")
WRITES = {"output_interval": 0.02, "output_field_interval": 0.1, "restart_interval": 0.2}
CASES = {
    "chebyshev": {"ts_type": "chebyshev", "contact_restitution": 0.7, "initial_height": 0.2, "ts_max_time": 0.5},
    "impact": {**GIVING, "ts_type": "impact", "initial_height": 0.2, "ts_max_time": 0.4},
    "modal": {"ts_type": "modal", "contact_surface": "line", "contact_restitution": 1, "initial_height": 0.2,
              "ts_max_time": 0.4},
    "network": {**{key: None for key in case()}, "structure_type": "network", "network_grillage": "3,3",
                "network_spacing": 2, "network_elements": 4, "filter_frequency": 300, "floor": True,
                "contact_restitution": 0.4, "initial_height": 0.05, "initial_spin": "0.1,0,0.2", "gravity": 9.81,
                "ts_type": "impact", "ts_max_time": 0.2},
}


class Repeats(UdarTest):
    def check(self, options):
        first = None
        for repeat in range(REPEATS):
            run = self.run_case({**options, **WRITES}, RANKS, name=str(repeat), timeout=240)
            if first is None:
                first = run
                self.assertGreater(run.summary()["last_contact_time"], 0, run)
                continue
            self.assertEqual(sorted(os.listdir(run.directory)), sorted(os.listdir(first.directory)))
            self.assertEqual(same_run.differences(first.directory, run.directory), [], f"run {repeat}{run}")
            for key in SPENT:
                self.assertEqual(run.summary()[key], first.summary()[key], f"run {repeat}: {key}")


for name, options in CASES.items():
    setattr(Repeats, f"test_{name}", lambda self, options=options: self.check(case(**options)))

if __name__ == "__main__":
    unittest.main()
