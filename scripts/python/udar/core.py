"""The library in this process: cases, models and what becomes of them in memory, without files (docs/python.md).

    Case       options, or a case file, read and checked
    Model      a case from its start on: steps, state, the filter's solver
    Recording  its tables as arrays of NumPy

Importing it starts MPI by mpi4py and PETSc by petsc4py, whose communicators, vectors and solvers it takes and gives.
SI units throughout. What is collective must be called by all ranks of a case's communicator.
"""
from .running import UdarWarning
from .tools import UserError, need

need("mpi4py.MPI", "python3-mpi4py")
need("petsc4py.PETSc", "python3-petsc4py, python3-petsc4py-real")
try:
    from ._core import Case, FileError, Model, PetscError, Recording, SolveError  # noqa: E402
except ModuleNotFoundError:
    raise ImportError("udar was built without its extension: that needs pybind11 and Python's headers (Debian: "
                      "pybind11-dev, python3-dev)") from None

__all__ = ["Case", "FileError", "Model", "PetscError", "Recording", "SolveError", "UdarWarning", "UserError"]
