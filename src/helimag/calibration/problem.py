"""A plan made ready: from values of the free inputs to runs, and from runs to the likelihood of what was observed."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from helimag.calibration.escapes import ENDS, log_stay, log_time
from helimag.calibration.numbers import NUMBERS
from helimag.calibration.plan import (
    CalibrationPlan,
    Candidate,
    Ending,
    Experiment,
    Free,
    Observation,
    ObservedNumber,
    Track,
    load_plan,
    si,
)
from helimag.engine import History, advance
from helimag.errors import InputError
from helimag.outcomes import End
from helimag.runs import Trajectory
from helimag.scenario import Input, LogUniform, Normal, Prior, Scenario, Uniform, check_apart, load, varied

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Expected:
    """What an observation is compared with in a run: numbers (m,) observed, their sd, and how to compute them.

    ``side`` is 0 for a number; -1 where all below what was observed is as good (an end at some time before), +1 where
    all above is (a device that stays for at least so long).
    """

    label: str
    unit: str
    observed: Floats
    sd: Floats
    value: Callable[[History], Floats]
    side: int = 0

    def loglikelihood(self, predicted: Floats) -> float:
        """Of predicted numbers (m,): normal, or the normal probability of what is as good."""
        from scipy.special import log_ndtr

        off = (predicted - self.observed) / self.sd
        if self.side:
            return float(log_ndtr(self.side * off).sum())
        return float(np.sum(-0.5 * off**2 - np.log(self.sd * math.sqrt(2.0 * math.pi))))


@dataclass(frozen=True)
class PreparedPlan:
    """A plan with its scenarios, priors and data read: a likelihood over the free inputs.

    Attributes
    ----------
    plan
        What was asked.
    bases
        The scenario of each run.
    priors
        Of each free input (SI).
    expected
        For each run, what was observed of it.
    """

    plan: CalibrationPlan
    bases: tuple[Scenario, ...]
    priors: tuple[Prior, ...]
    expected: tuple[tuple[Expected, ...], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Titles of the free inputs."""
        return tuple(free.title for free in self.plan.free)

    @cached_property
    def units(self) -> tuple[str, ...]:
        """Their SI units, ``"1"`` of a factor."""
        kinds = [None if free.factor else Input(free.input).kind(self._base_of(free)) for free in self.plan.free]
        return tuple("1" if kind is None else kind.si for kind in kinds)

    def _base_of(self, free: Free) -> Scenario:
        return next(base for run, base in zip(self.plan.run, self.bases, strict=True) if applies(free, run.name))

    def from_unit(self, points: ArrayLike) -> Floats:
        """Values (n, k), SI, of points (n, k) of the unit cube: what spreads evenly there follows the priors here."""
        given = np.asarray(points, dtype=np.float64)
        return np.stack([prior.quantile(given[..., i]) for i, prior in enumerate(self.priors)], axis=-1)

    def logprior(self, values: Floats) -> Floats:
        """Logarithm of the priors' density (n,) at values (n, k), SI, but for a constant; within their bounds."""
        columns = [_log_density(prior, values[:, i]) for i, prior in enumerate(self.priors)]
        return np.asarray(np.sum(columns, axis=0))

    def scenarios_at(self, values: ArrayLike) -> list[Scenario]:
        """The scenario of each run with the free inputs at values (k,), SI.

        Returns
        -------
        list of Scenario
            In the order of the plan's runs.

        Raises
        ------
        InputError
            Where they do not make scenarios.
        """
        row = np.asarray(values, dtype=np.float64)
        pairs = zip(self.plan.run, self.bases, strict=True)
        return [changed(base, self.plan.free, row, run.name) for run, base in pairs]

    def histories(self, values: Floats, *, threads: int | None = None) -> list[list[History] | None]:
        """All runs at each row of values (n, k); None where a row makes no scenario or its numbers broke down."""
        batch: list[Scenario] = []
        places: list[int | None] = []
        for row in values:
            try:
                scenarios = self.scenarios_at(row)
            except InputError:
                places.append(None)
                continue
            places.append(len(batch))
            batch += scenarios
        ran = advance(batch, threads=threads) if batch else []
        count = len(self.bases)
        found = [None if place is None else ran[place : place + count] for place in places]
        return [runs if runs and all(run.status is not End.NOT_FINITE for run in runs) else None for runs in found]

    def predicted(self, runs: Sequence[History]) -> list[Floats]:
        """What each observation, in the order of the plan, would be of these runs."""
        pairs = zip(runs, self.expected, strict=True)
        return [each.value(history) for history, observations in pairs for each in observations]

    @property
    def flat(self) -> tuple[Expected, ...]:
        """All observations, in the order of the plan."""
        return tuple(each for observations in self.expected for each in observations)

    def evaluate(self, values: Floats, *, threads: int | None = None) -> tuple[Floats, list[list[Floats] | None]]:
        """Log-likelihood (n,) and predictions at each row of values (n, k); minus infinity where nothing can run."""
        found, predictions = np.full(len(values), -np.inf), []
        for i, runs in enumerate(self.histories(values, threads=threads)):
            predicted = None if runs is None else self.predicted(runs)
            predictions.append(predicted)
            if predicted is not None:
                found[i] = math.fsum(e.loglikelihood(p) for e, p in zip(self.flat, predicted, strict=True))
        if np.isnan(found).any():
            raise InputError("an observation compares with a value that is not a number; check its sd and its track")
        return found, predictions


