"""The equations of motion, put together: which formulas give field, magnet path and drag of a run.

The choice is made when a kernel is built, not by branches in it. A further formula is one Warp function with the
signature of its kind; nothing else changes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import warp as wp

from helimag.engine.medium import OPEN_WATER, Alike, Medium
from helimag.engine.synchrony import lag_vector
from helimag.physics import magnetics
from helimag.physics.balance import Swimmer, load_on, moment_of
from helimag.physics.kinematics import (
    RpmPose,
    State,
    head_position,
    rotation_matrix,
    rpm_pose,
    sampled_rpm_pose,
    state_rates,
)
from helimag.physics.magnetics import FieldSource, moment_axis
from helimag.scenario import Drive, Scenario

MAGNET_MODELS = {"dipole": magnetics.point_dipole, "cylinder": magnetics.cylinder}


@dataclass(frozen=True)
class System:
    """The formulas that make up the equations of motion.

    Attributes
    ----------
    magnet
        ``magnet(magnet, r, axis, m)``: field (T) and force (N) of one magnet at ``r`` (m) from it, its moment along the
        unit vector ``axis``, on the moment ``m`` (A m^2): see :mod:`helimag.physics.magnetics`.
    pose
        ``pose(drive, t)``: the RPM's pose at ``t`` (s); the type of its first argument is that of the drives.
    medium
        What surrounds the device.
    """

    magnet: Callable[..., Any]
    pose: wp.Function = rpm_pose
    medium: Medium = OPEN_WATER

    @property
    def drive_type(self) -> Any:
        """Structure that describes a drive to ``pose``."""
        return self.pose.input_types["drive"]


def leaps_hold(system: System) -> bool:
    """Whether runs with these formulas may leap over turns: drive and medium repeat themselves in a moving frame."""
    return system.pose is rpm_pose and system.medium.alike is not Alike.NOWHERE


def uniform(system: System) -> bool:
    """Whether the medium answers alike everywhere, as long as no wall holds the device."""
    return clear_of_walls(system).medium.alike is Alike.EVERYWHERE


def frame_moves(system: System, drive: Drive) -> bool:
    """Whether a frame moves with the drive in which all that acts on the device repeats itself turn by turn."""
    sideways = any(drive.velocity[:2])
    leaves = drive.velocity[2] != 0.0 and not uniform(system)
    return leaps_hold(system) and not leaves and not (drive.yaw_rate != 0.0 and sideways)


def clear_of_walls(system: System) -> System:
    """The formulas as long as the device keeps clear of walls that hold."""
    clear = system.medium.clear
    return system if clear is None else replace(system, medium=clear)


def system_of(scenario: Scenario) -> System:
    """The formulas that a scenario asks for."""
    pose = rpm_pose if scenario.drive.path is None else sampled_rpm_pose
    return System(MAGNET_MODELS[scenario.magnet[0].field], pose, _medium_of(scenario))


def _medium_of(scenario: Scenario) -> Medium:
    """What surrounds its device; formulas of walls are imported, each a millisecond, where there are walls."""
    workspace, device = scenario.workspace, scenario.device
    medium = OPEN_WATER
    if device.hydrodynamics.near_walls and not (workspace.floor is None and workspace.surface is None):
        from helimag.engine.walls import NEAR_WALLS

        medium = NEAR_WALLS
    if not workspace.holds:
        return medium
    from helimag.engine.contact import held_in

    return held_in(medium)


@cache
def build_load(magnet_model: Callable[..., Any]) -> wp.Function:
    """Make the function that sums field (T) and force (N) of all magnets on a moment ``m`` at ``head``."""

    @wp.func
    def load(magnets: wp.array(dtype=FieldSource), pose: RpmPose, head: wp.vec3d, m: wp.vec3d):
        field = wp.vec3d()
        force = wp.vec3d()
        for j in range(magnets.shape[0]):
            r = head - pose.position - pose.rotation * magnets[j].offset
            axis = moment_axis(magnets[j], pose.rotation, pose.spin)
            field_j, force_j = magnet_model(magnets[j], r, axis, m)
            field += field_j
            force += force_j
        return field, force

    return load


@cache
def build_balance(response: wp.Function) -> wp.Function:
    """Make the function that turns magnetic ``force`` (N) and ``field`` (T), lab components, into rates: eq. (4)."""
    here_type = response.input_types["here"]

    @wp.func
    def balance(body: Swimmer, here: here_type, state: State, force: wp.vec3d, field: wp.vec3d) -> State:
        rotation = rotation_matrix(state)
        motion = response(body, here, head_position(state), rotation, load_on(body, rotation, force, field))
        velocity = rotation * wp.vec3d(motion[0], motion[1], motion[2])
        return state_rates(state, velocity, wp.vec3d(motion[3], motion[4], motion[5]))

    return balance


@cache
def build_rates_at(system: System) -> wp.Function:
    """Make the right-hand side of the equations of motion: rates of a state, and its lag vector, at a pose."""
    here_type = system.medium.here_type
    load, balance = build_load(system.magnet), build_balance(system.medium.response)

    @wp.func
    def rates_at(body: Swimmer, here: here_type, magnets: wp.array(dtype=FieldSource), pose: RpmPose, state: State):
        field, force = load(magnets, pose, head_position(state), moment_of(body, state))
        return balance(body, here, state, force, field), lag_vector(field, state)

    return rates_at


@cache
def build_rates(system: System) -> wp.Function:
    """Make the function that gives the rates of a state at ``t`` (s)."""
    drive_type, here_type = system.drive_type, system.medium.here_type
    rates_at, pose_model = build_rates_at(system), system.pose

    @wp.func
    def rates(
        body: Swimmer,
        here: here_type,
        drive: drive_type,
        magnets: wp.array(dtype=FieldSource),
        t: wp.float64,
        state: State,
    ) -> State:
        found, lag = rates_at(body, here, magnets, pose_model(drive, t), state)
        return found

    return rates
