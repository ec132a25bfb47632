#!/usr/bin/env python3
"""Prints by how much the runs of studies miss the limit of each: scatter.py STUDY...

A study is one place of the supports; its limit is the mean of the series `limit`. Of each series: root of the mean
square and largest error over all runs at all places, in percent.
"""
import json
import pathlib
import sys

import numpy as np

QUANTITIES = {"ends": "gauge_0_lowest", "middle": "gauge_2_lowest", "rebound": "rebound_velocity"}


def finished_runs(folder):
    study = json.loads((pathlib.Path(folder) / "study.json").read_text(encoding="utf-8"))
    return [run for run in study["runs"] if run["state"] == "finished"]


def values_of(runs, series):
    """A row of each run of the series; a beam that is still in contact has no rebound."""
    rows = [[run["quantities"][key] for key in QUANTITIES.values()] for run in runs if run["series"] == series]
    return np.array(rows, dtype=float).reshape(-1, len(QUANTITIES))


def main():
    errors, solves = {}, {}
    for folder in sys.argv[1:]:
        runs = finished_runs(folder)
        truth = values_of(runs, "limit").mean(axis=0)
        for series in dict.fromkeys(run["series"] for run in runs):
            errors.setdefault(series, []).append(100 * (values_of(runs, series) / truth - 1))
            solves.setdefault(series, []).extend(run["quantities"]["line_solves"] for run in runs
                                                 if run["series"] == series)
        print(f"{pathlib.Path(folder).name}: limit " +
              ", ".join(f"{name} {value:.5g}" for name, value in zip(QUANTITIES, truth)))
    print("\n| series | runs | " + " | ".join(f"{name}: rms, largest [%]" for name in QUANTITIES) + " | line solves |")
    print("|---" * (len(QUANTITIES) + 3) + "|")
    for series, of_places in errors.items():
        all_of = np.vstack(of_places)
        columns = []
        for column in all_of.T:
            known = column[np.isfinite(column)]
            columns.append(f"{np.sqrt(np.mean(known**2)):.1f}, {np.max(np.abs(known)):.1f}" if len(known) else "-")
        print(f"| {series} | {len(all_of)} | " + " | ".join(columns) +
              f" | {min(solves[series]):.0f} to {max(solves[series]):.0f} |")


if __name__ == "__main__":
    main()
