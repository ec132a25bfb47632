#!/usr/bin/env python3
# ranks: 1; size: medium
"""Supports with a width converge under mesh refinement, point supports do not."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from common import STEEL_MASS, UdarTest, case

MESHES = (80, 160, 320)
# Asked for are 2 %; found are 1e-4 (depth) and 2e-6 (time, impulse with e = 0): mass moves by O(h) at the edges alone.
DEPTH_CHANGE = 1e-3
EPISODE_CHANGE = 1e-4
WF = 50


class Patches(UdarTest):
    def fall(self, elements, **changes):
        """The first contact episode: the beam falls from 1 m, meets its supports at 0.45 s and, if these have a
        width, has left them by 0.7 s."""
        run = self.run_case(
            case(filter_frequency=WF, beam_elements=elements, ts_type="impact", ts_max_time=0.75, **changes),
            name=f"run{elements}",
        )
        summary = run.summary()
        depth = -summary["min_line_gap"]
        duration = summary["last_contact_time"] - summary["first_contact_time"]
        return run, depth, duration, sum(summary["support_impulse"])

    def settled(self, values, change, what):
        self.assertLess(max(values) - min(values), change * max(values), f"{what} on {MESHES} elements: {values}")

    def check(self, width, restitution):
        falls = [self.fall(n, support_width=width, contact_restitution=restitution)[1:] for n in MESHES]
        depths, durations, impulses = zip(*falls)
        self.settled(depths, DEPTH_CHANGE, "depth of the line under the supports")
        if restitution == 0:  # with e = 1 every mass bounces by itself, and when the last one leaves is chance
            self.assertLess(max(durations), 0.7 - 0.45, "the episode is over")
            self.settled(durations, EPISODE_CHANGE, "time of contact")
            self.settled(impulses, EPISODE_CHANGE, "impulse of the supports")

    def test_point_supports_diverge_and_the_program_says_so(self):
        falls = [self.fall(n) for n in MESHES[:2]]
        # v0/wf sqrt(N/2): by sqrt(2) per halving, less where the ends bend over.
        self.assertGreater(falls[1][1], 1.2 * falls[0][1], "depth of the line under point supports")
        for run, *_ in falls:
            self.assertIn("under point supports this grows without limit on finer meshes", run.err)

    def test_stiffness_is_that_of_the_width(self):
        for elements in (17, 80, 333):
            run = self.run_case(
                case(filter_frequency=WF, beam_elements=elements, support_width=0.5, ts_max_time=0.01, udar_view=True),
                name=f"view{elements}",
            )
            line = next(line for line in run.out.splitlines() if "stiffness of filter springs [N/m]" in line)
            stiffness = float(line.split("]")[1].split()[0])
            self.assertAlmostEqual(stiffness / (STEEL_MASS / 10 * WF**2 * 0.5), 1, delta=1e-5)  # printed with 6 digits


for wide in (0.5, 1):
    for e in (0, 1):
        setattr(
            Patches,
            f"test_width_{wide}_restitution_{e}".replace(".", "_"),
            lambda self, wide=wide, e=e: self.check(wide, e),
        )

if __name__ == "__main__":
    unittest.main()
