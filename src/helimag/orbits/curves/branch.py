"""A branch: orbits along one input, and where their stability changes.

Y. A. Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed., Springer 2004, ch. 4.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from helimag.orbits.strobe import Floats, Orbit
from helimag.scenario.inputs import Input


class Change(StrEnum):
    """How stability changes along a branch."""

    FOLD = "fold"
    NEIMARK_SACKER = "Neimark-Sacker"
    PERIOD_DOUBLING = "period doubling"
    BRANCH_POINT = "branch point"

    @property
    def meaning(self) -> str:
        """What happens there."""
        return _MEANINGS[self]


_MEANINGS = {
    Change.FOLD: "the orbit meets an unstable one and both vanish",
    Change.NEIMARK_SACKER: "a slow swing begins to grow",
    Change.PERIOD_DOUBLING: "the orbit begins to repeat only every second turn",
    Change.BRANCH_POINT: "another orbit passes through",
}


@dataclass(frozen=True)
class Point:
    """One orbit of a branch; ``tangent`` (7,) is the direction of travel: chart, then the input over its range."""

    value: float
    orbit: Orbit
    tangent: Floats

    @property
    def unstable(self) -> int:
        """How many multipliers lie outside the unit circle."""
        return int(np.count_nonzero(np.abs(self.orbit.multipliers) > 1.0))


@dataclass(frozen=True)
class Event:
    """A change of stability, located; ``index`` counts the points of the branch before it."""

    kind: Change
    value: float
    orbit: Orbit
    index: int

    @property
    def swing(self) -> float:
        """Imaginary part of the rate that crosses zero, 1/s; zero where a real one does."""
        if self.kind in (Change.FOLD, Change.BRANCH_POINT):
            return 0.0
        swings = self.orbit.rates[np.abs(self.orbit.rates.imag) > 0.0]
        return float(abs(swings[np.argmin(np.abs(swings.real))].imag))


@dataclass(frozen=True)
class Branch:
    """Orbits along one input in order of arclength, what happens on the way, and why it ends at either end.

    ``origin`` counts the points before the orbit that was followed.
    """

    path: str
    low: float
    high: float
    points: list[Point]
    events: list[Event]
    ends: tuple[str, str]
    origin: int

    @property
    def values(self) -> Floats:
        """Values of the input (n,), SI."""
        return np.array([point.value for point in self.points])

    @property
    def text(self) -> str:
        """Events and ends in words."""
        given, scenario = Input(self.path), self.points[0].orbit.scenario
        begin, end = (given.show(scenario, point.value) for point in (self.points[0], self.points[-1]))
        lines = [f"from {begin} ({self.ends[0]}) to {end} ({self.ends[1]}), {len(self.points)} orbits"]
        for event in self.events:
            meaning = event.kind.meaning
            if event.kind is Change.NEIMARK_SACKER:
                meaning += f", of period {2.0 * np.pi / event.swing:.4g} s"
            lines.append(f"{event.kind} at {given.show(scenario, event.value)}: {meaning}")
        return "\n".join(lines)
