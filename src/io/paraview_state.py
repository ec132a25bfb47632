"""Shows the run of this folder in ParaView 5.11 and later; docs/output.md of udar tells more.

    paraview --state=paraview-state.py                     # in a window
    pvbatch paraview-state.py PICTURE.png [TIME [COLOUR]]  # without one; without a display: xvfb-run -a pvbatch ...

udar writes this file anew as the run goes on: keep changes in a copy in this folder.
"""

import pathlib
import sys

from paraview import simple

# What a run is: io/paraview_files.cpp

HERE = pathlib.Path(__file__).resolve().parent
INK = [0.1, 0.1, 0.1]
DIVERGING = [(0.2, 0.3, 0.75), (0.87, 0.87, 0.87), (0.7, 0.0, 0.15)]
HEAT = [(0.87, 0.87, 0.87), (0.95, 0.6, 0.2), (0.55, 0.0, 0.1)]
TOUCHED, TOUCHING = [0.6, 0.85, 0.1], [0.0, 0.45, 0.15]
MADE = {"contact": ("POINTS", "contact: 1 since the row before, 2 now", "", 0.0, 2.0)}
MOMENTS = [name for name in ("moment_y", "moment_z") if name in RUN["fields"]]
if MOMENTS:
    MADE["moment"] = ("CELLS", "bending moment", "N m", 0.0, max(RUN["fields"][name][4] for name in MOMENTS))

# At the time of the pipeline supports and strikers stand where the table in the file says.
MOVE = """
import numpy
time = self.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP())
given, rows = inputs[0], inputs[0].FieldData["time"]
motion = numpy.asarray(given.FieldData["motion"]).reshape(len(rows), -1)
now = numpy.array([numpy.interp(0.0 if time is None else time, rows, column) for column in motion.T] + [0.0])
output.ShallowCopy(given.VTKObject)
moved = given.PointData["displacement"] + now[given.PointData["mover"]][:, None] * given.PointData["normal"]
output.PointData.append(moved, "displacement")
"""
TIMES = """
executive = vtk.vtkStreamingDemandDrivenPipeline
information = self.GetOutputInformation(0)
information.Set(executive.TIME_STEPS(), {times}, {count})
information.Set(executive.TIME_RANGE(), [{times}[0], {times}[-1]], 2)
"""


def structure():
    """The reader of the run, and its line or points where they are, displacements exaggerated."""
    reader = simple.XDMFReader(registrationName="run", FileNames=[str(HERE / "results.xdmf")])
    if not RUN["upright"]:
        return reader, warped("moved", reader, "displacement", EXAGGERATION)
    moved = simple.Transform(registrationName="moved", Input=reader)  # which stands in its place
    moved.Transform.Scale = [1.0, EXAGGERATION, 1.0]
    return reader, moved


def warped(name, what, vectors, scale):
    return simple.WarpByVector(registrationName=name, Input=what, Vectors=["POINTS", vectors], ScaleFactor=scale)


def calculated(name, what, result, function, where="Point Data"):
    return simple.Calculator(registrationName=name, Input=what, AttributeType=where, ResultArrayName=result,
                             Function=function)


def with_made_fields(moved):
    """Adds the contact of each node and, of a network, the bending moment of each cell about both axes."""
    known = calculated("contact", moved, "contact", RUN["contact"])
    if MOMENTS:
        known = calculated("moment", known, "moment", "sqrt(moment_y^2+moment_z^2)", "Cell Data")
    return known


def radius_of_balls():
    return THICKNESS * RUN["ball"]


def with_drawn_radius(known):
    if RUN["tubes"]:
        return calculated("drawn radius", known, "drawn", f"radius*{THICKNESS!r}")
    return calculated("drawn radius", known, "drawn", f"{radius_of_balls()!r}")


def balls(name, nodes, scale, **properties):
    """Around nodes, so many times larger than their array says, or all alike."""
    glyphs = simple.Glyph(registrationName=name, Input=nodes, GlyphType="Sphere", GlyphMode="All Points",
                          ScaleFactor=scale, **properties)
    glyphs.GlyphType.ThetaResolution = glyphs.GlyphType.PhiResolution = 16
    return glyphs


def bodies(known):
    """What is drawn of the structure: tubes with the radii of its sections, or balls."""
    if not RUN["tubes"]:
        return balls("balls", known, 2.0, ScaleArray=["POINTS", "drawn"])
    solid = simple.Threshold(registrationName="members", Input=known, Scalars=["CELLS", "radius"],
                             LowerThreshold=1e-9, UpperThreshold=1e9)  # there is nothing in a gap between two beams
    lines = simple.ExtractSurface(registrationName="lines", Input=solid)
    return simple.Tube(registrationName="tubes", Input=lines, Scalars=["POINTS", "drawn"],
                       VaryRadius="By Absolute Scalar", NumberofSides=16)


