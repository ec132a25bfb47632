#!/usr/bin/env python3
# ranks: 1; size: medium
"""The Python module udar: runs, their results as frames and fields, sweeps; the notebook of examples/python."""

import itertools
import os
import pathlib
import sys
import unittest
import unittest.mock
import warnings

import h5py
import numpy as np

from common import ENVIRONMENT, ROOT, UDAR, UdarTest, case, read_csv

os.environ.update({**ENVIRONMENT, "UDAR": UDAR})
sys.path.insert(0, str(ROOT / "scripts" / "python"))
import udar  # noqa: E402, its place comes first
from udar.running import as_text  # noqa: E402

OPTIONS = {**case(ts_max_time=0.5, output_field_interval=0.05), "support_position": [2, 8]}


class QuietTest(UdarTest):
    """The filter frequency of 100 rad/s is too low for this beam, which every run says."""

    def setUp(self):
        super().setUp()
        warnings.simplefilter("ignore", udar.UdarWarning)


class Runs(QuietTest):
    @classmethod
    def setUpClass(cls):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", udar.UdarWarning)
            cls.run_of_all = udar.run(OPTIONS)

    @classmethod
    def tearDownClass(cls):
        del cls.run_of_all

    def test_tables_are_the_files(self):
        results = self.run_of_all
        for name in ("gauges", "energy", "contact", "impacts"):
            table, frame = read_csv(results.folder / f"{name}.csv"), getattr(results, name)
            self.assertEqual(list(frame.columns), list(table), name)
            self.assertGreater(len(frame), 1, name)
            for column, values in table.items():
                np.testing.assert_array_equal(frame[column], values, f"{name}: {column}")
        self.assertEqual(results.impacts["node"].dtype, np.int64)
        self.assertEqual(len(results.rests), results.summary["rests"])
        np.testing.assert_array_equal(results.supports["impulse"], results.summary["support_impulse"])

    def test_units_are_those_of_the_files(self):
        """results.h5 has the units of the tables that are in it."""
        with h5py.File(self.run_of_all.path) as file:
            for name in ("energy", "impacts", "rests"):
                expected = dict(zip(file[name].dtype.names, file[name].attrs["units"].decode().split(",")))
                self.assertEqual(getattr(self.run_of_all, name).attrs["units"], expected, name)
        units = self.run_of_all.gauges.attrs["units"]
        self.assertEqual([units[name] for name in ("time", "mass_0", "velocity_1", "line_2")], ["s", "m", "m/s", "m"])
        units = self.run_of_all.contact.attrs["units"]
        self.assertEqual([units[name] for name in ("masses", "x_min", "force_0", "impulse_1")], ["1", "m", "N", "N s"])

    def test_the_envelope_is_envelope_csv(self):
        envelope, table = self.run_of_all.envelope, read_csv(self.run_of_all.folder / "envelope.csv")
        for name, values in table.items():
            np.testing.assert_array_equal(envelope[name], values, name)
        self.assertEqual(envelope.attrs["units"]["stress_max"], "Pa")

    def test_options_and_nodes(self):
        self.assertEqual(self.run_of_all.options["support_position"], "2,8")
        self.assertEqual(self.run_of_all.structure, "beam")
        self.assertTrue(self.run_of_all.finished)
        self.assertAlmostEqual(self.run_of_all.nodes["mass"].sum(), 2466.15, places=2)

    def test_fields_have_units_and_places(self):
        moment = self.run_of_all.field("moment", time=(0.1, 0.3))
        with h5py.File(self.run_of_all.path) as file:
            np.testing.assert_array_equal(moment, file["fields/moment"][2:7])
        self.assertEqual(moment.dims, ("time", "node"))
        units = [part.attrs["units"] for part in (moment, moment.x, moment.time)]
        self.assertEqual(units, ["N m", "m", "s"])
        np.testing.assert_allclose(moment.x, np.linspace(0, 10, 21), rtol=0, atol=1e-14)
        shear = self.run_of_all.field("shear", time=0.26)
        self.assertEqual((shear.dims, shear.shape), (("time", "cell"), (1, 20)))
        np.testing.assert_allclose((shear.time[0], shear.x[0]), (0.25, 0.25), rtol=0, atol=1e-14)
        self.assertEqual(self.run_of_all.field("moment", every=5).shape, (3, 21))

    def test_a_field_or_time_that_is_not_there_is_refused(self):
        for arguments, words in ((("momentum",), "no field 'momentum', there are"), (("moment", 0.7), "to 0.5 s"),
                                 (("moment", (0.3, 0.1)), "no time (0.3, 0.1) s"), (("moment", None, 0), "every = 0")):
            with self.assertRaises(udar.UserError) as refused:
                self.run_of_all.field(*arguments)
            self.assertIn(words, str(refused.exception))

    def test_a_network_has_vectors_and_cells(self):
        results = udar.run(structure_type="network", network_grillage=[2, 1], network_spacing=2, network_elements=2,
                           filter_frequency=1000, initial_height=1, floor=True, ts_max_time=0.1)
        moved = results.field("displacement_of_line")
        self.assertEqual(moved.dims, ("time", "node", "axis"))
        fallen = moved.sel(axis="y").isel(time=-1).mean() - moved.sel(axis="y").isel(time=0).mean()
        self.assertAlmostEqual(float(fallen), -9.81 * 0.1**2 / 2, places=9)
        self.assertEqual(len(results.envelope), len(results.field("moment_z").cell))

    def test_what_is_no_run_is_refused(self):
        for folder, words in ((self.scratch / "none", "no such folder"), (self.scratch, "it has no results.h5")):
            with self.assertRaises(udar.UserError) as refused:
                udar.open(folder)
            self.assertIn(words, str(refused.exception))

    def test_a_package_that_is_missing_is_named(self):
        fresh = udar.open(self.run_of_all.folder)
        for module, ask in (("pandas", lambda: fresh.gauges), ("xarray", lambda: fresh.field("moment"))):
            with unittest.mock.patch.dict(sys.modules, {module: None}), self.assertRaises(ImportError) as refused:
                ask()
            self.assertIn(f"Debian: python3-{module}", str(refused.exception))


