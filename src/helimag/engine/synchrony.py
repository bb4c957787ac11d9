"""Whether the device keeps in step with the field, and how often it slips a turn."""

import warp as wp

from helimag.physics.kinematics import State, rotation_matrix

ZERO = wp.constant(wp.float64(0.0))


@wp.struct
class Synchrony:
    """A run's step with the field so far; a slip is a passage of the field behind the moment after one in front."""

    lag: wp.vec2d  # see :func:`lag_vector`
    locked: wp.int32  # whether the moment has been within a quarter turn of the field since the last slip
    slips: wp.int32


@wp.func
def lag_vector(field: wp.vec3d, state: State) -> wp.vec2d:
    """Field across the long axis (T), along the moment and a quarter turn ahead: its angle is the phase lag."""
    body_field = wp.transpose(rotation_matrix(state)) * field
    return wp.vec2d(body_field[1], body_field[2])


@wp.func
def passed_behind(old: wp.vec2d, new: wp.vec2d) -> bool:
    """Whether the field went through the direction opposite to the moment between two lag vectors, on a straight line.

    Where a slipping device lets the field swing nearly along its axis, it goes from front to back within a step.
    """
    if old[1] * new[1] > ZERO or old[1] == new[1]:
        return False
    return (old[0] * new[1] - new[0] * old[1]) * (new[1] - old[1]) < ZERO


@wp.func
def synchrony_with(before: Synchrony, lag: wp.vec2d) -> Synchrony:
    """The record of a run's step with the field with one more lag vector in it."""
    after = before
    if before.locked == 1 and passed_behind(before.lag, lag):
        after.slips += 1
        after.locked = 0
    if lag[0] > ZERO:
        after.locked = 1
    after.lag = lag
    return after
