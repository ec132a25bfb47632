#!/usr/bin/env python3
# ranks: 1; size: long
"""udar-plot on synthetic run folders in the format of docs/output.md. UDAR_PLOT: the executable."""
import contextlib
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import h5py
import matplotlib.image
import numpy as np

TOOL = os.environ.get("UDAR_PLOT") or str(pathlib.Path(__file__).resolve().parents[2] / "scripts" / "udar-plot.py")
sys.path.insert(0, str(pathlib.Path(TOOL).parent / "python"))
from udar import cli  # noqa: E402, its place is known now

ONE_RUN = ("gauges", "energy", "contacts", "deflection", "impulses", "forces", "envelope")
SEVERAL_RUNS = ("gauges", "energy", "contacts")
GRAVITY, DROP, LENGTH, MASS = 9.81, 1.0, 10.0, 2466.15
IMPACT = [("time", "f8"), ("node", "i8"), ("x", "f8"), ("support", "i8"), ("velocity_before", "f8"),
          ("velocity_after", "f8"), ("impulse", "f8"), ("energy_loss", "f8")]
REST = [("time", "f8"), ("node", "i8"), ("x", "f8"), ("support", "i8"), ("release", "i8")]
ENERGY = ("time", "kinetic", "line_strain", "fictitious_springs", "load_potential", "support_springs", "load_work",
          "support_work", "base_work", "lost_in_impacts", "lost_in_dampers", "radiated",
          "lost_in_hinges", "total", "drift")
BLUE, VERMILLION = (0, 114, 178), (213, 94, 0)


def bounce(time, restitution, gravity):
    """Height and velocity of a ball dropped from DROP on the ground, and the (time, speed) of its impacts."""
    if gravity == 0.0:
        return np.full_like(time, DROP), np.zeros_like(time), []
    height, velocity, impacts = DROP - gravity * time**2 / 2, -gravity * time, []
    at, speed = np.sqrt(2 * DROP / gravity), np.sqrt(2 * DROP * gravity)
    while at < time[-1] and speed > 0.05:
        impacts.append((at, speed))
        speed *= restitution
        later = time - at
        height = np.where(later > 0, speed * later - gravity * later**2 / 2, height)
        velocity = np.where(later > 0, speed - gravity * later, velocity)
        at += 2 * speed / gravity
    stopped = time > at if impacts and speed <= 0.05 else np.zeros(len(time), bool)
    return np.where(stopped, 0.0, height), np.where(stopped, 0.0, velocity), impacts


def write_csv(path, names, rows):
    with open(path, "w", encoding="utf-8") as file:
        file.write(",".join(names) + "\n")
        for row in rows:
            file.write(",".join(value if isinstance(value, str) else f"{value:.17g}" for value in row) + "\n")


