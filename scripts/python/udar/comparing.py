"""Two runs, or a run and curves from elsewhere, side by side and judged by a tolerance."""
from __future__ import annotations

import collections.abc
import dataclasses
import os
import pathlib
import re
import typing

import numpy as np

from .files import ENERGIES, RunFiles, read_options, unit_of
from .tools import UserError, read_csv

Path = typing.Union[str, "os.PathLike[str]"]
PREFIXES = {"": 1.0, "k": 1e3, "M": 1e6, "G": 1e9, "m": 1e-3, "u": 1e-6, "\u00b5": 1e-6}
CONSTANT = 1e-9    # of its size: a curve that varies less has no range to speak of
# Keys of summary.json that say what a run cost or was asked for, not what came out. The drift is round-off.
COSTS = {"completed", "elements", "ranks", "integrator", "integrator_counts", "steps", "rejected_steps",
         "repeated_steps", "rhs_evaluations", "line_solves", "stepping_line_solves", "row_line_solves",
         "streamed_bytes", "event_steps", "energy_drift", "warnings", "gauge_position", "gauge_node_position",
         "wall_seconds", "wall_seconds_mean", "own_seconds", "communication", "peak_memory_bytes", "memory_per_rank",
         "versions"}
# Shown, not judged: when and where an extreme was reached jumps between peaks of nearly one size; windows are settings.
NOT_JUDGED = re.compile(r"^(min|max|plastic)_.*_(time|[xyz]|member|place)$|window$")
SCALAR_UNITS = (("_time", "s"), ("window", "s"), ("moment_y", "N m"), ("moment_z", "N m"), ("shear_y", "N"),
                ("shear_z", "N"), ("_x", "m"), ("_y", "m"), ("_z", "m"), ("gap", "m"), ("deflection", "m"),
                ("displacement", "m"), ("penetration", "m"), ("velocity", "m/s"), ("impulse", "N s"), ("force", "N"),
                ("stress", "Pa"), ("moment", "N m"), ("torque", "N m"), ("shear", "N"), ("energy", "J"))


@dataclasses.dataclass
class Curve:
    unit: str           # "" where a file does not say
    time: np.ndarray    # [s], ascending
    values: np.ndarray


@dataclasses.dataclass(frozen=True)
class Tolerance:
    """`relative` to the range of a curve, or the size of a number; `absolute` by column or unit in place of it."""
    relative: float
    absolute: dict[str, float]

    def allowed(self, name: str, unit: str, scale: float) -> float:
        return self.absolute.get(name, self.absolute.get(unit, self.relative * scale))


@dataclasses.dataclass
class CurveDifference:
    """Of two curves over the times of both; `relative` is the largest over the range, nan: a value is no number."""
    name: str
    unit: str
    largest: float
    time: float         # of the largest [s]
    rms: float          # over time
    relative: float
    apart_from: float | None  # the first time beyond the tolerance [s]
    within: bool


@dataclasses.dataclass
class ImpactDifference:
    """Impacts of both runs, paired at the same place and support within `window` [s]."""
    first: int
    second: int
    matched: int
    missing: int        # of the first alone
    extra: int          # of the second alone
    window: float
    first_alone: float | None  # time of the first impact without a partner [s]
    time: float         # largest differences: [s], and of the speed before the impact [m/s]
    speed: float
    within: bool


@dataclasses.dataclass
class ScalarDifference:
    name: str
    unit: str
    first: float | None
    second: float | None
    relative: float     # nan where one is not known
    judged: bool
    within: bool


@dataclasses.dataclass
class Comparison:
    """`within`: nothing that is judged is beyond the tolerance."""
    first: str
    second: str
    tolerance: Tolerance
    begin: float        # of what was compared [s]
    end: float
    rows: tuple[int, int]
    same_times: bool
    curves: list[CurveDifference]
    only_first: list[str]
    only_second: list[str]
    impacts: ImpactDifference | None = None
    scalars: list[ScalarDifference] = dataclasses.field(default_factory=list)
    options: dict[str, tuple[str | None, str | None]] = dataclasses.field(default_factory=dict)
    notes: list[str] = dataclasses.field(default_factory=list)
    alike: bool = True  # both have the same curves, and both have ended or neither

    @property
    def within(self) -> bool:
        return (self.alike and all(entry.within for entry in (*self.curves, *self.scalars))
                and (self.impacts is None or self.impacts.within))


