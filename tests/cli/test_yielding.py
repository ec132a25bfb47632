#!/usr/bin/env python3
# ranks: 1 2; size: medium
"""A beam that yields, through the program: closed cases, an independent exact solution, restart, what files say."""

import os
import unittest

import numpy as np

from common import STOPPED_BY_STEPS, UdarTest, case, datasets

RANKS = int(os.environ.get("UDAR_RANKS", "1"))
LENGTH, ELEMENTS, MASS = 2.0, 20, 30.0  # [m], -, [kg/m]
STIFFNESS, YIELD = 2e6, 4e3             # EI [N m^2], [N m]

CANTILEVER = {
    "beam_length": LENGTH, "beam_elements": ELEMENTS, "beam_radius": None, "beam_section": "direct", "beam_area": 1,
    "beam_inertia": 1, "beam_young_modulus": None, "beam_density": None, "beam_bending_stiffness": STIFFNESS,
    "beam_mass_per_length": MASS, "beam_left_end": "clamped", "support_position": None, "initial_height": 0,
    "gravity": 0, "gauge_position": f"0,{LENGTH}", "beam_yield_moment": YIELD,
}
UNFILTERED = {"filter_frequency": "none", "ts_type": "moreau"}
ROOT = {"beam_hinge_position": 0}
# A cantilever that turns about its root, in place of a fall.
SWING = {
    "filter_frequency": 2e3, "beam_left_end": "clamped", "support_position": None, "initial_height": 0, "gravity": 0,
    "initial_velocity": None, "ts_type": "chebyshev", "initial_slope": 0, "beam_hinge_position": "0,0.5",
    "beam_yield_hardening": None, "beam_yield_moment": YIELD, "beam_bending_stiffness": STIFFNESS,
    "support_stiffness": None, "ts_dt": None, "ts_max_time": 0.1, "restart_interval": None, "output_interval": 2e-3,
}


def nodes(elements=ELEMENTS):
    """Places and lumped masses."""
    mass = np.full(elements + 1, MASS * LENGTH / elements)
    mass[[0, -1]] *= 0.5
    return np.linspace(0, LENGTH, elements + 1), mass


class OneHinge:
    """The filtered cantilever with a hinge at its root, event by event, by eigenvectors of dense matrices."""

    def __init__(self, elements, filter_frequency, hardening):
        place, mass = nodes(elements)
        h = place[1]
        # Rows of T and S for the moments at 0 ... n - 1, columns of T for the displacements of 1 ... n.
        bend = np.zeros((elements, elements + 1))
        for i in range(elements):
            bend[i, i + 1] += 1 / h
            bend[i, i] -= 1 / h
            if i > 0:
                bend[i, i] -= 1 / h
                bend[i, i - 1] += 1 / h
        bend = bend[:, 1:]
        give = np.diag([2.0] + [4.0] * (elements - 1)) + np.eye(elements, k=1) + np.eye(elements, k=-1)
        give *= h / (6 * STIFFNESS)
        self.mass = mass[1:]
        self.springs = filter_frequency**2 * self.mass
        line = np.linalg.inv(np.diag(self.springs) + bend.T @ np.linalg.solve(give, bend))
        kink = np.linalg.solve(give, np.eye(elements)[0])
        self.response = line @ bend.T @ kink               # of the line to a unit rotation
        self.moment = np.linalg.solve(give, bend @ line)[0] * self.springs
        self.released = kink[0] - kink @ bend @ self.response + hardening
        elastic = np.diag(self.springs) - self.springs[:, None] * line * self.springs
        # theta = (moment y - s M) / released takes energy out of the stiffness.
        yielding = elastic - np.outer(self.moment, self.moment) / self.released
        self.modes = [self.decomposed(stiffness) for stiffness in (elastic, yielding)]

    def decomposed(self, stiffness):
        root = np.sqrt(self.mass)
        values, vectors = np.linalg.eigh(stiffness / np.outer(root, root))
        values[values < 1e-12 * values.max()] = 0  # turning about a perfectly plastic hinge
        return np.sqrt(values), vectors / root[:, None], vectors * root[:, None]

    def motion(self, side, pull, y, v):
        """y and v after a time, under forces that stay."""
        frequency, shapes, weights = self.modes[side != 0]
        swings = frequency > 0
        w = np.where(swings, frequency, 1.0)
        a, b, force = weights.T @ y, weights.T @ v, shapes.T @ pull

        def at(time):
            c, s = np.cos(w * time), np.sin(w * time) / w
            place = np.where(swings, a * c + b * s + force * (1 - c) / w**2, a + b * time + 0.5 * force * time**2)
            return shapes @ place, shapes @ np.where(swings, b * c + (force - a * w**2) * s, b + force * time)

        return at

    def run(self, velocity, end):
        """@return displacements and rotation at the end, and how often the hinge began or ceased to turn"""
        y, v, theta, side, time, events = np.zeros_like(velocity), velocity, 0.0, 0, 0.0, 0
        step = 0.02 / self.modes[0][0].max()
        while time < end:
            # Of a rotation that stays, and of one that follows.
            pull = self.moment * (theta if side == 0 else -side * YIELD / self.released)
            at = self.motion(side, pull, y, v)

            def left(elapsed):
                """Falls through zero at an event."""
                y, v = at(elapsed)
                if side == 0:
                    return YIELD - abs(self.moment @ y - self.released * theta)
                return side * self.moment @ v

            # Past the event that began this state.
            low = 1e-3 * step if events else 0.0
            while low < end - time and left(low + step) > 0:
                low += step
            high = min(low + step, end - time)
            if left(high) <= 0:
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    low, high = (middle, high) if left(middle) > 0 else (low, middle)
            y, v = at(high)
            time += high
            if side != 0:
                theta = (self.moment @ y - side * YIELD) / self.released
            if time < end:
                side = int(np.sign(self.moment @ y - self.released * theta)) if side == 0 else 0
                events += 1
        return y, theta, events


