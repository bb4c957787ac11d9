"""The command that finds and follows orbits, orbit, with map, flow, basin and against beside it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from helimag.cli import orbit_against, orbit_grids, proofs
from helimag.cli._common import PLAIN, Common
from helimag.cli._found_orbits import print_branches, print_orbit, print_orbits
from helimag.cli._outputs import DATA, FIGURE, Drawing, FigureSize, Outputs, check_outputs, stored, write_outputs
from helimag.cli._shared import Changes, ScenarioName, print_warnings, progress_bar, scenario_from
from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.cli._outputs import Format, Writer
    from helimag.orbits import Branch, Orbit
    from helimag.scenario import Scenario

app = App(name="orbit")
app.command(orbit_grids.map_, name="map")
app.command(orbit_grids.flow)
app.command(orbit_grids.basin)
app.command(orbit_against.against)
app.command(proofs.check)


@app.default
def orbit(
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    every: Annotated[bool, Parameter(name="--all", negative="")] = False,
    vary: str | None = None,
    start: Annotated[str | None, Parameter(name="--from", allow_leading_hyphen=True)] = None,
    stop: Annotated[str | None, Parameter(name="--to", allow_leading_hyphen=True)] = None,
    prove: Annotated[bool, Parameter(negative="")] = False,
    tolerance: Annotated[bool, Parameter(negative="")] = False,
    certificate: Path | None = None,
    output: Outputs = None,
    size: FigureSize = None,
    common: Common = PLAIN,
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
    prove
        Prove by enclosures that the orbit exists and attracts, for all time: a theorem about the model.
    tolerance
        Look for how far frequency, pitch, distance and weight may be off, all at once, and prove that: some minutes.
    certificate
        Write the certificate of the proof to this file (.json); with --tolerance that of the box of inputs.
    output
        Write a figure (.png, .svg, .pdf) or the data (.nc) of what was found to this file. May be repeated.
    """
    _check_options(every, vary, start, stop)
    check_outputs(output, FIGURE, DATA, size=size)
    proofs.check_options(prove, certificate, tolerance, every or vary is not None)
    from helimag import orbits

    chosen = scenario_from(scenario, changes)
    if prove:
        proofs.check_provable(chosen)
    limits = _limits(chosen, vary, start, stop)
    if every:
        with progress_bar(f"searching orbits of {chosen.title}") as progress:
            found = orbits.list_orbits(chosen, progress=progress)
        warnings = _warnings(chosen, [])
        print_warnings(warnings)
        print_orbits(chosen, found, _write_orbits(output, found, size), warnings, common.json)
        if not found and not common.json:
            print(f"  {orbits.find_orbit(chosen).text}")
        return
    if vary is None or limits is None:
        with progress_bar(f"searching the orbit of {chosen.title}") as progress:
            result = orbits.find_orbit(chosen, progress=progress)
        warnings = _warnings(chosen, [])
        print_warnings(warnings)
        proof = proofs.proved(result, certificate) if prove else None
        box = None
        if proof is not None and tolerance:
            with progress_bar("proving a box of inputs") as progress:
                box = proofs.tolerated(proof, certificate, progress)
        files = _write_orbits(output, [result] if result.found else [], size)
        print_orbit(result, files, warnings, common.json, proof, box)
        return
    with progress_bar(f"following orbits through {vary}") as progress:
        watch = orbits.Watch(progress)
        result = orbits.find_orbit(chosen, progress=watch.part(0.0, 0.1))
        branches = orbits.all_branches(result, vary, *limits, progress=watch.part(0.1, 1.0))
    files = (output or []) if branches else []
    write_outputs(files, _branch_writers(branches), size=size)
    warnings = _warnings(chosen, branches)
    print_warnings(warnings)
    print_branches(result, vary, branches, files, warnings, common.json)


def _branch_writers(branches: "list[Branch]") -> "dict[Format, Writer]":
    from helimag import orbits

    return {
        FIGURE: Drawing(lambda plots, size: plots.draw_branches(branches, size=size)),
        DATA: stored(lambda: orbits.branches_dataset(branches)),
    }


def _write_orbits(output: list[Path] | None, found: "list[Orbit]", size: FigureSize) -> list[Path]:
    """Draw or store orbits; the files written, none where there is no orbit."""
    from helimag import orbits

    files = (output or []) if found else []
    write_outputs(
        files,
        {
            FIGURE: Drawing(lambda plots, size: plots.draw_orbits(found, size=size)),
            DATA: stored(lambda: orbits.orbits_dataset(found)),
        },
        size=size,
    )
    return files


def _warnings(scenario: "Scenario", branches: "list[Branch]") -> list[dict[str, Any]]:
    """What does not hold for a scenario and along branches."""
    from helimag.checks import cautions
    from helimag.scenario import Input

    given = [(scenario, "the scenario's own inputs")]
    for branch in branches:
        shown = Input(branch.path).show
        given += [(point.orbit.scenario, f"{branch.path} = {shown(scenario, point.value)}") for point in branch.points]
    found = cautions((each for each, _ in given), lambda run: given[run][1])
    return [caution.as_dict() for caution in found]


def _check_options(every: bool, vary: str | None, start: str | None, stop: str | None) -> None:
    if every and vary is not None:
        raise InputError("--all lists the orbits of one scenario, --vary follows them: leave one of them out")
    if vary is None and (start is not None or stop is not None):
        raise InputError("--from and --to need --vary with the input that they limit, such as --vary drive.pitch")
    if vary is not None and (start is None or stop is None):
        raise InputError(
            "--vary needs --from and --to with the range of the input, such as --from '8 deg' --to '18 deg'"
        )


def _limits(scenario: "Scenario", vary: str | None, start: str | None, stop: str | None) -> tuple[float, float] | None:
    """The range of the input that ``--vary`` names (SI); None without ``--vary``."""
    from helimag.scenario import Input

    if vary is None or start is None or stop is None:
        return None
    given = Input(vary)
    low, high = given.read(scenario, start), given.read(scenario, stop)
    if not low < high:
        raise InputError(f"--from must be below --to; got {given.show(scenario, low)} and {given.show(scenario, high)}")
    return low, high
