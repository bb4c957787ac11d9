"""What every command offers, --json, --quiet and --verbose, and what they do to all that a command prints.

A command takes them as its last parameter, ``common: Common = PLAIN``, and asks ``common.json`` only; the rest happens
around it, in :func:`speaking`. ``tests/test_cli_common.py`` walks over all commands.
"""

import io
import logging
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from inspect import BoundArguments
from typing import Annotated

from cyclopts import Parameter

from helimag.errors import InputError

LOG = logging.getLogger("helimag")  # the rooms' own loggers hang below it


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Common:
    """How a command speaks."""

    json: Annotated[
        bool, Parameter(name="--json", negative="", help="Print one JSON object on stdout and nothing else.")
    ] = False
    quiet: Annotated[
        bool, Parameter(name="--quiet", negative="", help="Print nothing but errors; with --json, the object.")
    ] = False
    verbose: Annotated[
        bool,
        Parameter(
            name="--verbose", negative="", help="Say on stderr what is done, with what, and how long each step takes."
        ),
    ] = False


PLAIN = Common()


def common_of(bound: BoundArguments) -> Common:
    """The common options among a command's arguments; of what has none, such as --help, how it speaks by default."""
    return next((value for value in bound.arguments.values() if isinstance(value, Common)), PLAIN)


@contextmanager
def speaking(common: Common) -> Iterator[None]:
    """Within, what is printed and logged is as these options say; errors are printed by whoever is outside.

    Raises
    ------
    InputError
        Where a command is to say more and nothing.
    """
    if common.quiet and common.verbose:
        raise InputError("--quiet and --verbose contradict each other: leave one of them out")
    with ExitStack() as stack:
        if common.quiet:
            stack.enter_context(redirect_stderr(_Nowhere()))
            if not common.json:
                stack.enter_context(redirect_stdout(_Nowhere()))
        if common.verbose:
            stack.enter_context(_telling())
        yield


class _Nowhere(io.TextIOBase):
    """A stream that keeps nothing."""

    def write(self, text: str) -> int:
        return len(text)


@contextmanager
def _telling() -> Iterator[None]:
    """Send to stderr what the rooms log, and how long all of it took."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("helimag: %(message)s"))
    before, begun = LOG.level, time.monotonic()
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)
    try:
        yield
        LOG.info("%.2f s in all", time.monotonic() - begun)
    finally:
        LOG.setLevel(before)
        LOG.removeHandler(handler)
