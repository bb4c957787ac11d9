"""Standard output and error as they may be: closed, a pipe that nobody reads any more, a full disk, not in UTF-8."""

import io
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, TextIO, cast


class OutputLost(Exception):
    """Standard output takes no more; ``broken`` where its reader has gone, which is no error of anybody's."""

    def __init__(self, error: OSError) -> None:
        super().__init__(error.strerror or str(error))
        self.broken = isinstance(error, BrokenPipeError)


class _Guarded:
    """A text stream whose first failure ends it for good, so that nothing is said of it when Python ends either."""

    def __init__(self, stream: TextIO, *, must_be_heard: bool) -> None:
        if isinstance(stream, io.TextIOWrapper):  # a sign that the terminal has not, or that a file's name is no text
            stream.reconfigure(errors="backslashreplace")
        self._stream = stream
        self._must_be_heard = must_be_heard

    def write(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except OSError as error:
            self._end(error)
            return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError as error:
            self._end(error)

    def _end(self, error: OSError) -> None:
        """What is still in its buffer goes nowhere; where that is an error, raise it."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)
        if self._must_be_heard:
            raise OutputLost(error) from None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def guarded() -> Iterator[None]:
    """Within, a failure of standard output raises :class:`OutputLost`, and one of standard error is passed over.

    Streams that were closed before Python started take nothing either, and their numbers are taken, lest the next file
    that is opened gets them and with it whatever is printed.
    """
    before = sys.stdout, sys.stderr
    taken = os.open(os.devnull, os.O_RDWR)
    while taken <= 2:
        taken = os.dup(taken)
    os.close(taken)
    with ExitStack() as ours:
        out, err = (stream if stream is not None else ours.enter_context(_closed()) for stream in before)
        sys.stdout = cast(TextIO, _Guarded(out, must_be_heard=True))
        sys.stderr = heard = cast(TextIO, _Guarded(err, must_be_heard=False))
        try:
            yield
        finally:
            heard.flush()
            sys.stdout, sys.stderr = before


def _closed() -> TextIO:
    """A stream that can be written to as little as a closed one, and says the same."""
    return os.fdopen(os.open(os.devnull, os.O_RDONLY), "w", encoding="utf-8")
