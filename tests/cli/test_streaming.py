#!/usr/bin/env python3
# size: medium
"""What of a run is written: compressed fields, merged impacts, some fields, a part of the structure, each so many
nodes; and that readers take it. UDAR_PLOT, UDAR_REPORT: the programs."""

import os
import shutil
import subprocess
import time
import unittest

import h5py
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

import same_run
from common import UdarTest, case, command, read_csv, run, start

import udar

# Long enough rows to be compressed, and masses that come down one after the other, and again.
LONG = case(beam_elements=1000, initial_height=0.003, initial_slope=2e-4, support_position=None, floor=True,
            contact_restitution=0.8, ts_type="impact", ts_max_time=0.2, output_interval=1e-3,
            output_field_interval=5e-3, restart_interval=0.02)
BOTH = {"output_compression": 4, "output_contacts": "both", "output_contact_window": 4e-3}
# Masses that bounce until they rest: of 440 110 impacts 261 000 come in one step, 17 MB of records.
MANY = case(beam_length=100, beam_elements=4000, initial_height=0.01, support_position=None, floor=True,
            contact_restitution=0.9, ts_type="impact", ts_rtol=1e-6, ts_max_time=1, output_interval=0.05,
            output_field_interval=0.5, modal_estimate="false", gauge_position="50")
NETWORK = {
    "structure_type": "network", "network_lattice": "2,2,2", "network_spacing": 0.5, "network_elements": 7,
    "network_section": "tube", "network_section_radius": 0.02, "network_section_inner_radius": 0.017,
    "network_rotation": "0,0,0.02", "initial_height": 0.02, "floor": "true", "contact_restitution": 0.5,
    "filter_frequency": 300, "ts_max_time": 0.08, "output_interval": 1e-3, "output_field_interval": 5e-3,
    "gauge_junction": "0 0 0,1 1 1",
}
SUMS = ("impulse", "energy_loss")


def merged_by_hand(raw, window):
    """Rows (first, last, node, support, count, speed, impulse, loss) in the order of the list of the run."""
    rows, newest = [], {}
    for time, node, support, speed, *sums in zip(raw["time"], raw["node"], raw["support"],
                                                 np.abs(raw["velocity_before"]), *(raw[name] for name in SUMS)):
        row = newest.get((node, support))
        if row is None or time - row[0] >= window:
            row = newest[node, support] = [time, time, node, support, 0, 0.0, *(0.0 for _ in sums)]
            rows.append(row)
        row[1], row[4], row[5] = time, row[4] + 1, max(row[5], speed)
        for column, value in enumerate(sums, 6):
            row[column] += value
    return np.array(sorted(rows, key=lambda row: (row[0], row[2])))


def content(run_of):
    with h5py.File(run_of.file("results.h5")) as file:
        return {name: item[()] for name, item in file["fields"].items()}


def lists_of(directory):
    with h5py.File(directory / "results.h5") as file:
        return {name: file[name][()] for name in ("impacts", "impacts_merged", "rests") if name in file}


