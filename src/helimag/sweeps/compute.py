"""The runs of one chunk: scenarios in, arrays out. What every engine calls, here or on another machine."""

from collections.abc import Callable, Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from helimag.engine import History, advance
from helimag.errors import InputError
from helimag.runs.gain import End, Judgement, Verdict
from helimag.scenario import Scenario

Rows = dict[str, NDArray[np.generic]]

HASH_BYTES = 32


class Outcome(IntEnum):
    """A run's verdict as a CF flag; also what has no verdict."""

    NOT_COMPUTED = 0
    BOUNDED = 1
    DRIFTING = 2
    ATTRACTED = 3
    FELL = 4
    WALL_LIMITED = 5
    FAILED = 6


class Reason(IntEnum):
    """Why, as a CF flag."""

    NOT_COMPUTED = 0
    SETTLED = 1
    STILL_RISES = 2
    STILL_SINKS = 3
    SWINGS_EVER_MORE = 4
    PULLED_INTO_MAGNET = 5
    FELL_BEHIND = 6
    REACHED_FLOOR = 7
    REACHED_SURFACE = 8
    REACHED_WALL = 9
    NUMBERS_BROKE_DOWN = 10
    SCENARIO_REFUSED = 11


# name: unit, meaning; one number a run
SCALARS: dict[str, tuple[str, str]] = {
    "gain": ("1", "input-output gain y / u (eq. 6)"),
    "output": ("m", "y: range of heights that the head covers"),
    "input": ("m", "u: initial height difference between device and magnet"),
    "end_time": ("s", "when the run ended"),
    "escape_time": ("s", "when the device was lost; none where it was not"),
    "slips": ("1", "turns slipped against the field"),
    "wobble": ("rad", "standard deviation of the attack angle over the second half of the run"),
    "attack_angle": ("rad", "mean attack angle over the second half of the run"),
    "height_change": ("m", "mean height at the end of the run less that at its start"),
}
ENDS = {
    End.CONTACT: Reason.PULLED_INTO_MAGNET,
    End.FLOOR: Reason.REACHED_FLOOR,
    End.SURFACE: Reason.REACHED_SURFACE,
    End.WALL: Reason.REACHED_WALL,
}


def label(flag: IntEnum) -> str:
    """A flag's word, as verdicts are written everywhere: ``wall-limited``."""
    return flag.name.lower().replace("_", "-")


def empty_rows(count: int, sample_times: NDArray[np.float64] | None = None) -> Rows:
    """Arrays of ``count`` runs that have not been computed."""
    rows: Rows = {name: np.full(count, np.nan) for name in SCALARS}
    rows["verdict"] = np.zeros(count, np.int8)
    rows["reason"] = np.zeros(count, np.int8)
    rows["scenario_hash"] = np.zeros((count, HASH_BYTES), np.uint8)
    if sample_times is not None:
        rows["position"] = np.full((count, sample_times.size, 3), np.nan)
        rows["quaternion"] = np.full((count, sample_times.size, 4), np.nan)
    return rows


def compute(
    scenarios: Sequence[Scenario | None],
    sample_times: NDArray[np.float64] | None = None,
    *,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Rows:
    """Run a chunk and judge each run; a run that fails is a row like any other.

    Parameters
    ----------
    scenarios
        One a run; None where the point made no valid scenario. They may differ in the magnet's field model.
    sample_times
        (times,): when to keep the state (s), where trajectories are kept.
    threads, progress
        As for :func:`helimag.engine.simulation.advance`.
    """
    rows = empty_rows(len(scenarios), sample_times)
    rows["verdict"][:] = Outcome.FAILED
    rows["reason"][:] = Reason.SCENARIO_REFUSED
    valid = [(i, scenario) for i, scenario in enumerate(scenarios) if scenario is not None]
    for model in sorted({scenario.magnet[0].field for _, scenario in valid}):
        batch = [(i, scenario) for i, scenario in valid if scenario.magnet[0].field == model]
        histories = advance([scenario for _, scenario in batch], threads=threads, progress=progress)
        for (i, _), history in zip(batch, histories, strict=True):
            _fill(rows, i, history)
    return rows


def _fill(rows: Rows, run: int, history: History) -> None:
    """Write one run's results into its row."""
    rows["scenario_hash"][run] = np.frombuffer(bytes.fromhex(history.scenario.hash), np.uint8)
    if "position" in rows:
        count = min(history.time.size, rows["position"].shape[1])
        if history.time[count - 1] != _due(history, count - 1):
            count -= 1  # the last sample is that of the end, between two of the times that are kept
        rows["position"][run, :count] = history.states[:count, :3]
        rows["quaternion"][run, :count] = history.states[:count, 3:]
    if history.status.name == "NOT_FINITE":
        rows["reason"][run] = Reason.NUMBERS_BROKE_DOWN
        rows["end_time"][run] = history.time[-1]
        return
    try:
        judgement = history.judge()
    except InputError:
        return  # the scenario has no input: the device starts level with the magnet
    for name in SCALARS:
        if name != "height_change":
            value = getattr(judgement, name)
            rows[name][run] = np.nan if value is None else value
    heights = history.heights
    rows["height_change"][run] = heights.mean[-1] - heights.mean[0]
    rows["verdict"][run] = Outcome[judgement.verdict.name]
    rows["reason"][run] = _reason(judgement, heights.end)


def _due(history: History, sample: int) -> float:
    """When a sample was due (s); the last one of a run that ended early comes before."""
    run = history.scenario.run
    return float(min(sample * run.sample_interval, run.duration))


def _reason(judgement: Judgement, end: End) -> Reason:
    match judgement.verdict:
        case Verdict.BOUNDED:
            return Reason.SETTLED
        case Verdict.FELL:
            return Reason.FELL_BEHIND
        case Verdict.DRIFTING if "still rises" in judgement.reason:
            return Reason.STILL_RISES
        case Verdict.DRIFTING if "still sinks" in judgement.reason:
            return Reason.STILL_SINKS
        case Verdict.DRIFTING:
            return Reason.SWINGS_EVER_MORE
        case _:
            return ENDS[end]
