"""Sweeps: one case with many values of some options, in parallel, as one table."""
from __future__ import annotations

import collections.abc
import concurrent.futures
import contextlib
import itertools
import os
import pathlib
import tempfile
import typing
import warnings

import numpy as np

from .frames import Path, Results, frame
from .running import Case, RunError, UdarWarning, run
from .tools import UserError, one_line

if typing.TYPE_CHECKING:
    import pandas

# Columns, their units and the keys of summary.json that they are from; of several supports the largest.
COLUMNS = {"peak_force": ("N", "peak_support_force"), "stress": ("Pa", "max_bending_stress"),
           "utilisation": ("1", "max_utilisation"), "line_gap": ("m", "min_line_gap"),
           "sag": ("m", "max_deflection"), "rebound": ("m/s", "rebound_velocity"),
           "first_contact": ("s", "first_contact_time"), "last_contact": ("s", "last_contact_time"),
           "energy_drift": ("1", "energy_drift")}
TEXTS = ("state", "reason", "folder")
NUMBERS = (int, float, np.number)
ALWAYS = ("peak_force", "stress", "utilisation", "line_gap", "first_contact", "last_contact", "energy_drift")

Points = typing.Union["collections.abc.Mapping[str, collections.abc.Iterable[typing.Any]]",
                      "collections.abc.Iterable[collections.abc.Mapping[str, typing.Any]]"]


def points_of(sweep: Points) -> list[dict[str, typing.Any]]:
    """All combinations of the values, the last key fastest; a list of points is taken as it is."""
    if not isinstance(sweep, collections.abc.Mapping):
        return [dict(point) for point in sweep]
    for key, values in sweep.items():
        if isinstance(values, str) or not isinstance(values, collections.abc.Iterable):
            raise UserError(f"{key}: {values!r} is no list of values to sweep; one value is an option of its own")
    return [dict(zip(sweep, values)) for values in itertools.product(*sweep.values())]


def number_of(summary: dict[str, typing.Any], key: str) -> float:
    """A number of the summary, the largest of a list by size; nan where it is not known."""
    values = np.atleast_1d(np.array(summary.get(key), float))  # None is nan
    known = values[np.isfinite(values)]
    return float(known[np.argmax(np.abs(known))]) if len(known) else float("nan")


def row_of(results: Results) -> dict[str, typing.Any]:
    numbers = {name: number_of(results.summary, key) for name, (_, key) in COLUMNS.items()
               if name in ALWAYS or key in results.summary}
    return {"state": "finished" if results.finished else "stopped", "warnings": len(results.warnings), **numbers}


def study(case: Case, sweep: Points, out: Path | None = None, ranks: int = 1, jobs: int | None = None,
          **options: typing.Any) -> "pandas.DataFrame":
    """Runs a case for many values of some options and gives a table with a row for each run, in their order.

    `sweep`: values by key, of which all combinations are run, or a list of points, each with its values by key:
    `udar.study("case.yaml", {"initial_height": [0.5, 1, 2]}, filter_frequency=400)`. `out`: a folder for the runs,
    `run-000`, `run-001`, ...; None: only the table is kept. `ranks`: of each run. `jobs`: runs at the same time; None:
    as many as there are cores for. `options`: of all runs, as in `udar.run`.

    Columns: those of the sweep; `state` (finished, stopped, failed); `warnings`: how many the run gave; `peak_force`
    [N] of the support that gave most; `stress` [Pa] and `utilisation` [1], the largest; `line_gap` [m], of line and
    supports, negative where it was below; `first_contact`, `last_contact` [s]; `energy_drift` [1]; `sag` [m] and
    `rebound` [m/s] where the summary has them; `reason` of a run that failed; `folder`. nan: not known. Units are in
    `attrs["units"]`. A run that fails does not end the others; if all fail, the RunError of the first is raised.
    """
    points = points_of(sweep)
    if not points:
        raise UserError("sweep: there is no point to run")
    both = sorted({key for point in points for key in point} & set(options))
    if both:
        raise UserError(f"{both[0]}: an option of all runs and of the sweep")
    with contextlib.ExitStack() as stack:
        kept = out is not None
        folder = pathlib.Path(out if kept else stack.enter_context(tempfile.TemporaryDirectory(prefix="udar-")))
        stack.enter_context(warnings.catch_warnings())
        warnings.simplefilter("ignore", UdarWarning)  # they are counted in the table
        executor = stack.enter_context(
            concurrent.futures.ThreadPoolExecutor(jobs or max(1, (os.cpu_count() or 1) // ranks)))
        errors: list[RunError] = []

        def one(number: int) -> dict[str, typing.Any]:
            at = folder / f"run-{number:03d}"
            known = {**points[number], "folder": str(at)} if kept else dict(points[number])
            try:
                return {**known, **row_of(run(case, at, ranks, **options, **points[number]))}
            except RunError as error:
                errors.append(error)
                return {**known, "state": "failed", "reason": one_line(error)}

        rows = list(executor.map(one, range(len(points))))
    if len(errors) == len(rows):
        raise errors[0]
    return table_of(rows)


def table_of(rows: list[dict[str, typing.Any]]) -> "pandas.DataFrame":
    """One column for each key of any row, the reason and the folder last."""
    names = dict.fromkeys(name for row in sorted(rows, key=lambda row: row["state"] == "failed") for name in row)
    last = [name for name in ("reason", "folder") if name in names]
    names = [name for name in names if name not in last] + last
    columns = {}
    for name in names:
        values = [row.get(name, "" if name in TEXTS else float("nan")) for row in rows]
        columns[name] = np.array(values, None if all(isinstance(value, NUMBERS) for value in values) else object)
    return frame(columns, {name: COLUMNS.get(name, ("",))[0] for name in names})
