"""What a device's resistance says of how it moves alone: swimming, sinking, rolling."""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def roll_resistance(mobility: Floats) -> float:
    """Torque about the long axis per roll rate (N m s) of a device that nothing else holds: it may swim as it turns."""
    return 1.0 / float(mobility[3, 3])


def advance_per_turn(mobility: Floats) -> float:
    """How far a device swims along its long axis, towards the head, in one turn by its roll torque alone (m).

    Positive roll is right-handed about the axis from helix to head; velocity per torque over roll rate per torque.
    """
    return 2.0 * math.pi * float(mobility[0, 3] / mobility[3, 3])


def sinking_speeds(resistance: Floats, net_weight: float) -> tuple[float, float]:
    """Speeds (m/s, positive down) level and upright under the net weight (N), the attitude held as by a field.

    The force balance with no rotation: weight over drag, level as the mean over a roll.
    """
    drift = np.linalg.inv(resistance[:3, :3])
    return net_weight * float(drift[1, 1] + drift[2, 2]) / 2.0, net_weight * float(drift[0, 0])


def largest_drag(resistance: Floats) -> float:
    """Drag per speed (N s/m) in the direction in which it is largest, the attitude held."""
    return float(np.linalg.eigvalsh(resistance[:3, :3])[-1])
