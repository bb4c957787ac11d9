"""Commands about single runs: presets, simulate, resistance."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from helimag.cli import proofs
from helimag.cli._common import PLAIN, Common
from helimag.cli._drawing import NO_DRAWING, DrawOptions
from helimag.cli._outputs import (
    DATA,
    FIGURE,
    FILM,
    Drawing,
    FigureSize,
    Outputs,
    check_outputs,
    files_report,
    print_files,
    write_outputs,
)
from helimag.cli._shared import (
    Changes,
    ScenarioName,
    accuracy_told,
    degrees,
    leading_words,
    print_json,
    print_warnings,
    progress_bar,
    scenario_from,
    validity_warnings,
)
from helimag.cli.calibration import predict
from helimag.errors import InputError
from helimag.outcomes import Future

if TYPE_CHECKING:
    from helimag.cli._outputs import Format, Writer
    from helimag.orbits import Outlook
    from helimag.runs.trajectory import Trajectory
    from helimag.scenario import Scenario


def presets(
    name: str | None = None, *, schema: Annotated[bool, Parameter(negative="")] = False, common: Common = PLAIN
) -> None:
    """List the presets, or print one as TOML.

    Parameters
    ----------
    name
        A preset to print, every value with its unit and its mark: published, fitted or assumed.
    schema
        Print the JSON schema of scenario files instead.
    """
    from helimag import scenario as scenarios
    from helimag.scenario import load, preset_names

    if schema:
        print_json(scenarios.schema())
    elif name is not None:
        scenario = load(name)
        if common.json:
            print_json(scenario.model_dump(mode="json") | {"hash": scenario.hash})
        else:
            print(scenario.to_toml(), end="")
    elif common.json:
        print_json({"presets": [_preset_report(preset) for preset in preset_names()]})
    else:
        wide = max(map(len, preset_names()))
        for preset in preset_names():
            scenario = load(preset)
            drive = scenario.drive
            speed = sum(v * v for v in drive.velocity) ** 0.5
            print(
                f"{preset:{wide}s}  {drive.frequency:g} Hz, {degrees(drive.pitch):g} deg, {1e3 * drive.distance:g} mm, "
                f"yaw {degrees(drive.yaw_rate):g} deg/s, {1e3 * speed:g} mm/s, {scenario.run.duration:g} s"
            )


def _preset_report(name: str) -> dict[str, Any]:
    from helimag.scenario import load

    scenario = load(name)
    drive = scenario.drive
    return {
        "name": name,
        "frequency_hz": drive.frequency,
        "pitch_deg": degrees(drive.pitch),
        "distance_m": drive.distance,
        "yaw_rate_deg_per_s": degrees(drive.yaw_rate),
        "velocity_m_per_s": list(drive.velocity),
        "duration_s": scenario.run.duration,
        "hash": scenario.hash,
    }


def simulate(
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    duration: str | None = None,
    interval: str | None = None,
    output: Outputs = None,
    size: FigureSize = None,
    method: Literal["multirevolution", "direct"] = "multirevolution",
    device: str = "cpu",
    orbit: bool = True,
    accuracy: bool = True,
    refine: bool = True,
    ensemble: Path | None = None,
    drawing: DrawOptions = NO_DRAWING,
    certificate: Path | None = None,
    common: Common = PLAIN,
) -> None:
    """Run a scenario, judge it, and say what happens after its end.

    Parameters
    ----------
    duration
        How long, such as "100 s", instead of the scenario's own.
    interval
        Time between samples in the result, such as "0.1 s".
    output
        Write the trajectory (.nc), a figure (.png, .svg, .pdf) or a film (.mp4) to this file. May be repeated.
    method
        "multirevolution": leaps over turns of the magnet where the device keeps in step and nothing is near, and direct
        steps elsewhere; or "direct": steps all the way, several times slower where runs are long and steady.
    device
        "cpu", or a CUDA device such as "cuda".
    accuracy
        Whether to run again with finer steps, to say how far to trust the places.
    refine
        Whether to make the run again with finer steps where the device loses step or is drawn into the magnet, which
        multiplies errors; without it the run has steps as those of sweeps have.
    orbit
        Whether to look for the orbit that a run which stayed comes to, and to continue the run where there is none.
    ensemble
        What calibrate wrote: run the scenario with devices from it, and say how likely each outcome is, without
        orbits, accuracy or finer steps.
    certificate
        A proof of the scenario's orbit (helimag orbit ... --prove --certificate), which goes into the netCDF file.
    """
    own = {"run.duration": duration, "run.interval": interval}
    if ensemble is not None:
        _check_for_many(output, certificate)
        check_outputs(None, size=size)
        predict(
            scenario_from(scenario, changes, own), ensemble, drawing, method=method, device=device, json=common.json
        )
        return
    drawing.check_unused()
    from helimag.engine import simulate as run

    check_outputs(output, DATA, FIGURE, FILM, size=size)
    chosen = scenario_from(scenario, changes, own)
    proof = None if certificate is None else proofs.checked_for(certificate, chosen)
    with progress_bar(f"simulating {chosen.title}") as progress:
        trajectory = run(chosen, method=method, device=device, accuracy=accuracy, refine=refine, progress=progress)
    if proof is not None:
        trajectory = proofs.carried(trajectory, proof)
    write_outputs(output, run_writers(trajectory), size=size)
    outlook = None
    if orbit:
        from helimag.orbits import explain

        with progress_bar(f"continuing {chosen.title}") as progress:
            outlook = explain(trajectory, progress=progress)
        told = trajectory.noted(outlook=str(outlook.future), outlook_reason=outlook.text)
        write_outputs([path for path in output or [] if DATA.fits(path)], run_writers(told))
    warnings = validity_warnings(trajectory.attributes)
    print_warnings(warnings)
    if common.json:
        print_json(_report(trajectory) | _outlook_report(outlook) | {"warnings": warnings} | files_report(output))
    else:
        _print_summary(chosen, trajectory)
        if outlook is not None and outlook.future is not Future.GONE:
            print(f"  for all time  {outlook.text}")
        print_files(output)


def run_writers(run: "Trajectory") -> "dict[Format, Writer]":
    """What can be made of a run: its data, a figure, a film."""
    return {
        DATA: run.save,
        FIGURE: Drawing(lambda plots, size: plots.draw_run(run, size=size)),
        FILM: lambda path: _film(run, path),
    }


def _film(run: "Trajectory", path: Path) -> None:
    from helimag import plots

    with progress_bar(f"filming {path.name}") as progress:
        plots.animate(run, path, progress=progress)


def _check_for_many(output: list[Path] | None, certificate: Path | None) -> None:
    """Refuse with --ensemble what is for one run."""
    if output:
        raise InputError("--output writes one run; with --ensemble use --json")
    if certificate is not None:
        raise InputError("--certificate is for one run; leave it out with --ensemble")


def _report(trajectory: "Trajectory") -> dict[str, Any]:
    judgement = trajectory.judgement
    return {
        "gain": judgement.gain,
        "output_y_m": judgement.output,
        "input_u_m": judgement.input,
        "verdict": str(judgement.verdict),
        "reason": judgement.reason,
        "end_time_s": judgement.end_time,
        "escape_time_s": judgement.escape_time,
        "slips": judgement.slips,
        "wobble_deg": degrees(judgement.wobble),
        "attack_angle_deg": degrees(judgement.attack_angle),
        "contacts": [
            {
                "wall": str(touch.wall),
                "count": touch.count,
                "first_s": touch.first,
                "last_s": touch.last,
                "total_s": touch.total,
            }
            for touch in judgement.touches
        ],
        "leads": trajectory.leading_end,
        "leading_cosine": None if math.isnan(trajectory.leading_cosine) else trajectory.leading_cosine,
        "final_state": trajectory.final_state.tolist(),
        "accuracy": accuracy_told(trajectory.attributes),
        "integrator": trajectory.attributes["integrator"],
        "tolerance": trajectory.attributes["tolerance"],
        "share_of_turns_leapt_over": trajectory.attributes.get("share_of_turns_leapt_over", 0.0),
        "wall_time_s": trajectory.attributes["wall_time"],
    }


def _outlook_report(outlook: "Outlook | None") -> dict[str, Any]:
    if outlook is None:
        return {}
    found = outlook.orbit is not None and outlook.orbit.found
    return {
        "outlook": str(outlook.future),
        "outlook_reason": outlook.text,
        "orbit_position_m": outlook.orbit.position.tolist() if outlook.orbit is not None and found else None,
        "orbit_stable": outlook.orbit.stable if outlook.orbit is not None and found else None,
    }


def _print_summary(scenario: "Scenario", trajectory: "Trajectory") -> None:
    judgement = trajectory.judgement
    print(f"{scenario.title}: {judgement.verdict}, {judgement.reason}")
    print(
        f"  gain          {judgement.gain:.3f}  (y {1e3 * judgement.output:.2f} mm, u {1e3 * judgement.input:.2f} mm)"
    )
    print(
        f"  attack angle  {degrees(judgement.attack_angle):.1f} deg, wobble {degrees(judgement.wobble):.1f} deg"
        " over the second half"
    )
    print(f"  leads         {leading_words(trajectory.leading_end, trajectory.leading_cosine)}")
    print(f"  slips         {judgement.slips}")
    told = accuracy_told(trajectory.attributes)
    if told is not None:
        print(f"  accuracy      {told['text']}")
    for touch in judgement.touches:
        print(
            f"  contact       {touch.wall.sentence}: {touch.times}, first at {touch.first:.1f} s, last at "
            f"{touch.last:.1f} s, {touch.total:.1f} s in all"
        )
    guesses = [
        f"{path} {mark.partition(':')[0]}" for path, mark in scenario.provenance.items() if "published" not in mark
    ]
    if guesses:
        print(f"  not published {', '.join(guesses)}")


def resistance(scenario: ScenarioName, *, changes: Changes = None, common: Common = PLAIN) -> None:
    """Print the device's 6x6 resistance about its origin, translation first (SI), and whether it can be true."""
    from helimag import hydrodynamics
    from helimag.hydrodynamics.bounds import enclosing_resistance, violates

    chosen = scenario_from(scenario, changes)
    matrix = hydrodynamics.resistance(chosen.device, chosen.fluid)
    model = chosen.device.hydrodynamics.model
    error = hydrodynamics.error_estimate(chosen.device)
    violated = violates(matrix, enclosing_resistance(chosen.device, chosen.fluid), error)
    if common.json:
        mobility = hydrodynamics.mobility(matrix)
        report = {"resistance": matrix.tolist(), "mobility": mobility.tolist(), "model": model}
        print_json(report | {"error_estimate": error, "bound_violated": violated})
        return
    print(f"{chosen.title}, {model}: force (N), torque (N m) per velocity (m/s), angular velocity (rad/s)")
    for row in matrix:
        print("  ".join(f"{entry:12.4e}" for entry in row))
    if error is not None:
        print(f"estimated error {100.0 * error:.1g} %")
    if violated:
        print('more than the drag of a body that encloses the device, which cannot be; see model = "boundary"')
