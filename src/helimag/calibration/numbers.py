"""Numbers that can be observed of a run: each a smooth function of its heights and states."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q

if TYPE_CHECKING:
    from helimag.engine import History

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Observable:
    """A number of a run: its kind (None without a unit), its name in words, and its value up to a time (s)."""

    kind: q.Kind | None
    words: str
    value: Callable[["History", float], float]


def _part(history: "History", until: float) -> NDArray[np.bool_]:
    part = history.time <= until * (1.0 + 1e-9)
    part[0] = True
    return part


def output(history: "History", until: float) -> float:
    """|y|: range of heights that the head covers (m)."""
    heights, part = history.heights, _part(history, until)
    return float(heights.high[part].max() - heights.low[part].min())


def gain(history: "History", until: float) -> float:
    """|y| over the initial height difference of device and magnet (eq. 6)."""
    return output(history, until) / history.heights.initial_gap


def attack_angle(history: "History", until: float) -> float:
    """Mean attack angle over the second half (rad)."""
    part = _part(history, until)
    time, attack = history.time[part], history.heights.attack[part]
    late = time >= time[0] + (time[-1] - time[0]) / 2.0
    spans = np.diff(time, prepend=time[0])[late]
    return float(np.average(attack[late], weights=spans)) if spans.sum() > 0.0 else float(attack[-1])


def speed(history: "History", until: float) -> float:
    """Distance between first and last place along the horizontal, over the time between (m/s)."""
    part = _part(history, until)
    places, time = history.states[part, :2], history.time[part]
    gone = float(time[-1] - time[0])
    return float(np.linalg.norm(places[-1] - places[0])) / gone if gone > 0.0 else 0.0


def rise(history: "History", until: float) -> float:
    """Height of the head at the end less that at the start (m)."""
    heights = history.states[_part(history, until), 2]
    return float(heights[-1] - heights[0])


def depth(history: "History", until: float) -> float:
    """How far below its start the head came (m)."""
    return float(history.states[0, 2] - history.heights.low[_part(history, until)].min())


NUMBERS: dict[str, Observable] = {
    "output": Observable(q.LENGTH, "|y|", output),
    "gain": Observable(None, "gain", gain),
    "attack_angle": Observable(q.ANGLE, "attack angle", attack_angle),
    "speed": Observable(q.VELOCITY, "speed", speed),
    "rise": Observable(q.LENGTH, "rise", rise),
    "depth": Observable(q.LENGTH, "depth reached", depth),
}
