"""Tolerances for equal errors, and times in interleaved rounds."""

import math
import time
from dataclasses import dataclass, field

import numpy as np
from codes import Code, Floats

DECADES = range(3, 14)  # of tolerances that are tried
HORIZON = 100.0  # s; where errors are measured
NEAR = 0.5  # of the error aimed at: closer is near enough
HALVINGS = 3  # of the way between two tolerances, where none is near enough


@dataclass
class Tuning:
    """Errors (m) of a code after :data:`HORIZON` by tolerance, the loosest first."""

    code: Code
    exact: Floats
    errors: dict[float, float] = field(default_factory=dict)
    chosen: dict[float, float] = field(default_factory=dict)

    def error(self, tolerance: float) -> float:
        """The error at a tolerance; infinite where the run broke down."""
        if tolerance not in self.errors:
            away = float(np.linalg.norm(self.code.run(HORIZON, tolerance) - self.exact))
            self.errors[tolerance] = away if math.isfinite(away) else math.inf
        return self.errors[tolerance]

    def scan(self, least: float) -> None:
        """Try tolerances down to where the error is below ``least`` twice running."""
        below = 0
        for decade in DECADES:
            below = below + 1 if self.error(10.0**-decade) < least else 0
            if below == 2:
                return

    def tolerance_for(self, target: float) -> float:
        """The loosest tolerance found at which, and at all tighter ones tried, the error is within the target."""
        if target in self.chosen:
            return self.chosen[target]
        for _ in range(HALVINGS):
            best, looser = self._around(target)
            if not 0.0 < best < looser or self.errors[best] > NEAR * target:
                break
            self.error(float(f"{math.sqrt(best * looser):.3g}"))
        self.chosen[target] = self._around(target)[0]
        return self.chosen[target]

    def _around(self, target: float) -> tuple[float, float]:
        """That tolerance, zero where there is none, and the next looser one that was tried, zero likewise."""
        tried = sorted(self.errors)
        count = next((i for i, tolerance in enumerate(tried) if self.errors[tolerance] > target), len(tried))
        return tried[count - 1] if count else 0.0, tried[count] if count < len(tried) else 0.0


def timed(code: Code, duration: float, tolerance: float) -> float:
    """CPU seconds of one run, user's and system's: ticks of 4 ms tell one from the other, too coarse for a run."""
    begun = time.process_time()
    code.run(code.share * duration, tolerance)
    return (time.process_time() - begun) / code.share / code.runs


def rounds(codes: list[tuple[Code, float]], duration: float, count: int) -> Floats:
    """Seconds a run, codes in turn in each round: (rounds, codes)."""
    for code, tolerance in codes:
        code.run(HORIZON, tolerance)  # compiles what long runs take
    return np.array([[timed(code, duration, tolerance) for code, tolerance in codes] for _ in range(count)])
