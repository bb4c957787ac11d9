"""Input-output gain (paper, eqs 5-6) and the verdict on a run, simulated or measured alike."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.outcomes import End, Reason, Verdict
from helimag.runs.evidence import STILL, Said, evidence
from helimag.runs.heights import Heights, spans_between
from helimag.runs.touches import Touch, holding, summed

Floats = NDArray[np.float64]

FALLEN = 0.5  # of the input: a head this far below its start and still sinking has lost the magnet
SAMPLED = ("time", "low", "high", "mean", "attack", "attack_square")
TOGETHER = ("gain", "output", "input", "end_time", "wobble", "attack_angle", "height_change")
ONE_BY_ONE = ("escape_time", "slips", "contacts", "contact_time", "first_contact")


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """Gain and verdict of a run (SI, radians): ``cause`` decides the verdict, ``reason`` says it with the numbers."""

    gain: float
    output: float
    input: float
    cause: Reason
    reason: str
    end_time: float
    escape_time: float | None
    slips: int
    wobble: float
    attack_angle: float
    touches: tuple[Touch, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """The verdict: how the run is judged."""
        return self.cause.verdict

    @property
    def contacts(self) -> int:
        """How often the device came to a wall that held it."""
        return summed(self.touches).number

    @property
    def contact_time(self) -> float:
        """How long walls held the device, each wall's time added (s)."""
        return summed(self.touches).total

    @property
    def first_contact(self) -> float | None:
        """When the device first came to such a wall (s); None where it never did."""
        return summed(self.touches).first


@dataclass(frozen=True)
class Judgements:
    """Judgements of several runs.

    Attributes
    ----------
    numbers
        (n,) each, by the names of :class:`Judgement`, and ``height_change``: mean height at the end less that at the
        start (m). NaN for None, and of a run that cannot be judged.
    said
        Why each has its verdict; None of a run that cannot be judged.
    """

    numbers: dict[str, Floats]
    said: list[Said | None]


def judge(run: Heights) -> Judgement:
    """Gain and verdict of a run.

    The input u is the initial height difference between device and magnet, the output y the range of heights that the
    device covers, and the gain is y / u (eq. 6; the paper's y has the other sign). Mean and standard deviation of the
    attack angle (wobble) are over the second half of the run, when the start has died out.

    Returns
    -------
    Judgement
        Gain, verdict and reason.

    Raises
    ------
    InputError
        Where the run has no samples, holds values that are not finite, or starts level with the magnet.

    Examples
    --------
    A head that sinks by 3 mm within the first minute, 150 mm below the magnet, and stays there; without a word on how
    slow such a run can be, ten minutes of it decide nothing:

    >>> time = np.linspace(0.0, 600.0, 101)
    >>> height = -0.003 * np.minimum(time / 60.0, 1.0)
    >>> level = np.zeros_like(time)
    >>> run = Heights(
    ...     time=time, low=height, high=height, mean=height, attack=level, attack_square=level,
    ...     slips=0, initial_gap=0.15, end=End.HORIZON,
    ... )
    >>> judgement = judge(run)
    >>> round(judgement.gain, 6), str(judgement.verdict)
    (0.02, 'undecided')
    """
    together = judge_each([run])
    said, number = together.said[0], {name: float(values[0]) for name, values in together.numbers.items()}
    if said is None:
        raise InputError(_fault(run))
    cause, told = said
    return Judgement(
        gain=number["gain"],
        output=number["output"],
        input=run.initial_gap,
        cause=cause,
        reason=cause.text(**told),
        end_time=number["end_time"],
        escape_time=None if math.isnan(number["escape_time"]) else number["escape_time"],
        slips=run.slips,
        wobble=number["wobble"],
        attack_angle=number["attack_angle"],
        touches=run.touches,
    )


def judge_each(runs: Sequence[Heights]) -> Judgements:
    """Judge several runs, each as :func:`judge` does; numbers of those that have as many samples are found together.

    Returns
    -------
    Judgements
        In the order of the runs. One that :func:`judge` would refuse is there as one that cannot be judged.
    """
    numbers = {name: np.full(len(runs), np.nan) for name in (*TOGETHER, *ONE_BY_ONE)}
    said: list[Said | None] = [None] * len(runs)
    alike: dict[int, list[int]] = {}
    for place, run in enumerate(runs):
        alike.setdefault(run.time.size, []).append(place)
    for places in alike.values():
        samples = [np.array([getattr(runs[place], name) for place in places]) for name in SAMPLED]
        gaps = np.array([runs[place].initial_gap for place in places])
        sound = (gaps > 0.0) & np.all([_sound(values) for values in samples], axis=0)
        if not sound.any():
            continue
        where = np.array(places)[sound]
        for name, values in zip(TOGETHER, _numbers([each[sound] for each in samples], gaps[sound]), strict=True):
            numbers[name][where] = values
        judged = [runs[place] for place in where]
        causes = [_cause(run) for run in judged]
        for place, (cause, told, _) in zip(where, causes, strict=True):
            said[place] = cause, told
        further = [(c[-1], run.slips, *summed(run.touches)) for c, run in zip(causes, judged, strict=True)]
        for name, column in zip(ONE_BY_ONE, zip(*further, strict=True), strict=True):
            numbers[name][where] = column  # NaN for None
    return Judgements(numbers, said)


