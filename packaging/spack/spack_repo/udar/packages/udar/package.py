# SPDX-License-Identifier: BSD-2-Clause
from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Udar(CMakePackage):
    """Impact of elastic beams and networks of beams on supports, by the filter method."""

    # Where the project is kept; a checkout is built without it: spack dev-build -d CHECKOUT udar@main
    git = "https://udar.example/udar.git"

    license("BSD-2-Clause")

    version("main", branch="main")
    version("0.1.0", tag="v0.1.0")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")

    depends_on("mpi")
    depends_on("petsc@3.18:+mpi+double~complex")
    depends_on("slepc@3.18:")
    depends_on("hdf5@1.10:+mpi")
    depends_on("metis@5.1:")
    depends_on("suite-sparse@5.12:")
    depends_on("lapack")
    depends_on("zlib-api")
    depends_on("yaml-cpp@0.6:")
    depends_on("nlohmann-json@3.10:")
    depends_on("boost@1.74:")

    # -help of the programs in Python becomes their manual when they are built.
    extends("python@3.11:", type=("build", "link", "run"))
    for module in ("numpy", "h5py", "jinja2", "matplotlib", "pandas", "xarray"):
        depends_on(f"py-{module}", type=("build", "run"))

    def cmake_args(self):
        python = self.spec["python"]
        return [
            self.define("UDAR_BUILD_TESTS", False),
            self.define("UDAR_PYTHON", python.command.path),
            self.define("UDAR_PYTHON_DIR", f"lib/python{python.version.up_to(2)}/site-packages"),
            self.define("PETSC_DIR", self.spec["petsc"].prefix),
            self.define("SLEPC_DIR", self.spec["slepc"].prefix),
        ]