class Yielding(UdarTest):
    def cantilever(self, name, ranks=RANKS, code=0, **changes):
        return self.run_case(case(**{**CANTILEVER, **changes}), ranks, name=name, code=code)

    def start(self, velocity, name):
        """A file of velocities at the nodes."""
        path = self.scratch / f"{name}.csv"
        places = nodes(len(velocity) - 1)[0].tolist()
        path.write_text("".join(f"{x!r},0,{v!r}\n" for x, v in zip(places, velocity.tolist())))
        return path

    def balanced(self, result, tolerance=1e-9):
        energy = result.csv("energy.csv")
        self.assertLess(np.abs(energy["drift"]).max(), tolerance, f"energy balance{result}")
        self.assertGreaterEqual(np.diff(energy["lost_in_hinges"]).min(), -1e-12 * energy["lost_in_hinges"].max())
        return energy

    @unittest.skipIf(RANKS > 1, "once")
    def test_one_hinge_is_exact(self):
        """Rotations to and fro, perfectly plastic and hardening, against an independent solution."""
        for hardening in (0.0, 2e5):
            for elements, wf in ((3, 800), (8, 3000)):
                with self.subTest(hardening=hardening, elements=elements):
                    place = nodes(elements)[0]
                    velocity = 3 * place + 8 * np.sin(3 * place)
                    y, theta, events = OneHinge(elements, wf, hardening).run(velocity[1:], 0.1)
                    name = f"exact{elements}{hardening}"
                    result = self.cantilever(
                        name, beam_elements=elements, filter_frequency=wf, initial_shape=self.start(velocity, name),
                        beam_hinge_hardening=hardening, ts_max_time=0.1, ts_type="chebyshev", **ROOT)
                    self.balanced(result)
                    self.assertGreaterEqual(events, 6)
                    gauges = result.csv("gauges.csv")
                    self.assertAlmostEqual(gauges["plastic_rotation_0"][-1], theta, delta=1e-10)
                    self.assertAlmostEqual(gauges["mass_1"][-1], y[-1], delta=1e-10)

    @unittest.skipIf(RANKS > 1, "once")
    def test_a_force_that_jumps_turns_a_hinge_at_once(self):
        """The massless line follows it before any mass moves: from the start, and on the way."""
        elements, wf, force = 8, 50, 5e3  # so soft a filter that the line alone carries the force
        one = OneHinge(elements, wf, 0.0)
        turned = (one.response[-1] * force - YIELD) / one.released
        self.assertGreater(turned, 1e-3)
        load = self.scratch / "jump.csv"
        for begin in (0.0, 0.01):
            with self.subTest(begin=begin):
                before = f"0,0\n{begin},0\n" if begin else ""
                load.write_text(f"{before}{begin},{force}\n1,{force}\n")
                result = self.cantilever(
                    f"jump{begin}", beam_elements=elements, filter_frequency=wf, load_position=LENGTH, load_table=load,
                    output_interval=0.01, ts_max_time=begin + 1e-7, gauge_position=0, **ROOT)
                energy = self.balanced(result)
                found = result.csv("gauges.csv")["plastic_rotation_0"]
                self.assertAlmostEqual(found[-1] / turned, 1, delta=1e-6)
                # What it takes before the first row is part of the start.
                self.assertAlmostEqual(energy["lost_in_hinges"][-1] / (YIELD * turned), 1 if begin else 0, delta=1e-6)

    def swing(self, name, stiffness, **changes):
        """A cantilever that turns about its root, where alone it yields. @return how far it turns, over that of a rigid
        one"""
        place, mass = nodes()
        speed = 8.0  # [rad/s]
        result = self.cantilever(name, beam_bending_stiffness=stiffness, initial_shape=self.start(speed * place, name),
                                 ts_max_time=0.3, **ROOT, **changes)
        energy = self.balanced(result)
        turned = result.csv("gauges.csv")["plastic_rotation_0"][-1]
        # Forth, and where it rings back a little.
        self.assertTrue(1 - 1e-9 < energy["lost_in_hinges"][-1] / (YIELD * turned) < 1.001)
        return turned / (0.5 * np.sum(mass * place**2) * speed**2 / YIELD)

    @unittest.skipIf(RANKS > 1, "once")
    def test_a_hinge_of_a_stiff_beam_turns_as_that_of_a_rigid_one(self):
        for kind, changes in (("exact", {"filter_frequency": 4e3}), ("steps", {**UNFILTERED, "ts_dt": 5e-5})):
            with self.subTest(kind=kind):
                off = [1 - self.swing(f"{kind}{stiffness}", stiffness, **changes) for stiffness in (2e6, 2e7)]
                self.assertLess(abs(off[0]), 2e-3)
                self.assertLess(abs(off[1]), 0.2 * abs(off[0]), "towards the rigid one as the stiffness grows")


    @unittest.skipIf(RANKS > 1, "once")
    def test_a_struck_tip_bends_the_beam_as_parkes_has_it(self):
        """A mass at the tip of a cantilever that yields everywhere is struck: rigid, perfectly plastic theory; towards
        it as the mesh is refined and as the stiffness grows."""
        tip, speed = 30.0, 10.0  # [kg], [m/s]
        along = np.linspace(0, LENGTH, 20001)
        slower = speed / (1 + MASS * along / (2 * tip))
        times = MASS * along**2 * slower / (6 * YIELD)
        travelling = np.sum(0.5 * (slower[1:] + slower[:-1]) * np.diff(times))
        turning = LENGTH * 0.5 * (tip + MASS * LENGTH / 3) * slower[-1] ** 2 / YIELD
        off = {}
        for elements, stiffness in ((10, 2e7), (20, 2e6), (20, 2e7), (40, 2e7)):
            name = f"tip{elements}-{stiffness:g}"
            place, mass = nodes(elements)
            velocity = np.where(place == LENGTH, speed, 0.0)
            result = self.cantilever(
                name, beam_elements=elements, beam_bending_stiffness=stiffness, beam_point_mass_position=LENGTH,
                beam_point_mass=tip - mass[-1], initial_shape=self.start(velocity, name), ts_dt=1e-4, ts_max_time=0.25,
                output_field_interval=0.25, **UNFILTERED)
            energy = self.balanced(result)
            self.assertGreater(energy["lost_in_hinges"][-1], 0.99 * 0.5 * tip * speed**2)
            rotation = datasets(result.file("results.h5"))["fields/plastic_rotation"][-1]
            off[elements, stiffness] = np.sum(rotation * (LENGTH - place)) / (travelling + turning) - 1
        self.assertLess(off[40, 2e7], 0.04)
        self.assertLess(off[40, 2e7], 0.75 * off[20, 2e7], f"towards the rigid beam as the mesh is refined: {off}")
        self.assertLess(off[20, 2e7], 0.75 * off[10, 2e7], f"{off}")
        self.assertLess(off[20, 2e7], 0.6 * off[20, 2e6], f"and as the stiffness grows: {off}")

    @unittest.skipIf(RANKS > 1, "once")
    def test_slow_cycles_lose_what_the_law_says(self):
        """A hardening hinge under a slow force at the tip: residual rotation, and the loop's area for each cycle."""
        hardening, largest, quarter = 2e5, 1.5 * YIELD, 1.0
        load = self.scratch / "load.csv"
        times = np.linspace(0, 8 * quarter, 401)
        force = largest / LENGTH * np.sin(0.5 * np.pi * times / quarter)
        load.write_text("".join(f"{time!r},{value!r}\n" for time, value in zip(times.tolist(), force.tolist())))
        turned = (largest - YIELD) / hardening
        # Inertia adds the square of the force's frequency over that of the cantilever on its hinge of stiffness H.
        inertia = (0.5 * np.pi / quarter) ** 2 / (hardening / (MASS * LENGTH**3 / 3))
        self.assertLess(inertia, 2e-3)
        for kind, changes in (("exact", {"filter_frequency": 1e3}), ("steps", {**UNFILTERED, "ts_dt": 1e-3})):
            with self.subTest(kind=kind):
                result = self.cantilever(
                    f"cycle{kind}", load_position=LENGTH, load_table=load, beam_hinge_hardening=hardening,
                    gauge_position=0, ts_max_time=8 * quarter, output_interval=quarter, beam_elements=4, **ROOT,
                    **changes)
                energy = self.balanced(result)
                found = result.csv("gauges.csv")["plastic_rotation_0"]
                np.testing.assert_allclose(found[[2, 4, 6, 8]], np.array([1, -1, 1, -1]) * turned, rtol=20 * inertia)
                lost = energy["lost_in_hinges"][[2, 4, 6, 8]]
                np.testing.assert_allclose(lost, YIELD * turned * np.array([1, 3, 5, 7]), rtol=20 * inertia)

    @unittest.skipIf(RANKS > 1, "once")
    def test_below_its_yield_moment_a_beam_is_elastic_to_the_bit(self):
        struck = {"beam_left_end": None, "support_position": "0.5,1.5", "initial_height": 0.1, "gravity": 9.81,
                  "initial_slope": 0.01, "ts_max_time": 0.4}
        for kind, changes in (
            ("exact", {"ts_type": "chebyshev", "filter_frequency": 800, "beam_hinge_position": "0.7,1.2"}),
            ("steps", {**UNFILTERED, "ts_dt": 2e-4}),
            ("free", {**UNFILTERED, "ts_dt": 2e-4, "gravity": 0, "initial_velocity": -1,
                      "initial_angular_velocity": 5}),
        ):
            with self.subTest(kind=kind):
                runs = [
                    self.cantilever(f"{kind}{moment}", **{
                        **struck, **changes, "beam_yield_moment": moment,
                        "beam_hinge_position": changes.get("beam_hinge_position") if moment else None})
                    for moment in (None, 1e9)]
                for file, columns in (("gauges.csv", ("mass_0", "velocity_1", "line_1")),
                                      ("energy.csv", ("kinetic", "line_strain", "total", "lost_in_impacts"))):
                    elastic, yielding = (run.csv(file) for run in runs)
                    for column in columns:
                        np.testing.assert_array_equal(yielding[column], elastic[column], err_msg=f"{file} {column}")
                self.assertEqual(runs[0].file("contact.csv").read_text(), runs[1].file("contact.csv").read_text())

    def fall(self, name, **changes):
        """A beam that falls on supports and yields there."""
        return self.cantilever(name, **{
            "beam_left_end": None, "support_position": "0.5,1.5", "support_stiffness": 3e5, "initial_height": 0.05,
            "initial_velocity": -3, "gravity": 9.81, "initial_slope": 0.02, "ts_max_time": 0.08,
            "output_interval": 4e-3, "restart_interval": 0.02,
            "beam_bending_stiffness": 2e5, "beam_yield_hardening": 0.05, "beam_yield_moment": 300, **UNFILTERED,
            "ts_dt": 2e-4, **changes})

    @unittest.skipIf(RANKS > 1, "once")
    def test_a_falling_beam_yields_on_its_supports(self):
        """Contact and hinges in one problem, at every node: the energy lost converges as the mesh is refined."""
        lost = []
        for elements in (20, 40, 80):
            result = self.fall(f"fall{elements}", beam_elements=elements)
            energy = self.balanced(result, 1e-4)  # steps in which springs are met miss part of what they hold
            lost.append(energy["lost_in_hinges"][-1])
            self.assertGreater(result.summary()["plastic_rotation"], 0.01 / elements)
        change = np.abs(np.diff(lost))
        self.assertLess(change[0], 0.05 * lost[-1], f"{lost}")
        self.assertLess(change[1], 0.6 * change[0], f"{lost}")

    @unittest.skipIf(RANKS > 1, "once")
    def test_steps_are_of_first_order(self):
        """One hinge that turns, stands and turns back."""
        place = nodes(4)[0]
        start = self.start(3 * place + 2 * np.sin(3 * place), "order")
        ends = [self.cantilever(f"order{parts}", beam_elements=4, initial_shape=start, ts_max_time=0.04,
                                output_interval=0.04, ts_dt=2e-4 / parts, **ROOT, **UNFILTERED).csv("gauges.csv")
                for parts in (1, 2, 4, 32)]
        for column in ("plastic_rotation_0", "mass_1"):
            off = [abs(end[column][-1] - ends[-1][column][-1]) for end in ends[:-1]]
            self.assertTrue(off[1] < 0.6 * off[0] and off[2] < 0.6 * off[1], f"{column}: {off}")

    def test_a_dropped_mass_bends_a_beam_for_good(self):
        """Moments stay within the bound at every instant, and the mass leaves with what the hinges have not taken."""
        drop = {"beam_left_end": "pinned", "beam_right_end": "pinned", "filter_frequency": 2e3, "gravity": 9.81,
                "gauge_position": LENGTH / 2, "striker_position": LENGTH / 2, "striker_mass": 200, "striker_gap": 0.3,
                "striker_restitution": 0, "ts_max_time": 0.4, "output_interval": 1e-3}
        leaves = []
        for moment, places in ((None, None), (YIELD, "0.9,1,1.1")):
            result = self.cantilever(f"drop{moment}", beam_yield_moment=moment, beam_hinge_position=places, **drop)
            energy = self.balanced(result)
            leaves.append(result.csv("strikers.csv")["velocity_0"].max())
        self.assertGreater(energy["lost_in_hinges"][-1], 100)
        moment = datasets(result.file("results.h5"))["envelope/moment_max"]
        self.assertAlmostEqual(moment[9:12].max() / YIELD, 1, delta=1e-9)
        self.assertLess(leaves[1], 0.8 * leaves[0])

    def same(self, runs, tolerance):
        for file in ("gauges.csv", "energy.csv"):
            first, second = (run.csv(file) for run in runs)
            for column in first:
                if column not in ("drift", "line_strain"):
                    np.testing.assert_allclose(second[column], first[column], rtol=0, err_msg=f"{file} {column}",
                                               atol=tolerance * max(1e-3, np.abs(first[column]).max()))

    @unittest.skipIf(RANKS == 1, "needs ranks")
    def test_ranks_agree(self):
        swing = {"initial_shape": self.start(8.0 * nodes()[0], "swing"), **SWING}
        for name, changes in (("steps", {}), ("exact", swing)):
            with self.subTest(name=name):
                self.same([self.fall(f"{name}{ranks}", ranks=ranks, **changes) for ranks in (1, RANKS)], 1e-9)

    def test_a_restart_goes_on_to_the_bit(self):
        """Stopped while hinges yield."""
        swing = {"initial_shape": self.start(8.0 * nodes()[0], "swing"), **SWING}
        for name, steps, changes in (("steps", 250, {}), ("exact", 8, swing)):
            with self.subTest(name=name):
                whole = self.fall(f"{name}whole", **changes)
                first = self.fall(f"{name}first", ts_max_steps=steps, code=STOPPED_BY_STEPS, **changes)
                second = self.fall(f"{name}second", restart_file=first.file("restart.h5"), **changes)
                for file in ("gauges.csv", "energy.csv"):
                    rows, head, tail = (run.file(file).read_text().splitlines() for run in (whole, first, second))
                    self.assertEqual(tail[1:], rows[len(rows) - len(tail) + 1:], f"{file} after the restart")
                    self.assertTrue(2 < len(head) < len(rows) - 2, "stopped on the way")
                if name == "exact":
                    lost = whole.csv("energy.csv")["lost_in_hinges"]
                    at = len(first.file("energy.csv").read_text().splitlines()) - 2
                    self.assertGreater(lost[at + 1], lost[at], "a hinge turned there")


if __name__ == "__main__":
    unittest.main()
