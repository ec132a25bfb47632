#!/usr/bin/env python3
# ranks: 1; size: medium
"""Networks against planes of any direction: walls, inclines, corners, pads; and how they start in space."""

import re
import unittest

import h5py
import numpy as np

from common import STOPPED_BY_STEPS, UdarTest, run
from space import listed, turn

# No two directions of it are alike: a turned copy that answers as the first does not do so by symmetry.
PLACES = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 0.2, 1.5], [1.0, 1.8, 0.6]])
MEMBERS = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)]
ELEMENTS = 4
SECTION = "{name: bar, shape: rectangle, width: 0.06, height: 0.1}"
FLIGHT = {"structure_type": "network", "filter_frequency": 300, "gravity": 0, "initial_height": 0,
          "support_position": 0, "support_width": "inf", "ts_rtol": 1e-9, "ts_max_time": 0.04, "output_interval": 1e-3,
          "output_field_interval": 0.01}


def frame(rotation, shift=(0.0, 0.0, 0.0), places=PLACES):
    """A frame in YAML; members' own axes turn with it."""
    turned = places @ rotation.T + np.array(shift)
    up = rotation @ np.array([0.1, 1.0, -0.2])
    lines = ["sections:", f"  - {SECTION}", "junctions:"]
    lines += [f"  - {{name: j{i}, place: [{listed(place)}]}}" for i, place in enumerate(turned)]
    lines += ["members:"]
    lines += [f"  - {{from: j{a}, to: j{b}, section: bar, elements: {ELEMENTS}, orientation: [{listed(up)}]}}"
              for a, b in MEMBERS]
    return "\n".join(lines) + "\n"


def mean_displacements(run_of, masses):
    """Of all masses, at the times of the fields [m]."""
    with h5py.File(run_of.file("results.h5"), "r") as file:
        moved = file["/fields/displacement_of_masses"][()]
        times = file["/fields/time"][()]
    return times, np.einsum("tnk,n->tk", moved, masses) / masses.sum()


def masses_of(run_of):
    with h5py.File(run_of.file("results.h5"), "r") as file:
        mass = file["/mass"][()]
        return mass, np.array([file[f"/{axis}"][()] if axis in file else 0 * mass for axis in "xyz"]).T


class NetworkContactTest(UdarTest):
    def fly(self, name, text, velocity, ranks=0, code=0, **options):
        path = self.scratch / f"{name}.yaml"
        path.write_text(text)
        given = {"network_file": path, "initial_velocity": f"{velocity[1]:.17g}",
                 "initial_velocity_x": f"{velocity[0]:.17g}", "initial_velocity_z": f"{velocity[2]:.17g}"}
        return self.run_case({**FLIGHT, **given, **options}, ranks, name=name, code=code)

    @staticmethod
    def momenta(run_of):
        """Of all masses along x, y, z, at the times of the fields [N s]."""
        with h5py.File(run_of.file("results.h5"), "r") as file:
            return np.einsum("n,tnk->tk", file["/mass"][()], file["/fields/mass_velocity"][()])

    def same(self, expected, found, tolerance):
        """Energies, contact and impulses of two runs."""
        self.assertGreater(max(abs(value) for value in expected.summary()["support_impulse"]), 100.0)
        rows, others = expected.csv("energy.csv"), found.csv("energy.csv")
        scale = np.abs(rows["kinetic"]).max()
        for column in ("kinetic", "line_strain", "fictitious_springs", "lost_in_impacts"):
            self.assertLess(np.abs(rows[column] - others[column]).max(), tolerance * scale, f"{column}{found}")
        self.assertEqual(found.summary()["impacts"], expected.summary()["impacts"], found)
        np.testing.assert_allclose(np.abs(found.summary()["support_impulse"]),
                                   np.abs(expected.summary()["support_impulse"]), rtol=tolerance, err_msg=str(found))


