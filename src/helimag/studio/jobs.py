"""Longer work of a panel, beside the page: with progress, to be stopped, and in nobody's way."""

import threading
import time
from collections.abc import Callable
from typing import Any

from helimag.errors import HelimagError
from helimag.studio.live import Live

INTERVAL = 0.5  # s between words of how far it has come
PATIENCE = 0.02  # s between looks at whether the live run is done


class JobStopped(Exception):
    """The work is no longer wanted."""


class Job:
    """One piece of work at a time; a new one stops the one before.

    Parameters
    ----------
    live
        The tab's live run, which goes first: the work waits at its next word of progress while that one computes.
    """

    def __init__(self, live: Live) -> None:
        self._live = live
        self._number = 0
        self.fraction = 0.0
        self.running = False

    def start(
        self,
        work: Callable[[Callable[[float], None]], Any],
        done: Callable[[Any], None],
        failed: Callable[[str], None],
        heard: Callable[[float], None] | None = None,
    ) -> None:
        """Do ``work(progress)`` in a thread; ``done`` gets what it returns, ``failed`` why it did not, there too.

        ``heard`` gets the fraction done now and then.
        """
        self._number += 1
        number, self.fraction, self.running = self._number, 0.0, True
        told = time.monotonic()

        def progress(fraction: float) -> None:
            nonlocal told
            self._breathe(number)
            self.fraction = fraction
            if heard is not None and time.monotonic() - told > INTERVAL:
                told = time.monotonic()
                heard(fraction)

        def run() -> None:
            try:
                result = work(progress)
                self._breathe(number)
            except JobStopped:
                return
            except HelimagError as error:
                if number == self._number:
                    self.running = False
                    failed(str(error))
                return
            self.running, self.fraction = False, 1.0
            done(result)

        threading.Thread(target=run, name="helimag-job", daemon=True).start()

    def stop(self) -> None:
        """Give up what is being done."""
        self._number += 1
        self.running = False

    def _breathe(self, number: int) -> None:
        """Raise JobStopped where the work is no longer wanted; wait while the live run computes."""
        while number == self._number and not self._live.idle.is_set():
            time.sleep(PATIENCE)
        if number != self._number:
            raise JobStopped
