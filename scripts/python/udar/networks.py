"""The pictures of a network: the structure in space, and how it deforms. y points up in them."""
import dataclasses

import numpy as np
from matplotlib import cm, colors, pyplot, ticker
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from .curves import prefixed, with_unit
from .files import RunFiles
from .palette import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION
from .shapes import lift_of_held, rigid_motion, round_factor, without_motion
from .style import GREY, SUPPORT_GREY

MOST_PIECES = 12_000     # pieces of members in one panel; finer ones are thinned, of more members some are left out
MOST_NAMES = 20          # gauges whose names can be read beside each other
MOST_DOTS = 300          # junctions that are drawn as dots
PANELS = 4
SCANNED = 120            # rows that are searched for the largest deformations
SCANNED_BYTES = 400e6
ELEVATION, AZIMUTH = 22.0, -62.0  # of the view [degrees]
WIDTH, LABELS = 0.78, 0.14  # of the width of a panel: a structure, labels below it
MANY = 3000              # pieces: they are drawn thinner, those behind paler, and the undeformed ones not at all
DRAWN_DEFORMATION = 0.08  # the largest in a picture, of the structure's size
PLAIN = "#3b4a63"        # of members that are all alike
KINDS = (BLUE, ORANGE, PURPLE, SKY, BLACK)  # of members of different radii; of more they are plain


