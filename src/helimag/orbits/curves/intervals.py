"""Where along a branch orbits are stable: intervals of one input."""

from collections.abc import Callable
from dataclasses import dataclass

from helimag.errors import InputError
from helimag.orbits.curves.branch import Branch
from helimag.orbits.curves.continuation import follow
from helimag.orbits.strobe import Orbit
from helimag.scenario import Scenario
from helimag.scenario.inputs import Input


@dataclass(frozen=True)
class StableInterval:
    """Where an orbit stays stable as one input varies: ends (SI) and what happens at each."""

    path: str
    scenario: Scenario
    low: float
    high: float
    why_low: str
    why_high: str

    @property
    def margin(self) -> float:
        """From the scenario's own value to the nearer end, SI."""
        here = Input(self.path).value(self.scenario)
        return min(here - self.low, self.high - here)

    @property
    def text(self) -> str:
        """The interval as a sentence."""
        given = Input(self.path)
        low, high = given.show(self.scenario, self.low), given.show(self.scenario, self.high)
        return f"stable for {given.name} between {low} ({self.why_low}) and {high} ({self.why_high})"


def stable_interval(
    orbit: Orbit, path: str, low: float, high: float, *, progress: Callable[[float], None] | None = None
) -> StableInterval:
    """Follow a stable orbit both ways through an input to where it loses stability, or to the ends of the range.

    Parameters
    ----------
    orbit
        A stable one, at a value of the input within the range.
    path
        Dotted path of a scalar field, such as ``drive.pitch``; or ``drive.speed``.
    low, high
        Range of the input, SI.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    StableInterval
        Its ends, and what happens there.

    Raises
    ------
    InputError
        Where the orbit is not stable, or as for :func:`follow`.
    """
    if not orbit.stable:
        raise InputError(f"an interval of stability needs a stable orbit; this one is not: {orbit.text}")
    return stable_segments(follow(orbit, path, low, high, while_stable=True, progress=progress))[0]


def stable_segments(branch: Branch) -> list[StableInterval]:
    """The stable stretches of a branch, in order of arclength."""
    marks = {event.index: (event.value, str(event.kind)) for event in branch.events}
    last = len(branch.points)
    marks.setdefault(0, (branch.points[0].value, branch.ends[0]))
    marks.setdefault(last, (branch.points[-1].value, branch.ends[1]))
    scenario = branch.points[branch.origin].orbit.scenario
    stable = [False, *(point.orbit.stable for point in branch.points), False]
    begins = [i for i in range(last) if stable[i + 1] and not stable[i]]
    ends = [i for i in range(1, last + 1) if stable[i] and not stable[i + 1]]
    result = []
    for begin, end in zip(begins, ends, strict=True):
        (low, why_low), (high, why_high) = sorted([marks[begin], marks[end]])
        result.append(StableInterval(branch.path, scenario, low, high, why_low, why_high))
    return result
