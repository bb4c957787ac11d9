"""How far an orbit lies from every loss of stability, input by input, and moving it to where that is farthest."""

from collections.abc import Mapping

import numpy as np

from helimag.design.fitting import fitted
from helimag.design.task import DesignTask
from helimag.errors import InputError
from helimag.orbits import Floats, Orbit, StableInterval, Watch, find_orbits, stable_interval


def stable_intervals(task: DesignTask, orbit: Orbit, watch: Watch) -> dict[str, StableInterval]:
    """Where the orbit stays stable as each input varies alone, within the limits."""
    return {
        path: stable_interval(orbit, path, low, low + span, progress=watch.turn(count, len(task.span)))
        for count, (path, low, span) in enumerate(zip(task.parameters.paths, task.low, task.span, strict=True))
    }


def least_margin(task: DesignTask, intervals: Mapping[str, StableInterval]) -> float:
    """The least share of an input's range between the orbit and an end of its stable interval."""
    return min(float(interval.margin / span) for interval, span in zip(intervals.values(), task.span, strict=True))


def polished(
    task: DesignTask, orbit: Orbit, moves: int, watch: Watch
) -> tuple[float, Orbit, dict[str, StableInterval]] | None:
    """Least margin, orbit and intervals, moved to their middle while that margin grows; None where it has none."""
    try:
        intervals = stable_intervals(task, orbit, watch.turn(0, moves + 1))
    except InputError:
        return None
    margin, share = least_margin(task, intervals), 0.7
    for count in range(moves):
        part = watch.turn(count + 1, moves + 1)
        place = task.shares(orbit.scenario)
        middle = (np.array([(i.low + i.high) / 2.0 for i in intervals.values()]) - task.low) / task.span
        target = place + share * (middle - place)
        moved = _walk(task, orbit, target, part.part(0.0, 0.3))
        if moved is None:
            share *= 0.5
            continue
        try:
            new = stable_intervals(task, moved, part.part(0.3, 1.0))
        except InputError:
            share *= 0.5
            continue
        if least_margin(task, new) > margin:
            orbit, intervals, margin = moved, new, least_margin(task, new)
        else:
            share *= 0.5
    return margin, orbit, intervals


def _walk(task: DesignTask, orbit: Orbit, target: Floats, watch: Watch, steps: int = 6) -> Orbit | None:
    """The orbit taken to other inputs in small steps, then to the wanted values."""
    place = task.shares(orbit.scenario)
    for i in range(1, steps + 1):
        (orbit,) = find_orbits(
            [task.at(place + i / steps * (target - place))], orbit.state[None], progress=watch.turn(i - 1, steps)
        )
        if not orbit.stable:
            return None
    return fitted(task, orbit, watch)
