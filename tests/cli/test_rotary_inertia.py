#!/usr/bin/env python3
# ranks: 1; size: medium
"""Rotary inertia of members through the program: spins in free flight, landings, restarts, ranks, files, refusals."""

import unittest

import h5py
import numpy as np

from common import STOPPED_BY_STEPS, UdarTest, run
from space import listed, turn

PLACES = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 0.2, 1.5], [1.0, 1.8, 0.6]])
MEMBERS = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3)]  # one stands out: a junction with one axis of inertia, and two
ELEMENTS = 5
WIDTH, HEIGHT, DENSITY = 0.06, 0.1, 7850.0
SPIN = np.array([2.0, -3.0, 1.5])
RUN = {"structure_type": "network", "filter_frequency": 3000, "gravity": 0, "initial_height": 0, "rotary_inertia": "",
       "ts_rtol": 1e-10, "ts_max_time": 0.02, "output_interval": 1e-3, "output_field_interval": 2e-3,
       "support_position": 0, "support_width": "inf", "support_height": -9}


def frame(rotation=np.eye(3)):
    """A frame in YAML, turned with its members' axes."""
    lines = ["sections:", f"  - {{name: bar, shape: rectangle, width: {WIDTH}, height: {HEIGHT}}}", "junctions:"]
    lines += [f"  - {{name: j{i}, place: [{listed(place)}]}}" for i, place in enumerate(PLACES @ rotation.T)]
    lines += ["members:"]
    lines += [f"  - {{from: j{a}, to: j{b}, section: bar, elements: {ELEMENTS}, "
              f"orientation: [{listed(rotation @ (0.1, 1.0, -0.2))}]}}" for a, b in MEMBERS]
    return "\n".join(lines) + "\n"


def inertias(places):
    """Of each node, the tensor of rotary inertia [kg m^2]."""
    per_length = DENSITY * WIDTH * HEIGHT * (WIDTH**2 + HEIGHT**2) / 12
    tensors = [np.zeros((3, 3)) for _ in PLACES]
    for a, b in MEMBERS:
        span = places[b] - places[a]
        length = np.linalg.norm(span)
        own = per_length * length / ELEMENTS * np.outer(span, span) / length**2
        tensors[a] += own / 2
        tensors[b] += own / 2
        tensors += [own] * (ELEMENTS - 1)
    return np.array(tensors)


