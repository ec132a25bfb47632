#!/usr/bin/env python3
"""Prints the table "numbers to expect" of README.md from a study: table.py STUDY"""
import json
import pathlib
import sys

V0 = (2 * 9.81 * 1.0) ** 0.5  # m/s after the fall
ENERGY = 7850 * 3.141592653589793 * 0.1**2 * 10 * 9.81  # J brought in by the fall of 1 m

COLUMNS = {
    "ends [cm]": lambda q: 100 * q["gauge_0_lowest"],
    "middle [cm]": lambda q: 100 * q["gauge_2_lowest"],
    "line below support [cm]": lambda q: 100 * q["penetration"],
    "rebound / v0": lambda q: (q["rebound_velocity"] or float("nan")) / V0,
    "centre of mass [%]": lambda q: 100 * q["energy_centre"] / ENERGY,
    "vibration [%]": lambda q: 100 * q["energy_vibration"] / ENERGY,
    "springs [%]": lambda q: 100 * q["energy_springs"] / ENERGY,
}


def main():
    study = json.loads((pathlib.Path(sys.argv[1]) / "study.json").read_text())
    runs = [run for run in study["runs"] if run["state"] == "finished"]
    print("| series | wf, step or modes | " + " | ".join(COLUMNS) + " | line solves |")
    print("|---" * (len(COLUMNS) + 3) + "|")
    for run in runs:
        axis = next(iter(run["axes"].values()), "1e-6")
        quantities = run["quantities"]
        values = " | ".join(f"{column(quantities):.2f}" for column in COLUMNS.values())
        print(f"| {run['series']} | {axis} | {values} | {quantities['line_solves']:.0f} |")


if __name__ == "__main__":
    main()
