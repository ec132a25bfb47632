#!/usr/bin/env python3
# ranks: 1 2; size: medium
"""Masses that strike a beam, through the program: Timoshenko's ball, networks, what files say, restart, bad input."""

import os
import pathlib
import re
import subprocess
import unittest

import numpy as np

from common import UdarTest, case, datasets, read_csv

DATA = pathlib.Path(__file__).resolve().parents[1] / "verification" / "data"
RANKS = int(os.environ.get("UDAR_RANKS", "1"))

# The steel beam, simply supported, hit in the middle.
STRUCK = {
    "support_position": None, "beam_left_end": "pinned", "beam_right_end": "pinned", "initial_height": 0, "gravity": 0,
    "gauge_position": "3,5", "striker_position": 5, "striker_mass": 80, "striker_velocity": -3, "striker_gap": 0.06,
    "ts_max_time": 0.3, "output_field_interval": 0.01,
}
MEMBER = """\
sections:
  - {name: round, shape: circle, radius: 0.1}
junctions:
  - {name: left, place: [0, 0, 0], held: pinned}
  - {name: right, place: [10, 0, 0], held: pinned}
members:
  - {name: beam, from: left, to: right, section: round, elements: 20}
"""
SPLIT = MEMBER.replace("members:\n", "  - {name: middle, place: [5, 0, 0]}\nmembers:\n").replace(
    "to: right, section: round, elements: 20}", "to: middle, section: round, elements: 10}") + """\
  - {name: rest, from: middle, to: right, section: round, elements: 10}
"""


