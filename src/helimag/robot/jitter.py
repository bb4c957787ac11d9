"""What errors of arm and motor do to a run: speed ripple, path offset, shaking, frequency error."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.files import text_of, toml_tables
from helimag.robot.arm.path import magnet_path
from helimag.robot.logs import Log, check_motor
from helimag.scenario import Frequency, Length, Part, Scenario, model_of

if TYPE_CHECKING:
    from helimag.ensembles import Ensemble

Floats = NDArray[np.float64]
Point = tuple[Length, Length, Length]

SAMPLES_A_PERIOD = 10  # of the fastest line of the spectrum
COARSEST = 1.0  # s, between samples of a path without fast lines
MOST = 400_000  # samples of a path
LINES = 8  # of a measured spectrum


class SpeedRipple(Part):
    """A share of the arm's speed that comes and goes."""

    frequency: Frequency
    share: float


class Shake(Part):
    """A swing of the magnet's centre, amplitude along lab x, y and z."""

    frequency: Frequency
    amplitude: Point


class Jitter(Part):
    """How an arm and a motor err: lines of a spectrum, measured or assumed, and constant errors."""

    source: str = "assumed"
    speed: tuple[SpeedRipple, ...] = ()
    shake: tuple[Shake, ...] = ()
    offset: Point = (0.0, 0.0, 0.0)
    frequency_error: float = 0.0  # share of the motor's frequency

    @property
    def parts(self) -> "dict[str, Jitter]":
        """Each kind of error alone, and all together."""
        kinds = ("speed", "shake", "offset", "frequency_error")
        blank = Jitter(source=self.source)
        alone = {kind: blank.model_copy(update={kind: getattr(self, kind)}) for kind in kinds}
        return {kind: one for kind, one in alone.items() if one != blank} | {"all": self}


def load_jitter(path: str | Path) -> Jitter:
    """Read a jitter model from a TOML file.

    Returns
    -------
    Jitter
        SI.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where it is no jitter model.
    """
    return model_of(Jitter, toml_tables(text_of(path), str(path)), str(path))


def jittered(scenario: Scenario, jitter: Jitter, random: np.random.Generator) -> Scenario:
    """The scenario with its path sampled and the errors added, the phases of all lines drawn at random.

    Speed ripple moves the magnet early and late along its own path; the motor does not know, and turns on evenly.

    Raises
    ------
    InputError
        Where the spectrum is so fast that the path would need too many samples.
    """
    path = magnet_path(scenario)
    fastest = max([*(line.frequency for line in jitter.speed), *(line.frequency for line in jitter.shake)], default=0.0)
    interval = min([COARSEST] + ([1.0 / (SAMPLES_A_PERIOD * fastest)] if fastest else []))
    count = math.ceil(path.duration / interval) + 1
    if count > MOST:
        raise InputError(
            f"jitter needs {count} samples at {fastest:g} Hz over {path.duration:g} s, "
            f"more than {MOST}; shorten the run"
        )
    times = np.linspace(0.0, path.duration, count)
    along = times.copy()
    for line in jitter.speed:
        phase = random.uniform(0.0, 2.0 * math.pi)
        rate = 2.0 * math.pi * line.frequency
        along += line.share / rate * (np.sin(rate * times + phase) - math.sin(phase))
    poses = path.at(np.clip(along, 0.0, path.duration))
    position = poses.position + np.array(jitter.offset)
    for shake in jitter.shake:
        swing = np.sin(2.0 * math.pi * shake.frequency * times + random.uniform(0.0, 2.0 * math.pi))
        position = position + swing[:, None] * np.array(shake.amplitude)
    axis = poses.axis
    spin = path.at(times).spin * (1.0 + jitter.frequency_error)
    return scenario.replaced(
        {
            "drive.path": {
                "time": times.tolist(),
                "position": position.tolist(),
                "yaw": np.unwrap(np.arctan2(axis[:, 1], axis[:, 0])).tolist(),
                "pitch": np.arcsin(np.clip(axis[:, 2], -1.0, 1.0)).tolist(),
                "phase": (spin - 2.0 * math.pi * scenario.drive.frequency * times).tolist(),
            },
            "drive.yaw_rate": 0.0,
            "drive.velocity": (0.0, 0.0, 0.0),
        }
    )


