#!/usr/bin/env python3
"""Prints the table "numbers to expect" of README.md from finished runs: table.py RUN [RUN ...]"""
import csv
import json
import pathlib
import sys

import h5py
import numpy as np

EPISODE_GAP = 0.2  # s: a longer pause between impacts is a flight of the whole beam


def numbers(run):
    run = pathlib.Path(run)
    summary = json.loads((run / "summary.json").read_text())
    rows = list(csv.DictReader((run / "impacts.csv").open()))
    time = np.array([float(row["time"]) for row in rows])
    last = next((i for i in range(1, len(time)) if time[i] - time[i - 1] > EPISODE_GAP), len(time)) - 1
    impulse = sum(float(row["impulse"]) for row in rows[: last + 1] if row["support"] == "0")
    with h5py.File(run / "results.h5") as results, (run / "energy.csv").open() as energy:
        weight = np.ones(results["x"].shape[0])
        weight[[0, -1]] = 0.5
        after = np.searchsorted(results["fields/time"][:], time[last])
        velocity = results["fields/mass_velocity"][after] @ weight / weight.sum()
        fall = results["fields/time"][after] - time[last]
        drift = max(abs(float(row["drift"])) for row in csv.DictReader(energy))
        frequency = results.attrs["filter_frequency"]
    gravity, v0 = 9.81, (2 * 9.81) ** 0.5
    return frequency, {
        "time of the first contact [s]": f"{summary['first_contact_time']:.9f}",
        f"impacts up to t = {summary['end_time']:g} s": str(summary["impacts"]),
        "duration of the first contact [ms]": f"{1e3 * (time[last] - time[0]):.1f}",
        "lowest line position at a support [m]": f"{summary['min_line_gap']:.4f}",
        "at the time [s]": f"{summary['min_line_gap_time']:.4f}",
        "speed of the centre of mass after the first contact / v0": f"{(velocity + gravity * fall) / v0:.3f}",
        "impulse of one support in the first contact [N s]": f"{impulse:.1f}",
        "largest abs(drift) of the energy": f"{drift:.0e}",
        "accepted steps, line solves": f"{summary['steps']}, {summary['line_solves']}",
    }


columns = [numbers(run) for run in sys.argv[1:]]
print("| quantity |" + "".join(f" wf = {frequency:g} rad/s |" for frequency, _ in columns))
print("|---|" + "---|" * len(columns))
for key in columns[0][1]:
    print(f"| {key} |" + "".join(f" {table[key]} |" for _, table in columns))
