"""The runs of one chunk: scenarios in, arrays out. What every engine calls, here or on another machine."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from helimag.engine import History, advance
from helimag.errors import InputError
from helimag.outcomes import End, Reason
from helimag.runs.gain import judge
from helimag.scenario import Scenario

Rows = dict[str, NDArray[np.generic]]

HASH_BYTES = 32
AT_ONCE = 64  # runs of a chunk whose histories are held in memory

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
    "contacts": ("1", "how often the device came to a wall that held it"),
    "contact_time": ("s", "how long walls held it, each wall's time added"),
    "first_contact": ("s", "when it first came to such a wall; none where it never did"),
    "height_change": ("m", "mean height at the end of the run less that at its start"),
}


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
        One a run; None where the point made no valid scenario.
    sample_times
        (times,): when to keep the state (s), where trajectories are kept.
    threads, progress
        As for :func:`helimag.engine.advance`.
    """
    rows = empty_rows(len(scenarios), sample_times)
    _say(rows, slice(None), Reason.SCENARIO_REFUSED)
    valid = [(i, scenario) for i, scenario in enumerate(scenarios) if scenario is not None]
    for begin in range(0, len(valid), AT_ONCE):
        part = valid[begin : begin + AT_ONCE]
        seen = None if progress is None else partial(_part_seen, progress, begin, len(part), len(valid))
        histories = advance([scenario for _, scenario in part], threads=threads, progress=seen)
        for (i, _), history in zip(part, histories, strict=True):
            _fill(rows, i, history)
    return rows


def _part_seen(progress: Callable[[float], None], begin: int, count: int, total: int, done: float) -> None:
    """Report the share of all runs that is done, from that of the ``count`` after the first ``begin``."""
    progress((begin + done * count) / total)


def _fill(rows: Rows, run: int, history: History) -> None:
    """Write one run's results into its row."""
    rows["scenario_hash"][run] = np.frombuffer(bytes.fromhex(history.scenario.hash), np.uint8)
    if "position" in rows:
        count = min(history.time.size, rows["position"].shape[1])
        if history.time[count - 1] != _due(history, count - 1):
            count -= 1  # the last sample is that of the end, between two of the times that are kept
        rows["position"][run, :count] = history.states[:count, :3]
        rows["quaternion"][run, :count] = history.states[:count, 3:]
    if history.status is End.NOT_FINITE:
        _say(rows, run, Reason.NUMBERS_BROKE_DOWN)
        rows["end_time"][run] = history.time[-1]
        return
    heights = history.heights
    try:
        judgement = judge(heights)
    except InputError:
        return  # the scenario has no input: the device starts level with the magnet
    for name in SCALARS:
        if name != "height_change":
            value = getattr(judgement, name)
            rows[name][run] = np.nan if value is None else value
    rows["height_change"][run] = heights.mean[-1] - heights.mean[0]
    _say(rows, run, judgement.cause)


def _say(rows: Rows, where: int | slice, cause: Reason) -> None:
    """Write the verdict and its reason into rows."""
    rows["verdict"][where] = cause.verdict.flag
    rows["reason"][where] = cause.flag


def _due(history: History, sample: int) -> float:
    """When a sample was due (s); the last one of a run that ended early comes before."""
    run = history.scenario.run
    return float(min(sample * run.sample_interval, run.duration))
