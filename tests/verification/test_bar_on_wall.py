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

    # Thick: few bending modes, which nothing sets off, lie below the axial ones. The wall is under the foot alone.
    MODAL = {"options_file": EXAMPLE / "case.yaml", "ts_type": "modal", "modal_estimate": "no", "floor": "false",
             "network_section_radius": 0.5, "support_position": 0, "support_width": "inf", "support_y_position": 0,
             "support_y_width": 1e-3, "support_height": 0}

    def by_modes(self, name, **changes):
        """Contact over 2 L / c, mean force over rho c A v, and speed of the way back."""
        flight = self.run_case({**self.MODAL, **changes}, RANKS, name=name)
        summary = flight.summary()
        contact = summary["last_contact_time"] - summary["first_contact_time"]
        impulse = summary["support_impulse"][0]
        force = TABLE.DENSITY * TABLE.WAVE * np.pi * 0.5**2 * TABLE.SPEED
        mass = TABLE.DENSITY * TABLE.LENGTH * np.pi * 0.5**2
        return contact / TABLE.CONTACT, impulse / contact / force, impulse / mass - TABLE.SPEED

    def test_by_modes_on_a_rigid_wall(self):
        for modes in (56, 88):  # 20 and 40 of them along the bar
            contact, force, rebound = self.by_modes(f"rigid{modes}", modal_modes=modes, network_elements=200)
            self.assertAlmostEqual(contact, 1.0, delta=0.006, msg=modes)  # found: -0.0001, 0.0043
            self.assertAlmostEqual(force, 1.0, delta=0.01, msg=modes)  # found: -0.0053, -0.0081
            self.assertAlmostEqual(rebound, 1.0, delta=0.013, msg=modes)  # found: -0.0109, -0.0077

    def test_by_modes_on_a_spring(self):
        # With a foot on a spring K, tau = rho c A / K, the force is F = rho c A v (1 - exp(-t / tau)) up to 2 L / c and
        # zero after y tau more, 2 (1 + y) = exp(y); its integral falls short of that on a rigid wall by .0517 tau.
        share = 0.05  # of 2 L / c
        spring = TABLE.DENSITY * TABLE.WAVE * np.pi * 0.5**2 / (share * TABLE.CONTACT)
        y = 1.6783469900166608
        short = 1 - (4 - y - (2 + y) / (1 + y))
        errors = []
        for modes in (30, 56, 88):
            contact, _, rebound = self.by_modes(f"spring{modes}", modal_modes=modes, network_elements=800,
                                                support_stiffness=f"{spring:.17g}")
            errors.append([abs(contact - 1 - y * share), abs(rebound - 1 + 2 * short * share)])
        # Found: 1.0e-3, 9.5e-5, 2.9e-6.
        for error, bound in zip(errors, (2e-3, 2e-4, 6e-6)):
            self.assertLess(max(error), bound, errors)

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
