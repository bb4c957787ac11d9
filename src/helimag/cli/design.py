"""The command that chooses inputs: design."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from helimag.cli._common import PLAIN, Common
from helimag.cli._drawing import NO_ERRORS, ErrorOptions
from helimag.cli._found_orbits import orbit_report
from helimag.cli._outputs import SCENARIO, Outputs, check_outputs, files_report, print_files, write_outputs
from helimag.cli._shared import (
    Changes,
    ScenarioName,
    input_range,
    print_json,
    progress_bar,
    quantity,
    scenario_from,
    whole,
)

if TYPE_CHECKING:
    from helimag.design import Design
    from helimag.ensembles import Devices
    from helimag.scenario import Scenario


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
    runs: Annotated[int, whole(1, 100_000)] = 200,
    ensemble: Path | None = None,
    errors: ErrorOptions = NO_ERRORS,
    output: Outputs = None,
    common: Common = PLAIN,
) -> None:
    """Find inputs whose orbit is stable with the largest margin, with tolerances that full runs confirm.

    Parameters
    ----------
    speed
        Wanted of the device, such as "0.5 mm/s".
    radius
        Wanted of its circle, such as "12 mm".
    runs
        How many full runs, all inputs off at once, must stay bounded; with --ensemble, how many devices are drawn.
    ensemble
        What calibrate wrote: choose the inputs that most of its devices stay with, instead of tolerances.
    output
        Write the designed scenario (.toml) to this file. May be repeated.
    """
    check_outputs(output, SCENARIO)
    from helimag import quantities
    from helimag.design import design as find_inputs

    chosen = scenario_from(scenario, changes)
    limits = dict(input_range("--limit", chosen, text) for text in limit) if limit else None
    devices = _devices(chosen, ensemble, errors, runs)
    with progress_bar(f"designing {chosen.title}") as progress:
        result = find_inputs(
            chosen,
            speed=None if speed is None else quantity("--speed", speed, quantities.VELOCITY),
            radius=None if radius is None else quantity("--radius", radius, quantities.LENGTH),
            limits=limits,
            devices=devices,
            runs=runs,
            progress=progress,
        )
    write_outputs(output, {SCENARIO: lambda path: _write(result, path)})
    if common.json:
        print_json(_report(result) | files_report(output))
        return
    print(result.text)
    print_files(output)


def _write(result: "Design", path: Path) -> None:
    from helimag.files import replacing

    with replacing(path) as beside:
        beside.write_text(result.scenario.to_toml(), encoding="utf-8")


def _devices(scenario: "Scenario", fit: Path | None, errors: ErrorOptions, count: int) -> "Devices | None":
    """The devices that the inputs are to be good for."""
    if fit is None:
        errors.check_unused()
        return None
    from helimag.calibration import Posterior, drawn

    noise = errors.noise_in(scenario)
    return drawn(Posterior.load(fit), scenario, draws=count, noise=noise, seed=errors.seed or 0)


def _report(result: "Design") -> dict[str, Any]:
    from helimag.scenario import Input

    inputs = {
        path: {
            "value": Input(path).value(result.scenario),
            "tolerance": result.tolerances.get(path),
            "stable_low": interval.low,
            "stable_high": interval.high,
        }
        for path, interval in result.intervals.items()
    }
    share, low, high = result.probability
    verdicts = {str(verdict): count for verdict, count in result.verdicts.items()}
    return {
        "inputs": inputs,
        "runs": verdicts,
        "probability_bounded": {"share": share, "low_95": low, "high_95": high},
        "runs_duration_s": result.duration,
        "on_orbit": result.on_orbit,
        "orbit": orbit_report(result.orbit),
    }
