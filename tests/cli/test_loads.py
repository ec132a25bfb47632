#!/usr/bin/env python3
# size: long
"""Forces by a formula through the program: of networks at junctions and places, on any number of ranks."""

import unittest

import numpy as np

from common import UdarTest, case, run

# The steel beam in space, held at its left end.
MEMBER = """\
sections:
  - {name: round, shape: circle, radius: 0.1}
junctions:
  - {name: root, place: [0, 0, 0], held: clamped}
  - {name: tip, place: [10, 0, 0]}
members:
  - {name: bar, from: root, to: tip, section: round, elements: 20}
"""
SWUNG = {
    "support_position": None, "gauge_position": None, "initial_height": 0, "gravity": 0, "ts_max_time": 0.4,
    "output_interval": 0.01, "output_field_interval": 0, "ts_type": "chebyshev", "ts_rtol": 1e-13,
    "load_law": "harmonic", "load_amplitude": 3e3, "load_frequency": 4, "load_accuracy": 1e-2,
}
NOISE = {"load_law": "random", "load_density": 1e6, "load_band": "1,15", "load_period": 2, "load_accuracy": 1e-2}


class Loads(UdarTest):
    def swung(self, name, ranks=0, **changes):
        options = case(**{**SWUNG, **changes})
        if "structure_type" in changes:
            options = {key: value for key, value in options.items() if not key.startswith("beam_")}
        return self.run_case(options, ranks, name=name)

    def test_of_a_network_act_at_junctions_and_places_in_any_direction(self):
        """Up it is the beam; across the height stays, and half of a skew force is in the height."""
        beam = self.swung("beam", beam_left_end="clamped", load_position=10, gauge_position=10).csv("gauges.csv")
        expected = beam["line_0"]
        scale = np.abs(expected).max()
        self.assertGreater(scale, 0.02)
        path = self.scratch / "bar.yaml"
        path.write_text(MEMBER)
        bar = {"structure_type": "network", "network_file": path, "gauge_junction": "tip"}
        skew = f"{np.sqrt(0.75)!r},0.5,0"
        for name, changes, share in (
            ("position", {"load_position": 10}, 1.0),
            ("place", {"load_place": "9.9,0.3,-0.1"}, 1.0),
            ("junction", {"load_junction": "tip"}, 1.0),
            ("down", {"load_junction": "tip", "load_direction": "0,-2,0"}, -1.0),
            ("across", {"load_junction": "tip", "load_direction": "0,0,1"}, 0.0),
            ("skew", {"load_junction": "tip", "load_direction": skew}, 0.5),
        ):
            done = self.swung(name, **bar, **changes)
            found = done.csv("gauges.csv")["line_0"]
            # The chain and the network solve the same line in other orders.
            np.testing.assert_allclose(found, share * expected, rtol=0, atol=1e-8 * scale, err_msg=name)
            energy = done.csv("energy.csv")
            if name == "across":
                up = self.swung("again", **bar, load_junction="tip").csv("energy.csv")
                np.testing.assert_allclose(energy["kinetic"], up["kinetic"], rtol=0, atol=1e-8 * up["kinetic"].max())
            self.assertLess(np.abs(energy["drift"]).max(), 1e-9)

    def test_of_one_seed_are_the_same_force_on_any_number_of_ranks(self):
        noise = {key: None for key in SWUNG if key.startswith("load_")} | NOISE
        options = {**noise, "beam_left_end": "clamped", "load_position": 10, "gauge_position": 10}
        one, two, again = (self.swung(name, ranks, **options, load_seed=7).csv("gauges.csv")["line_0"]
                           for name, ranks in (("np1", 1), ("np2", 2), ("again", 1)))
        np.testing.assert_array_equal(again, one)
        scale = np.abs(one).max()
        self.assertGreater(scale, 1e-3)
        np.testing.assert_allclose(two, one, rtol=0, atol=1e-11 * scale)
        other = self.swung("other", 1, **options, load_seed=8).csv("gauges.csv")["line_0"]
        self.assertGreater(np.abs(other - one).max(), 0.1 * scale)

    def test_of_a_spectrum_in_a_file_are_those_of_its_numbers(self):
        noise = {key: None for key in SWUNG if key.startswith("load_")} | NOISE
        options = {**noise, "beam_left_end": "clamped", "load_position": 10, "gauge_position": 10}
        path = self.scratch / "spectrum.csv"
        path.write_text("frequency,density\n1,1e6\n15,1e6\n")
        numbers = self.swung("numbers", **options).csv("gauges.csv")["line_0"]
        file = self.swung("file", **{**options, "load_density": None, "load_band": None, "load_spectrum": path})
        np.testing.assert_array_equal(file.csv("gauges.csv")["line_0"], numbers)

    def test_of_a_hinged_network_turns_about_its_hinge(self):
        path = self.scratch / "rod.yaml"
        path.write_text(MEMBER.replace("held: clamped", "held: [ux, uy, uz, rx]"))
        bar = {"structure_type": "network", "network_file": path, "gauge_junction": "tip", "ts_max_time": 0.1}
        free = {key: None for key in SWUNG if key.startswith("load_")}
        for name, start in (("spin", {"initial_spin": "0,0,0.2"}), ("angular", {"initial_angular_velocity": 0.2})):
            turned = self.swung(name, **bar, **free, **start, initial_pivot="0,0,0")
            rows = turned.csv("gauges.csv")
            np.testing.assert_allclose(rows["line_0"], 0.2 * 10 * rows["time"], rtol=0, atol=1e-10)
            energy = turned.csv("energy.csv")["kinetic"]
            mass = 7850 * np.pi * 0.1**2 * 10
            np.testing.assert_allclose(energy, 0.5 * mass * 100 / 3 * (1 + 0.5 / 20**2) * 0.2**2, rtol=1e-9)
        held = self.scratch / "held.yaml"
        held.write_text(MEMBER)
        options = {key: value for key, value in case(**SWUNG).items() if not key.startswith(("beam_", "load_"))}
        failed = run({**options, **bar, "network_file": held, "initial_spin": "0,0,0.2", "initial_pivot": "0,0,0",
                      "output_directory": self.scratch / "refused"})
        self.assertEqual(failed.code, 1, failed)
        self.assertIn("-initial_pivot", failed.errors[0])


if __name__ == "__main__":
    unittest.main()
