"""A drawing of the case with its dimensions, as SVG: a beam from the side, other structures in space."""
import html

import numpy as np

from ..curves import with_unit
from .faces import support_faces

WIDTH, LEFT, RIGHT = 1000.0, 80.0, 130.0
MOST_PLACES = 9          # places between which lengths are written
MOST_DRAWN = 60          # supports that are drawn as such
MOST_EDGES = 16_000
LABEL = 8.0              # room for a character
TURN, LIFT = np.radians(30.0), np.radians(22.0)  # of the view in space


class Drawing:
    """Elements of an SVG; all text is escaped."""

    def __init__(self):
        self.parts = []

    def line(self, x1, y1, x2, y2, kind):
        self.parts.append(f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>')

    def lines(self, ends, kind):
        """Many lines at once; `ends` has two points for each."""
        path = "".join(f"M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}" for (x1, y1), (x2, y2) in ends)
        self.parts.append(f'<path class="{kind}" fill="none" d="{path}"/>')

    def shape(self, points, kind):
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.parts.append(f'<polygon class="{kind}" points="{corners}"/>')

    def dot(self, x, y, kind, radius=4.0):
        self.parts.append(f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}"/>')

    def text(self, x, y, words, anchor="middle", kind="word"):
        self.parts.append(f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
                          f'{html.escape(str(words))}</text>')

    def arrow(self, x1, y1, x2, y2, kind="force"):
        self.parts.append(f'<line class="{kind}" marker-end="url(#tip)" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" '
                          f'y2="{y2:.1f}"/>')

    def measure(self, x1, y1, x2, y2, words):
        """A length between two points, its words beside the middle."""
        self.parts.append(f'<line class="measure" marker-start="url(#end)" marker-end="url(#end)" x1="{x1:.1f}" '
                          f'y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>')
        if x1 == x2:
            self.text(x1 + 7.0, 0.5 * (y1 + y2) + 5.0, words, "start")
        else:
            self.text(0.5 * (x1 + x2), 0.5 * (y1 + y2) - 5.0, words)

    def svg(self, height, title):
        return (f'<svg class="sketch" viewBox="0 0 {WIDTH:.0f} {height:.0f}" role="img" '
                f'aria-label="{html.escape(title)}"><defs>'
                '<marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto">'
                '<path d="M0 0L10 5L0 10z"/></marker>'
                '<marker id="end" viewBox="0 0 10 10" refX="5" refY="5" markerWidth="7" markerHeight="7">'
                '<path d="M2 9L8 1" stroke="#444" fill="none"/></marker></defs>' + "".join(self.parts) + "</svg>")


def numbers(options, key):
    found = []
    for word in str(options.get(key, "")).replace(";", ",").split(","):
        try:
            found.append(float(word))
        except ValueError:
            continue
    return found


class BeamSketch:
    """A beam from the side: true along x, out of scale upwards."""

    BEAM = 96.0  # its height in the drawing

    def __init__(self, run, load_ways):
        """`load_ways`: of each load 1 if it pushes up, from below, -1 if down."""
        self.run, self.load_ways, self.drawing = run, load_ways, Drawing()
        self.begin, self.end = float(run.x.min()), float(run.x.max())
        self.axis = numbers(run.options, "initial_height")[:1] or [0.0]
        self.gaps = [self.axis[0] - support.height for support in run.supports
                     if support.striker is None and support.side > 0 and np.isfinite(support.height)] or [0.0]
        self.foot = 0.0
        self.top = self.BEAM + (46.0 if max(self.gaps) > 0.0 else 5.0)

    def at(self, x):
        return LEFT + (WIDTH - LEFT - RIGHT) * (x - self.begin) / (self.end - self.begin)

    def draw(self):
        for k, support in enumerate(self.run.supports):
            if support.striker is not None:
                self.draw_striker(support)
            elif support.is_floor:
                self.draw_floor(support)
            elif len(self.run.supports) <= MOST_DRAWN or k % (len(self.run.supports) // MOST_DRAWN + 1) == 0:
                self.draw_support(support)
        self.drawing.line(self.at(self.begin), self.BEAM, self.at(self.end), self.BEAM, "beam")
        for end, x, way in (("left", self.begin, -1.0), ("right", self.end, 1.0)):
            self.draw_end(self.run.options.get(f"beam_{end}_end", "free"), self.at(x), way)
        self.draw_loads()
        self.draw_gauges()
        if max(self.gaps) > 0.0:
            least, most = (with_unit(gap(self.gaps), "m", 3) for gap in (min, max))
            x = WIDTH - RIGHT + 22.0
            self.drawing.line(self.at(self.end), self.BEAM, x + 6.0, self.BEAM, "thin")
            self.drawing.line(x - 6.0, self.top, x + 6.0, self.top, "thin")
            self.drawing.measure(x, self.BEAM, x, self.top, most if least == most else f"from {least}")
            if least != most:
                self.drawing.text(x + 7.0, 0.5 * (self.BEAM + self.top) + 22.0, f"to {most}", "start")
        self.draw_lengths()
        return self.drawing.svg(self.foot + 20.0, "the beam with its supports")

    def draw_support(self, support):
        x, way = self.at(support.position), 1.0 if support.side > 0 else -1.0
        top = self.top if way > 0 else self.BEAM - 22.0
        if support.high > support.low:
            a, b = self.at(support.low), self.at(support.high)
            self.drawing.shape([(a, top), (b, top), (b, top + 18.0 * way), (a, top + 18.0 * way)], "support")
        else:
            self.drawing.shape([(x, top), (x + 9.0, top + 18.0 * way), (x - 9.0, top + 18.0 * way)], "support")
        if way < 0:
            words = f"stop, {with_unit(support.height - self.axis[0], 'm')} above"
            beside = (x + 14.0, "start") if x < 0.5 * WIDTH else (x - 14.0, "end")
            self.drawing.text(beside[0], top - 7.0, words, beside[1])

    def draw_floor(self, support):
        top = self.top if support.side > 0 else self.BEAM - 40.0
        way = 1.0 if support.side > 0 else -1.0
        a, b = self.at(self.begin) - 20.0, self.at(self.end) + 20.0
        self.drawing.shape([(a, top), (b, top), (b, top + 12.0 * way), (a, top + 12.0 * way)], "support")

    def draw_striker(self, support):
        x, options = self.at(support.position), self.run.options
        way = 1.0 if support.side > 0 else -1.0
        base = self.BEAM - 24.0 * way

        def of(key, unit):
            values = numbers(options, key)
            return f"{values[min(support.striker, len(values) - 1)]:g} {unit}" if values else ""

        self.drawing.shape([(x - 16.0, base), (x + 16.0, base), (x + 16.0, base - 24.0 * way),
                            (x - 16.0, base - 24.0 * way)], "striker")
        self.drawing.arrow(x, base, x, self.BEAM - 5.0 * way)
        words = ", ".join(word for word in (of("striker_mass", "kg"), of("striker_velocity", "m/s")) if word)
        self.drawing.text(x + 24.0, base - 10.0 * way + 5.0, words, "start")

    def draw_end(self, kind, x, way):
        if kind == "clamped":
            self.drawing.line(x, self.BEAM - 26.0, x, self.BEAM + 26.0, "wall")
            for k in range(6):
                y = self.BEAM - 24.0 + 10.0 * k
                self.drawing.line(x, y, x + 9.0 * way, y + 7.0, "thin")
        elif kind == "pinned":
            self.drawing.shape([(x, self.BEAM), (x + 9.0, self.BEAM + 17.0), (x - 9.0, self.BEAM + 17.0)], "pin")
        if kind != "free":
            self.drawing.text(x, self.BEAM - 34.0, kind, "start" if way < 0 else "end", "small")

    def draw_loads(self):
        options = self.run.options
        for x, way in zip(numbers(options, "load_position")[:20], self.load_ways):
            stops = [self.at(support.position) for support in self.run.supports if support.side < 0]
            far = 66.0 if way < 0.0 and any(abs(stop - self.at(x)) < 90.0 for stop in stops) else 46.0
            self.drawing.arrow(self.at(x), self.BEAM + far * way, self.at(x), self.BEAM + 5.0 * way)
            self.drawing.text(self.at(x) + 8.0, self.BEAM + (far - 8.0) * way, "load", "start")
        if "load_axles" in options:
            for k in range(4):
                x = LEFT + 60.0 + 26.0 * k
                self.drawing.arrow(x, self.BEAM - 44.0, x, self.BEAM - 4.0)
            speed = numbers(options, "load_axles_speed")
            words = f"axles, {with_unit(speed[0], 'm/s')}" if speed else "axles"
            self.drawing.text(LEFT + 152.0, self.BEAM - 36.0, words, "start")
            self.drawing.arrow(LEFT + 152.0, self.BEAM - 22.0, LEFT + 205.0, self.BEAM - 22.0)

    def draw_gauges(self):
        last = -np.inf
        for number, place in enumerate(self.run.gauge_at):
            if len(self.run.x):
                x = self.at(place[0])
                self.drawing.dot(x, self.BEAM, "gauge")
                if x - last > 26.0:
                    self.drawing.text(x + 5.0, self.BEAM - 10.0, f"g{number}", "start", "mark")
                    last = x

    def draw_lengths(self):
        places = np.unique([self.begin, self.end, *(support.position for support in self.run.supports
                                                    if not support.is_floor)])
        level = self.top + 44.0
        if 2 < len(places) <= MOST_PLACES:
            for a, b in zip(places[:-1], places[1:]):
                words = with_unit(b - a, "m")
                room = self.at(b) - self.at(a)
                self.drawing.measure(self.at(a), level, self.at(b), level, words if len(words) * LABEL < room else "")
            level += 28.0
        elif len(places) > MOST_PLACES:
            count = sum(support.striker is None and not support.is_floor for support in self.run.supports)
            self.drawing.text(0.5 * WIDTH, level, f"{count} supports from x = {with_unit(places[1], 'm')} to "
                                                  f"{with_unit(places[-2], 'm')}")
            level += 28.0
        self.foot = level
        for x in (self.begin, self.end):
            self.drawing.line(self.at(x), self.BEAM + 6.0, self.at(x), level + 6.0, "faint")
        self.drawing.measure(self.at(self.begin), level, self.at(self.end), level,
                             with_unit(self.end - self.begin, "m"))


class SpaceSketch:
    """A structure in space, seen from above and the side, with the size of the box around it."""

    def __init__(self, run, space):
        self.run, self.space, self.drawing = run, space, Drawing()
        self.faces = support_faces(run)
        self.low, self.high = run.place.min(axis=0), run.place.max(axis=0)
        seen = np.concatenate([self.flat(run.place), *(self.flat(face) for _, face in self.faces),
                               self.flat(self.corners())])
        self.left, self.bottom = seen.min(axis=0)
        span = np.maximum(seen.max(axis=0) - seen.min(axis=0), 1e-9)
        self.scale = min((WIDTH - 280.0) / span[0], 330.0 / span[1])
        self.shift = 0.5 * (WIDTH - self.scale * span[0])
        self.height = self.scale * span[1] + 90.0

    def corners(self):
        return np.array([[x, y, z] for x in (self.low[0], self.high[0]) for y in (self.low[1], self.high[1])
                         for z in (self.low[2], self.high[2])])

    @staticmethod
    def flat(points):
        x, y, z = np.asarray(points, float).T
        return np.column_stack([x * np.cos(TURN) + z * np.sin(TURN),
                                y * np.cos(LIFT) + (x * np.sin(TURN) - z * np.cos(TURN)) * np.sin(LIFT)])

    def at(self, points):
        flat = self.flat(np.atleast_2d(points))
        return np.column_stack([self.shift + self.scale * (flat[:, 0] - self.left),
                                self.height - 45.0 - self.scale * (flat[:, 1] - self.bottom)])

    def draw(self):
        for _, face in self.faces:
            if len(face) > 2:
                self.drawing.shape(self.at(face), "support")
            else:
                (x1, y1), (x2, y2) = self.at(face)
                self.drawing.line(x1, y1, x2, y2, "wall")
        edges = self.space["edges"] if self.space is not None else np.empty((0, 2), int)
        if len(edges):
            self.drawing.lines(self.at(self.space["place"])[edges], "member" if len(edges) < 600 else "member fine")
        else:
            place = self.run.place if self.space is None else self.space["place"]
            dots = self.at(place[::len(place) // MOST_EDGES + 1])
            self.drawing.lines(np.stack([dots, dots + [1.5, 0.0]], axis=1), "member")
        for number, place in enumerate(self.run.gauge_at):
            x, y = self.at(place)[0]
            self.drawing.dot(x, y, "gauge", 5.0)
            self.drawing.text(x + 8.0, y - 6.0, f"g{number}", "start", "mark")
        self.draw_box()
        return self.drawing.svg(self.height, "the structure in space")

    def draw_box(self):
        """Lengths along those edges of the box that nothing is in front of."""
        a, b = self.low, self.high
        for axis, begin, end, anchor in ((0, (a[0], a[1], b[2]), (b[0], a[1], b[2]), "start"),
                                         (2, (a[0], a[1], a[2]), (a[0], a[1], b[2]), "end"),
                                         (1, (a[0], a[1], a[2]), (a[0], b[1], a[2]), "end")):
            length = b[axis] - a[axis]
            if length < 1e-6 * (b - a).max():
                continue
            (x1, y1), (x2, y2) = self.at([begin, end])
            away = (-16.0, 0.0) if axis == 1 else (0.0, 16.0)
            x1, x2, y1, y2 = x1 + away[0], x2 + away[0], y1 + away[1], y2 + away[1]
            self.drawing.line(x1, y1, x2, y2, "measure")
            words = f"{'xyz'[axis]}: {with_unit(length, 'm')}"
            self.drawing.text(0.5 * (x1 + x2) + 0.5 * away[0] + (8.0, 0.0, -8.0)[axis],
                              0.5 * (y1 + y2) + 1.1 * away[1], words, anchor)


def load_ways(text):
    """Of each load 1 if its largest force pushes up, else -1: tables, each behind the number of its rows."""
    try:
        values = [float(word) for word in text.split() if word != "none"]
    except ValueError:
        return [-1.0] * 20
    ways = []
    while values:
        count = int(values[0])
        table, values = values[1:1 + count], values[1 + count:]
        ways.append(1.0 if max(table, key=abs, default=0.0) > 0.0 else -1.0)
    return ways


def sketch_of(sheet):
    """The drawing of a run, or none where the places of its nodes are not known."""
    run = sheet.run
    if not len(run.x):
        return ""
    if run.along_line:
        return BeamSketch(run, load_ways(sheet.parameters.get("loads, forces [N]", ""))).draw()
    return SpaceSketch(run, sheet.space).draw()
