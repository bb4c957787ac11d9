"""The medium of devices among walls that hold: another medium's answer to a load, with what the walls push added."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.kernels import MAKING
from helimag.engine.medium import Medium
from helimag.engine.structures import structs
from helimag.physics.balance import Sheet, Swimmer
from helimag.physics.contact import (
    Six,
    SixBySix,
    Tank,
    gaps_in,
    least_pushes,
    surface_load,
    unit_push,
    walls_touched,
)
from helimag.physics.kinematics import State
from helimag.scenario import Device, Scenario

ZERO = wp.constant(wp.float64(0.0))
# of a turn: 1 / 8 is the longest step, and the method is stable up to six times what relaxes (see `control`, `methods`)
CLOSING_TIME = 1.0 / 32.0


def rear_ball(device: Device) -> float:
    """How far behind the origin the ball has its centre that touches for the rear end (m).

    At the end of the coil's axis, as where runs stop; of a body without a helix, so that it ends where the body does.
    """
    if device.helix is not None:
        return device.tail_length
    return max(device.tail_length - device.tail_radius, 0.0)


def pack_tanks(scenarios: Sequence[Scenario]) -> NDArray[np.void]:
    """Walls and what touches them, as the kernels take them."""
    return structs(
        Tank,
        [
            {
                "low": scenario.workspace.box[0],
                "high": scenario.workspace.box[1],
                "tail": rear_ball(scenario.device),
                "head_radius": scenario.device.head_radius,
                "tail_radius": scenario.device.tail_radius,
                "rate": abs(scenario.drive.frequency) / CLOSING_TIME,
                "pull": scenario.workspace.surface_pull or 0.0,
            }
            for scenario in scenarios
        ],
    )


def _pushed(respond: wp.Function, here_type: Any) -> wp.Function:
    """Make the answer to a load among walls that hold, from that without them."""

    @wp.func
    def response(
        body: Swimmer, here: here_type, position: wp.vec3d, rotation: wp.mat33d, load: wp.spatial_vectord
    ) -> wp.spatial_vectord:
        whole = load
        if here.tank.pull > ZERO:
            whole = load + surface_load(here.tank, position, rotation)
        motion = respond(body, here.beyond, position, rotation, whole)
        near = gaps_in(here.tank, position, rotation)
        speed, spin = wp.length(wp.spatial_top(motion)), wp.length(wp.spatial_bottom(motion))
        if speed + here.tank.tail * spin <= here.tank.rate * wp.min(near.gap):
            return motion  # far from all walls, which need not be asked one by one
        parting = Six()
        for k in range(6):
            push = unit_push(here.tank, rotation, k, near.way[k])
            parting[k] = wp.dot(push, motion) + here.tank.rate * near.gap[k]
        if wp.min(parting) >= ZERO:
            return motion
        mobility = SixBySix()
        six = wp.int32(6)
        for k in range(six):
            push = unit_push(here.tank, rotation, k, near.way[k])
            answer = respond(body, here.beyond, position, rotation, push)
            for j in range(six):
                mobility[j, k] = wp.dot(unit_push(here.tank, rotation, j, near.way[j]), answer)
        pushes = least_pushes(mobility, parting)
        for k in range(six):
            whole += pushes[k] * unit_push(here.tank, rotation, k, near.way[k])
        return respond(body, here.beyond, position, rotation, whole)

    return response


def held_in(medium: Medium) -> Medium:
    """The medium with walls that hold: the same for all threads, whose structures must be of one kind."""
    with MAKING:
        return _held_in(medium)


@cache
def _held_in(medium: Medium) -> Medium:
    around_type, here_type, local = medium.surroundings_type, medium.here_type, medium.local

    @wp.struct
    class Among:
        """Surroundings of a run, and the walls."""

        beyond: around_type  # type: ignore[valid-type]
        tank: Tank

    @wp.struct
    class Here:
        """The same at a place."""

        beyond: here_type  # type: ignore[valid-type]
        tank: Tank

    @wp.func
    def local_among(
        surroundings: Among,
        position: wp.vec3d,
        rotation: wp.mat33d,
        sheets: wp.array(dtype=Sheet),  # type: ignore[valid-type]
    ) -> Here:
        here = Here()
        here.beyond = local(surroundings.beyond, position, rotation, sheets)
        here.tank = surroundings.tank
        return here

    @wp.func
    def beyond(surroundings: Among) -> around_type:  # type: ignore[valid-type]
        return surroundings.beyond

    @wp.func
    def touched(here: Here, state: State, rates: State) -> int:
        return walls_touched(here.tank, state, rates)  # type: ignore[no-any-return]

    def pack(scenarios: Sequence[Scenario], device: str) -> wp.array:
        beyond = medium.pack(scenarios, device)
        packed: Any = np.zeros(len(scenarios), dtype=Among.numpy_dtype())  # type: ignore[attr-defined]
        packed["beyond"], packed["tank"] = beyond.numpy(), pack_tanks(scenarios)
        walls = wp.array(packed, dtype=Among, device=device)
        walls.beyond = beyond  # what these point to must live as long as they do
        return walls

    respond = _pushed(medium.response, Here)
    return Medium(respond, local_among, pack, touched, alike=medium.alike, clear=medium, beyond=beyond)
