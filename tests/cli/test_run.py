#!/usr/bin/env python3
# size: long
"""What a good run writes and prints: files, formats, balances, help, interruption, other integrators."""

import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import xml.etree.ElementTree

import h5py
import numpy as np

from common import ENVIRONMENT, ROOT, STOPPED_BY_STEPS, STEEL_MASS, UdarTest
from common import case, command, datasets, lumped_masses, read_csv, run, start

EXAMPLE = ROOT / "examples" / "01-falling-beam" / "case.yaml"
GRAVITY = 9.81
LAUNCHES = (0, 2)  # without mpiexec, and on two ranks

SUMMARY_KEYS = """
    elements ranks steps rejected_steps rhs_evaluations line_solves stepping_line_solves row_line_solves
    impacts rests releases first_contact_time
    last_contact_time min_line_gap min_line_gap_x min_line_gap_time support_impulse force_window
    peak_force_window peak_support_force mode_frequency mode_filtered energy_drift warnings
    max_bending_stress max_bending_stress_x max_bending_stress_time max_utilisation max_utilisation_x
    max_utilisation_time wall_seconds wall_seconds_mean own_seconds communication
    peak_memory_bytes memory_per_rank versions""".split()
ENERGY_COLUMNS = (
    "time,kinetic,line_strain,fictitious_springs,load_potential,support_springs,load_work,support_work,base_work,"
    "lost_in_impacts,lost_in_dampers,radiated,lost_in_hinges,total,drift"
)
IMPACT_COLUMNS = "time,node,x,support,velocity_before,velocity_after,impulse,energy_loss"
REST_COLUMNS = "time,node,x,support,event"
ROOT_ATTRIBUTES = "udar_version petsc_version hdf5_version mpi_version options filter_frequency elements ranks".split()
SUPPORT_DATASETS = ["support_position", "support_width", "support_height", "support_side", "support_restitution"]
FIELDS = ["mass_position", "mass_velocity", "line_position", "moment"]

HELP_OPTIONS = """
    beam_length beam_elements beam_section beam_radius beam_young_modulus beam_density beam_theory beam_left_end
    beam_right_end beam_formulation gravity initial_height initial_slope initial_velocity initial_angular_velocity
    initial_shape filter_frequency support_position support_width support_height support_side contact_restitution
    contact_tolerance floor floor_height gauge_position load_position load_table output_directory output_interval
    output_field_interval output_force_window output_overwrite restart_file restart_interval restart_wall_minutes
    wall_limit continue udar_view udar_guard udar_summary output_monitor output_fields output_compression
    output_contacts output_contact_window output_region output_members output_stride
    ts_max_time ts_rtol ts_type options_file version citations
    ts_rk_type filter_ksp_type filter_pc_type""".split()
HELP_UNITS = ["[m]", "[rad/s]", "[Pa]", "[kg/m^3]", "[s]", "[m/s]", "[m/s^2]"]


