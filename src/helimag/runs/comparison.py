"""A measured run beside a simulated one: brought together in time and place, and judged by the same code."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.geometry import turn
from helimag.outcomes import End, Verdict
from helimag.runs.gain import Judgement, judge
from helimag.runs.measurement import NORMAL_95, SIMULATIONS, Measured, gain, output
from helimag.runs.trajectory import Trajectory

Floats = NDArray[np.float64]
Alignment = Literal["fit", "start", "none"]

LATEST = 5.0  # shift in time that the fit tries (s)
TRIES = 201
# share by which a shift in time must lessen the rms difference to be used: along a steady path it is undetermined
WORTH = 0.02
BEGINNING = 0.5  # over which the start is averaged (s)
# a comparison of less than this share of the shorter run, of fewer samples, or after a shift of the clocks by more of
# the common time than this says so
WHOLE, SAMPLES, SHIFTED = 0.75, 10, 0.1


@dataclass(frozen=True)
class Comparison:
    """Measured less simulated at the measured samples (SI, rad).

    ``difference`` (n, 3) has the standard deviations ``difference_sd`` (n, 3) of the measurement, zero where unknown;
    ``simulated_time`` and ``simulated_path`` are the simulated run at its own samples, brought to the measured one.
    ``attack_difference`` (n,) is None where either run has no attack angle. The simulated run was moved by
    ``time_shift``, then turned by ``yaw`` about z, then moved by ``translation``. Its gain does not change by that.

    Gains, outputs and verdicts are those of ``measured_part`` and ``simulated_part``: the time that the two share.
    ``bracketed`` is whether shifts to either side of the one that was taken were tried and found worse.
    """

    measured: Trajectory
    simulated: Trajectory
    measured_part: Trajectory
    simulated_part: Trajectory
    time: Floats
    measured_position: Floats
    simulated_position: Floats
    difference_sd: Floats
    simulated_time: Floats
    simulated_path: Floats
    measured_attack: Floats | None
    simulated_attack: Floats | None
    attack_sd: Floats
    time_shift: float
    bracketed: bool
    yaw: float
    translation: Floats
    measured_output: Measured
    simulated_output: float
    measured_gain: Measured
    simulated_gain: float

    @property
    def difference(self) -> Floats:
        """Measured less simulated position (n, 3) in m."""
        return self.measured_position - self.simulated_position

    @property
    def attack_difference(self) -> Floats | None:
        """Measured less simulated attack angle (n,) in rad."""
        if self.measured_attack is None or self.simulated_attack is None:
            return None
        return self.measured_attack - self.simulated_attack

    @cached_property
    def measured_judgement(self) -> Judgement:
        """Gain and verdict of the measured run, by the slow times of the scenario that was simulated."""
        return judge(replace(self.measured_part.heights, slow=self.simulated.heights.slow))

    @property
    def measured_source(self) -> str:
        """Where the run that is taken as measured comes from; "unknown" where its file does not say."""
        return str(self.measured.dataset.attrs.get("source", "unknown"))

    @property
    def really_measured(self) -> bool:
        """Whether that is not one of helimag's own simulations."""
        return self.measured_source not in SIMULATIONS

    @property
    def left_out(self) -> tuple[float, float]:
        """How long (s) either run lasts beyond the time that the two share."""
        pairs = ((self.measured, self.measured_part), (self.simulated, self.simulated_part))
        whole, part = ([float(np.ptp(_values(run, "time"))) for run in runs] for runs in zip(*pairs, strict=True))
        return whole[0] - part[0], whole[1] - part[1]

    @property
    def agrees(self) -> bool | None:
        """Whether both have the same verdict and the simulated gain lies in the measured gain's 95 % interval.

        None where nothing speaks against it, but that interval is not known or a verdict undecided.
        """
        if self.measured_gain.interval is None:
            return None
        verdicts = {self.measured_judgement.verdict, self.simulated_part.verdict}
        slack = 1e-9 * self.simulated_gain  # of rounding
        inside = self.measured_gain.low - slack <= self.simulated_gain <= self.measured_gain.high + slack
        if not inside or len(verdicts - {Verdict.UNDECIDED}) > 1:
            return False
        return None if Verdict.UNDECIDED in verdicts else True

    @property
    def doubts(self) -> dict[str, str]:
        """What makes the comparison say less than it seems to: in two words, and at length."""
        common = float(np.ptp(self.time))
        shorter = common + min(self.left_out)
        starts = float(_values(self.measured, "time")[0] - _values(self.simulated, "time")[0])
        moved = min(abs(self.time_shift), abs(self.time_shift - starts))  # from a common clock, from a common start
        doubts = {}
        if self.time.size < SAMPLES:
            doubts["few samples"] = f"only {self.time.size} samples are set beside each other"
        if common < WHOLE * shorter:
            share = 100.0 * common / shorter
            doubts["little in common"] = (
                f"only {common:.2f} s are set beside each other, {share:.0f} % of the shorter run"
            )
        if moved > SHIFTED * common:
            doubts["clocks shifted"] = (
                f"the clocks are shifted by {moved:.2f} s, {100.0 * moved / common:.0f} % of the time that is "
                "compared; where both are known, leave them (align none)"
            )
        if not self.bracketed:
            doubts["shift at its limit"] = (
                "the shift of the clocks is the last that was tried: the runs may be further apart, or not belong "
                "together"
            )
        return doubts

    @property
    def numbers(self) -> dict[str, Any]:
        """Everything as plain numbers: SI, angles in degrees."""
        distance = np.linalg.norm(self.difference, axis=1)
        known = self.difference_sd > 0.0
        within = np.abs(self.difference) <= NORMAL_95 * self.difference_sd
        attack = self.attack_difference
        return {
            "samples": int(self.time.size),
            "from_s": float(self.time[0]),
            "until_s": float(self.time[-1]),
            "time_shift_s": self.time_shift,
            "yaw_deg": float(np.degrees(self.yaw)),
            "translation_m": self.translation.tolist(),
            "difference_rms_m": float(np.sqrt(np.mean(distance**2))),
            "difference_worst_m": float(distance.max()),
            "difference_mean_m": self.difference.mean(axis=0).tolist(),
            "difference_sd_m": self.difference_sd.mean(axis=0).tolist(),
            "share_within_95": float(within[known].mean()) if known.any() else None,
            "attack_difference_rms_deg": None if attack is None else float(np.degrees(np.sqrt(np.mean(attack**2)))),
            "attack_difference_mean_deg": None if attack is None else float(np.degrees(np.mean(attack))),
            "left_out_s": dict(zip(("measured", "simulated"), self.left_out, strict=True)),
            "measured": {
                "source": self.measured_source,
                "really_measured": self.really_measured,
                "gain": self.measured_gain.value,
                "gain_95": self.measured_gain.interval,
                "output_y_m": self.measured_output.value,
                "output_y_95_m": self.measured_output.interval,
                "verdict": str(self.measured_judgement.verdict),
                "reason": self.measured_judgement.reason,
            },
            "simulated": {
                "gain": self.simulated_gain,
                "output_y_m": self.simulated_output,
                "verdict": str(self.simulated_part.verdict),
                "reason": self.simulated_part.judgement.reason,
            },
            "agrees": self.agrees,
            "doubts": list(self.doubts.values()),
        }


