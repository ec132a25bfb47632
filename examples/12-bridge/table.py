#!/usr/bin/env python3
"""Bearings of the bridge in runs of this case, and where by statics the far one lets go.

usage: table.py RUN...   (folders of results; the speed of the axles is among their options)

An axle P at a < L in the first span of two takes P a (L^2 - a^2) / (4 L^3) from the far bearing, which carries 3/8 of
the weight of a span as long as all three press.
"""

import csv
import pathlib
import re
import sys

import h5py
import numpy as np

SPAN, WEIGHT, START = 20.0, 0.0764 * 7850 * 9.81, 5.0  # [m], [N/m], [s]
AXLES = np.array([0.0, 2.2, 8.4, 10.6])  # [m] behind the first
FORCE = 2e5  # [N] each


def columns(path):
    with open(path, encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def static_place():
    """Of the first axle when the far bearing lets go [m], by bisection."""
    def left(head):
        a = np.clip(head - AXLES, 0, SPAN)
        return 0.375 * WEIGHT * SPAN - (FORCE * a * (SPAN**2 - a**2) / (4 * SPAN**3)).sum()

    low, high = 0.0, 12.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if left(middle) > 0 else (low, middle)
    return low


def main():
    print("| speed [m/s] | bearing | at rest [kN] | largest [kN] | open [s] | lifts by [mm] | far one opens with the"
          " first axle at [m] |\n|---|---|---|---|---|---|---|")
    print(f"| statics | left | {0.375 * WEIGHT * SPAN / 1e3:.2f} | | | | {static_place():.2f} |")
    for run in map(pathlib.Path, sys.argv[1:]):
        with h5py.File(run / "results.h5") as file:
            options = str(np.char.decode(np.bytes_(file.attrs["options"])))
        speed = float(re.search(r"-load_axles_speed (\S+)", options)[1])
        contact, gauges = columns(run / "contact.csv"), columns(run / "gauges.csv")
        passing = contact["time"] > START
        row = contact["time"][1] - contact["time"][0]
        for number, (name, gauge) in enumerate((("left", 0), ("middle", None), ("far", 3))):
            force = contact[f"force_{number}"]
            open_rows = passing & (force == 0)
            lift = "" if gauge is None else f"{1e3 * gauges[f'line_{gauge}'][passing].max():.0f}"
            head = (contact["time"][open_rows][0] - START) * speed if name == "far" else 0.0
            where = f"{head:.2f}" if name == "far" else ""
            print(f"| {speed:g} | {name} | {force[~passing][-1] / 1e3:.2f} | {force[passing].max() / 1e3:.0f} |"
                  f" {open_rows.sum() * row:.2f} | {lift} | {where} |")


if __name__ == "__main__":
    main()
