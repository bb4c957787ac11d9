"""What a check returns."""

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal


@dataclass(frozen=True)
class Check:
    """One assumption of the model held against a scenario.

    ``setting`` is the dotted path of the field that decides. ``value`` is sound where it is at most, or at least, the
    ``threshold``. ``message`` says the number in words, ``remedy`` what to do.
    """

    name: str
    setting: str
    value: float
    bound: Literal["at most", "at least"]
    threshold: float
    message: str
    remedy: str

    @property
    def holds(self) -> bool:
        """Whether the assumption holds; a value that is not a number never does."""
        return self.value <= self.threshold if self.bound == "at most" else self.value >= self.threshold

    @property
    def excess(self) -> float:
        """How many times the value is beyond the threshold; more than one where the check does not hold."""
        over, under = (self.value, self.threshold) if self.bound == "at most" else (self.threshold, self.value)
        return over / under if under > 0.0 else float("inf")

    def as_dict(self) -> dict[str, Any]:
        """For JSON, which has no infinity: ``value`` is None where it is no finite number."""
        return {**asdict(self), "value": self.value if math.isfinite(self.value) else None}
