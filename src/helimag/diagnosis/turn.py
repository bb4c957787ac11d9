"""Field and force over one turn of the magnets, on a device that keeps in step, by the kernels' own formulas."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.checks import rotation_at_start
from helimag.engine import build_load, pack_magnets, ready, system_of
from helimag.physics.kinematics import RpmPose
from helimag.physics.magnetics import FieldSource
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

PHASES = 64  # of a turn; the integrands are low harmonics
TURN = wp.constant(wp.float64(2.0 * np.pi))
ZERO = wp.constant(wp.float64(0.0))


@cache
def build_turn(magnet_model: Callable[..., Any]) -> wp.Kernel:
    """Make the kernel that gives field and force at each place and phase, the device's moment along the field."""
    load = build_load(magnet_model)

    @wp.kernel(enable_backward=False, module="unique")
    def turn(
        magnets: wp.array(dtype=FieldSource),
        rotation: wp.mat33d,
        moment: wp.float64,
        places: wp.array(dtype=wp.vec3d),
        fields: wp.array2d(dtype=wp.vec3d),
        forces: wp.array2d(dtype=wp.vec3d),
    ):
        i, j = wp.tid()
        spin = TURN * wp.float64(j) / wp.float64(fields.shape[1])
        pose = RpmPose()
        pose.rotation = rotation
        pose.spin = wp.vec2d(wp.cos(spin), wp.sin(spin))
        field, idle = load(magnets, pose, places[i], wp.vec3d())
        same, force = load(magnets, pose, places[i], moment * wp.normalize(field))
        fields[i, j] = field
        forces[i, j] = force

    return turn


def over_a_turn(scenario: Scenario, places: Floats) -> tuple[Floats, Floats]:
    """Field (T) and force (N), lab frame, at places (n, 3) seen from the RPM's centre (m): each (n, phases, 3).

    The RPM has its attitude at the start, and the device's moment lies along the field.
    """
    kernel = ready(partial(build_turn, system_of(scenario).magnet), "cpu")
    count = len(places)
    fields, forces = (wp.zeros((count, PHASES), dtype=wp.vec3d, device="cpu") for _ in range(2))
    magnets = wp.array(pack_magnets([scenario])[0], dtype=FieldSource, device="cpu")
    rotation = wp.mat33d(rotation_at_start(scenario))
    given = wp.array(np.ascontiguousarray(places), dtype=wp.vec3d, device="cpu")
    inputs = [magnets, rotation, wp.float64(scenario.device.magnetic_moment), given, fields, forces]
    wp.launch(kernel, dim=(count, PHASES), inputs=inputs, device="cpu")
    return fields.numpy(), forces.numpy()
