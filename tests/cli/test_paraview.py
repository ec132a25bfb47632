#!/usr/bin/env python3
# ranks: 1 2; size: short
"""What ParaView is given: rows, radii, contact, supports and strikers, and the state that shows them.

The files are read by VTK's own readers where they have one, the state is executed with a recorder in place of ParaView.
"""

import os
import pathlib
import sys
import unittest
import xml.etree.ElementTree

import h5py
import numpy as np
import vtk
from vtk.numpy_interface import dataset_adapter
from vtk.util.numpy_support import vtk_to_numpy

from common import UdarTest, case

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import paraview_stub  # noqa: E402

RANKS = int(os.environ.get("UDAR_RANKS", "1"))
FALL = case(ts_max_time=0.6, output_field_interval=0.05)
STRUCK = case(support_position="2,8", initial_height=0, support_height=-0.02, gravity=0, gauge_position="3,5",
              striker_position=5, striker_mass=80, striker_velocity=-3, striker_gap=0.06, ts_max_time=0.05,
              output_field_interval=0.01)
POSTS = """\
sections:
  - {name: thick, shape: circle, radius: 0.1}
  - {name: thin, shape: circle, radius: 0.02}
junctions:
  - {name: foot, place: [0, 1, 0]}
  - {name: knee, place: [0, 4, 0]}
  - {name: end, place: [3, 4, 0]}
members:
  - {name: post, from: foot, to: knee, section: thick, elements: 4}
  - {name: beam, from: knee, to: end, section: thin, elements: 4}
"""


def point_array(data, name):
    return vtk_to_numpy(data.GetPointData().GetArray(name))


def cell_array(data, name):
    return vtk_to_numpy(data.GetCellData().GetArray(name))


def slabs(path):
    """Of each row of results.xdmf its attributes as the file names them: numbers of a dataset of results.h5."""
    with h5py.File(path.parent / "results.h5") as file:
        for grid in xml.etree.ElementTree.parse(path).find("Domain/Grid"):
            values = {"time": float(grid.find("Time").get("Value"))}
            for attribute in grid.iter("Attribute"):
                item = attribute.find("DataItem")
                if item.get("ItemType") == "HyperSlab":
                    begin, _, count = np.array(item[0].text.split(), int).reshape(3, -1)
                    part = tuple(slice(a, a + n) for a, n in zip(begin, count))
                    item = item[1]
                else:
                    part = ()
                values[attribute.get("Name"), attribute.get("Center")] = np.squeeze(
                    file[item.text.split(":")[1]][part], axis=0) if part else file[item.text.split(":")[1]][()]
            yield values


