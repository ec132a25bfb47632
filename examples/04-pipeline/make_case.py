#!/usr/bin/env python3
"""Writes case.yaml: a pipeline of 1 km on 200 sleepers of uneven height. make_case.py > case.yaml"""
import random
import textwrap

LENGTH, SLEEPERS, UNEVEN = 1000.0, 200, 0.02  # m, -, m

random.seed(4)
spacing = LENGTH / SLEEPERS
positions = ", ".join(f"{spacing * (k + 0.5):g}" for k in range(SLEEPERS))
heights = ", ".join(f"{random.uniform(-UNEVEN, UNEVEN):.4f}" for _ in range(SLEEPERS))


def listed(numbers):
    """A list over as many lines as it needs."""
    return "\n" + textwrap.fill(f"[{numbers}]", 120, initial_indent=4 * " ", subsequent_indent=5 * " ")


print(f"""# A steel pipeline, 1 km, dropped 0.3 m onto {SLEEPERS} sleepers. SI units.
# Their heights differ by up to {UNEVEN * 100:g} cm.
# Written by make_case.py; every key is also an option of udar.
beam:
  length: {LENGTH}            # m
  elements: 10000
  section: tube
  radius: 0.25              # m
  inner_radius: 0.235       # m
  young_modulus: 2.1e11     # Pa
  density: 7850.0           # kg/m^3
gravity: 9.81               # m/s^2, downward
initial:
  height: 0.3               # m above the mean sleeper
support:
  position:                 # m{listed(positions)}
  height:                   # m{listed(heights)}
contact:
  surface: line
filter:
  frequency: 200.0          # rad/s
gauge:
  position: [250.0, 500.0, 750.0]  # m
ts:
  max_time: 0.6             # s
output:
  interval: 5.0e-3          # s
  field_interval: 0.02      # s""")
