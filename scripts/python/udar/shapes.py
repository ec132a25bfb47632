"""Shapes in space: what of a displacement is deformation, and how much larger it is drawn."""
import numpy as np


def rigid_motion(place, displacement, mass):
    """(turn, first, second): the whole moves best as `(place - first) @ turn + second` (Kabsch)."""
    weight = mass / mass.sum()
    there = place + displacement
    first, second = weight @ place, weight @ there
    u, _, vt = np.linalg.svd((place - first).T @ (weight[:, None] * (there - second)))
    return u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0]) @ vt, first, second


def without_rigid_motion(place, displacement, mass):
    """What is left of displacements when the whole has been moved and turned back as well as can be."""
    turn, first, second = rigid_motion(place, displacement, mass)
    return place + displacement - ((place - first) @ turn + second)


def round_factor(value):
    """The largest of 1, 2, 5, 10, ... that is no larger; 1 at least."""
    if not value > 1.0:
        return 1
    scale = 10.0 ** np.floor(np.log10(value))
    return int(scale * max(step for step in (1, 2, 5) if step * scale <= value * (1 + 1e-9)))
