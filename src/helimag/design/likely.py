"""Inputs with which a device is bounded as likely as can be, whichever of those that it may be it is."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from helimag.design.full_runs import long_run
from helimag.design.margins import polished
from helimag.design.result import Design
from helimag.design.task import DesignTask
from helimag.engine import start_state
from helimag.ensembles import Copies, Devices, tally
from helimag.orbits import Orbit, Watch
from helimag.outcomes import Verdict

FIRST_DEVICES = 8  # each candidate is run with, and twice as many each time that the better half of them is kept


def likeliest(
    task: DesignTask, devices: Devices, fits: Sequence[Orbit], on_orbit: bool, watch: Watch, tried: list[Orbit]
) -> Design | None:
    """The design that most of the devices stay with; None where none of them stays with any candidate.

    All candidates meet the same devices with the same errors, so that they are compared on equal terms. Of two that are
    as good, the one that comes first in ``fits`` is taken; what was ``tried`` in vain is added.
    """
    batches = [_copies(devices, orbit, on_orbit) for orbit in fits]
    counts: list[Counter[Verdict]] = [Counter() for _ in fits]
    alive, begun, many = list(range(len(fits))), 0, FIRST_DEVICES
    comparing = watch.part(0.0, 0.8)
    while alive and begun < len(devices):
        end = len(devices) if len(alive) == 1 else min(begun + many, len(devices))
        share = comparing.part(begun / len(devices), end / len(devices))
        for turn, i in enumerate(alive):
            counts[i] += tally(batches[i].part(begun, end), progress=share.turn(turn, len(alive)))
        alive.sort(key=lambda i: _staying(counts[i]), reverse=True)
        begun, many = end, 2 * many
        if begun < len(devices):
            alive = alive[: max(1, len(alive) // 2)]
    for i in alive:
        intervals = polished(task, fits[i], 0, watch.part(0.8, 1.0)) if counts[i][Verdict.BOUNDED] else None
        if intervals is not None:
            return Design(fits[i], long_run(fits[i]), intervals[2], {}, dict(counts[i]), on_orbit)
    tried += fits
    return None


def _staying(verdicts: Counter[Verdict]) -> tuple[int, int]:
    """How many are bounded; of as many, how many are inside at the end at least."""
    return verdicts[Verdict.BOUNDED], sum(count for verdict, count in verdicts.items() if verdict.inside)


def _copies(devices: Devices, orbit: Orbit, on_orbit: bool) -> Copies:
    """A candidate's long run with each device, from the scenario's start or from the orbit, displaced as drawn."""
    copies = devices.copies(long_run(orbit))
    if not on_orbit:
        return copies
    begun = np.array([start_state(scenario) for scenario in copies.scenarios])
    states = np.repeat(orbit.state[None], len(begun), axis=0)
    states[:, :3] += copies.states[:, :3] - begun[:, :3]
    return Copies(copies.scenarios, states)