class Turned(NetworkContactTest):
    """A turned copy of a fall gives the turned answer."""

    ROTATIONS = {"wall": turn((0, 0, 1), -np.pi / 2), "behind": turn((1, 0, 0), -np.pi / 2),
                 "ceiling": turn((0, 0, 1), np.pi), "oblique": turn((0.3, 0.5, -1.0), 0.9),
                 "down": turn((1.0, 0.2, 0.4), 2.4)}

    def check(self, tolerance, **options):
        straight = self.fly("floor", frame(np.eye(3)), (0, -2, 0), support_height=-0.01, **options)
        for name, rotation in self.ROTATIONS.items():
            with self.subTest(name):
                normal = rotation @ (0, 1, 0)
                velocity = rotation @ (0, -2, 0)
                found = self.fly(name, frame(rotation), velocity, support_height=-0.01, support_normal=listed(normal),
                                 **options)
                self.same(straight, found, tolerance)

    def test_masses_that_bounce(self):
        self.check(1e-7, ts_type="impact", contact_restitution=0.5)

    def test_masses_on_springs(self):
        self.check(1e-7, ts_type="rk", support_stiffness=1e7)

    def test_line(self):
        self.check(1e-6, ts_type="impact", contact_surface="line")

    def test_an_oblique_plane_on_two_ranks(self):
        rotation = self.ROTATIONS["oblique"]
        options = {"support_height": -0.01, "support_normal": listed(rotation @ (0, 1, 0)), "ts_type": "impact",
                   "contact_restitution": 0.5}
        one, two = (self.fly(f"np{ranks}", frame(rotation), rotation @ (0, -2, 0), ranks, **options)
                    for ranks in (1, 2))
        self.same(one, two, 1e-8)

    def test_a_corner_of_two_planes(self):
        both = {"support_position": "0,0", "support_height": "-0.01,-0.02", "contact_restitution": 0.8,
                "ts_type": "impact"}
        velocity = np.array([-1.5, -2.0, 0.3])
        straight = self.fly("corner", frame(np.eye(3)), velocity, support_normal="0,1,0,1,0,0", **both)
        self.assertGreater(min(np.abs(straight.summary()["support_impulse"])), 50.0, straight)
        rotation = self.ROTATIONS["oblique"]
        normals = listed([rotation @ (0, 1, 0), rotation @ (1, 0, 0)])
        self.same(straight, self.fly("turned", frame(rotation), rotation @ velocity, support_normal=normals, **both),
                  1e-7)

    def test_a_corner_of_three_planes_in_any_order(self):
        rotation = self.ROTATIONS["oblique"]
        normals, heights = rotation.T, np.array([-0.01, -0.02, -0.015])  # of faces turned from x, y, z
        runs = []
        for order in ([0, 1, 2], [0, 2, 1], [2, 0, 1]):
            given = {"support_position": "0,0,0", "support_normal": listed(normals[order]),
                     "support_height": listed(heights[order]), "ts_type": "impact", "ts_max_time": 0.015}
            found = self.fly("".join(map(str, order)), frame(rotation), rotation @ (-1.5, -2.0, -1.8), **given)
            runs.append(np.array(found.summary()["support_impulse"])[np.argsort(order)])
        self.assertGreater(np.abs(runs[0]).min(), 20.0)
        for other in runs[1:]:
            np.testing.assert_allclose(other, runs[0], rtol=1e-8)

    def test_a_wall_that_moves(self):
        table = self.scratch / "motion.csv"
        table.write_text("time,height\n0,0\n0.01,0.005\n0.03,0.03\n1,0.03\n")
        options = {"support_height": -0.01, "support_motion": table, "ts_type": "impact"}
        straight = self.fly("floor", frame(np.eye(3)), (0, -1, 0), **options)
        found = self.fly("wall", frame(turn((0, 0, 1), np.pi / 2)), (1, 0, 0), support_normal="-3,0,0", **options)
        self.same(straight, found, 1e-7)


    def test_the_program_turns_it_as_well(self):
        angles = np.array([0.4, -0.7, 1.1])
        rotation = turn((0, 0, 1), angles[2]) @ turn((0, 1, 0), angles[1]) @ turn((1, 0, 0), angles[0])
        shift = np.array([1.0, -2.0, 0.5])
        normal = rotation @ (0, 1, 0)
        options = {"ts_type": "impact", "contact_restitution": 0.5, "support_normal": listed(normal),
                   "support_height": f"{-0.01 + shift @ normal:.17g}"}
        own = self.fly("file", frame(rotation, shift), rotation @ (0, -2, 0), **options)
        found = self.fly("options", frame(np.eye(3)), rotation @ (0, -2, 0), **options,
                         network_rotation=listed(angles), network_shift=listed(shift))
        self.same(own, found, 1e-9)


class Restarts(NetworkContactTest):
    ROTATION = turn((0.3, 0.5, -1.0), 0.9)
    CASE = {"support_height": -0.005, "support_normal": listed(ROTATION @ (0, 1, 0)), "contact_restitution": 0.3,
            "support_friction": 0.2, "ts_type": "rk", "gauge_place": "0,0,0", "output_field_interval": 0}

    def fall(self, name, **changes):
        return self.fly(name, frame(self.ROTATION), self.ROTATION @ (0.5, -1, 0.3), **{**self.CASE, **changes})

    def test_goes_on_as_if_it_had_never_stopped(self):
        whole = self.fall("whole")
        first = self.fall("first", ts_max_steps=40, code=STOPPED_BY_STEPS)
        second = self.fall("second", restart_file=first.file("restart.h5"))
        self.assertGreater(whole.summary()["impacts"], first.summary()["impacts"])
        for name in ("gauges.csv", "contact.csv", "impacts.csv"):
            rows, tail = (run_of.file(name).read_text().splitlines() for run_of in (whole, second))
            self.assertGreater(len(tail), 1)
            self.assertEqual(tail[1:], rows[len(rows) - len(tail) + 1:], name)
        self.assertEqual(second.summary()["support_impulse"], whole.summary()["support_impulse"])

    def test_another_plane_is_refused(self):
        first = self.fall("first", ts_max_time=0.002)
        path = self.scratch / "first.yaml"
        for change, words in (({"support_normal": "1,0,0"}, "normals, x"), ({"support_friction": 0.3}, "friction"),
                              ({"support_z_width": 9}, "z from")):
            failed = run({**FLIGHT, **self.CASE, "network_file": path, "output_directory": self.scratch / "run",
                          "restart_file": first.file("restart.h5"), **change})
            self.assertIn(words, failed.errors[0])


