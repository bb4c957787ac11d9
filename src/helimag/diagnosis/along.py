"""Forces on a device all along a run: the magnets' pull, its net weight, and the thrust of its turning."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.checks import rotation_at_start
from helimag.diagnosis.turn import over_a_turn
from helimag.geometry import magnet_motion
from helimag.hydrodynamics import net_weight, resistance
from helimag.scenario import Scenario

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Forces:
    """Lab frame, SI, of n instants.

    Attributes
    ----------
    pull
        (n, 3): of the magnets, mean over a turn, on a device in step (N).
    weight
        (n, 3): less buoyancy (N).
    thrust
        (n, 3): what turning with the field would push with, were the device held (N).
    field_axis
        (n, 3): unit vector about which the field turns at the device, right-handed.
    """

    pull: Floats
    weight: Floats
    thrust: Floats
    field_axis: Floats


def forces_along(scenario: Scenario, time: Floats, position: Floats, nose: Floats) -> Forces:
    """Forces at instants of a run.

    A held device that rolls at the field's rate f about its nose is pushed by -R_xr 2 pi f along the nose (R: the 6x6
    resistance, x along, r about the nose). Below a dipole that turns about an axis w, seen along the unit vector r, the
    field turns about (3 r r - 2) w: the cofactors of 3 r r - 1 applied to w.

    Parameters
    ----------
    scenario
        That was run.
    time, position, nose
        (n,) s, (n, 3) m of the head, (n, 3) unit vector to the head.

    Returns
    -------
    Forces
        Lab frame, SI, one row an instant.
    """
    poses = magnet_motion(scenario.drive)(time)
    away = position - poses.position
    # a whole turn at an instant is the turn at the start, seen in the frame that moves with the magnet
    back = rotation_at_start(scenario) @ np.swapaxes(poses.rotation, 1, 2)
    _, forces = over_a_turn(scenario, np.einsum("nij,nj->ni", back, away))
    pull = np.einsum("nji,nj->ni", back, forces.mean(axis=1))
    weight = np.zeros_like(pull)
    weight[:, 2] = -net_weight(scenario.device, scenario.fluid)[0]
    along = away / np.linalg.norm(away, axis=1, keepdims=True)
    axis = poses.axis * math.copysign(1.0, scenario.drive.frequency)
    turning = 3.0 * along * np.sum(along * axis, axis=1, keepdims=True) - 2.0 * axis
    turning /= np.linalg.norm(turning, axis=1, keepdims=True)
    coupling = float(resistance(scenario.device, scenario.fluid)[0, 3])
    rate = 2.0 * math.pi * abs(scenario.drive.frequency) * np.sign(np.sum(turning * nose, axis=1, keepdims=True))
    return Forces(pull, weight, -coupling * rate * nose, turning)
