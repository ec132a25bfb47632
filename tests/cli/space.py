"""What tests of structures in three dimensions share."""

import numpy as np


def turn(axis, angle):
    """The rotation about an axis."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def listed(values):
    return ",".join(f"{value:.17g}" for value in np.asarray(values).ravel())