class Slopes(NetworkContactTest):
    def test_a_frame_slides_down_an_incline_as_a_body_does(self):
        angle = 0.4
        rotation = turn((0, 0, 1), -angle)
        normal = rotation @ (0, 1, 0)
        slid = self.fly("incline", frame(rotation), (0, 0, 0), support_normal=listed(normal), gravity=9.81,
                        support_height=0, contact_restitution=0, ts_type="impact", ts_max_time=0.3)
        masses, _ = masses_of(slid)
        times, moved = mean_displacements(slid, masses)
        down = np.array([np.cos(angle), -np.sin(angle), 0.0]) * 0.5 * 9.81 * np.sin(angle) * times[:, None] ** 2
        along = moved - (moved @ normal)[:, None] * normal
        self.assertLess(np.abs(along - down).max(), 1e-9 * np.abs(down).max(), slid)
        self.assertLess(abs(slid.csv("energy.csv")["drift"]).max(), 1e-6, slid)  # 5e-7 where little has moved yet

    def slide(self, name, friction, angle=0.5, speed=2.0, end=0.4, **options):
        """One heavy frame of masses that rest on an incline, thrown up it: its mean way along the slope."""
        rotation = turn((0, 0, 1), -angle)
        down = np.array([np.cos(angle), -np.sin(angle), 0.0])
        flat = frame(rotation, places=np.array([[0, 0, 0], [2.0, 0, 0], [0.3, 0, 1.5], [1.0, 0, 0.6]]))
        slid = self.fly(name, flat, -speed * down, support_normal=listed(rotation @ (0, 1, 0)), gravity=9.81,
                        support_height=0, contact_restitution=0, support_friction=friction, ts_type="rk",
                        ts_max_time=end, output_field_interval=end / 40, **options)
        masses, _ = masses_of(slid)
        times, moved = mean_displacements(slid, masses)
        drift = np.abs(slid.csv("energy.csv")["drift"]).max()
        self.assertLess(drift, 1e-6, slid)
        return times, moved @ down

    def test_a_body_thrown_up_an_incline_with_friction(self):
        angle, speed, g = 0.5, 2.0, 9.81
        for friction in (0.2, 0.9):  # it comes back down, it stays
            up, back = g * (np.sin(angle) + friction * np.cos(angle)), g * (np.sin(angle) - friction * np.cos(angle))
            top = speed / up
            errors = []
            for step in (4e-4, 2e-4):
                times, way = self.slide(f"{friction}_{step}", friction, angle, speed, ts_adapt_dt_max=step,
                                        ts_rtol=1e-6)
                late = np.maximum(times - top, 0.0)
                early = np.minimum(times, top)
                exact = -speed * early + 0.5 * up * early**2 + 0.5 * max(back, 0.0) * late**2
                errors.append(np.abs(way - exact).max())
            with self.subTest(friction=friction):
                self.assertLess(errors[1], 2e-3 * speed**2 / up / 2)
                self.assertLess(errors[1], 0.6 * errors[0], "first order")

    def test_a_body_at_rest_on_an_incline(self):
        angle, g = 0.5, 9.81  # tan = 0.546
        steps = (4e-4, 2e-4)
        stuck = [self.slide(f"stuck-{step}", 0.6, angle, 0.0, ts_adapt_dt_max=step, ts_rtol=1e-6) for step in steps]
        for step, (times, way) in zip(steps, stuck):
            # It falls freely along the slope in each step and is stopped at its end: half a step's speed, no more.
            self.assertLess(np.abs(way - 0.5 * g * np.sin(angle) * step * times).max(), 1e-2 * way.max())
        self.assertLess(stuck[1][1].max(), 0.51 * stuck[0][1].max())
        self.assertLess(stuck[1][1].max(), 2e-3 * 0.5 * g * np.sin(angle) * 0.4**2)
        times, way = self.slide("slides", 0.5, angle, 0.0, ts_adapt_dt_max=steps[1], ts_rtol=1e-6)
        slid = 0.5 * g * (np.sin(angle) - 0.5 * np.cos(angle)) * times**2
        self.assertLess(np.abs(way - slid).max(), 0.5 * g * np.sin(angle) * steps[1] * 0.4)

    def test_friction_of_an_impact(self):
        # One point of contact: what it gives along the normal, times the coefficient, is what it takes across.
        lone = frame(np.eye(3), places=np.array([[0, 0.6, 0], [1.0, 0, 0.1], [0.3, 0.8, 0.9], [0.6, 0.9, 0.3]]))
        across = np.array([0.7, 0.4])
        for friction, sticks in ((0.1, False), (0.5, True)):
            hit = self.fly(f"hit_{friction}", lone, (0.7, -3, 0.4), support_height=-0.01, contact_restitution=1,
                           support_friction=friction, ts_max_time=0.0045, output_field_interval=4.5e-3)
            impacts = hit.csv("impacts.csv")
            self.assertEqual(len(impacts["time"]), 1, hit)
            impulse = impacts["impulse"][0]
            mass = impulse / (2 * 3)
            self.assertEqual(friction * impulse > mass * np.linalg.norm(across), sticks)
            momentum = self.momenta(hit)
            taken = mass * across if sticks else friction * impulse * across / np.linalg.norm(across)
            np.testing.assert_allclose((momentum[-1] - momentum[0])[[0, 2]], -taken, rtol=1e-8)
            self.assertLess(np.abs(hit.csv("energy.csv")["drift"]).max(), 1e-9, hit)
            lost = 0.5 * mass * (across @ across) if sticks else taken @ across - 0.5 * taken @ taken / mass
            np.testing.assert_allclose(hit.csv("energy.csv")["lost_in_impacts"][-1], lost, rtol=1e-9)
            np.testing.assert_allclose(impacts["energy_loss"], [lost], rtol=1e-9)

    def test_momentum_is_what_the_supports_gave(self):
        rotation = turn((0.3, 0.5, -1.0), 0.9)
        normals = np.array([rotation @ (0, 1, 0), rotation @ (0, 0, 1)])
        velocity = rotation @ (0.4, -2.0, -1.0)
        run_of = self.fly("corner", frame(rotation), velocity, support_position="0,0", support_normal=listed(normals),
                          support_height=-0.01, contact_restitution=0.6, ts_type="impact")
        momentum = self.momenta(run_of)
        np.testing.assert_allclose(momentum[0] / np.linalg.norm(momentum[0]), velocity / np.linalg.norm(velocity))
        signs = np.sign(normals[np.arange(2), np.abs(normals).argmax(axis=1)])
        given = np.array(run_of.summary()["support_impulse"]) * signs @ normals
        self.assertGreater(np.abs(given).max(), 500.0)
        np.testing.assert_allclose(momentum[-1] - momentum[0], given, atol=1e-9 * np.abs(given).max())


