#!/usr/bin/env python3
"""Writes ground-0.csv to ground-3.csv beside this file: a wave of the ground that runs along the rack.

Time [s], height [m], velocity [m/s] under each portal. python3 make_ground.py [FOLDER]
"""
import math
import pathlib
import sys

HEIGHT, LASTS, WAVES = 0.06, 0.3, 2  # from trough to crest [m], each [s], how many
BEGINS, DELAY = 0.5, 0.05  # under the first portal [s], from one to the next, 6 m: 120 m/s
STEP = 0.01  # [s]


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent
    turn = 2 * math.pi / LASTS
    for portal in range(4):
        lines = [f"# the ground under portal {portal}, by make_ground.py: time [s], height [m], velocity [m/s]"]
        for k in range(round(WAVES * LASTS / STEP) + 1):
            phase = turn * k * STEP
            height, velocity = 0.5 * HEIGHT * (1 - math.cos(phase)), 0.5 * HEIGHT * turn * math.sin(phase)
            lines.append(f"{BEGINS + portal * DELAY + k * STEP:.2f},{height:.9f},{round(velocity, 9) + 0.0:.9f}")
        (folder / f"ground-{portal}.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