class Starts(QuietTest):
    def test_values_are_written_as_options(self):
        for value, text in ((True, "true"), (np.False_, "false"), (1e-3, "0.001"), (np.float32(0.5), "0.5"), (3, "3"),
                            ([0.1, 2], "0.1,2"), (np.arange(3), "0,1,2"), ((True, False), "true,false"), ("1,2", "1,2"),
                            (pathlib.Path("a"), "a")):
            self.assertEqual(as_text("key", value), text)
        for value in ({"a": 1}, [[1, 2]], object()):
            with self.assertRaises(udar.UserError) as refused:
                as_text("some_key", value)
            self.assertIn("some_key: ", str(refused.exception))

    def test_an_error_is_an_exception_with_its_message_and_code(self):
        with self.assertRaises(udar.RunError) as failed:
            udar.run(OPTIONS, self.scratch / "run", support_width=-1)
        self.assertEqual(failed.exception.code, 1)
        self.assertIn("option -support_width: '-1' is not allowed", failed.exception.message)
        self.assertNotIn("udar: error", failed.exception.message)
        for arguments, words in (({"output_directory": "a"}, "given as out"), ({"ranks": 0}, "ranks = 0"),
                                 ({"environment": "no-such-program"}, "'no-such-program' is no program")):
            program = {"UDAR": arguments.pop("environment", UDAR)}
            with unittest.mock.patch.dict(os.environ, program), self.assertRaises(udar.UserError) as refused:
                udar.run(OPTIONS, **arguments)
            self.assertIn(words, str(refused.exception))

    def test_a_run_that_hangs_is_ended(self):
        with self.assertRaises(udar.RunError) as failed:
            udar.run(OPTIONS, timeout=0.5, ts_max_time=1e6, filter_frequency=1000, output_interval=10,
                     output_field_interval=0)
        self.assertIn("no end after 0.5 s", failed.exception.message)

    def test_a_stopped_run_goes_on(self):
        with self.assertWarns(udar.UdarWarning) as warned:
            stopped = udar.run(OPTIONS, self.scratch / "run", ts_max_steps=2)
        self.assertIn("test_python.py", warned.filename)
        self.assertFalse(stopped.finished)
        whole = udar.resume(self.scratch / "run", ts_max_steps=1000)
        straight = udar.run(OPTIONS)
        self.assertTrue(whole.finished)
        same = udar.compare(straight.folder, whole.folder, tolerance=0)
        self.assertTrue(same.within, same)

    def test_warnings_and_a_temporary_folder(self):
        with self.assertWarnsRegex(udar.UdarWarning, "the filter lowers the first bending frequency"):
            results = udar.run(OPTIONS, ts_max_time=0.01, ranks=2)
        self.assertEqual(results.summary["ranks"], 2)
        self.assertIn("finished at t = 0.01 s", results.log)
        folder = results.folder
        self.assertTrue(folder.is_dir())
        del results
        self.assertFalse(folder.exists())


class Studies(QuietTest):
    def test_all_combinations_are_run_and_failures_listed(self):
        sweep = {"initial_height": [0.5, -1], "support_width": [0, 1]}
        table = udar.study(OPTIONS, sweep, self.scratch / "study", ts_max_time=0.4)
        points = list(zip(table["initial_height"], table["support_width"]))
        self.assertEqual(points, list(itertools.product(*sweep.values())))
        self.assertEqual(list(table["state"]), ["finished", "finished", "failed", "failed"])
        self.assertIn("overlaps the beam at the start", table["reason"][2])
        self.assertEqual(table["reason"][0], "")
        self.assertTrue(np.isnan(table["peak_force"][2]))
        one = udar.open(self.scratch / "study" / "run-001")
        self.assertEqual(table["peak_force"][1], max(map(abs, one.summary["peak_support_force"])))
        self.assertEqual(table["stress"][1], one.summary["max_bending_stress"])
        np.testing.assert_allclose(table["first_contact"][:2], np.sqrt(2 * 0.5 / 9.81), rtol=1e-9)
        self.assertEqual((table.attrs["units"]["peak_force"], table.attrs["units"]["stress"]), ("N", "Pa"))

    def test_points_may_be_listed(self):
        points = [{"initial_height": 0.3}, {"initial_height": 0.5, "support_position": [1, 9]}]
        table = udar.study({key: value for key, value in OPTIONS.items() if key != "initial_height"}, points,
                           ts_max_time=0.35)
        np.testing.assert_allclose(table["first_contact"], np.sqrt(2 * table["initial_height"] / 9.81), rtol=1e-9)
        self.assertNotIn("folder", table)

    def test_what_makes_no_study_is_refused(self):
        for sweep, words in (({"initial_height": 1}, "initial_height: 1 is no list"), ({"gravity": []}, "no point"),
                             ({"ts_max_time": [1]}, "ts_max_time: an option of all runs and of the sweep")):
            with self.assertRaises(udar.UserError) as refused:
                udar.study(OPTIONS, sweep, ts_max_time=0.4)
            self.assertIn(words, str(refused.exception))
        with self.assertRaises(udar.RunError) as failed:
            udar.study(OPTIONS, {"support_width": [-1, -2]})
        self.assertIn("-support_width", failed.exception.message)


if __name__ == "__main__":
    unittest.main()