class Example(UdarTest):
    """The first example at 50 rad/s, run once for all checks."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = pathlib.Path(tempfile.mkdtemp(prefix="udar-test-"))
        cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        options = {"options_file": EXAMPLE, "filter_frequency": 50, "output_directory": folder / "run"}
        cls.finished = run(options, cwd=folder, timeout=120)
        if cls.finished.code != 0:
            raise RuntimeError(str(cls.finished))
        cls.summary = cls.finished.summary()
        cls.file = h5py.File(cls.finished.file("results.h5"), "r")
        cls.addClassCleanup(cls.file.close)
        words = as_text(cls.file.attrs["options"]).split()
        cls.options = {key.lstrip("-"): value for key, value in zip(words, words[1:]) if key.startswith("-")}

    def option(self, name):
        return [float(word) for word in self.options[name].strip("[]").split(",")]

    def header(self, name):
        return self.finished.file(name).read_text().splitlines()[0]

    def test_printed_text_is_quiet_in_a_pipe(self):
        for text in (self.finished.out, self.finished.err):
            self.assertNotIn("\r", text)
            self.assertNotIn("\x1b", text)
        self.assertLess(len(self.finished.out.splitlines()), 100, self.finished)

    def test_every_dataset_says_its_units(self):
        found = {}
        self.file.visititems(lambda name, item: found.update({name: item}) if isinstance(item, h5py.Dataset) else None)
        self.assertGreater(len(found), 20)
        for name, data in found.items():
            units = as_text(data.attrs["units"]).split(",")
            self.assertEqual(len(units), len(data.dtype.names or [0]), f"a unit for each column of {name}")
            self.assertNotIn("", units, name)
        self.assertEqual(as_text(found["fields/moment"].attrs["units"]), "N m")
        self.assertEqual(as_text(found["energy"].attrs["units"]).split(",")[0], "s")

    def test_gauges(self):
        gauges = len(self.option("gauge_position"))
        columns = ["time"] + [f"{name}_{i}" for i in range(gauges) for name in ("mass", "velocity", "line")]
        self.assertEqual(self.header("gauges.csv"), ",".join(columns), self.finished)
        found, interval = self.finished.csv("gauges.csv"), self.option("output_interval")[0]
        rows = int(np.floor(self.option("ts_max_time")[0] / interval * (1 + 1e-12))) + 1
        self.assertEqual(len(found["time"]), rows)
        np.testing.assert_array_almost_equal_nulp(found["time"], np.arange(rows) * interval, 1)
        for name, column in found.items():
            self.assertTrue(np.isfinite(column).all(), name)

    def test_gauges_agree_with_fields(self):
        found, fields = self.finished.csv("gauges.csv"), self.file["fields"]
        times = (np.round(found["time"], 9), np.round(fields["time"][()], 9))
        both, rows, fields_rows = np.intersect1d(*times, return_indices=True)
        self.assertGreater(len(both), 1, "times that both have")
        for gauge, node in enumerate(self.file["gauge_node"][()]):
            for column, field in (("mass", "mass_position"), ("velocity", "mass_velocity"), ("line", "line_position")):
                expected = fields[field][()][fields_rows, node]
                np.testing.assert_allclose(
                    found[f"{column}_{gauge}"][rows], expected, rtol=1e-12, atol=1e-12, err_msg=column
                )

    def test_headers(self):
        self.assertEqual(self.header("energy.csv"), ENERGY_COLUMNS)
        self.assertEqual(self.header("impacts.csv"), IMPACT_COLUMNS)
        self.assertEqual(self.header("rests.csv"), REST_COLUMNS)

    def test_energy(self):
        energy = self.finished.csv("energy.csv")
        np.testing.assert_array_equal(energy["time"], self.finished.csv("gauges.csv")["time"])
        # The case asks for 1e-10 per step of `chebyshev`, and takes some twenty.
        self.assertLess(np.abs(energy["drift"]).max(), 2e-9)
        self.assertLess(abs(self.summary["energy_drift"]), 2e-9)
        parts = energy["kinetic"] + energy["line_strain"] + energy["fictitious_springs"] + energy["load_potential"]
        np.testing.assert_allclose(parts, energy["total"], rtol=1e-12, atol=1e-9 * np.abs(energy["total"]).max())
        np.testing.assert_array_less(-1e-9, np.diff(energy["lost_in_impacts"]))
        last = self.finished.csv("impacts.csv")["energy_loss"].sum()
        np.testing.assert_allclose(energy["lost_in_impacts"][-1], last, rtol=1e-6, atol=1e-6 * energy["kinetic"].max())

    def test_summary(self):
        self.assertLessEqual(set(SUMMARY_KEYS), set(self.summary))
        frequency, filtered = (np.array(self.summary[f"mode_{kind}"]) for kind in ("frequency", "filtered"))
        self.assertEqual(len(frequency), 3)
        # 22.373 / L^2 sqrt(EI / rhoA) of the free beam; 20 elements have 0.8 % less.
        self.assertAlmostEqual(frequency[0] / 57.86, 1.0, delta=0.01)
        np.testing.assert_allclose(filtered, 50 * frequency / np.hypot(50, frequency), rtol=1e-6)
        self.assertEqual(self.summary["elements"], self.file.attrs["elements"])
        self.assertEqual(self.summary["ranks"], 1)
        self.assertEqual(len(self.summary["support_impulse"]), len(self.file["support_position"]))
        impacts, rests = self.finished.csv("impacts.csv"), self.finished.csv("rests.csv")
        self.assertEqual(self.summary["impacts"], len(impacts["time"]))
        self.assertEqual(self.summary["rests"], int(np.count_nonzero(rests["event"] == "rest")))
        self.assertEqual(self.summary["releases"], int(np.count_nonzero(rests["event"] == "release")))
        self.assertGreaterEqual(self.summary["line_solves"], self.summary["rhs_evaluations"])
        self.assertEqual(self.summary["integrator"], "chebyshev")  # two nodes can touch
        self.assertGreater(self.summary["integrator_counts"]["steps_to_events"], 5)
        self.assertLess(self.summary["integrator_counts"]["steps_to_events"], self.summary["steps"] + 1)
        self.assertGreater(self.summary["peak_memory_bytes"], 1e6)
        self.assertLess(self.summary["peak_memory_bytes"], 1e9)
        self.assertGreater(self.summary["stepping_line_solves"], 0)
        self.assertLess(self.summary["stepping_line_solves"], self.summary["line_solves"])  # modes were found before
        self.assertEqual(self.summary["row_line_solves"], len(self.finished.csv("energy.csv")["time"]))
        seconds, own = self.summary["wall_seconds"], self.summary["own_seconds"]
        self.assertAlmostEqual(seconds["set_up"] + seconds["stepping"], seconds["total"], delta=1e-9)
        self.assertAlmostEqual(sum(own.values()), seconds["stepping"], delta=1e-9)
        self.assertGreater(min(own.values()), -1e-9)
        self.assertEqual(self.summary["wall_seconds_mean"], seconds)  # one rank
        self.assertGreaterEqual(seconds["contact"], own["contact"])
        told = self.summary["communication"]
        self.assertEqual(told["stepping"]["messages"], 0)  # one rank
        self.assertEqual((told["line_solve"]["reductions"], told["reduction"]["reductions"]), (0, 0))
        memory = self.summary["memory_per_rank"]
        self.assertEqual({memory["largest"], memory["smallest"]}, {self.summary["peak_memory_bytes"]})
        text = self.finished.file("summary.json").read_text()
        self.assertNotIn("NaN", text)
        self.assertNotIn("Infinity", text)

    def test_first_contact_is_the_free_fall(self):
        drop = self.option("initial_height")[0] - min(self.file["support_height"][()])
        fall = np.sqrt(2 * drop / GRAVITY)
        self.assertAlmostEqual(self.summary["first_contact_time"], fall, delta=1e-7)
        impacts = self.finished.csv("impacts.csv")
        self.assertAlmostEqual(impacts["time"][0], fall, delta=1e-7)
        self.assertAlmostEqual(impacts["velocity_before"][0], -GRAVITY * fall, delta=1e-5)
        self.assertGreaterEqual(self.summary["last_contact_time"], impacts["time"][-1])

    def test_impacts(self):
        impacts = self.finished.csv("impacts.csv")
        restitution = self.file["support_restitution"][()][impacts["support"].astype(int)]
        self.assertTrue((impacts["velocity_before"] < 0).all())
        rebound = -restitution * impacts["velocity_before"]
        after = impacts["velocity_after"]
        self.assertTrue((np.isclose(after, rebound, rtol=1e-12) | (after == 0)).all())
        mass = lumped_masses(self.file.attrs["elements"])[impacts["node"].astype(int)]
        np.testing.assert_allclose(impacts["impulse"], mass * (after - impacts["velocity_before"]), rtol=1e-9)
        np.testing.assert_allclose(impacts["x"], self.file["x"][()][impacts["node"].astype(int)], rtol=1e-15)
        order = np.lexsort((impacts["node"], impacts["time"]))
        np.testing.assert_array_equal(order, np.arange(len(order)), err_msg="in order of time, then node")

    def test_symmetry(self):
        """A symmetric case stays symmetric: left and right nodes are hit at the same times up to the tenth impact."""
        impacts, nodes = self.finished.csv("impacts.csv"), self.summary["elements"]
        for node in np.unique(impacts["node"]):
            left, right = (impacts["time"][impacts["node"] == n][:5] for n in (node, nodes - node))
            np.testing.assert_allclose(left, right, rtol=0, atol=1e-10)

    def test_results_file(self):
        file, supports = self.file, len(self.file["support_position"])
        for name in ROOT_ATTRIBUTES:
            self.assertIn(name, file.attrs)
        self.assertEqual(file.attrs["filter_frequency"], 50)
        for line in as_text(file.attrs["options"]).splitlines():
            self.assertRegex(line, r"^-\w+( [^ ]+)?$", "one option per line")
        self.assertEqual(file.attrs["ranks"], 1)
        nodes = int(file.attrs["elements"]) + 1
        np.testing.assert_allclose(file["x"][()], np.linspace(0, self.option("beam_length")[0], nodes), rtol=1e-14)
        np.testing.assert_array_equal(file["gauge_position"][()], self.option("gauge_position"))
        self.assertEqual(file["gauge_node"].dtype, np.int64)
        for name in SUPPORT_DATASETS:
            self.assertEqual((file[name].shape, file[name].dtype), ((supports,), np.float64), name)
        np.testing.assert_array_equal(file["support_side"][()], 1)
        rows = len(file["fields/time"])
        interval = self.option("output_field_interval")[0]
        np.testing.assert_allclose(file["fields/time"][()], np.arange(rows) * interval, rtol=1e-15)
        for name in FIELDS:
            field = file["fields"][name]
            self.assertEqual((field.shape, field.dtype), ((rows, nodes), np.float64), name)
        self.assertEqual((file["fields/resting"].shape, file["fields/resting"].dtype), ((rows, nodes), np.uint8))
        ends = file["fields/moment"][()][:, [0, -1]]
        np.testing.assert_allclose(ends, 0, atol=1e-6, err_msg="free ends carry no moment")

    def test_tables_in_results_file(self):
        rest_columns = REST_COLUMNS.replace("event", "release")
        for name, columns in (("impacts", IMPACT_COLUMNS), ("rests", rest_columns), ("energy", ENERGY_COLUMNS)):
            table, text = self.file[name], self.finished.csv(f"{name}.csv")
            self.assertEqual(list(table.dtype.names), columns.split(","), name)
            self.assertEqual(len(table), len(text["time"]), name)
            for column in columns.split(","):
                if column != "release":
                    np.testing.assert_array_equal(table[column], text[column], err_msg=f"{name}: {column}")
        events = self.finished.csv("rests.csv")["event"]
        np.testing.assert_array_equal(self.file["rests"]["release"] != 0, events == "release")

    def test_xdmf(self):
        path = self.finished.file("results.xdmf")
        tree = xml.etree.ElementTree.parse(path)
        references = [item for item in tree.iter("DataItem") if item.get("Format") == "HDF"]
        self.assertGreater(len(references), 0)
        view = h5py.File(path.parent / "results.vtkhdf", "r")
        self.addCleanup(view.close)
        self.assertFalse(view["VTKHDF/Points"][: len(self.file["x"]), 2].any(), "the beam lies in z = 0")
        for item in references:
            name, dataset = item.text.strip().split(":")
            file = {"results.h5": self.file, "results.vtkhdf": view}[name]
            dimensions = tuple(int(word) for word in item.get("Dimensions").split())
            self.assertIn(dataset, file)
            shape = file[dataset].shape
            self.assertEqual(len(dimensions), len(shape), item.text)
            self.assertEqual(dimensions[1:], shape[1:], item.text)
            # A row of a growing field may know no more rows than there were when it was written.
            self.assertTrue(dimensions[0] == shape[0] or (len(shape) > 1 and dimensions[0] <= shape[0]), item.text)
        rows, nodes = self.file["fields/moment"].shape
        self.assertEqual(len(list(tree.iter("Time"))), rows, "one time for every row of the fields")
        for slab in tree.iter("DataItem"):
            if slab.get("ItemType") == "HyperSlab":
                begin, stride, count = np.array(slab[0].text.split(), int).reshape(3, -1)
                size = np.array(slab[1].get("Dimensions").split(), int)
                self.assertTrue((begin + (count - 1) * stride < size).all(), "hyperslab inside its dataset")
        names = {attribute.get("Name") for attribute in tree.iter("Attribute")}
        self.assertLessEqual({"moment", "mass_position", "mass_velocity"}, names)


class Balance(UdarTest):
    def momentum(self, changes):
        end = 1.0
        result = self.run_case(case(ts_max_time=end, output_field_interval=end, ts_rtol=1e-10, **changes))
        data = datasets(result.file("results.h5"))
        mass = data["mass"]
        self.assertAlmostEqual(mass.sum(), STEEL_MASS, delta=1e-9 * STEEL_MASS, msg=result)
        change = mass @ (data["fields/mass_velocity"][-1] - data["fields/mass_velocity"][0])
        impulse = result.summary()["support_impulse"]
        weight = STEEL_MASS * GRAVITY
        self.assertAlmostEqual(sum(impulse), change + weight * end, delta=1e-6 * weight, msg=result)
        self.assertLess(abs(result.summary()["energy_drift"]), 1e-7)
        return impulse

    def test_momentum_elastic(self):
        left, right = self.momentum({"contact_restitution": 1})
        self.assertAlmostEqual(left, right, delta=1e-6 * left)

    def test_momentum_with_rests(self):
        self.momentum({"contact_restitution": 0.5})

    def test_momentum_plastic_pads(self):
        self.momentum({"contact_restitution": 0, "support_width": 1})

    def test_lift_of_moving_supports_is_in_the_rows(self):
        table = self.scratch / "lift.csv"
        table.write_text("time,height\n0,0\n0.4,0.2\n")  # at rest at both ends
        result = self.run_case(case(support_motion=table, ts_max_time=0.5, initial_height=0.5))
        with h5py.File(result.file("results.h5")) as file:
            time, lift = file["contact"]["time"], file["supports/lift"][()]
        s = np.clip(time / 0.4, 0, 1)
        for of_one in lift.T:
            np.testing.assert_allclose(of_one, 0.2 * s**2 * (3 - 2 * s), rtol=0, atol=1e-15)
        with h5py.File(self.run_case(case(ts_max_time=0.1), name="still").file("results.h5")) as file:
            self.assertNotIn("lift", file["supports"])

    def test_momentum_floor(self):
        """Flat on the floor with e = 0: all stick at once, and the floor then carries the weight."""
        (impulse,) = self.momentum({"contact_restitution": 0, "support_position": None, "floor": True})
        self.assertAlmostEqual(impulse, STEEL_MASS * GRAVITY, delta=1e-6 * STEEL_MASS * GRAVITY)

    def test_zeno(self):
        """A flat fall bounces at t0 + 2 t0 (e + e^2 + ...) and rests at t0 (1 + e) / (1 - e)."""
        e, fall = 0.5, np.sqrt(2 / GRAVITY)
        floor = {"support_position": None, "floor": True}
        result = self.run_case(
            case(contact_restitution=e, contact_tolerance=1e-9, ts_max_time=2, ts_rtol=1e-10, **floor)
        )
        impacts, rests = result.csv("impacts.csv"), result.csv("rests.csv")
        times = impacts["time"][impacts["node"] == 7]
        expected = fall * (1 + 2 * np.cumsum([0, *e ** np.arange(1.0, 12.0)]))
        np.testing.assert_allclose(times[:12], expected, rtol=0, atol=1e-7)
        self.assertEqual(len(rests["time"]), 21, result)
        # What is left of the series when a hop of 1e-9 m ends it.
        last_hop = np.sqrt(8 * 1e-9 / GRAVITY)
        np.testing.assert_allclose(rests["time"], fall * (1 + e) / (1 - e), rtol=0, atol=2 * last_hop)
        np.testing.assert_allclose(result.csv("gauges.csv")["mass_0"][-1], 0, atol=1e-12)


class Forces(UdarTest):
    def test_envelope_of_a_pinned_beam_at_rest(self):
        """Under its weight, lumped at the nodes: w L^2 / 8 in the middle, (w L - w h) / 2 in the first element."""
        elements, length = 20, 10.0
        w, h, bending = STEEL_MASS * GRAVITY / length, length / elements, 2.1e11 * np.pi * 0.1**4 / 4
        x = np.linspace(0, length, elements + 1)
        moment = w * x * (length - x) / 2
        # The three-moment equation at each inner node, the ends held, gives the line where nothing moves.
        slopes = h / (6 * bending) * (moment[:-2] + 4 * moment[1:-1] + moment[2:])
        rises = (np.diag(np.full(elements - 1, -2.0)) + np.eye(elements - 1, k=1) + np.eye(elements - 1, k=-1)) / h
        sag = np.concatenate([[0], np.linalg.solve(rises, slopes), [0]])
        shape = self.scratch / "shape.csv"
        shape.write_text("x,offset\n" + "".join(f"{a:.17g},{b:.17g}\n" for a, b in zip(x, sag)))
        pinned = {"beam_left_end": "pinned", "beam_right_end": "pinned", "support_position": None}
        pinned["beam_yield_stress"] = 30e6
        start = {"initial_height": 0, "initial_shape": shape, "ts_max_time": 0.2, "gauge_position": "5"}
        for ranks in (0, 2, 3):
            with self.subTest(ranks=ranks):
                run = self.run_case(case(**pinned, **start), ranks, name=f"pinned{ranks}")
                envelope = run.csv("envelope.csv")
                shear = np.append(np.diff(moment) / h, np.nan)
                for side in ("min", "max"):
                    # Round-off of the sag, 1e-16 of 0.02 m, times 4 EI / h^2 is 1e-9 of the moment.
                    np.testing.assert_allclose(envelope[f"moment_{side}"], moment, rtol=0, atol=1e-8 * moment.max())
                    np.testing.assert_allclose(envelope[f"shear_{side}"], shear, rtol=0, atol=1e-8 * w * length)
                self.assertAlmostEqual(envelope["moment_max"][10], w * length**2 / 8, delta=1e-8 * w * length**2)
                self.assertAlmostEqual(envelope["shear_max"][0], (w * length - w * h) / 2, delta=1e-8 * w * length)
                with h5py.File(run.file("results.h5")) as file:
                    np.testing.assert_array_equal(file["envelope/moment_max"][()], envelope["moment_max"])
                    np.testing.assert_array_equal(file["envelope/shear_min"][()], envelope["shear_min"][:-1])
                    self.assertEqual(as_text(file["envelope/shear_min"].attrs["units"]), "N")
                self.assertFalse(run.file("contact.csv").exists(), "there are no supports")
                # W = pi r^3 / 4; it stands still, so that the largest moment is that of the first row.
                stress, found = w * length**2 / 8 / (np.pi * 0.1**3 / 4), run.summary()
                self.assertAlmostEqual(found["max_bending_stress"] / stress, 1, delta=1e-8)
                self.assertAlmostEqual(found["max_utilisation"], found["max_bending_stress"] / 30e6, delta=1e-12)
                self.assertEqual((found["max_bending_stress_x"], found["max_utilisation_x"]), (5, 5))
                expected = moment / (np.pi * 0.1**3 / 4)
                np.testing.assert_allclose(envelope["stress_max"], expected, rtol=0, atol=1e-8 * stress)
                np.testing.assert_allclose(envelope["utilisation_max"], envelope["stress_max"] / 30e6, rtol=1e-15)
                self.assertIn("the bending stress reaches 1.28 times the yield stress, at x = 5 m", run.err)

    def test_bending_stress_by_section(self):
        """c / I of each section and at a joint, the larger side; null where the outermost fibre is not known."""
        two = {"beam_length": "5,5", "beam_elements": "10,10", "ts_max_time": 0.5, "filter_frequency": 1000}
        tube = np.pi / 4 * (0.1**4 - 0.08**4) / 0.1
        bar = 0.1 * 0.2**2 / 6
        direct = {"beam_section": "direct", "beam_area": 0.02, "beam_inertia": 1e-5, "beam_radius": None}
        for name, options, left, right in (
            ("mixed", {"beam_section": "tube,rectangle", "beam_radius": 0.1, "beam_inner_radius": 0.08,
                       "beam_width": 0.1, "beam_height": 0.2}, tube, bar),
            ("given", {**direct, "beam_outer_fibre": 0.1}, 1e-4, 1e-4),
            ("stiffness", {"beam_bending_stiffness": "2.1e6,4.2e6", "beam_outer_fibre": "0.05,0.2"}, 2e-4, 1e-4),
            ("unknown", direct, np.nan, np.nan),
            ("replaced", {"beam_bending_stiffness": 2.1e6}, np.nan, np.nan),
        ):
            with self.subTest(name):
                run = self.run_case(case(**{**two, **options}), name=name)
                envelope, found = run.csv("envelope.csv"), run.summary()
                modulus = np.r_[np.full(10, left), min(left, right), np.full(10, right)]
                most = np.maximum(-envelope["moment_min"], envelope["moment_max"])
                np.testing.assert_allclose(envelope["stress_max"], most / modulus, rtol=1e-12)
                self.assertTrue(np.isnan(envelope["utilisation_max"]).all())
                self.assertIsNone(found["max_utilisation"])
                if np.isnan(left):
                    self.assertIsNone(found["max_bending_stress"])
                    continue
                worst = int(np.argmax(envelope["stress_max"]))
                self.assertEqual(found["max_bending_stress"], envelope["stress_max"][worst])
                self.assertEqual(found["max_bending_stress_x"], envelope["x"][worst])
                self.assertGreater(found["max_bending_stress_time"], np.sqrt(2 / GRAVITY), "after the fall")

    def test_floor_carries_the_weight_and_the_window_is_stated(self):
        """Flat on the floor with e = 0: the blow in one window, then the weight."""
        floor = {"support_position": None, "floor": True, "contact_restitution": 0, "initial_height": 0.1}
        run = self.run_case(case(**floor, output_interval=0.01, output_force_window=0.045, ts_max_time=0.5))
        window, rows = run.summary()["force_window"], run.csv("contact.csv")
        self.assertAlmostEqual(window, 0.05, delta=1e-15)
        weight, fall = STEEL_MASS * GRAVITY, np.sqrt(0.2 / GRAVITY)
        given = np.where(rows["time"] > fall, weight * rows["time"], 0)
        np.testing.assert_allclose(rows["impulse_0"], given, rtol=0, atol=1e-8 * weight)
        settled = rows["time"] > fall + window
        self.assertGreater(np.count_nonzero(settled), 20)
        np.testing.assert_allclose(rows["force_0"][settled], weight, rtol=1e-6)
        # In the last window that has the blow: all that the fall had gathered, and the weight since.
        first = np.argmax(rows["time"] > fall)
        sample = 0.01 / 2  # the longest part of the interval that is no longer than pi / (4 wf) = 0.00785
        self.assertAlmostEqual(run.summary()["peak_force_window"], 0.045, delta=1e-15)
        peak = weight * np.floor((fall + 0.045) / sample) * sample / 0.045
        self.assertAlmostEqual(run.summary()["peak_support_force"][0], peak, delta=1e-6 * peak)
        np.testing.assert_array_equal(rows["masses"], np.where(rows["time"] > fall, 21, 0))
        np.testing.assert_array_equal(rows["x_max"][first:], 10)
        with h5py.File(run.file("results.h5")) as file:
            self.assertEqual(file["supports"].attrs["force_window"], window)
            np.testing.assert_array_equal(file["supports/impulse"][:, 0], rows["impulse_0"])
            np.testing.assert_array_equal(file["contact"]["time"], rows["time"])


    def test_extremes_belong_to_the_motion_and_not_to_the_rows(self):
        """No row but the first within the contact: peak forces and moments are those of a run with many rows."""
        options = {"ts_max_time": 0.6, "output_force_window": 0.039}
        few = self.run_case(case(output_interval=10, **options), name="few")
        many = self.run_case(case(output_interval=0.002, **options), name="many")
        self.assertAlmostEqual(few.summary()["peak_force_window"], 5 * 10 / 1274, delta=1e-12)  # 1274 > 10 / (pi / 400)
        for peak, expected in zip(few.summary()["peak_support_force"], many.summary()["peak_support_force"]):
            self.assertGreater(peak, 1e5)
            # Windows of nearly equal length; where they begin differs by a tenth of one at most.
            self.assertAlmostEqual(peak / expected, 1, delta=0.25)
        for name in ("moment_min", "moment_max"):
            moments, expected = few.csv("envelope.csv")[name], many.csv("envelope.csv")[name]
            np.testing.assert_allclose(moments, expected, rtol=0, atol=0.05 * np.abs(expected).max())


class LineSupports(UdarTest):
    """A beam that hangs between supports of its line and swings about its sag."""

    def hang(self, name, ranks, **changes):
        options = {"support_position": None, "initial_height": 0, "gauge_position": "2,5,8", "filter_frequency": 50}
        options |= {"beam_line_support_position": "2,8", "ts_max_time": 1, "ts_rtol": 1e-10, **changes}
        result = self.run_case(case(**options), ranks, name=name)
        self.assertEqual(result.summary()["impacts"], 0, result)
        self.assertLess(abs(result.summary()["energy_drift"]), 1e-7, result)
        gauges = result.csv("gauges.csv")
        self.assertLess(gauges["line_1"].min(), -1e-3, f"the middle sags{result}")
        self.assertLess(gauges["mass_1"].max(), 1e-3, f"and swings back to the axis{result}")
        return gauges

    def test_rigid(self):
        for ranks in LAUNCHES:
            with self.subTest(ranks=ranks):
                gauges = self.hang(f"rigid{ranks}", ranks)
                for column in ("line_0", "mass_0", "velocity_0", "line_2", "mass_2", "velocity_2"):
                    np.testing.assert_array_equal(gauges[column], 0, err_msg=column)

    def test_elastic(self):
        """Springs give way; very stiff ones are almost rigid."""
        rigid = self.hang("rigid", 0)
        soft = self.hang("soft", 0, beam_line_support_stiffness=1e6)
        stiff = self.hang("stiff", 0, beam_line_support_stiffness="1e13,1e13")
        self.assertLess(soft["line_0"].min(), -1e-3)
        np.testing.assert_allclose(stiff["line_1"], rigid["line_1"], rtol=0, atol=1e-7)
        self.assertLess(np.abs(stiff["line_0"]).max(), 1e-7)


class Printing(UdarTest):
    def test_view(self):
        result = self.run_case(case(filter_frequency=50, beam_elements=80, udar_view=True, ts_max_time=0.01,
                                    initial_velocity=-0.25, beam_yield_stress=2.5e8))
        self.assertRegex(result.out, r"initial velocity \[m/s\].* -0\.25 0\n")
        self.assertRegex(result.out, r"yield stress \[Pa\].* 2\.5e\+08\n")
        for words in (("frequenc", "rad/s"), ("decay",), ("stiffness",), ("sag",), ("warning",)):
            for word in words:
                self.assertIn(word, (result.out + result.err).lower(), f"-udar_view{result}")
        decay = (4 * 2.1e11 * np.pi * 0.1**4 / 4 / (7850 * np.pi * 0.1**2 * 50**2)) ** 0.25
        self.assertIn(f"{decay:.2g}", result.out + result.err, "decay length of the line [m]")

    def test_warnings_are_kept(self):
        """summary.json has every warning of the terminal, in order, before the run and at its end."""
        coarse = {"ts_type": "rk", "ts_adapt_type": "none", "ts_dt": 0.04, "ts_max_time": 0.8}
        options = case(filter_frequency=50, nobody_knows=1, **coarse)
        result = self.run_case(options, name="warned")
        said = re.findall(r"^udar: warning: (.*)$", result.err, re.MULTILINE)
        self.assertEqual(result.summary()["warnings"], said)
        for finding, text in zip(("read by nobody", "lowers the first", "sink", "energy balance"), said, strict=True):
            self.assertIn(finding, text, result)
        near = {"initial_height": 0.01, "ts_max_time": 0.05}
        silent = self.run_case(case(filter_frequency=1000, contact_surface="line", **near), name="silent")
        self.assertEqual(silent.summary()["warnings"], [], silent)

    def test_echo(self):
        """What the run is about to do: mass, contact of a fall of 1 m, what the filter makes of the first mode."""
        result = self.run_case(case(ts_max_time=0.5))
        lines = result.out.splitlines()
        echo = next(number for number, line in enumerate(lines, 1) if line.startswith("output "))
        self.assertLessEqual(echo, 8, result)
        self.assertLessEqual(len(lines), echo + 25, result)
        mass = f"{STEEL_MASS:.4g} kg"
        modes = self.run_case(case(ts_max_time=0.5, udar_view=True), name="view").out
        first = float(re.search(r"^ +1 +([0-9.]+)", modes, re.MULTILINE).group(1))
        filtered = f"{100 * first / np.hypot(100, first):.4g} rad/s"
        contact = f"t = {np.sqrt(2 / 9.81):.4g} s"
        for words in (
            (mass, "10 m", "20 elements"),
            (f"{first:.4g}, ",),
            ("wf = 100 rad/s", filtered),
            ("2 below", "x = 2 m, 8 m"),
            (contact,),
            ("51 rows", "51 of fields"),
        ):
            self.assertTrue(any(all(word in line for word in words) for line in lines), f"{words}{result}")

    def test_hard_to_believe(self):
        """A slip of unit or sign is named, with the unit; nothing is said of the paper's beam."""
        slips = (
            ({"beam_young_modulus": 210}, ("-beam_young_modulus of 210 Pa", "2.1e11 Pa")),
            ({"beam_density": 7.85}, ("-beam_density of 7.85 kg/m^3",)),
            ({"beam_radius": 100}, ("radius of gyration of 50 m", "metres")),
            ({"beam_radius": 3}, ("10 m long", "6.67 times")),
            ({"initial_height": 1e4}, ("starts 10000 m from a support", "metres")),
            ({"initial_height": 1e4}, ("first contact is expected at t = 45.15 s", "after the end")),
            ({"gravity": -9.81}, ("-gravity -9.81 m/s^2 pulls upwards",)),
            ({"support_position": None}, ("no support",)),
            ({"initial_velocity": 10, "ts_max_time": 0.1}, ("after the end",)),
            ({"support_side": "above", "initial_height": -1}, ("nothing touched a support",)),
            ({}, ()),
        )
        for change, words in slips:
            with self.subTest(change=change):
                result = self.run_case(case(**{"ts_max_time": 0.01, "initial_height": 1e-4, **change}), name="slip")
                said = [text for text in result.summary()["warnings"] if "filter" not in text and "sink" not in text]
                found = any(all(word in text for word in words) for text in said)
                self.assertTrue(found if words else not said, f"{said}{result}")
                shutil.rmtree(result.directory)

    def test_places(self):
        """Who is taken to a node far away is named with both places; a width of one node, too; others are not."""
        coarse = {"beam_elements": 10, "ts_max_time": 0.01}
        for change, words in (
            ({"gauge_position": "5,5.3"}, ("gauge 1 at x = 5.3 m", "nearest node, at x = 5 m", "-beam_elements")),
            ({"gauge_position": "5.15"}, ()),
            ({"support_position": "2.4,8"}, ("support 0 at x = 2.4 m", "at x = 2 m")),
            ({"support_width": "0.6,0"}, ("support 0 is 0.6 m wide", "one node, 2 at x = 2 m", "elements of 1 m")),
            ({"support_width": "2,0"}, ()),
            ({"gauge_position": "0.5,1.5,2.5,3.5"}, ("gauge 2 at x = 2.5 m", "and 1 more")),
        ):
            with self.subTest(change=change):
                result = self.run_case(case(**coarse, **{"gauge_position": "5", **change}), name="places")
                said = [text for text in result.summary()["warnings"] if "node" in text]
                found = len(said) == 1 and all(word in said[0] for word in words)
                self.assertTrue(found if words else not said, f"{said}{result}")
                shutil.rmtree(result.directory)

    def test_modes_where_the_line_is_held_without_a_filter(self):
        """Chosen by themselves, with a second run that says how far the numbers are off."""
        held = {"filter_frequency": None, "contact_surface": "line", "contact_restitution": 1, "ts_max_time": 0.6}
        for stiffness, rigid in (("inf", True), (1e8, False)):
            result = self.run_case(case(**held, support_stiffness=stiffness), name=f"modes-{rigid}")
            summary = result.summary()
            self.assertEqual(summary["integrator"], "modal", result)
            estimate = summary["modal_estimate"]
            self.assertGreaterEqual(estimate["modes"], 1.4 * summary["integrator_counts"]["modes"])
            shares = np.divide(estimate["support_impulse"], summary["support_impulse"])
            self.assertTrue(np.all(shares < (0.1 if rigid else 2e-3)), result)
            self.assertTrue(np.all(shares > 0.0), result)
            self.assertIn("udar: ", [line[:6] for line in result.out.splitlines() if "modes in place of" in line])
            self.assertFalse((result.directory / "more_modes").exists())
            radiated = result.csv("energy.csv")["radiated"]
            self.assertTrue(np.all(np.diff(radiated) >= 0.0))
            self.assertEqual(radiated[-1] > 0.0, rigid)
        result = self.run_case(case(**held, modal_estimate="no"), name="alone")
        self.assertNotIn("modal_estimate", result.summary())

    def test_step_of_the_unfiltered_beam(self):
        """-ts_dt is shortened to divide the interval and the end; one that does not resolve vibration is named."""
        lumped = {"filter_frequency": "none", "ts_type": "moreau", "ts_max_time": 0.02}
        result = self.run_case(case(**lumped, ts_dt=3e-4), name="short")
        self.assertEqual(result.summary()["steps"], 2 * 34)  # 0.01 / 34 is the longest such step up to 3e-4
        self.assertEqual([text for text in result.summary()["warnings"] if "resolve" in text], [])
        result = self.run_case(case(**{**lumped, "ts_max_time": 0.1}, ts_dt=0.02, output_interval=0.02), name="long")
        self.assertEqual(result.summary()["steps"], 5)
        said = [text for text in result.summary()["warnings"] if "resolve" in text]
        self.assertEqual(len(said), 1, result)
        for words in ("time step of 0.02 s", "1.15 times 1 / w1", "w1 = 57.", "-ts_dt"):
            self.assertIn(words, said[0])

    def test_automatic_filter_frequency(self):
        outputs = []
        for ranks in (1, 2, 3):
            options = case(filter_frequency="auto", filter_accuracy=0.001, filter_modes=2, ts_max_time=0.01)
            result = self.run_case(options, ranks, f"auto-{ranks}")
            table = re.findall(r"^ +(\d+) +([\d.]+) +([\d.]+) +-([\d.]+) %$", result.out, re.MULTILINE)
            self.assertEqual([row[0] for row in table], ["1", "2"], result)
            w, filtered, error = (np.array([float(row[i]) for row in table]) for i in (1, 2, 3))
            wf = float(re.search(r"wf ([\d.]+) rad/s", result.out)[1])
            # Six digits of the frequencies, four decimals of the errors in percent.
            np.testing.assert_allclose(filtered, wf * w / np.hypot(wf, w), rtol=5e-6)
            np.testing.assert_allclose(error, 100 * (1 - filtered / w), atol=6e-4)
            self.assertEqual(table[1][3], "0.1000", "the accuracy asked for, no more")
            with h5py.File(result.file("results.h5")) as file:
                self.assertAlmostEqual(file.attrs["filter_frequency"], wf, delta=1e-9 * wf)
                outputs.append(file.attrs["filter_frequency"])
        self.assertEqual(len(set(outputs)), 1, "the same to the last bit on any number of ranks")

    def test_corrected_modes(self):
        result = self.run_case(
            case(filter_correct_modes=2, filter_correct_mode=4, udar_view=True, ts_max_time=0.01), name="corrected"
        )
        number = r"([\d.]+)"
        corrected = re.findall(rf"mode (\d): filtered {number} rad/s, corrected to {number} rad/s", result.out)
        self.assertEqual([row[0] for row in corrected], ["1", "4"], result)
        for _, filtered, w in corrected:
            self.assertAlmostEqual(float(filtered), 100 * float(w) / np.hypot(100, float(w)), delta=1e-6)
        self.assertRegex(result.out, r"mode 2, 157\.43\d* rad/s, is above wf 100\.? rad/s and left uncorrected")
        found = re.search(rf"largest frequency {number} .*before, {number} rad/s", result.out)
        before, after = map(float, found.groups())
        self.assertLess(before, 100)
        self.assertAlmostEqual(after, float(corrected[1][2]), delta=1e-5 * after)
        self.assertEqual(result.out.count("corrected to 0"), 2, "in the table of -udar_view")

    def test_solver_view(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                out = self.run_case(
                    case(filter_ksp_view=True, ts_max_time=0.01, beam_elements=200), ranks, f"ksp-view-{ranks}"
                ).out
                self.assertEqual(out.count("type: chain"), 1, out)
                for word in ("decay length", "joints", "coupling of ranks"):
                    self.assertIn(word, out)

    def test_solver_of_a_line_under_tension(self):
        out = self.run_case(case(udar_view=True, ts_max_time=0.01, beam_tension=1e5), name="tension").out
        self.assertIn("assembled block form, because the chain recursion cannot carry it: tension", out)

    def test_help(self):
        result = run({"help": True}, cwd=self.scratch)
        self.assertEqual(result.code, 0, result)
        for name in HELP_OPTIONS:
            self.assertRegex(result.out, rf"-{name}\b", "missing in -help")
        for unit in HELP_UNITS:
            self.assertIn(unit, result.out)
        self.assertEqual(list(self.scratch.iterdir()), [], "-help writes nothing")

    def test_reader_that_stops_reading(self):
        """`udar -help | head` is no crash, though PETSc takes SIGPIPE."""
        reader = subprocess.Popen(["true"], stdin=subprocess.PIPE)
        reader.wait()
        done = subprocess.run(
            command({"help": True}), stdout=reader.stdin, stderr=subprocess.PIPE, text=True, timeout=60)
        reader.stdin.close()
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_help_of_a_topic(self):
        ours = self.run_case({"help": "support"}).out
        keys = [line.split()[0] for line in ours.splitlines() if line.startswith("  -")]
        self.assertIn("-support_position", keys)
        self.assertEqual([key for key in keys if "support" not in key], [], ours)
        self.assertNotIn("usage:", ours)
        petsc = self.run_case({"help": "ts"}).out
        self.assertIn("  -ts_max_time", petsc)
        self.assertIn("  -ts_adapt_type", petsc, "PETSc's own")
        self.assertNotIn("  -filter", petsc)
        self.assertIn("no key of that topic", run({"help": "suport"}).errors[0])

    def test_version(self):
        for key in ("-version", "--version"):
            out = run({}, extra=[key]).out
            self.assertRegex(out, r"^udar \d+\.\d+\.\d+")
            for library in ("petsc", "slepc", "hdf5", "mpi"):
                self.assertRegex(out, rf"{library} +\S")

    def test_supports_as_objects(self):
        path = self.scratch / "case.yaml"
        path.write_text("support:\n  - {position: 2, width: 0.5}\n  - {position: 8, height: 0.1}\n")
        objects = self.run_case(case(support_position=None, ts_max_time=0.5, options_file=path), name="objects")
        lists = self.run_case(case(support_width="0.5,0", support_height="0,0.1", ts_max_time=0.5), name="lists")
        for name, column in lists.csv("gauges.csv").items():
            np.testing.assert_array_equal(objects.csv("gauges.csv")[name], column)

    def test_logs_of_petsc(self):
        """Each form of -log_view, from the command line and from a file, beside the costs in summary.json."""
        for form, word in (("ascii_flamegraph", "FilterSolve"), ("ascii_xml", "<?xml"), ("ascii_info", "FilterSolve")):
            path = self.scratch / f"log.{form}"
            options = self.scratch / "log.yaml"
            options.write_text(f"log_view: ':{path}:{form}'\n")
            for source in ({"log_view": f":{path}:{form}"}, {"options_file": options}):
                with self.subTest(form=form, source=source):
                    path.unlink(missing_ok=True)
                    done = self.run_case(case(ts_max_time=0.5, output_overwrite=True, **source), name="logged")
                    self.assertIn(word, path.read_text())
                    self.assertGreater(done.summary()["wall_seconds"]["line_solve"], 0)

    def test_quiet_under_mpiexec(self):
        """mpiexec gives every rank a terminal of its own; what the user reads is still a pipe."""
        result = self.run_case(case(beam_elements=400, support_width=1), 2)  # seconds, not milliseconds
        self.assertNotIn("\r", result.out + result.err)
        self.assertNotIn("\x1b", result.out + result.err)

    def test_minimal_case(self):
        """The filter frequency and a beam are enough; results go where they are told."""
        result = self.run_case({"filter_frequency": 100, "ts_max_time": 0.1})
        self.assertTrue(result.file("summary.json").is_file())


class Interrupted(UdarTest):
    def test_sigint(self):
        """A long run ends in order with exit code 130, readable files and a restart file that goes on."""
        options = case(
            output_directory=self.scratch / "run",
            ts_max_time=1e5,
            output_interval=0.5,
            output_field_interval=0.5,
            restart_interval=1.0,
        )
        process = start(command(options), cwd=self.scratch)
        gauges = self.scratch / "run" / "gauges.csv"
        for _ in range(200):
            if (self.scratch / "run" / "restart.previous.h5").exists() or process.poll() is not None:
                break
            time.sleep(0.05)
        out, err = self.interrupt(process, after=0.5)
        self.assertEqual(process.returncode, 130, out + err)
        self.assertNotIn("PETSC ERROR", err)
        rows = len(gauges.read_text().splitlines())
        self.assertGreater(rows, 2, "rows written before the signal")
        with h5py.File(self.scratch / "run" / "results.h5", "r") as file:
            times = file["fields/time"][()]
            self.assertGreater(len(times), 1)
            self.assertEqual(len(file["energy"]), rows - 1)
        json.loads((self.scratch / "run" / "summary.json").read_text())
        xml.etree.ElementTree.parse(self.scratch / "run" / "results.xdmf")
        reached = (rows - 2) * 0.5
        rest = self.run_case(
            {
                **options,
                "output_directory": self.scratch / "rest",
                "restart_file": self.scratch / "run" / "restart.h5",
                "ts_max_time": reached + 2.0,
            }
        )
        after = rest.csv("gauges.csv")["time"]
        self.assertEqual(after[-1], reached + 2.0)
        self.assertLessEqual(after[0], reached + 0.5, "nothing is missing between the files")

    def started(self, process, *files):
        """Waits until a run has written these files of its folder."""
        for _ in range(600):
            if process.poll() is not None or all((self.scratch / "run" / name).exists() for name in files):
                break
            time.sleep(0.05)
        self.assertIsNone(process.poll(), "the run is to go on")

    def long_run(self, ranks=0, **changes):
        shutil.rmtree(self.scratch / "run", ignore_errors=True)
        endless = {"ts_max_time": 1e5, "output_allow_large": True}
        options = case(output_directory=self.scratch / "run", output_overwrite=True, **endless, **changes)
        return options, start(command(options, ranks), cwd=self.scratch)

    def test_signals_of_terminals_and_batch_systems(self):
        for number in (signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2, signal.SIGTERM):
            with self.subTest(signal=number.name):
                _, process = self.long_run(output_interval=0.5)
                self.started(process, "energy.csv")
                process.send_signal(number)
                process.send_signal(number)  # from the shell and from the terminal
                out, err = process.communicate(timeout=60)
                self.assertEqual(process.returncode, 128 + number, out + err)
                for name in ("restart.h5", "summary.json", "envelope.csv"):
                    self.assertTrue((self.scratch / "run" / name).exists(), name)

    def test_second_signal_ends_at_once(self):
        """A run that is stuck, here in a pipe that nobody reads, cannot end in order."""
        options = case(ts_max_time=1e5, output_interval=0.5, ts_monitor=True, ts_dt=1e-4, ts_type="rk",
                       ts_adapt_type="none", output_allow_large=True, output_directory=self.scratch / "run")
        process = start(command(options), cwd=self.scratch)
        self.started(process, "energy.csv")
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        time.sleep(0.5)
        self.assertIsNone(process.poll(), "it is to be stuck")
        process.send_signal(signal.SIGINT)
        process.wait(timeout=5)
        self.assertEqual(process.returncode, -signal.SIGINT)

    def test_nohup(self):
        """What the program was started to ignore stays ignored."""
        large = {"output_allow_large": True}
        options = case(output_directory=self.scratch / "run", ts_max_time=1e5, output_interval=0.5, **large)
        process = start(["nohup"] + command(options), cwd=self.scratch)
        self.started(process, "energy.csv")
        process.send_signal(signal.SIGHUP)
        time.sleep(0.5)
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 143)

    def test_killed_run_loses_no_row(self):
        """What a killed run has on the disk reaches at least to its checkpoint, from which the next goes on."""
        rows, field_rows = 0.0005, 0.002
        often = {"output_interval": rows, "output_field_interval": field_rows, "restart_interval": 0.004}
        contact = {"initial_height": 0.05, "contact_restitution": 0.7, "ts_type": "impact", "gauge_position": "0,5,10"}
        for ranks, seconds in ((0, 0.4), (2, 0.7), (2, 1.1)):
            with self.subTest(ranks=ranks, seconds=seconds):
                shutil.rmtree(self.scratch / "run", ignore_errors=True)  # whose restart files are not to be waited for
                options, process = self.long_run(ranks, **often, **contact)
                self.started(process, "restart.previous.h5")
                time.sleep(seconds)
                os.kill(children(process.pid)[0] if ranks else process.pid, signal.SIGKILL)
                process.communicate(timeout=60)
                killed, checkpoint = self.scratch / "run", self.scratch / "run" / "restart.h5"
                with h5py.File(checkpoint) as file:
                    reached = dict(file["scalars"].attrs)
                more = {"output_directory": self.scratch / "rest", "restart_file": checkpoint}
                end = field_rows * (np.floor(reached["time"] / field_rows) + 3)
                rest = self.run_case({**options, **more, "ts_max_time": end})
                parts = []
                for run_folder in (killed, rest.directory):
                    with h5py.File(run_folder / "results.h5") as file:
                        fields, energy = file["fields/time"][()], file["energy"]["time"]
                        contact_rows, impacts = file["contact"]["time"], file["impacts"]["time"]
                    tables = [read_csv(run_folder / f"{name}.csv")["time"] for name in ("gauges", "energy", "contact")]
                    xdmf = (run_folder / "results.xdmf").read_text().count("<Time ")
                    parts.append((fields, fields[:xdmf], energy, contact_rows, *tables, impacts))
                *intervals, _ = (field_rows, field_rows, *[rows] * 5, None)
                for interval, before, after in zip(intervals, *parts):
                    joined = np.append(before[before <= reached["time"]], after)
                    np.testing.assert_allclose(joined, interval * np.arange(len(joined)), rtol=1e-12, atol=0)
                    self.assertAlmostEqual(joined[-1], end, delta=1e-9)
                # Impacts that the checkpoint counts are in the first part, and in its text.
                for impacts in (parts[0][-1], read_csv(killed / "impacts.csv")["time"]):
                    self.assertEqual(np.count_nonzero(impacts <= reached["time"]), reached["impacts"])

    def test_kill_within_a_flush(self):
        """Readers refuse a file that is shorter than HDF5 has already written that it is."""
        rows = 0.0005
        often = {"output_interval": rows, "output_field_interval": 0.002, "restart_interval": 0.004}
        contact = {"initial_height": 0.05, "contact_restitution": 0.7, "ts_type": "impact", "gauge_position": 5}
        for ranks, resizes in ((0, range(6, 13)), (2, range(6, 9))):
            for resize in resizes:
                with self.subTest(ranks=ranks, resize=resize):
                    shutil.rmtree(self.scratch / "run", ignore_errors=True)
                    options = case(ts_max_time=0.4, output_directory=self.scratch / "run", **often, **contact)
                    preload = {"LD_PRELOAD": os.environ["UDAR_KILL_AT_RESIZE"], "KILL_AT_RESIZE": str(resize)}
                    run(options, ranks, environment=preload)
                    self.assertFalse((self.scratch / "run" / "summary.json").exists(), "the run is to be killed")
                    with h5py.File(self.scratch / "run" / "restart.h5") as file:
                        reached = file["scalars"].attrs.get("time", 0.0)  # none before the first checkpoint
                    with h5py.File(self.scratch / "run" / "results.h5") as file:
                        for times in (file["energy"]["time"], file["contact"]["time"]):
                            np.testing.assert_allclose(times, rows * np.arange(len(times)), rtol=1e-12, atol=0)
                            self.assertGreater(times[-1] if len(times) else 0.0, reached - rows * (1 + 1e-9))

    def test_shortest_restart_interval(self):
        """Intervals are counted: adding 1e-12 s up to the next step would never end."""
        for interval in (1e-12, 1e-300):
            run = self.run_case(case(beam_elements=4, ts_max_steps=2, restart_interval=interval), code=STOPPED_BY_STEPS)
            self.assertTrue(run.file("restart.h5").exists())
            shutil.rmtree(run.directory)

    def test_stop_between_the_rows_of_a_step(self):
        """A step may hold minutes of rows: the run ends at once all the same, and goes on behind the last row."""
        every = 1e-6
        parts = []
        for ts_type in ("chebyshev", "impact"):
            parts.clear()
            restart = None
            for name in ("run", "rest"):
                shutil.rmtree(self.scratch / name, ignore_errors=True)
            for name in ("run", "rest"):
                options = case(
                    ts_type=ts_type,
                    output_directory=self.scratch / name,
                    output_overwrite=True,
                    output_interval=every,
                    output_field_interval=0,
                    gauge_position=5,
                    restart_file=restart,
                )
                process = start(command(options), cwd=self.scratch)
                gauges = self.scratch / name / "gauges.csv"
                for _ in range(600):
                    if process.poll() is not None or (gauges.exists() and gauges.stat().st_size > 100000):
                        break
                    time.sleep(0.05)
                process.send_signal(signal.SIGTERM)
                begin = time.monotonic()
                out, err = process.communicate(timeout=60)
                self.assertEqual(process.returncode, 143, out + err)
                self.assertLess(time.monotonic() - begin, 5, "a second on a machine of its own")
                restart = self.scratch / name / "restart.h5"
                parts.append(read_csv(gauges))
            with h5py.File(self.scratch / "run" / "restart.h5", "r") as file:
                self.assertGreater(file["scalars"].attrs["last_row_time"], file["scalars"].attrs["time"])
            times = np.concatenate([part["time"] for part in parts])
            np.testing.assert_allclose(np.diff(times), every, rtol=1e-9, err_msg="no row lost, none twice")
            heights = np.concatenate([part["mass_0"] for part in parts])
            np.testing.assert_allclose(heights, 1 - 0.5 * 9.81 * times**2, atol=1e-7, err_msg=f"free fall, {ts_type}")

    def test_removed_results_are_an_error(self):
        options, process = self.long_run(output_interval=0.5)
        self.started(process, "energy.csv")
        (self.scratch / "run" / "results.h5").unlink()
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, err)
        self.assertIn("results.h5': it was removed or replaced while the run wrote into it", err)
        self.assertTrue((self.scratch / "run" / "restart.h5").exists(), "what is not gone is kept")

    def test_error_under_mpiexec_gives_the_prompt_back(self):
        """mpiexec waits twice its sigkill timeout, 1 s by default, whoever has ended already."""
        seconds = []
        for options, code in (({"help": True}, 0), ({"beam_radius": -1}, 1)):
            line = f"source {ROOT}/scripts/env.sh && exec " + shlex.join(command(options, 2))
            begin = time.monotonic()
            process = subprocess.run(["bash", "-c", line], env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
            seconds.append(time.monotonic() - begin)
            self.assertEqual(process.returncode, code, process.stderr)
        self.assertLess(seconds[1] - seconds[0], 6, "besides starting and ending the program [s]")


def children(parent):
    """Processes that `parent` has started."""
    found = []
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue  # it has ended meanwhile
        if int(fields[1]) == parent:
            found.append(int(entry.name))
    return found


# Part of what another key of the table says, or what has no place in a run that goes on from a falling beam.
NOT_TRIED = {
    "options_file", "help", "version", "citations", "continue", "restart_file", "output_directory", "filter_band",
    "filter_modes", "filter_accuracy",
    "beam_inner_radius", "beam_width", "beam_height", "beam_area", "beam_inertia", "beam_gap", "beam_left_spring",
    "beam_right_spring", "beam_yield_hardening",
    "beam_left_rotational_spring", "beam_right_rotational_spring", "filter_correct_mode", "ts_max_time",
    "structure_type", "structure_stiffness", "structure_mass", "structure_points", "structure_lumping",
    "structure_write", "output_members", "damping_ratio", "modal_estimate", "gauge_place", "gauge_junction",
    "network_file", "network_groups", "network_grillage", "network_lattice", "network_spacing", "network_elements",
    "network_grading", "network_section",
    "network_section_radius", "network_section_inner_radius", "network_section_width", "network_section_height",
    "network_young_modulus", "network_poisson_ratio", "network_density", "network_theory", "network_rotation",
    "network_partition", "network_shift", "support_normal", "support_friction", "support_y_position", "support_y_width",
    "striker_position", "striker_place", "striker_junction", "striker_mass", "striker_gap", "striker_velocity",
    "striker_side", "striker_restitution", "striker_yield_speed", "striker_law", "striker_stiffness",
    "striker_exponent", "striker_damping", "striker_unloading_stiffness", "striker_plateau_force",
    "striker_bottoming_compression", "striker_bottoming_stiffness", "striker_table",
    "pair_from_place", "pair_from_junction", "pair_to_place", "pair_to_junction", "pair_normal", "pair_gap",
    "pair_restitution", "pair_yield_speed", "pair_law", "pair_stiffness", "pair_exponent", "pair_damping",
    "pair_unloading_stiffness", "pair_plateau_force", "pair_bottoming_compression", "pair_bottoming_stiffness",
    "pair_table", "initial_part", "initial_part_velocity",
    "support_z_position", "support_z_width", "support_box", "support_height_field", "support_field_tolerance",
    "load_place", "load_junction", "load_direction", "load_spectrum",
    "initial_velocity_x", "initial_velocity_z", "initial_spin", "rotary_inertia", "base_motion_direction",
    "base_motion_scale",
}


def changes_at_a_restart(folder):
    """(name, keys, what the refusal says: quantity, value there, value here; empty if the run goes on)."""
    tables = {"load": "0,0\n1,1\n", "motion": "0,0\n1,0\n", "ground": "0,-1\n10,-1\n", "shape": "0,0\n10,0\n",
              "curve": "0,0\n1,4\n2,5\n"}
    for name, text in tables.items():
        (folder / f"{name}.csv").write_text(text)
    path = {name: folder / f"{name}.csv" for name in tables}
    refused = (
        ({"beam_length": 11}, "beam lengths [m]: 10 there, 11 here"),
        ({"beam_elements": 22}, "beam elements: 20 there, 22 here"),
        ({"beam_young_modulus": 2e11}, "bending stiffness EI [N m^2]: 16493361.43134642 there"),
        ({"beam_density": 8000}, "mass per length rhoA [kg/m]: 246.615"),
        ({"beam_radius": 0.11}, "bending stiffness EI", "mass per length rhoA"),
        ({"beam_section": "direct", "beam_radius": None, "beam_area": 1, "beam_inertia": 1},
         "bending stiffness EI", "mass per length rhoA"),
        ({"beam_theory": "timoshenko"}, "shear stiffness kGA [N]: inf there"),
        ({"beam_theory": "timoshenko", "beam_poisson_ratio": 0.2}, "shear stiffness kGA [N]: inf there"),
        ({"beam_theory": "timoshenko", "beam_shear_coefficient": 0.9}, "shear stiffness kGA [N]: inf there"),
        ({"beam_theory": "timoshenko", "beam_shear_stiffness": 1e9}, "shear stiffness kGA [N]: inf there, 1e+09 here"),
        ({"beam_bending_stiffness": 1e7}, "bending stiffness EI [N m^2]: 16493361.43134642 there, 1e+07 here"),
        ({"beam_mass_per_length": 200}, "mass per length rhoA [kg/m]: 246.61502330679878 there, 200 here"),
        ({"beam_foundation": 1}, "foundation [N/m^2]: 0 there, 1 here"),
        ({"beam_tension": 5}, "tension [N]: 0 there, 5 here"),
        ({"beam_yield_moment": 1e6, "beam_hinge_position": 5, "beam_hinge_hardening": 3},
         "yield moments [N m]: none there, 1e+06 here", "hinges, positions [m]: none there, 5 here",
         "hinges, hardening [N m/rad]: none there, 3 here", "stiffness after yielding over EI: none there, 0 here"),
        ({"beam_shape_factor": 1.5, "beam_yield_stress": 1e8, "beam_hinge_position": 5},
         "yield moments [N m]: none there, 117809.", "hinges, positions [m]", "hinges, hardening [N m/rad]",
         "stiffness after yielding over EI"),
        ({"beam_left_end": "pinned"}, "ends, stiffness against displacement [N/m]: 0 0 there, inf 0 here"),
        ({"beam_right_end": "clamped"}, "ends, stiffness against displacement [N/m]: 0 0 there, 0 inf here",
         "ends, stiffness against rotation [N m/rad]: 0 0 there, 0 inf here"),
        ({"beam_line_support_position": 5, "beam_line_support_stiffness": 10},
         "line supports, positions [m]: none there, 5 here", "line supports, stiffness [N/m]: none there, 10 here"),
        ({"beam_point_mass_position": 5, "beam_point_mass": 7}, "point masses, positions [m]: none there, 5 here",
         "point masses [kg]: none there, 7 here"),
        ({"beam_formulation": "hermite"}, "formulation: mixed there, hermite here"),
        ({"filter_frequency": 101}, "filter frequency [rad/s]: 100 there, 101 here"),
        ({"filter_correct_modes": 1}, "corrected modes, lowest: 0 there, 1 here"),
        ({"gravity": 1}, "gravity [m/s^2]: 9.81 there, 1 here"),
        ({"initial_height": 2}, "initial height [m]: 1 there, 2 here"),
        ({"initial_slope": 0.01}, "initial slope: 0 there, 0.01 here"),
        ({"load_position": 5, "load_table": path["load"]}, "loads, positions [m]: none there, 5 here",
         "loads, times [s]: none there, 2 0 1 here", "loads, forces [N]: none there, 2 0 1 here"),
        ({"load_position": 5, "load_table": path["load"], "load_width": 4}, "loads, positions [m]: none there, 5 here",
         "loads, widths [m]: none there, 4 here", "loads, times [s]", "loads, forces [N]"),
        ({"load_position": 5, "load_table": path["load"], "load_width": 4, "load_breadth": 2},
         "loads, positions [m]: none there, 5 here", "loads, widths [m]: none there, 4 here",
         "loads, breadths [m]: none there, 2 here", "loads, times [s]", "loads, forces [N]"),
        ({"load_position": "4,5,6", "load_law": "harmonic,friedlander,random", "load_start": "1,2,3", "load_until": 4,
          "load_amplitude": 5, "load_frequency": 6, "load_last_frequency": 7, "load_phase": 8, "load_duration": 9,
          "load_decay": 10, "load_density": 11, "load_band": "12,13", "load_period": 14, "load_seed": 15,
          "load_accuracy": 0.01},
         "loads, positions [m]: none there, 4 5 6 here", "loads, times [s]: none there, 0 0 0 here",
         "loads, forces [N]: none there, 0 0 0 here", "laws of loads (0 harmonic, 1 random, 2 friedlander): none there,"
         " 0 2 1 here", "laws of loads, starts [s]: none there, 1 2 3 here",
         "laws of loads, ends [s]: none there, 4 4 4 here", "laws of loads, amplitudes [N]: none there, 5 5 0 here",
         "laws of loads, frequencies [Hz]: none there, 6 0 0 here",
         "laws of loads, last frequencies [Hz]: none there, 7 0 0 here",
         "laws of loads, phases [rad]: none there, 8 0 0 here", "laws of loads, durations [s]: none there, 0 9 0 here",
         "laws of loads, decays: none there, 0 10 0 here", "laws of loads, seeds: none there, 1 1 15 here",
         "laws of loads, periods [s]: none there, 0 0 14 here",
         "laws of loads, accuracies: none there, 0.01 0.01 0.01 here",
         "laws of loads, spectra, frequencies [Hz]: none there, 0 0 2 12 13 here",
         "laws of loads, spectra, densities [N^2/Hz]: none there, 0 0 2 11 11 here"),
        ({"load_axles": path["load"], "load_axles_speed": 5, "load_axles_start": 2},
         "axles, distances behind the first [m]: none there, 2 0 1 here", "axles, forces [N]: none there, 2 0 1 here",
         "axles, speeds [m/s]: none there, 5 here", "axles, starts [s]: none there, 2 here"),
        ({"base_motion": path["load"], "base_motion_kind": "velocity"},
         "base motion, directions: none there, 0 1 0 here", "base motion, times [s]: none there, 4 0 0 1 1 here",
         "base motion, accelerations [m/s^2]: none there, 4 0 1 1 0 here"),
        ({"beam_left_end": "pinned", "base_motion": path["load"], "base_motion_kind": "velocity",
          "base_motion_place": "left", "base_motion_accuracy": 0.01},
         "ends, stiffness against displacement [N/m]: 0 0 there, inf 0 here",
         "motion of places, kinds: none there, 0 here", "motion of places, numbers: none there, 0 here",
         "motion of places, starts [m]: none there, 0 here",
         "motion of places, speeds at the start [m/s]: none there, 0 here",
         "motion of places, accuracies: none there, 0.01 here", "motion of places, directions: none there, 0 1 0 here",
         "motion of places, times [s]: none there, 4 0 0 1 1 here",
         "motion of places, accelerations [m/s^2]: none there, 4 0 1 1 0 here"),
        ({"damping_mass": 1, "ts_type": "impact"}, "damping of masses [1/s]: 0 there, 1 here"),
        ({"damping_stiffness": 1e-4, "ts_type": "impact"}, "damping of stiffness [s]: 0 there, 1e-04 here"),
        ({"support_position": "2,7"}, "supports, positions [m]: 2 8 there, 2 7 here"),
        ({"support_width": "0,3", "support_weighting": "inclusive"}, "supports, widths [m]: 0 0 there, 0 3 here"),
        ({"support_height": "0,-1"}, "supports, heights [m]: 0 0 there, 0 -1 here"),
        ({"support_side": "above", "support_height": 3}, "supports, sides (1 below, -1 above): 1 1 there, -1 -1 here",
         "supports, heights [m]: 0 0 there, 3 3 here"),
        ({"contact_restitution": 0.4}, "supports, restitution: 1 1 there, 0.4 0.4 here"),
        ({"support_yield_speed": 2}, "supports, yield speeds [m/s]: inf inf there, 2 2 here"),
        ({"support_stiffness": 1e6, "support_damping": 5, "ts_type": "impact"},
         "supports, stiffness [N/m]: inf inf there, 1e+06 1e+06 here",
         "supports, damping [N s/m]: 0 0 there, 5 5 here"),
        ({"contact_law": "hunt_crossley", "contact_stiffness": 5, "contact_exponent": 2, "contact_damping": 3},
         "supports, power law, stiffness [N/m^n]: none there, 1 5 1 5 here",
         "supports, power law, exponent: none there, 1 2 1 2 here",
         "supports, power law, damping [s/m]: none there, 1 3 1 3 here"),
        ({"contact_law": "bilinear,table", "contact_stiffness": 5, "contact_unloading_stiffness": 50,
          "contact_table": f"none,{path['curve']}"},
         "supports, loading curve, compression [m]: none there, 1 0 3 0 1 2 here",
         "supports, loading curve, force [N]: none there, 1 0 3 0 4 5 here",
         "supports, loading curve, last slope [N/m]: none there, 1 5 1 1 here",
         "supports, loading curve, unloading slope [N/m]: none there, 1 50 1 50 here"),
        ({"contact_law": "crush", "contact_stiffness": 8, "contact_plateau_force": 4, "contact_preload": 2,
          "contact_bottoming_compression": 2, "contact_bottoming_stiffness": 1},
         "supports, heights [m]: 0 0 there, 0.25 0.25 here",
         "supports, loading curve, compression [m]: none there, 3 0 0.5 2 3 0 0.5 2 here",
         "supports, loading curve, force [N]", "supports, loading curve, last slope [N/m]",
         "supports, loading curve, unloading slope [N/m]"),
        ({"support_motion": path["motion"], "ts_type": "impact"}, "supports, times of motion [s]",
         "supports, heights of motion [m]", "supports, velocities of motion [m/s]"),
        ({"contact_surface": "line", "contact_line_dense_max": 7, "ts_type": "impact"},
         "contact surface: mass there, line here", "contact nodes solved as few, at most: 0 there, 7 here"),
    )
    accepted = (
        {"initial_velocity": 1}, {"initial_angular_velocity": 1},
        {"initial_angular_velocity": 1, "initial_pivot": 2}, {"initial_shape": path["shape"]},
        {"beam_outer_fibre": 0.2, "beam_yield_stress": 1e8}, {"filter_check_interval": 7},
        {"filter_residual_tolerance": 1e-7}, {"filter_pc_chain_lanes": 1}, {"contact_tolerance": 1e-9},
        {"gauge_position": 3}, {"output_interval": 0.02}, {"output_field_interval": 0.03}, {"output_force_window": 0.5},
        {"output_monitor": 0.1}, {"udar_summary": "none"}, {"output_fields": "moment"}, {"output_compression": 1},
        {"output_contacts": "both", "output_contact_window": 0.01}, {"output_region": "2,5"}, {"output_stride": 3},
        {"output_allow_large": True}, {"output_overwrite": True}, {"restart_interval": 0.5}, {"udar_view": True},
        {"restart_wall_minutes": 1}, {"wall_limit": 100}, {"udar_guard": "stop"},
        {"structure_memory": 1e12},
        {"ts_rtol": 1e-9}, {"ts_atol": 1e-9}, {"ts_dt": 1e-3},
    )
    ground = ({"floor": True, "floor_height": -1}, {"ground_profile": path["ground"]})
    rows = [(" ".join(change), change, differs) for change, *differs in refused]
    rows += [(" ".join(change), change, []) for change in accepted]
    lists = ("positions [m]", "widths [m]", "heights [m]", "sides", "restitution", "yield speeds", "stiffness [N/m]",
             "damping", "times of motion", "heights of motion", "velocities of motion")
    rows += [(" ".join(change), change, [f"supports, {name}" for name in lists] +
              ["ground profile, x [m]", "ground profile, heights [m]"]) for change in ground]
    return rows


class Refused(UdarTest):
    """Runs that must not end as if all were well."""

    def refusal(self, options):
        result = run(options)
        self.assertEqual(result.code, 1, result)
        self.assertEqual(len(result.errors), 1, result)
        return result.errors[0]

    def test_unstable_fixed_step(self):
        steps = {"ts_type": "rk", "ts_dt": 1, "ts_adapt_type": "none", "ts_max_time": 3}
        line = self.refusal(case(output_directory=self.scratch / "run", **steps))
        self.assertIn("unstable", line)
        self.assertIn("-ts_dt", line)
        self.assertTrue((self.scratch / "run" / "restart.h5").exists(), "the last good step is kept")

    def test_file_beyond_the_limit_of_its_size(self):
        # MPI needs files of some MB itself.
        often = {"output_interval": 0.0002, "output_field_interval": 0, "support_position": None, "ts_max_time": 20}
        line = shlex.join(command(case(output_directory=self.scratch / "run", **often)))
        limited = ["bash", "-c", f"ulimit -f 5000; exec {line}"]
        result = subprocess.run(limited, env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"cannot write '.*/run/(gauges|energy)\.csv': File too large")

    def test_option_changes_at_a_restart(self):
        """Of every group of keys: what shapes the motion is refused with both values, and only that; the rest passes.

        Keys that neither table has are a fault of this test: -help shows which there are.
        """
        self.run_case(case(ts_max_time=0.05, beam_radius=0.1))
        files = {"restart_file": self.scratch / "run" / "restart.h5"}
        for number, (name, change, differs) in enumerate(changes_at_a_restart(self.scratch)):
            with self.subTest(name=name):
                options = case(output_directory=self.scratch / f"rest-{number}", ts_max_time=0.06, **files | change)
                if not differs:
                    self.assertEqual(run(options).code, 0, name)
                    continue
                line = self.refusal(options)
                self.assertIn("-restart_file", line)
                for text in differs:
                    self.assertIn(text, line)
                found = [part for part in line.split("; ") if " there, " in part]
                self.assertEqual(len(found), len(differs), line)

    def test_every_option_is_in_the_table_of_changes(self):
        page = (pathlib.Path(os.environ["UDAR_SOURCE_DIR"]) / "docs" / "options.md").read_text(encoding="utf-8")
        keys = set(re.findall(r"^\| `-([a-z]\w*)` \|", page, re.MULTILINE))
        self.assertGreater(len(keys), 50)
        tried = {key for _, change, _ in changes_at_a_restart(self.scratch) for key in change}
        self.assertEqual(sorted(keys - tried - NOT_TRIED), [], "neither tried nor named as not to be")


class Integrators(UdarTest):
    """Every integrator that is accepted finds the same motion."""

    def gauge(self, name, **changes):
        options = case(filter_frequency=50, ts_max_time=0.6, contact_restitution=0.5, **changes)
        result = self.run_case(options, name=name)
        return result.csv("gauges.csv"), result.summary()

    def test_agreement(self):
        expected, summary = self.gauge("5dp", ts_type="rk", ts_rtol=1e-11)
        for name, tolerance, changes in (
            ("chebyshev", 1e-8, {"ts_type": "chebyshev"}),
            ("impact", 1e-6, {"ts_type": "impact"}),
            ("3bs", 1e-4, {"ts_rk_type": "3bs"}),
            ("5f", 1e-4, {"ts_rk_type": "5f"}),
            ("5bs", 1e-5, {"ts_rk_type": "5bs"}),
            ("8vr", 1e-6, {"ts_rk_type": "8vr", "ts_rtol": 1e-11}),
            ("rk4", 1e-5, {"ts_rk_type": "4", "ts_dt": 5e-4, "ts_adapt_type": "none"}),
            ("euler", 1e-2, {"ts_type": "euler", "ts_dt": 2e-5}),
            ("ssp", 1e-4, {"ts_type": "ssp", "ts_dt": 5e-4}),
        ):
            with self.subTest(integrator=name):
                found, other = self.gauge(name, **changes)
                for column in ("mass_0", "mass_2", "line_2"):
                    off = np.abs(found[column] - expected[column]).max()
                    self.assertLess(off, tolerance, f"{column} of {name} against 5dp [m]")
                if name == "8vr":
                    self.assertLess(other["steps"], summary["steps"], "eighth order takes fewer steps")


def as_text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


if __name__ == "__main__":
    unittest.main()
