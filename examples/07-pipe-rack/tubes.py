"""Draws a network's deformed shape as tubes of its sections' radii, in ParaView without a window.

    pvbatch examples/07-pipe-rack/tubes.py out/07 [TIME [SCALE]]

writes tubes.png into the folder of the results, for TIME [s] (default: the last row) and displacements times SCALE
(default 1), coloured by the axial force [N]. Where there is no display: xvfb-run -a pvbatch ...
"""

import pathlib
import sys

from paraview import simple


def main(folder, time=None, scale="1"):
    results = simple.XDMFReader(FileNames=[str(folder / "results.xdmf")])
    results.UpdatePipelineInformation()
    times = results.TimestepValues
    time = times[-1] if time is None else min(times, key=lambda row: abs(row - float(time)))
    moved = simple.WarpByVector(Input=results, Vectors=["POINTS", "displacement"], ScaleFactor=float(scale))
    lines = simple.ExtractSurface(Input=moved)
    tubes = simple.Tube(Input=lines, Scalars=["POINTS", "radius"], VaryRadius="By Absolute Scalar")
    tubes.UpdatePipeline(time)
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize, view.Background, view.UseColorPaletteForBackground = [1200, 800], [1.0, 1.0, 1.0], 0
    view.ViewTime = time
    shown = simple.Show(tubes, view)
    simple.ColorBy(shown, ("CELLS", "axial_force"))
    shown.SetScalarBarVisibility(view, True)
    bar = simple.GetScalarBar(simple.GetColorTransferFunction("axial_force"), view)
    bar.Title, bar.ComponentTitle = "axial force [N]", ""
    bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
    view.CameraPosition, view.CameraViewUp = [-1.0, 1.0, 2.0], [0.0, 1.0, 0.0]
    view.CameraFocalPoint = [0.0, 0.0, 0.0]
    view.ResetCamera()
    simple.SaveScreenshot(str(folder / "tubes.png"), view)
    information = results.GetDataInformation()
    print(f"t = {time:g} s: {information.GetNumberOfPoints()} nodes, {information.GetNumberOfCells()} elements, "
          f"radii {results.PointData['radius'].GetRange(0)} m; written to {folder / 'tubes.png'}")


main(pathlib.Path(sys.argv[1]), *sys.argv[2:])
