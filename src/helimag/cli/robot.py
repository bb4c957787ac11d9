"""Commands about the arm: robot program, check, read-back, replay, jitter."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from helimag.cli._shared import Changes, Json, ScenarioName, print_json, progress_bar, scenario_from
from helimag.errors import FileError, InputError

if TYPE_CHECKING:
    from helimag.robot import Plan
    from helimag.runs.trajectory import Trajectory
    from helimag.scenario import Scenario

app = App(name="robot", help="From a scenario to a programme that an arm can run, and back from what an arm did.")

CellFile = Annotated[Path | None, Parameter(name="--cell", help="TOML file of the cell; without it, the default cell.")]
Unwind = Annotated[
    bool, Parameter(name="--unwind", negative="", help="Let axis 6 turn back in place where it runs into its limit.")
]


@app.command
def check(
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    cell: CellFile = None,
    unwind: Unwind = False,
    figure: Path | None = None,
    json: Json = False,
) -> None:
    """Report whether the arm can take the magnet along a scenario's path, and if not, when and why not.

    Parameters
    ----------
    figure
        Draw joints and limits over time into this file; the cell in 3-D goes beside it, named with -cell.
    """
    from helimag import robot

    plan = _plan(scenario_from(scenario, changes), cell, unwind)
    found = robot.report(plan)
    if not plan.feasible and not unwind and found["offence"]["joint"] == "A6":
        other = _plan(plan.scenario, cell, True)
        found["with_unwinding"] = {
            "feasible": other.feasible,
            "unwindings": len(other.unwindings),
            "duration_s": other.duration,
        }
    if figure is not None:
        _draw(plan, figure)  # names the files on stderr
    if json:
        print_json(found)
    else:
        _print_report(found)


@app.command
def program(
    scenario: ScenarioName,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    changes: Changes = None,
    cell: CellFile = None,
    unwind: Unwind = False,
    name: str | None = None,
    accept_unbounded: Annotated[bool, Parameter(negative="")] = False,
    spline: Annotated[bool, Parameter(negative="")] = False,
    json: Json = False,
) -> None:
    """Write the programme of a scenario: KRL, a RoboDK script, the timed path, the motor's set-points.

    Parameters
    ----------
    output
        Folder for the files.
    name
        Name of the programme; default made of the scenario's name.
    accept_unbounded
        Write although the simulated run is not bounded; the header then warns.
    spline
        Write SLIN and SCIRC instead of LIN and CIRC.
    """
    from helimag import robot
    from helimag.robot.krl.writer import checked_name

    if name is not None:
        checked_name(name)
    plan = _plan(scenario_from(scenario, changes), cell, unwind)
    robot.feasible_or_refused(plan)
    run = _simulated(_as_programmed(plan))
    written = robot.write_programme(
        plan,
        output,
        verdict=str(run.verdict),
        reason=run.judgement.reason,
        name=name,
        accept_unbounded=accept_unbounded,
        spline=spline,
    )
    if json:
        print_json({"files": [str(path) for path in written], "verdict": str(run.verdict), **robot.report(plan)})
        return
    print(f"{plan.scenario.name}: {run.verdict}, {run.judgement.reason}")
    print(f"  expected duration {plan.duration:.1f} s, {len(plan.unwindings)} unwindings")
    for path in written:
        print(f"  {path}")


@app.command(name="read-back")
def read_back(
    source: Path,
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    cell: CellFile = None,
    unwind: Unwind = False,
    json: Json = False,
) -> None:
    """Interpret a KRL programme and compare it with the plan of its scenario; exit status 1 where they differ.

    Parameters
    ----------
    source
        The .src file; its .dat file is looked for beside it.
    """
    from helimag import robot
    from helimag.errors import RunError

    plan = _plan(scenario_from(scenario, changes), cell, unwind)
    found = robot.deviation(plan, robot.play(*_krl(source), plan.cell.arm))
    if json:
        print_json(
            {
                "position_m": found.position,
                "axis_rad": found.axis,
                "timing": found.timing,
                "duration_s": found.duration,
                "planned_duration_s": plan.duration,
                "acceptable": found.acceptable,
            }
        )
    else:
        print(f"{source} against the plan of {plan.scenario.name}")
        print(f"  position  within {1e6 * found.position:.3f} um")
        print(f"  axis      within {found.axis:.2e} rad")
        print(
            f"  timing    within {100.0 * found.timing:.4f} %  ({found.duration:.2f} s, planned {plan.duration:.2f} s)"
        )
    if not found.acceptable:
        raise RunError(
            f"{source} is not the programme of this scenario and cell: it differs by more than 1 um, 1e-6 rad or 0.1 %"
        )


@app.command
def replay(
    log: Path,
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    cell: CellFile = None,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    json: Json = False,
) -> None:
    """Simulate what the device would have done under what the arm really did.

    Parameters
    ----------
    log
        Measured poses (.csv, with units and frames), or a KRL programme (.src) to run on paper.
    output
        Write the trajectory to this netCDF file.
    """
    from helimag.robot.logs import replayed

    chosen = scenario_from(scenario, changes)
    run = _simulated(replayed(chosen, _log(log, chosen, cell), log.name))
    planned = _simulated(chosen)
    if output is not None:
        run.save(output)
    if json:
        print_json({"replayed": _judged(run), "planned": _judged(planned)})
        return
    print(f"{log.name}: {run.verdict}, {run.judgement.reason}; gain {run.gain:.3f}")
    print(f"{chosen.name} as planned: {planned.verdict}, {planned.judgement.reason}; gain {planned.gain:.3f}")


@app.command
def jitter(
    scenario: ScenarioName,
    spectrum: Path,
    *,
    changes: Changes = None,
    cell: CellFile = None,
    draws: int = 4,
    seed: int = 0,
    json: Json = False,
) -> None:
    """Find what errors of arm and motor do to the gain.

    Parameters
    ----------
    spectrum
        A TOML file of errors (assumed), or a log of measured poses (.csv) to take them from.
    draws
        Runs for each kind of error, with other phases.
    seed
        Of the phases.
    """
    from helimag.robot.jitter import load_jitter, measured_jitter, study
    from helimag.robot.logs import read_log

    if draws < 1:
        raise InputError(f"--draws must be 1 or more; got {draws}")
    chosen = scenario_from(scenario, changes)
    if spectrum.suffix == ".csv":
        errors = measured_jitter(chosen, read_log(spectrum, _cell(cell)), spectrum.name)
    else:
        errors = load_jitter(spectrum)
    with progress_bar(f"simulating {chosen.name} with errors") as progress:
        outcomes = study(chosen, errors, draws=draws, seed=seed, progress=progress)
    if json:
        rows = [{"kind": o.kind, "gains": list(o.gains), "verdicts": list(o.verdicts)} for o in outcomes]
        print_json({"source": errors.source, "outcomes": rows})
        return
    print(f"{chosen.name}, errors {errors.source}")
    for outcome in outcomes:
        counts = ", ".join(
            f"{outcome.verdicts.count(verdict)} {verdict}" for verdict in dict.fromkeys(outcome.verdicts)
        )
        print(f"  {outcome.kind:16s} gain {outcome.mean:.4f} +- {outcome.spread:.4f}   {counts}")


def _cell(path: Path | None) -> Any:
    from helimag.robot import load_cell

    return load_cell(path)


def _plan(scenario: "Scenario", cell: Path | None, unwind: bool) -> "Plan":
    from helimag import robot

    return robot.plan(scenario, _cell(cell), unwind=unwind)


def _as_programmed(plan: "Plan") -> "Scenario":
    """The scenario as its programme runs it: with the unwindings, where there are any."""
    from helimag.robot.logs import log_of, replayed
    from helimag.robot.timed import timed_table

    if not plan.unwindings:
        return plan.scenario
    lasting = plan.scenario.replaced({"run.duration": plan.duration})
    return replayed(lasting, log_of(timed_table(plan), plan.reversed_axis), "the programme's own path")


def _simulated(scenario: "Scenario") -> "Trajectory":
    from helimag.engine.simulation import simulate

    with progress_bar(f"simulating {scenario.name}") as progress:
        return simulate(scenario, progress=progress)


def _judged(run: "Trajectory") -> dict[str, Any]:
    judgement = run.judgement
    return {
        "gain": judgement.gain,
        "verdict": str(judgement.verdict),
        "reason": judgement.reason,
        "end_time_s": judgement.end_time,
        "final_state": run.final_state.tolist(),
    }


def _krl(source: Path) -> tuple[str, str]:
    texts = []
    for path in (source, source.with_suffix(".dat")):
        try:
            texts.append(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            if path == source:
                raise FileError(f"there is no file '{path}'") from None
            texts.append("")
        except UnicodeDecodeError:
            raise InputError(f"{path} is not a text file") from None
        except OSError as error:
            raise FileError(f"{path} cannot be read: {error.strerror or error}") from None
    return texts[0], texts[1]


def _log(path: Path, scenario: "Scenario", cell: Path | None) -> Any:
    from helimag import robot
    from helimag.robot.logs import log_of_playback, read_log

    chosen = _cell(cell)
    if path.suffix.lower() == ".src":
        return log_of_playback(robot.play(*_krl(path), chosen.arm, interval=0.1), scenario)
    return read_log(path, chosen)


def _draw(plan: "Plan", target: Path) -> None:
    from helimag import plots

    for path in plots.save_plan(plan, target):
        print(path, file=sys.stderr)


def _print_report(found: dict[str, Any]) -> None:
    print(
        f"{found['scenario']} with {found['arm']}, cell '{found['cell']}': "
        f"{'feasible' if found['feasible'] else 'NOT feasible'}"
    )
    if found["offence"] is not None:
        print(f"  {found['offence']['text']}")
        for remedy in found["remedies"]:
            print(f"  remedy    {remedy}")
    if "with_unwinding" in found:
        other = found["with_unwinding"]
        outcome = (
            f"feasible with {other['unwindings']} unwindings, {other['duration_s']:.1f} s"
            if other["feasible"]
            else "not feasible"
        )
        print(f"  --unwind  {outcome}")
    tool = found["tool"]
    print(
        f"  tool      motor's axis {tool['motor_axis']} the rotation axis, turned "
        f"{tool['roll_deg']:.0f} deg, branch {tool['branch']}"
    )
    print(f"  duration  {found['duration_s']:.1f} s, {found['laps']:.2f} laps, {len(found['unwindings'])} unwindings")
    margins = found["margins"]
    if margins is not None:
        joints = ", ".join(f"{name} {value:.0f}" for name, value in margins["joint_limits_deg"].items())
        print(f"  margins   joints (deg) {joints}; singularity {margins['singularity_deg']:.0f} deg")
        near = ", ".join(f"{name} {value:.0f} mm" for name, value in margins["obstacles_mm"].items())
        print(
            f"            fastest joint at {100.0 * margins['largest_share_of_joint_speed']:.1f} % of its speed; {near}"
        )
