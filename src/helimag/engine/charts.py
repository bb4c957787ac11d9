"""Attitudes near a reference by three coordinates: how far the long axis swung, and the roll about it.

In these coordinates the roll, which a turn of the magnet makes forget where it began, is one and the same component
wherever the device points, so that a Jacobian of the turn serves for many places. Swing and twist: P. Dobrowolski,
Swing-twist decomposition in Clifford algebra, arXiv:1506.05481 (2015).
"""

import warp as wp

from helimag.physics.kinematics import State

ZERO = wp.constant(wp.float64(0.0))
HALF = wp.constant(wp.float64(0.5))
ONE = wp.constant(wp.float64(1.0))
TWO = wp.constant(wp.float64(2.0))
LEAST_COSINE = wp.constant(wp.float64(0.05))  # of half a swing, so that numbers stay numbers where a guess went wrong
MOST_SWING = wp.constant(wp.float64(0.8))  # of the long axis from the reference, in a chart's coordinates
MOST_ROLL = wp.constant(wp.float64(1.5))  # rad

# head (m), twice the sine of half the swing about body y and z, roll (rad)
Place = wp.types.vector(length=6, dtype=wp.float64)


@wp.func
def to_chart(reference: State, state: State) -> Place:
    """Coordinates of a state in the chart about the attitude of ``reference``."""
    a = reference[3]
    b = reference[4]
    c = reference[5]
    d = reference[6]
    w = a * state[3] + b * state[4] + c * state[5] + d * state[6]
    x = a * state[4] - b * state[3] - c * state[6] + d * state[5]
    y = a * state[5] + b * state[6] - c * state[3] - d * state[4]
    z = a * state[6] - b * state[5] + c * state[4] - d * state[3]
    if w < ZERO:
        w = -w
        x = -x
        y = -y
        z = -z
    scale = TWO / wp.sqrt(w * w + x * x)
    return Place(state[0], state[1], state[2], scale * (y * w - z * x), scale * (z * w + y * x), TWO * wp.atan2(x, w))


@wp.func
def from_chart(reference: State, place: Place) -> State:
    """The state at these coordinates."""
    a = reference[3]
    b = reference[4]
    c = reference[5]
    d = reference[6]
    swing_y = HALF * place[3]
    swing_z = HALF * place[4]
    swing = wp.sqrt(wp.max(ONE - swing_y * swing_y - swing_z * swing_z, LEAST_COSINE))
    cosine = wp.cos(HALF * place[5])
    sine = wp.sin(HALF * place[5])
    w = swing * cosine
    x = swing * sine
    y = swing_y * cosine + swing_z * sine
    z = swing_z * cosine - swing_y * sine
    return State(
        place[0],
        place[1],
        place[2],
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


@wp.func
def far_off(place: Place) -> bool:
    """Whether a place is so far from the chart's reference that a new one should be made."""
    return wp.max(wp.abs(place[3]), wp.abs(place[4])) > MOST_SWING or wp.abs(place[5]) > MOST_ROLL
