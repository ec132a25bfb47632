#!/usr/bin/env python3
# ranks: 1 2; size: medium
"""Places that hold a structure and move, through the program: a junction of a network, restart, what is told."""

import os
import unittest

import numpy as np

from common import UdarTest, case, datasets

RANKS = int(os.environ.get("UDAR_RANKS", "1"))

# The steel beam, held at its foot and on a spring in its middle.
COLUMN = """\
sections:
  - {name: round, shape: circle, radius: 0.1}
junctions:
  - {name: foot, place: [0, 0, 0], held: clamped}
  - {name: middle, place: [0, 5, 0], stiffness: [2.0e5, 0, 2.0e5, 0, 0, 0]}
  - {name: head, place: [0, 10, 0]}
members:
  - {from: foot, to: middle, section: round, elements: 8}
  - {from: middle, to: head, section: round, elements: 8}
"""
MOVED = {
    "support_position": None, "gauge_position": None, "initial_height": 0, "gravity": 0, "ts_max_time": 0.3,
    "output_interval": 0.01, "output_field_interval": 0.02, "restart_interval": None,
    "base_motion_kind": "acceleration", "base_motion_scale": 9.81, "ts_type": "chebyshev", "ts_rtol": 1e-13,
}
BEAM = {
    "beam_elements": 16, "beam_left_end": "clamped", "beam_line_support_position": 5,
    "beam_line_support_stiffness": 2e5,
}
RECORD = "time,acceleration\n0.01,0\n0.05,3\n0.12,-4\n0.2,0.3\n0.31,0\n"  # of g


class HeldMotion(UdarTest):
    def setUp(self):
        super().setUp()
        self.record = self.scratch / "record.csv"
        self.record.write_text(RECORD)

    def moved(self, name, ranks=RANKS, **changes):
        options = case(**{**MOVED, "base_motion": self.record, **changes})
        if "structure_type" in changes:
            options = {key: value for key, value in options.items() if not key.startswith("beam_")}
        return self.run_case(options, name=name, ranks=ranks)

    def test_of_a_junction_is_that_of_the_end_of_a_beam(self):
        """Of what is held and of the foot of a spring, along x, z and between them, while the other place stays."""
        path = self.scratch / "column.yaml"
        path.write_text(COLUMN)
        network = {"structure_type": "network", "network_file": path}
        for of_beam, junction in (("left", "foot"), ("line_support_0", "middle")):
            beam = self.moved(f"beam-{of_beam}", **BEAM, base_motion_place=of_beam)
            along = datasets(beam.file("results.h5"))["fields/mass_position"]
            scale = np.abs(along).max()
            self.assertGreater(scale, 0.02)
            for name, direction in (("x", (1, 0, 0)), ("skew", (0.6, 0.0, -0.8))):
                column = self.moved(f"{junction}-{name}", **network, base_motion_place=junction,
                                    base_motion_direction=",".join(map(str, direction)))
                data = datasets(column.file("results.h5"))
                order = np.argsort(data["y"])
                found = data["fields/displacement_of_masses"][:, order] @ np.array(direction)
                np.testing.assert_allclose(found, along, rtol=0, atol=1e-9 * scale, err_msg=name)
                energy = column.csv("energy.csv")
                work = beam.csv("energy.csv")["base_work"]
                self.assertGreater(np.abs(work).max(), 10.0)
                np.testing.assert_allclose(energy["base_work"], work, rtol=0, atol=1e-8 * np.abs(work).max())
                self.assertLess(np.abs(energy["drift"]).max(), 1e-8)

    def test_goes_on_from_a_restart_file(self):
        """The straight run ends a step where the first one does, at a row of the record."""
        keys = {**BEAM, "base_motion_place": "left", "gauge_position": "2,10", "output_field_interval": None}
        whole = self.moved("whole", **keys)
        first = self.moved("first", ts_max_time=0.12, **keys)
        rest = self.moved("rest", restart_file=first.file("restart.h5"), **keys)
        other = self.moved("other", ranks=3 - RANKS, restart_file=first.file("restart.h5"), **keys)
        for table in ("gauges.csv", "energy.csv"):
            rows = whole.file(table).read_text().splitlines()
            tail = rest.file(table).read_text().splitlines()
            self.assertGreater(len(tail), 10)
            self.assertEqual(tail[2:], rows[len(rows) - len(tail) + 2:], table)
        for column in ("mass_1", "velocity_0", "line_1"):
            found, on_other = rest.csv("gauges.csv")[column], other.csv("gauges.csv")[column]
            np.testing.assert_allclose(on_other, found, rtol=0, atol=1e-9 * np.abs(found).max())

    @unittest.skipIf(RANKS > 1, "once")
    def test_is_told_and_shown(self):
        """What moves, by how much, and that a beam is bent at once where a place starts away from the axis."""
        away = self.scratch / "away.csv"
        away.write_text("time,displacement\n0,0.02\n0.1,0.05\n")
        run = self.moved("away", **BEAM, base_motion=away, base_motion_kind="displacement", base_motion_scale=1,
                         base_motion_place="left", gauge_position="0", ts_type="impact", ts_rtol=1e-9)
        self.assertIn("left      moves along (0, 1, 0) from t = 0 to 0.1 s", run.out)
        self.assertIn("left starts 0.02 m from where it is unstressed", run.out + run.err)
        gauges = run.csv("gauges.csv")
        self.assertEqual(gauges["line_0"][0], 0.02)
        np.testing.assert_allclose(gauges["line_0"][gauges["time"] > 0.1], 0.05, rtol=0, atol=1e-15)


if __name__ == "__main__":
    unittest.main()
