"""All checks of a scenario, and what does not hold over a batch: one entry a kind, never one a run."""

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from helimag.checks.check import Check
from helimag.checks.flow import (
    boundary_drag,
    enclosing_body,
    pitch_angle,
    reynolds,
    slenderness,
    wall_gap,
    wall_resolved,
)
from helimag.checks.magnets import magnet_distance, step_out
from helimag.scenario import Scenario

CHECKS: tuple[Callable[[Scenario], Check | None], ...] = (
    reynolds,
    slenderness,
    pitch_angle,
    enclosing_body,
    wall_gap,
    wall_resolved,
    magnet_distance,
    step_out,
)
THOROUGH = (*CHECKS, boundary_drag)


@dataclass(frozen=True)
class Caution:
    """An assumption that does not hold in some runs of a batch; ``where`` says in which it is worst."""

    worst: Check
    runs: int
    of: int
    where: str

    @property
    def text(self) -> str:
        """One line."""
        check = self.worst
        if self.of == 1:
            return f"{check.name}: {check.message}; {check.remedy}"
        at = f" at {self.where}" if self.where else ""
        return f"{check.name}: {self.runs} of {self.of} runs, worst{at}: {check.message}; {check.remedy}"

    def as_dict(self) -> dict[str, object]:
        """For JSON and for attributes of files."""
        return {**self.worst.as_dict(), "runs": self.runs, "of": self.of, "where": self.where, "text": self.text}


def examine(scenario: Scenario, *, thorough: bool = False) -> list[Check]:
    """Every check that applies, whether it holds or not; ``thorough``: those that take seconds, too."""
    return [found for check in (THOROUGH if thorough else CHECKS) if (found := check(scenario)) is not None]


def cautions(scenarios: Iterable[Scenario], where: Callable[[int], str] = lambda _: "") -> list[Caution]:
    """What does not hold over a batch, grouped by kind, in the order of the checks.

    Parameters
    ----------
    scenarios
        The batch.
    where
        Says which run the n-th is, such as ``"drive.pitch = 12 deg"``.

    Returns
    -------
    list of Caution
        None of what holds.
    """
    failed: dict[str, list[tuple[int, Check]]] = defaultdict(list)
    total = 0
    for total, scenario in enumerate(scenarios, start=1):
        for check in examine(scenario):
            if not check.holds:
                failed[check.name].append((total - 1, check))
    found = []
    for name in (check.__name__ for check in CHECKS):
        if name in failed:
            run, worst = max(failed[name], key=lambda pair: pair[1].excess)
            found.append(Caution(worst, runs=len(failed[name]), of=total, where=where(run)))
    return found
