"""Commands about orbits: orbit with map, flow and basin beside it, and design."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from helimag.cli import orbit_against, orbit_grids
from helimag.cli._orbit_reports import files_report, print_files
from helimag.cli._shared import (
    Changes,
    Json,
    Outputs,
    ScenarioName,
    check_outputs,
    check_target,
    degrees,
    input_range,
    print_json,
    print_warnings,
    progress_bar,
    quantity,
    scenario_from,
    write_outputs,
)
from helimag.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from helimag.orbits import Branch, Orbit
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
    if every and vary is not None:
        raise InputError("--all lists the orbits of one scenario, --vary follows them: leave one of them out")
    if output and vary is None:
        raise InputError("--output draws orbits along an input: name it with --vary")
    check_outputs(output)
    from helimag import orbits

    chosen = scenario_from(scenario, changes)
    limits = _limits(chosen, vary, start, stop)
    if every:
        with progress_bar(f"searching orbits of {chosen.name}") as progress:
            found = orbits.list_orbits(chosen, progress=progress)
        warnings = _warnings(chosen, [])
        print_warnings(warnings)
        _print_all(chosen, found, warnings, json)
        if not found and not json:
            print(f"  {orbits.find_orbit(chosen).text}")
        return
    with progress_bar(f"searching the orbit of {chosen.name}") as progress:
        result = orbits.find_orbit(chosen, progress=progress)
    if vary is None or limits is None:
        warnings = _warnings(chosen, [])
        print_warnings(warnings)
        _print_one(result, warnings, json)
        return
    with progress_bar(f"following orbits through {vary}") as progress:
        branches = _branches(result, vary, *limits, progress)
    if branches:
        write_outputs(output, lambda plots: plots.draw_branches(branches), lambda: orbits.branches_dataset(branches))
    warnings = _warnings(chosen, branches)
    print_warnings(warnings)
    _print_branches(result, vary, branches, output, warnings, json)


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


def _limits(scenario: "Scenario", vary: str | None, start: str | None, stop: str | None) -> tuple[float, float] | None:
    """The range of the input that ``--vary`` names (SI); None without ``--vary``."""
    from helimag.scenario import Input

    if vary is None:
        if start is not None or stop is not None:
            raise InputError("--from and --to need --vary with the input that they limit, such as --vary drive.pitch")
        return None
    if start is None or stop is None:
        raise InputError(
            "--vary needs --from and --to with the range of the input, such as --from '8 deg' --to '18 deg'"
        )
    given = Input(vary)
    low, high = given.read(scenario, start), given.read(scenario, stop)
    if not low < high:
        show = (given.show(scenario, value) for value in (low, high))
        raise InputError("--from must be below --to; got {} and {}".format(*show))
    return low, high


def _branches(
    orbit: "Orbit", path: str, low: float, high: float, progress: "Callable[[float], None]"
) -> "list[Branch]":
    """The branch of the scenario's own orbit, and all others that are stable somewhere in the range."""
    from helimag import orbits
    from helimag.scenario import Input

    own = []
    if orbit.found and Input(path).within(orbit.scenario, low, high):
        own = [orbits.follow(orbit, path, low, high, progress=lambda done: progress(0.3 * done))]
    stable = orbits.survey(orbit.scenario, path, low, high, known=own, progress=lambda done: progress(0.3 + 0.7 * done))
    return own + [branch for branch in stable if branch not in own]


def design(
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    speed: str | None = None,
    radius: str | None = None,
    limit: Annotated[
        list[str] | None,
        Parameter(
            name="--limit",
            negative="",
            consume_multiple=False,
            help='An input to choose with its range, such as --limit drive.pitch="5 deg..15 deg". May be repeated.',
        ),
    ] = None,
    runs: int = 200,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    json: Json = False,
) -> None:
    """Find inputs whose orbit is stable with the largest margin, with tolerances that full runs confirm.

    Parameters
    ----------
    speed
        Wanted of the device, such as "0.5 mm/s".
    radius
        Wanted of its circle, such as "12 mm".
    runs
        How many full runs, all inputs off at once, must stay bounded.
    output
        Write the designed scenario to this TOML file.
    """
    if output is not None:
        check_target(output)
    from helimag import quantities
    from helimag.design import design as find_inputs
    from helimag.files import replacing
    from helimag.scenario import Input

    chosen = scenario_from(scenario, changes)
    limits = dict(input_range("--limit", chosen, text) for text in limit) if limit else None
    with progress_bar(f"designing {chosen.name}") as progress:
        result = find_inputs(
            chosen,
            speed=None if speed is None else quantity("--speed", speed, quantities.VELOCITY),
            radius=None if radius is None else quantity("--radius", radius, quantities.LENGTH),
            limits=limits,
            runs=runs,
            progress=progress,
        )
    if output is not None:
        with replacing(output) as beside:
            beside.write_text(result.scenario.to_toml(), encoding="utf-8")
    if not json:
        print(result.text)
        if output is not None:
            print(f"written to {output}")
        return
    inputs = {
        path: {
            "value": Input(path).value(result.scenario),
            "tolerance": half,
            "stable_low": result.intervals[path].low,
            "stable_high": result.intervals[path].high,
        }
        for path, half in result.tolerances.items()
    }
    verdicts = {str(verdict): count for verdict, count in result.verdicts.items()}
    print_json(
        {"inputs": inputs, "runs": verdicts, "runs_duration_s": result.duration, "on_orbit": result.on_orbit}
        | {"orbit": _report(result.orbit)}
    )