def curves_of(files: RunFiles) -> dict[str, Curve]:
    """All curves of a run by column: gauges, forces and impulses of supports, energies, `strikers.position_0`,
    `places.force_0` ..."""
    with files.results() as file:
        gauges, contact = len(file["gauge_node"]), files.contact(file)
    tables = {"": files.table("gauges", ["time"])} if gauges else {}
    for name in ("strikers", "places", "axles"):
        if (files.folder / f"{name}.csv").exists():
            tables[f"{name}."] = files.table(name, ["time"])
    curves = {before + name: Curve(unit_of(name), table["time"], values)
              for before, table in tables.items() for name, values in table.items() if name != "time"}
    for kind in ("force", "impulse") if contact is not None else ():
        for k, values in enumerate(getattr(contact, kind).T):
            name = kind if contact.together else f"{kind}_{k}"
            curves[name] = Curve(unit_of(name), contact.time, values)
    energy = files.table("energy", ["time", *ENERGIES])
    return curves | {name: Curve("J", energy["time"], energy[name]) for name in ENERGIES}


def curves_of_table(path: pathlib.Path, time: str) -> dict[str, Curve]:
    """Columns of a CSV file; a name may be followed by its unit, `deflection [mm]`."""
    table = {}
    for head, values in read_csv(path, whole=True).items():
        name, unit = re.fullmatch(r'[\s"]*(.*?)\s*(?:\[(.*)\])?[\s"]*', head).groups()
        table[name] = unit or "", values
    if time not in table:
        raise UserError(f"{path}: the first line has no column '{time}', only {', '.join(table)}")
    unit, times = table.pop(time)
    times = times * factor(unit, "s", f"{path}: {time}")
    if not len(times):
        raise UserError(f"{path}: no rows below the names")
    if not np.all(np.diff(times) > 0):
        row = int(np.argmin(np.diff(times) > 0)) + 1
        raise UserError(f"{path}: {time} does not grow in row {row + 1}, where it is {times[row]:g} s")
    for name, (_, values) in table.items():
        if not np.isfinite(values).all():
            raise UserError(f"{path}: {name} is no number in row {int(np.argmin(np.isfinite(values))) + 1}")
    return {name: Curve(unit, times, values) for name, (unit, values) in table.items()}


def factor(unit: str, wanted: str, what: str) -> float:
    """What a number in `unit` is to be multiplied by to be in `wanted`; `mm` is 1e-3 `m`. Without a unit it is SI."""
    if unit in ("", "-" if wanted == "1" else ""):
        return 1.0
    if unit.endswith(wanted) and unit.removesuffix(wanted) in PREFIXES:
        return PREFIXES[unit.removesuffix(wanted)]
    raise UserError(f"{what} has the unit {unit}, expected {wanted}, with k, M, G, m or u before it, or none")


def compare_curves(name: str, one: Curve, other: Curve, scale: float, tolerance: Tolerance) -> CurveDifference:
    """At the times of both where both are, linear between rows."""
    same = np.array_equal(one.time, other.time)
    time = one.time if same else common_times(one.time, other.time)
    off = other.values - one.values if same else (
        np.interp(time, other.time, other.values) - np.interp(time, one.time, one.values))
    size = np.abs(off)
    if not np.isfinite(off).all():
        at = float(time[np.argmin(np.isfinite(off))])
        return CurveDifference(name, one.unit, np.nan, at, np.nan, np.nan, at, False)
    steps = np.diff(time)
    squares = (off[1:]**2 + off[1:] * off[:-1] + off[:-1]**2) / 3.0
    rms = np.sqrt(steps @ squares / steps.sum()) if len(steps) else size[0]
    beyond = np.flatnonzero(size > tolerance.allowed(name, one.unit, scale))
    largest = float(size.max())
    return CurveDifference(name, one.unit, largest, float(time[size.argmax()]), float(rms),
                           largest / scale if scale else (np.inf if largest else 0.0),
                           float(time[beyond[0]]) if len(beyond) else None, not len(beyond))


