"""A drive with tolerances, and what was seen of it."""

from dataclasses import dataclass

from helimag.orbits import Orbit, StableInterval
from helimag.outcomes import Verdict
from helimag.runs.shares import in_percent, wilson
from helimag.scenario import Input, Scenario


@dataclass(frozen=True)
class Design:
    """A drive with tolerances, or with the probability that a device is bounded of which not all is known.

    Attributes
    ----------
    orbit
        Stable.
    scenario
        The designed one, as long as the runs that check it; with the likeliest device.
    intervals
        Where it stays stable as one input varies.
    tolerances
        Half width (SI) for each input such that all may be off at once; empty where devices took their place.
    verdicts
        How many of the full runs ended how: perturbed ones, or those of the devices.
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
        """How many of the runs stayed bounded."""
        return self.verdicts.get(Verdict.BOUNDED, 0)

    @property
    def probability(self) -> tuple[float, float, float]:
        """Share of the runs that stayed bounded, and lower and upper end of that of all (95 %, Wilson)."""
        total = sum(self.verdicts.values())
        return self.bounded / total, *wilson(self.bounded / total, total)

    @property
    def text(self) -> str:
        """Inputs with tolerances, intervals, and the check."""
        lines = []
        for path, interval in self.intervals.items():
            given = Input(path)
            here = given.show(self.scenario, given.value(self.scenario), 4)
            off = f" ± {given.show(self.scenario, self.tolerances[path], 2)}" if self.tolerances else ""
            lines.append(f"{path:18s} {here}{off}; alone {interval.text}")
        total = sum(self.verdicts.values())
        tally = ", ".join(f"{count} {verdict}" for verdict, count in self.verdicts.items())
        place = "the orbit" if self.on_orbit else "the scenario's start"
        how = "all inputs off at once" if self.tolerances else "each with its device"
        lines.append(
            f"speed {1e3 * self.orbit.speed:.4g} mm/s, radius {1e3 * self.orbit.radius:.4g} mm; "
            f"{total} full runs of {self.duration:.0f} s from {place}, {how}: {tally}"
        )
        share, low, high = map(in_percent, self.probability)
        lines.append(f"bounded with a probability of {share}% ({low}% to {high}%, with 95 % confidence)")
        return "\n".join(lines)
