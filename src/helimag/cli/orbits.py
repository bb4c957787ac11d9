"""The command that finds and follows orbits, orbit, with map, flow, basin and against beside it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from helimag.cli import orbit_against, orbit_grids
from helimag.cli._found_orbits import print_branches, print_orbit, print_orbits
from helimag.cli._shared import (
    Changes,
    Json,
    Outputs,
    ScenarioName,
    check_outputs,
    progress_bar,
    scenario_from,
    write_outputs,
)
from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.scenario import Scenario

app = App(name="orbit")
app.command(orbit_grids.map_, name="map")
app.command(orbit_grids.flow)
app.command(orbit_grids.basin)
app.command(orbit_against.against)


@app.default
def orbit(
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    every: Annotated[bool, Parameter(name="--all", negative="")] = False,
    vary: str | None = None,
    start: Annotated[str | None, Parameter(name="--from", allow_leading_hyphen=True)] = None,
    stop: Annotated[str | None, Parameter(name="--to", allow_leading_hyphen=True)] = None,
    output: Outputs = None,
    json: Json = False,
) -> None:
    """Find the orbit that a run settles on, whether it is stable, and over which inputs.

    Parameters
    ----------
    every
        List all orbits that a grid of starts around the magnet leads to.
    vary
        Follow orbits through this input, such as drive.pitch: the scenario's own, and all that are stable in the range.
    start
        Lowest value of that input, such as "8 deg".
    stop
        Highest value.
    """
    _check_options(every, vary, start, stop, output)
    check_outputs(output)
    from helimag import orbits

    chosen = scenario_from(scenario, changes)
    if every:
        with progress_bar(f"searching orbits of {chosen.name}") as progress:
            found = orbits.list_orbits(chosen, progress=progress)
        print_orbits(chosen, found, json)
        if not found and not json:
            print(f"  {orbits.find_orbit(chosen).text}")
        return
    if vary is None or start is None or stop is None:
        with progress_bar(f"searching the orbit of {chosen.name}") as progress:
            result = orbits.find_orbit(chosen, progress=progress)
        print_orbit(result, json)
        return
    low, high = _range(chosen, vary, start, stop)
    with progress_bar(f"following orbits through {vary}") as progress:
        watch = orbits.Watch(progress)
        result = orbits.find_orbit(chosen, progress=watch.part(0.0, 0.1))
        branches = orbits.all_branches(result, vary, low, high, progress=watch.part(0.1, 1.0))
    if branches:
        write_outputs(output, lambda plots: plots.draw_branches(branches), lambda: orbits.branches_dataset(branches))
    print_branches(result, vary, branches, output, json)


def _check_options(
    every: bool, vary: str | None, start: str | None, stop: str | None, output: list[Path] | None
) -> None:
    if every and vary is not None:
        raise InputError("--all lists the orbits of one scenario, --vary follows them: leave one of them out")
    if output and vary is None:
        raise InputError("--output draws orbits along an input: name it with --vary")
    if vary is None and (start is not None or stop is not None):
        raise InputError("--from and --to need --vary with the input that they limit, such as --vary drive.pitch")
    if vary is not None and (start is None or stop is None):
        raise InputError(
            "--vary needs --from and --to with the range of the input, such as --from '8 deg' --to '18 deg'"
        )


def _range(scenario: "Scenario", path: str, start: str, stop: str) -> tuple[float, float]:
    """Ends of an input's range (SI), as --from and --to say."""
    from helimag.scenario import Input

    given = Input(path)
    low, high = given.read(scenario, start), given.read(scenario, stop)
    if not low < high:
        raise InputError(f"--from must be below --to; got {given.show(scenario, low)} and {given.show(scenario, high)}")
    return low, high
