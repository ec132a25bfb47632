#!/usr/bin/env python3
"""First frequencies of a small space frame by CalculiX, with which verification.calculix compares.

    tests/verification/calculix_frame.py FOLDER [--elements 40,80] [--side 1,0.25]

writes the input of `ccx` (Debian: calculix-ccx) into the folder, runs it, and prints the frequencies [Hz], for B32R and
B32: quadratic beams that `ccx` turns into solids of 20 nodes, with reduced and with full integration. Two sections,
clamped feet, an arm.
"""

import argparse
import pathlib
import subprocess

YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0
COUNT = 6
POINTS = [(0, 0, 0), (4, 0, 0), (4, 0, 3), (0, 0, 3), (0, 3, 0), (4, 3, 0), (4, 3, 3), (0, 3, 3), (5.5, 3, 0)]
FEET = range(4)
COLUMNS, RAILS = 0.1, 0.08  # sides of squares, times --side
MEMBERS = [(i, i + 4, COLUMNS) for i in FEET] + [(4 + i, 4 + (i + 1) % 4, RAILS) for i in FEET] + [(5, 8, RAILS)]


def mesh(elements):
    """Places of nodes, and for each member the nodes along it."""
    places = list(POINTS)
    along = []
    for a, b, _ in MEMBERS:
        steps = 2 * elements
        own = [a]
        for i in range(1, steps):
            places.append(tuple(p + (q - p) * i / steps for p, q in zip(POINTS[a], POINTS[b], strict=True)))
            own.append(len(places) - 1)
        along.append([*own, b])
    return places, along


def across(a, b):
    """A direction across a member."""
    return (1.0, 0.0, 0.0) if abs(b[1] - a[1]) > 0.5 else (0.0, 1.0, 0.0)


def deck(kind, elements, factor):
    places, along = mesh(elements)
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{i + 1}, " + ", ".join(f"{c:.12g}" for c in p) for i, p in enumerate(places)]
    number = 0
    for m, own in enumerate(along):
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET=M{m}")
        for first in range(0, len(own) - 1, 2):
            number += 1
            lines.append(", ".join(str(v) for v in [number, *(n + 1 for n in own[first : first + 3])]))
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{YOUNG}, {POISSON}", "*DENSITY", f"{DENSITY}"]
    for m, (a, b, side) in enumerate(MEMBERS):
        direction = ", ".join(str(c) for c in across(POINTS[a], POINTS[b]))
        lines += [f"*BEAM SECTION, ELSET=M{m}, MATERIAL=STEEL, SECTION=RECT",
                  f"{side * factor}, {side * factor}", direction]
    lines.append("*BOUNDARY")
    lines += [f"{i + 1}, 1, 6" for i in FEET]
    lines += ["*STEP", "*FREQUENCY", f"{COUNT}", "*END STEP", ""]
    return "\n".join(lines)


def frequencies(folder, kind, elements, factor):
    name = f"frame-{kind.lower()}-{elements}-{factor}"
    (folder / f"{name}.inp").write_text(deck(kind, elements, factor))
    run = subprocess.run(["ccx", name], cwd=folder, capture_output=True, text=True, timeout=600, check=False)
    (folder / f"{name}.log").write_text(run.stdout + run.stderr)
    found = []
    for line in (folder / f"{name}.dat").read_text().splitlines():
        words = line.split()
        if len(words) == 5 and words[0].isdigit():  # number, eigenvalue, rad/time, cycles/time, imaginary part
            found.append(float(words[3]))
    return found[:COUNT]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--elements", default="40,80", help="of a member")
    parser.add_argument("--side", default="1,0.25", help="factors of the sides")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for kind in ("B32R", "B32"):
        for factor in map(float, arguments.side.split(",")):
            for elements in map(int, arguments.elements.split(",")):
                values = frequencies(arguments.folder, kind, elements, factor)
                print(f"{kind:4} {factor:5} {elements:4}", " ".join(f"{v:.6f}" for v in values))


if __name__ == "__main__":
    main()
