"""What can go wrong, by name. Each error is also the builtin that fits it, so either can be caught."""

from typing import Self


class HelimagError(Exception):
    """Base of everything helimag raises on purpose."""


class InputError(HelimagError, ValueError):
    """A value, a file's content or a combination of values that helimag cannot use."""


class FileError(HelimagError, OSError):
    """A file that cannot be read or written."""


class RunError(HelimagError, RuntimeError):
    """A run whose numbers broke down although its input was valid."""


class NotFeasible(RunError):
    """A path that an arm in its cell cannot take the magnet along, although its input is valid."""


class MissingExtra(HelimagError, ImportError):
    """An optional dependency that is not installed."""

    @classmethod
    def of(cls, what: str, package: str, extra: str) -> Self:
        """The one sentence for all of them: what needs which package, and the extra that brings it, quoted for zsh.

        Returns
        -------
        MissingExtra
            To be raised.
        """
        return cls(f'{what} needs {package}: in a checkout of helimag, python -m pip install ".[{extra}]"')
