#!/usr/bin/env python3
# ranks: 1 2; size: medium
"""An axial bar as one member of a network against a rigid wall: example 08 against its closed form."""

import importlib.util
import os
import pathlib
import sys
import unittest

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import ROOT, UdarTest

EXAMPLE = ROOT / "examples" / "08-bar-on-wall"
SPEC = importlib.util.spec_from_file_location("bar_table", EXAMPLE / "table.py")
TABLE = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(TABLE)
RANKS = int(os.environ.get("UDAR_RANKS", "1"))
TOUCH = 1e-3  # of case.yaml [s]


class BarOnWall(UdarTest):
    def flight(self, frequency, elements, **changes):
        return self.run_case({"options_file": EXAMPLE / "case.yaml", "filter_frequency": frequency,
                              "network_elements": elements, **changes}, RANKS, name=f"{frequency:g}-{elements}")

    def test_contact_is_that_of_the_closed_form(self):
        slow = []
        for frequency, elements in ((1e4, 100), (2e4, 60), (8e4, 400)):
            where = f"wf = {frequency:g}, N = {elements}"
            flight = self.flight(frequency, elements)
            run = TABLE.measured(flight.directory)
            contact, rebound = TABLE.closed_form(frequency, elements)
            self.assertAlmostEqual(run["contact"] / contact, 1.0, delta=1e-5, msg=where)
            self.assertAlmostEqual(run["rebound"], rebound, delta=1e-6, msg=where)
            # The wall gives the change of momentum.
            self.assertAlmostEqual(run["impulse"] / run["mass"], run["rebound"] + TABLE.SPEED, delta=1e-9, msg=where)
            rows = flight.csv("contact.csv")
            touching = (rows["time"] > TOUCH) & (rows["time"] < TOUCH + contact)
            expected = TABLE.wall(rows["time"][touching] - TOUCH, frequency, elements)[1]
            # Within a step of at most 1.5 / wf a row has its share of the time of the impulse.
            error = np.abs(rows["impulse_0"][touching] - expected).max()
            self.assertLess(error, 0.15 * TABLE.FORCE / frequency, where)
            slow.append(1 - run["rebound"])
        # As the width of a front that has run 2 L: to the power 2/3 of 1 / wf.
        self.assertAlmostEqual(np.log(slow[0] / slow[2]) / np.log(8), 2 / 3, delta=0.03)

    def test_nothing_moves_sideways_and_energy_stays(self):
        run = self.flight(2e4, 60)
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-7, run)
        self.assertGreater(run.summary()["min_line_gap"], -1e-12, run)
        with h5py.File(run.file("results.h5")) as file:
            moved = np.abs(file["fields/displacement_of_masses"][:]).max(axis=(0, 1))
            self.assertLess(max(moved[0], moved[2]), 1e-12)
            self.assertGreater(moved[1], 1e-4)


if __name__ == "__main__":
    unittest.main()