class Starts(NetworkContactTest):
    def test_spin_is_about_the_centre_of_mass(self):
        spin = np.array([0.3, -0.5, 0.7])
        drift = np.array([0.2, 0.4, -0.1])
        flown = self.fly("spin", frame(np.eye(3)), drift, support_position=None, support_width=None,
                         initial_spin=listed(spin), ts_type="chebyshev", ts_max_time=0.01,
                         output_field_interval=0.01)
        masses, places = masses_of(flown)
        with h5py.File(flown.file("results.h5"), "r") as file:
            found = file["/fields/mass_velocity"][()][-1]
        centre = masses @ places / masses.sum()
        np.testing.assert_allclose(found, drift + np.cross(spin, places - centre), atol=1e-9)

    def test_pads_hold_what_stands_on_them(self):
        grillage = {"network_grillage": "3,3", "network_elements": 2, "network_spacing": 1}
        four = {"support_position": "0,2,0,2", "support_width": 0.2, "support_z_position": "0,0,2,2",
                "support_z_width": 0.2, "support_height": 0}
        shown = self.run_case({**FLIGHT, **grillage, **four, "gravity": 9.81, "initial_height": 0.01, "udar_view": True,
                               "ts_max_time": 0.08})
        contact = shown.csv("contact.csv")
        self.assertEqual(contact["masses"].max(), 4, shown)
        impulse = np.array(shown.summary()["support_impulse"])
        self.assertGreater(impulse.min(), 0.0)
        np.testing.assert_allclose(impulse, impulse[0], rtol=1e-6)


class Floors(NetworkContactTest):
    GRILLAGE = {"network_spacing": 1, "network_elements": 2, "support_position": None, "support_width": None,
                "floor": True, "contact_surface": "line", "gravity": 9.81, "initial_height": 0.02}

    def test_a_line_over_hundreds_of_nodes(self):
        fallen = self.run_case({**FLIGHT, **self.GRILLAGE, "network_grillage": "7,7", "ts_type": "impact",
                                "ts_rtol": 1e-6, "ts_max_time": 0.1})
        self.assertEqual(fallen.csv("contact.csv")["masses"].max(), 49 + 2 * 42, fallen)
        self.assertLess(np.abs(fallen.csv("energy.csv")["drift"]).max(), 1e-6, fallen)

    def test_too_many_are_refused(self):
        failed = run({"output_directory": self.scratch / "run", **FLIGHT, **self.GRILLAGE, "network_grillage": "30,30"})
        self.assertIn("more than 2000 contact points", failed.errors[0])


