"""The command line in this process, as every test runs it: what it said, and that no refusal cost a kernel."""

import contextlib
import io
import sys
import warnings
from typing import NamedTuple

import pytest
import warp

from helimag.cli import main


class Said(NamedTuple):
    """Exit status, stdout and stderr."""

    status: int
    out: str
    err: str


def run(*words: object, refused_by_a_run: bool = False) -> Said:
    """Run ``helimag`` with these words.

    Bad input must be refused before any kernel is built or loaded, whether or not this machine has compiled it before.
    That is checked for every command that ends with status 2, but for those that a run's own result refuses.
    """
    out, err = io.StringIO(), io.StringIO()
    status, loaded = 0, []
    load = warp.Module.load

    def noted(module: warp.Module, *given: object, **named: object) -> object:
        loaded.append(module.name)
        return load(module, *given, **named)

    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Cyclopts application invoked without tokens")  # as from a shell, on purpose
        patch.setattr(warp.Module, "load", noted)
        patch.setattr(sys, "argv", ["helimag", *(str(word) for word in words)])
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                main()
            except SystemExit as end:
                status = int(end.code or 0)
    if status == 2 and loaded and not refused_by_a_run:
        pytest.fail(f"refused only after loading {loaded[0]}: {err.getvalue()}")
    return Said(status, out.getvalue(), err.getvalue())