def write_run(folder, wf=50.0, nodes=21, supports=((2.0, 0.0), (8.0, 0.0)), gauges=(0.0, 2.0, 5.0, 8.0, 10.0), end=3.0,
              restitution=0.8, gravity=GRAVITY, height=0.0, side=1.0, floor=False, finished=True, field_step=0.01,
              summary=None):
    """A beam whose masses all bounce like balls while the line swings between them: no physics, the right format."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True)
    x = np.linspace(0.0, LENGTH, nodes)
    time = np.arange(0.0, end + 1e-9, 0.002)
    mass, velocity, hits = bounce(time, restitution, gravity)
    swing = 0.15 * np.exp(-time) * np.sin(wf * time / 3) * (time > np.sqrt(2 * DROP / GRAVITY)) * (gravity > 0)
    shape = np.cos(2 * np.pi * x / LENGTH)
    mass, velocity = height + side * mass, side * velocity

    touching = []  # (node, support)
    for number, (position, width) in enumerate(supports):
        near = np.flatnonzero(np.abs(x - position) <= width / 2 + 1e-9)
        touching += [(node, number) for node in (near if len(near) else [np.argmin(np.abs(x - position))])]
    if floor:
        touching = [(node, len(supports)) for node in range(nodes)]
    node_mass = MASS / (nodes - 1)
    impacts = [(at, node, x[node], support, -side * speed, side * restitution * speed,
                side * node_mass * (1 + restitution) * speed, node_mass * (1 - restitution**2) * speed**2 / 2)
               for at, speed in hits for node, support in touching]
    rests = []
    if hits and hits[-1][1] < 1.0:
        at = hits[-1][0]
        rests = [(at + 0.01, node, x[node], support, 0) for node, support in touching]
        rests += [(at + 0.15, touching[0][0], x[touching[0][0]], touching[0][1], 1)] if at + 0.15 < end else []

    kinetic, potential = MASS * velocity**2 / 2, MASS * gravity * np.abs(mass - height)
    start = max(kinetic[0] + potential[0], 1.0)
    lost = start - kinetic - potential if gravity else np.zeros_like(time)
    drift = 1e-12 * np.cumsum(np.sin(37 * time)) / len(time)
    energy = np.column_stack([time, kinetic, 100 * swing**2, 50 * swing**2, potential, 0 * time, 0 * time,
                              0 * time, 0 * time, lost, 0 * time, 0 * time, 0 * time, kinetic + potential,
                              drift])
    gauge_node = np.array([np.argmin(np.abs(x - position)) for position in gauges], dtype=int)
    columns = [time]
    for node in gauge_node:
        columns += [mass, velocity, mass + swing * shape[node]]

    names = [f"{name}_{k}" for k in range(len(gauges)) for name in ("mass", "velocity", "line")]
    write_csv(folder / "gauges.csv", ["time", *names], np.column_stack(columns))
    write_csv(folder / "energy.csv", ENERGY, energy)
    write_csv(folder / "impacts.csv", [name for name, _ in IMPACT], impacts)
    write_csv(folder / "rests.csv", ["time", "node", "x", "support", "event"],
              [(*row[:4], "release" if row[4] else "rest") for row in rests])
    if touching:
        row_time = time[::5]
        given = np.array([[sum(hit[6] for hit in impacts if hit[3] == k and hit[0] < at)
                           for k in range(1 + max(number for _, number in touching))] for at in row_time]) \
            if nodes < 1000 else np.zeros((len(row_time), 1))
        force = np.diff(given, axis=0, prepend=0.0) / 0.01
        hit_since = np.array([any(before <= at < now for at, _ in hits)
                              for before, now in zip(np.append(-1.0, row_time), row_time)])
        edges = x[[min(node for node, _ in touching), max(node for node, _ in touching)]]
        zone = np.where(hit_since[:, None], [len(touching), *edges], [0.0, np.nan, np.nan])
        both = np.stack([force, given], axis=2).reshape(len(row_time), -1)
        names = [f"{name}_{k}" for k in range(given.shape[1]) for name in ("force", "impulse")]
        write_csv(folder / "contact.csv", ["time", "masses", "x_min", "x_max", *names],
                  np.column_stack([row_time, zone, both]))
    if finished:
        text = json.dumps({"impacts": len(impacts), "max_bending_stress_time": 1.25, **(summary or {})})
        (folder / "summary.json").write_text(text, encoding="utf-8")
    field_time = np.arange(0.0, end + 1e-9, field_step)
    with h5py.File(folder / "results.h5", "w") as file:
        file.attrs.update({"udar_version": "test", "options": f"-filter_frequency {wf}\n", "filter_frequency": wf,
                           "elements": nodes - 1, "ranks": 1})
        file["x"] = x
        file["cells"] = np.column_stack([np.arange(nodes - 1), np.arange(1, nodes)])
        file["gauge_node"], file["gauge_position"] = gauge_node, np.array(gauges, dtype=float)
        all_supports = list(supports) + ([(0.0, np.inf)] if floor else [])
        for name, values in (("position", [s[0] for s in all_supports]), ("width", [s[1] for s in all_supports]),
                             ("height", [height] * len(all_supports)), ("side", [side] * len(all_supports)),
                             ("restitution", [restitution] * len(all_supports))):
            file[f"support_{name}"] = np.array(values, dtype=float)
        shown = np.interp(field_time, time, mass)[:, None]
        file["fields/time"] = field_time
        file["fields/mass_position"] = np.broadcast_to(shown, (len(field_time), nodes))
        file["fields/line_position"] = shown + np.interp(field_time, time, swing)[:, None] * shape
        for name, kind in (("mass_velocity", "f8"), ("moment", "f8"), ("resting", "u1")):
            file.create_dataset(f"fields/{name}", shape=(len(field_time), nodes), dtype=kind, chunks=(1, nodes))
        if finished:
            moment = 2e4 * np.sin(np.pi * x / LENGTH)
            for name, values in (("moment", moment), ("shear", np.diff(moment) / np.diff(x))):
                file[f"envelope/{name}_min"], file[f"envelope/{name}_max"] = values - 1e4, values
                for side in ("min", "max"):
                    file[f"envelope/{name}_{side}"].attrs.update(
                        {"units": "N m" if name == "moment" else "N",
                         "where": "points" if name == "moment" else "cells",
                         "label": "bending moment" if name == "moment" else "shear force"})
            file["envelope/stress_max"] = moment / (np.pi * 0.1**3 / 4)
            file["envelope/utilisation_max"] = file["envelope/stress_max"][()] / 2e8
        if touching:
            file.create_group("supports").attrs["force_window"] = 0.01
        file["impacts"] = np.array(impacts, dtype=IMPACT)
        file["rests"] = np.array(rests, dtype=REST)
        file["energy"] = np.array([tuple(row) for row in energy], dtype=[(name, "f8") for name in ENERGY])
    return folder


def write_network(folder, count=(3, 2, 2), elements=4, held=(), rows=9, gauges=("0 0 0", "2 1 1"), turn=0.3, **options):
    """A lattice of 1 m that falls, turns, and hangs down by 1 cm in its middle: no physics, the right format."""
    write_run(folder, gauges=(0.0,) * len(gauges), **options)
    corner = {at: number for number, at in enumerate(np.ndindex(*count))}
    place = [np.array(at, float) for at in corner]
    cells, member = [], []
    for at, number in corner.items():
        for axis in range(3):
            other = corner.get(tuple(np.add(at, np.eye(3, dtype=int)[axis])))
            if other is None:
                continue
            path = [number, *range(len(place), len(place) + elements - 1), other]
            place += [place[number] + (place[other] - place[number]) * i / elements for i in range(1, elements)]
            member += [member[-1] + 1 if member else 0] * elements
            cells += zip(path[:-1], path[1:])
    place = np.array(place)
    time = np.linspace(0.0, 3.0, rows)
    middle = place.mean(axis=0)
    moved = []
    for at in time:
        c, s = np.cos(turn * at), np.sin(turn * at)
        sag = np.zeros_like(place)
        sag[:, 1] = -0.01 * np.sin(np.pi * at / 3.0) * np.exp(-((place - middle)[:, 0])**2)
        moved.append((place + sag - middle) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]).T + middle - place)
        moved[-1][:, 1] -= 0.2 * at
    with h5py.File(folder / "results.h5", "a") as file:
        file.attrs.update({"structure": "network", "elements": len(cells),
                           "options": file.attrs["options"] + "-gauge_junction " + ",".join(gauges) + "\n"})
        for name in ("x", "cells", "gauge_node", "fields", "envelope"):
            del file[name]
        for axis, name in enumerate("xyz"):
            file[name] = place[:, axis]
        file["mass"], file["cells"], file["member"] = np.ones(len(place)), np.array(cells), np.array(member)
        file["member_radius"], file["radius"] = np.full(len(cells), 0.02), np.full(len(place), 0.02)
        file["gauge_node"] = [corner[tuple(map(int, name.split()))] for name in gauges]
        file["fields/time"], file["fields/displacement_of_line"] = time, np.array(moved)
        if held:
            file["held"] = np.isin(np.arange(len(place)), held).astype(int)
    return folder


def drawn_lines(svg):
    """How many lines there are of members, deformed and not, in each panel."""
    groups = re.findall(r'<g id="((?:members|undeformed)[-0-9]*)">(.*?)</g>', svg, re.DOTALL)
    return {name: group.count("<path") for name, group in groups}


def close_to(picture, colour):
    """How many pixels have nearly this colour (0 to 255)."""
    return int((np.abs(picture[:, :, :3] * 255 - np.array(colour)).max(axis=2) < 12).sum())


class PlotTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.here = pathlib.Path(holder.name)

    def run_tool(self, *arguments):
        """In this process: Python's and matplotlib's start takes longer than most pictures."""
        out, err = io.StringIO(), io.StringIO()
        with (contextlib.chdir(self.here), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err),
              unittest.mock.patch("sys.argv", ["udar-plot", *map(str, arguments)]),
              self.assertRaises(SystemExit) as ended):
            cli.run()
        return subprocess.CompletedProcess(arguments, ended.exception.code or 0, out.getvalue(), err.getvalue())

    def draw(self, *arguments):
        """Runs the tool, checks that it printed exactly the files it wrote; returns them by name and what it noted."""
        done = self.run_tool(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("Warning", done.stderr)
        files = [self.here / line for line in done.stdout.splitlines()]
        self.assertTrue(all(file.is_file() for file in files), done.stdout)
        written = [file for folder in {file.parent for file in files} for file in folder.iterdir()]
        self.assertEqual(sorted(files), sorted(written))
        return {file.name: file for file in files}, done.stderr

    def picture(self, file):
        pixels = matplotlib.image.imread(file)
        self.assertGreater(pixels[:, :, :3].std(), 0.02, f"{file} is blank")
        self.assertGreater(len(np.unique((pixels[::2, ::2, :3] * 255).astype(int).reshape(-1, 3), axis=0)), 20)
        return pixels

    def assert_refused(self, expected, *arguments):
        done = self.run_tool(*arguments)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertTrue(done.stderr.startswith("udar-plot: "), done.stderr)
        self.assertIn(expected, done.stderr)


class Program(PlotTest):
    """As a program of its own."""

    def test_pictures_and_errors(self):
        run, environment = write_run(self.here / "run"), {**os.environ, "MPLCONFIGDIR": str(self.here / "mpl")}
        for arguments, code, out in (((run, "--format", "svg"), 0, len(ONE_RUN)), ((run, "--dpi", "0"), 2, 0)):
            done = subprocess.run([TOOL, *arguments], capture_output=True, text=True, timeout=120, env=environment)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertEqual(len(done.stdout.splitlines()), out)
        self.assertRegex(done.stderr, "^udar-plot: .*dpi.*\n$")


class OneRun(PlotTest):
    def test_draws_all_pictures_in_both_formats_into_the_run_folder(self):
        run = write_run(self.here / "run")
        files, noted = self.draw(run)
        self.assertEqual(set(files), {f"{name}.{kind}" for name in ONE_RUN for kind in ("png", "svg")})
        self.assertEqual({file.parent for file in files.values()}, {run / "plots"})
        self.assertEqual(noted, "")
        labels = {"gauges": ("time [s]", "y [m]", "gauge 4, x = 10 m", "on a support", "impact"),
                  "energy": ("time [s]", "energy [kJ]", "|drift| [-]", "fictitious springs"),
                  "contacts": ("time [s]", "x along the beam [m]", "impulse of the impact [N s]"),
                  "deflection": ("x along the beam [m]", "y [m]", "time from the first", "contact, t = 0.4515 s"),
                  "impulses": ("time [s]", "impulse so far [kN s]", "support 1, x = 8 m"),
                  "forces": ("time [s]", "mean force, up [kN]", "in contact", "support 1, x = 8 m", "mean over 10 ms"),
                  "envelope": ("x along the beam [m]", "bending moment [kN m]", "shear force [kN]",
                               "bending stress [MPa]",
                               "largest 25.5 MPa at x = 5 m, t = 1.25 s; at most 12.7 % of the yield stress")}
        for name, texts in labels.items():
            self.picture(files[f"{name}.png"])
            svg = files[f"{name}.svg"].read_text(encoding="utf-8")
            for text in (*texts, "N = 20 elements, wf = 50 rad/s, t = 0"):
                self.assertIn(text, svg, name)

    def test_a_new_field_of_the_file_is_drawn(self):
        """Name, unit and place come from the file: nothing here or in the program knows of twist."""
        run = write_run(self.here / "run")
        with h5py.File(run / "results.h5", "a") as file:
            for side, value in (("min", -3e3), ("max", 2e3)):
                twist = file.create_dataset(f"envelope/twist_{side}", data=np.full(len(file["cells"]), value))
                twist.attrs.update({"units": "N m", "where": "cells", "label": "twisting moment"})
        files, noted = self.draw(run, "--pictures", "envelope", "--format", "svg")
        self.assertEqual(noted, "")
        svg = files["envelope.svg"].read_text(encoding="utf-8")
        for text in ("twisting moment [kN m]", "bending moment, shear force and twisting moment"):
            self.assertIn(text, svg)

    def test_size_follows_dpi_and_the_number_of_gauges(self):
        run = write_run(self.here / "run")
        files, _ = self.draw(run, "--gauges", "1,3", "--format", "png", "--dpi", "100", "--output", self.here / "out")
        self.assertEqual(self.picture(files["gauges.png"]).shape[:2], (470, 950))
        self.assertEqual(self.picture(files["energy.png"]).shape[:2], (650, 950))
        self.assertEqual(set(files), {f"{name}.png" for name in ONE_RUN})
        self.assertEqual({file.parent for file in files.values()}, {self.here / "out"})

    def test_curves_and_impacts_are_there_and_only_where_they_belong(self):
        run = write_run(self.here / "run")
        only = ("--pictures", "gauges", "--format", "png")
        on_support, _ = self.draw(run, "--gauges", "1", *only, "--output", self.here / "on")
        beside, _ = self.draw(run, "--gauges", "2", *only, "--output", self.here / "beside")
        on_support, beside = self.picture(on_support["gauges.png"]), self.picture(beside["gauges.png"])
        for pixels in (on_support, beside):
            self.assertGreater(close_to(pixels, BLUE), 500)
        self.assertGreater(close_to(on_support, VERMILLION), 100)
        self.assertEqual(close_to(beside, VERMILLION), 0)

    def test_title_is_put_before_every_title(self):
        files, _ = self.draw(write_run(self.here / "run"), "--title", "Falling <beam> & co", "--format", "svg")
        for file in files.values():
            self.assertIn("Falling &lt;beam&gt; &amp; co: ", file.read_text(encoding="utf-8"))

    def test_same_run_gives_the_same_svg(self):
        run = write_run(self.here / "run")
        first, _ = self.draw(run, "--format", "svg", "--output", self.here / "a")
        second, _ = self.draw(run, "--format", "svg", "--output", self.here / "b")
        for name in first:
            self.assertEqual(first[name].read_bytes(), second[name].read_bytes())

    def test_resting_masses_are_shown_as_bars(self):
        run = write_run(self.here / "run", restitution=0.3)
        files, _ = self.draw(run, "--pictures", "contacts", "--format", "svg")
        self.assertIn("mass at rest", files["contacts.svg"].read_text(encoding="utf-8"))
        never = write_run(self.here / "never", restitution=1.0)
        files, _ = self.draw(never, "--pictures", "contacts", "--format", "svg")
        self.assertNotIn("mass at rest", files["contacts.svg"].read_text(encoding="utf-8"))

    def test_without_impacts(self):
        files, _ = self.draw(write_run(self.here / "run", gravity=0.0), "--format", "svg")
        for name in ("contacts", "impulses", "forces"):
            self.assertIn("no contact", files[f"{name}.svg"].read_text(encoding="utf-8"))
        self.assertEqual(set(files), {f"{name}.svg" for name in ONE_RUN})

    def test_only_what_is_asked_for(self):
        run = write_run(self.here / "run", gauges=())
        files, noted = self.draw(run, "--pictures", "forces,gauges,structure", "--format", "svg")
        self.assertEqual(set(files), {"forces.svg"})
        self.assertEqual(len(noted.splitlines()), 2, noted)
        self.assertIn("has no gauges", noted)
        self.assertIn("there is no picture structure of", noted)
        self.assert_refused("'bars' is none of gauges, energy", run, "--pictures", "bars")

    def test_without_supports(self):
        files, noted = self.draw(write_run(self.here / "run", supports=(), gravity=0.0), "--format", "png")
        self.assertEqual(set(files), {"gauges.png", "energy.png", "deflection.png", "envelope.png"})
        self.assertIn("no supports", noted)

    def test_without_gauges(self):
        files, noted = self.draw(write_run(self.here / "run", gauges=()), "--format", "png")
        self.assertEqual(set(files), {f"{name}.png" for name in ONE_RUN} - {"gauges.png"})
        self.assertIn("no gauges", noted)

    def test_floor_wide_supports_and_a_support_above(self):
        for name, options, expected in (("floor", {"supports": (), "floor": True}, "on the floor"),
                                        ("wide", {"supports": ((5.0, 2.0),)}, "on a support"),
                                        ("above", {"side": -1.0, "height": 2.0}, "under a support")):
            run = write_run(self.here / name, **options)
            files, _ = self.draw(run, "--format", "png", "--dpi", "60")
            self.assertEqual(set(files), {f"{picture}.png" for picture in ONE_RUN})
            for file in files.values():
                self.picture(file)
            only = ("--pictures", "gauges", "--format", "svg", "--output", self.here / f"{name}_gauges")
            self.assertIn(expected, self.draw(run, *only)[0]["gauges.svg"].read_text(encoding="utf-8"))

    def test_supports_that_move_are_drawn_where_they_are(self):
        run = write_run(self.here / "run")
        only = ("--gauges", "1", "--pictures", "gauges,deflection", "--format", "svg")
        at_rest, _ = self.draw(run, *only, "--output", self.here / "at_rest")
        with h5py.File(run / "results.h5", "a") as file:
            time = np.linspace(0.0, 2.0, 21)
            file["contact"] = np.array([(at,) for at in time], dtype=[("time", "f8")])
            supports = len(file["support_position"])
            file["supports/lift"] = np.outer(0.3 * np.sin(time), np.ones(supports))
        moving, _ = self.draw(run, *only, "--output", self.here / "moving")
        for name in ("gauges.svg", "deflection.svg"):
            before, after = (files[name].read_text(encoding="utf-8") for files in (at_rest, moving))
            self.assertNotEqual(before, after, name)

    def test_unfiltered(self):
        files, _ = self.draw(write_run(self.here / "run", wf=0.0), "--format", "svg")
        self.assertIn("N = 20 elements, unfiltered", files["gauges.svg"].read_text(encoding="utf-8"))

        run = write_run(self.here / "none", wf=2e5)  # 2 / dt, what the program writes
        for options, label in (("-filter_frequency none\n-ts_dt 1e-5", "unfiltered"), ("-ts_type modal", "by modes")):
            with h5py.File(run / "results.h5", "a") as file:
                file.attrs["options"] = f"-beam_length 10\n{options}"
                if label == "by modes":  # which have no frequency of a filter
                    del file.attrs["filter_frequency"]
            only = ("--pictures", "gauges", "--format", "svg", "--output", self.here / label)
            files, _ = self.draw(run, *only)
            svg = files["gauges.svg"].read_text(encoding="utf-8")
            self.assertIn(f"N = 20 elements, {label}", svg)
            self.assertNotIn("rad/s", svg)

    def test_force_without_impacts(self):
        """Contact on the line gives forces alone: impulses and times of contact come from them."""
        run = write_run(self.here / "run", gravity=0.0)
        with h5py.File(run / "results.h5", "a") as file:
            file.attrs["options"] = "-contact_surface line"
            file["support_side"][1] = -1.0
        time = np.arange(0.0, 3.0001, 0.01)
        force = np.outer((time > 1) & (time <= 2), [3e6, -2e6])
        impulse = np.cumsum(0.01 * force, axis=0)
        rows = np.column_stack([time, 0 * time, np.full((len(time), 2), np.nan), force[:, 0], impulse[:, 0],
                                force[:, 1], impulse[:, 1]])
        write_csv(run / "contact.csv", ["time", "masses", "x_min", "x_max", "force_0", "impulse_0", "force_1",
                                        "impulse_1"], rows)
        files, _ = self.draw(run, "--pictures", "impulses,forces,contacts")
        for name, texts in {"impulses": ("impulse so far [MN s]", "support 0 below, x = 2 m"),
                            "forces": ("mean force, up [MN]", "support 1 above, x = 8 m", "in contact, above"),
                            "contacts": ("contact on the line", "in contact, below")}.items():
            svg = files[f"{name}.svg"].read_text(encoding="utf-8")
            for text in texts:
                self.assertIn(text, svg, name)
            self.assertNotIn("no contact", svg, name)
        # In the lower panel of `forces`, two bars a third of the time long and nothing between the supports.
        pixels = self.picture(files["forces.png"])
        between = pixels[int(0.55 * len(pixels)):]
        self.assertGreater(close_to(between, (86, 180, 233)), 1000)
        self.assertGreater(close_to(between, (230, 159, 0)), 1000)
        self.assertLess(close_to(between, (86, 180, 233)), 0.05 * between[:, :, 0].size)

    def test_units_follow_what_is_drawn(self):
        """A thousandth of the size and a billionth of the energy."""
        run = write_run(self.here / "run")
        for name in ("gauges", "energy", "contact"):
            head, *rows = (run / f"{name}.csv").read_text(encoding="utf-8").splitlines()
            scales = [1.0 if column in ("time", "x_min", "x_max") else 1e-3 if name == "gauges" else 1e-9
                      for column in head.split(",")]
            rows = [",".join(f"{float(text) * scale:.17g}" for text, scale in zip(row.split(","), scales))
                    for row in rows]
            (run / f"{name}.csv").write_text("\n".join([head, *rows, ""]), encoding="utf-8")
        files, _ = self.draw(run, "--pictures", "gauges,energy,forces", "--format", "svg")
        labels = {"gauges": "y [mm]", "energy": "energy [\u00b5J]", "forces": "mean force, up [\u00b5N]"}
        for name, label in labels.items():
            self.assertIn(label, files[f"{name}.svg"].read_text(encoding="utf-8"), name)

    def test_what_a_run_warned_of_is_in_its_pictures(self):
        warned = {"warnings": ["the energy balance is off by 7.5e-02: do not trust these curves; lower -ts_rtol"],
                  "completed": False}
        one, other = write_run(self.here / "one", summary=warned), write_run(self.here / "other", wf=100.0)
        for folders in ((one,), (one, other)):
            files, _ = self.draw(*folders, "--format", "svg", "--output", self.here / f"out{len(folders)}")
            for name, file in files.items():
                svg, before = file.read_text(encoding="utf-8"), "wf = 50 rad/s: " if len(folders) > 1 else ""
                self.assertIn(f"Warning: {before}the energy balance is off by 7.5e-02: do not trust these curves<", svg)
                self.assertIn(f"Warning: {before}stopped early, at t = 3 s", svg, name)
                self.assertNotIn("-ts_rtol", svg, "the advice is for the terminal")
        files, _ = self.draw(other, "--pictures", "energy", "--format", "svg")
        self.assertNotIn("Warning", files["energy.svg"].read_text(encoding="utf-8"))

    def test_two_hundred_supports(self):
        """Forces over time and place instead of two hundred curves; from results.h5, contact.csv has the sums."""
        place = np.linspace(0.1, 9.9, 200)
        run = write_run(self.here / "run", nodes=501, supports=[(x, 0.0) for x in place])
        table = np.genfromtxt(run / "contact.csv", delimiter=",", names=True)
        force, impulse = (np.array([table[f"{kind}_{k}"] for k in range(200)]).T for kind in ("force", "impulse"))
        with h5py.File(run / "results.h5", "a") as file:
            file["supports/force"], file["supports/impulse"] = force, impulse
        rows = np.column_stack([*(table[name] for name in ("time", "masses", "x_min", "x_max")), force.sum(axis=1),
                                impulse.sum(axis=1)])
        write_csv(run / "contact.csv", ["time", "masses", "x_min", "x_max", "force", "impulse"], rows)
        files, _ = self.draw(run, "--pictures", "impulses,forces")
        for name, text in (("impulses", "impulse so far [N s]"), ("forces", "mean force, up [kN]")):
            svg = files[f"{name}.svg"].read_text(encoding="utf-8")
            self.assertIn(text, svg)
            self.assertIn("x along the beam [m]", svg)
            self.assertLess(len(svg), 1_000_000, name)
            self.picture(files[f"{name}.png"])

    def test_many_nodes_and_impacts_are_thinned(self):
        run = write_run(self.here / "run", nodes=100_001, supports=(), floor=True, end=1.2, field_step=0.1,
                        restitution=0.5)
        files, _ = self.draw(run)
        svg = files["contacts.svg"].read_text(encoding="utf-8")
        self.assertIn("impulse per cell [N s]", svg)
        self.assertIn("(2 ms by 40 mm)", svg)
        for file in files.values():
            self.assertLess(file.stat().st_size, 3_000_000, file)
            if file.suffix == ".png":
                self.picture(file)


class Networks(PlotTest):
    """Structure and deformation in space."""

    def test_members_gauges_and_supports_are_drawn(self):
        run = write_network(self.here / "run")  # 20 members
        files, noted = self.draw(run)
        self.assertEqual(noted, "")
        self.assertEqual({pathlib.Path(name).stem for name in files},
                         {"gauges", "energy", "contacts", "impulses", "forces", "structure", "deformation"})
        structure = files["structure.svg"].read_text(encoding="utf-8")
        for text in ("Network of 12 junctions and 20 members", "0: 0 0 0", "1: 2 1 1", "junction", "gauge", "support",
                     "N = 80 elements"):
            self.assertIn(text, structure)
        self.assertNotIn("held", structure)
        self.assertEqual(drawn_lines(structure), {"members": 80})
        self.assertGreater(close_to(self.picture(files["structure.png"]), VERMILLION), 50, "gauges")
        shape = files["deformation.svg"].read_text(encoding="utf-8")
        self.assertEqual(drawn_lines(shape),
                         {f"{name}-{panel}": 80 for name in ("members", "undeformed") for panel in range(4)})
        # It falls by 0.6 m and turns by 0.9; 1 cm is what is drawn, less its mean.
        self.assertIn("drawn 50 times as large", shape)
        self.assertIn("from its motion as a whole", shape)
        self.assertEqual(len(re.findall(r"t = [0-9.]+ m?s: up to [0-9.]+ mm", shape)), 4)
        self.assertEqual(shape.count(", the largest"), 1)
        self.picture(files["deformation.png"])
        self.assertIn("gauge 1, 2 1 1", files["gauges.svg"].read_text(encoding="utf-8"))

    def test_what_is_held_does_not_move_as_a_whole(self):
        run = write_network(self.here / "run", held=(0, 3), turn=0.0, supports=())
        files, _ = self.draw(run, "--pictures", "structure,deformation", "--format", "svg")
        self.assertIn(">held<", files["structure.svg"].read_text(encoding="utf-8"))
        shape = files["deformation.svg"].read_text(encoding="utf-8")
        self.assertNotIn("motion as a whole", shape)
        self.assertIn("up to 0.6 m", shape)
        self.assertIn("in true size", shape)

    def test_where_what_is_held_starts_is_no_deformation(self):
        run = write_network(self.here / "run", held=(0, 3), turn=0.0, supports=())
        with h5py.File(run / "results.h5", "a") as file:
            file["fields/displacement_of_line"][:, :, 1] += 40.0 + 0.5 * (file["x"][()] - 1.0)
            file.create_group("parameters").attrs.update({"initial height [m]": "40", "initial slope": "0.5"})
        files, _ = self.draw(run, "--pictures", "deformation", "--format", "svg")
        self.assertIn("up to 0.6 m", files["deformation.svg"].read_text(encoding="utf-8"))

    def test_planes_are_drawn_where_they_are(self):
        """A wall behind the end, an incline, and one too far away to be drawn."""
        run = write_network(self.here / "run", supports=3 * ((1.0, np.inf),), gravity=0.0)
        with h5py.File(run / "results.h5", "a") as file:
            for k, axis in enumerate("xyz"):
                file[f"support_normal_{axis}"] = np.array([[-1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])[:, k]
            for axis in "yz":
                file[f"support_{axis}_from"], file[f"support_{axis}_to"] = np.full(3, -np.inf), np.full(3, np.inf)
            file["support_height"][...] = [-2.5, -0.3, 40.0]
        files, _ = self.draw(run, "--pictures", "structure,gauges", "--format", "svg")
        svg = files["structure.svg"].read_text(encoding="utf-8")
        self.assertEqual(len(re.findall('<g id="Poly3DCollection_', svg)), 2)
        self.assertNotIn(">support<", files["gauges.svg"].read_text(encoding="utf-8"), "no heights of planes")

    def test_height_fields_are_drawn_next_to_the_structure(self):
        run = write_network(self.here / "run", supports=((1.0, np.inf),), gravity=0.0)
        x, z = np.linspace(-40.0, 41.0, 82), np.array([-9.0, -0.5, 0.5, 1.5, 30.0])
        height = np.tile(0.1 * np.sin(x) - 0.5, (len(z), 1))
        height[2, 41] = np.nan  # at x = 1, z = 0.5: four cells have no corner there
        with h5py.File(run / "results.h5", "a") as file:
            for axis, normal in zip("xyz", (0.0, 1.0, 0.0)):
                file[f"support_normal_{axis}"] = [normal]
            for axis in "yz":
                file[f"support_{axis}_from"], file[f"support_{axis}_to"] = [-np.inf], [np.inf]
            file["height_field_0_x"], file["height_field_0_z"], file["height_field_0_height"] = x, z, height.ravel()
        files, _ = self.draw(run, "--pictures", "structure,gauges", "--format", "svg")
        svg = files["structure.svg"].read_text(encoding="utf-8")
        (faces,) = re.findall('<g id="Poly3DCollection_[^>]*>(.*?)</g>', svg, re.DOTALL)
        across, along = 4, 2  # cells from the last place before the structure to the first behind it
        self.assertEqual(faces.count("<path"), across * along - 4)
        self.assertNotIn(">support<", files["gauges.svg"].read_text(encoding="utf-8"), "no heights of planes")

    def test_without_rows(self):
        files, noted = self.draw(write_network(self.here / "run", rows=0), "--format", "png")
        self.assertIn("structure.png", files)
        self.assertNotIn("deformation.png", files)
        self.assertIn("no rows of fields", noted)

    def test_ten_thousand_members_are_readable_and_small(self):
        run = write_network(self.here / "run", count=(15, 15, 16), elements=3, rows=3, gauges=())
        files, _ = self.draw(run, "--pictures", "structure,deformation", "--dpi", "60")
        self.assertIn("Network of 3600 junctions and 10095 members", files["structure.svg"].read_text(encoding="utf-8"))
        for name in ("structure", "deformation"):
            self.assertLess(files[f"{name}.svg"].stat().st_size, 1_500_000, name)
            pixels = self.picture(files[f"{name}.png"])
            white = (pixels[:, :, :3] > 0.98).all(axis=2).mean()
            self.assertTrue(0.3 < white < 0.9, f"{name}: {white}")

    def test_a_file_without_its_members_is_refused(self):
        run = write_network(self.here / "run")
        with h5py.File(run / "results.h5", "a") as file:
            del file["member"]
        self.assert_refused("results.h5", run)


class UnfinishedRun(PlotTest):
    def test_last_line_being_written_is_left_out(self):
        run = write_run(self.here / "run", finished=False, restitution=0.3)
        for name, cut in (("gauges", 40), ("energy", 30), ("impacts", 11), ("rests", 3)):
            path = run / f"{name}.csv"
            path.write_bytes(path.read_bytes()[:-cut])
        files, _ = self.draw(run, "--format", "svg")
        for file in files.values():
            self.assertIn("(not finished)", file.read_text(encoding="utf-8"))

    def test_impacts_come_from_the_csv_file_when_results_h5_lags_behind(self):
        run = write_run(self.here / "run", finished=False)
        rows = len((run / "impacts.csv").read_text(encoding="utf-8").splitlines()) - 1
        with h5py.File(run / "results.h5", "a") as file:
            for name in ("impacts", "rests", "energy"):
                del file[name]
        files, _ = self.draw(run, "--pictures", "contacts", "--format", "svg")
        self.assertIn(f">{rows} impacts<", files["contacts.svg"].read_text(encoding="utf-8"))

    def test_fields_of_different_length(self):
        run = write_run(self.here / "run", finished=False)
        with h5py.File(run / "results.h5", "a") as file:
            kept = file["fields/line_position"][:20]
            del file["fields/line_position"]
            file["fields/line_position"] = kept
        files, _ = self.draw(run, "--pictures", "deflection", "--format", "svg")
        self.assertIn("t = 0.08 to 0.19 s", files["deflection.svg"].read_text(encoding="utf-8"))

    def test_nothing_but_headers_yet(self):
        run = write_run(self.here / "run", finished=False)
        for name in ("gauges", "energy", "impacts", "rests", "contact"):
            path = run / f"{name}.csv"
            path.write_text(path.read_text(encoding="utf-8").splitlines()[0] + "\n", encoding="utf-8")
        with h5py.File(run / "results.h5", "a") as file:
            for name in ("time", "mass_position", "line_position"):
                width = file[f"fields/{name}"].shape[1:]
                del file[f"fields/{name}"]
                file[f"fields/{name}"] = np.empty((0, *width))
        files, noted = self.draw(run, "--format", "svg")
        self.assertEqual(set(files), {f"{name}.svg" for name in ONE_RUN} - {"envelope.svg"})
        self.assertIn("no envelopes, which are written when a run ends", noted)
        self.draw(run, run, "--format", "svg", "--output", self.here / "both")


class SeveralRuns(PlotTest):
    def test_are_laid_over_each_other(self):
        slow, fast = write_run(self.here / "slow", wf=50.0), write_run(self.here / "fast", wf=100.0, restitution=0.6)
        files, _ = self.draw(slow, fast)
        self.assertEqual(set(files), {f"{name}.{kind}" for name in SEVERAL_RUNS for kind in ("png", "svg")})
        self.assertEqual({file.parent for file in files.values()}, {self.here / "plots"})
        for name in SEVERAL_RUNS:
            svg = files[f"{name}.svg"].read_text(encoding="utf-8")
            self.assertIn(">wf = 50 rad/s", svg)
            self.assertIn(">wf = 100 rad/s", svg)
            self.assertNotIn("wf = 50 rad/s, wf", svg, "not in the title, too")
            self.assertIn("time [s]", svg)
            self.picture(files[f"{name}.png"])
        gauges = self.picture(files["gauges.png"])
        self.assertGreater(close_to(gauges, BLUE), 1000)
        self.assertGreater(close_to(gauges, VERMILLION), 1000)

    def test_of_equal_frequency_are_told_apart_by_mesh_or_folder(self):
        meshes = {"coarse": 21, "fine": 41, "again": 21}
        runs = [write_run(self.here / name, nodes=nodes) for name, nodes in meshes.items()]
        svg = self.draw(*runs, "--pictures", "gauges", "--format", "svg")[0]["gauges.svg"].read_text(encoding="utf-8")
        for label in ("coarse, N = 20", "fine, N = 40", "again, N = 20"):
            self.assertIn(f">{label}<", svg)
        self.assertIn("3 runs, wf = 50 rad/s, t = 0", svg)

    def test_eight_runs_keep_their_panels(self):
        """Legends take rows, not the width of a panel."""
        runs = [write_run(self.here / f"a-run-with-a-long-name-{k}", gauges=(2.0,)) for k in range(8)]
        files, _ = self.draw(*runs, "--format", "png", "--dpi", "60")
        for name, share in (("energy", 0.75), ("contacts", 0.7), ("gauges", 0.8)):
            pixels = self.picture(files[f"{name}.png"])
            dark = (pixels[:, :, :3] < 0.6).all(axis=2)  # the axis below the lowest panels is the longest dark row
            self.assertGreater(dark.sum(axis=1).max(), share * pixels.shape[1], name)

    def test_may_differ_in_gauges_and_supports(self):
        first = write_run(self.here / "a", gauges=(2.0, 5.0))
        second = write_run(self.here / "b", wf=100.0, gauges=(5.0,), supports=(), floor=True)
        third = write_run(self.here / "c", wf=200.0, gauges=(), supports=(), gravity=0.0)
        files, _ = self.draw(first, second, third, "--format", "png")
        self.assertEqual(set(files), {f"{name}.png" for name in SEVERAL_RUNS})


class Refused(PlotTest):
    def test_folders_that_are_no_runs(self):
        (self.here / "empty").mkdir()
        self.assert_refused("no such folder", self.here / "nowhere")
        self.assert_refused("no results.h5", self.here / "empty")

    def test_damaged_results(self):
        run = write_run(self.here / "run")
        path = run / "results.h5"
        whole = path.read_bytes()
        path.write_bytes(whole[:len(whole) // 2])
        self.assert_refused("results.h5", run)
        path.write_bytes(b"not HDF5\n" * 100)
        self.assert_refused("results.h5", run)

    def test_results_without_something_they_need(self):
        for name in ("x", "gauge_node", "support_width", "fields", "fields/time"):
            run = write_run(self.here / name.replace("/", "_"))
            with h5py.File(run / "results.h5", "a") as file:
                del file[name]
            self.assert_refused("results.h5", run)
        run = write_run(self.here / "attribute")
        with h5py.File(run / "results.h5", "a") as file:
            del file.attrs["filter_frequency"]
        self.assert_refused("filter_frequency", run)

    def test_results_that_contradict_themselves(self):
        run = write_run(self.here / "node")
        with h5py.File(run / "results.h5", "a") as file:
            file["gauge_node"][0] = 99
        self.assert_refused("gauge_node", run)
        run = write_run(self.here / "support")
        with h5py.File(run / "results.h5", "a") as file:
            records = file["impacts"][()]
            records["support"][0] = 7
            file["impacts"][...] = records
        self.assert_refused("support", run)
        run = write_run(self.here / "width")
        with h5py.File(run / "results.h5", "a") as file:
            del file["fields/line_position"]
            file["fields/line_position"] = np.zeros((301, 5))
        self.assert_refused("line_position", run)

    def test_missing_and_malformed_csv(self):
        for name in ("gauges", "energy"):
            run = write_run(self.here / name)
            path = run / f"{name}.csv"
            good = path.read_text(encoding="utf-8")
            path.write_text(good.replace("\n0.002", "\nnonsense", 1), encoding="utf-8")
            self.assert_refused(f"{name}.csv", run)
            path.write_text("time\n0\n", encoding="utf-8")
            self.assert_refused("has no column", run)
            path.write_bytes(b"\xff\xfe\x00" * 50)
            self.assert_refused(f"{name}.csv", run)
            path.unlink()
            self.assert_refused("no such file", run)

    def test_one_bad_run_among_several_draws_nothing(self):
        good = write_run(self.here / "good")
        self.assert_refused("no such folder", good, self.here / "bad", "--output", self.here / "out")
        self.assertFalse((self.here / "out").exists())

    def test_options(self):
        run = write_run(self.here / "run")
        self.assert_refused("no gauge 5", run, "--gauges", "0,5")
        self.assert_refused("'a'", run, "--gauges", "a")
        self.assert_refused("pdf", run, "--format", "png,pdf")
        self.assert_refused("dpi", run, "--dpi", "0")
        self.assert_refused("--colour", run, "--colour", "red")
        self.assert_refused("RUN")

    def test_output_that_cannot_be_a_folder(self):
        run = write_run(self.here / "run")
        (self.here / "file").write_text("", encoding="utf-8")
        self.assert_refused("file", run, "--output", self.here / "file")


if __name__ == "__main__":
    unittest.main()