def applies(free: Free, run: str) -> bool:
    """Whether a free input belongs to a run."""
    return free.runs is None or run in free.runs


def changed(scenario: Scenario, frees: Sequence[Free], values: Floats, run: str | None) -> Scenario:
    """A scenario with free inputs at values (k,); ``run`` is its name in the plan, None for one that is not in it.

    Raises
    ------
    InputError
        Where the scenario cannot have them.
    """
    changes: dict[str, float] = {}
    for free, value in zip(frees, values.tolist(), strict=True):
        if applies(free, run) if run is not None else free.runs is None:
            path = Input(free.input)
            changes[free.input] = value * path.value(scenario) if free.factor else value
    return varied(scenario, changes) if changes else scenario


def prepared(plan: CalibrationPlan | str | Path) -> PreparedPlan:
    """Read what a plan names, and check that all of it fits together.

    Returns
    -------
    PreparedPlan
        With the scenarios, tracks and priors read.

    Raises
    ------
    FileError
        Where a file cannot be read.
    InputError
        Where an input, a prior or an observation does not fit its run.
    """
    plan = plan if isinstance(plan, CalibrationPlan) else load_plan(plan)
    bases = tuple(base_of(run) for run in plan.run)
    priors = tuple(_prior(free, plan, bases) for free in plan.free)
    for run in plan.run:
        own = [free for free in plan.free if applies(free, run.name)]
        if len({free.input for free in own}) < len(own):
            raise InputError(f"two free inputs change the same field of run '{run.name}'; give each its own runs")
        check_apart({free.input: None for free in own})
    expected = tuple(
        tuple(_expected(observation, run, base) for observation in run.observed)
        for run, base in zip(plan.run, bases, strict=True)
    )
    return PreparedPlan(plan, bases, priors, expected)


def base_of(run: Experiment | Candidate) -> Scenario:
    """The scenario of a run, with its changes."""
    base = run.base if isinstance(run.base, Scenario) else load(run.base)
    return varied(base, run.changes) if run.changes else base


