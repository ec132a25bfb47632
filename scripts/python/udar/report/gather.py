"""All that a report shows of one run. What cannot be read is left out and said in a remark."""
import dataclasses
import pathlib

import h5py
import numpy as np

from ..curves import with_unit
from ..files import read_options, read_summary
from ..palette import ENERGY_LINES, SELDOM
from ..results import Run, Support, read_run
from ..tools import UserError, first_line
from . import events, fields
from .spectra import gather_spectra
from .streams import CsvTable, SummedTable, WideTable, thin_table

PARTS = 2000             # of a curve: of each the least and the greatest value are kept
MOST_FORCES = 7          # supports whose forces are drawn; of more the largest, and the sum of all
MANY_SUPPORTS = 20       # of so many pauses between touches are told as far as a screen shows them
TABLES = ("gauges.csv", "energy.csv", "contact.csv", "impacts.csv", "summary.json", "restart.h5")
FAULTS = (UserError, OSError, KeyError, ValueError, TypeError, IndexError, RuntimeError, UnicodeDecodeError)


@dataclasses.dataclass
class Sheet:
    """One run as the report has it; a part that there is nothing of is None."""
    run: Run
    parameters: dict = dataclasses.field(default_factory=dict)
    versions: dict = dataclasses.field(default_factory=dict)
    mass: float = None
    remarks: list = dataclasses.field(default_factory=list)
    gauges: list = dataclasses.field(default_factory=list)  # of each gauge a table, or None
    gauge_width: int = 1
    energy: dict = None
    begin: float = 0.0
    end: float = 0.0
    forces: dict = None
    contact: dict = None
    strikers: dict = None
    first_impacts: dict = None
    line: dict = None
    space: dict = None
    envelope: list = dataclasses.field(default_factory=list)
    spectra: dict = None

    @property
    def touched(self):
        """From the first to the last contact; None without any."""
        known = [self.run.summary.get(f"{which}_contact_time") for which in ("first", "last")]
        return tuple(known) if None not in known else None


def options_of_restart(folder):
    """Of a run whose results cannot be read, from its restart file; none where that is not readable either."""
    try:
        with h5py.File(folder / "restart.h5", "r") as file:
            text = bytes(file["texts/options"][()]).decode("utf-8", "replace")
    except FAULTS:
        return {}
    words = [line.split(None, 1) for line in text.replace("\0", "\n").splitlines() if line.startswith("-")]
    return {word[0][1:]: word[1].strip() if len(word) > 1 else "" for word in words}


def bare_run(folder):
    """A run of which no results.h5 can be read: what its tables and its restart file tell."""
    options = options_of_restart(folder)
    supports, gauges = [], 0
    for name, mark in (("contact.csv", "force_"), ("gauges.csv", "mass_")):
        if (folder / name).is_file():
            count = sum(column.startswith(mark) for column in CsvTable(folder / name).names)
            if mark == "force_":
                supports = [Support(f"support {k}", 0.0, 0.0, np.nan, 0.0, 1.0, False, np.zeros(1), np.zeros(1))
                            for k in range(count)]
            else:
                gauges = count
    summary = read_summary(folder / "summary.json")
    return Run(folder=folder, filter_frequency=np.nan, options=options, summary=summary, elements=0, x=np.zeros(0),
               place=np.zeros((0, 3)), gauge_node=np.full(gauges, -1), supports=supports, gauges={}, strikers={},
               energy={}, impacts={}, rests={}, finished=bool(summary.get("completed", False)), structure="unknown",
               gauge_names=[""] * gauges)


def open_results(folder):
    """(run, its open results.h5 or None, remarks)."""
    if not folder.is_dir():
        raise UserError(f"{folder}: no such folder")
    if not (folder / "results.h5").is_file() and not any((folder / name).is_file() for name in TABLES):
        raise UserError(f"{folder}: not a run folder of udar, it has neither results.h5 nor its tables")
    missing = "no shapes, envelopes and sketch"
    if not (folder / "results.h5").is_file():
        return bare_run(folder), None, [f"there is no results.h5: {missing}"]
    try:
        return read_run(folder, with_fields=False, with_tables=False), h5py.File(folder / "results.h5", "r"), []
    except FAULTS as error:
        return bare_run(folder), None, [f"results.h5 cannot be read ({first_line(error)}): {missing}"]


