#!/usr/bin/env python3
# ranks: 1; size: short
"""Programs that know nothing of udar read a run as docs/output.md says: h5py, pandas, gnuplot, VTK."""

import subprocess
import unittest

import h5py
import numpy as np
import pandas
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from common import UdarTest, case

BENT = case(ts_max_time=0.6, output_field_interval=0.05)
PLOT = """
set datafile separator ","
set key autotitle columnhead
set terminal svg
set output "{folder}/gauges.svg"
plot "{folder}/gauges.csv" using "time":"line_2" with lines
stats "{folder}/gauges.csv" using "line_2" name "line" nooutput
print sprintf("%.17g", line_min), line_records
"""


class Readers(UdarTest):
    def setUp(self):
        super().setUp()
        self.run = self.run_case(BENT)

    def test_h5py(self):
        with h5py.File(self.run.file("results.h5")) as file:
            energy = pandas.DataFrame(file["energy"][()])
            np.testing.assert_array_equal(energy["total"], self.run.csv("energy.csv")["total"])
            self.assertEqual(file["fields/moment"].shape, (len(file["fields/time"]), len(file["x"])))
            self.assertEqual(file["fields/moment"].attrs["units"].decode(), "N m")

    def test_pandas(self):
        for name in ("gauges", "energy", "contact", "impacts", "rests", "envelope"):
            table = pandas.read_csv(self.run.file(f"{name}.csv"), float_precision="round_trip")
            for column, values in self.run.csv(f"{name}.csv").items():
                np.testing.assert_array_equal(table[column], values, f"{name}: {column}")

    def test_gnuplot(self):
        done = subprocess.run(["gnuplot"], input=PLOT.format(folder=self.run.directory), capture_output=True, text=True,
                              timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        line = self.run.csv("gauges.csv")["line_2"]
        least, rows = done.stderr.split()
        self.assertEqual((float(least), int(float(rows))), (line.min(), len(line)))
        self.assertIn('id="gnuplot_plot_1"', self.run.file("gauges.svg").read_text())

    def test_vtk_hdf(self):
        """Before VTK 9.3 its first row, after that every one."""
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(self.run.file("results.vtkhdf")))
        reader.UpdateInformation()
        row = 0
        with h5py.File(self.run.file("results.h5")) as file:
            if vtk.vtkVersion().GetVTKMajorVersion() * 100 + vtk.vtkVersion().GetVTKMinorVersion() >= 903:
                row = len(file["fields/time"]) - 1
                self.assertEqual(reader.GetNumberOfSteps(), row + 1)
                reader.SetStep(row)
            reader.Update()
            grid = reader.GetOutput()
            part = vtk_to_numpy(grid.GetCellData().GetArray("part"))
            self.assertEqual([int(np.sum(part == kind)) for kind in range(3)], [20, 1, 2])  # line, masses, supports
            moved = vtk_to_numpy(grid.GetPointData().GetArray("displacement"))[:21]
            places = vtk_to_numpy(grid.GetPoints().GetData())[:21]
            np.testing.assert_allclose((places + moved)[:, 1], file["fields/line_position"][row], rtol=1e-6)


if __name__ == "__main__":
    unittest.main()