class Strikers(UdarTest):
    def struck(self, name="run", ranks=RANKS, **changes):
        options = case(**{**STRUCK, **changes})
        if "structure_type" in changes:
            options = {key: value for key, value in options.items() if not key.startswith("beam_")}
        return self.run_case(options, name=name, ranks=ranks)

    @unittest.skipIf(RANKS > 1, "once")
    def test_timoshenkos_ball(self):
        """Three contacts of a steel ball and a steel bar, against an integral equation (ball_on_beam.py)."""
        expected = read_csv(DATA / "ball_on_beam.csv")
        mass = 7850 * 4 / 3 * np.pi * 0.02**3
        hertz = 4 / 3 * 2.1e11 / (2 * (1 - 0.3**2)) * np.sqrt(0.02)
        result = self.struck(
            beam_length=0.307, beam_elements=128, beam_section="rectangle", beam_radius=None, beam_width=0.01,
            beam_height=0.01, filter_frequency=1e7, gauge_position=0.1535, striker_position=0.1535, striker_mass=mass,
            striker_velocity=-0.01, striker_gap=0, striker_law="hertz", striker_stiffness=hertz, ts_max_time=5e-3,
            output_interval=2e-5, output_field_interval=0, output_force_window=2e-5, ts_type="impact")
        contact, striker = result.csv("contact.csv"), result.csv("strikers.csv")
        np.testing.assert_allclose(contact["time"][1:], expected["time"], rtol=1e-9)
        last = expected["impulse"][-1]
        self.assertLess(np.abs(contact["impulse_0"][1:] - expected["impulse"]).max(), 0.01 * last)
        self.assertLess(np.abs(striker["velocity_0"][1:] + expected["velocity"]).max(), 0.01 * 0.02)
        mean = np.diff(expected["impulse"], prepend=0) / 2e-5
        self.assertLess(np.abs(contact["force_0"][1:] - mean).max(), 0.01 * mean.max())
        pressing = contact["force_0"] > 0.01 * mean.max()
        self.assertEqual(np.count_nonzero(np.diff(pressing.astype(int)) == 1), 3)
        self.assertLess(np.abs(result.csv("energy.csv")["drift"]).max(), 1e-8)

    def test_in_a_network_as_on_a_beam(self):
        path = self.scratch / "beam.yaml"
        path.write_text(MEMBER)
        beam = self.struck("beam", ts_rtol=1e-12, ts_type="impact", contact_restitution=None, striker_restitution=0.3)
        network = self.struck("network", structure_type="network", network_file=path, ts_rtol=1e-12, ts_type="impact",
                              striker_restitution=0.3, gauge_position="3,5")
        self.assert_same_curves(beam, network, "strikers.position_0", "strikers.velocity_0", **{"m": 1e-8, "m/s": 1e-8})
        along = datasets(beam.file("results.h5"))["fields/mass_position"]
        data = datasets(network.file("results.h5"))
        order = np.argsort(data["x"], kind="stable")
        found = data["fields/displacement_of_masses"][:, order, 1]
        np.testing.assert_allclose(found, along, rtol=0, atol=1e-9)
        self.assertGreater(np.abs(along).max(), 0.01)
        self.assertGreater(len(beam.csv("impacts.csv")["time"]), 3)

    def test_placed_where_a_network_stands_up(self):
        """By three numbers and by a junction's name, on a beam 3 m up, as by x on one that lies at y = 0."""
        path, split = self.scratch / "beam.yaml", self.scratch / "split.yaml"
        path.write_text(MEMBER)
        split.write_text(SPLIT)
        keys = {"structure_type": "network", "ts_rtol": 1e-12, "ts_type": "impact", "ts_max_time": 0.1}
        low = self.struck("low", network_file=path, **keys)
        high = {"network_shift": "0,3,0", "gauge_position": None, "gauge_place": "3,3,0,5,3,0",
                "striker_position": None, **keys}
        for name, file, where in (("place", path, {"striker_place": "5,3,0"}),
                                  ("junction", split, {"striker_junction": "middle"})):
            found = self.struck(name, network_file=file, **high, **where)
            for table, column in (("strikers.csv", "position_0"), ("gauges.csv", "mass_1")):
                np.testing.assert_allclose(found.csv(table)[column] - 3, low.csv(table)[column], rtol=0, atol=1e-10,
                                           err_msg=f"{name} {column}")
            self.assertNotIn("warning", found.err + found.out)
            self.assertGreater(found.summary()["impacts"], 0)
        far = self.struck("far", network_file=path, **high, striker_place="5,4,0")
        self.assertIn("striker 0 at (5, 4, 0) m is taken to the nearest node, at (5, 3, 0) m", far.err + far.out)

    @unittest.skipIf(RANKS > 1, "once")
    def test_nothing_else_touches_its_node(self):
        """A plane beside a node that is struck would rub the centre of mass of both."""
        path = self.scratch / "beam.yaml"
        path.write_text(MEMBER)
        options = case(**{**STRUCK, "structure_type": "network", "network_file": path, "support_position": 5,
                          "support_height": -1, "support_friction": 0.3, "ts_type": "rk"})
        options = {key: value for key, value in options.items() if not key.startswith("beam_")}
        for normal in ("0,0,1", "1,0,0", "0,1,0"):
            self.refuse_case({**options, "support_normal": normal}, ["-striker_position", "no support", "x = 5"])
        away = self.run_case({**options, "support_normal": "0,0,1", "support_position": 2, "ts_max_time": 0.02})
        self.assertEqual(away.code, 0)

    @unittest.skipIf(RANKS > 1, "once")
    def test_errors_name_keys_of_strikers(self):
        (self.scratch / "law.csv").write_text("0,0\n1e-3,x\n")
        options = case(**{**STRUCK, "striker_law": "table", "striker_unloading_stiffness": 1e9,
                          "striker_table": self.scratch / "law.csv"})
        self.refuse_case(options, ["-striker_table", "law.csv", "x"])

    def test_untouched_beam_stays_where_it_is(self):
        """What is told of the beam is told without what strikes it."""
        away = self.struck(beam_left_end=None, beam_right_end=None, striker_velocity=0, ts_max_time=0.02)
        summary = away.summary()
        self.assertLess(summary["max_deflection"], 1e-15)
        self.assertEqual(summary["impacts"], 0)

    def test_its_solver_is_known(self):
        """Behind the strikers stands the structure's own: what is said of it, and of what it moves."""
        seen = self.struck("seen", ts_max_time=0.03, udar_view=True, ts_type="impact")
        self.assertRegex(seen.out, r"line solver .*chain recursion")
        self.assertGreater(seen.summary()["streamed_bytes"], 0)
        path = self.scratch / "beam.yaml"
        path.write_text(MEMBER)
        network = self.struck("network", structure_type="network", network_file=path, ts_max_time=0.02, udar_view=True)
        self.assertIn("members condensed to junctions", network.out)
        self.assertIn("nodes of a rank, most over mean", network.out)

    def test_the_view_tells_strikers_from_supports(self):
        seen = self.struck("seen", ts_max_time=0.02, udar_view=True)
        said = dict(re.findall(r"(?m)^  (\S.*?)  +(\S.*)$", seen.out))
        self.assertEqual(said["strikers, first node"], "10")
        self.assertEqual(said["strikers, last node"], "10")
        self.assertNotIn("supports, nodes", said)
        self.assertEqual(said["nodes"], "21")
        self.assertEqual(said["mass [kg]"], "2466.15")
        file = datasets(seen.file("results.h5"))
        np.testing.assert_array_equal(file["support_striker"], [0])

    def test_what_files_say(self):
        """Rows of nodes are the beam's own; what was given to the striker is what its support says."""
        result = self.struck(striker_restitution=0.5, ts_type="impact", ts_rtol=1e-11)
        striker, gauges = result.csv("strikers.csv"), result.csv("gauges.csv")
        contact, impacts = result.csv("contact.csv"), result.csv("impacts.csv")
        data = datasets(result.file("results.h5"))
        self.assertEqual(data["fields/mass_position"].shape[1], 21)
        self.assertEqual(len(data["x"]), 21)
        np.testing.assert_allclose(data["mass"][10], 7850 * np.pi * 0.1**2 * 0.5, rtol=1e-12)
        np.testing.assert_array_equal(data["fields/mass_position"][:, 10], gauges["mass_1"])
        np.testing.assert_array_equal(data["fields/line_position"][:, 10], gauges["line_1"])
        self.assertGreaterEqual((striker["position_0"] - gauges["mass_1"]).min(), -1e-12)
        self.assertEqual(striker["position_0"][0], 0.06)
        self.assertEqual(striker["velocity_0"][0], -3)
        np.testing.assert_allclose(80 * (striker["velocity_0"] + 3), contact["impulse_0"], rtol=0, atol=1e-9)
        np.testing.assert_array_equal(impacts["node"], 10)
        np.testing.assert_allclose(impacts["time"][0], 0.02, rtol=1e-12)
        np.testing.assert_allclose(impacts["velocity_before"][0], -3, rtol=1e-12)
        np.testing.assert_allclose(impacts["velocity_after"][0], 1.5, rtol=1e-12)
        node = 7850 * np.pi * 0.1**2 * 0.5
        np.testing.assert_allclose(impacts["impulse"][0], 4.5 * node * 80 / (node + 80), rtol=1e-12)
        envelope = result.csv("envelope.csv")
        self.assertEqual(len(envelope["node"]), 21)
        self.assertGreater(envelope["moment_max"][10], 1e3)
        self.assertLess(np.abs(result.csv("energy.csv")["drift"]).max(), 1e-9)

    @unittest.skipIf(RANKS > 1, "once")
    def test_pictures_show_the_striker(self):
        result = self.struck(ts_max_time=0.05)
        drawn = subprocess.run([os.environ["UDAR_PLOT"], result.directory, "--output", self.scratch / "plots"],
                               capture_output=True, text=True, check=True)
        self.assertNotIn("Warning", drawn.stderr)
        self.assertIn("striker", (self.scratch / "plots" / "gauges.svg").read_text())

    def test_integrators_agree(self):
        runs = [self.struck(name, ts_type=name, ts_rtol=rtol, ts_max_time=0.1, striker_restitution=0.5)
                for name, rtol in (("chebyshev", 1e-14), ("impact", 1e-12), ("rk", 1e-11))]
        for other in runs[1:]:
            for table, name in (("strikers.csv", "position_0"), ("gauges.csv", "mass_1"), ("gauges.csv", "line_0")):
                np.testing.assert_allclose(other.csv(table)[name], runs[0].csv(table)[name], rtol=0, atol=1e-8)

    def test_goes_on_from_a_restart_file(self):
        law = {"striker_law": "crush", "striker_stiffness": 1e6, "striker_plateau_force": 2e4, "ts_type": "impact"}
        for kind, keys in (("rigid", {"ts_type": "impact"}), ("crush", law)):
            whole = self.struck(f"{kind}-whole", ts_max_time=0.2, **keys)
            self.struck(f"{kind}-first", ts_max_time=0.03, **keys)
            file = self.scratch / f"{kind}-first" / "restart.h5"
            rest = self.struck(f"{kind}-rest", ts_max_time=0.2, restart_file=file, **keys)
            one = self.struck(f"{kind}-one", ts_max_time=0.2, ranks=3 - RANKS, restart_file=file, **keys)
            for name in ("position_0", "velocity_0"):
                found = rest.csv("strikers.csv")[name]
                # The first run ended a step where the whole one did not; bits are for cli.continue.
                np.testing.assert_allclose(found, whole.csv("strikers.csv")[name][-len(found):], rtol=0, atol=1e-6)
                np.testing.assert_allclose(one.csv("strikers.csv")[name], found, rtol=0, atol=1e-9)

    @unittest.skipIf(RANKS > 1, "once")
    def test_refuses_other_strikers_at_a_restart(self):
        self.struck(ts_max_time=0.05)
        file = self.scratch / "run" / "restart.h5"
        for changes, text in (({"striker_mass": 81}, "strikers, masses [kg]: 80 there, 81 here"),
                              ({"striker_position": 6}, "strikers, positions [m]: 5 there, 6 here"),
                              ({"striker_side": "below"}, "strikers, sides (1 above, -1 below): 1 there, -1 here")):
            options = case(**{**STRUCK, "restart_file": file, "output_directory": self.scratch / "rest", **changes})
            self.refuse_case(options, [text])


if __name__ == "__main__":
    unittest.main()
