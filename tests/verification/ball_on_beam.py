#!/usr/bin/python3
"""Timoshenko's ball on a simply supported beam, by an integral equation that shares nothing with udar.

usage: ball_on_beam.py > tests/verification/data/ball_on_beam.csv

S. Timoshenko, "Zur Frage nach der Wirkung eines Stosses auf einen Balken", Zeitschrift fuer Mathematik und Physik 62
(1913): a steel ball of 2 cm radius hits a steel bar of 1 cm x 1 cm x 30.7 cm in the middle with 1 cm/s, several times.
The approach of ball and beam is that of the ball, v t - 1/M int int F, less the deflection of the beam, a sum over its
modes of Duhamel's integrals, and F = k approach^1.5 by Hertz. Between steps F is linear, modes and ball are exact, and
each step solves for the F at its end by Newton.

Columns: time [s], force [N], impulse [N s], velocity of the ball towards the beam [m/s].
"""

import sys

import numpy as np

MODULUS, POISSON, DENSITY = 2.1e11, 0.3, 7850.0  # [Pa], [-], [kg/m^3]
RADIUS, SPEED = 0.02, 0.01  # [m], [m/s]
WIDTH, LENGTH = 0.01, 0.307  # [m]
BALL = DENSITY * 4 / 3 * np.pi * RADIUS**3  # [kg]
HERTZ = 4 / 3 * MODULUS / (2 * (1 - POISSON**2)) * np.sqrt(RADIUS)  # [N/m^1.5]
END, ROWS = 5e-3, 250  # [s]


def history(modes=150, steps_a_row=2000):
    """Force, impulse and velocity at the ends of all rows."""
    step = END / (ROWS * steps_a_row)
    odd = 2 * np.arange(modes) + 1
    mass = DENSITY * WIDTH**2 * LENGTH / 2  # of each mode, of unit size in the middle
    w = (odd * np.pi / LENGTH) ** 2 * np.sqrt(MODULUS * WIDTH**4 / 12 / (DENSITY * WIDTH**2))
    c, s = np.cos(w * step), np.sin(w * step)
    # q'' + w^2 q = (f0 + (f1 - f0) t / h) / m: what f0 and f1 add to q and q' at the end of a step.
    ramp = np.array([(step - s / w) / (w**2 * step), (1 - c) / (w**2 * step)]) / mass  # of (f1 - f0)
    level = np.array([(1 - c) / w**2, s / w]) / mass  # of f0
    to_end = ramp[0].sum()
    q, rate = np.zeros(modes), np.zeros(modes)
    place, velocity, force, impulse = 0.0, SPEED, 0.0, 0.0
    rows = []
    for k in range(1, ROWS * steps_a_row + 1):
        q_free = c * q + s / w * rate + (level[0] - ramp[0]) * force
        rate_free = c * rate - w * s * q + (level[1] - ramp[1]) * force
        place_free = place + step * velocity - step**2 / 3 * force / BALL
        approach_free = place_free - q_free.sum()
        give = to_end + step**2 / 6 / BALL  # of the approach, for each newton at the end
        new = 0.0
        if approach_free > 0.0:
            new = force
            for _ in range(50):
                approach = max(approach_free - give * new, 0.0)
                wrong = new - HERTZ * approach**1.5
                change = wrong / (1 + 1.5 * HERTZ * np.sqrt(approach) * give)
                new -= change
                if abs(change) < 1e-13:
                    break
        q, rate = q_free + ramp[0] * new, rate_free + ramp[1] * new
        place = place_free - step**2 / 6 * new / BALL
        velocity -= step * (force + new) / 2 / BALL
        impulse += step * (force + new) / 2
        force = new
        if k % steps_a_row == 0:
            rows.append([k * step, force, impulse, velocity])
    return np.array(rows)


def main():
    rows = history()
    coarse = history(modes=75, steps_a_row=1000)
    print("time,force,impulse,velocity")
    for row in rows:
        print(",".join(f"{value:.9g}" for value in row))
    print(f"half the modes and steps: {np.abs(rows - coarse)[:, 1].max() / rows[:, 1].max():.2e} of the largest force",
          file=sys.stderr)


if __name__ == "__main__":
    main()