class Boxes(NetworkContactTest):
    """Boxes as obstacles: planes with edges, of which one entry makes as many as somebody faces."""

    def test_a_box_is_its_faces(self):
        # Beside the second foot, and under the first.
        boxes = {"support_position": None, "support_width": None,
                 "support_box": "2.01,3,-0.2,0.5,-0.5,0.5,-0.5,0.5,-1,-0.01,-0.5,1.6"}
        faces = {"support_position": "0,0", "support_width": "inf,1", "support_normal": "-1,0,0,0,1,0",
                 "support_height": "-2.01,-0.01", "support_y_position": "0.15,0", "support_y_width": "0.7,inf",
                 "support_z_position": "0,0.55", "support_z_width": "1,2.1"}
        for ways in ({"ts_type": "impact", "contact_restitution": "0.5,0.8"},
                     {"ts_type": "rk", "support_friction": "0.4,0.2"}):
            with self.subTest(ways=ways):
                planes, found = (self.fly(f"{ways['ts_type']}-{name}", frame(np.eye(3)), (2, -2, 0.1), **ways, **given)
                                 for name, given in (("planes", faces), ("boxes", boxes)))
                self.assertGreater(min(np.abs(planes.summary()["support_impulse"])), 50.0)
                self.same(planes, found, 1e-12)

    BAR = {"structure_type": "network", "network_grillage": "2,1", "network_spacing": 2, "network_elements": 20,
           "filter_frequency": 3000, "gravity": 0, "initial_height": 0, "initial_velocity_x": 1, "ts_type": "impact",
           "ts_max_time": 2e-3, "output_interval": 1e-5, "output_field_interval": 0}

    def test_a_bar_flies_at_the_side_of_a_box(self):
        hit = self.run_case({**self.BAR, "support_box": "2.0005,3,-0.1,0.1,-0.1,0.1"})
        impacts = hit.csv("impacts.csv")
        self.assertEqual(set(impacts["node"]), {1})
        self.assertAlmostEqual(impacts["time"][0], 5e-4, delta=1e-12)
        self.assertEqual(len(hit.summary()["support_impulse"]), 1)
        over = self.run_case({**self.BAR, "support_box": "0.5,1.5,-1,-0.01,-1,1"}, name="over")
        self.assertEqual(over.summary()["impacts"], 0, "along its top")

    def test_a_grillage_lands_on_a_box(self):
        grillage = {"network_grillage": "3,3", "network_elements": 2, "network_spacing": 1}
        fallen = self.run_case({**FLIGHT, **grillage, "support_position": None, "support_width": None, "gravity": 9.81,
                                "initial_height": 0.05, "support_box": "-0.1,1.1,-1,-0.01,0.9,2.1",
                                "ts_max_time": 0.15})
        _, places = masses_of(fallen)
        touched = np.unique(fallen.csv("impacts.csv")["node"].astype(int))
        over = (places[:, 0] < 1.1) & (places[:, 2] > 0.9)
        self.assertEqual(list(touched), list(np.flatnonzero(over)), fallen)
        self.assertAlmostEqual(fallen.csv("impacts.csv")["time"][0], np.sqrt(2 * 0.06 / 9.81), delta=1e-9)

    def test_who_touches_from_beyond_an_edge_is_told(self):
        grillage = {**FLIGHT, "network_grillage": "3,3", "network_elements": 2, "ts_type": "chebyshev",
                    "ts_max_time": 0.06}
        pad = {**grillage, "support_position": 1, "support_width": 0.2, "support_height": -0.05, "initial_velocity": -1}
        box = {**grillage, "support_position": None, "support_width": None, "support_box": "2.1,3,-0.5,0.3,-1,3",
               "initial_velocity_x": 2}
        for name, options, beyond in (
            ("pad", {**pad, "initial_velocity_x": 10}, 0.45),
            ("box", {**box, "initial_height": 1}, 0.7),
            ("over the pad", pad, None),
            ("beside the box", box, None),
        ):
            with self.subTest(name):
                found = self.run_case(options, name=name)
                self.assertGreater(found.summary()["impacts"], 0)
                warned = [text for text in found.summary()["warnings"] if "beyond its edges" in text]
                if beyond is None:
                    self.assertEqual(warned, [])
                    continue
                (warning,) = warned
                off = float(re.search(r"m, by ([0-9.]+) m at t = ", warning).group(1))
                self.assertAlmostEqual(off, beyond, delta=0.06)

    def test_refusals(self):
        path = self.scratch / "frame.yaml"
        path.write_text(frame(np.eye(3)))
        case = {**FLIGHT, "support_position": None, "support_width": None, "network_file": path}
        for words, changes in (
            (["-support_box", "5 numbers", "six"], {"support_box": "0,1,0,1,0"}),
            (["-support_box", "1,0,0,1,0,1", "from < to"], {"support_box": "1,0,0,1,0,1"}),
            (["-support_box", "node at (2, 0.1, 0)", "in it", "-network_shift"], {"support_box": "1.9,3,0,1,-1,1"}),
            (["-support_box", "above, below or beside"], {"support_box": "5,6,5,6,5,6"}),
            (["-support_box", "overlaps"], {"support_box": "-1,1,-1,-0.1,-1,1", "initial_height": -1}),
            (["-contact_restitution", "3", "2"],
             {"support_box": "-1,1,-1,-0.1,-1,1", "floor": True, "floor_height": -3, "contact_restitution": "1,1,1"}),
            (["-support_box", "-structure_type network"],
             {"structure_type": "beam", "network_file": None, "support_box": "0,1,-1,0,0,1"}),
        ):
            with self.subTest(changes=changes):
                self.refuse_case({**case, **changes}, words)


