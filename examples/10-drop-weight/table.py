#!/usr/bin/env python3
"""What the load cell shows in runs of this case, beside the closed form of the supported bar.

usage: table.py RUN...   (folders of results)

While weight and bar touch they are linear: with the receptance of a simply supported bar in its middle,
G(w) = L^3 / (4 E I b^3) (tan(b / 2) - tanh(b / 2)), b = L (rho A w^2 / E I)^(1/4), the force is
F(t) = v sum_n sin(w_n t) / (w_n^3 D'(w_n^2)) at the zeros w_n of D = 1 / K - 1 / (M w^2) + G(w).
"""

import csv
import json
import pathlib
import sys

import numpy as np

LENGTH, WIDTH, MODULUS, DENSITY = 0.6, 0.04, 2.1e11, 7850.0
MASS, SPEED, CELL = 100.0, 0.5, 2e8  # [kg], [m/s], [N/m]
BENDING = MODULUS * WIDTH**4 / 12  # [N m^2]
LINE = DENSITY * WIDTH**2  # [kg/m]


def receptance(w):
    b = LENGTH * (LINE * w**2 / BENDING) ** 0.25
    return LENGTH**3 / (4 * BENDING * b**3) * (np.tan(b / 2) - np.tanh(b / 2))


def characteristic(w):
    return 1 / CELL - 1 / (MASS * w**2) + receptance(w)


def frequencies(modes):
    """Zeros of D, one between each two poles of G, by bisection [rad/s]."""
    unit = np.sqrt(BENDING / LINE) / LENGTH**2
    poles = unit * (np.pi * (2 * np.arange(modes) + 1)) ** 2  # of the bar alone, symmetric modes
    low, high = np.concatenate([[1e-3 * poles[0]], poles[:-1]]), poles.copy()
    low, high = low * (1 + 1e-12), high * (1 - 1e-12)
    for _ in range(200):
        middle = 0.5 * (low + high)
        below = characteristic(middle) < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)


def closed_form(time, modes=400):
    w = frequencies(modes)
    step = 1e-6 * w
    slope = (characteristic(w + step) - characteristic(w - step)) / ((w + step) ** 2 - (w - step) ** 2)
    return SPEED * (np.sin(np.outer(time, w)) / (w**3 * slope)).sum(axis=1)


def told(name, time, force):
    """Largest force [kN] and when [ms], end of the first contact [ms], impulse up to there [N s]."""
    end = np.flatnonzero(force[1:] <= 0)[0] + 1
    peak = force[:end].argmax()
    step = time[1] - time[0]
    impulse = force[:end].sum() * step
    return f"| {name} | {force[peak] / 1e3:.2f} | {1e3 * time[peak]:.2f} | {1e3 * time[end]:.2f} | {impulse:.3f} |"


def main():
    fine = (np.arange(140000) + 0.5) * 1e-7
    exact = closed_form(fine)
    exact[np.flatnonzero(exact < 0)[0]:] = 0  # they part, and what follows is another problem
    rows = exact.reshape(-1, 200).mean(axis=1)  # means over rows of 20 us
    time = 2e-5 * (np.arange(len(rows)) + 1)
    print("| | largest force [kN] | at [ms] | contact ends [ms] | impulse [N s] | off [%] | line solves |")
    print("|---|---|---|---|---|---|---|")
    print(told("closed form", time, rows), " |  |")
    for run in map(pathlib.Path, sys.argv[1:]):
        with open(run / "contact.csv", encoding="ascii") as file:
            table = list(csv.DictReader(file))
        last = max(int(name[6:]) for name in table[0] if name.startswith("force_"))  # the striker
        force = np.diff([float(row[f"impulse_{last}"]) for row in table]) / 2e-5
        summary = json.loads((run / "summary.json").read_text())
        print(told(run.name, time[: len(force)], force), end="")
        end = np.flatnonzero(rows <= 0)[0]
        off = np.abs(force[:end] - rows[:end]).max() / rows.max()
        print(f" {100 * off:.2f} | {summary['stepping_line_solves']} |")


if __name__ == "__main__":
    main()
