"""What the time loop recorded of one run."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from helimag.engine.packing import initial_gap
from helimag.engine.slow_times import slow_times
from helimag.outcomes import End
from helimag.runs.gain import Judgement, judge
from helimag.runs.heights import Heights
from helimag.runs.touches import Touch, touches_from
from helimag.scenario import Scenario

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class History:
    """The raw material of a trajectory, and enough for a judgement.

    Attributes
    ----------
    scenario
        What was run.
    time
        (n,): when samples were taken, s; the last is the end, where the run has ended.
    records
        (n,): the samples, with the fields of :class:`helimag.engine.samples.Record`.
    status
        How the run stands; ``RUNNING`` where it was stopped before its end.
    steps, rejected
        Steps that were taken, and trials that were not.
    wall_time
        Share of the batch's time that fell to this run, s.
    progress
        All that is needed to go on; ``memory`` with it, where the method leaps over turns.
    memory
        What is remembered of turns that were followed, see :class:`helimag.engine.turn_memory.Memory`.
    """

    scenario: Scenario
    time: Floats
    records: NDArray[np.void]
    status: End
    steps: int
    rejected: int
    wall_time: float
    progress: np.void = field(repr=False)
    memory: dict[str, Floats] = field(repr=False, default_factory=dict)

    @property
    def states(self) -> Floats:
        """Head position (m) and quaternion w, x, y, z at each sample: (n, 7)."""
        return np.asarray(self.records["state"])

    @property
    def slips(self) -> Floats:
        """Turns slipped against the field up to each sample: (n,)."""
        return self.records["slips"].astype(np.float64)

    @property
    def leapt(self) -> float:
        """Share of the run's turns of the magnet that it was taken over by leaps."""
        turns = float(self.time[-1]) * abs(self.scenario.drive.frequency)
        return float(self.progress["leap"]["turns"]) / turns if turns > 0.0 else 0.0

    @cached_property
    def heights(self) -> Heights:
        """What a judgement needs."""
        samples = self.records
        return Heights(
            time=self.time,
            low=samples["low"],
            high=samples["high"],
            mean=samples["height"],
            attack=samples["attack"],
            attack_square=samples["square"],
            slips=int(samples["slips"][-1]),
            initial_gap=initial_gap(self.scenario),
            end=self.status,
            slow=slow_times(self.scenario),
            touches=self.touches,
        )

    @property
    def touches(self) -> tuple[Touch, ...]:
        """Contacts with each wall that was touched."""
        return touches_from(self.contacts) if self.scenario.workspace.holds else ()

    @property
    def contacts(self) -> dict[str, Floats]:
        """Count, first and last time, and total (s) of contacts with each wall, at its number: (6,) each."""
        kept = self.progress["touches"]
        return {name: np.asarray(kept[name], dtype=np.float64) for name in ("count", "first", "last", "total")}

    def judge(self) -> Judgement:
        """Gain and verdict."""
        return judge(self.heights)