class ParaView(UdarTest):
    def made(self, options):
        return self.run_case(options, RANKS)

    def state(self, run):
        """Executes the state; times of rows as the file that a reader opens has them."""
        path = run.file("paraview-state.py")
        return paraview_stub.run_state(path, lambda _: [row["time"] for row in slabs(run.file("results.xdmf"))])

    def supports(self, run):
        return paraview_stub.read_polydata(run.file("supports.vtp"))

    def moved(self, run, state, time):
        """Points of supports and strikers at a time, by the state's own filter, not exaggerated."""
        given = self.supports(run)
        output = vtk.vtkPolyData()
        executive = vtk.vtkStreamingDemandDrivenPipeline

        class Filter:
            @staticmethod
            def GetOutputInformation(_):
                information = vtk.vtkInformation()
                information.Set(executive.UPDATE_TIME_STEP(), time)
                return information

        exec(state.state["MOVE"], {"self": Filter, "vtk": vtk, "inputs": [dataset_adapter.WrapDataObject(given)],
                                   "output": dataset_adapter.WrapDataObject(output)})
        return vtk_to_numpy(given.GetPoints().GetData()) + point_array(output, "displacement")

    def test_a_beam(self):
        run = self.made(FALL)
        rows = list(slabs(run.file("results.xdmf")))
        impacts = run.csv("impacts.csv")
        with h5py.File(run.file("results.h5")) as file:
            time = file["fields/time"][()]
            np.testing.assert_array_equal([row["time"] for row in rows], time)
            touched, resting = file["fields/touched"][()], file["fields/resting"][()]
            for k, row in enumerate(rows):
                np.testing.assert_array_equal(row["touched", "Node"], touched[k])
                np.testing.assert_array_equal(row["moment", "Node"], file["fields/moment"][k])
                np.testing.assert_array_equal(row["mass_velocity", "Node"], file["fields/mass_velocity"][k])
                np.testing.assert_array_equal(row["radius", "Node"], np.full(21, 0.1))
                np.testing.assert_array_equal(row["radius", "Cell"], np.full(20, 0.1))
                hit = impacts["node"][(impacts["time"] >= time[max(k - 1, 0)]) & (impacts["time"] < time[k])]
                expected = resting[k].copy()
                expected[hit.astype(int)] = 1
                np.testing.assert_array_equal(touched[k], expected, f"row {k}")
            self.assertGreater(touched.sum(), resting.sum())
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(run.file("results.vtkhdf")))
        reader.Update()
        grid = reader.GetOutput()
        line = cell_array(grid, "part") == 0
        np.testing.assert_array_equal(cell_array(grid, "radius")[line], 0.1)
        np.testing.assert_array_equal(point_array(grid, "radius")[:21], 0.1)
        corners = [grid.GetCell(k).GetPointId(i) for k in np.flatnonzero(line) for i in range(2)]
        np.testing.assert_array_equal(np.reshape(corners, (-1, 2)), np.add.outer(np.arange(20), [0, 1]))
        self.assertEqual(grid.GetPointData().GetArray("touched").GetNumberOfTuples(), grid.GetNumberOfPoints())

    def test_the_state_of_a_beam(self):
        run = self.made(FALL)
        state = self.state(run)
        self.assertEqual((state.state["EXAGGERATION"], state.state["THICKNESS"], state.state["COLOUR"]),
                         (1, 1, "moment"))
        with h5py.File(run.file("results.h5")) as file:
            moment = np.abs(file["fields/moment"][()])
            self.assertEqual(state.state["TIME"], file["fields/time"][moment.max(axis=1).argmax()])
            self.assertEqual(state.views[0].ViewTime, state.state["TIME"])
            where, label, unit, least, most = state.state["RUN"]["fields"]["moment"]
            self.assertEqual((where, label, unit, -least, most),
                             ("POINTS", "bending moment", "N m", most, moment.max()))
        self.assertEqual(state.coloured, [("POINTS", "moment")])
        self.assertIn(state.named("tubes"), state.shown)
        self.assertIn(state.named("supports"), state.shown)
        for colour in (*state.state["RUN"]["fields"], "contact"):
            state.state["main"](colour=colour)  # asks for nothing that there is not
        with self.assertRaises(KeyError):
            state.state["main"](colour="temperature")

    def test_supports_of_a_beam(self):
        run = self.made({**FALL, "ts_max_time": 0.05, "support_position": "2,8", "support_width": "0.5,0",
                         "support_height": "-0.2,2", "support_side": "below,above"})
        data = self.supports(run)
        places = vtk_to_numpy(data.GetPoints().GetData())
        self.assertEqual((data.GetNumberOfPoints(), data.GetNumberOfPolys()), (16, 12))
        np.testing.assert_array_equal(cell_array(data, "support"), np.repeat([0, 1], 6))
        self.assertFalse(cell_array(data, "striker").any())
        face, above = places[:4], places[8:12]
        np.testing.assert_allclose([face[:, 0].min(), face[:, 0].max(), above[:, 0].mean()], [1.75, 2.25, 8], rtol=1e-6)
        np.testing.assert_array_equal([face[:, 1], above[:, 1]], np.zeros((2, 4)))
        displacement, away = point_array(data, "displacement"), point_array(data, "away")
        np.testing.assert_allclose(displacement[:, 1], np.repeat([-0.2, 2], 8), rtol=1e-15)
        np.testing.assert_allclose(away[:, 1], np.repeat([-0.1, 0.1], 8), rtol=1e-15)  # where the tube's surface is
        self.assertLess(places[4, 1], 0, "a body below its face")
        self.assertGreater(places[12, 1], 0, "and above it")
        self.assertIsNone(data.GetFieldData().GetArray("motion"))

    def test_supports_that_move(self):
        table = self.scratch / "lift.csv"
        table.write_text("time,height\n0,0\n0.4,0.2\n")
        run = self.made(case(support_motion=table, ts_max_time=0.5, initial_height=0.5, support_height=-0.25,
                             output_field_interval=0.1, output_interval=0.1))
        state = self.state(run)
        with h5py.File(run.file("results.h5")) as file:
            lift = file["supports/lift"][()]
        self.assertGreater(np.ptp(lift), 0.1)
        for time, rise in zip((0, 0.1, 0.2, 0.3, 0.4, 0.5), lift):
            height = self.moved(run, state, time)[[0, 8], 1]
            np.testing.assert_allclose(height, -0.25 + rise, rtol=0, atol=1e-15)
        self.assertIn(state.named("motion"), [state.named("displaced").input])

    def test_strikers(self):
        run = self.made(STRUCK)
        state = self.state(run)
        data = self.supports(run)
        striker = cell_array(data, "striker")
        self.assertEqual((data.GetNumberOfVerts(), list(np.flatnonzero(striker))), (1, [0]))
        self.assertEqual(cell_array(data, "support")[0], 2)
        tip = data.GetCell(0).GetPointId(0)
        table = run.csv("strikers.csv")
        for time in (0.0, 0.01, 0.03, 0.05):
            row = np.argmin(np.abs(table["time"] - time))
            self.assertAlmostEqual(self.moved(run, state, time)[tip, 1], table["position_0"][row], delta=1e-15)
        np.testing.assert_array_equal(point_array(data, "away")[tip], [0, 0.1, 0])
        self.assertIn(state.named("strikers"), state.shown)
        self.assertGreater(state.state["EXAGGERATION"], 1, "it bends by centimetres")

    def test_a_network(self):
        (self.scratch / "posts.yaml").write_text(POSTS)
        run = self.made({"structure_type": "network", "network_file": self.scratch / "posts.yaml", "gravity": 9.81,
                         "filter_frequency": 200, "initial_height": 0, "floor": True, "floor_height": 0.9,
                         "ts_max_time": 0.16, "output_interval": 0.02, "output_field_interval": 0.02})
        state = self.state(run)
        most = {name: field[4] for name, field in state.state["RUN"]["fields"].items()}
        axial = most["axial_force"] * 0.02 / 4  # as a moment on a round bar of the smallest radius
        colour = "moment" if max(most["moment_y"], most["moment_z"]) > axial else "axial_force"
        self.assertEqual((state.state["COLOUR"], state.coloured), (colour, [("CELLS", colour)]))
        self.assertGreater(most["moment_z"], 0)
        for colour in (*state.state["RUN"]["fields"], "contact", "moment"):
            state.state["main"](colour=colour)
        data = self.supports(run)
        places, displacement = vtk_to_numpy(data.GetPoints().GetData()), point_array(data, "displacement")
        # The foot is what meets the floor first: drawn from there. It meets it by its end, not by its side.
        np.testing.assert_allclose(places[:4, 1], 1, rtol=1e-7)
        np.testing.assert_allclose(displacement[:, 1], -0.1, rtol=1e-14)
        np.testing.assert_allclose(point_array(data, "away"), 0, rtol=0, atol=1e-15)
        last = list(slabs(run.file("results.xdmf")))[-1]
        self.assertEqual(last["displacement", "Node"].shape, (9, 3))
        np.testing.assert_array_equal(np.unique(last["radius", "Cell"]), [0.02, 0.1])
        self.assertTrue(last["touched", "Node"][0], "the foot has hit the floor")


if __name__ == "__main__":
    unittest.main()