def common_times(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """All times of both between the later of their begins and the earlier of their ends."""
    begin, end = max(one[0], other[0]), min(one[-1], other[-1])
    if not begin <= end:
        raise UserError(f"no time is in both: one is from {one[0]:g} to {one[-1]:g} s, the other from {other[0]:g} to "
                        f"{other[-1]:g} s")
    both = np.union1d(one, other)
    return both[(both >= begin) & (both <= end)]


def range_of(values: np.ndarray) -> float:
    """How much a curve varies; of one that does not its size."""
    known = values[np.isfinite(values)]
    if not len(known):
        return 0.0
    size = float(np.abs(known).max())
    return float(np.ptp(known)) if np.ptp(known) > CONSTANT * size else size


def compare_impacts(tables: list[dict[str, np.ndarray]], span: float, tolerance: Tolerance) -> ImpactDifference:
    """Pairs are each other's nearest in time, at the same place and support and within the tolerance of time."""
    window = tolerance.allowed("time", "s", span)
    speeds = [np.abs(table["velocity_before"]) for table in tables]
    sizes = [len(table["time"]) for table in tables]
    places = np.concatenate([np.column_stack([table["x"], table["node"] if same_nodes(tables) else 0 * table["node"],
                                              table["support"]]) for table in tables])
    groups = np.unique(np.round(places, 9), axis=0, return_inverse=True)[1].ravel()
    groups = [groups[:sizes[0]], groups[sizes[0]:]]
    pairs = [(np.empty(0, int), np.empty(0, int))]
    for group in np.intersect1d(*groups):
        rows = [np.flatnonzero(own == group) for own in groups]
        times = [table["time"][own] for table, own in zip(tables, rows)]
        there, back = nearest(times[0], times[1]), nearest(times[1], times[0])
        mutual = (back[there] == np.arange(len(there))) & (np.abs(times[1][there] - times[0]) <= window)
        pairs.append((rows[0][mutual], rows[1][there[mutual]]))
    first, second = (np.concatenate(rows) for rows in zip(*pairs))
    alone = [np.delete(table["time"], own) for table, own in zip(tables, (first, second))]
    away = np.abs(tables[1]["time"][second] - tables[0]["time"][first]).max(initial=0.0)
    faster = np.abs(speeds[1][second] - speeds[0][first]).max(initial=0.0)
    allowed = tolerance.allowed("velocity_before", "m/s", max(own.max(initial=0.0) for own in speeds))
    lonely = np.concatenate(alone)
    return ImpactDifference(*sizes, len(first), len(alone[0]), len(alone[1]), float(window),
                            float(lonely.min()) if len(lonely) else None, float(away), float(faster),
                            not len(lonely) and bool(faster <= allowed))


def same_nodes(tables: list[dict[str, np.ndarray]]) -> bool:
    """A node's number is the same place in both, as far as they tell; another mesh has other numbers."""
    places = [dict(zip(table["node"].tolist(), table["x"].tolist())) for table in tables]
    return all(places[1].get(node, x) == x for node, x in places[0].items())


def nearest(times: np.ndarray, others: np.ndarray) -> np.ndarray:
    """For each time the row of the nearest of the others, which ascend."""
    after = np.clip(np.searchsorted(others, times), 1, max(1, len(others) - 1))
    before = after - 1
    after = np.minimum(after, len(others) - 1)
    return np.where(np.abs(others[before] - times) <= np.abs(others[after] - times), before, after)


def numbers_of(summary: dict[str, typing.Any]) -> dict[str, float | None]:
    """Results by key; of lists each entry by its number."""
    found = {}
    for key, value in summary.items():
        if key in COSTS:
            continue
        for end, part in ([("", value)] if not isinstance(value, list)
                          else [(f"_{k}", part) for k, part in enumerate(value)]):
            if part is None or isinstance(part, (int, float)) and not isinstance(part, bool):
                found[key + end] = part
    return found


def compare_numbers(one: dict[str, typing.Any], other: dict[str, typing.Any],
                    tolerance: Tolerance) -> list[ScalarDifference]:
    numbers = [numbers_of(summary) for summary in (one, other)]
    found = []
    for name in numbers[0] | numbers[1]:
        values = [own.get(name) for own in numbers]
        if values == [None, None]:
            continue
        bare = re.sub(r"_\d+$", "", name)
        unit = next((unit for end, unit in SCALAR_UNITS if bare.endswith(end)), "1")
        judged = not NOT_JUDGED.search(name)
        if None in values:
            found.append(ScalarDifference(name, unit, *values, np.nan, judged, not judged))
            continue
        off, scale = abs(values[1] - values[0]), max(map(abs, values))
        within = bool(off <= tolerance.allowed(name, unit, scale))
        found.append(ScalarDifference(name, unit, *values, off / scale if scale else 0.0, judged, within or not judged))
    return found


def differing_options(runs: list[RunFiles]) -> dict[str, tuple[str | None, str | None]]:
    options = []
    for files in runs:
        with files.results() as file:
            options.append(read_options(file))
    keys = sorted((options[0].keys() | options[1].keys()) - {"output_directory", "output_overwrite"})
    return {key: (options[0].get(key), options[1].get(key)) for key in keys
            if options[0].get(key) != options[1].get(key)}


def paired(curves: list[dict[str, Curve]], names: list[Path],
           columns: collections.abc.Mapping[str, str] | None) -> list[tuple[str, Curve, Curve]]:
    """The curves that belong together, the second in the unit of the first."""
    wanted = {name: name for name in curves[0] if name in curves[1]} if columns is None else columns
    if not wanted:
        raise UserError(f"{names[1]}: no curve of {names[0]} is called as a column here, which are "
                        f"{', '.join(curves[1])}; --columns says which belongs to which")
    pairs = []
    for name, other in wanted.items():
        for number, key in enumerate((name, other)):
            if key not in curves[number]:
                raise UserError(f"{names[number]}: no curve '{key}', there are {', '.join(curves[number])}")
        one, two = curves[0][name], curves[1][other]
        scale = factor(two.unit, one.unit, f"{names[1]}: {other}")
        pairs.append((name, one, Curve(one.unit, two.time, scale * two.values)))
    return pairs


def compare(first: Path, second: Path, tolerance: float = 0.01,
            absolute: collections.abc.Mapping[str, float] | None = None,
            columns: collections.abc.Mapping[str, str] | None = None) -> Comparison:
    """Compares a run with another one, or with the curves of a CSV file.

    `first`: the folder of a run; `second`: another, or a CSV file with a column `time` and a header with names, units
    behind them in brackets if they are not SI. `tolerance`: of the range of a curve, of the size of a number of the
    summary; of the time that both runs have for times of impacts. `absolute`: by column or unit in place of it, in SI
    units. `columns`: compare these curves of the first with those of the second, and nothing else; `time` names the
    column of times of a CSV file. Raises UserError for what cannot be read or compared.
    """
    limits = Tolerance(tolerance, dict(absolute or {}))
    for name, value in {"tolerance": tolerance, **limits.absolute}.items():
        if not value >= 0:
            raise UserError(f"{name}: {value} is not allowed, expected a number >= 0")
    wanted = dict(columns) if columns else None
    time = wanted.pop("time", "time") if wanted else "time"
    runs = [RunFiles(first)]
    table = pathlib.Path(second).is_file()
    if not table:
        runs.append(RunFiles(second))
    curves = [curves_of(files) for files in runs]
    if table:
        curves.append(curves_of_table(pathlib.Path(second), time))
    pairs = paired(curves, [first, second], wanted or None)
    for name, one, other in pairs:
        if not len(one.time) or not len(other.time):
            raise UserError(f"{second if len(one.time) else first}: no rows of {name} yet")
    energies = max(range_of(curves[0][name].values) for name in ENERGIES)
    times = pairs[0][1].time, pairs[0][2].time
    common = common_times(*times)
    result = Comparison(
        str(first), str(second), limits, float(common[0]), float(common[-1]), (len(times[0]), len(times[1])),
        np.array_equal(*times),
        [compare_curves(name, one, other, energies if name in ENERGIES else range_of(one.values), limits)
         for name, one, other in pairs],
        [] if wanted or table else sorted(curves[0].keys() - curves[1].keys()),
        [] if wanted else sorted(curves[1].keys() - curves[0].keys()))
    if not table:
        result.options = differing_options(runs)
        if not wanted:
            compare_runs(result, runs, common[-1] - common[0])
    return result


def compare_runs(result: Comparison, runs: list[RunFiles], span: float) -> None:
    """What only runs have: impacts and the numbers of their summaries."""
    result.alike = not result.only_first and not result.only_second
    tables = []
    for files in runs:
        with files.results() as file:
            tables.append(files.impacts(file, ("time", "node", "x", "support", "velocity_before")))
    if any(len(table["time"]) for table in tables):
        result.impacts = compare_impacts(tables, span, result.tolerance)
    ended = [bool(files.summary) for files in runs]
    result.notes += [f"{files.folder} has not ended: no summary.json" for files in runs if not files.summary]
    result.notes += [f"{files.folder} was stopped before its end" for files in runs if files.summary
                     and not files.finished]
    result.alike = result.alike and ended[0] == ended[1]
    if all(ended):
        result.scalars = compare_numbers(runs[0].summary, runs[1].summary, result.tolerance)
