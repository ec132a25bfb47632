#!/usr/bin/env python3
"""Writes the network of this example: a grillage of steel box beams on four short legs.

python3 make_network.py > network.yaml
"""

ALONG, ACROSS = [0.0, 2.0, 4.0, 6.0, 8.0], [0.0, 1.5, 3.0, 4.5]  # x and z of the beams [m]
LEGS = [(1, 1), (3, 1), (1, 2), (3, 2)]  # crossings that stand on one
DROP = 0.2  # [m], of a leg


def main():
    print("# A grillage of steel box beams on four short legs; SI units, y is up. Written by make_network.py.")
    print("sections:")
    # A box of 0.2 x 0.1 m with walls of 6 mm: I of outer less inner rectangle, J of Bredt, 4 A^2 t / U.
    print("  - {name: box, area: 3.456e-3, inertia: [1.79391e-5, 5.99027e-6], torsion_constant: 1.38563e-5}")
    print("  - {name: leg, shape: tube, radius: 0.05, inner_radius: 0.04}")
    print("junctions:")
    for k, z in enumerate(ACROSS):
        for i, x in enumerate(ALONG):
            print(f"  - {{name: {i} {k}, place: [{x}, 0.0, {z}]}}")
    for i, k in LEGS:
        print(f"  - {{name: foot {i} {k}, place: [{ALONG[i]}, {-DROP}, {ACROSS[k]}]}}")
    print("members:")
    names = []
    for k in range(len(ACROSS)):
        for i in range(len(ALONG)):
            for to_i, to_k in ((i + 1, k), (i, k + 1)):
                if to_i < len(ALONG) and to_k < len(ACROSS):
                    names.append(f"{i} {k} to {to_i} {to_k}")
                    print(f"  - {{name: {names[-1]}, from: {i} {k}, to: {to_i} {to_k}}}")
    for i, k in LEGS:
        print(f"  - {{name: leg {i} {k}, from: {i} {k}, to: foot {i} {k}, section: leg, elements: 2}}")
    print("groups:")
    print("  - name: beams")
    print("    section: box")
    print("    element_length: 0.25")
    print("    members:")
    for name in names:
        print(f"      - {name}")


if __name__ == "__main__":
    main()
