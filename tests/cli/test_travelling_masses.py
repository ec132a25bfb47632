#!/usr/bin/env python3
# size: medium
"""Masses that travel along a beam, through the program: modal equations by NumPy, files, restart, ranks."""

import unittest

import numpy as np

from common import STOPPED_BY_STEPS, UdarTest, case, datasets

LENGTH, SPEED, MASS, STIFFNESS, GRAVITY = 10.0, 20.0, 800.0, 4e5, 9.81
PER_LENGTH = 7850 * np.pi * 0.1**2
RIGIDITY = 2.1e11 * np.pi * 0.1**4 / 4
CROSSING = LENGTH / SPEED
MODES = 20


def by_modes(steps, spring):
    """Height of the mass at the ends of even steps over its way, by the first modes of a simply supported beam.

    With phi_n = sin(n pi x / L) and the mass on the beam, w(t) = sum phi_n(v t) q_n(t), the force that it gives the
    beam is -M (g + w''); on a spring k it is k (y - w) - M g, with y counted from where the weight puts it. Fourth
    order (Runge-Kutta), checked against half the steps.
    """
    n = np.arange(1, MODES + 1) * np.pi / LENGTH
    modal = PER_LENGTH * LENGTH / 2
    w2 = n**4 * RIGIDITY / PER_LENGTH

    def rate(t, state):
        q, p, y, u = state[:MODES], state[MODES:-2], state[-2], state[-1]
        phi, slope = np.sin(n * SPEED * t), n * np.cos(n * SPEED * t)
        if spring:
            force = spring * (y - phi @ q)
            return np.concatenate([p, -w2 * q + (force - MASS * GRAVITY) * phi / modal, [u, -force / MASS]])
        given = -w2 * q - MASS / modal * phi * (GRAVITY + 2 * SPEED * slope @ p - SPEED**2 * (n**2 * phi) @ q)
        return np.concatenate([p, given - phi * (phi @ given) / (modal / MASS + phi @ phi), [0, 0]])

    state, step, heights = np.zeros(2 * MODES + 2), CROSSING / steps, [0.0]
    for i in range(steps):
        t = i * step
        a = rate(t, state)
        b = rate(t + step / 2, state + step / 2 * a)
        c = rate(t + step / 2, state + step / 2 * b)
        d = rate(t + step, state + step * c)
        state = state + step / 6 * (a + 2 * b + 2 * c + d)
        heights.append(state[-2] if spring else np.sin(n * SPEED * (t + step)) @ state[:MODES])
    return np.array(heights)


