"""udar in Python, over the program and the files of its runs (docs/python.md).

    run, resume      start the program, and read what it wrote
    open             the results of a run: frames of pandas, fields of xarray, with their units
    study            a case with many values of some options
    compare          two runs, or a run and other curves, by a tolerance

The modules, each of which uses only those before it:

tools     errors of one line, the command line's parser, tables
files     the files of a run: tables, summary, options, units; nothing else opens them
frames    `Results`
running   `run` and `resume`
sweeping  `study`
comparing `compare`; compare_cli: udar-compare
core      the library in this process, compiled; imported by itself alone, as it starts MPI and PETSc
curves    thinning, units that suit what is shown
palette   colours, parts of the energy
shapes    what of a displacement is deformation
style     units of axes, labels: what all pictures have in common
results   a run as its pictures need it: `Run`
figures   the pictures of one run, or of several laid over each other
networks  structure and deformation of a network in space
studies   the pictures of a study
cli       udar-plot
report    udar-report
"""
import os

os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")  # a run that is still writing may be looked at

from .comparing import Comparison, compare  # noqa: E402, h5py must see the line above
from .frames import FieldInfo, Results, open  # noqa: E402
from .running import RunError, UdarWarning, resume, run  # noqa: E402
from .sweeping import study  # noqa: E402
from .tools import UserError  # noqa: E402

__all__ = ["Comparison", "FieldInfo", "Results", "RunError", "UdarWarning", "UserError", "compare", "open", "resume",
           "run", "study"]
