"""Input-output gain (paper, eqs 5-6) and the verdict on a run, simulated or measured alike."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.outcomes import End, Reason, Verdict
from helimag.runs.evidence import STILL, evidence
from helimag.runs.heights import Heights
from helimag.runs.touches import Touch, holding

Floats = NDArray[np.float64]

FALLEN = 0.5  # of the input: a head this far below its start and still sinking has lost the magnet


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
        return sum(touch.count for touch in self.touches)

    @property
    def contact_time(self) -> float:
        """How long walls held the device, each wall's time added (s)."""
        return math.fsum(touch.total for touch in self.touches)

    @property
    def first_contact(self) -> float | None:
        """When the device first came to such a wall (s); None where it never did."""
        return min((touch.first for touch in self.touches), default=None)


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
    _check_finite(run)
    if not run.initial_gap > 0.0:
        raise InputError("the gain needs a device that starts at another height than the magnet")
    output = float(run.high.max() - run.low.min())
    cause, reason, escape_time = _cause(run)
    attack_angle, square = _late_means(run)
    variance = square - attack_angle**2
    return Judgement(
        gain=output / run.initial_gap,
        output=output,
        input=run.initial_gap,
        cause=cause,
        reason=reason,
        end_time=float(run.time[-1]),
        escape_time=escape_time,
        slips=run.slips,
        wobble=float(np.sqrt(max(variance, 0.0))),
        attack_angle=attack_angle,
        touches=run.touches,
    )


def _check_finite(run: Heights) -> None:
    """Raise InputError where a run has no samples, or one that is not finite: all looked at at once, then by name."""
    samples = {name: getattr(run, name) for name in ("time", "low", "high", "mean", "attack", "attack_square")}
    if all(values.size for values in samples.values()) and np.isfinite(np.concatenate(list(samples.values()))).all():
        return
    for name, values in samples.items():
        if values.size == 0 or not np.isfinite(values).all():
            raise InputError(f"a run must have samples of {name} that are all finite")


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


def _late_means(run: Heights) -> tuple[float, float]:
    """Means over the second half of the run of attack angle (rad) and its square: a sample is of what it ends."""
    first = int(np.searchsorted(run.time, run.time[0] + (run.time[-1] - run.time[0]) / 2.0))
    late = slice(first, None)
    weights = run.spans[late]
    total = weights.sum()
    if not total > 0.0:
        weights, total = np.ones_like(weights), float(weights.size)
    return float((run.attack[late] * weights).sum() / total), float((run.attack_square[late] * weights).sum() / total)


def _cause(run: Heights) -> tuple[Reason, str, float | None]:
    """Why the run has its verdict, the same in words, and when the device was lost (s), if that is judged so."""
    cause, end_time = run.end.cause, float(run.time[-1])
    if cause is not None and cause is not Reason.FELL_BEHIND:
        return cause, cause.text(time=end_time), end_time
    if run.end is not End.FALL:
        held = holding(run.touches, run.time)
        if held is not None:
            return held.wall.cause, held.text(), held.first
    since = _fallen_since(run)
    if since is None:
        return *evidence(run), None
    drop = float(run.mean[0] - run.mean[-1])
    cause = Reason.FELL_BEHIND
    return cause, cause.text(since=since, drop=1e3 * drop, share=drop / run.initial_gap), since


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
