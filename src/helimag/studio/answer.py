"""What the page says of a run: verdict, gain and the rest, exactly as ``helimag simulate --json`` prints them."""

import math
from dataclasses import dataclass
from enum import Enum, auto

from helimag.outcomes import Verdict
from helimag.runs import Trajectory


class Stage(Enum):
    """How far an answer has got: the first part of the run, all of it, and the outlook."""

    FIRST = auto()
    WHOLE = auto()
    AFTERWARDS = auto()


@dataclass(frozen=True)
class Answer:
    """A run judged."""

    verdict: Verdict
    reason: str
    gain: float
    numbers: dict[str, str]
    outlook: str | None = None


def answered(run: Trajectory, outlook: str | None = None) -> Answer:
    """The answer that a run gives."""
    judged = run.judgement
    numbers: dict[str, float | int | None] = {
        "gain": judged.gain,
        "output_y_m": judged.output,
        "input_u_m": judged.input,
        "end_time_s": judged.end_time,
        "escape_time_s": judged.escape_time,
        "slips": judged.slips,
        "wobble_deg": math.degrees(judged.wobble),
        "attack_angle_deg": math.degrees(judged.attack_angle),
    }
    shown = {name: "-" if value is None else repr(value) for name, value in numbers.items()}
    return Answer(judged.verdict, judged.reason, judged.gain, shown, outlook)
