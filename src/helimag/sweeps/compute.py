"""The runs of one chunk: scenarios in, arrays out. What every engine calls, here or on another machine."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.engine import DEFAULT, History, advance, method_named, start_state
from helimag.ensembles import Devices
from helimag.errors import InputError
from helimag.outcomes import End, Reason, Verdict
from helimag.runs import judge_each
from helimag.scenario import Scenario

Rows = dict[str, NDArray[np.generic]]

HASH_BYTES = 32
# runs of a chunk, those of devices too, whose histories are held in memory: as many as hold so many samples
FEWEST_AT_ONCE, MOST_AT_ONCE = 64, 1024
SAMPLES_AT_ONCE = 80_000

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
    """What is kept of each point: its state at times (s), and how the devices end that it is run with.

    ``method`` is what takes the steps of its runs, by the name that :func:`helimag.simulate` has for it.
    """

    times: NDArray[np.float64] | None = None
    devices: Devices | None = None
    method: str = DEFAULT

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
        What to keep of each beside its judgement, and how to run it.
    threads, progress
        As for :func:`helimag.engine.advance`.
    """
    rows = empty_rows(len(scenarios), kept)
    _say(rows, range(len(scenarios)), [Reason.SCENARIO_REFUSED] * len(scenarios))
    valid = [(point, scenario) for point, scenario in enumerate(scenarios) if scenario is not None]
    total = len(valid) * (1 if kept.devices is None else 1 + len(kept.devices))
    ended: dict[int, list[tuple[Verdict, float]]] = {point: [] for point, _ in valid}
    runs, begin = _runs(valid, kept.devices), 0
    at_once = _at_once([scenario for _, scenario in valid])
    while batch := list(islice(runs, at_once)):
        states = np.array([run.state for run in batch])
        seen = None if progress is None else partial(_part_seen, progress, begin, len(batch), total)
        engine: dict[str, Any] = {"method": method_named(kept.method), "threads": threads, "progress": seen}
        histories = advance([run.scenario for run in batch], initial_states=states, **engine)
        judged = judge_each([history.heights for history in histories])
        causes = [
            said[0] if said is not None and history.status is not End.NOT_FINITE else None
            for said, history in zip(judged.said, histories, strict=True)
        ]
        _fill(rows, batch, histories, causes, judged.numbers)
        for run, cause, gain in zip(batch, causes, judged.numbers["gain"].tolist(), strict=True):
            if run.drawn and cause is not None:
                ended[run.point].append((cause.verdict, gain))
        begin += len(batch)
    if kept.devices is not None:
        for point, drawn in ended.items():
            _fill_spread(rows, point, drawn, len(kept.devices))
    return rows


def _at_once(scenarios: Sequence[Scenario]) -> int:
    """How many runs to make at once: what each such batch costs by itself would be some of the time of short ones."""
    samples = max((scenario.run.duration / scenario.run.sample_interval for scenario in scenarios), default=1.0)
    return min(MOST_AT_ONCE, max(FEWEST_AT_ONCE, int(SAMPLES_AT_ONCE / samples)))


@dataclass(frozen=True)
class _Run:
    """A run of a point, with a device that was ``drawn`` or as the point says, and the state (7,) that it begins in."""

    point: int
    scenario: Scenario
    state: NDArray[np.float64]
    drawn: bool


def _runs(valid: Sequence[tuple[int, Scenario]], devices: Devices | None) -> Iterator[_Run]:
    """All runs of some points, one point after the other; none with a device that a point cannot have."""
    for point, scenario in valid:
        yield _Run(point, scenario, start_state(scenario), drawn=False)
        if devices is None:
            continue
        for place in range(len(devices)):
            try:
                copy, state = devices.copy(scenario, place)
            except InputError:
                continue  # counts as failed
            yield _Run(point, copy, state, drawn=True)


def _part_seen(progress: Callable[[float], None], begin: int, count: int, total: int, done: float) -> None:
    """Report the share of all runs that is done, from that of the ``count`` after the first ``begin``."""
    progress((begin + done * count) / total)


def _fill_spread(rows: Rows, point: int, ended: Sequence[tuple[Verdict, float]], drawn: int) -> None:
    """Write how the devices of a point ended, with their gains; what did not run or broke down counts as failed."""
    for name, verdict in PROBABILITIES.items():
        rows[name][point] = sum(each is verdict for each, _ in ended) / drawn
    rows["probability_inside"][point] = sum(each.inside for each, _ in ended) / drawn
    rows["probability_failed"][point] = (drawn - len(ended)) / drawn
    if ended:
        gains = [gain for _, gain in ended]
        for name, share in SHARES.items():
            rows[name][point] = np.quantile(gains, share)


def _fill(
    rows: Rows,
    runs: Sequence[_Run],
    histories: Sequence[History],
    causes: Sequence[Reason | None],
    numbers: Mapping[str, NDArray[np.float64]],
) -> None:
    """Write the points' own runs into their rows, column by column: many times faster than run by run.

    A cause is missing where the numbers of a run broke down, or it has no input: it starts level with the magnet.
    """
    own = [i for i, run in enumerate(runs) if not run.drawn]
    digests = b"".join(bytes.fromhex(runs[i].scenario.hash) for i in own)
    rows["scenario_hash"][[runs[i].point for i in own]] = np.frombuffer(digests, np.uint8).reshape(-1, HASH_BYTES)
    if "position" in rows:
        for i in own:
            _fill_places(rows, runs[i].point, histories[i])
    found = {i: cause for i in own if (cause := causes[i]) is not None}
    judged, where = list(found), [runs[i].point for i in found]
    for name in SCALARS:
        rows[name][where] = numbers[name][judged]
    _say(rows, where, list(found.values()))
    broken = [i for i in own if histories[i].status is End.NOT_FINITE]
    lost = [runs[i].point for i in broken]
    rows["end_time"][lost] = [histories[i].time[-1] for i in broken]
    _say(rows, lost, [Reason.NUMBERS_BROKE_DOWN] * len(lost))


def _fill_places(rows: Rows, point: int, history: History) -> None:
    """Write where a run was at the times that are kept."""
    count = min(history.time.size, rows["position"].shape[1])
    if history.time[count - 1] != _due(history, count - 1):
        count -= 1  # the last sample is that of the end, between two of the times that are kept
    rows["position"][point, :count] = history.states[:count, :3]
    rows["quaternion"][point, :count] = history.states[:count, 3:]


def _say(rows: Rows, where: Sequence[int], causes: Sequence[Reason]) -> None:
    """Write verdicts and their reasons into rows."""
    rows["verdict"][where] = [cause.verdict.flag for cause in causes]
    rows["reason"][where] = [cause.flag for cause in causes]


def _due(history: History, sample: int) -> float:
    """When a sample was due (s); the last one of a run that ended early comes before."""
    run = history.scenario.run
    return float(min(sample * run.sample_interval, run.duration))
