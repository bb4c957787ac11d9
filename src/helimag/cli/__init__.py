"""The command line. Thin: a command's module imports what it needs only when it runs, so that --help is instant."""

import sys

from cyclopts import App, CycloptsError

from helimag.cli import checks, compare, design, orbits, pictures, robot, runs, sweeps, vision
from helimag.cli._streams import OutputLost, guarded
from helimag.errors import HelimagError, RunError

app = App(
    name="helimag",
    help="Simulate and judge open-loop runs of magnetic helical devices under a rotating permanent magnet.",
    version_flags=["--version"],
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
COMMANDS = (
    runs.presets,
    runs.simulate,
    sweeps.sweep,
    orbits.app,
    design.design,
    pictures.plot,
    pictures.reproduce,
    runs.resistance,
    robot.app,
    vision.app,
    compare.compare,
    checks.doctor,
    checks.cite,
)
for command in COMMANDS:
    app.command(command)


def main() -> None:
    """Run the command line: exit status 0 done, 1 a run failed or an arm cannot make it, 2 bad input."""
    with guarded():
        status = _status()
    sys.exit(status or None)


def _status() -> int:
    """What the process ends with, everything said."""
    try:
        try:
            app(exit_on_error=False, print_error=False)
        finally:
            sys.stdout.flush()
    except RunError as error:
        return _said(str(error), 1)
    except HelimagError as error:
        return _said(str(error), 2)
    except CycloptsError as error:
        return _said(str(error), 2)
    except KeyboardInterrupt:
        return _said("interrupted", 130)
    except OutputLost as lost:
        return 1 if lost.broken else _said(f"standard output cannot be written: {lost}", 2)
    return 0


def _said(message: str, status: int) -> int:
    print("helimag: " + " ".join(message.split()), file=sys.stderr)
    return status