class TravellingMasses(UdarTest):
    def axles(self, rows, name="axles.csv"):
        path = self.scratch / name
        path.write_text("".join(",".join(map(str, row)) + "\n" for row in rows))
        return path

    def crossing(self, name, rows, ranks=0, code=0, **changes):
        given = {"support_position": None, "initial_height": 0, "gravity": GRAVITY, "beam_left_end": "pinned",
                 "beam_right_end": "pinned", "beam_elements": 40, "filter_frequency": 800, "gauge_position": 5,
                 "load_axles": self.axles(rows, f"{name}.csv"), "load_axles_speed": SPEED, "ts_max_time": CROSSING,
                 "output_interval": CROSSING / 50}
        return self.run_case(case(**{**given, **changes}), ranks, name=name, code=code)

    def test_modal_equations(self):
        """A mass alone and one on a spring; the beam's own weight is left out by a force that holds it."""
        lift = self.axles([[0, PER_LENGTH * LENGTH * GRAVITY]], "lift.csv")
        for spring, most in ((0, 4e-3), (STIFFNESS, 3e-3)):
            expected, finer = by_modes(4000, spring)[::80], by_modes(8000, spring)[::160]
            sag = np.abs(expected).max()
            self.assertLess(np.abs(expected - finer).max() / sag, 1e-6)
            off = []
            for wf in (400, 800):
                run = self.crossing(f"run-{spring}-{wf}", [[0, 0, MASS, spring]], beam_elements=80,
                                    filter_frequency=wf, load_position=5, load_width="inf", load_table=lift)
                axle = run.csv("axles.csv")
                np.testing.assert_allclose(axle["x_0"], SPEED * axle["time"], rtol=0, atol=1e-12)
                # Near the far end a mass swings ever faster on the line: there the order is lower.
                off.append(np.abs(axle["position_0"] - expected)[:41].max() / sag)
                self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-8)
            self.assertLess(off[1], most / 4)
            self.assertGreater(off[0] / off[1], 3.0)  # second order in 1 / wf

    def test_of_none_is_a_force_to_the_bit(self):
        plain = self.crossing("plain", [[0, -8000], [2, -3000]])
        none = self.crossing("none", [[0, -8000, 0, 0], [2, -3000, 0, 1e5]])
        for name in ("gauges.csv", "energy.csv"):
            self.assertEqual(none.file(name).read_bytes(), plain.file(name).read_bytes())
        self.assertFalse(none.file("axles.csv").exists())
        self.assertIn('"integrator": "chebyshev"', none.file("summary.json").read_text())

    def test_files_and_roads(self):
        """Two of three axles have a mass; they come from a road and go onto one, to the left."""
        rows = [[0, 0, MASS, STIFFNESS], [1.5, -2000, 0, 0], [3, 0, MASS, 0]]
        run = self.crossing("run", rows, load_axles_speed=-SPEED, load_axles_start=0.05, ts_max_time=0.8,
                            beam_left_end="spring", beam_left_spring=1e6, ts_rtol=1e-10)
        axle = run.csv("axles.csv")
        time, there = axle["time"], axle["time"] < 0.05 + 1.5 / SPEED
        np.testing.assert_allclose(axle["x_0"], LENGTH - SPEED * (time - 0.05), rtol=0, atol=1e-12)
        np.testing.assert_allclose(axle["x_1"], axle["x_0"] + 3, rtol=0, atol=1e-12)
        np.testing.assert_allclose(axle["position_1"][there], 0, rtol=0, atol=1e-15)
        np.testing.assert_allclose(axle["force_1"][there], -MASS * GRAVITY, rtol=1e-12)
        for k in (0, 1):
            on = (axle[f"x_{k}"] > -1e-9) & (axle[f"x_{k}"] < LENGTH + 1e-9)  # rows at an end are as before it
            self.assertLess(axle[f"line_{k}"][on].min(), -5e-3)
            np.testing.assert_allclose(axle[f"line_{k}"][~on], 0, rtol=0, atol=1e-12)
        self.assertLess(np.abs(run.csv("energy.csv")["drift"]).max(), 1e-8)  # found 12 times the tolerance

    def test_ranks_and_restart(self):
        rows = [[0, 0, MASS, STIFFNESS], [2, 0, MASS, 0]]
        short = {"beam_elements": 20, "filter_frequency": 200, "ts_max_time": 0.2, "load_axles_start": -0.05}
        whole = self.crossing("whole", rows, **short)
        two = self.crossing("two", rows, ranks=2, **short)
        for table, name in (("axles.csv", "position_0"), ("axles.csv", "position_1"), ("gauges.csv", "line_0")):
            np.testing.assert_allclose(two.csv(table)[name], whole.csv(table)[name], rtol=0, atol=1e-9)
        first = self.crossing("first", rows, code=STOPPED_BY_STEPS, ts_max_steps=100, **short)
        second = self.crossing("second", rows, restart_file=first.file("restart.h5"), **short)
        for name in ("axles.csv", "gauges.csv", "energy.csv"):
            all_rows, tail = (run.file(name).read_text().splitlines() for run in (whole, second))
            self.assertGreater(len(tail), 10)
            self.assertLess(len(tail), len(all_rows) - 5)
            self.assertEqual(tail[1:], all_rows[len(all_rows) - len(tail) + 1:], name)
        found, expected = (datasets(run.file("restart.h5"))["node_fields/mass_position"] for run in (second, whole))
        self.assertEqual(len(expected), 23)
        np.testing.assert_array_equal(found, expected)

    def test_warns_of_long_elements(self):
        run = self.crossing("run", [[0, 0, MASS]], ts_max_time=0.01)
        self.assertIn("elements of 0.25 m are longer than the 0.157 m", run.err)
        self.assertNotIn("are longer", self.crossing("force", [[0, -1]], ts_max_time=0.01).err)

    def test_refuses_another_mass_at_a_restart(self):
        self.crossing("run", [[0, 0, MASS]], ts_max_time=0.01)
        options = {"support_position": None, "initial_height": 0, "beam_left_end": "pinned", "beam_right_end": "pinned",
                   "beam_elements": 40, "filter_frequency": 800, "load_axles": self.axles([[0, 0, 900]]),
                   "load_axles_speed": SPEED, "restart_file": self.scratch / "run" / "restart.h5",
                   "output_directory": self.scratch / "rest"}
        self.refuse_case(case(**options), ["axles, masses [kg]: 1 800 there, 1 900 here"])


if __name__ == "__main__":
    unittest.main()
