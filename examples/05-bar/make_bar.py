#!/usr/bin/env python3
"""Writes stiffness, mass and places of a solid steel bar of hexahedra as udar imports them.

usage: make_bar.py [--elements NX NY NZ] [--size LX LY LZ] [PREFIX]

Default: the beam of examples 01 and 02, square instead of round, with the same EI / rhoA and so the same motion.
Each node has three unknowns, along x, y and z, one after the other; nodes are numbered along x last.
PREFIX-stiffness.bin and PREFIX-mass.bin are PETSc's binary form; the mass is consistent.
PREFIX-points.csv has x, y, z [m] and the direction of each unknown; the axis of the bar is y = z = 0, y is up.
"""

import argparse

import numpy as np

YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0  # steel [Pa, -, kg/m^3]
SIDE = 0.1 * np.sqrt(3)  # of a square with the radius of gyration of a circle of 0.1 m [m]
CORNERS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])


def strain_of(gradient):
    """Strain (xx, yy, zz, xy, yz, xz) of displacements along x, y, z of functions with these gradients [n, 3]."""
    strain = np.zeros((6, 3 * len(gradient)))
    for axis in range(3):
        strain[axis, axis::3] = gradient[:, axis]
    for row, (a, b) in enumerate([(0, 1), (1, 2), (0, 2)], start=3):
        strain[row, a::3], strain[row, b::3] = gradient[:, b], gradient[:, a]
    return strain


def element(size):
    """Stiffness and consistent mass of a brick, 24 x 24, by 2 x 2 x 2 Gauss points.

    Three incompatible modes 1 - xi^2 for each direction, condensed (Wilson et al. 1973): without them trilinear bricks
    are too stiff in bending.
    """
    lame = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    shear = YOUNG / (2 * (1 + POISSON))
    material = np.diag([2 * shear] * 3 + [shear] * 3)
    material[:3, :3] += lame
    full, mass = np.zeros((33, 33)), np.zeros((24, 24))
    weight = np.prod(size) / 8
    to_global = 2 / np.asarray(size)
    for point in CORNERS / np.sqrt(3):
        shape = np.prod(1 + CORNERS * point, axis=1) / 8
        gradient = np.empty((8, 3))
        for axis in range(3):
            others = [other for other in range(3) if other != axis]
            gradient[:, axis] = CORNERS[:, axis] * np.prod(1 + CORNERS[:, others] * point[others], axis=1) / 8
        strain = strain_of(np.vstack([gradient, np.diag(-2 * point)]) * to_global)
        full += weight * strain.T @ material @ strain
        mass += weight * DENSITY * np.kron(np.outer(shape, shape), np.eye(3))
    stiffness = full[:24, :24] - full[:24, 24:] @ np.linalg.solve(full[24:, 24:], full[24:, :24])
    return (stiffness + stiffness.T) / 2, mass


def write_petsc(path, numbers, matrix, unknowns):
    """Sums the matrices of all bricks; unknowns [bricks, 24] of each.

    PETSc's binary form: class, rows, columns, nonzeros, lengths of rows, columns, values; the highest byte first.
    """
    places = (numbers[:, :, None] * unknowns + numbers[:, None, :]).ravel()
    places, entry = np.unique(places, return_inverse=True)
    values = np.bincount(entry, np.tile(matrix.ravel(), len(numbers)))
    with open(path, "wb") as file:
        np.array([1211216, unknowns, unknowns, len(places)], ">i4").tofile(file)
        np.bincount(places // unknowns, minlength=unknowns).astype(">i4").tofile(file)
        (places % unknowns).astype(">i4").tofile(file)
        values.astype(">f8").tofile(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--elements", type=int, nargs=3, default=[280, 4, 4])
    parser.add_argument("--size", type=float, nargs=3, default=[10.0, SIDE, SIDE])
    parser.add_argument("prefix", nargs="?", default="bar")
    given = parser.parse_args()
    counts, size = np.array(given.elements), np.array(given.size)
    grid = np.arange(np.prod(counts + 1)).reshape(counts + 1)
    first = np.stack(np.meshgrid(*[np.arange(count) for count in counts], indexing="ij"), -1).reshape(-1, 3)
    nodes = np.stack([grid[tuple((first + (corner + 1) // 2).T)] for corner in CORNERS], axis=1)
    numbers = (3 * nodes[:, :, None] + np.arange(3)).reshape(-1, 24)
    unknowns = 3 * grid.size
    stiffness, mass = element(size / counts)
    write_petsc(given.prefix + "-stiffness.bin", numbers, stiffness, unknowns)
    write_petsc(given.prefix + "-mass.bin", numbers, mass, unknowns)
    places = np.stack(np.unravel_index(np.arange(grid.size), counts + 1), -1) * (size / counts)
    places -= [0.0, size[1] / 2, size[2] / 2]
    rows = np.column_stack([np.repeat(places, 3, axis=0), np.tile([1, 2, 3], grid.size)])
    np.savetxt(given.prefix + "-points.csv", rows, "%.17g", ",", header="x,y,z,direction", comments="")
    print(f"{unknowns} unknowns, {DENSITY * np.prod(size):g} kg in each direction")


if __name__ == "__main__":
    main()
