"""Commands about the arm: robot program, check, read-back, replay, jitter."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from helimag.cli import proofs
from helimag.cli._robot_reports import (
    deviation_data,
    judged,
    outcome_data,
    print_deviation,
    print_outcome,
    print_plan,
)
from helimag.cli._shared import Changes, Json, ScenarioName, check_target, print_json, progress_bar, scenario_from
from helimag.errors import InputError, NotFeasible

if TYPE_CHECKING:
    from helimag.robot import ArmPlan
    from helimag.runs.trajectory import Trajectory
    from helimag.scenario import Scenario

app = App(name="robot", help="From a scenario to a programme that an arm can run, and back from what an arm did.")

CellFile = Annotated[
    Path | None, Parameter(name="--cell", help="TOML file of the cell, or wide; without it, the default cell.")
]
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
    """Report whether the arm can take the magnet along a scenario's path; exit status 1 where it cannot, and why.

    Parameters
    ----------
    figure
        Draw joints and limits over time into this file; the cell in 3-D goes beside it, named with -cell.
    """
    from helimag import robot

    plan = _plan(scenario_from(scenario, changes), cell, unwind)
    found = robot.report(plan)
    other = None if unwind else robot.with_unwinding(plan)
    if other is not None:
        found["with_unwinding"] = other
    if figure is not None:
        _draw(plan, figure)  # names the files on stderr
    if json:
        print_json(found)
    else:
        print_plan(found)
    if not plan.feasible:
        raise NotFeasible(f"the arm cannot run '{plan.scenario.title}': {plan.offence}")


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
    certificate: Path | None = None,
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
        Write although the simulated run is not bounded, or the device leaves when it goes on; the header then warns.
    spline
        Write spline motions, in blocks that keep the speed at their points, instead of LIN and CIRC.
    certificate
        A proof of the scenario's orbit (helimag orbit ... --prove --certificate); the header names it by its hash.
    """
    from helimag import robot

    if name is not None:
        robot.checked_name(name)
    plan = _plan(scenario_from(scenario, changes), cell, unwind)
    robot.feasible_or_refused(plan)
    proof = None if certificate is None else proofs.checked_for(certificate, plan.scenario)
    with progress_bar(f"simulating {plan.scenario.title}") as progress:
        run = robot.rehearse(plan, progress=progress)
    written = robot.write_programme(
        plan, output, run=run, name=name, accept_unbounded=accept_unbounded, spline=spline, certificate=proof
    )
    if json:
        print_json({"files": [str(path) for path in written], "verdict": str(run.verdict), **robot.report(plan)})
        return
    print(f"{plan.scenario.title}: {run.verdict}, {run.judgement.reason}")
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
    playback = robot.play(*robot.krl_texts(source), plan.cell.arm, inputs=plan.cell.inputs)
    found = robot.deviation(plan, playback)
    if json:
        print_json(deviation_data(found, plan, playback))
    else:
        print_deviation(found, plan, playback, source)
    if not found.acceptable:
        raise RunError(
            f"{source} is not the programme of this scenario and cell: it differs by more than 1 um, 1e-6 rad or "
            "0.1 %, or in what it sets"
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
    from helimag import robot

    if output is not None:
        check_target(output)
    chosen = scenario_from(scenario, changes)
    run = _simulated(robot.replayed(chosen, _log(log, chosen, cell), log.name))
    planned = _simulated(chosen)
    if output is not None:
        run.save(output)
    if json:
        print_json({"replayed": judged(run), "planned": judged(planned)})
        return
    print(f"{log.name}: {run.verdict}, {run.judgement.reason}; gain {run.gain:.3f}")
    print(f"{chosen.title} as planned: {planned.verdict}, {planned.judgement.reason}; gain {planned.gain:.3f}")


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
    from helimag import robot

    if draws < 1:
        raise InputError(f"--draws must be 1 or more; got {draws}")
    chosen = scenario_from(scenario, changes)
    if spectrum.suffix == ".csv":
        errors = robot.measured_jitter(chosen, robot.read_log(spectrum, _cell(cell)), spectrum.name)
    else:
        errors = robot.load_jitter(spectrum)
    with progress_bar(f"simulating {chosen.title} with errors") as progress:
        ensembles = robot.study(chosen, errors, draws=draws, seed=seed, progress=progress)
    judged = {"none": [next(iter(ensembles.values())).judgement]}
    judged |= {kind: ensemble.judgements for kind, ensemble in ensembles.items()}
    if json:
        print_json({"source": errors.source, "outcomes": [outcome_data(kind, runs) for kind, runs in judged.items()]})
        return
    print(f"{chosen.title}, errors {errors.source}")
    for kind, runs in judged.items():
        print_outcome(kind, runs)


def _cell(path: Path | None) -> Any:
    from helimag.robot import load_cell

    return load_cell(path)


def _plan(scenario: "Scenario", cell: Path | None, unwind: bool) -> "ArmPlan":
    from helimag import robot

    return robot.plan(scenario, _cell(cell), unwind=unwind)


def _simulated(scenario: "Scenario") -> "Trajectory":
    from helimag.engine import simulate

    with progress_bar(f"simulating {scenario.title}") as progress:
        return simulate(scenario, progress=progress)


def _log(path: Path, scenario: "Scenario", cell: Path | None) -> Any:
    from helimag import robot

    chosen = _cell(cell)
    if path.suffix.lower() == ".src":
        playback = robot.play(*robot.krl_texts(path), chosen.arm, interval=0.1, inputs=chosen.inputs)
        return robot.log_of_playback(playback, scenario, chosen)
    return robot.read_log(path, chosen)


def _draw(plan: "ArmPlan", target: Path) -> None:
    from helimag import plots

    for path in plots.save_plan(plan, target):
        print(path, file=sys.stderr)
