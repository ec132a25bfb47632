#!/usr/bin/env python3
# ranks: 1; size: medium
"""Contact on the line does not depend on the mesh, also under point supports, and keeps energy; the unfiltered beam."""

import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import UdarTest, case

FALL = {"filter_frequency": 400, "ts_max_time": 0.53, "output_interval": 1e-4, "gauge_position": "5"}


class LineContact(UdarTest):
    def fall(self, **changes):
        name = "_".join(f"{key}{value}" for key, value in changes.items()).replace(",", "_")
        run = self.run_case(case(**{**FALL, **changes}), name=name)
        summary, gauges, energy = run.summary(), run.csv("gauges.csv"), run.csv("energy.csv")
        return {
            "duration": summary["last_contact_time"] - summary["first_contact_time"],
            "sag": -gauges["line_0"].min(),
            "impulse": sum(summary["support_impulse"]),
            # Relative to the motion so far: in the first rows of a fall that is hardly more than rounding.
            "drift": np.abs(energy["drift"][energy["kinetic"] > 0.01 * energy["kinetic"].max()]).max(),
            "gap": summary["min_line_gap"],
            "impacts": summary["impacts"],
            "run": run,
        }

    def test_two_points_do_not_depend_on_the_mesh(self):
        runs = [self.fall(contact_surface="line", beam_elements=n) for n in (40, 80, 160)]
        for quantity in ("duration", "sag", "impulse"):
            coarse, middle, fine = (run[quantity] for run in runs)
            self.assertLess(abs(coarse / fine - 1), 0.005, f"{quantity}: {coarse} {middle} {fine}")
            # Second order in the element length: a fourth, and the sampling of the times of contact.
            self.assertLess(abs(middle - fine), 0.35 * abs(coarse - middle), f"{quantity}: {coarse} {middle} {fine}")
        for run in runs:
            self.assertLess(run["drift"], 1e-6, run["run"])
            self.assertGreater(run["gap"], -1e-12, "round-off of forces near 1e6 N over the line's stiffness")
            self.assertEqual(run["impacts"], 0, run["run"])

    def test_both_integrators_agree(self):
        """At tolerances that make each exact to 1e-6."""
        runs = [
            self.fall(contact_surface="line", ts_type="impact", ts_rtol=1e-9),
            self.fall(contact_surface="line", ts_type="rk", ts_rtol=1e-10),
        ]
        for quantity in ("sag", "impulse"):  # rk tells times of contact to half a step only
            one, other = (run[quantity] for run in runs)
            self.assertLess(abs(one / other - 1), 1e-6, quantity)

    def test_masses_sink_where_the_line_does_not(self):
        """Point supports under masses: the line goes through, the deeper the finer the mesh; the program says so."""
        depths = []
        for elements in (40, 160):
            run = self.fall(contact_surface="mass", filter_frequency=100, beam_elements=elements)
            self.assertIn("sink", run["run"].err)
            depths.append(-run["gap"])
        self.assertGreater(depths[1], 1.5 * depths[0], "sink depth ~ v0 / wf sqrt(N / 2)")
        line = self.fall(contact_surface="line", filter_frequency=100, beam_elements=160)
        self.assertNotIn("sink", line["run"].err)

    def test_converges_to_the_unfiltered_beam(self):
        """Deflection of the middle over the first 50 ms after touch.

        Not monotone: contact comes in bursts, and 200 rad/s happens to be nearer than 400.
        """
        limit = self.fall(filter_frequency="none", ts_dt=1e-5, beam_elements=40)
        self.assertLess(limit["drift"], 1e-10, "the scheme keeps energy but for round-off")
        coarse = self.fall(filter_frequency="none", ts_dt=4e-4, beam_elements=40)
        self.assertLess(coarse["drift"], 1e-10, "also in rows between the ends of its steps")
        reference = limit["run"].csv("gauges.csv")
        after = (reference["time"] > 0.4515) & (reference["time"] < 0.5015)
        off = []
        for wf in (100, 200, 400, 800):
            found = self.fall(contact_surface="line", filter_frequency=wf, beam_elements=40)["run"].csv("gauges.csv")
            off.append(np.sqrt(np.mean((found["line_0"] - reference["line_0"])[after] ** 2)))
        # Found: 31, 11, 13 and 4 mm.
        self.assertLess(off[0], 0.04)
        self.assertLess(max(off[1:]), 0.5 * off[0])
        self.assertLess(off[-1], 0.006)

    def test_rejects_what_has_no_meaning(self):
        for changes, words in (
            ({"contact_surface": "line", "contact_restitution": 0.5}, ("-contact_restitution", "0.5", "line")),
            ({"contact_surface": "line", "ts_type": "chebyshev", "floor": True}, ("-ts_type", "chebyshev", "rk")),
            ({"filter_frequency": "none"}, ("-ts_dt", "[s]")),
            ({"filter_frequency": "none", "ts_dt": 1e-4, "ts_type": "rk"}, ("-ts_type", "moreau")),
            ({"filter_frequency": 100, "ts_type": "moreau"}, ("-filter_frequency none",)),
            ({"contact_surface": "surface"}, ("-contact_surface", "surface", "mass", "line")),
            ({"filter_frequency": "non"}, ("-filter_frequency", "non", "none", "[rad/s]")),
        ):
            with self.subTest(**changes):
                self.refuse_case(case(**changes), words)


if __name__ == "__main__":
    unittest.main()
