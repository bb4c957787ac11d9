"""What a measured run says, with uncertainty: |y|, gain, and the attack angle in windows of time."""

import json
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.runs.smoothing import smooth
from helimag.runs.trajectory import Trajectory

Floats = NDArray[np.float64]

DRAWS = 400
TWICE_NOISY = (
    1.0 + 2.0**0.5
)  # a range grows with the noise's spread; noise drawn on top of noise makes that sqrt(2) times larger
NORMAL_95 = 1.959963984540054


SIMULATIONS = ("simulated", "rendered", "staged")  # sources of runs that nobody measured


class Measured(NamedTuple):
    """A value with its standard deviation and 95 % interval (SI); nan where a run does not say how exact it is."""

    value: float
    sd: float
    low: float
    high: float

    @property
    def interval(self) -> list[float] | None:
        """Both ends of the interval; None where it is not known."""
        return None if math.isnan(self.sd) else [self.low, self.high]


def interval_text(interval: list[float] | None, digits: int, *, per: float = 1.0, unit: str = "") -> str:
    """A 95 % interval in words, its ends in a ``unit`` of which an SI unit is ``per``."""
    if interval is None:
        return "95 % interval not known: the track has no standard deviations"
    low, high = (f"{per * end:.{digits}f}" for end in interval)
    return f"95 % {low} to {high}{unit}"


@dataclass(frozen=True)
class Windows:
    """Attack angle over stretches of time: arrays (k,), s and rad.

    ``wobble`` is the standard deviation of the angle in the window less what measurement noise adds to it, and
    ``mean_sd`` the standard deviation of the mean from that noise.
    """

    start: Floats
    end: Floats
    mean: Floats
    mean_sd: Floats
    wobble: Floats
    samples: Floats