def show_coloured(what, view, colour):
    """With a bar that keeps its range at all times."""
    where, label, unit, least, most = {**RUN["fields"], **MADE}[colour]
    shown = simple.Show(what, view)
    simple.ColorBy(shown, (where, colour))
    table = simple.GetColorTransferFunction(colour)
    colours = DIVERGING if least < 0.0 else HEAT
    ends = (least, 0.5 * (least + most), most)
    table.RGBPoints = [number for end, rgb in zip(ends, colours) for number in (end, *rgb)]
    shown.SetScalarBarVisibility(view, True)
    bar = simple.GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = f"{label} [{unit}]" if unit else label, ""
    bar.TitleColor = bar.LabelColor = INK
    bar.Orientation, bar.WindowLocation, bar.ScalarBarLength = "Horizontal", "Lower Center", 0.4
    bar.AutomaticLabelFormat, bar.RangeLabelFormat, bar.LabelFormat = 0, "%.3g", "%.3g"
    bar.UseCustomLabels, bar.CustomLabels = 1, [least + part * (most - least) for part in (0.25, 0.5, 0.75)]


def show_contact(known, view):
    """Balls around the nodes that touch something or have done so."""
    for name, colour, least, most in (("touched", TOUCHED, 0.5, 1.5), ("touching", TOUCHING, 1.5, 2.5)):
        nodes = simple.Threshold(registrationName=f"{name} nodes", Input=known, Scalars=["POINTS", "contact"],
                                 LowerThreshold=least, UpperThreshold=most, AllScalars=0)
        show_plain(balls(name, nodes, 2.6, ScaleArray=["POINTS", "drawn"]), view, colour)


def show_plain(what, view, colour, opacity=1.0):
    shown = simple.Show(what, view)
    shown.ColorArrayName = ["POINTS", ""]
    shown.AmbientColor = shown.DiffuseColor = colour
    shown.Opacity = opacity
    return shown


def surroundings(times):
    """Supports and tips of strikers, displaced as the structure is and as far off its axis as its surface."""
    placed = simple.XMLPolyDataReader(registrationName="supports and strikers", FileName=[str(HERE / "supports.vtp")])
    if RUN["moving"]:
        placed = simple.ProgrammableFilter(registrationName="motion", Input=placed, Script=MOVE,
                                           RequestInformationScript=TIMES.format(times=times, count=len(times)),
                                           CopyArrays=1)
    apart = warped("displaced", placed, "displacement", EXAGGERATION)
    return warped("apart", apart, "away", THICKNESS)


def show_strikers(around, view):
    """Balls on their tips, of a size that means nothing."""
    tips = simple.Threshold(registrationName="tips", Input=around, Scalars=["CELLS", "striker"],
                            LowerThreshold=0.5, UpperThreshold=1.5)
    strikers = balls("strikers", tips, 0.05 * RUN["size"], OrientationArray=["POINTS", "away"])
    strikers.GlyphTransform.Translate = [0.5, 0.0, 0.0]
    show_plain(strikers, view, [0.25, 0.25, 0.3])


def show_text(source, view, corner):
    shown = simple.Show(source, view)
    shown.WindowLocation, shown.Color, shown.FontSize = corner, INK, 16


def main(picture=None, time=TIME, colour=COLOUR):
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize, view.OrientationAxesVisibility = [1400, 700], 1
    view.UseColorPaletteForBackground, view.Background = 0, [1.0, 1.0, 1.0]
    reader, moved = structure()
    reader.UpdatePipelineInformation()
    times = [float(row) for row in reader.TimestepValues]
    view.ViewTime = min(times, key=lambda row: abs(row - float(time)))
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.AnimationTime = view.ViewTime

    known = with_drawn_radius(with_made_fields(moved))
    shapes = bodies(known)
    show_coloured(shapes, view, colour)
    show_contact(known, view)
    if RUN["supports"] or RUN["strikers"]:
        around = surroundings(times)
    if RUN["supports"]:
        bodies_around = simple.Threshold(registrationName="supports", Input=around, Scalars=["CELLS", "striker"],
                                         LowerThreshold=-0.5, UpperThreshold=0.5)
        show_plain(bodies_around, view, [0.55, 0.5, 0.45])
    flat = RUN["flat"]
    view.CameraFocalPoint, view.CameraViewUp = [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]
    view.CameraPosition = [-0.15, 0.3, 1.0] if flat else [-0.6, 0.5, 1.0]
    view.ResetCamera()  # with much room around
    bounds = list(shapes.GetDataInformation().GetBounds())
    _, tall, _ = sides = [after - before for before, after in zip(bounds[::2], bounds[1::2])]
    closer = 1.0 if tall > 0.5 * max(sides) else 1.6 if flat else 1.4
    camera = view.GetActiveCamera()  # knows where it is now
    view.CameraFocalPoint = focus = list(camera.GetFocalPoint())
    view.CameraPosition = [a + (b - a) / closer for a, b in zip(focus, camera.GetPosition())]
    if RUN["strikers"]:
        show_strikers(around, view)
    show_text(simple.AnnotateTime(registrationName="time", Format="t = {time:.4f} s"), view, "Upper Left Corner")
    drawn = f"displacements x {EXAGGERATION:g}" + (f", radii x {THICKNESS:g}" if RUN["tubes"] else "")
    drawn += "\nlight green: in contact since the row before, dark green: now"
    show_text(simple.Text(registrationName="legend", Text=drawn), view, "Upper Right Corner")
    if picture:
        simple.SaveScreenshot(picture, view)
    else:
        simple.Render(view)


main(*(sys.argv[1:4] if sys.argv and pathlib.Path(sys.argv[0]).name == pathlib.Path(__file__).name else []))
