"""The command line. Thin: a command's module imports what it needs only when it runs, so that --help is instant."""

import sys

from cyclopts import App, CycloptsError

from helimag.cli import checks, compare, design, orbits, pictures, robot, runs, sweeps, vision
from helimag.errors import HelimagError, RunError

app = App(
    name="helimag",
    help="Simulate and judge open-loop runs of magnetic helical devices under a rotating permanent magnet.",
    version_flags=["--version"],
    result_action="return_value",
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
    """Run the command line: exit status 0 done, 1 a run failed, 2 bad input."""
    try:
        app(exit_on_error=False, print_error=False)
    except RunError as error:
        _fail(str(error), 1)
    except HelimagError as error:
        _fail(str(error), 2)
    except CycloptsError as error:
        _fail(" ".join(str(error).split()), 2)
    except KeyboardInterrupt:
        _fail("interrupted", 130)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(1)


def _fail(message: str, status: int) -> None:
    print("helimag: " + " ".join(message.split()), file=sys.stderr)
    sys.exit(status)
