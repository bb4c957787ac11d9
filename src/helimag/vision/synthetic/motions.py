"""Staged runs: motions given in closed form, to try cameras and tracking on. They are not simulated."""

from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from helimag.errors import InputError
from helimag.runs.trajectory import Trajectory

Kind = Literal["held", "wobbling", "falling"]

TURNS = 3.5  # turns a second, as in the straight runs of the paper
SAMPLE = 0.01  # s
GAP = 0.102  # height of the magnet above the start (m), as in the straight runs


def staged(kind: Kind, *, duration: float = 8.0, seed: int = 0) -> Trajectory:
    """A run of 160 mm along the tank that is held straight, wobbles or falls.

    The device turns 3.5 times a second about its long axis. Held: pointing 6 deg down, height within a millimetre.
    Wobbling: the long axis also circles by 7 deg a turn, and the head moves with it. Falling: 28 mm down, ever steeper.

    Parameters
    ----------
    duration
        In which the tank is crossed (s); shorter is faster, and harder.
    seed
        Of phases, and of the sideways path.

    Returns
    -------
    Trajectory
        As if simulated.
    """
    if not duration > 10.0 * SAMPLE:
        raise InputError(f"duration must exceed {10.0 * SAMPLE} s; got {duration}")
    random = np.random.default_rng(seed)
    phase, side = random.uniform(0.0, 2.0 * np.pi, 2)
    time = np.arange(0.0, duration + SAMPLE / 2.0, SAMPLE)
    done = time / duration
    turn = 2.0 * np.pi * TURNS * time + phase
    y = 2e-3 * np.sin(2.0 * np.pi * done + side)
    z = -4e-3 + 0.5e-3 * np.sin(2.6 * np.pi * done + phase)
    pitch = np.radians(-6.0 + 0.5 * np.sin(turn))
    yaw = np.radians(3.0) * np.sin(2.0 * np.pi * done)
    match kind:
        case "held":
            pass
        case "wobbling":
            z = z + 0.2e-3 * np.sin(turn) + 0.4e-3 * np.sin(np.pi * time)
            pitch = pitch + np.radians(7.0) * np.sin(turn)
            yaw = yaw + np.radians(7.0) * np.cos(turn)
        case "falling":
            y = y - 4e-3 * done
            z = z - 28e-3 * done**1.5
            pitch = pitch - np.radians(10.0) * done
        case _:
            raise InputError(f"kind must be held, wobbling or falling; got {kind!r}")
    rotation = Rotation.from_euler("ZYX", np.stack([yaw, -pitch, turn], axis=1))
    axis = rotation.as_matrix()[:, :, 0]
    variables = {
        "position": np.stack([160e-3 * done, y, z], axis=1),
        "quaternion": np.asarray(rotation.as_quat(scalar_first=True)),
        "long_axis": axis,
        "attack_angle": np.arcsin(axis[:, 2]),
    }
    return Trajectory.from_arrays(
        time, variables, {"name": f"staged: {kind}", "source": "staged", "initial_gap": GAP, "end": "horizon"}
    )
