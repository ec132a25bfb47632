#!/usr/bin/env python3
# ranks: 1 2; size: medium
"""Parts of a network that touch each other across a gap, through the program: bars, beams, a mass between beam and
support; laws, files, ranks, restart."""

import os
import re
import unittest

import numpy as np

from common import STOPPED_BY_STEPS, UdarTest, datasets

RANKS = int(os.environ.get("UDAR_RANKS", "1"))
STEEL = 2.1e11, 7850.0  # [Pa], [kg/m^3]
BARS = """\
sections:
  - {name: round, shape: circle, radius: 0.05}
junctions:
  - {name: a, place: [0, 0, 0]}
  - {name: b, place: [1, 0, 0]}
  - {name: c, place: [1.001, 0, 0]}
  - {name: d, place: [2.001, 0, 0]}
members:
  - {name: left, from: a, to: b, elements: 100}
  - {name: right, from: c, to: d, elements: 100}
"""
# One beam lies across two others, over which it stands out.
LOGS = """\
sections:
  - {name: round, shape: circle, radius: 0.05}
junctions:
  - {name: a, place: [0, 0, -1], held: pinned}
  - {name: b, place: [0, 0, 1], held: pinned}
  - {name: c, place: [2, 0, -1], held: pinned}
  - {name: d, place: [2, 0, 1], held: pinned}
  - {name: e, place: [-1, 0.1, 0]}
  - {name: f, place: [3, 0.1, 0]}
members:
  - {name: one, from: a, to: b, elements: 4}
  - {name: other, from: c, to: d, elements: 4}
  - {name: over, from: e, to: f, elements: 8}
"""
ON_LOGS = {"pair_from_place": "0,0,0,2,0,0", "pair_to_place": "0,0.1,0,2,0.1,0", "pair_gap": 0.002,
           "filter_frequency": 2000, "initial_height": 0, "ts_type": "impact"}
# A mass, a short stiff member that stands on a pad, under the middle of a beam.
PROP = """\
sections:
  - {name: round, shape: circle, radius: 0.05}
  - {name: block, shape: circle, radius: 0.2}
junctions:
  - {name: a, place: [-2, 0, 0], held: pinned}
  - {name: b, place: [2, 0, 0], held: pinned}
  - {name: head, place: [0, -0.1, 0]}
  - {name: foot, place: [0, -0.3, 0]}
members:
  - {name: beam, from: a, to: b, elements: 8, section: round}
  - {name: mass, from: foot, to: head, elements: 1, section: block}
"""