class Streaming(UdarTest):
    def test_compressed_fields_and_merged_impacts(self):
        """The same to the bit on one rank and two; killed in a flush and continued to the bit."""
        plain = self.run_case(LONG, name="plain")
        packed = self.run_case(LONG | BOTH, name="packed")
        expected = content(plain)
        for name, values in content(packed).items():
            np.testing.assert_array_equal(values, expected[name], name)
        with h5py.File(packed.file("results.h5")) as file:
            self.assertEqual((file["fields/moment"].compression, file["fields/moment"].chunks), ("gzip", (1, 1001)))
            self.assertTrue(file["fields/moment"].shuffle)
            stored = sum(file["fields"][name].id.get_storage_size() for name in expected)
        self.assertLess(stored, 0.85 * sum(values.nbytes for values in expected.values()))

        raw, merged = packed.csv("impacts.csv"), packed.csv("impacts_merged.csv")
        np.testing.assert_array_equal(raw["impulse"], plain.csv("impacts.csv")["impulse"])
        found = np.column_stack([merged[name] for name in ("time", "last_time", "node", "support", "impacts",
                                                           "speed_max", *SUMS)])
        np.testing.assert_array_equal(found, merged_by_hand(raw, BOTH["output_contact_window"]))
        self.assertGreater(len(raw["time"]), 1.5 * len(found))
        with h5py.File(packed.file("results.h5")) as file:
            for name, values in merged.items():
                np.testing.assert_array_equal(file["impacts_merged"][name], values, name)
        frame = udar.open(packed.directory).merged_impacts
        self.assertEqual((frame["impacts"].sum(), frame.attrs["units"]["speed_max"]), (len(raw["time"]), "m/s"))

        two = self.run_case(LONG | BOTH, 2, name="two")
        for name, values in content(two).items():
            np.testing.assert_allclose(values, expected[name], rtol=0, atol=1e-9 * max(1.0, np.abs(values).max()))
        self.assertEqual(two.csv("impacts_merged.csv")["impacts"].sum(), len(two.csv("impacts.csv")["time"]))

        folder = self.scratch / "killed"
        folder.mkdir()
        straight = self.scratch / "straight"
        straight.mkdir()
        inside = LONG | BOTH | {"output_directory": "run"}
        self.assertEqual(run(inside, cwd=straight).code, 0)
        for number in range(8, 48):
            shutil.rmtree(folder / "run", ignore_errors=True)
            run(inside, cwd=folder, environment={"LD_PRELOAD": os.environ["UDAR_KILL_AT_RESIZE"],
                                                 "KILL_AT_RESIZE": str(number)})
            self.assertFalse((folder / "run" / "summary.json").exists(), "it is to be killed")
            if (folder / "run" / "restart.previous.h5").exists():
                break
        again = {"continue": "run"}
        for change, words in (({"output_contacts": "raw"}, "-output_contact_window"),
                              ({"output_contact_window": 1e-3}, "merged within 0.004 s there"),
                              ({"output_fields": "moment"}, "results.h5 has mass_position"),
                              ({"output_region": "2,5"}, "other columns")):
            refused = run(again | change, cwd=folder)
            self.assertEqual((refused.code, len(refused.errors)), (1, 1), refused)
            self.assertIn(words, refused.errors[0])
        went_on = run(again, cwd=folder)
        self.assertEqual(went_on.code, 0, went_on)
        self.assertEqual(same_run.differences(straight / "run", folder / "run"), [])

    def test_steps_of_many_impacts(self):
        """Held a block at a time; compressed the same to the bit, on two ranks, killed between such steps, too."""
        few = self.run_case(MANY | {"ts_max_time": 0.3}, name="few").summary()
        plain = self.run_case(MANY, name="plain")
        summary = plain.summary()
        self.assertGreater(summary["impacts"] - few["impacts"], 400_000)
        # Blocks, and what waits for tables: 10 MB. Where the largest step was held and copied it took 50 MB.
        self.assertLess(summary["peak_memory_bytes"] - few["peak_memory_bytes"], 24e6)

        packed = MANY | BOTH | {"output_directory": "run", "restart_interval": 0.02}
        straight, folder = self.scratch / "straight", self.scratch / "killed"
        straight.mkdir()
        folder.mkdir()
        self.assertEqual(run(packed, cwd=straight).code, 0)
        two = [lists_of(self.run_case(MANY | options | {"output_overwrite": True}, 2, name="two").directory)
               for options in ({}, BOTH)]
        for one, other in ((lists_of(plain.directory), lists_of(straight / "run")), two):
            for name in ("impacts", "rests"):
                for column in one[name].dtype.names:
                    np.testing.assert_array_equal(one[name][column], other[name][column], f"{name} {column}")
        with h5py.File(straight / "run" / "results.h5") as file:
            for name in ("impacts", "impacts_merged", "rests"):
                self.assertEqual((file[name].compression, file[name].chunks), ("gzip", (1024,)))
            self.assertLess(file["impacts"].id.get_storage_size(), 0.5 * 64 * len(file["impacts"]))

        process = start(command(packed), cwd=folder)
        results = folder / "run" / "results.h5"
        while process.poll() is None and not (results.exists() and results.stat().st_size > 6e6):
            time.sleep(0.01)
        process.kill()
        process.communicate()
        self.assertFalse((folder / "run" / "summary.json").exists(), "it is to be killed")
        went_on = run({"continue": "run"}, cwd=folder)
        self.assertEqual(went_on.code, 0, went_on)
        self.assertEqual(same_run.differences(straight / "run", folder / "run"), [])

    def tools_take(self, directory, *without):
        """Pictures and report of a run; nothing of the report is missing but what is named."""
        for program, arguments in (("UDAR_PLOT", ["--format", "png", "--dpi", "40"]), ("UDAR_REPORT", [])):
            done = subprocess.run([os.environ[program], str(directory), *arguments], capture_output=True, text=True,
                                  timeout=120)
            self.assertEqual(done.returncode, 0, done.stderr)
        page = (directory / "report.html").read_text(encoding="utf-8")
        for words in without:
            self.assertIn(words, page)

    def test_some_fields_and_no_list(self):
        some = self.run_case(LONG | {"output_fields": "moment,line_position", "output_contacts": "none"})
        self.assertEqual(sorted(content(some)), ["line_position", "moment", "time"])
        for name in ("impacts.csv", "rests.csv", "impacts_merged.csv"):
            self.assertFalse(some.file(name).exists(), name)
        with h5py.File(some.file("results.h5")) as file:
            self.assertEqual((len(file["impacts"]), len(file["rests"])), (0, 0))
        self.assertGreater(some.summary()["impacts"], 1000)
        self.tools_take(some.directory, "no field mass_position")
        merged = self.run_case(LONG | BOTH | {"output_contacts": "merged", "output_overwrite": True})
        self.assertFalse(merged.file("impacts.csv").exists())
        self.tools_take(merged.directory, "merged alone")
        self.assertEqual(udar.open(merged.directory).merged_impacts["impacts"].sum(), merged.summary()["impacts"])
        goes_on = self.run_case(LONG | BOTH | {"output_overwrite": True})
        raw = goes_on.csv("impacts.csv")
        goes_on.file("summary.json").unlink()  # and there are too many impacts for the table
        goes_on.file("impacts.csv").write_text(goes_on.file("impacts.csv").read_text().split("\n")[0] + "\n")
        np.testing.assert_array_equal(udar.open(goes_on.directory).impacts["time"], raw["time"])
        self.tools_take(goes_on.directory, "not finished")
        self.refuse_case(LONG | {"output_fields": "moment,force", "output_overwrite": True},
                         ["-output_fields", "'force'", "mass_velocity, line_position, moment"])

    def test_part_of_a_beam(self):
        """Rows are those of the whole run; of each so many nodes the fields alone."""
        whole = self.run_case(LONG, name="whole")
        fields, impacts, envelope = content(whole), whole.csv("impacts.csv"), whole.csv("envelope.csv")
        parts = (({"output_region": "2,5.005"}, np.arange(200, 501), 1),
                 ({"output_stride": 7}, np.append(np.arange(0, 1001, 7), 1000), 7),
                 ({"output_region": "2,5.005", "output_stride": 50, "output_compression": 1}, np.arange(200, 501, 50),
                  50))
        for ranks in (0, 2):
            for change, nodes, stride in parts:
                with self.subTest(change=change, ranks=ranks):
                    part = self.run_case(LONG | change | {"output_overwrite": True}, ranks)
                    with h5py.File(part.file("results.h5")) as file:
                        np.testing.assert_array_equal(file["node"], nodes)
                        np.testing.assert_array_equal(file["cells"], np.column_stack([np.arange(len(nodes) - 1),
                                                                                      np.arange(1, len(nodes))]))
                        self.assertEqual(int(file.attrs["elements"]), 1000)
                    for name, values in content(part).items():
                        rows = () if name == "time" else (slice(None), nodes[:-1] if name == "shear" else nodes)
                        np.testing.assert_allclose(values, fields[name][rows], rtol=0,
                                                   atol=1e-9 * max(1.0, np.abs(values).max()) if ranks else 0)
                    if ranks:
                        continue
                    inside = np.isin(impacts["node"], nodes) if stride == 1 else (
                        np.isin(impacts["node"], np.arange(nodes[0], nodes[-1] + 1)))
                    np.testing.assert_array_equal(part.csv("impacts.csv")["time"], impacts["time"][inside])
                    np.testing.assert_array_equal(part.csv("envelope.csv")["moment_max"],
                                                  envelope["moment_max"][nodes])
                    self.assertEqual(part.summary()["max_moment"], whole.summary()["max_moment"])
                    self.assertEqual(part.csv("gauges.csv")["line_0"][-1], whole.csv("gauges.csv")["line_0"][-1])
        self.tools_take(part.directory)
        field = udar.open(part.directory).field("moment", time=0.1)
        self.assertEqual(field.shape[1], len(nodes))
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(part.file("results.vtkhdf")))
        reader.Update()
        points = vtk_to_numpy(reader.GetOutput().GetPoints().GetData())
        np.testing.assert_allclose(points[:len(nodes), 0], 0.01 * nodes, rtol=1e-12)
        for wrong, words in (("2,5,7", "3 values"), ("5,2", "below"), ("2,2.001", "no element")):
            self.refuse_case(LONG | {"output_region": wrong, "output_overwrite": True}, ["-output_region", words])

    def test_part_of_a_network(self):
        whole = self.run_case(NETWORK, name="whole")
        fields = content(whole)
        with h5py.File(whole.file("results.h5")) as file:
            node, cells, member, place = (file[name][()] for name in ("node", "cells", "member", "x"))
        upright = "0 0 0 to 0 1 0"
        for ranks in (0, 2):
            chosen = {"output_members": upright, "output_stride": 3, "output_overwrite": True}
            part = self.run_case(NETWORK | chosen, ranks)
            with h5py.File(part.file("results.h5")) as file:
                number = int(file["member"][0])
                own = np.flatnonzero(member == number)
                chain = np.append(cells[own, 0], cells[own[-1], 1])  # rows of the whole run from end to end
                kept = np.append(chain[:-1:3], chain[-1])
                order = np.argsort(node[kept])
                np.testing.assert_array_equal(file["node"], node[kept][order])
                np.testing.assert_array_equal(file["node"][()][file["cells"][()]],
                                              np.column_stack([node[kept[:-1]], node[kept[1:]]]))
                for name, rows in (("displacement_of_line", kept[order]), ("axial_force", own[::3])):
                    values = file["fields"][name][()]
                    np.testing.assert_allclose(values, fields[name][:, rows], rtol=0,
                                               atol=1e-9 * max(1.0, np.abs(values).max()) if ranks else 0)
        self.tools_take(part.directory)
        box = self.run_case(NETWORK | {"output_region": "-1,2,-1,0.3,-1,2", "output_overwrite": True})
        with h5py.File(box.file("results.h5")) as file:
            self.assertLess(len(file["node"]), len(node))
            self.assertTrue(np.all(file["y"][()] <= 0.3))
            self.assertEqual(len(place), len(node))
        self.refuse_case(NETWORK | {"output_members": "mast", "output_overwrite": True}, ["-output_members", "'mast'"])
        self.refuse_case(LONG | {"output_members": "mast", "output_overwrite": True}, ["-output_members", "network"])


if __name__ == "__main__":
    unittest.main()