class HeightFields(NetworkContactTest):
    """Ground given by its heights over a grid."""

    SLOPES = np.array([0.3, -0.2])
    BELOW = -0.52  # of the plane at the origin: the frame's second foot is 0.02 above it
    ABOVE = 1.64  # its top is 0.02 below it

    def table(self, name, height, x=(-1, 0.5, 1, 2.5, 4), z=(-1, 0, 2, 3)):
        path = self.scratch / f"{name}.csv"
        path.write_text("x,z,height\n" + "".join(f"{a},{b},{height(a, b):.17g}\n" for a in x for b in z))
        return path

    def plane(self, start=BELOW):
        return self.table("plane", lambda x, z: start + self.SLOPES @ (x, z))

    def flat_grid(self, start):
        """The same plane as a map: x to the east, z to the south."""
        rows = [" ".join(f"{start + self.SLOPES @ (x, z):.17g}" for x in range(-1, 5)) for z in range(-1, 4)]
        path = self.scratch / "plane.asc"
        head = "ncols 6\nnrows 5\nxllcenter -1\nyllcenter -3\ncellsize 1\nNODATA_value -9999\n"
        path.write_text(head + "\n".join(rows) + "\n")
        return path

    def test_a_plane_is_a_plane(self):
        normal = np.array([-self.SLOPES[0], 1.0, -self.SLOPES[1]])
        for ways in ({"ts_type": "impact", "contact_restitution": 0.5}, {"ts_type": "rk", "support_friction": 0.3},
                     {"ts_type": "rk", "support_stiffness": 1e7}, {"ts_type": "impact", "contact_surface": "line"},
                     {"ts_type": "impact", "support_side": "above"}):
            with self.subTest(ways=ways):
                start, speed = (self.ABOVE, 2) if "support_side" in ways else (self.BELOW, -2)
                velocity = (0.3, speed, 0.1)
                height = f"{start / np.linalg.norm(normal):.17g}"
                name = "-".join(str(value) for value in ways.values())
                plane = self.fly(f"plane-{name}", frame(np.eye(3)), velocity, support_normal=listed(normal),
                                 support_height=height, **ways)
                for field in (self.plane(start), self.flat_grid(start)):
                    found = self.fly(f"field-{name}", frame(np.eye(3)), velocity, support_height_field=field,
                                     output_overwrite=True, **ways)
                    self.same(plane, found, 1e-12)
                    self.assertLess(found.summary()["height_field_error"], 1e-14)

    def test_ranks_agree(self):
        field = self.table("valley", lambda x, z: -0.02 + 0.02 * x**2 + 0.03 * z**2 - 0.01 * x * z)
        one, two = (self.fly(f"np{ranks}", frame(np.eye(3)), (0.2, -2, 0.1), ranks, support_height_field=field,
                             ts_type="impact", contact_restitution=0.5) for ranks in (1, 2))
        self.same(one, two, 1e-9)
        self.assertAlmostEqual(one.summary()["height_field_error"], two.summary()["height_field_error"], delta=1e-12)

    @staticmethod
    def normals(places):
        """Of the field of the next test."""
        slopes = np.column_stack([0.06 * places[:, 0] - 0.02 * places[:, 2] - 0.02, np.ones(len(places)),
                                  -0.02 * places[:, 0] + 0.04 * places[:, 2]])
        slopes[:, [0, 2]] *= -1
        return slopes / np.linalg.norm(slopes, axis=1)[:, None]

    def test_momentum_is_what_the_ground_gave(self):
        field = self.table("curved", lambda x, z: -0.02 + 0.03 * x**2 - 0.02 * x * z - 0.02 * x + 0.02 * z**2)
        hit = self.fly("momentum", frame(np.eye(3)), (0.4, -2.0, -0.3), support_height_field=field, ts_type="impact",
                       ts_max_time=0.1)
        _, places = masses_of(hit)
        impacts = hit.csv("impacts.csv")
        self.assertGreater(len(set(impacts["node"])), 1)
        given = impacts["impulse"] @ self.normals(places)[impacts["node"].astype(int)]
        momentum = self.momenta(hit)
        self.assertGreater(np.abs(given).min(), 1.0, "along each axis")
        np.testing.assert_allclose(momentum[-1] - momentum[0], given, atol=1e-9 * np.abs(given).max())
        self.assertLess(abs(hit.summary()["energy_drift"]), 1e-9, hit)

    GRILLAGE = {"structure_type": "network", "network_grillage": "2,2", "network_spacing": 2, "network_elements": 4,
                "filter_frequency": 300, "support_position": 0, "support_width": "inf", "initial_height": 0.05,
                "ts_type": "impact", "ts_max_time": 0.3, "output_interval": 1e-3, "output_field_interval": 0.05}

    def test_a_grillage_stands_on_the_sides_of_a_valley(self):
        # Its corners are where the valley is highest: they touch at once, the middles of its sides hang over it.
        valley = self.table("valley", lambda x, z: 0.05 * ((x - 1) ** 2 + (z - 1) ** 2 - 2))
        fallen = self.run_case({**self.GRILLAGE, "support_height_field": valley, "contact_restitution": 0})
        first = fallen.csv("impacts.csv")
        self.assertEqual(set(first["node"][:4]), {0, 1, 2, 3})
        np.testing.assert_allclose(first["time"][:4], np.sqrt(2 * 0.05 / 9.81), rtol=1e-9)
        self.assertEqual(fallen.csv("contact.csv")["masses"].max(), 4)
        _, places = masses_of(fallen)
        with h5py.File(fallen.file("results.h5"), "r") as file:
            moved, resting = file["/fields/displacement_of_masses"][()][-1], file["/fields/resting"][()][-1] != 0
        self.assertEqual(list(np.flatnonzero(resting)), [0, 1, 2, 3])
        slopes = 0.1 * (places[resting] - 1)
        over = moved[resting, 1] - slopes[:, 0] * moved[resting, 0] - slopes[:, 2] * moved[resting, 2]
        np.testing.assert_allclose(over, 0, atol=1e-12)
        impulse = first["impulse"][:4]
        np.testing.assert_allclose(impulse, impulse[0], rtol=1e-9)
        self.assertLess(abs(fallen.summary()["energy_drift"]), 1e-9, fallen)
        # A side that is higher touches first.
        tilted = self.table("tilted", lambda x, z: 0.05 * ((x - 1) ** 2 + (z - 1) ** 2 - 2) + 0.015 * (x - 1))
        early = self.run_case({**self.GRILLAGE, "support_height_field": tilted, "ts_max_time": 0.09}, name="tilted")
        impacts = early.csv("impacts.csv")
        self.assertEqual(set(impacts["node"][:2]), {1, 3})
        np.testing.assert_allclose(impacts["time"][:2], np.sqrt(2 * (0.05 - 0.015) / 9.81), rtol=1e-9)

    def glide(self, name, speed, **changes):
        """A frame that falls into a valley while it moves along x."""
        valley = self.table("along", lambda x, z: 0.1 * x**2 - 0.4, z=(-1, 1, 3))
        return self.fly(name, frame(np.eye(3)), (speed, -1, 0), support_height_field=valley, ts_type="impact",
                        contact_restitution=0, ts_max_time=0.1,
                        **{"output_field_interval": 1e-3, **changes})

    @staticmethod
    def told(run_of):
        return [text for text in run_of.summary()["warnings"] if "height field" in text]

    def test_planes_that_are_off_are_told(self):
        off = {"support_field_tolerance": 1e-4}
        far = self.glide("far", 6, **off)
        with h5py.File(far.file("results.h5"), "r") as file:
            across = file["/fields/displacement_of_masses"][()][..., 0]
            resting = file["/fields/resting"][()] != 0
        _, places = masses_of(far)
        apart = 0.1 * across**2 / np.sqrt(1 + (0.2 * places[:, 0]) ** 2)
        found = far.summary()["height_field_error"]
        self.assertGreater(found, 1e-3)
        self.assertGreater(found, (1 - 1e-9) * apart[resting].max())
        self.assertLess(found, (1 + 1e-9) * apart.max())
        (warning,) = self.told(far)
        for word in ("height field", "-support_field_tolerance", "off by more than 0.0001 m"):
            self.assertIn(word, warning)
        near = self.glide("near", 6, support_field_tolerance=2 * found)
        self.assertEqual(self.told(near), [])
        first = self.glide("first", 6, ts_max_steps=20, code=STOPPED_BY_STEPS, **off)
        self.assertGreater(first.summary()["height_field_error"], 0)
        second = self.glide("second", 6, restart_file=first.file("restart.h5"), **off)
        for key in ("height_field_error", "height_field_error_x", "height_field_error_time"):
            self.assertEqual(second.summary()[key], far.summary()[key], key)
        other = self.table("other", lambda x, z: 0.1 * x**2 - 0.5)
        failed = run({**FLIGHT, "network_file": self.scratch / "first.yaml", "support_height_field": other,
                      "contact_restitution": 0, "restart_file": first.file("restart.h5"),
                      "output_directory": self.scratch / "other"})
        self.assertIn("supports, height fields, heights", failed.errors[0])

    def test_who_leaves_the_field_is_told(self):
        flat = frame(np.eye(3), places=PLACES * (1, 0, 1))
        short = self.table("short", lambda x, z: 0.0, x=(-1, 2.2))
        left = self.fly("left", flat, (10, 0, 0), support_height_field=short, ts_type="impact", gravity=9.81,
                        contact_restitution=0)
        (warning,) = self.told(left)
        self.assertIn("(2, 0, 0) m, who has left the field, at t = 0.021 s", warning)
        self.assertIsNone(left.summary()["height_field_error"])

    def test_pictures_have_it(self):
        with h5py.File(self.glide("picture", 0.2).file("results.h5"), "r") as file:
            x, z, height = (file[f"/height_field_0_{part}"][()] for part in ("x", "z", "height"))
        np.testing.assert_allclose(height.reshape(len(z), len(x)), np.tile(0.1 * x**2 - 0.4, (len(z), 1)))

    def test_refusals(self):
        path = self.scratch / "frame.yaml"
        path.write_text(frame(np.eye(3)))
        motion = self.scratch / "motion.csv"
        motion.write_text("0,0\n1,0\n")
        ragged = self.scratch / "ragged.asc"
        ragged.write_text("ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5\n")
        case = {**FLIGHT, "network_file": path, "support_height_field": self.plane()}
        small = self.table("small", lambda x, z: -1, x=(-1, 1), z=(-1, 3))
        for words, changes in (
            (["-support_height_field", "node at (2, 0.1, 0)", "from x = -1 to 1", "-support_width"],
             {"support_height_field": small}),
            (["-support_height_field", "line 7 has 2 height(s)", "ncols = 3"], {"support_height_field": ragged}),
            (["-support_height_field", "cannot be read"], {"support_height_field": "nowhere.asc"}),
            (["-support_height_field", "3", "1"], {"support_height_field": "none,none,none"}),
            (["-support_motion", "-support_height_field"], {"support_motion": motion}),
            (["-support_normal", "-support_height_field"], {"support_normal": "1,0,0"}),
            (["-support_width", "-support_height_field"], {"support_width": 0}),
            (["-support_height_field", "overlaps"], {"support_height": 0.1}),
            (["-support_field_tolerance", "0", "> 0"], {"support_field_tolerance": 0}),
            (["-support_height_field", "-structure_type network", "-ground_profile"],
             {"structure_type": "beam", "network_file": None}),
        ):
            with self.subTest(changes=changes):
                self.refuse_case({**case, **changes}, words)


