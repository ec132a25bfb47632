#!/usr/bin/env python3
"""What the restraint takes in runs of this case, beside the work of crushing in closed form.

usage: table.py RUN...   (folders of results)

A restraint that crushes at the force Fp, elastic with the slope k before and after, has taken Fp (D - Fp / k) when it
was pressed by D at most and let go.
"""

import csv
import json
import pathlib
import re
import sys

import h5py
import numpy as np

STIFFNESS, GAP = 2e7, 0.03  # [N/m], [m]


def columns(path):
    with open(path, encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def main():
    print("| plateau [kN] | largest force [kN] | pressed by [mm] | taken [J] | closed form [J] | tip up to [mm] |"
          " stress at the anchor [MPa] |\n|---|---|---|---|---|---|---|")
    for run in map(pathlib.Path, sys.argv[1:]):
        with h5py.File(run / "results.h5") as file:
            options = file.attrs["options"]
        plateau = float(re.search(r"-contact_plateau_force (\S+)",
                                  options if isinstance(options, str) else options.decode())[1])
        gauges, summary = columns(run / "gauges.csv"), json.loads((run / "summary.json").read_text())
        deep = gauges["mass_0"].max() - GAP
        taken = columns(run / "energy.csv")["lost_in_dampers"][-1]
        print(f"| {plateau / 1e3:g} | {-summary['peak_support_force'][0] / 1e3:.1f} | {1e3 * deep:.1f} | {taken:.1f} |"
              f" {max(plateau * (deep - plateau / STIFFNESS), 0):.1f} | {1e3 * gauges['line_1'].max():.0f} |"
              f" {summary['max_bending_stress'] / 1e6:.0f} |")


if __name__ == "__main__":
    main()
