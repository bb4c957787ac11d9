"""What else a trajectory holds beside states: the RPM's pose, the field and the phase lag."""

from functools import cache, partial

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.kernels import ready
from helimag.engine.packing import pack_drives, pack_magnets
from helimag.engine.synchrony import lag_vector
from helimag.engine.system import System, build_load, system_of
from helimag.physics.kinematics import State, head_position
from helimag.physics.magnetics import FieldSource, moment_axis
from helimag.scenario import Scenario

Floats = NDArray[np.float64]


@cache
def build_observe(system: System) -> wp.Kernel:
    """Make the kernel that works out the RPM's pose, the field and the phase lag at sampled states."""
    drive_type, pose_model, load = system.drive_type, system.pose, build_load(system.magnet)

    @wp.kernel(enable_backward=False, module="unique")
    def observe(
        drives: wp.array(dtype=drive_type),
        magnets: wp.array(dtype=FieldSource),
        times: wp.array(dtype=wp.float64),
        states: wp.array(dtype=State),
        positions: wp.array(dtype=wp.vec3d),
        moments: wp.array(dtype=wp.vec3d),
        fields: wp.array(dtype=wp.vec3d),
        lags: wp.array(dtype=wp.float64),
    ):
        i = wp.tid()
        pose = pose_model(drives[0], times[i])
        field, force = load(magnets, pose, head_position(states[i]), wp.vec3d())
        lag = lag_vector(field, states[i])
        positions[i] = pose.position
        moment = wp.vec3d()
        for j in range(magnets.shape[0]):
            moment += magnets[j].moment * moment_axis(magnets[j], pose.rotation, pose.spin)
        moments[i] = moment
        fields[i] = field
        lags[i] = wp.atan2(lag[1], lag[0])

    return observe


def observed(scenario: Scenario, times: Floats, states: Floats) -> dict[str, Floats]:
    """RPM position and moment, field at the head and phase lag at states (n, 7), by the kernels' own formulas."""
    kernel = ready(partial(build_observe, system_of(scenario)), "cpu")
    count = times.size
    position, moment, field = (wp.zeros(count, dtype=wp.vec3d, device="cpu") for _ in range(3))
    lag = wp.zeros(count, dtype=wp.float64, device="cpu")
    drive = pack_drives([scenario], "cpu")
    magnets = wp.array(pack_magnets([scenario])[0], dtype=FieldSource, device="cpu")
    given = [wp.array(times, dtype=wp.float64, device="cpu"), wp.array(states, dtype=State, device="cpu")]
    wp.launch(kernel, dim=count, inputs=[drive, magnets, *given, position, moment, field, lag], device="cpu")
    return {
        "rpm_position": position.numpy(),
        "rpm_moment": moment.numpy(),
        "field": field.numpy(),
        "phase_lag": lag.numpy(),
    }