class RotaryInertia(UdarTest):
    def fly(self, name, rotation=np.eye(3), ranks=0, code=0, **options):
        path = self.scratch / f"{name}.yaml"
        path.write_text(frame(rotation))
        spin = rotation @ SPIN
        given = {"network_file": path, "initial_spin": listed(spin), **options}
        return self.run_case({**RUN, **given}, ranks, name=name, code=code)

    LANDING = {"support_height": -0.002, "initial_velocity": -1, "contact_restitution": 0.6}

    def test_an_oblique_spin_keeps_its_angular_momentum_and_energy(self):
        flight = self.fly("flight")
        with h5py.File(flight.file("results.h5"), "r") as file:
            places = np.array([file[f"/{axis}"][()] for axis in "xyz"]).T
            mass = file["/mass"][()]
            velocity = file["/fields/mass_velocity"][()]
            turning = file["/fields/rotation_rate_of_masses"][()]
            self.assertEqual(file["/fields/rotation_of_masses"].attrs["units"], b"rad")
            self.assertEqual(file["/fields/rotation_rate_of_masses"].attrs["units"], b"rad/s")
        tensors = inertias(places)
        own = np.einsum("nij,tnj->ti", tensors, turning)
        momentum = own + np.einsum("n,tni->ti", mass, np.cross(places[None], velocity))
        self.assertGreater(np.abs(own).max(), 1e-4 * np.abs(momentum).max())
        self.assertLess(np.abs(momentum - momentum[0]).max(), 1e-11 * np.abs(momentum).max(), flight)
        energy = flight.csv("energy.csv")
        expected = 0.5 * (np.einsum("n,ni,ni->", mass, velocity[0], velocity[0])
                          + np.einsum("ni,nij,nj->", turning[0], tensors, turning[0]))
        spun = np.einsum("i,nij,j->", SPIN, tensors, SPIN)
        self.assertAlmostEqual(np.einsum("ni,nij,nj->", turning[0], tensors, turning[0]) / spun, 1, delta=1e-12)
        self.assertAlmostEqual(energy["kinetic"][0] / expected, 1, delta=1e-12)
        self.assertLess(np.abs(energy["kinetic"] / expected - 1).max(), 1e-9)  # a rigid motion, -ts_rtol
        self.assertLess(np.abs(energy["line_strain"]).max(), 1e-12 * expected)

    def test_a_shaft_spins_about_itself(self):
        path = self.scratch / "shaft.yaml"
        path.write_text("""\
sections: [{name: bar, shape: circle, radius: 0.05}]
junctions: [{name: a, place: [0, 0, 0]}, {name: b, place: [3, 1, 0.5]}]
members: [{from: a, to: b, elements: 24}]
""")
        axis = np.array([3, 1, 0.5])
        spun = self.run_case({**RUN, "network_file": path, "initial_spin": listed(20 * axis), "ts_max_time": 0.5},
                             name="shaft")
        inertia = DENSITY * np.pi * 0.05**4 / 2 * np.linalg.norm(axis)
        energy = spun.csv("energy.csv")
        np.testing.assert_allclose(energy["kinetic"], 0.5 * inertia * 400 * (axis @ axis), rtol=1e-12)
        self.assertLess(np.abs(energy["drift"]).max(), 1e-12)
        with h5py.File(spun.file("results.h5"), "r") as file:
            turned = file["/fields/rotation_of_masses"][-1]
        np.testing.assert_allclose(turned, np.broadcast_to(10 * axis, turned.shape), rtol=1e-12)
        self.assertNotIn("held by a spring", spun.out)

    def test_a_landing_keeps_its_energy_and_twists(self):
        landed = self.fly("landing", **self.LANDING)
        self.assertGreater(landed.summary()["impacts"], 3)
        self.assertLess(np.abs(landed.csv("energy.csv")["drift"]).max(), 1e-9)
        with h5py.File(landed.file("results.h5"), "r") as file:
            masses, line = (file[f"/fields/rotation_of_{what}"][()] for what in ("masses", "line"))
        self.assertGreater(np.abs(masses - line).max(), 1e-6)
        still = self.fly("without", **{**self.LANDING, "rotary_inertia": "no"})
        with h5py.File(still.file("results.h5"), "r") as file:
            self.assertNotIn("rotation_of_masses", file["/fields"])

    def test_a_turned_copy_and_more_ranks_answer_alike(self):
        one = self.fly("one", ts_type="impact", **self.LANDING)
        rotation = turn((0.3, 0.5, -1.0), 0.9)
        velocity = rotation @ (0, -1, 0)
        others = [self.fly(f"np{ranks}", ranks=ranks, ts_type="impact", **self.LANDING) for ranks in (2, 3)]
        others.append(self.fly("turned", rotation, ts_type="impact", **{
            **self.LANDING, "support_normal": listed(rotation @ (0, 1, 0)), "initial_velocity": velocity[1],
            "initial_velocity_x": velocity[0], "initial_velocity_z": velocity[2]}))
        rows = one.csv("energy.csv")
        scale = np.abs(rows["kinetic"]).max()
        for other in others:
            self.assertEqual(other.summary()["impacts"], one.summary()["impacts"])
            for column in ("kinetic", "line_strain", "fictitious_springs", "lost_in_impacts"):
                away = np.abs(rows[column] - other.csv("energy.csv")[column]).max()
                self.assertLess(away, 1e-8 * scale, f"{column}{other}")

    def test_goes_on_as_if_it_had_never_stopped(self):
        for method in ("impact", "rk"):
            with self.subTest(method):
                options = {**self.LANDING, "ts_type": method, "output_field_interval": 0, "gauge_junction": "j3"}
                whole = self.fly(f"{method}_whole", **options)
                first = self.fly(f"{method}_first", code=STOPPED_BY_STEPS, ts_max_steps=15, **options)
                second = self.fly(f"{method}_second", restart_file=first.file("restart.h5"), **options)
                self.assertGreater(whole.summary()["impacts"], first.summary()["impacts"])
                for name in ("gauges.csv", "energy.csv", "impacts.csv"):
                    rows, tail = (run_of.file(name).read_text().splitlines() for run_of in (whole, second))
                    self.assertGreater(len(tail), 1)
                    self.assertEqual(tail[1:], rows[len(rows) - len(tail) + 1:], name)

    def test_a_restart_without_it_is_refused(self):
        first = self.fly("first", ts_max_time=0.002)
        failed = run({**RUN, "network_file": self.scratch / "first.yaml", "initial_spin": listed(SPIN),
                      "output_directory": self.scratch / "run", "restart_file": first.file("restart.h5"),
                      "rotary_inertia": "no"})
        self.assertNotEqual(failed.code, 0)
        self.assertIn("rotary inertia", failed.errors[0])


if __name__ == "__main__":
    unittest.main()
