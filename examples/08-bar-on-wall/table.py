#!/usr/bin/env python3
"""Prints the table "numbers to expect" of README.md from runs of this example: table.py RUN...

The order is, with wf, that of what the bar is too slow by, from the row before; with N, that of the changes of its
speed, from the two before.
"""
import json
import math
import pathlib
import sys

import h5py
import numpy as np

LENGTH, RADIUS, YOUNG, DENSITY, SPEED = 10.0, 0.05, 2.1e11, 7850.0, 1.0  # of case.yaml
WAVE = math.sqrt(YOUNG / DENSITY)  # [m/s]
AREA = math.pi * RADIUS**2
FORCE = DENSITY * WAVE * AREA * SPEED  # [N]
CONTACT = 2 * LENGTH / WAVE  # [s]


def wall(time, frequency, elements):
    """Force [N] and impulse [N s] of the wall on the filtered bar, in contact since t = 0 (README)."""
    step = LENGTH / elements
    number = (2 * np.arange(1, elements + 1) - 1) * math.pi / (2 * LENGTH)
    plain = 2 * WAVE / step * np.sin(0.5 * number * step)
    slow = plain / np.sqrt(1 + (plain / frequency) ** 2)
    share = 2 * YOUNG * AREA / LENGTH * np.cos(0.5 * number * step) ** 2 / plain**2
    # The half mass at the wall has nothing but its filter spring.
    slow, share = np.append(slow, frequency), np.append(share, 0.5 * DENSITY * AREA * step)
    time = np.asarray(time, dtype=float)
    angle = np.multiply.outer(time, slow)
    return SPEED * np.sin(angle) @ (share * slow), SPEED * (1 - np.cos(angle)) @ share


def closed_form(frequency, elements):
    """When the wall's force first is zero [s], and the speed at which the bar is then on its way back [m/s]."""
    times = np.arange(1, math.ceil(2 * CONTACT * frequency * 8)) / (8 * frequency)
    after = int(np.argmax(wall(times, frequency, elements)[0] < 0))
    low, high = times[after - 1], times[after]
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if wall(middle, frequency, elements)[0] > 0 else (low, middle)
    return low, wall(low, frequency, elements)[1] / (DENSITY * AREA * LENGTH) - SPEED


def measured(folder):
    """What a run says of itself, by name."""
    folder = pathlib.Path(folder)
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    with h5py.File(folder / "results.h5") as file:
        frequency, elements = float(file.attrs["filter_frequency"]), int(file.attrs["elements"])
        mass = file["mass"][:]
        velocity = file["fields/mass_velocity"][-1, :, 1]
    return {
        "frequency": frequency,
        "elements": elements,
        "impulse": summary["support_impulse"][0],
        "mass": mass.sum(),
        "contact": summary["last_contact_time"] - summary["first_contact_time"],
        "rebound": mass @ velocity / mass.sum(),
        "solves": summary["stepping_line_solves"] - summary["row_line_solves"],
    }


def order(runs):
    """Of the last of some runs; empty: not told."""
    *_, last = runs
    if len(runs) > 1 and runs[-2]["frequency"] != last["frequency"]:
        slow, slower = (SPEED - run["rebound"] for run in (last, runs[-2]))
        return f"{math.log(slower / slow) / math.log(last['frequency'] / runs[-2]['frequency']):.2f}"
    if len(runs) > 2 and runs[0]["frequency"] == last["frequency"]:
        first, second = (abs(runs[k]["rebound"] - runs[k + 1]["rebound"]) for k in (0, 1))
        return f"{math.log(first / second) / math.log(last['elements'] / runs[1]['elements']):.2f}"
    return ""


def main():
    print(f"contact {1e3 * CONTACT:.4f} ms, force {1e-3 * FORCE:.2f} kN\n")
    print("| wf [rad/s] | N | contact [ms] | closed form | too long [%] | rebound / v | closed form | too slow [%] "
          "| order | line solves |")
    print("|---" * 10 + "|")
    runs = []
    for folder in sys.argv[1:]:
        run = measured(folder)
        runs.append(run)
        contact, rebound = closed_form(run["frequency"], run["elements"])
        slow = 1 - run["rebound"] / SPEED
        print(f"| {run['frequency']:g} | {run['elements']} | {1e3 * run['contact']:.5f} | {1e3 * contact:.5f} "
              f"| {100 * (run['contact'] / CONTACT - 1):.2f} | {run['rebound'] / SPEED:.6f} | {rebound / SPEED:.6f} "
              f"| {100 * slow:.2f} | {order(runs[-3:])} | {run['solves']} |")


if __name__ == "__main__":
    main()