def _report(orbit: "Orbit") -> dict[str, Any]:
    return {
        "found": orbit.found,
        "stable": orbit.stable,
        "status": str(orbit.status),
        "reason": orbit.text,
        "position_m": orbit.position.tolist() if orbit.found else None,
        "state": orbit.state.tolist() if orbit.found else None,
        "multipliers": [[m.real, m.imag] for m in orbit.multipliers],
        "rates_per_s": [[r.real, r.imag] for r in orbit.rates],
        "attack_angle_deg": degrees(orbit.attack_angle) if orbit.found else None,
        "wobble_deg": degrees(orbit.wobble) if orbit.found else None,
        "radius_m": orbit.radius if math.isfinite(orbit.radius) else None,
        "speed_m_per_s": orbit.speed if orbit.found else None,
        "position_error_m": orbit.position_error if math.isfinite(orbit.position_error) else None,
    }


def _print_one(orbit: "Orbit", warnings: list[dict[str, Any]], json: bool) -> None:
    if json:
        print_json(_report(orbit) | {"warnings": warnings})
        return
    print(f"{orbit.scenario.title}: {orbit.text}")
    if orbit.found:
        rates = ", ".join(_shown(rate) for rate in orbit.rates if rate.imag >= 0.0)
        print(f"  rates         {rates} per second")
        print(
            f"  attack angle  {degrees(orbit.attack_angle):.1f} deg, wobble {degrees(orbit.wobble):.1f} deg over a turn"
        )
        circle = f"radius {1e3 * orbit.radius:.2f} mm, " if math.isfinite(orbit.radius) else ""
        print(f"  path          {circle}speed {1e3 * orbit.speed:.3f} mm/s")
        print(f"  place         known to {1e9 * orbit.position_error:.1g} nm in the integration")


def _shown(rate: complex) -> str:
    return f"{rate.real:.4g} ± {rate.imag:.4g}i" if rate.imag > 0.0 else f"{rate.real:.4g}"


def _print_all(scenario: "Scenario", found: "list[Orbit]", warnings: list[dict[str, Any]], json: bool) -> None:
    if json:
        print_json({"orbits": [_report(orbit) for orbit in found], "warnings": warnings})
        return
    print(f"{scenario.title}: {len(found)} orbits found")
    for orbit in found:
        print(f"  {orbit.text}")


def _print_branches(
    orbit: "Orbit",
    path: str,
    branches: "list[Branch]",
    output: list[Path] | None,
    warnings: list[dict[str, Any]],
    json: bool,
) -> None:
    from helimag import orbits

    segments = [segment for branch in branches for segment in orbits.stable_segments(branch)]
    if json:
        intervals = [{"low": s.low, "high": s.high, "why_low": s.why_low, "why_high": s.why_high} for s in segments]
        print_json(
            {
                "input": path,
                "stable_intervals": intervals,
                "branches": [_branch_report(branch) for branch in branches],
                "warnings": warnings,
            }
            | files_report(output if branches else None)
        )
        return
    print(f"{orbit.scenario.title}: {orbit.text}")
    for segment in segments:
        print(f"  {segment.text}")
    if not segments:
        print("  nowhere stable in this range, as far as the search goes")
    for branch in branches:
        print("  branch " + branch.text.replace("\n", "\n  "))
    print_files(output if branches else None)


def _branch_report(branch: "Branch") -> dict[str, Any]:
    return {
        "changes": [{"kind": str(event.kind), "value": event.value} for event in branch.events],
        "ends": list(branch.ends),
        "points": [
            {
                "value": point.value,
                "position_m": point.orbit.position.tolist(),
                "stable": point.orbit.stable,
                "leading_rate_per_s": [point.orbit.rates[0].real, point.orbit.rates[0].imag],
            }
            for point in branch.points
        ],
    }
