"""Commands about the arm: robot program, check, read-back, replay, jitter."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from helimag.cli import proofs
from helimag.cli._common import PLAIN, Common
from helimag.cli._outputs import (
    DATA,
    FIGURE,
    FILM,
    OUTPUT,
    FigureSize,
    Folder,
    Outputs,
    check_folder,
    check_outputs,
    files_report,
    print_files,
    write_outputs,
)
from helimag.cli._robot_reports import (
    deviation_data,
    judged,
    outcome_data,
    print_deviation,
    print_outcome,
    print_plan,
)
from helimag.cli._shared import LARGEST_SEED, Changes, ScenarioName, print_json, progress_bar, scenario_from, whole
from helimag.cli.runs import run_writers
from helimag.errors import NotFeasible

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
    output: Annotated[Outputs, Parameter(name=[*OUTPUT, "--figure"])] = None,
    size: FigureSize = None,
    common: Common = PLAIN,
) -> None:
    """Report whether the arm can take the magnet along a scenario's path; exit status 1 where it cannot, and why.

    Parameters
    ----------
    output
        Write a figure (.png, .svg, .pdf) of joints and limits over time to this file, and one of the cell beside it,
        named with -cell. May be repeated.
    """
    check_outputs(output, FIGURE, size=size)
    from helimag import robot

    plan = _plan(scenario_from(scenario, changes), cell, unwind)
    found = robot.report(plan)
    other = None if unwind else robot.with_unwinding(plan)
    if other is not None:
        found["with_unwinding"] = other
    files = [path for target in output or [] for path in _draw(plan, target, size)]
    if common.json:
        print_json(found | files_report(files))
    else:
        print_plan(found)
        print_files(files)
    if not plan.feasible:
        raise NotFeasible(f"the arm cannot run '{plan.scenario.title}': {plan.offence}")


@app.command
def program(
    scenario: ScenarioName,
    *,
    output: Folder,
    changes: Changes = None,
    cell: CellFile = None,
    unwind: Unwind = False,
    name: str | None = None,
    accept_unbounded: Annotated[bool, Parameter(negative="")] = False,
    spline: Annotated[bool, Parameter(negative="")] = False,
    certificate: Path | None = None,
    common: Common = PLAIN,
) -> None:
    """Write the programme of a scenario: KRL, a RoboDK script, the timed path, the motor's set-points.

    Parameters
    ----------
    output
        Folder for the files, made where there is none.
    name
        Name of the programme; default made of the scenario's name, and where it was changed of its hash.
    accept_unbounded
        Write although the simulated run is not bounded, or the device leaves when it goes on; the header then warns.
    spline
        Write spline motions, in blocks that keep the speed at their points, instead of LIN and CIRC.
    certificate
        A proof of the scenario's orbit (helimag orbit ... --prove --certificate); the header names it by its hash.
    """
    check_folder(output)
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
    if common.json:
        print_json({"verdict": str(run.verdict), **robot.report(plan)} | files_report(written))
        return
    print(f"{plan.scenario.title}: {run.verdict}, {run.judgement.reason}")
    print(f"  duration      {plan.duration:.1f} s, {len(plan.unwindings)} unwindings")
    print_files(written)


@app.command(name="read-back")
def read_back(
    source: Path,
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    cell: CellFile = None,
    unwind: Unwind = False,
    common: Common = PLAIN,
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
    if common.json:
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
    output: Outputs = None,
    size: FigureSize = None,
    common: Common = PLAIN,
) -> None:
    """Simulate what the device would have done under what the arm really did.

    Parameters
    ----------
    log
        Measured poses (.csv, with units and frames), or a KRL programme (.src) to run on paper.
    output
        Write the trajectory (.nc), a figure (.png, .svg, .pdf) or a film (.mp4) to this file. May be repeated.
    """
    check_outputs(output, DATA, FIGURE, FILM, size=size)
    from helimag import robot

    chosen = scenario_from(scenario, changes)
    run = _simulated(robot.replayed(chosen, _log(log, chosen, cell), log.name))
    planned = _simulated(chosen)
    write_outputs(output, run_writers(run), size=size)
    if common.json:
        print_json({"replayed": judged(run), "planned": judged(planned)} | files_report(output))
        return
    print(f"{log.name}: {run.verdict}, {run.judgement.reason}; gain {run.gain:.3f}")
    print(f"{chosen.title} as planned: {planned.verdict}, {planned.judgement.reason}; gain {planned.gain:.3f}")
    print_files(output)


@app.command
def jitter(
    scenario: ScenarioName,
    spectrum: Path,
    *,
    changes: Changes = None,
    cell: CellFile = None,
    draws: Annotated[int, whole(1, 10_000)] = 4,
    seed: Annotated[int, whole(0, LARGEST_SEED)] = 0,
    common: Common = PLAIN,
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

    chosen = scenario_from(scenario, changes)
    if spectrum.suffix == ".csv":
        errors = robot.measured_jitter(chosen, robot.read_log(spectrum, _cell(cell)), spectrum.name)
    else:
        errors = robot.load_jitter(spectrum)
    with progress_bar(f"simulating {chosen.title} with errors") as progress:
        ensembles = robot.study(chosen, errors, draws=draws, seed=seed, progress=progress)
    judged = {"none": [next(iter(ensembles.values())).judgement]}
    judged |= {kind: ensemble.judgements for kind, ensemble in ensembles.items()}
    if common.json:
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


def _draw(plan: "ArmPlan", target: Path, size: FigureSize) -> list[Path]:
    from helimag import plots

    return plots.save_plan(plan, target, size=size or "print")
