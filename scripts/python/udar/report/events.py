"""Who touched what and when: impacts, masses at rest, spans in which a support pressed; of many what a screen shows."""
import dataclasses

import numpy as np

from .streams import CsvTable, RecordTable

MOST_MARKS = 20_000      # impacts, rests or spans that are kept one by one
COLUMNS, ROWS = 1200, 250  # cells of time and of x that more of them are counted in
BLOCK = 1 << 18
FIRST = 40               # impacts and touches in a table


@dataclasses.dataclass
class Grid:
    """Cells of time and place."""
    begin: float
    end: float
    x_edges: np.ndarray

    @classmethod
    def over(cls, begin, end, x):
        margin = 1e-9 * (np.ptp(x) or 1.0)
        return cls(begin, end if end > begin else begin + 1.0,
                   np.linspace(x.min() - margin, x.max() + margin, min(len(x), ROWS) + 1))

    @property
    def size(self):
        return (self.end - self.begin) / COLUMNS, float(self.x_edges[1] - self.x_edges[0])

    @property
    def rows(self):
        return len(self.x_edges) - 1

    def column(self, time):
        return np.clip((np.asarray(time) - self.begin) / self.size[0], 0, COLUMNS - 1).astype(int)

    def row(self, x):
        return np.clip(np.searchsorted(self.x_edges, x, side="right") - 1, 0, self.rows - 1)

    def time_of(self, column):
        return self.begin + column * self.size[0]

    def x_of(self, row):
        return 0.5 * (self.x_edges[row] + self.x_edges[np.asarray(row) + 1])


def table_of(file, folder, name, ended):
    """Impacts, or in their place merged ones, or rests: of results.h5 once the run has ended, before that of the CSV
    file, which has more unless there were too many for it."""
    if name == "impacts" and not (folder / "impacts.csv").exists() and (folder / "impacts_merged.csv").exists():
        name = "impacts_merged"
    csv = folder / f"{name}.csv"
    records = RecordTable(file[name]) if file is not None and name in file else None
    if records is not None and (ended or not csv.exists()):
        return records
    rows = CsvTable(csv)
    return records if records is not None and len(records) > len(rows) else rows


def gather_impacts(table, grid):
    """(marks, size of their cells or None, numbers of the supports that were hit, how many impacts); marks have t, x,
    speed, ..."""
    merged = "speed_max" in table.names
    names = ["time", "x", "speed_max" if merged else "velocity_before", "impulse", "support",
             *(["impacts"] if merged else [])]
    if len(table) <= MOST_MARKS:
        rows = np.concatenate([np.empty((0, len(names))), *table.blocks(names, BLOCK)])
        marks = {"t": rows[:, 0], "x": rows[:, 1], "speed": np.abs(rows[:, 2]), "impulse": np.abs(rows[:, 3]),
                 "count": rows[:, 5] if merged else np.ones(len(rows))}
        return marks, None, np.unique(rows[:, 4].astype(int)), int(marks["count"].sum())
    cells = COLUMNS * grid.rows
    speed, impulse, count, supports = np.zeros(cells), np.zeros(cells), np.zeros(cells), set()
    for rows in table.blocks(names, BLOCK):
        cell = grid.row(rows[:, 1]) * COLUMNS + grid.column(rows[:, 0])
        rising = np.argsort(np.abs(rows[:, 2]))
        fastest = np.zeros(cells)
        fastest[cell[rising]] = np.abs(rows[rising, 2])  # of equal cells the last one stays
        np.maximum(speed, fastest, out=speed)
        impulse += np.bincount(cell, np.abs(rows[:, 3]), cells)
        count += np.bincount(cell, rows[:, 5] if merged else None, cells)
        supports |= set(np.unique(rows[:, 4].astype(int)))
    hit = np.flatnonzero(count)
    marks = {"t": grid.time_of(hit % COLUMNS + 0.5), "x": grid.x_of(hit // COLUMNS), "speed": speed[hit],
             "impulse": impulse[hit], "count": count[hit]}
    return marks, grid.size, np.array(sorted(supports), int), int(count.sum())


def pair_rests(rows, still, begin):
    """Intervals (x, from, to) that end in these rows, and who still rests: rows (time, node, x, release)."""
    rows = np.concatenate([still, rows])
    rows = rows[np.lexsort((rows[:, 3], rows[:, 0], rows[:, 1]))]
    time, node, x, release = rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3] > 0
    follows = np.append(False, (node[1:] == node[:-1]) & ~release[:-1])
    ends = np.flatnonzero(release)
    # A release without a rest before it: the mass was resting when this run took over from a restart file.
    since = np.where(follows[ends], time[ends - 1], begin)
    open_ones = ~release & np.append((node[1:] != node[:-1]) | ~release[1:], True)
    return np.column_stack([x[ends], since, time[ends]]), rows[open_ones]


def gather_rests(table, grid):
    """Marks x, t0, t1 of masses at rest, and the numbers of the supports that bore them."""
    many = len(table) > MOST_MARKS
    change = np.zeros((grid.rows, COLUMNS + 1), int) if many else None
    still, found, supports = np.empty((0, 4)), [np.empty((0, 3))], set()

    def add(spans):
        if not many:
            found.append(spans)
            return
        row = grid.row(spans[:, 0])
        np.add.at(change, (row, grid.column(spans[:, 1])), 1)
        np.add.at(change, (row, grid.column(spans[:, 2]) + 1), -1)

    for rows in table.blocks(["time", "node", "x", "release", "support"], BLOCK):
        spans, still = pair_rests(rows[:, :4], still, grid.begin)
        add(spans)
        supports |= set(np.unique(rows[:, 4].astype(int)))
    add(np.column_stack([still[:, 2], still[:, 0], np.full(len(still), grid.end)]))
    if many:
        resting = np.cumsum(change, axis=1) > 0
        edges = np.diff(np.pad(resting.astype(int), ((0, 0), (1, 1))), axis=1)
        row, first = np.nonzero(edges == 1)
        _, after = np.nonzero(edges == -1)
        found.append(np.column_stack([grid.x_of(row), grid.time_of(first), grid.time_of(after)]))
    x, t0, t1 = np.concatenate(found).T
    return {"x": x, "t0": t0, "t1": t1}, np.array(sorted(supports), int)


def gather_spans(table, impulses, least):
    """Spans (support, from, to, impulse) of rows in which a support gave anything, pauses below `least` [s] ignored."""
    spans = [[] for _ in impulses]
    before = None
    for rows in table.blocks(["time", *impulses], max(1, BLOCK // len(impulses))):
        whole = rows if before is None else np.concatenate([before, rows])
        if not len(whole):
            continue
        for own, column in zip(spans, whole[:, 1:].T):
            gave = np.diff(column) != 0.0
            edges = np.flatnonzero(np.diff(np.concatenate([[False], gave, [False]]).astype(int)))
            for first, last in zip(edges[::2], edges[1::2]):
                if own and whole[first, 0] - own[-1][1] <= least:
                    own[-1][1] = whole[last, 0]
                    own[-1][2] += column[last] - column[first]
                else:
                    own.append([whole[first, 0], whole[last, 0], column[last] - column[first]])
        before = whole[-1:]
    return np.array([(number, *span) for number, own in enumerate(spans) for span in own]).reshape(-1, 4)
