"""A run and its twins: the same drive, the device let go a little to the side."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from helimag.engine import History, advance, trajectory_of
from helimag.runs.gain import Judgement
from helimag.runs.trajectory import Trajectory
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

TWINS = 32
DISPLACEMENT = 10e-6  # m, standard deviation along each axis
SEED = 3


@dataclass(frozen=True)
class Ensemble:
    """A run as its scenario says, and its twins."""

    nominal: History
    twins: list[History]

    @property
    def scenario(self) -> Scenario:
        """What was run."""
        return self.nominal.scenario

    @property
    def trajectory(self) -> Trajectory:
        """The run without its twins."""
        return trajectory_of(self.nominal)

    @cached_property
    def judgement(self) -> Judgement:
        """Of the run without its twins."""
        return self.nominal.judge()

    @cached_property
    def judgements(self) -> list[Judgement]:
        """Of the twins."""
        return [twin.judge() for twin in self.twins]

    @property
    def verdicts(self) -> Counter[str]:
        """How many twins got which verdict."""
        return Counter(str(judgement.verdict) for judgement in self.judgements)

    @property
    def first_slip(self) -> float | None:
        """When the run first slips a turn against the field (s)."""
        slipped = np.flatnonzero(self.nominal.slips > 0.0)
        return float(self.nominal.time[slipped[0]]) if slipped.size else None


def displaced_states(position: Sequence[float], count: int, rng: np.random.Generator) -> Floats:
    """Level states around a position (m), the first exactly there, the others normally displaced: (count + 1, 7)."""
    states = np.tile([*position, 1.0, 0.0, 0.0, 0.0], (count + 1, 1))
    states[1:, :3] += DISPLACEMENT * rng.standard_normal((count, 3))
    return states


def run_ensembles(
    scenarios: Sequence[Scenario], *, twins: int = TWINS, progress: Callable[[float], None] | None = None
) -> list[Ensemble]:
    """Run each scenario with its twins, all in one batch; the magnet's path is that of the scenario for every twin.

    Raises
    ------
    RunError
        Where a run broke down.
    """
    rng = np.random.default_rng(SEED)
    size = twins + 1
    histories = advance(
        [scenario for scenario in scenarios for _ in range(size)],
        initial_states=np.concatenate([displaced_states(s.drive.start, twins, rng) for s in scenarios]),
        progress=progress,
    )
    return [Ensemble(histories[i], histories[i + 1 : i + size]) for i in range(0, len(histories), size)]