def output(run: Trajectory, *, seed: int = 0) -> Measured:
    """Range of heights |y| of a run with its uncertainty; exact for a simulated run, not known for a track without.

    The value is that of :func:`helimag.runs.gain.judge`. Noise makes a range larger: the interval reaches lower by as
    much as the measured covariance lengthens the range of runs drawn about the measured heights. Frames miss what
    happens between and beside them: it reaches higher by what :func:`unseen` allows. The calibration's accuracy at two
    places and its error of scale, which no averaging removes, are added.

    Parameters
    ----------
    run
        Measured, with ``position_covariance``.
    """
    value = run.judgement.output
    if "position_covariance" not in run.dataset:
        simulated = run.dataset.attrs.get("source") in SIMULATIONS
        return Measured(value, 0.0, value, value) if simulated else Measured(value, *[math.nan] * 3)
    time = np.asarray(run.dataset["time"].values, dtype=np.float64)
    height = np.asarray(run.dataset["position"].values[:, 2], dtype=np.float64)
    if "position_noise" in run.dataset:  # without the calibration's error, which moves all samples together
        noise = np.asarray(run.dataset["position_noise"].values[:, 2], dtype=np.float64)
    else:
        noise = np.sqrt(np.asarray(run.dataset["position_covariance"].values[:, 2, 2], dtype=np.float64))
    attributes = run.dataset.attrs
    interval = float(attributes.get("frame_interval", np.median(np.diff(time)) if time.size > 1 else 1.0))
    random = np.random.default_rng(seed)
    ranges = []
    for _ in range(DRAWS // 50):
        fresh = random.standard_normal((time.size, 50))
        if attributes.get("smoothed"):
            fresh, weights = smooth(time, fresh, interval)
            fresh = fresh / np.sqrt(np.sum(weights * weights, axis=1))[:, None]
        drawn = height[:, None] + noise[:, None] * fresh
        ranges.append(np.ptp(drawn, axis=0))
    drawn_ranges = np.concatenate(ranges)
    excess = TWICE_NOISY * max(float(drawn_ranges.mean()) - value, 0.0)
    accuracy = float(attributes.get("position_accuracy", 0.0))
    scale = float(attributes.get("scale_sd", 0.0)) * value
    sd = float(np.sqrt(drawn_ranges.var() + 2.0 * accuracy**2 + scale**2))
    film = (float(attributes.get("film_begin", time[0])), float(attributes.get("film_end", time[-1])))
    high = value + unseen(time, height, interval, film) + NORMAL_95 * sd
    return Measured(value, sd, max(value - excess - NORMAL_95 * sd, 0.0), high)


def unseen(time: Floats, height: Floats, interval: float, film: tuple[float, float] | None = None) -> float:
    """How much longer the range of heights would be had the device gone straight on where no frame shows it (m).

    From each sample it is taken to go on with the speed between its neighbours: halfway into the time without a sample
    that follows or precedes, and beyond the first and the last to the film's ends, one frame ``interval`` (s) at least.
    """
    if time.size < 3:
        return 0.0
    speed = np.gradient(height, time)
    begin, end = (time[0], time[-1]) if film is None else film
    after = np.append(np.diff(time) / 2.0, max(interval, end - time[-1]))
    before = np.insert(np.diff(time) / 2.0, 0, max(interval, time[0] - begin))
    reached = np.concatenate([height, height + speed * after, height - speed * before])
    return float(np.ptp(reached) - np.ptp(height))


def gain(run: Trajectory, *, seed: int = 0) -> Measured:
    """Gain of a run with the uncertainty of |y|; the input is taken as exact."""
    size = run.judgement.input
    return Measured(*(part / size for part in output(run, seed=seed)))


def attack_windows(run: Trajectory, *, count: int = 8) -> Windows:
    """Mean attack angle and wobble in equally long windows of a run, as in Fig. 5 of the paper.

    Raises
    ------
    InputError
        Where the run has no attack angle, or ``count`` is not positive.
    """
    if "attack_angle" not in run.dataset:
        raise InputError(
            "a run must have attack angles to be cut into windows; an imported track without axes has none"
        )
    if count < 1:
        raise InputError(f"count must be at least 1; got {count}")
    time = np.asarray(run.dataset["time"].values, dtype=np.float64)
    angle = np.asarray(run.dataset["attack_angle"].values, dtype=np.float64)
    noise = np.zeros_like(angle)
    if "attack_angle_sd" in run.dataset:
        noise = np.asarray(run.dataset["attack_angle_sd"].values, dtype=np.float64)
    edges = np.linspace(time[0], time[-1], count + 1)
    which = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, count - 1)
    rows = []
    for window in range(count):
        inside = which == window
        if not inside.any():
            rows.append([np.nan, np.nan, np.nan, 0.0])
            continue
        size = int(inside.sum())
        variance = float(angle[inside].var() - np.mean(noise[inside] ** 2))
        mean_sd = float(np.sqrt(np.mean(noise[inside] ** 2) / size))
        rows.append([float(angle[inside].mean()), mean_sd, np.sqrt(max(variance, 0.0)), float(size)])
    mean, mean_sd, wobble, samples = np.array(rows).T
    return Windows(edges[:-1], edges[1:], mean, mean_sd, wobble, samples)


def report(run: Trajectory) -> dict[str, Any]:
    """Everything above as plain numbers, for --json: SI but for angles in degrees, gaps with their reasons."""
    judgement = run.judgement
    size, ratio = output(run), gain(run)
    attributes = run.dataset.attrs
    result: dict[str, Any] = {
        "gain": ratio.value,
        "gain_sd": None if ratio.interval is None else ratio.sd,
        "gain_95": ratio.interval,
        "output_y_m": size.value,
        "output_y_sd_m": None if size.interval is None else size.sd,
        "output_y_95_m": size.interval,
        "input_u_m": judgement.input,
        "verdict": str(judgement.verdict),
        "reason": judgement.reason,
        "end_time_s": judgement.end_time,
        "samples": int(run.dataset.sizes["time"]),
        "gaps": json.loads(attributes.get("gaps", "[]")),
        "warnings": json.loads(attributes.get("warnings", "[]")),
    }
    for name in ("frames_first", "clock_offset", "clock_offset_sd", "position_accuracy"):
        if name in attributes:
            result[name] = float(attributes[name])
    if "attack_angle" in run.dataset:
        windows = attack_windows(run)
        result["attack_angle_deg"] = float(np.degrees(judgement.attack_angle))
        result["wobble_deg"] = float(np.degrees(judgement.wobble))
        result["windows"] = [
            {
                "from_s": float(start),
                "until_s": float(end),
                "attack_angle_deg": float(np.degrees(mean)) if samples else None,
                "wobble_deg": float(np.degrees(wobble)) if samples else None,
            }
            for start, end, mean, wobble, samples in zip(
                windows.start, windows.end, windows.mean, windows.wobble, windows.samples, strict=True
            )
        ]
    return result
