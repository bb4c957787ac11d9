"""How small and how large each kind of quantity may be: wide enough for every laboratory, and why not wider.

Beyond them a typing error is likelier than an experiment, the model does not hold, or a run would never end. Forces,
moments and densities have no limits: where they are absurd, the run's numbers break down, which is said.
"""

import math
import sys
from typing import NamedTuple

from helimag import quantities as q
from helimag.errors import InputError


class Limits(NamedTuple):
    """Least size of what must be positive, and largest size of what may have either sign (SI), each with its reason."""

    least: float
    too_small: str
    most: float
    too_large: str


LIMITS = {
    q.LENGTH: Limits(1e-9, "where a fluid is no continuum", 100.0, "where a magnet's field is far below the Earth's"),
    q.ANGLE: Limits(0.0, "", 1e9, "beyond which rounding decides the direction"),
    q.ANGULAR_RATE: Limits(0.0, "", 2.0 * math.pi * 10.0, "ten turns a second, which no arm reaches"),
    q.FREQUENCY: Limits(0.0, "", 1e4, "which no motor reaches"),
    q.VELOCITY: Limits(0.0, "", 100.0, "which no arm reaches"),
    q.ACCELERATION: Limits(0.0, "", 1e4, "which no arm reaches"),
    q.MASS: Limits(1e-6, "less than any motor weighs", 1e3, "which no arm carries"),
    q.INERTIA: Limits(0.0, "", 1e3, "which no arm turns"),
    q.TIME: Limits(1e-9, "which is no time for a device to move", 1e9, "thirty years"),
    q.REMANENCE: Limits(1e-6, "which is no magnet", 2.5, "more than the saturation of any material"),
    q.VISCOSITY: Limits(1e-6, "a tenth of that of gases", 1e6, "where nothing moves within a day"),
}
LEAST_FREQUENCY = 1e-6  # Hz: a turn in eleven days; steps are counted in turns


def sizes(kind: q.Kind) -> tuple[float, float]:
    """Least size of a positive quantity of a kind, and largest size of any (SI): all numbers where it has no limits."""
    limits = LIMITS.get(kind)
    return (0.0, sys.float_info.max) if limits is None else (limits.least, limits.most)


def check_size(value: float, kind: q.Kind, *, positive: bool) -> None:
    """Raise InputError, with the limit and its reason, where a value (SI) is larger or smaller than is sensible."""
    limits = LIMITS.get(kind)
    if limits is None:
        return
    if abs(value) > limits.most:
        bound = f"at most {q.show(limits.most, kind)}" + ("" if positive else " either way")
        raise InputError(f"must be {bound} ({limits.too_large}); got '{q.show(value, kind)}'")
    if positive and value < limits.least:
        bound = q.show(limits.least, kind)
        raise InputError(f"must be at least {bound} ({limits.too_small}); got '{q.show(value, kind)}'")