def study(
    scenario: Scenario,
    jitter: Jitter,
    *,
    draws: int = 4,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> "dict[str, Ensemble]":
    """The run without errors (nominal), and copies of it with each kind of error alone and with all, by kind.

    Each kind has ``draws`` runs, with other phases.

    Returns
    -------
    dict of str to Ensemble
        By kind of error, in the order in which they are reported.

    Raises
    ------
    InputError
        Where the jitter does not fit the run.
    RunError
        Where the numbers of a run broke down.
    """
    from helimag.engine import advance
    from helimag.ensembles import Ensemble, finished

    kinds = jitter.parts
    runs = [jittered(scenario, Jitter(), np.random.default_rng(seed))]
    labels = ["none"]
    for kind, part in kinds.items():
        drawn = draws if part.speed or part.shake else 1
        runs += [jittered(scenario, part, np.random.default_rng([seed, i])) for i in range(drawn)]
        labels += [kind] * drawn
    histories = finished(advance(runs, progress=progress))
    return {
        kind: Ensemble(histories[0], [run for label, run in zip(labels, histories, strict=True) if label == kind])
        for kind in kinds
    }


def measured_jitter(scenario: Scenario, log: Log, source: str) -> Jitter:
    """The errors of a log against its scenario's own path: offset, strongest lines of the rest, frequency error.

    Errors along the path count as shaking too: a log cannot tell an early arm from a displaced one.

    Returns
    -------
    Jitter
        SI.

    Raises
    ------
    InputError
        Where the log is too short to tell anything, or its samples are not evenly spaced to 20 %.
    """
    until = min(scenario.run.duration, float(log.time[-1]))
    inside = log.time <= until
    time = log.time[inside]
    if time.size < 32:
        raise InputError(f"a spectrum needs a log of 32 rows or more within the run; got {time.size}")
    spacing = np.diff(time)
    if spacing.max() > 1.2 * spacing.min():
        raise InputError("a spectrum needs a log with evenly spaced rows")
    away = log.tool[inside, :3, 3] - magnet_path(scenario).at(time).position
    offset = away.mean(axis=0)
    even = np.linspace(time[0], time[-1], time.size)
    rest = np.column_stack([np.interp(even, time, away[:, i] - offset[i]) for i in range(3)])
    window = np.hanning(time.size)
    spectrum = np.abs(np.fft.rfft(rest * window[:, None], axis=0)) / (window.sum() / 2.0)
    frequencies = np.fft.rfftfreq(time.size, even[1] - even[0])
    height = np.linalg.norm(spectrum, axis=1)
    peaks = [i for i in range(2, height.size - 1) if height[i] >= height[i - 1] and height[i] > height[i + 1]]
    chosen = sorted(sorted(peaks, key=lambda i: height[i], reverse=True)[:LINES])
    return Jitter(
        source=f"measured: {source}",
        shake=tuple(Shake(frequency=float(frequencies[i]), amplitude=tuple(spectrum[i].tolist())) for i in chosen),
        offset=tuple(offset.tolist()),
        frequency_error=_frequency_error(scenario, log),
    )


def _frequency_error(scenario: Scenario, log: Log) -> float:
    """Share by which the motor turned too fast, from the slope of its angle; zero where it was not recorded."""
    if log.motor is None:
        return 0.0
    check_motor(log, scenario)
    turned = float(np.polyfit(log.time, log.motor, 1)[0]) * (-1.0 if log.reversed_axis else 1.0)
    share = turned / (2.0 * math.pi * scenario.drive.frequency)
    if share < 0.0:
        raise InputError(
            "motor must turn as the scenario's drive does; it turns the other way round: check '# motor axis: along' "
            "or 'against'"
        )
    return share - 1.0
