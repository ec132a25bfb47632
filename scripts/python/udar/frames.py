"""The results of a run in Python: tables as frames of pandas, fields as arrays of xarray, each with its units."""
from __future__ import annotations

import functools
import os
import pathlib
import typing

import numpy as np

from .files import RunFiles, read_options, text_of, unit_of
from .tools import UserError, need

if typing.TYPE_CHECKING:
    import pandas
    import xarray

Path = typing.Union[str, "os.PathLike[str]"]
WHOLE = ("node", "support", "masses", "member", "cell", "impacts")  # columns of whole numbers
SUPPORT_UNITS = {"position": "m", "width": "m", "height": "m", "side": "1", "restitution": "1", "impulse": "N s",
                 "peak_force": "N"}


class FieldInfo(typing.NamedTuple):
    """What is known of a field before it is read; `shape` is (times, nodes or cells) or (times, nodes, 3)."""
    label: str
    units: str
    where: str
    shape: tuple[int, ...]


class Results:
    """A run of udar. Nothing is read before it is asked for; what cannot be read is a `UserError` that names the file.

    Of a run that goes on, what was read stays as it was: `udar.open` again shows what has come since.
    Frames have the units of their columns in `frame.attrs["units"]`, by name; "1" is a number without unit.
    """

    def __init__(self, folder: Path) -> None:
        self._files = RunFiles(folder)
        self.log = ""  # what the program said, where `udar.run` started it

    def __repr__(self) -> str:
        state = "" if self.finished else ", not finished"
        return f"<udar.Results {self.folder}: {len(self._files.summary.get('warnings', ()))} warnings{state}>"

    @property
    def folder(self) -> pathlib.Path:
        return self._files.folder

    @property
    def finished(self) -> bool:
        """The run has reached its end; not while it goes on, nor where it was stopped."""
        return self._files.finished

    @property
    def summary(self) -> dict[str, typing.Any]:
        """summary.json as it is (docs/output.md); empty while the run goes on."""
        return self._files.summary

    @property
    def warnings(self) -> list[str]:
        """What the run warned of."""
        return list(self.summary.get("warnings", ()))

    @functools.cached_property
    def options(self) -> dict[str, str]:
        """The options the run had, as text by key without its dash."""
        with self._files.results() as file:
            return read_options(file)

    @functools.cached_property
    def structure(self) -> str:
        """`beam`, `network`, or `points` of imported matrices."""
        with self._files.results() as file:
            return text_of(file, "structure", "beam")

    @functools.cached_property
    def gauges(self) -> "pandas.DataFrame":
        """gauges.csv: `time` [s], and of gauge k `mass_k` [m], `velocity_k` [m/s], `line_k` [m]."""
        return frame(self._files.table("gauges", ["time"]))

    @functools.cached_property
    def strikers(self) -> "pandas.DataFrame":
        """strikers.csv: `time` [s], and of striker k `position_k` [m], `velocity_k` [m/s]; UserError without."""
        return frame(self._files.table("strikers", ["time"]))

    @functools.cached_property
    def places(self) -> "pandas.DataFrame":
        """places.csv: `time` [s], and of place k, which holds the structure and moves, `displacement_k` [m],
        `velocity_k` [m/s], `force_k` [N]; UserError without."""
        return frame(self._files.table("places", ["time"]))

    @functools.cached_property
    def axles(self) -> "pandas.DataFrame":
        """axles.csv: `time` [s], and of mass k that travels `x_k` [m], `position_k` [m], `velocity_k` [m/s], `line_k`
        [m] under it, `force_k` [N] of it on the line; UserError without."""
        return frame(self._files.table("axles", ["time"]))

    @functools.cached_property
    def energy(self) -> "pandas.DataFrame":
        """energy.csv: `time` [s], energies [J], `drift` [1] of their total."""
        return frame(self._files.table("energy", ["time"]))

    @functools.cached_property
    def contact(self) -> "pandas.DataFrame":
        """contact.csv: `time` [s], `masses` in contact, `x_min`, `x_max` [m], of support k `force_k` [N], `impulse_k`
        [N s], y up, of however many supports; UserError without supports."""
        with self._files.results() as file:
            contact = self._files.contact(file)
        if contact is None:
            raise UserError(f"{self.folder}: the run has no supports, and no contact.csv")
        columns = {name: getattr(contact, name) for name in ("time", "masses", "x_min", "x_max")}
        for k in range(contact.force.shape[1]):
            end = "" if contact.together else f"_{k}"
            columns |= {f"force{end}": contact.force[:, k], f"impulse{end}": contact.impulse[:, k]}
        return frame(columns)

    @functools.cached_property
    def impacts(self) -> "pandas.DataFrame":
        """All impacts: `time` [s], `node`, `x` [m], `support`, `velocity_before`, `velocity_after` [m/s], `impulse`
        [N s], `energy_loss` [J]."""
        return self._records("impacts")

    @functools.cached_property
    def merged_impacts(self) -> "pandas.DataFrame":
        """Impacts of a node on a support within `-output_contact_window` as one: `time` of the first and `last_time`
        [s], `node`, `x` [m], `support`, how many `impacts`, `speed_max` [m/s], sums of `impulse` [N s] and
        `energy_loss` [J]; UserError where the run was not asked for them."""
        with self._files.results() as file:
            if "impacts_merged" not in file:
                raise UserError(f"{self.path}: the run was not asked to merge impacts (-output_contacts)")
        return self._records("impacts_merged")

    @functools.cached_property
    def rests(self) -> "pandas.DataFrame":
        """`time` [s], `node`, `x` [m], `support` and `release`: 0 where the mass comes to rest, 1 where it leaves."""
        return self._records("rests")

    @functools.cached_property
    def supports(self) -> "pandas.DataFrame":
        """A row for each support, a floor and strikers after the others: `position`, `width`, `height` [m], `side`,
        `restitution` and, once the run has ended, `impulse` [N s] and `peak_force` [N]."""
        names = ("position", "width", "height", "side", "restitution")
        with self._files.results() as file:
            columns = {name: np.atleast_1d(file[f"support_{name}"][()]) for name in names}
        for name, key in (("impulse", "support_impulse"), ("peak_force", "peak_support_force")):
            if self.summary.get(key):
                columns[name] = np.array(self.summary[key], float)
        return frame(columns, {name: SUPPORT_UNITS[name] for name in columns})

    @functools.cached_property
    def nodes(self) -> "pandas.DataFrame":
        """`node` (the user's number), `x`, `y`, `z` [m], `mass` [kg], in the order of the fields."""
        with self._files.results() as file:
            columns = self._places(file)
            columns["mass"] = file["mass"][()]
        return frame(columns, {**dict.fromkeys("xyz", "m"), "node": "1", "mass": "kg"})

    @functools.cached_property
    def envelope(self) -> "pandas.DataFrame":
        """What the fields reached, with `_min` and `_max`: of a beam a row for each node (of the shear force that of
        the element to its right), of a network one for each of its cells; UserError before the run has ended."""
        with self._files.results() as file:
            group = file.get("envelope")
            if group is None:
                raise UserError(f"{self.path}: no /envelope, which is written when a run ends")
            units = {name: text_of(item, "units", "1") for name, item in group.items()}
            columns = {name: item[()].astype(float) for name, item in group.items()}
            rows = max(map(len, columns.values()), default=0)
            places = self._places(file)
            if rows != len(places["x"]):
                places = {"cell": np.arange(rows)}
        padded = {name: np.append(values, np.full(rows - len(values), np.nan)) for name, values in columns.items()}
        return frame({**places, **padded}, {**dict.fromkeys(places, "m"), "node": "1", "cell": "1", **units})

    @property
    def path(self) -> pathlib.Path:
        """results.h5, for what is not here."""
        return self._files.path

    @functools.cached_property
    def fields(self) -> dict[str, FieldInfo]:
        """The fields there are, by name; none of them is read."""
        with self._files.results() as file:
            group = file["fields"]
            return {name: FieldInfo(text_of(group[name], "label", name), text_of(group[name], "units", "1"),
                                    text_of(group[name], "where", "points"), group[name].shape)
                    for name in group if name != "time"}

    @functools.cached_property
    def field_times(self) -> np.ndarray:
        """Times of the rows of fields [s]."""
        with self._files.results() as file:
            return file["fields/time"][()]

    def field(self, name: str, time: float | tuple[float, float] | None = None, every: int = 1) -> "xarray.DataArray":
        """Rows of a field, of which no others are read.

        `time`: one time [s], of which the nearest row is taken, or (from, to) [s]; None: all. `every`: of these rows
        each so-manieth. Dimensions: `time`, then `node` or `cell`, of vectors `axis`; `x`, `y`, `z` [m] are coordinates
        along nodes, or the middles of cells; units in `attrs["units"]`, also of the coordinates.
        Raises UserError for a field or a time that is not there, ImportError without xarray.
        """
        if name not in self.fields:
            raise UserError(f"{self.path}: no field '{name}', there are {', '.join(self.fields)}")
        if every < 1:
            raise UserError(f"field: every = {every} is not allowed, expected a whole number >= 1")
        info = self.fields[name]
        rows = self._rows(time, every)
        with self._files.results() as file:
            values = file["fields"][name][rows]  # a run that goes on may have fewer rows of this field
            times = self.field_times[rows][:len(values)]
            along, places = self._coordinates(file, info.where)
        coordinates = {"time": ("time", times, {"units": "s"}), **places}
        dimensions: tuple[str, ...] = ("time", along)
        if values.ndim == 3:
            dimensions += ("axis",)
            coordinates["axis"] = ("axis", list("xyz"))
        return need("xarray", "python3-xarray").DataArray(
            values, coordinates, dimensions, name, {"units": info.units, "long_name": info.label})

    def _rows(self, time: float | tuple[float, float] | None, every: int) -> slice:
        times = self.field_times
        if time is None:
            return slice(0, len(times), every)
        begin, end = (time, time) if np.isscalar(time) else time
        if not len(times) or not begin <= end or end < times[0] or begin > times[-1]:
            known = f"rows go from {times[0]:g} to {times[-1]:g} s" if len(times) else "there are no rows yet"
            raise UserError(f"{self.path}: fields have no time {time} s; {known}")
        if np.isscalar(time):
            row = int(np.argmin(np.abs(times - time)))
            return slice(row, row + 1)
        return slice(int(np.searchsorted(times, begin)), int(np.searchsorted(times, end, side="right")), every)

    def _records(self, name: str) -> "pandas.DataFrame":
        with self._files.results() as file:
            return frame(self._files.records(file, name, ("time", "node", "x", "support")))

    @staticmethod
    def _places(file: typing.Any) -> dict[str, np.ndarray]:
        x = np.atleast_1d(file["x"][()])
        return {"node": file["node"][()] if "node" in file else np.arange(len(x)), "x": x,
                **{axis: file[axis][()] if axis in file else np.zeros(len(x)) for axis in "yz"}}

    def _coordinates(self, file: typing.Any, where: str) -> tuple[str, dict[str, typing.Any]]:
        places = self._places(file)
        along = "node"
        if where == "cells":
            along = "cell"
            cells = file["cells"][()]
            places = {"cell": np.arange(len(cells)), **{axis: places[axis][cells].mean(axis=1) for axis in "xyz"}}
        return along, {name: (along, values, {"units": "m"} if name in "xyz" else {})
                       for name, values in places.items()}


def frame(columns: dict[str, np.ndarray], units: dict[str, str] | None = None) -> "pandas.DataFrame":
    """Columns as a frame of pandas with their units."""
    whole = {name: values.astype(np.int64) if name in WHOLE else values for name, values in columns.items()}
    table = need("pandas", "python3-pandas").DataFrame(whole)
    table.attrs["units"] = {name: units[name] if units else unit_of(name) for name in columns}
    return table


def open(folder: Path) -> Results:  # as the module's function: udar.open
    """The results of a run in its folder, finished or not; raises UserError if the folder is none of a run."""
    return Results(folder)
