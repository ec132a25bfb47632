#!/usr/bin/env python3
# ranks: 1; size: medium
"""A base that moves, through the program: in space, under imported matrices, by records as they come."""

import unittest

import numpy as np

from common import UdarTest, case, datasets

# The steel beam, held at its foot.
MEMBER = """\
sections:
  - {name: round, shape: circle, radius: 0.1}
junctions:
  - {name: foot, place: [0, 0, 0], held: clamped}
  - {name: head, place: [0, 10, 0]}
members:
  - {name: column, from: foot, to: head, section: round, elements: 20}
"""
SHAKEN = {
    "support_position": None, "gauge_position": None, "initial_height": 0, "gravity": 0, "ts_max_time": 0.4,
    "output_interval": 0.01, "output_field_interval": 0.02, "base_motion_kind": "acceleration",
}
RECORD = "time,acceleration\n0.01,0\n0.05,0.8\n0.12,-0.9\n0.2,0.3\n0.31,0\n"  # of g


class BaseMotion(UdarTest):
    def setUp(self):
        super().setUp()
        self.record = self.scratch / "record.csv"
        self.record.write_text(RECORD)

    def shaken(self, name, **changes):
        options = case(**{**SHAKEN, "base_motion": self.record, "base_motion_scale": 9.81, **changes})
        if "structure_type" in changes:
            options = {key: value for key, value in options.items() if not key.startswith("beam_")}
        return self.run_case(options, name=name)

    def test_of_a_column_across_is_that_of_a_beam(self):
        """Of a network in the field's rows: displacements of nodes in the order of their numbers, ends last."""
        beam = self.shaken("beam", beam_left_end="clamped", ts_type="chebyshev", ts_rtol=1e-13)
        along = datasets(beam.file("results.h5"))["fields/mass_position"]
        scale = np.abs(along).max()
        self.assertGreater(scale, 0.02)
        path = self.scratch / "column.yaml"
        path.write_text(MEMBER)
        file = {"structure_type": "network", "network_file": path, "ts_type": "chebyshev", "ts_rtol": 1e-13}
        skew = np.array([0.6, 0.0, -0.8])
        for name, motions, direction in (
            ("x", [self.record], (1, 0, 0)),
            ("z", [self.record], (0, 0, 2)),
            ("skew", [self.record, self.record], skew),
        ):
            # Two motions at right angles are the one between them.
            given = direction if len(motions) == 1 else (0.6, 0, 0, 0, 0, -0.8)
            scales = 9.81 if len(motions) == 1 else f"{0.6 * 9.81!r},{0.8 * 9.81!r}"
            column = self.shaken(name, **file, base_motion=",".join(map(str, motions)),
                                 base_motion_direction=",".join(map(str, given)), base_motion_scale=scales)
            data = datasets(column.file("results.h5"))
            order = np.argsort(data["y"])
            found = data["fields/displacement_of_masses"][:, order] @ (np.array(direction) / np.linalg.norm(direction))
            np.testing.assert_allclose(found, along, rtol=0, atol=1e-9 * scale, err_msg=name)
            energy = column.csv("energy.csv")
            np.testing.assert_allclose(energy["base_work"], beam.csv("energy.csv")["base_work"], rtol=0,
                                       atol=1e-8 * np.abs(energy["base_work"]).max())
            self.assertLess(np.abs(energy["drift"]).max(), 1e-8)

    def test_by_modes_tells_the_same(self):
        """All 20 modes are the structure itself; the filter at 3000 rad/s lowers those that move by 1e-6."""
        whole = {"beam_left_end": "clamped", "beam_elements": 10, "gauge_position": "5,10", "damping_ratio": None}
        modal = self.shaken("modal", **whole, filter_frequency=None, ts_type="modal", modal_modes=8,
                            modal_estimate="no", modal_retardation=0)
        filtered = self.shaken("filtered", **whole, filter_frequency=30000)
        # 1e-4 of the size of a curve, of which its range is twice at most.
        self.assert_same_curves(filtered, modal, "mass_0", "mass_1", "absolute_mass_1", tolerance=0.5e-4)

    def test_of_imported_matrices_is_that_of_their_beam(self):
        options = {"beam_left_end": "clamped", "beam_formulation": "hermite", "gauge_position": "5,10"}
        beam = self.shaken("beam", **options, structure_write=self.scratch / "beam")
        files = {f"structure_{part}": self.scratch / f"beam-{part}.mtx" for part in ("stiffness", "mass")}
        files["structure_points"] = self.scratch / "beam-points.csv"
        again = self.shaken("import", structure_type="import", gauge_position="5,10", **files)
        self.assert_same_curves(beam, again, **{"m": 1e-8, "m/s": 1e-8})

    def test_of_a_record_leaves_a_free_beam_where_it_is(self):
        """In absolute places, by whatever integrator, and however long the record is."""
        rows = 100_000
        time = 0.004 * np.arange(rows)
        value = 0.3 * np.sin(40.0 * time) * np.exp(-3.0 * time) + 0.01 * np.sin(1.7 * np.arange(rows))
        self.record.write_text("\n".join(f"{t:.6g} {a:.12g}" for t, a in zip(time, value)))
        run = self.shaken("free", gauge_position="0,5", initial_height=2, initial_velocity=0.25)
        gauges = run.csv("gauges.csv")
        self.assertGreater(np.ptp(gauges["mass_0"] - 0.25 * gauges["time"]), 1e-3)
        np.testing.assert_allclose(gauges["absolute_mass_0"], 2 + 0.25 * gauges["time"], rtol=0, atol=1e-9)
        np.testing.assert_allclose(gauges["absolute_velocity_1"], 0.25, rtol=0, atol=1e-9)
        self.assertIn("base      moves along (0, 1, 0) from t = 0 to 400 s", run.out)


if __name__ == "__main__":
    unittest.main()