def compare(measured: Trajectory, simulated: Trajectory, *, align: Alignment = "fit") -> Comparison:
    """Compare two runs; either may be measured or simulated, and uncertainty is taken from the first.

    Parameters
    ----------
    measured, simulated
        The simulated run is interpolated at the measured samples; gaps stay gaps.
    align
        "none": same clock and frame. "start": the first half seconds coincide in place, the first samples in time.
        "fit": turned about the vertical, moved and shifted in time (up to 5 s) for the least rms difference; the
        vertical itself is never tilted.

    Gains and verdicts are those of the time that both cover; the input of the gain is that of each run's own start.

    Returns
    -------
    Comparison
        Differences over the common time (SI), and gain and verdict of both.

    Raises
    ------
    InputError
        Where the runs share less than two samples of either.
    """
    if align not in ("fit", "start", "none"):
        raise InputError(f"align must be fit, start or none; got {align!r}")
    shift, bracketed, yaw, move = _alignment(measured, simulated, align)
    time = _values(measured, "time")
    inside = _inside(time, simulated, shift)
    if inside.sum() < 2:
        raise InputError(
            f"the runs must overlap in time: the measured one lasts from {time[0]:.2f} s to {time[-1]:.2f} s, "
            f"and shares "
            f"{int(inside.sum())} samples with the simulated one"
        )
    time = time[inside]
    turned = turn(2, yaw)
    covariance = measured.dataset.get("position_covariance")
    spread = np.zeros((time.size, 3))
    if covariance is not None:
        noise = np.einsum("nii->ni", np.asarray(covariance.values, dtype=np.float64))[inside]
        spread = np.sqrt(noise + float(measured.dataset.attrs.get("position_accuracy", 0.0)) ** 2)
    attack_sd = np.zeros(time.size)
    if "attack_angle_sd" in measured.dataset:
        attack_sd = _values(measured, "attack_angle_sd")[inside]
    measured_part = _within(measured, time[0], time[-1])
    simulated_part = _within(simulated, time[0] - shift, time[-1] - shift)
    own_gain, own_output = gain(measured_part), output(measured_part)
    return Comparison(
        measured=measured,
        simulated=simulated,
        measured_part=measured_part,
        simulated_part=simulated_part,
        time=time,
        measured_position=_values(measured, "position")[inside],
        simulated_position=_at(simulated, "position", time - shift) @ turned.T + move,
        difference_sd=spread,
        simulated_time=_values(simulated, "time") + shift,
        simulated_path=_values(simulated, "position") @ turned.T + move,
        measured_attack=_values(measured, "attack_angle")[inside] if "attack_angle" in measured.dataset else None,
        simulated_attack=_at(simulated, "attack_angle", time - shift) if "attack_angle" in simulated.dataset else None,
        attack_sd=attack_sd,
        time_shift=shift,
        bracketed=bracketed,
        yaw=yaw,
        translation=move,
        measured_output=own_output,
        simulated_output=simulated_part.judgement.output,
        measured_gain=own_gain,
        simulated_gain=simulated_part.gain,
    )


