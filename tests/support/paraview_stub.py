"""In place of ParaView, too heavy for a test: `paraview.simple` as a recorder that knows which arrays there are.

Each source or filter it makes has `arrays`, pairs of POINTS or CELLS and a name, that it has by its input. What asks
for another array, or reads a file that is not there, fails.
"""

import pathlib
import re
import sys
import types
import unittest.mock
import xml.etree.ElementTree

import vtk

CENTRES = {"Node": "POINTS", "Cell": "CELLS"}
WORD = re.compile(r"[a-z]\w*")


def xdmf_arrays(path):
    """Of its first row."""
    grid = xml.etree.ElementTree.parse(path).find("Domain/Grid/Grid")
    return {(CENTRES[item.get("Center")], item.get("Name")) for item in grid.iter("Attribute")}


def read_polydata(path):
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def vtp_arrays(path):
    data = read_polydata(path)
    return {(where, part.GetArrayName(i)) for where, part in (("POINTS", data.GetPointData()),
                                                              ("CELLS", data.GetCellData()))
            for i in range(part.GetNumberOfArrays())}


class Anything:
    """What may be set, called and asked for at will."""

    def __getattr__(self, name):
        value = Anything()
        setattr(self, name, value)
        return value

    def __call__(self, *_, **__):
        return Anything()

    def __iter__(self):
        return iter(6 * (0.0,))


class Part(Anything):
    """A source or a filter of the pipeline."""

    def __init__(self, kind, times, properties):
        self.kind, self.properties, self.arrays = kind, properties, set()
        self.input = properties.get("Input")
        if self.input is not None:
            self.arrays = set(self.input.arrays)
        for name in ("FileName", "FileNames"):
            for path in properties.get(name, ()):
                read = {"XDMFReader": xdmf_arrays, "XMLPolyDataReader": vtp_arrays}[kind]
                self.arrays |= read(pathlib.Path(path))
                self.TimestepValues = times(path)
        for name in ("Scalars", "Vectors", "ScaleArray", "OrientationArray"):
            if name in properties:
                self.need(*properties[name])
        if kind == "Calculator":
            where = {"Point Data": "POINTS", "Cell Data": "CELLS"}[properties["AttributeType"]]
            for word in set(WORD.findall(properties["Function"])) - {"sqrt", "e"}:
                self.need(where, word)
            self.arrays.add((where, properties["ResultArrayName"]))

    def need(self, where, name):
        if (where, name) not in self.arrays:
            raise KeyError(f"{self.kind} asks for {where} {name}, there are {sorted(self.arrays)}")


class Recorder(types.ModuleType):
    """The module `paraview.simple`. @param times of the rows, by the path of what a reader opens"""

    def __init__(self, times):
        super().__init__("simple")
        self.times, self.made, self.shown, self.coloured, self.views = times, [], [], [], []

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)

        def make(*_, **properties):
            part = Part(name, self.times, properties) if "registrationName" in properties else Anything()
            self.made.append(part)
            return part

        return make

    def GetActiveViewOrCreate(self, kind):
        self.views.append(Anything())
        return self.views[-1]

    def Show(self, what, view):
        self.shown.append(what)
        shown = Anything()
        shown.of = what
        return shown

    def ColorBy(self, shown, array):
        shown.of.need(*array)
        self.coloured.append(array)

    def named(self, name):
        """What was registered as this."""
        parts = [part for part in self.made if isinstance(part, Part)]
        return next(part for part in parts if part.properties["registrationName"] == name)


def run_state(path, times):
    """Executes a state as ParaView does and returns what it did."""
    recorder = Recorder(times)
    package = types.ModuleType("paraview")
    package.simple = recorder
    names = {"__file__": str(path), "__name__": "__main__"}
    with unittest.mock.patch.dict(sys.modules, {"paraview": package, "paraview.simple": recorder}):
        exec(compile(path.read_text(), str(path), "exec"), names)
    recorder.state = names
    return recorder