class Pairs(UdarTest):
    def touching(self, text, name="run", ranks=RANKS, code=0, **options):
        path = self.scratch / "network.yaml"
        path.write_text(text)
        return self.run_case({"structure_type": "network", "network_file": path, "gravity": 0, **options}, ranks,
                             name=name, code=code)

    def test_a_bar_hands_its_speed_on(self):
        """Waves run through both bars and back: after 2 L / c the one that came stands and the other goes on."""
        radius, speed, touch = 0.05, 2.0, 5e-4
        young, density = STEEL
        contact = 2.0 / np.sqrt(young / density)
        mass = density * np.pi * radius**2
        run = self.touching(
            BARS, filter_frequency=6e5, initial_height=0, initial_part="0,1,0,0,0,0", initial_part_velocity="2,0,0",
            pair_from_junction="b", pair_to_junction="c", pair_normal="1,0,0", pair_gap=0.001, pair_restitution=0,
            ts_type="impact", ts_max_time=1.2e-3, ts_rtol=1e-10, output_interval=1e-5, output_field_interval=1e-5,
            output_force_window=2e-5)
        summary = run.summary()
        self.assertAlmostEqual(summary["first_contact_time"], touch, delta=1e-12)
        data = datasets(run.file("results.h5"))
        # Points at ends are those of nodes 0 to 3, then come inner ones of the first bar.
        masses, velocity = data["mass"], data["fields/mass_velocity"][:, :, 0]
        left = np.isin(data["node"], [0, 1, *range(4, 103)])
        momentum = velocity * masses
        np.testing.assert_allclose(momentum.sum(axis=1), mass * speed, rtol=1e-12)
        self.assertAlmostEqual(momentum[-1, ~left].sum() / mass, speed, delta=0.02 * speed)
        self.assertAlmostEqual(momentum[-1, left].sum() / mass, 0.0, delta=0.02 * speed)
        np.testing.assert_allclose(run.csv("contact.csv")["impulse_0"][-1], momentum[-1, ~left].sum(), rtol=1e-9)
        # While they press the force is rho c A v / 2; found 7e-6, but for the ripple of the mesh.
        time, force, impulse = (run.csv("contact.csv")[name] for name in ("time", "force_0", "impulse_0"))
        pressing = (time > touch + 0.2 * contact) & (time < touch + 0.8 * contact)
        np.testing.assert_allclose(force[pressing].mean(), 0.5 * mass * speed * np.sqrt(young / density), rtol=1e-3)
        for part, share in ((0.5, 0.5), (1.0, 1.0)):
            self.assertAlmostEqual(np.interp(touch + part * contact, time, impulse) / impulse[-1], share, delta=0.02)
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-9)

    def test_a_beam_comes_to_rest_on_two_others(self):
        """Half the weight on each, which each feels as a load, in the end."""
        young, density = STEEL
        weight = 9.81 * density * np.pi * 0.05**2 * 4
        run = self.touching(LOGS, gravity=9.81, damping_mass=20, pair_restitution=0, ts_max_time=2.0,
                            ts_rtol=1e-11,
                            output_interval=0.01, gauge_place="0,0,0,0,0.1,0", **ON_LOGS)
        contact, gauges = run.csv("contact.csv"), run.csv("gauges.csv")
        for pair in (0, 1):
            self.assertAlmostEqual(contact[f"force_{pair}"][-1] / weight, 0.5, delta=1e-6)
        # A pinned beam of 2 m under its own weight, as halves of elements, and a force in the middle.
        bending = young * np.pi * 0.05**4 / 4
        sag = 0.5 * weight * 2**3 / (48 * bending) + self.own_sag(weight / 4, bending)
        self.assertAlmostEqual(-gauges["line_0"][-1] / sag, 1.0, delta=1e-3)
        self.assertAlmostEqual(gauges["mass_1"][-1] - gauges["mass_0"][-1], 0.1 - 0.002, delta=1e-12)
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-9)
        self.assertGreater(run.summary()["impacts"], 0)

    @staticmethod
    def own_sag(per_length, bending, length=2.0, elements=4):
        """In the middle, of the weight of nodes [m]."""
        step = length / elements
        places = step * np.arange(1, elements)
        along = np.minimum(places, length - places)
        return (per_length * step * along * (3 * length**2 - 4 * along**2) / (48 * bending)).sum()

    def test_hertz_between_two_bodies(self):
        """Force against time of two bodies, each in one piece, by a quadrature of the relative motion."""
        stiffness, speed, mass = 1e6, 1.0, 7850 * np.pi * 0.05**2
        run = self.touching(
            BARS.replace("elements: 100", "elements: 1"), filter_frequency=1e5, initial_height=0,
            initial_part="0,1,0,0,0,0", initial_part_velocity="1,0,0", pair_from_junction="b", pair_to_junction="c",
            pair_normal="1,0,0", pair_gap=0, pair_law="hertz", pair_stiffness=stiffness, ts_type="impact",
            ts_max_time=0.2, output_interval=1e-3)
        reduced = 0.5 * mass
        deepest = (1.25 * reduced * speed**2 / stiffness) ** 0.4
        # The time of the way in by d = deepest (1 - s^2), in which nothing is singular, by the middles of parts.
        ends = np.linspace(0, 1, 20001)
        middles = 0.5 * (ends[1:] + ends[:-1])
        rate = np.sqrt(speed**2 - 0.8 * stiffness / reduced * (deepest * (1 - middles**2)) ** 2.5)
        before = np.cumsum(2 * deepest * middles / rate) * ends[1]  # from where it is deepest
        half = before[-1]
        contact = run.csv("contact.csv")
        inwards = contact["time"] < half
        # The impulse is the change of the relative momentum.
        expected = 1 - np.interp(contact["time"][inwards], (half - before)[::-1], rate[::-1]) / speed
        found = contact["impulse_0"] / (reduced * speed)
        self.assertGreater(np.count_nonzero(inwards), 10)
        np.testing.assert_allclose(found[inwards], expected, atol=2e-3)
        self.assertAlmostEqual(found[-1], 2.0, delta=2e-3)
        self.assertAlmostEqual(run.summary()["last_contact_time"] / (2 * half), 1.0, delta=2e-3)

    def test_a_mass_between_beam_and_support(self):
        """It lies on a pad and is hit by the beam from above: contact on both of its sides, at rest in the end."""
        run = self.touching(
            PROP, gravity=9.81, damping_mass=20, filter_frequency=2000, initial_height=0, ts_type="impact",
            pair_from_junction="head", pair_to_place="0,0,0", pair_gap=0.004, pair_restitution=0.2,
            support_position=0, support_y_position=-0.3, support_y_width=0.01, support_height=-0.305,
            contact_restitution=0.2, load_place="0,0,0", load_table=self.table("0,0\n0.01,-2e4\n3,-2e4\n"),
            ts_max_time=3.0, output_interval=0.01, ts_rtol=1e-11)
        block = 9.81 * 7850 * np.pi * 0.2**2 * 0.2
        contact = run.csv("contact.csv")
        self.assertAlmostEqual(contact["force_0"][-1] - contact["force_1"][-1], block, delta=1e-6 * block)
        self.assertGreater(contact["force_1"][-1], 1e3)
        self.assertEqual(set(run.csv("impacts.csv")["support"]), {0, 1})
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-9)

    def table(self, text):
        path = self.scratch / "load.csv"
        path.write_text(text)
        return path

    def test_what_files_say(self):
        run = self.touching(LOGS, gravity=9.81, pair_restitution=0.5, ts_max_time=0.3,
                            output_field_interval=0.01, gauge_place="0,0,0,0,0.1,0", **ON_LOGS)
        data, gauges = datasets(run.file("results.h5")), run.csv("gauges.csv")
        np.testing.assert_array_equal(data["support_pair"], [0, 1])
        self.assertNotIn("support_striker", data)
        rows = [int(np.flatnonzero(data["node"] == node)[0]) for node in data["pair_nodes"]]
        places = np.column_stack([data["x"][rows], data["y"][rows]])
        np.testing.assert_allclose(places, [[0, 0], [0, 0.1], [2, 0], [2, 0.1]], atol=1e-12)
        # Half of two elements, each 0.5 m long: of both nodes of a pair.
        for place in ((0, 0, 0), (0, 0.1, 0)):
            at = np.flatnonzero((data["x"] == place[0]) & (data["y"] == place[1]) & (np.abs(data["z"]) < 1e-12))
            self.assertEqual(len(at), 1)
            np.testing.assert_allclose(data["mass"][at], 7850 * np.pi * 0.05**2 * 0.5, rtol=1e-12)
            moved = data["fields/displacement_of_masses"][:, at[0], 1]
            np.testing.assert_allclose(moved, gauges[f"mass_{int(place[1] > 0)}"][::10] - place[1], atol=1e-15)
        gap = gauges["mass_1"] - gauges["mass_0"] - 0.1 + 0.002
        self.assertGreater(gap.min(), -1e-12)
        self.assertAlmostEqual(gap[0], 0.002, delta=1e-15)
        impacts = run.csv("impacts.csv")
        self.assertEqual(set(impacts["support"]), {0, 1})
        np.testing.assert_allclose(impacts["velocity_after"], -0.5 * impacts["velocity_before"], atol=1e-12)
        self.assertRegex(run.out, r"pair +\(0, 0, 0\) m and \(0, 0\.1, 0\) m touch along \(0, 1, 0\), 0\.002 m apart")
        self.assertRegex(run.out, r"0  pair 0 of nodes +\d")
        self.assertEqual(len(run.summary()["support_impulse"]), 2)
        seen = self.touching(LOGS, "seen", udar_view=True, ts_max_time=1e-3, **ON_LOGS)
        said = dict(re.findall(r"(?m)^  (\S.*?, asked \[m\], node, its place \[m\]) +(.*)$", seen.out))
        self.assertEqual(said["second node of pair 1, asked [m], node, its place [m]"].split()[:3], ["2", "0.1", "0"])
        self.assertEqual(said["first node of pair 1, asked [m], node, its place [m]"].split()[-3:], ["2", "0", "0"])

    def test_any_number_of_ranks_and_a_restart(self):
        """On one and two ranks to rounding; what goes on after a stop is the straight run to the bit."""
        options = {**ON_LOGS, "gravity": 9.81, "pair_law": "hunt_crossley", "pair_stiffness": 1e8, "pair_damping": 0.2,
                   "ts_max_time": 0.3, "gauge_place": "0,0,0,0,0.1,0", "restart_interval": 0.02}
        for kind, changes in (("law", {}), ("rigid", {"pair_law": "none", "pair_stiffness": None, "pair_damping": None,
                                                     "pair_restitution": 0.3})):
            given = {key: value for key, value in {**options, **changes}.items() if value is not None}
            whole = self.touching(LOGS, f"{kind}-whole", **given)
            other = self.touching(LOGS, f"{kind}-other", ranks=3 - RANKS, **given)
            for name in ("mass_0", "mass_1", "line_0"):
                np.testing.assert_allclose(other.csv("gauges.csv")[name], whole.csv("gauges.csv")[name], rtol=0,
                                           atol=1e-10, err_msg=f"{kind} {name}")
            self.touching(LOGS, f"{kind}-first", ts_max_steps=60, code=STOPPED_BY_STEPS, **given)
            rest = self.touching(LOGS, f"{kind}-rest", **given,
                                 restart_file=self.scratch / f"{kind}-first" / "restart.h5")
            for file in ("gauges.csv", "contact.csv", "impacts.csv", "energy.csv"):
                all_rows = whole.file(file).read_text().splitlines()
                tail = rest.file(file).read_text().splitlines()[1:]
                self.assertEqual(tail, all_rows[len(all_rows) - len(tail) :], f"{kind} {file}")
            self.assertGreater(len(rest.csv("gauges.csv")["time"]), 3)
        changed = {**given, "pair_gap": 0.003, "restart_file": self.scratch / "rigid-first" / "restart.h5"}
        self.refuse_case({"structure_type": "network", "network_file": self.scratch / "network.yaml",
                          "output_directory": self.scratch / "changed", **changed},
                         ["pairs of nodes, gaps [m]: 0.002 0.002 there, 0.003 0.003 here"])


if __name__ == "__main__":
    unittest.main()
