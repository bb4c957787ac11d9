"""The runs of one chunk: scenarios in, arrays out. What every engine calls, here or on another machine."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.engine import History, advance, start_state
from helimag.ensembles import Devices
from helimag.errors import InputError
from helimag.outcomes import End, Reason, Verdict
from helimag.runs import Judgement
from helimag.scenario import Scenario

Rows = dict[str, NDArray[np.generic]]

HASH_BYTES = 32

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


# of the devices that a point is run with
PROBABILITIES = {f"probability_{verdict}".replace("-", "_"): verdict for verdict in Verdict if verdict.judged}
SHARES = {"gain_p05": 0.05, "gain_p50": 0.5, "gain_p95": 0.95}
SPREAD: dict[str, tuple[str, str]] = {
    **{name: ("1", f"share of the devices whose verdict is {verdict}") for name, verdict in PROBABILITIES.items()},
    "probability_inside": ("1", "share of the devices that are inside at the end of their runs, whatever comes then"),
    "probability_failed": ("1", "share of the devices whose scenario is refused, or whose numbers broke down"),
    **{name: ("1", f"{share:.0%} of the devices' gains lie below") for name, share in SHARES.items()},
}


@dataclass(frozen=True)
class Kept:
    """What is kept of each point: its state at times (s), and how the devices end that it is run with."""

    times: NDArray[np.float64] | None = None
    devices: Devices | None = None

    @property
    def scalars(self) -> dict[str, tuple[str, str]]:
        """Unit and meaning of each number of a point."""
        return SCALARS if self.devices is None else SCALARS | SPREAD


NOTHING_MORE = Kept()


def empty_rows(count: int, kept: Kept = NOTHING_MORE) -> Rows:
    """Arrays of ``count`` points that have not been computed."""
    rows: Rows = {name: np.full(count, np.nan) for name in kept.scalars}
    rows["verdict"] = np.zeros(count, np.int8)
    rows["reason"] = np.zeros(count, np.int8)
    rows["scenario_hash"] = np.zeros((count, HASH_BYTES), np.uint8)
    if kept.times is not None:
        rows["position"] = np.full((count, kept.times.size, 3), np.nan)
        rows["quaternion"] = np.full((count, kept.times.size, 4), np.nan)
    return rows


def compute(
    scenarios: Sequence[Scenario | None],
    kept: Kept = NOTHING_MORE,
    *,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Rows:
    """Run a chunk and judge each run; a run that fails is a row like any other.

    Parameters
    ----------
    scenarios
        One a point; None where the point made no valid scenario.
    kept
        What to keep of each beside its judgement.
    threads, progress
        As for :func:`helimag.engine.advance`.
    """
    rows = empty_rows(len(scenarios), kept)
    _say(rows, slice(None), Reason.SCENARIO_REFUSED)
    valid = [(i, scenario) for i, scenario in enumerate(scenarios) if scenario is not None]
    if not valid:
        return rows
    copies = [_copies(scenario, kept.devices) for _, scenario in valid]
    batch = [scenario for _, scenario in valid] + [copy for each in copies for copy, _ in each]
    states = [start_state(scenario) for _, scenario in valid] + [state for each in copies for _, state in each]
    histories = iter(advance(batch, initial_states=np.array(states), threads=threads, progress=progress))
    for i, _ in valid:
        _fill(rows, i, next(histories))
    for (i, _), each in zip(valid, copies, strict=True):
        if kept.devices is not None:
            _fill_spread(rows, i, [next(histories) for _ in each], len(kept.devices))
    return rows


def _copies(scenario: Scenario, devices: Devices | None) -> list[tuple[Scenario, NDArray[np.float64]]]:
    """A point with each of the devices, but for those that it cannot have, and the states that its runs begin in."""
    made: list[tuple[Scenario, NDArray[np.float64]]] = []
    if devices is None:
        return made
    for place in range(len(devices)):
        try:
            made.append(devices.copy(scenario, place))
        except InputError:
            continue  # counts as failed
    return made


def _fill_spread(rows: Rows, point: int, histories: Sequence[History], drawn: int) -> None:
    """Write how the devices of a point ended; what did not run counts as failed."""
    judgements = [judgement for history in histories if (judgement := _judged(history)) is not None]
    for name, verdict in PROBABILITIES.items():
        rows[name][point] = sum(judgement.verdict is verdict for judgement in judgements) / drawn
    rows["probability_inside"][point] = sum(judgement.verdict.inside for judgement in judgements) / drawn
    rows["probability_failed"][point] = (drawn - len(judgements)) / drawn
    if judgements:
        gains = [judgement.gain for judgement in judgements]
        for name, share in SHARES.items():
            rows[name][point] = np.quantile(gains, share)


def _judged(history: History) -> Judgement | None:
    """How a run is judged; None where its numbers broke down, or it has no input."""
    if history.status is End.NOT_FINITE:
        return None
    try:
        return history.judge()
    except InputError:
        return None


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
    judgement = _judged(history)
    if judgement is None:
        return  # the scenario has no input: the device starts level with the magnet
    for name in SCALARS:
        if name != "height_change":
            value = getattr(judgement, name)
            rows[name][run] = np.nan if value is None else value
    heights = history.heights
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