def _prior(free: Free, plan: CalibrationPlan, bases: Sequence[Scenario]) -> Prior:
    path = Input(free.input)
    own = [base for run, base in zip(plan.run, bases, strict=True) if applies(free, run.name)]
    for base in own:
        path.check(base)
        if free.factor:
            path.value(base)
    kind = None if free.factor else path.kind(own[0])
    given = {key: getattr(free, key) for key in ("low", "high", "mean", "sd")}
    for key, value in given.items():
        if kind is not None and value is not None and not isinstance(value, str):
            raise InputError(f"free '{free.title}': {key} must be {kind.name} such as '{kind.example}'; got {value!r}")
    numbers = {key: si(value, kind, f"free '{free.title}': {key}") for key, value in given.items() if value is not None}
    try:
        if free.prior == "normal":
            bounds = {key: numbers[key] for key in ("low", "high") if key in numbers}
            return Normal(numbers["mean"], numbers["sd"], **bounds)
        even = Uniform if free.prior == "uniform" else LogUniform
        return even(numbers["low"], numbers["high"])
    except InputError as error:
        raise InputError(f"free '{free.title}': {error}") from None


def _log_density(prior: Prior, values: Floats) -> Floats:
    if isinstance(prior, Normal):
        return np.asarray(-0.5 * ((values - prior.mean) / prior.deviation) ** 2)
    return -np.log(values) if isinstance(prior, LogUniform) else np.zeros_like(values)


def _expected(observation: Observation, run: Experiment, base: Scenario) -> Expected:
    title, duration = f"{run.name}: {observation.label}", base.run.duration
    if isinstance(observation, Track):
        return _track(observation, title, base)
    if isinstance(observation, Ending):
        return _ending(observation, title, duration)
    return _number(observation, title, duration)


def _within(time: float | None, duration: float, title: str) -> float:
    if time is not None and time > duration * (1.0 + 1e-9):
        raise InputError(f"{title} is observed at {time:g} s, but the run ends at {duration:g} s; raise run.duration")
    return duration if time is None else time


def _number(observation: ObservedNumber, title: str, duration: float) -> Expected:
    until = _within(observation.until, duration, title)
    value, sd = observation.numbers
    kind, of = NUMBERS[observation.what].kind, NUMBERS[observation.what].value
    unit = "1" if kind is None else kind.si
    return Expected(title, unit, np.array([value]), np.array([sd]), lambda history: np.array([of(history, until)]))


def _ending(observation: Ending, title: str, duration: float) -> Expected:
    time = math.log(_within(observation.time, duration, title))
    sd = np.array([math.log1p(observation.spread)])
    if observation.what == "stays":
        return Expected(title, "ln s", np.array([time]), sd, lambda history: np.array([log_stay(history)]), side=1)
    end, side = ENDS[observation.what], -1 if observation.time is None else 0
    return Expected(title, "ln s", np.array([time]), sd, lambda history: np.array([log_time(history, end)]), side=side)


def _track(observation: Track, title: str, base: Scenario) -> Expected:
    run = Trajectory.load(observation.file)
    time = np.asarray(run.dataset["time"].values, dtype=np.float64)
    position = np.asarray(run.dataset["position"].values, dtype=np.float64)
    variance = np.zeros_like(position)
    if "position_covariance" in run.dataset:
        variance = np.einsum("nii->ni", np.asarray(run.dataset["position_covariance"].values, dtype=np.float64))
        variance = variance + float(run.dataset.attrs.get("position_accuracy", 0.0)) ** 2
    begins = observation.align == "start"
    if begins:
        time, position = time - time[0], position - position[0]
    whole = np.flatnonzero(np.isfinite(position).all(axis=1) & (time >= 0.0) & (time <= base.run.duration))
    if begins:
        whole = whole[whole > 0]  # the start is the same by definition
    if whole.size < 2:
        raise InputError(f"{title} has no two places within the {base.run.duration:g} s of its run")
    kept = whole[np.unique(np.linspace(0, whole.size - 1, observation.samples).astype(int))]
    times = time[kept]

    def places(history: History) -> Floats:
        states = history.states[:, :3]
        columns = [np.interp(times, history.time, column) for column in (states - begins * states[0]).T]
        return np.stack(columns, axis=1).ravel()

    sd = np.sqrt(variance[kept] + observation.sd**2)
    return Expected(title, "m", position[kept].ravel(), sd.ravel(), places)