def _within(run: Trajectory, first: float, last: float) -> Trajectory:
    """The part of a run between two times (s) on its own clock; the run itself where that is all of it."""
    time = _values(run, "time")
    slack = 1e-9 * max(1.0, abs(float(time[-1])))
    kept = np.flatnonzero((time >= first - slack) & (time <= last + slack))
    if kept.size == time.size:
        return run
    if kept.size < 2:
        raise InputError(f"the runs must share two samples of each; one has {kept.size} from {first:g} s to {last:g} s")
    part = run.dataset.isel(time=kept).copy()
    if kept[-1] < time.size - 1:
        part.attrs["end"] = str(End.HORIZON)
    height = _values(run, "position")[kept[0], 2]
    for name in ("height_low", "height_high", "height_mean"):  # of the time before the first sample that is kept
        if name in part:
            part[name] = part[name].copy(data=np.concatenate([[height], _values(run, name)[kept[1:]]]))
    if "slips" in part:
        part["slips"] = part["slips"] - part["slips"].values[0]
    return Trajectory(part)


def _values(run: Trajectory, name: str) -> Floats:
    return np.asarray(run.dataset[name].values, dtype=np.float64)


def _at(run: Trajectory, name: str, times: Floats) -> Floats:
    """A run's variable at other instants, linearly between its samples."""
    values, known = _values(run, name), _values(run, "time")
    columns = values.reshape(known.size, -1)
    return np.stack([np.interp(times, known, column) for column in columns.T], axis=1).reshape(
        times.size, *values.shape[1:]
    )


def _inside(time: Floats, simulated: Trajectory, shift: float) -> NDArray[np.bool_]:
    known = _values(simulated, "time")
    slack = 1e-9 * max(1.0, abs(float(known[-1])))
    return np.asarray((time - shift >= known[0] - slack) & (time - shift <= known[-1] + slack))


def _alignment(measured: Trajectory, simulated: Trajectory, align: Alignment) -> tuple[float, bool, float, Floats]:
    """Shift in time (s), whether it is bracketed, turn about z (rad) and move (m), for the simulated run."""
    if align == "none":
        return 0.0, True, 0.0, np.zeros(3)
    time = _values(measured, "time")
    together = float(time[0] - _values(simulated, "time")[0])
    if align == "start":
        first = time <= time[0] + BEGINNING
        move = (_values(measured, "position")[first] - _at(simulated, "position", time[first] - together)).mean(axis=0)
        return together, True, 0.0, np.asarray(move)
    shifts = together + np.linspace(-LATEST, LATEST, TRIES)
    least = 0.5 * _inside(time, simulated, together).sum()
    fits = [_moved(measured, simulated, shift, least) for shift in shifts]
    plain = _moved(measured, simulated, together, 2)
    best = min(range(TRIES), key=lambda i: fits[i][0])
    if not np.isfinite(fits[best][0]) or fits[best][0] > (1.0 - WORTH) * plain[0]:
        return together, True, plain[1], plain[2]
    beside = [fits[i][0] if 0 <= i < TRIES else np.inf for i in (best - 1, best + 1)]
    return float(shifts[best]), bool(np.isfinite(beside).all()), fits[best][1], fits[best][2]


def _moved(measured: Trajectory, simulated: Trajectory, shift: float, least: float) -> tuple[float, float, Floats]:
    """Rms difference, turn about z and move that fit best at a shift in time (Kabsch's method in the plane)."""
    time = _values(measured, "time")
    inside = _inside(time, simulated, shift)
    if inside.sum() < max(2.0, least):
        return np.inf, 0.0, np.zeros(3)
    target = _values(measured, "position")[inside]
    source = _at(simulated, "position", time[inside] - shift)
    one, two = source - source.mean(axis=0), target - target.mean(axis=0)
    angle = float(np.arctan2(np.sum(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]), np.sum(one[:, :2] * two[:, :2])))
    turned = turn(2, angle)
    move = target.mean(axis=0) - turned @ source.mean(axis=0)
    rest = target - source @ turned.T - move
    return float(np.sqrt(np.mean(np.sum(rest**2, axis=1)))), angle, move
