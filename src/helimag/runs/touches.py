"""Contacts of a run with floor, surface and walls that hold, and what they say of it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.outcomes import Limit

LATE = 0.5  # of a run: what holds the device in the rest of it decides the verdict


@dataclass(frozen=True, kw_only=True)
class Touch:
    """Contacts with one wall: how often one began, when the first did, when the last was seen, how long all took (s).

    Times are those of the integrator's steps.
    """

    wall: Limit
    count: int
    first: float
    last: float
    total: float

    @property
    def numbers(self) -> dict[str, object]:
        """For the sentence that gives the reason for the verdict on a run that this wall holds."""
        count = "one contact" if self.count == 1 else f"{self.count} contacts"
        return {"count": count, "first": self.first, "last": self.last, "total": self.total, "side": str(self.wall)}

    @property
    def times(self) -> str:
        """How often, in words."""
        return "once" if self.count == 1 else f"{self.count} times"


def touches_from(values: Mapping[str, Sequence[float] | NDArray[np.float64]]) -> tuple[Touch, ...]:
    """Contacts with each wall that was touched, from ``count``, ``first``, ``last``, ``total`` of all walls (6,)."""
    return tuple(
        Touch(
            wall=wall,
            count=int(values["count"][wall.flag]),
            first=float(values["first"][wall.flag]),
            last=float(values["last"][wall.flag]),
            total=float(values["total"][wall.flag]),
        )
        for wall in Limit
        if values["count"][wall.flag] > 0
    )


class Contacts(NamedTuple):
    """Contacts with all walls: how often one began, how long they took, each wall's time added, and the first (s)."""

    number: int
    total: float
    first: float | None


UNTOUCHED = Contacts(0, 0.0, None)


def summed(touches: Sequence[Touch]) -> Contacts:
    """Contacts with all walls together."""
    if not touches:
        return UNTOUCHED
    number, total = sum(touch.count for touch in touches), math.fsum(touch.total for touch in touches)
    return Contacts(number, total, min(touch.first for touch in touches))


def holding(touches: Sequence[Touch], time: NDArray[np.float64]) -> Touch | None:
    """The wall that holds the device at the end of a run sampled at ``time`` (s), if one does.

    A device that leaves its walls for good in the first half of a run has the second to show what it does on its own.
    """
    since = time[0] + LATE * (time[-1] - time[0])
    late = [touch for touch in touches if touch.last > since]
    return max(late, key=lambda touch: (touch.last, touch.total), default=None)
