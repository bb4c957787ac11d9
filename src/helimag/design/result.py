"""A drive with tolerances, and what was seen of it."""

from dataclasses import dataclass

from helimag.orbits import Orbit, StableInterval
from helimag.outcomes import Verdict
from helimag.scenario import Input, Scenario


@dataclass(frozen=True)
class Design:
    """A drive with tolerances.

    Attributes
    ----------
    orbit
        Stable.
    scenario
        The designed one, as long as the runs that check it.
    intervals
        Where it stays stable as one input varies.
    tolerances
        Half width (SI) for each input such that all may be off at once.
    verdicts
        How many of the perturbed full runs ended how.
    on_orbit
        Whether those runs began on the orbit (the scenario's own start does not lead to it) instead of at the start.
    """

    orbit: Orbit
    scenario: Scenario
    intervals: dict[str, StableInterval]
    tolerances: dict[str, float]
    verdicts: dict[Verdict, int]
    on_orbit: bool

    @property
    def duration(self) -> float:
        """Of the runs, s."""
        return self.scenario.run.duration

    @property
    def bounded(self) -> int:
        """How many of the perturbed runs stayed bounded."""
        return self.verdicts.get(Verdict.BOUNDED, 0)

    @property
    def text(self) -> str:
        """Inputs with tolerances, intervals, and the check."""
        lines = []
        for path, half in self.tolerances.items():
            given = Input(path)
            here = given.show(self.scenario, given.value(self.scenario), 4)
            off = given.show(self.scenario, half, 2)
            lines.append(f"{path:18s} {here} ± {off}; alone {self.intervals[path].text}")
        total = sum(self.verdicts.values())
        tally = ", ".join(f"{count} {verdict}" for verdict, count in self.verdicts.items())
        place = "the orbit" if self.on_orbit else "the scenario's start"
        lines.append(
            f"speed {1e3 * self.orbit.speed:.4g} mm/s, radius {1e3 * self.orbit.radius:.4g} mm; "
            f"{total} full runs of {self.duration:.0f} s from {place}, all inputs off at once: {tally}"
        )
        return "\n".join(lines)
