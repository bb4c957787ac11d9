"""A word to the user where something takes long that is done once and kept."""

import logging
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 0.7  # s before saying something
AGAIN = 4.0  # s between further words: nothing is silent for more than five seconds
TOLD = 0.01  # s: what took less was at hand already, and a log of it would only be long
LOG = logging.getLogger(__name__)


def announce(what: str) -> None:
    """Say on stderr what takes long: the only words there that depend on the machine's past."""
    print(f"helimag: {what}", file=sys.stderr)


@contextmanager
def announced(what: str, *, log: str) -> Iterator[None]:
    """Say ``what`` if the block takes more than a moment, and again how long it has taken while it goes on.

    What took more than a glance is logged as ``log`` with its time, whether or not anything was said.
    """
    done, begun = threading.Event(), time.monotonic()
    threading.Thread(target=_speak, args=(what, done, begun), daemon=True).start()
    try:
        yield
    finally:
        done.set()
        taken = time.monotonic() - begun
        if taken > TOLD:
            LOG.info("%s: %.2f s", log, taken)


def _speak(what: str, done: threading.Event, begun: float) -> None:
    if done.wait(PATIENCE):
        return
    announce(what)
    while not done.wait(AGAIN):
        announce(f"... {time.monotonic() - begun:.0f} s so far")