def _sound(samples: Floats) -> NDArray[np.bool_]:
    """Whether runs (n, samples) have samples, all finite: (n,)."""
    return np.asarray(np.isfinite(samples).all(axis=-1) & (samples.shape[-1] > 0))


def _fault(run: Heights) -> str:
    """Why a run cannot be judged."""
    for name in SAMPLED:
        if not _sound(getattr(run, name)):
            return f"a run must have samples of {name} that are all finite"
    return "the gain needs a device that starts at another height than the magnet"


def _numbers(samples: Sequence[Floats], gaps: Floats) -> tuple[Floats, ...]:
    """What :data:`TOGETHER` names, (n,) each, of what :data:`SAMPLED` does, (n, samples) each, and inputs (n,)."""
    time, low, high, mean, attack, square = samples
    output = high.max(axis=1) - low.min(axis=1)
    attack_angle, mean_square = _late_means(time, attack, square)
    variance = mean_square - np.array([angle**2 for angle in attack_angle.tolist()])
    wobble = np.sqrt(np.maximum(variance, 0.0))
    return output / gaps, output, gaps, time[:, -1], wobble, attack_angle, mean[:, -1] - mean[:, 0]


def gain_until(run: Heights, time: float) -> float:
    """Gain of the part of a run up to ``time`` (s): eqs (5)-(6) over its samples up to then.

    Parameters
    ----------
    run
        The run; where it ended before ``time``, all of it counts.
    time
        Seconds, not before the first sample.

    Returns
    -------
    float
        Output over input.

    Raises
    ------
    InputError
        Where the run has no sample up to then.
    """
    part = run.time <= time
    if not part.any():
        raise InputError(f"time must not be before the first sample at {run.time[0]:g} s; got {time:g} s")
    return float(run.high[part].max() - run.low[part].min()) / run.initial_gap


def _late_means(time: Floats, attack: Floats, square: Floats) -> tuple[Floats, Floats]:
    """Means (n,) over the second half of each run of attack angle (rad) and its square: a sample is of what it ends."""
    means = np.empty((2, len(time)))
    first = (time < (time[:, 0] + (time[:, -1] - time[:, 0]) / 2.0)[:, None]).sum(axis=1)
    for begin in np.unique(first):
        where = first == begin
        weights = spans_between(time[where])[:, begin:]
        total = weights.sum(axis=1)
        weights[~(total > 0.0)], total[~(total > 0.0)] = 1.0, weights.shape[1]
        means[:, where] = [(each[where, begin:] * weights).sum(axis=1) / total for each in (attack, square)]
    return means[0], means[1]


def _cause(run: Heights) -> tuple[Reason, dict[str, object], float | None]:
    """Why the run has its verdict, numbers for the sentence that says so, and when the device was lost, if it was."""
    cause, end_time = run.end.cause, float(run.time[-1])
    if cause is not None and cause is not Reason.FELL_BEHIND:
        return cause, {"time": end_time}, end_time
    if run.end is not End.FALL and run.touches:
        held = holding(run.touches, run.time)
        if held is not None:
            return held.wall.cause, held.numbers, held.first
    since = _fallen_since(run)
    if since is None:
        return *evidence(run), None
    drop = float(run.mean[0] - run.mean[-1])
    return Reason.FELL_BEHIND, {"since": since, "drop": 1e3 * drop, "share": drop / run.initial_gap}, since


def _fallen_since(run: Heights) -> float | None:
    """When the head passed the fallen line for good, if it ends below it and still sinks; None otherwise."""
    line = run.mean[0] - FALLEN * run.initial_gap
    if run.end is not End.FALL:
        if not run.high[-1] < line:
            return None
        before, last = run.part_means()[-2:]
        if not last < before - STILL * run.initial_gap:
            return None
    above = np.flatnonzero(run.high >= line)
    return float(run.time[min(above[-1] + 1, run.time.size - 1)])
