"""Progress of a long search, told to a caller some times a second; he stops the search by raising from what is called.

Nothing else is needed to cancel: exceptions from the caller's function and Ctrl-C go the same way out.
"""

import math
import time
from collections.abc import Callable

Report = Callable[[float], None]

INTERVAL = 0.1  # s between reports where nothing new is to be told


class Watch:
    """How far a search has come. Called with the fraction done, it tells the caller; that never goes backwards.

    Parameters
    ----------
    report
        The caller's function, or another watch; None where nobody asks.
    """

    def __init__(self, report: Report | None = None) -> None:
        self._report = report
        self._done, self._told = 0.0, -math.inf

    def __call__(self, done: float) -> None:
        self._done, self._told = max(self._done, min(float(done), 1.0)), time.monotonic()
        if self._report is not None:
            self._report(self._done)

    def pulse(self) -> None:
        """Tell the caller the same again where he has heard nothing for a while, so that he can stop the search."""
        if time.monotonic() - self._told >= INTERVAL:
            self(self._done)

    def part(self, begin: float, end: float) -> "Watch":
        """The watch of a part of the work, that from ``begin`` to ``end`` as shares of all of it."""
        return Watch(lambda done: self(begin + (end - begin) * done))

    def unmeasured(self) -> "Watch":
        """The watch of a part of which nobody knows how long it is: the caller hears what he has heard already."""
        return Watch(lambda _: self.pulse())

    def turn(self, number: int, of: int) -> "Watch":
        """The watch of one of several parts of equal length, counted from zero."""
        return self.part(number / of, (number + 1) / of)
