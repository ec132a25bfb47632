"""The files of a run (docs/output.md): tables by their columns, the summary, the options, units."""
import contextlib
import dataclasses
import json
import pathlib
import re

import h5py
import numpy as np

from .tools import UserError, first_line, read_csv

ENERGIES = ("kinetic", "line_strain", "fictitious_springs", "load_potential", "support_springs", "load_work",
            "support_work", "base_work", "lost_in_impacts", "lost_in_dampers", "radiated", "lost_in_hinges",
            "total")
# Of columns; of others 1.
UNITS = {**dict.fromkeys(ENERGIES, "J"), "energy_loss": "J", "time": "s", "last_time": "s", "x": "m", "x_min": "m",
         "x_max": "m", "mass": "m", "line": "m", "displacement": "m", "position": "m", "velocity": "m/s",
         "velocity_before": "m/s", "velocity_after": "m/s", "speed_max": "m/s", "force": "N", "impulse": "N s",
         "moment_min": "N m", "moment_max": "N m", "shear_min": "N", "shear_max": "N", "stress_max": "Pa"}


def unit_of(column):
    """The unit of a column of a run's tables: `line_2` has that of `line`, which is m; 1 of a number without."""
    return UNITS.get(re.sub(r"^absolute_|_\d+$", "", column), "1")


@dataclasses.dataclass
class Contact:
    """Rows of contact.csv; forces and impulses of each support, or of all together, by row."""
    time: np.ndarray
    masses: np.ndarray
    x_min: np.ndarray
    x_max: np.ndarray
    force: np.ndarray
    impulse: np.ndarray
    window: float     # forces are means over so long [s]; None if not known
    together: bool    # one column for all supports

    def spans(self):
        """Of each column the times, rows of (begin, end), in which it gave anything."""
        return [stretches(self.time, np.append(False, np.diff(column) != 0.0) if len(column) else np.empty(0, bool))
                for column in self.impulse.T]


def stretches(time, holds):
    """Rows (begin, end) of the times over which `holds` is true; a row tells of the time since the one before it."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]]).astype(int)))
    first, last = edges[::2], edges[1::2] - 1
    return np.column_stack([time[np.maximum(first - 1, 0)], time[last]]) if len(first) else np.empty((0, 2))


def text_of(dataset, name, otherwise):
    text = dataset.attrs.get(name, otherwise)
    return text.decode() if isinstance(text, bytes) else str(text)


def read_summary(path):
    """summary.json; empty while the run goes on. One that was stopped also leaves a summary."""
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
        return summary if isinstance(summary, dict) else {}
    except (OSError, ValueError):
        return {}


class RunFiles:
    """The folder of a run. Nothing is read before it is asked for; what cannot be read is a UserError."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.path = self.folder / "results.h5"
        if not self.folder.is_dir():
            raise UserError(f"{folder}: no such folder")
        if not self.path.is_file():
            raise UserError(f"{folder}: not a run folder of udar, it has no results.h5")
        self.summary = read_summary(self.folder / "summary.json")

    @property
    def finished(self):
        """The run has reached its end."""
        return bool(self.summary) and bool(self.summary.get("completed", True))

    @contextlib.contextmanager
    def results(self):
        """results.h5, open for reading."""
        try:
            with h5py.File(self.path, "r") as file:
                yield file
        except (OSError, KeyError, ValueError, TypeError, IndexError, RuntimeError) as error:
            raise UserError(f"{self.path}: cannot be read: {first_line(error)}") from None

    def table(self, name, needed=()):
        """Columns of NAME.csv."""
        return read_csv(self.folder / f"{name}.csv", needed)

    def records(self, file, name, needed):
        """Impacts or rests: from results.h5 once the run has ended, before that from the CSV file, which has more
        unless there were too many for it."""
        csv = self.folder / f"{name}.csv"
        if name in file and (self.summary or not csv.exists() or len(file[name]) > lines_of(csv) - 1):
            records = file[name][()]
            if records.dtype.names is None or any(column not in records.dtype.names for column in needed):
                raise UserError(f"{self.path}: /{name} lacks one of the columns {', '.join(needed)}")
            return {column: records[column] for column in records.dtype.names}
        return self.table(name, [column if column != "release" else "event" for column in needed])

    def impacts(self, file, needed):
        """Impacts, or where a run has them merged alone these, `velocity_before` being their largest speed."""
        if "impacts_merged" not in file or (self.folder / "impacts.csv").exists():
            return self.records(file, "impacts", needed)
        merged = self.records(file, "impacts_merged", ("time", "node", "x", "support", "speed_max", "impulse"))
        return merged | {"velocity_before": merged["speed_max"]}

    def contact(self, file):
        """contact.csv, and with more supports than it has columns for those of results.h5; None without supports."""
        if not (self.folder / "contact.csv").exists():
            return None
        table = self.table("contact", ["time", "masses", "x_min", "x_max"])
        window = np.ravel(file["supports"].attrs.get("force_window", np.nan))[0] if "supports" in file else np.nan
        together = "force" in table
        names = [""] if together else [f"_{k}" for k in range(sum(name.startswith("force_") for name in table))]
        force, impulse = (np.array([table[kind + name] for name in names]).T.reshape(len(table["time"]), len(names))
                          for kind in ("force", "impulse"))
        if together and "supports/force" in file and "supports/impulse" in file:
            rows = min(len(table["time"]), len(file["supports/force"]), len(file["supports/impulse"]))
            force, impulse = file["supports/force"][:rows], file["supports/impulse"][:rows]
            table, together = {name: values[:rows] for name, values in table.items()}, False
        return Contact(table["time"], table["masses"], table["x_min"], table["x_max"], force, impulse,
                       float(window) if np.isfinite(window) else None, together)


def lines_of(path):
    with open(path, "rb") as file:
        return sum(block.count(b"\n") for block in iter(lambda: file.read(1 << 20), b""))


def read_options(file):
    """The options a run had, as text by key without its dash."""
    words = [line.split(None, 1) for line in text_of(file, "options", "").splitlines() if line.startswith("-")]
    return {word[0][1:]: word[1].strip() if len(word) > 1 else "" for word in words}