class Refusals(NetworkContactTest):
    def test_of_options(self):
        path = self.scratch / "frame.yaml"
        path.write_text(frame(np.eye(3)))
        network = {**FLIGHT, "network_file": path, "ts_max_time": 1e-3}
        beam = {"filter_frequency": 100, "support_position": 5, "ts_max_time": 1e-3}
        for words, options in (
            (["-support_normal", "0,0,0", "direction"], {**network, "support_normal": "0,0,0"}),
            (["-support_normal", "2 numbers", "three"], {**network, "support_normal": "0,1"}),
            (["-support_normal", "right angles"],
             {**network, "support_position": "0,0", "support_normal": "0,1,0,1,1,0"}),
            (["-support_width", "oblique"], {**network, "support_width": 0, "support_normal": "1,1,0"}),
            (["-support_z_position", "50", "support 0", "from 49.5 to 50.5"],
             {**network, "support_z_position": 50, "support_z_width": 1}),
            (["-support_y_position", "9", "support 0", "from 9 to 9"],
             {**network, "support_y_position": 9, "support_y_width": 0}),
            (["-support_weighting", "tributary", "inclusive"], {**network, "support_weighting": "tributary"}),
            (["-support_normal", "-structure_type network"], {**beam, "support_normal": "1,0,0"}),
            (["-support_z_*", "-structure_type network"], {**beam, "support_z_width": 1}),
            (["-initial_velocity_x", "-structure_type network"], {**beam, "initial_velocity_x": 1}),
            (["-initial_spin", "2 values"], {**network, "initial_spin": "1,2"}),
            (["-initial_spin", "1 values", "three"], {**network, "initial_spin": 1}),
            *((["-support_friction", name, "rk"], {**network, "support_friction": 0.3, "ts_type": name})
              for name in ("impact", "chebyshev", "moreau")),
            (["-support_friction", "-contact_surface line"],
             {**network, "support_friction": 0.3, "contact_surface": "line"}),
            (["overlaps"], {**network, "support_normal": "1,0,0", "support_height": 0.5}),
        ):
            with self.subTest(options=options):
                self.refuse_case(options, words)

    def test_a_node_that_is_held_in_some_directions(self):
        path = self.scratch / "frame.yaml"
        path.write_text(frame(np.eye(3)) + "groups:\n  - {name: g, junctions: [j0], held: [uz]}\n")
        failed = run({"output_directory": self.scratch / "run", **FLIGHT, "network_file": path,
                      "support_normal": "1,1,0"})
        self.assertIn("held in some directions", failed.errors[0])


if __name__ == "__main__":
    unittest.main()
