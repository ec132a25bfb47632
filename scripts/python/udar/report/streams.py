"""Tables of any length, read a piece at a time: what is kept of them does not grow with the run."""
import itertools

import numpy as np

from ..tools import UserError, first_line

BLOCK_ROWS = 1 << 14
BLOCK_BYTES = 16_000_000


class CsvTable:
    """A table of a CSV file; a last line without its newline is a row still being written and left out."""

    def __init__(self, path):
        self.path = path
        if not path.is_file():
            raise UserError(f"there is no {path.name}")
        with open(path, "rb") as file:
            header = file.readline().decode("utf-8").strip().split(",")
            self.rows = sum(block.count(b"\n") for block in iter(lambda: file.read(1 << 20), b""))
        self.has_words = "event" in header  # of rests.csv, which other files have as a number
        self.names = ["release" if name == "event" else name for name in header]

    def __len__(self):
        return self.rows

    def blocks(self, names, rows):
        """Arrays of at most `rows` rows, a column for each name."""
        missing = [name for name in names if name not in self.names]
        if missing:
            raise UserError(f"{self.path.name}: the first line has no column '{missing[0]}'")
        columns = [self.names.index(name) for name in names]
        with open(self.path, encoding="utf-8") as file:
            file.readline()
            for _ in range(0, self.rows, rows):
                lines = [line for line in itertools.islice(file, rows) if line.endswith("\n")]
                try:
                    yield np.loadtxt(self._numbers(lines), delimiter=",", ndmin=2, comments=None, usecols=columns)
                except ValueError as error:
                    raise UserError(f"{self.path.name}: {first_line(error)}") from None

    def _numbers(self, lines):
        if not self.has_words:
            return lines
        return [line.replace("release", "1").replace("rest", "0") for line in lines]


class RecordTable:
    """A table of an HDF5 file: compound records."""

    def __init__(self, records):
        self.records, self.names = records, records.dtype.names

    def __len__(self):
        return len(self.records)

    def blocks(self, names, rows):
        for begin in range(0, len(self), rows):
            records = self.records[begin:begin + rows]
            yield np.column_stack([records[name].astype(float) for name in names])


class WideTable:
    """A dataset with a column for each support; columns are named by prefix and number."""

    def __init__(self, time, values, prefix):
        self.time, self.values, self.prefix = time, values, prefix
        self.names = ["time", *(f"{prefix}{k}" for k in range(values.shape[1]))]

    def __len__(self):
        return min(len(self.time), len(self.values))

    def blocks(self, names, rows):
        columns = [int(name.removeprefix(self.prefix)) for name in names if name != "time"]
        for begin in range(0, len(self), rows):
            end = min(begin + rows, len(self))
            yield np.column_stack([self.time[begin:end], self.values[begin:end][:, columns]])


class SummedTable:
    """A table with one more column, `sum`, of those of a list."""

    def __init__(self, table, summed):
        self.table, self.summed = table, summed

    def __len__(self):
        return len(self.table)

    def blocks(self, names, rows):
        own = [name for name in names if name != "sum"]
        for values in self.table.blocks([*own, *self.summed], max(1, rows // len(self.summed))):
            total = values[:, len(own):].sum(axis=1)
            chosen = {name: column for name, column in zip(own, values.T)}
            yield np.column_stack([total if name == "sum" else chosen[name] for name in names])


def peak_rows(values, width):
    """Rows at which a column of `values` is least or greatest among each `width` successive ones."""
    rows = len(values)
    if width < 3:
        return np.arange(rows)
    filled = np.where(np.isfinite(values), values, 0.0)
    short = -rows % width
    if short:
        filled = np.concatenate([filled, np.repeat(filled[-1:], short, axis=0)])
    parts = filled.reshape(-1, width, values.shape[1])
    start = np.arange(len(parts))[:, None] * width
    kept = np.concatenate([start + parts.argmin(axis=1), start + parts.argmax(axis=1)], axis=None)
    return np.unique(np.minimum(kept, rows - 1))


def thin_table(table, groups, parts):
    """For each group of columns of a table the rows that a picture of `parts` pixels across needs, time first.

    A row is kept where a column of the group is least or greatest among the rows of its pixel, and the first and the
    last, so that no peak is lost. Returns the groups and how many rows are behind a pixel.
    """
    names = list(dict.fromkeys(name for group in groups for name in group))
    chosen = [[names.index(name) for name in group] for group in groups]
    width = max(1, len(table) // parts)
    block = width * max(1, BLOCK_ROWS // width)
    kept = [[] for _ in groups]
    last = None
    for values in table.blocks(["time", *names], block):
        if not len(values):
            continue
        for rows, columns in zip(kept, chosen):
            of_group = values[:, [0, *(1 + column for column in columns)]]
            at = peak_rows(of_group[:, 1:], width)
            rows.append(of_group[at if last is not None else np.union1d([0], at)])
        last = values[-1]
    for rows, columns in zip(kept, chosen):
        end = None if last is None else last[[0, *(1 + column for column in columns)]]
        if rows and rows[-1][-1, 0] != end[0]:
            rows.append(end[None])
    return [np.concatenate(rows) if rows else np.empty((0, 1 + len(group)))
            for rows, group in zip(kept, groups)], width


def row_blocks(dataset, rows):
    """(begin, values) of a dataset, rows of it in pieces of some megabytes."""
    each = max(1, int(BLOCK_BYTES / max(1, dataset[:1].nbytes)))
    for begin in range(0, rows, each):
        yield begin, dataset[begin:min(begin + each, rows)]
