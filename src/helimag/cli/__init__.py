"""The command line. Thin: a command's module imports what it needs only when it runs, so that --help is instant."""

import errno
import gc
import os
import sys

from cyclopts import App, CycloptsError, UnusedCliTokensError

from helimag.cli import calibration, checks, compare, design, orbits, pictures, robot, runs, studio, sweeps, vision
from helimag.cli._common import common_of, speaking
from helimag.cli._outputs import check_not_read
from helimag.cli._streams import OutputLost, guarded
from helimag.errors import HelimagError, RunError

# what the system says of a path that the user gave, wherever it is first looked at
WRITTEN = "values with units are one word, in quotes: --duration '5 s', --set drive.pitch='12 deg'; see --help"
PATH_ERRORS = {errno.ENAMETOOLONG, errno.ELOOP, errno.EACCES, errno.EPERM, errno.ENOTDIR}
ALLOCATIONS = 200_000  # between looks for garbage: imports make none (benchmarks/start_up.py has what looking costs)
LONGEST_SHOWN = 80  # characters of such a path
app = App(
    name="helimag",
    help="Simulate and judge open-loop runs of magnetic helical devices under a rotating permanent magnet. "
    "To begin with: helimag simulate paper/fig3c, or helimag studio.",
    version_flags=["--version"],
    version_format="plaintext",
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
COMMANDS = (
    runs.presets,
    runs.simulate,
    sweeps.sweep,
    orbits.app,
    design.design,
    calibration.calibrate,
    pictures.plot,
    pictures.reproduce,
    runs.resistance,
    robot.app,
    vision.app,
    compare.compare,
    studio.studio,
    checks.doctor,
    checks.cite,
)
for command in COMMANDS:
    app.command(command)
app.register_install_completion_command(
    help="Teach bash, zsh or fish to complete commands and options: writes a file, adds a line to .bashrc."
)


def main() -> None:
    """Run the command line: exit status as in docs/reference/commands.md."""
    gc.set_threshold(ALLOCATIONS)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # it would look for some in each installed package
    with guarded():
        status = _status()
    gc.freeze()  # Python would look for garbage among all that was imported, to no end but that of the process
    sys.exit(status or None)


def _status() -> int:
    """What the process ends with, everything said."""
    try:
        try:
            command, bound, _ = app.parse_args(exit_on_error=False, print_error=False)
            check_not_read(bound)
            with speaking(common_of(bound)):
                command(*bound.args, **bound.kwargs)
        finally:
            sys.stdout.flush()
    except RunError as error:
        return _said(str(error), 1)
    except HelimagError as error:
        return _said(str(error), 2)
    except UnusedCliTokensError as error:
        spare = " ".join(repr(token) for token in error.unused_tokens or ())
        return _said(f"nothing takes {spare}; {WRITTEN}", 2)
    except CycloptsError as error:
        return _said(str(error), 2)
    except OSError as error:
        if error.errno not in PATH_ERRORS:
            raise
        name = str(error.filename)
        shown = name if len(name) <= LONGEST_SHOWN else f"{name[:LONGEST_SHOWN]}..."
        return _said(f"'{shown}' cannot be used as a path: {error.strerror}", 2)
    except KeyboardInterrupt as stop:
        return _said("; ".join(["interrupted", *map(str, stop.args)]), 130)
    except OutputLost as lost:
        return 1 if lost.broken else _said(f"standard output cannot be written: {lost}", 2)
    return 0


def _said(message: str, status: int) -> int:
    print("helimag: " + " ".join(message.split()), file=sys.stderr)
    return status
