"""Ensembles: a scenario and perturbed copies of it, run in one batch and judged."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.engine import DEFAULT, TOLERANCE, History, advance, method_named, start_state
from helimag.errors import InputError, RunError
from helimag.outcomes import End, Verdict
from helimag.runs import Judgement
from helimag.runs.shares import in_percent, wilson
from helimag.scenario import Input, Parameters, Prior, Scenario

Floats = NDArray[np.float64]

RUNS = 32


@dataclass(frozen=True)
class Perturbation:
    """How copies of a scenario differ from it.

    Attributes
    ----------
    priors
        Inputs by path, each drawn from its prior (SI), independent of the others.
    displacement
        Standard deviation along each axis (m) of where the device is released. The magnet's path is the scenario's; to
        move both, give ``drive.start.x`` and so on a prior.
    """

    priors: Mapping[str, Prior] = field(default_factory=dict)
    displacement: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.displacement < np.inf:
            raise InputError(f"displacement must be a length of zero or more; got {self.displacement:g} m")
        if not self.priors and self.displacement == 0.0:
            raise InputError("a perturbation must have priors of inputs, a displacement, or both; got neither")

    def copies(
        self, scenario: Scenario, runs: int, random: np.random.Generator, start: Floats | None = None
    ) -> "Copies":
        """Draw copies: first all inputs, run by run, then all displacements.

        Parameters
        ----------
        start
            (7,): head position (m) and quaternion that all are displaced from; default where each copy begins.

        Returns
        -------
        Copies
            Scenarios with their states.

        Raises
        ------
        InputError
            Where an input cannot be varied, or a drawn value does not fit.
        """
        drawn = [scenario] * runs
        if self.priors:
            parameters = Parameters.of(scenario, self.priors)
            drawn = parameters.scenarios(parameters.from_unit(random.random((runs, len(self.priors)))))
        states = np.array([start_state(copy) if start is None else start for copy in drawn]).reshape(-1, 7)
        if self.displacement > 0.0:
            states[:, :3] += self.displacement * random.standard_normal((runs, 3))
        return Copies(drawn, states)


@dataclass(frozen=True)
class Copies:
    """Scenarios and the states (n, 7) that their runs begin in."""

    scenarios: Sequence[Scenario]
    states: Floats

    def part(self, begin: int, end: int) -> "Copies":
        """Some of them."""
        return Copies(self.scenarios[begin:end], self.states[begin:end])


@dataclass(frozen=True)
class Ensemble:
    """The run of a scenario, and those of its perturbed copies.

    Attributes
    ----------
    nominal
        Run as the scenario says.
    copies
        Perturbed runs, in the order drawn.
    inputs
        Paths of the inputs that differ.
    """

    nominal: History
    copies: Sequence[History]
    inputs: tuple[str, ...] = ()

    @property
    def scenario(self) -> Scenario:
        """What the copies are copies of."""
        return self.nominal.scenario

    @cached_property
    def judgement(self) -> Judgement:
        """Of the run as the scenario says."""
        return self.nominal.judge()

    @cached_property
    def judgements(self) -> list[Judgement]:
        """Of the copies."""
        return [copy.judge() for copy in self.copies]

    @property
    def verdicts(self) -> Counter[Verdict]:
        """How many copies got which verdict."""
        return Counter(judgement.verdict for judgement in self.judgements)

    @property
    def shares(self) -> dict[Verdict, tuple[float, float, float]]:
        """Share of the copies with each verdict that occurs, and lower and upper end of that of all (95 %, Wilson)."""
        total = len(self.copies)
        return {verdict: (n / total, *wilson(n / total, total)) for verdict, n in self.verdicts.most_common()}

    @property
    def gains(self) -> Floats:
        """Gains of the copies (n,)."""
        return np.array([judgement.gain for judgement in self.judgements])

    @property
    def rows(self) -> list[dict[str, Any]]:
        """One row a copy, SI: its inputs by path, where it began (m), verdict, gain, when it ended and escaped (s)."""
        found = []
        for copy, judgement in zip(self.copies, self.judgements, strict=True):
            inputs = {path: Input(path).value(copy.scenario) for path in self.inputs}
            begin = dict(zip(("start_x", "start_y", "start_z"), copy.states[0, :3].tolist(), strict=True))
            found.append(
                inputs
                | begin
                | {
                    "verdict": judgement.verdict,
                    "gain": judgement.gain,
                    "end_time": judgement.end_time,
                    "escape_time": judgement.escape_time,
                }
            )
        return found

    @property
    def text(self) -> str:
        """The verdicts in a sentence."""
        parts = [
            f"{self.verdicts[verdict]} {verdict} ({in_percent(low)} to {in_percent(high)} % of all)"
            for verdict, (_, low, high) in self.shares.items()
        ]
        return f"of {len(self.copies)} copies {', '.join(parts)}, with 95 % confidence"


def ensemble(
    scenario: Scenario,
    perturbation: Perturbation,
    *,
    runs: int = RUNS,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    method: str = DEFAULT,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Ensemble:
    """Run a scenario and perturbed copies of it in one batch, and judge them.

    Parameters
    ----------
    scenario
        What to run.
    perturbation
        How the copies differ: inputs with priors, where the device is released, or both.
    runs
        Number of copies.
    seed
        Of the draws: the same seed draws the same copies.
    tolerance
        Of one step, see :func:`helimag.engine.advance`.
    method
        As for :func:`helimag.simulate`.
    device
        ``"cpu"`` or a CUDA device such as ``"cuda"``.
    threads
        CPU threads; default one a core.
    progress
        Called with the fraction done, some times a second.

    Returns
    -------
    Ensemble
        Verdicts with their shares and Wilson intervals, gains, and a row for each copy.

    Raises
    ------
    InputError
        Where an input cannot be varied, or a drawn value does not fit.
    RunError
        Where the numbers of a run broke down.
    """
    (found,) = ensembles(
        [scenario],
        perturbation,
        runs=runs,
        seed=seed,
        tolerance=tolerance,
        method=method_named(method),
        device=device,
        threads=threads,
        progress=progress,
    )
    return found


def ensembles(
    scenarios: Sequence[Scenario], perturbation: Perturbation, *, runs: int = RUNS, seed: int = 0, **engine: Any
) -> list[Ensemble]:
    """As :func:`ensemble`, for several scenarios in one batch, their copies drawn one scenario after the other.

    Returns
    -------
    list of Ensemble
        In the order of the scenarios.
    """
    if runs < 1:
        raise InputError(f"an ensemble must have at least one copy; got {runs}")
    random = np.random.default_rng(seed)
    drawn = [perturbation.copies(scenario, runs, random) for scenario in scenarios]
    batch: list[Scenario] = []
    states: list[Floats] = []
    for scenario, copies in zip(scenarios, drawn, strict=True):
        batch += [scenario, *copies.scenarios]
        states += [start_state(scenario)[None], copies.states]
    histories = finished(advance(batch, initial_states=np.concatenate(states), **engine))
    size = runs + 1
    inputs = tuple(perturbation.priors)
    return [Ensemble(histories[i], histories[i + 1 : i + size], inputs) for i in range(0, len(histories), size)]


def finished(histories: Sequence[History]) -> Sequence[History]:
    """The histories, none of which broke down.

    Returns
    -------
    sequence of History
        As given.

    Raises
    ------
    RunError
        Where the numbers of a run broke down: it has no verdict.
    """
    for i, history in enumerate(histories):
        if history.status is End.NOT_FINITE:
            name = history.scenario.title
            raise RunError(f"run {i} of {len(histories)} of '{name}' broke down at {history.time[-1]:.6g} s")
    return histories


def tally(copies: Copies, **engine: Any) -> Counter[Verdict]:
    """Run copies and count their verdicts.

    Returns
    -------
    collections.Counter
        How many copies have each verdict.

    Raises
    ------
    RunError
        Where the numbers of a run broke down.
    """
    histories = finished(advance(copies.scenarios, initial_states=copies.states, **engine))
    return Counter(history.judge().verdict for history in histories)
