"""A word to the user where something takes long that is done once and kept."""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 0.7  # s before saying something


def announce(what: str) -> None:
    """Say on stderr what takes long: the only words there that depend on the machine's past."""
    print(f"helimag: {what}", file=sys.stderr)


@contextmanager
def announced(what: str) -> Iterator[None]:
    """Say ``what`` if the block takes more than a moment."""
    note = threading.Timer(PATIENCE, lambda: announce(what))
    note.daemon = True
    note.start()
    try:
        yield
    finally:
        note.cancel()
