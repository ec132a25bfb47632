#!/usr/bin/env python3
"""What two frames that hit each other do in runs of this case, and when they meet by the run in which they do not.

usage: table.py RUN... FREE   (folders of results; the last one has a gap that stays open)

Up to the first touch both frames move as if each stood alone: they meet when their displacements in FREE are the gap
apart.
"""

import csv
import json
import pathlib
import re
import sys

import h5py
import numpy as np

STRUCK, HITS, ROOF = (6.0, 4.0), (6.24, 4.0), (6.0, 6.0)  # [m]: the place on the column, what comes, the higher roof
COLUMN = 1  # member


def columns(path):
    with open(path, encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


class Run:
    def __init__(self, folder):
        folder = pathlib.Path(folder)
        with h5py.File(folder / "results.h5") as file:
            options = str(np.char.decode(np.bytes_(file.attrs["options"])))
            place = np.column_stack([file["x"][()], file["y"][()]])
            self.time, way = file["fields/time"][()], file["fields/displacement_of_masses"][:, :, 0]
            here = file["member"][()] == COLUMN
            self.moment = max(np.abs(file[f"envelope/moment_z_{side}"][here]).max() for side in ("min", "max"))
        self.gap = float(re.search(r"-pair_gap (\S+)", options)[1])
        self.struck, self.hits, self.roof = (
            way[:, np.abs(place - at).sum(axis=1).argmin()] for at in (STRUCK, HITS, ROOF))
        self.contact, self.energy = columns(folder / "contact.csv"), columns(folder / "energy.csv")
        self.first = json.loads((folder / "summary.json").read_text())["first_contact_time"]

    def meet(self, gap):
        """When both are so near for the first time if nothing happens there [s]; linear between rows."""
        near = self.struck - self.hits - gap
        row = np.argmax(near > 0)
        return self.time[row - 1] - near[row - 1] * (self.time[row] - self.time[row - 1]) / (near[row] - near[row - 1])


def main():
    print("| gap [mm] | hits | first [s] | by the free run [s] | largest force [kN] | impulse [kN s] | lost [J] |"
          " high roof [mm] | low roof [mm] | moment of the column [kN m] |\n|---|---|---|---|---|---|---|---|---|---|")
    runs = [Run(folder) for folder in sys.argv[1:]]
    for run in runs:
        touch = run.contact["force_0"] > 0
        hits = np.count_nonzero(np.diff(touch.astype(int)) == 1)
        first = f"{run.first:.4f} | {runs[-1].meet(run.gap):.4f}" if hits else "never | never"
        print(f"| {1e3 * run.gap:g} | {hits} | {first} | {run.contact['force_0'].max() / 1e3:.1f} |"
              f" {run.contact['impulse_0'][-1] / 1e3:.2f} | {run.energy['lost_in_dampers'][-1]:.1f} |"
              f" {1e3 * np.abs(run.roof).max():.1f} | {1e3 * np.abs(run.hits).max():.1f} | {run.moment / 1e3:.1f} |")


if __name__ == "__main__":
    main()