@dataclasses.dataclass
class Network:
    place: np.ndarray      # of the nodes, x, y, z [m]
    paths: list            # of each member the rows of its nodes, from end to end
    radius: np.ndarray     # of each member [m]
    held: np.ndarray       # rows of nodes that do not move freely
    time: np.ndarray       # of the rows below [s]
    rows: np.ndarray       # displacement of all nodes at some times [m], the first that of the start
    deformation: np.ndarray  # how much of that is no motion of the whole [m]

    @property
    def size(self):
        return float(np.linalg.norm(np.ptp(self.place, axis=0)))

    def pieces(self):
        """Pairs of nodes to draw lines between, and the member of each; not more than can be drawn."""
        every = -(-len(self.paths) // MOST_PIECES)
        members = np.arange(0, len(self.paths), every)
        each = max(1, MOST_PIECES // len(members))
        pairs, owners = [], []
        for member in members:
            path = self.paths[member]
            steps = min(len(path) - 1, each)
            kept = path[np.rint(np.linspace(0, len(path) - 1, steps + 1)).astype(int)]
            pairs.append(np.column_stack([kept[:-1], kept[1:]]))
            owners.append(np.full(steps, member))
        return np.concatenate(pairs), np.concatenate(owners), every


def read_network(run):
    """The network of a run, with the rows that its pictures show."""
    with RunFiles(run.folder).results() as file:
        nodes = len(file["x"])
        place = np.column_stack([file[axis][()] if axis in file else np.zeros(nodes) for axis in "xyz"])
        cells, member = file["cells"][()], file["member"][()]
        first = np.flatnonzero(np.append(True, np.diff(member) != 0))
        paths = [np.append(part[0, 0], part[:, 1]) for part in np.split(cells, first[1:])]
        held = np.flatnonzero(file["held"][()]) if "held" in file else np.empty(0, int)
        time, rows, deformation = read_rows(file, run, place, len(held) > 0)
        return Network(place, paths, file["member_radius"][()][first], held, time, rows, deformation)


def read_rows(file, run, place, is_held):
    """The first row, and of each quarter of the time from the first contact on the row of largest deformation."""
    data, mass = file["fields/displacement_of_line"], file["mass"][()]
    count = min(len(data), len(file["fields/time"]))  # may differ in a cut run
    time = file["fields/time"][:count]
    if not count:
        return time, np.empty((0, *place.shape)), np.empty((0, *place.shape))

    def deformation(row):
        return without_motion(place, row, lift_of_held(file, place) if is_held else rigid_motion(place, row, mass))

    begin = min(run.first_contacts(), default=(time[0], 0))[0]
    begin = begin if begin < time[-1] else time[0]
    after = np.flatnonzero(time >= begin)
    most = int(np.clip(SCANNED_BYTES / max(1, place.nbytes), 2 * PANELS, SCANNED))
    scanned = after[np.unique(np.rint(np.linspace(0, len(after) - 1, min(len(after), most))).astype(int))]
    largest = np.array([np.linalg.norm(deformation(data[row]), axis=1).max() for row in scanned])
    quarter = np.minimum(PANELS * (time[scanned] - begin) / max(time[-1] - begin, 1e-300), PANELS - 1).astype(int)
    chosen = [0]
    for part in range(PANELS):
        there = np.flatnonzero(quarter == part)
        if len(there):
            chosen.append(int(scanned[there[np.argmax(largest[there])]]))
    rows = np.array([data[row] for row in chosen])
    return time[chosen], rows, np.array([deformation(row) for row in rows])


def upright(points):
    """x, y, z with y up as what a picture of matplotlib has: x, z, y."""
    return np.asarray(points)[..., [0, 2, 1]]


class Space:
    """A picture in space with equal axes, y up."""

    def __init__(self, axis, shapes, room):
        """`shapes`: points that must be in it; `room`: around them [m]."""
        self.axis, self.room = axis, room
        points = np.concatenate([np.reshape(shape, (-1, 3)) for shape in shapes])
        self.low, self.high = points.min(axis=0) - room, points.max(axis=0) + room
        axis.set_proj_type("persp", focal_length=0.6)
        axis.patch.set_visible(False)

    def add_supports(self, run, time):
        """Faces of the supports, as far as they are near; says which kinds there are."""
        kinds = set()
        reach = 0.6 * np.linalg.norm(self.high - self.low)
        for number, support in enumerate(run.supports):
            lift = float(run.lift_of(number, time))
            if support.field is not None:
                self.add_field(support)
                kinds.add("support")
                continue
            if support.pair is not None:
                continue
            if support.normal is not None:
                self.add_plane(support, support.height + lift, reach)
                kinds.add("support")
                continue
            z = (max(self.low[2] + 0.5 * self.room, support.box[2, 0]),
                 min(self.high[2] - 0.5 * self.room, support.box[2, 1]))
            face = support.face + lift
            if face.min() > self.high[1] + reach or face.max() < self.low[1] - reach:
                continue
            x = np.array(support.x, float)
            if support.is_floor:
                x[[0, -1]] = self.low[0], self.high[0]
            self.low[1], self.high[1] = min(self.low[1], face.min()), max(self.high[1], face.max())
            kinds.add("floor" if support.is_floor else "support")
            if len(x) == 1:
                self.axis.plot([x[0], x[0]], z, [face[0], face[0]], color=SUPPORT_GREY, linewidth=2.5, zorder=1,
                               clip_on=False)
                continue
            self.add_faces([[(a, z[0], c), (b, z[0], d), (b, z[1], d), (a, z[1], c)]
                            for a, b, c, d in zip(x[:-1], x[1:], face[:-1], face[1:])])
        return kinds

    def add_plane(self, support, height, reach):
        """A rectangle of a plane, as wide as what stands before it or as its box, if that is near."""
        low, high = np.maximum(self.low, support.box[:, 0]), np.minimum(self.high, support.box[:, 1])
        middle = 0.5 * (low + high)
        centre = middle + (height - support.normal @ middle) * support.normal
        if np.linalg.norm(centre - middle) > reach:
            return
        across = np.cross(support.normal, (0.0, 0.0, 1.0) if abs(support.normal[2]) < 0.9 else (1.0, 0.0, 0.0))
        first = across / np.linalg.norm(across)
        second = np.cross(support.normal, first)
        along = [0.5 * (np.abs(axis) @ (high - low)) * axis for axis in (first, second)]
        corners = np.array([centre + a * along[0] + b * along[1] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        self.add_faces([upright(corners)])
        self.low, self.high = np.minimum(self.low, corners.min(axis=0)), np.maximum(self.high, corners.max(axis=0))

    def add_field(self, support):
        """Cells of a height field next to what stands over it, some of them where there are many."""
        x, z, height = support.field
        rows, columns = (self.chosen(axis, max(self.low[k], support.box[k, 0]), min(self.high[k], support.box[k, 1]))
                         for axis, k in ((z, 2), (x, 0)))
        corners = [[np.array([x[i], height[j, i], z[j]]) for i in columns] for j in rows]
        faces = [np.array([a, b, d, c]) for near, far in zip(corners[:-1], corners[1:])
                 for a, b, c, d in zip(near[:-1], near[1:], far[:-1], far[1:])]
        faces = [face for face in faces if np.isfinite(face).all()]
        if faces:
            self.add_faces([upright(face) for face in faces])
            points = np.concatenate(faces)
            self.low, self.high = np.minimum(self.low, points.min(axis=0)), np.maximum(self.high, points.max(axis=0))

    @staticmethod
    def chosen(axis, low, high):
        """Numbers of at most some dozens of places on an axis, what lies between two places and one more each way."""
        last = min(np.searchsorted(axis, high), len(axis) - 1)
        first = min(max(np.searchsorted(axis, low, side="right") - 1, 0), last)
        return np.unique(np.append(np.arange(first, last, (last - first) // 50 + 1), last))

    def add_faces(self, faces):
        self.axis.add_collection3d(Poly3DCollection(faces, facecolor="#c9c9c9", edgecolor=SUPPORT_GREY, alpha=0.45,
                                                    linewidth=0.6, zorder=1, clip_on=False))

    def seen(self, low, high):
        """Corners of the box in the square of the axis."""
        corners = np.array([[x, y, z, 1.0] for x in (low[0], high[0]) for y in (low[2], high[2])
                            for z in (low[1], high[1])])
        projected = corners @ self.axis.get_proj().T
        pixels = self.axis.transData.transform(projected[:, :2] / projected[:, 3:])
        return self.axis.transAxes.inverted().transform(pixels)

    def finish(self, height):
        """`height`: of the square of the axis that there is room for."""
        span = self.high - self.low
        span = np.maximum(span, 0.12 * span.max())  # what is flat still has a box
        middle = 0.5 * (self.low + self.high)
        low, high = middle - 0.5 * span, middle + 0.5 * span
        axis = self.axis
        axis.set_xlim(low[0], high[0])
        axis.set_ylim(high[2], low[2])  # from behind, so that x, y, z is right-handed
        axis.set_zlim(low[1], high[1])
        axis.view_init(elev=ELEVATION, azim=AZIMUTH)
        zoom = 1.0
        for _ in range(3):  # nearer, nearer ends grow more
            axis.set_box_aspect(upright(span), zoom=zoom)
            seen = self.seen(low, high)
            zoom *= np.min([WIDTH, height] / np.ptp(seen, axis=0))
        place = axis.get_position()
        away = (0.5 * (seen.min(axis=0) + seen.max(axis=0)) - 0.5) * [place.width, place.height]
        axis.set_position([place.x0 - away[0] - 0.02 * place.width, place.y0 - away[1], place.width, place.height])
        for which, name, extent in zip((axis.xaxis, axis.yaxis, axis.zaxis), "xzy", upright(span)):
            which.set_major_locator(ticker.MaxNLocator(5 if extent > 0.4 * span.max() else 2))
            which.set_label_text(f"{name} [m]")
            which.set_pane_color((1.0, 1.0, 1.0, 0.0))
            which._axinfo["grid"].update(color="#e6e6e6", linewidth=0.5)
            which.set_tick_params(labelsize=8, pad=0)
            which.label.set_size(9)
            which.labelpad = 7


def panel_ratio(places, room):
    """How high a picture of these places is, over its width."""
    x, y, z = np.ptp(places, axis=0) + 2 * room
    turn, lift = np.radians(-AZIMUTH), np.radians(ELEVATION)
    across = x * np.sin(turn) + z * np.cos(turn)
    upwards = y * np.cos(lift) + (x * np.cos(turn) + z * np.sin(turn)) * np.sin(lift)
    return float(np.clip(WIDTH * 1.15 * upwards / across + LABELS, 0.35, 0.95))


class Sheet:
    """A figure of panels in space below a title and above a legend; matplotlib's own are square and half empty."""

    HEAD, TITLE = 0.75, 0.25  # of the figure, of each panel [inch]

    def __init__(self, width, columns, rows, ratio, foot, side=0.0):
        self.columns, self.side, self.foot = columns, side, foot
        self.slot = (width - side) / columns, (width - side) / columns * ratio + self.TITLE
        self.room = ratio - LABELS
        self.width, self.height = width, self.HEAD + rows * self.slot[1] + foot
        self.figure = pyplot.figure(figsize=(self.width, self.height))

    def panel(self, number, title=""):
        """A square as wide as its place, whatever of it is empty."""
        wide, high = self.slot
        left = number % self.columns * wide
        top = self.height - self.HEAD - number // self.columns * high
        bottom = top - self.TITLE - 0.5 * (high - self.TITLE) - 0.5 * wide
        if title:
            self.figure.text((left + 0.5 * wide) / self.width, top / self.height, title, ha="center", va="top")
        return self.figure.add_axes([left / self.width, bottom / self.height, wide / self.width, wide / self.height],
                                    projection="3d")


def line_widths(network, owners, space, figure_inches):
    """Of tubes about as thick as they are, as far as that can be seen and does not hide others."""
    points_per_metre = 50.0 * figure_inches / np.linalg.norm(space.high - space.low)
    least = 0.25 if len(owners) > MANY else 0.6
    return np.clip(2.0 * network.radius[owners] * points_per_metre, least, 6.0 if len(network.paths) < 300 else 2.0)


def paler_behind(colours, places, pairs):
    """Of many pieces those further away are lost in white, so that the near ones can be seen."""
    if len(pairs) <= MANY:
        return colours
    turn, lift = np.radians(AZIMUTH), np.radians(ELEVATION)
    x, y, z = places[pairs].mean(axis=1).T  # the axis of z is turned round
    near = np.cos(lift) * (np.cos(turn) * x - np.sin(turn) * z) + np.sin(lift) * y
    share = 0.85 * ((near.max() - near) / max(np.ptp(near), 1e-300))[:, None]
    return np.column_stack([colours[:, :3] + share * (1.0 - colours[:, :3]), np.ones(len(colours))])


def draw_members(axis, places, pairs, **style):
    lines = Line3DCollection(upright(places[pairs]), capstyle="round", rasterized=len(pairs) > 2000, clip_on=False,
                             **style)
    axis.add_collection3d(lines)
    return lines


def draw_structure(pen, run, network):
    """Members, supports, held nodes and gauges at the start."""
    places = network.place + (network.rows[0] if len(network.rows) else 0.0)
    start = float(network.time[0]) if len(network.time) else run.begin
    sheet = Sheet(9.5, 1, 1, panel_ratio(places, 0.03 * network.size), 0.75 + 0.3 * bool(run.doubts))
    axis = sheet.panel(0)
    space = Space(axis, [places], 0.03 * network.size)
    kinds = space.add_supports(run, start)
    pairs, owners, every = network.pieces()
    widths = line_widths(network, owners, space, 8.0)
    radii = np.unique(network.radius)
    handles = []
    if 1 < len(radii) <= len(KINDS):
        colours = colors.to_rgba_array([KINDS[k] for k in np.searchsorted(radii, network.radius)])[owners]
        handles += [Line2D([], [], color=KINDS[k], linewidth=3, label=f"members, radius {with_unit(radius, 'm', 3)}")
                    for k, radius in enumerate(radii)]
    else:
        colours = np.tile(colors.to_rgba(PLAIN), (len(pairs), 1))
        handles.append(Line2D([], [], color=PLAIN, linewidth=3, label="members"))
    draw_members(axis, places, pairs, gid="members", colors=paler_behind(colours, places, pairs), linewidths=widths)
    ends = np.unique([[path[0], path[-1]] for path in network.paths])
    if len(ends) <= MOST_DOTS:
        axis.scatter(*upright(places[ends]).T, color=BLACK, s=9, depthshade=False, zorder=4, clip_on=False)
        handles.append(Line2D([], [], linestyle="none", marker=".", color=BLACK, label="junction"))
    if len(network.held):
        axis.scatter(*upright(places[network.held]).T, color=GREEN, s=34, marker="^", depthshade=False, zorder=5,
                     clip_on=False)
        handles.append(Line2D([], [], linestyle="none", marker="^", color=GREEN, label="held"))
    if len(run.gauge_node):
        gauges = upright(run.gauge_at)
        axis.scatter(*gauges.T, color=VERMILLION, s=26, depthshade=False, zorder=6, clip_on=False)
        handles.append(Line2D([], [], linestyle="none", marker="o", color=VERMILLION, label="gauge"))
        for number, at in enumerate(gauges if len(gauges) <= MOST_NAMES else ()):
            axis.text(*at, f"  {number}: {run.gauge_names[number]}" if run.gauge_names[number] else f"  {number}",
                      fontsize=9, color=VERMILLION, zorder=7)
    handles += [Patch(facecolor="#d9d9d9", edgecolor=SUPPORT_GREY, label=kind) for kind in sorted(kinds)]
    space.finish(sheet.room)
    sheet.figure.legend(handles=handles, loc="lower center", ncol=min(4, len(handles)), fontsize=9,
                        bbox_to_anchor=(0.5, 0.3 * bool(run.doubts) / sheet.height))
    headline = f"Network of {len(ends)} junctions and {len(network.paths)} members"
    if every > 1:
        headline += f", one in {every} drawn"
    pen.write(sheet.figure, "structure", headline, [run])


def draw_deformation(pen, run, network):
    """The deformed shape where it is largest in each quarter of the time, against the undeformed one."""
    shown = np.linalg.norm(network.deformation[1:], axis=2)
    peak = shown.max()
    factor = round_factor(DRAWN_DEFORMATION * network.size / peak) if peak > 0.0 else 1
    pairs, owners, every = network.pieces()
    panels = len(shown)
    columns = 1 if panels == 1 else 2
    sheet = Sheet(11.5, columns, -(-panels // columns), panel_ratio(network.place, 0.1 * network.size),
                  0.2 + 0.3 * bool(run.doubts), side=1.1)
    scale, unit = prefixed(peak, "m")
    coloured = cm.ScalarMappable(colors.Normalize(0.0, peak / scale if peak > 0.0 else 1.0), "viridis")
    for panel in range(panels):
        deformation = network.deformation[1 + panel]
        rigid = network.place + network.rows[1 + panel] - deformation
        places = rigid + factor * deformation
        largest = ", the largest" if panels > 1 and shown[panel].max() == peak else ""
        axis = sheet.panel(panel, f"t = {with_unit(network.time[1 + panel], 's')}: up to "
                                  f"{with_unit(shown[panel].max(), 'm', 3)}{largest}")
        space = Space(axis, [rigid, places], 0.02 * network.size)
        space.add_supports(run, network.time[1 + panel])
        widths = line_widths(network, owners, space, 5.0)
        if len(pairs) <= MANY:
            draw_members(axis, rigid, pairs, gid=f"undeformed-{panel}", colors=SUPPORT_GREY, linewidths=0.5, alpha=0.7)
        colours = coloured.to_rgba(shown[panel][pairs].mean(axis=1) / scale)
        draw_members(axis, places, pairs, gid=f"members-{panel}", colors=paler_behind(colours, places, pairs),
                     linewidths=widths)
        space.finish(sheet.room)
    beside = sheet.figure.add_axes([1.0 - 0.95 / sheet.width, 0.2, 0.2 / sheet.width, 0.6])
    bar = sheet.figure.colorbar(coloured, cax=beside, label=f"deformation [{unit}]")
    bar.outline.set_edgecolor(GREY)
    size = f"{factor} times as large" if factor > 1 else "in true size"
    whole = "" if len(network.held) else " from its motion as a whole"
    part = f", one member in {every}" if every > 1 else ""
    pen.write(sheet.figure, "deformation", f"Deformation of the line{whole}, drawn {size}{part}", [run],
              times=(network.time[1], network.time[-1]))