class Gatherer:
    """Reads the parts of a run one by one."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        run, self.file, remarks = open_results(self.folder)
        self.sheet = Sheet(run, remarks=remarks)

    def attempt(self, what, read, *arguments):
        """What `read` returns, or None and a remark."""
        try:
            return read(*arguments)
        except FAULTS as error:
            self.sheet.remarks.append(f"no {what}: {first_line(error)}")
            return None

    def gather(self, gauges):
        sheet, run = self.sheet, self.sheet.run
        if not run.finished:
            sheet.remarks.insert(0, self.why_unfinished())
        if self.file is not None:
            self.attempt("parameters", self.read_head)
        self.attempt("energies", self.read_energy)
        if len(run.gauge_node):
            self.attempt("curves of gauges", self.read_gauges, gauges)
        if run.supports:
            self.attempt("forces of the supports", self.read_forces)
            self.attempt("contacts", self.read_contacts)
            self.attempt("table of impacts", self.read_first_impacts)
        struck = sum(support.striker is not None for support in run.supports)
        if struck:
            self.attempt("positions of strikers", self.read_strikers, struck)
        if self.file is not None and "fields" in self.file:
            self.attempt("motion of the structure", self.read_motion)
        if self.file is not None:
            self.file.close()
        return sheet

    def why_unfinished(self):
        run = self.sheet.run
        if run.summary:
            return f"stopped early, at t = {with_unit(run.summary.get('end_time', 0.0), 's')}"
        return "not finished: there is no summary.json, so the run is still going on or was killed"

    def read_head(self):
        attributes = self.file["parameters"].attrs if "parameters" in self.file else {}
        self.sheet.parameters = {name: text_of(value) for name, value in attributes.items()}
        self.sheet.versions = {name.removesuffix("_version"): text_of(value)
                               for name, value in self.file.attrs.items() if name.endswith("_version")}
        self.sheet.run.options = self.sheet.run.options or read_options(self.file)
        if "mass" in self.file:
            self.sheet.mass = float(np.sum(self.file["mass"][()]))

    def read_energy(self):
        table = CsvTable(self.folder / "energy.csv")
        names = [name for name, *_ in ENERGY_LINES if name in table.names]
        (rows,), _ = thin_table(table, [[*names, "drift"]], PARTS)
        if not len(rows):
            raise UserError("energy.csv has no rows yet")
        self.sheet.begin, self.sheet.end = rows[0, 0], rows[-1, 0]
        self.sheet.energy = {"t": rows[:, 0], "drift": rows[:, -1],
                             "parts": {name: rows[:, 1 + k] for k, name in enumerate(names)
                                       if name not in SELDOM or np.any(rows[:, 1 + k])}}

    def read_gauges(self, wanted):
        table = CsvTable(self.folder / "gauges.csv")
        shown = [gauge for gauge in wanted if gauge < len(self.sheet.run.gauge_node)]
        tables, self.sheet.gauge_width = thin_table(
            table, [[f"{kind}_{gauge}" for kind in ("line", "mass", "velocity")] for gauge in shown], PARTS)
        self.sheet.gauges = [{"gauge": gauge, "t": rows[:, 0], "line": rows[:, 1], "mass": rows[:, 2],
                              "velocity": rows[:, 3]} for gauge, rows in zip(shown, tables)]
        self.sheet.spectra = self.attempt("spectra", self.read_spectra, table, shown)

    def read_spectra(self, table, shown):
        found = gather_spectra(table, [f"velocity_{gauge}" for gauge in shown])
        if found is None:
            return None
        frequency, amplitude, pieces = found
        return {"frequency": frequency, "pieces": pieces,
                "amplitude": [{"gauge": gauge, "values": values} for gauge, values in zip(shown, amplitude)]}

    def force_table(self, prefix):
        """(table, columns): forces or impulses of each support, or of all together."""
        table = CsvTable(self.folder / "contact.csv")
        if prefix not in table.names:
            return table, [name for name in table.names if name.startswith(f"{prefix}_")]
        if self.file is not None and f"supports/{prefix}" in self.file:
            wide = WideTable(self.file["contact"]["time"], self.file[f"supports/{prefix}"], f"{prefix}_")
            return wide, wide.names[1:]
        return table, [prefix]

    def read_forces(self):
        run = self.sheet.run
        table, columns = self.force_table("force")
        together = columns == ["force"]
        names = ["all supports together"] if together else [run.supports[k].name for k in range(len(columns))]
        shown = list(range(len(columns)))
        if len(columns) > MOST_FORCES:
            peaks = np.abs(np.array(run.summary.get("peak_support_force") or np.zeros(len(columns)), float))
            shown = sorted(np.argsort(-peaks, kind="stable")[:MOST_FORCES - 1])
            table = SummedTable(table, columns)
        wanted = [columns[k] for k in shown] + (["sum"] if len(columns) > MOST_FORCES else [])
        (rows,), _ = thin_table(table, [wanted], PARTS)
        labels = [names[k] for k in shown] + ([f"all {len(columns)} supports"] if len(columns) > MOST_FORCES else [])
        window = run.summary.get("force_window")
        if window is None and self.file is not None and "supports" in self.file:
            window = float(np.ravel(self.file["supports"].attrs.get("force_window", np.nan))[0])
        self.sheet.forces = {"t": rows[:, 0], "window": window,
                             "curves": [{"label": label, "values": values}
                                        for label, values in zip(labels, rows[:, 1:].T)]}

    def read_contacts(self):
        sheet, run = self.sheet, self.sheet.run
        x = run.x if len(run.x) else np.array([0.0, 1.0])
        grid = events.Grid.over(sheet.begin, sheet.end, x)
        hits, stays = (events.table_of(self.file, self.folder, name, bool(run.summary))
                       for name in ("impacts", "rests"))
        impacts, cell, hit, count = events.gather_impacts(hits, grid)
        rests, bore = events.gather_rests(stays, grid)
        table, columns = self.force_table("impulse")
        pause = self.shortest_pause(len(table), len(columns))
        spans = events.gather_spans(table, columns, pause)
        together = columns == ["impulse"]
        told = np.isin(spans[:, 0], np.union1d(hit, bore)) & (not together)
        sheet.contact = {"impacts": impacts, "cell": cell, "rests": rests, "count": count, "together": together,
                         "spans": dict(zip(("support", "t0", "t1", "impulse"), spans[~told].T)),
                         "all_spans": spans, "pause": pause}

    def shortest_pause(self, rows, supports):
        """Pauses between touches that a screen cannot show, where there may be more touches than can be kept [s]."""
        length = self.sheet.end - self.sheet.begin
        if supports > MANY_SUPPORTS:
            return length / PARTS
        return length / events.MOST_MARKS if rows > events.MOST_MARKS else 0.0

    def read_strikers(self, count):
        names = [f"position_{k}" for k in range(count)]
        (rows,), _ = thin_table(CsvTable(self.folder / "strikers.csv"), [names], PARTS)
        self.sheet.strikers = {"t": rows[:, 0], "positions": list(rows[:, 1:].T)}

    def read_first_impacts(self):
        names = ["time", "node", "x", "support", "velocity_before", "velocity_after", "impulse", "energy_loss"]
        csv = self.folder / "impacts.csv"
        table = CsvTable(csv) if csv.exists() else events.table_of(self.file, self.folder, "impacts", True)
        if "velocity_before" not in table.names:
            raise UserError("the run has them merged alone")
        rows = next(iter(table.blocks(names, events.FIRST)), np.empty((0, len(names))))
        if len(rows):
            self.sheet.first_impacts = dict(zip(names, rows.T))

    def read_motion(self):
        sheet, run, file = self.sheet, self.sheet.run, self.file
        if run.along_line:
            sheet.line = self.attempt("motion of the beam", fields.gather_line, file, run, sheet.touched)
            sheet.envelope = self.attempt("envelopes", fields.gather_envelope, file, run) or []
        else:
            sheet.space = fields.gather_space(file, run, sheet.touched)


def text_of(value):
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
