"""What a trajectory holds, in the units of axes: mm, s, degrees. What is not there is None."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.outcomes import End
from helimag.runs.gain import Judgement
from helimag.runs.trajectory import Trajectory
from helimag.scenario import Scenario, parse

Floats = NDArray[np.float64]

NEAR = 0.05  # of the run's duration


@dataclass(frozen=True, kw_only=True)
class Shown:
    """A run in the units of axes; (n,) unless said otherwise, None where the run does not have it."""

    name: str
    time: Floats  # s
    position: Floats  # (n, 3) mm
    low: Floats  # mm
    high: Floats  # mm
    magnet: Floats | None  # (n, 3) mm
    gap: Floats | None  # mm
    attack: Floats | None  # deg
    attack_spread: Floats | None  # deg
    lag: Floats | None  # deg
    slips: Floats | None
    walls: Floats | None
    scenario: Scenario | None
    quaternion: Floats | None  # (n, 4)
    end: End | None
    leading_end: str
    leading_cosine: float
    judgement: Judgement | None
    verdict: str


def shown(trajectory: Trajectory) -> Shown:
    """Take from a trajectory what can be drawn.

    Raises
    ------
    InputError
        Where it has fewer than two samples with a finite position.
    """
    data = trajectory.dataset

    def values(name: str, scale: float = 1.0) -> Floats | None:
        return scale * np.asarray(data[name].values, dtype=np.float64) if name in data else None

    position = values("position", 1e3)
    if position is None or np.isfinite(position).all(axis=1).sum() < 2:
        raise InputError("a run must have at least two samples with a finite position to be drawn")
    height = position[:, 2]
    low, high = values("height_low", 1e3), values("height_high", 1e3)
    attack, attack_spread = _attack(values("attack_mean"), values("attack_mean_square"), values("attack_angle"))
    judgement, verdict = _judged(trajectory)
    return Shown(
        name=str(data.attrs.get("name", "run")),
        time=np.asarray(data["time"].values, dtype=np.float64),
        position=position,
        low=height if low is None else low,
        high=height if high is None else high,
        magnet=values("rpm_position", 1e3),
        gap=values("gap", 1e3),
        attack=attack,
        attack_spread=attack_spread,
        quaternion=values("quaternion"),
        end=None if "end" not in data.attrs else End.of(data.attrs["end"]),
        leading_end=trajectory.leading_end,
        leading_cosine=trajectory.leading_cosine,
        lag=values("phase_lag", 180.0 / np.pi),
        slips=values("slips"),
        walls=values("walls"),
        scenario=None if trajectory.scenario_toml is None else parse(trajectory.scenario_toml, "the run's scenario"),
        judgement=judgement,
        verdict=verdict,
    )


def _attack(mean: Floats | None, square: Floats | None, sampled: Floats | None) -> tuple[Floats | None, Floats | None]:
    """Attack angle, its mean between samples where known, and its standard deviation in between (deg)."""
    if mean is None or square is None:
        return (None if sampled is None else np.degrees(sampled)), None
    return np.degrees(mean), np.degrees(np.sqrt(np.maximum(square - mean**2, 0.0)))


def _judged(trajectory: Trajectory) -> tuple[Judgement | None, str]:
    """The judgement and its sentence; for a run that cannot be judged, why not."""
    try:
        judgement = trajectory.judgement
    except InputError as error:
        return None, f"no verdict: {error}"
    return judgement, f"{judgement.verdict}: {judgement.reason}"


def touching_spans(run: Shown) -> list[tuple[float, float]]:
    """Stretches of time (from, to; s) in which a wall pushes the device, between samples or all the while."""
    return [] if run.walls is None else _spans(run.time, np.flatnonzero(run.walls[1:] > 0.0) + 1)


def slipping_spans(run: Shown) -> list[tuple[float, float]]:
    """Stretches of time (from, to; s) in which the device slips against the field.

    Slips that follow each other within a twentieth of the run are one stretch: in between the device is not in step.
    """
    if run.slips is None:
        return []
    return _spans(run.time, np.flatnonzero(np.diff(run.slips) > 0.0) + 1, NEAR * float(run.time[-1] - run.time[0]))


def _spans(time: Floats, samples: NDArray[np.int64], near: float = 0.0) -> list[tuple[float, float]]:
    """Stretches of time (from, to; s) that end at these samples; those that are ``near`` (s) each other are one."""
    spans: list[tuple[float, float]] = []
    for last in samples:
        start, end = float(time[last - 1]), float(time[last])
        if spans and start - spans[-1][1] <= near:
            start = spans.pop()[0]
        spans.append((start, end))
    return spans


def lag_in_step(run: Shown) -> Floats:
    """Phase lag (deg), not a number where the device slips or none is recorded: there it has no meaning."""
    lag = np.full(run.time.size, np.nan) if run.lag is None else run.lag.copy()
    for start, end in slipping_spans(run):
        lag[(run.time > start) & (run.time <= end)] = np.nan
    return lag
