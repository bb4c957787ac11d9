"""Write the files of a programme, after having read them back."""

import contextlib
import hashlib
import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from helimag.errors import FileError, InputError, NotFeasible
from helimag.files import csv_text, replacing
from helimag.proof import Certificate, line, require_proof_of
from helimag.robot.arm.cell import Cell
from helimag.robot.arm.planning import ArmPlan
from helimag.robot.krl.comparison import Deviation, deviation
from helimag.robot.krl.interpreter import play
from helimag.robot.krl.sequence import lead_time
from helimag.robot.krl.writer import LONGEST_NAME, checked_name, name_for, write_krl
from helimag.robot.rehearsal import Gate, checked_run, gate, rehearse, shown
from helimag.robot.report import remedies, report
from helimag.robot.robodk import write_robodk
from helimag.robot.timed import motor_rows, timed_table
from helimag.runs.trajectory import Trajectory


def write_programme(
    plan: ArmPlan,
    folder: str | Path,
    *,
    run: Trajectory | None = None,
    name: str | None = None,
    accept_unbounded: bool = False,
    spline: bool = False,
    certificate: Certificate | None = None,
) -> list[Path]:
    """Write the programme of a plan: KRL, RoboDK script, timed path, motor set-points. Returns the paths written.

    Parameters
    ----------
    run
        What :func:`rehearse` gave for this plan; without it the programme is simulated here. A run of another
        scenario, with other unwindings, from another start or shorter than the programme is refused.
    name
        Of the KRL module and of the files; default made of the scenario's name, and of a changed one's hash.
    accept_unbounded
        Write although the run's verdict is not bounded, or the device leaves when the run goes on; the header then
        carries a warning.
    spline
        Write spline motions, in blocks that keep the speed at their points, instead of LIN and CIRC.
    certificate
        A proof of the scenario's orbit, which the header then names by its hash. One of another scenario is refused, as
        is one for a programme with unwindings, which no theorem about an even drive covers.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    NotFeasible
        Where the arm cannot do it.
    InputError
        Where the run is not the programme's, nothing shows that the device stays and that was
        not accepted, a name does not fit, or the programme read back differs from the plan.
    FileError
        Where a file cannot be written.
    """
    texts = programme_texts(
        plan, run=run, name=name, accept_unbounded=accept_unbounded, spline=spline, certificate=certificate
    )
    return _write(Path(folder), texts)


def programme_texts(
    plan: ArmPlan,
    *,
    run: Trajectory | None = None,
    name: str | None = None,
    accept_unbounded: bool = False,
    spline: bool = False,
    certificate: Certificate | None = None,
) -> dict[str, str]:
    """The files of a programme as texts by file name; parameters and errors as for :func:`write_programme`."""
    name = _own_name(plan) if name is None else checked_name(name)
    feasible_or_refused(plan)
    proof = [] if certificate is None else [_proof_line(plan, certificate)]
    judged = gate(plan, rehearse(plan) if run is None else checked_run(plan, run))
    if not judged.passes and not accept_unbounded:
        raise InputError(
            f"{judged.objection}; change the scenario, or accept it to write the programme all the same "
            "(--accept-unbounded)"
        )
    warning = [] if judged.passes else [f"WARNING: NOTHING SHOWS THAT THE DEVICE STAYS. {judged.objection}"]
    header = [*warning, *_header(plan, judged), *proof]
    src, dat = write_krl(plan, name, header, spline=spline)
    try:
        playback = play(src, dat, plan.cell.arm, inputs=plan.cell.inputs)
    except InputError as error:
        if not spline:
            raise
        raise InputError(f"{error}; write lines in place of spline motions (leave --spline out)") from None
    found = deviation(plan, playback)
    if not found.acceptable:
        raise InputError(f"the programme read back is not the plan: {_shown(found)}")
    header.append(f"Read back: {_shown(found)}")
    src, dat = write_krl(plan, name, header, spline=spline)
    return {f"{name}.src": src, f"{name}.dat": dat, **_other_texts(plan, name, header)}


def _own_name(plan: ArmPlan) -> str:
    """A name made of the scenario's; of a changed one also of its hash, so that the two are told apart."""
    scenario = plan.scenario
    plain = name_for(scenario.name)
    return plain if scenario.title == scenario.name else f"{plain[: LONGEST_NAME - 7]}_{scenario.hash[:6]}"


def _other_texts(plan: ArmPlan, name: str, header: list[str]) -> dict[str, str]:
    """RoboDK script, timed path and motor's set-points, by file name."""
    columns = {key: values.tolist() for key, values in timed_table(plan).columns().items()}
    path = {"header": header, "report": report(plan), "frame": "lab", "columns": columns}
    return {
        f"{name}_robodk.py": write_robodk(plan, name, header),
        f"{name}_path.csv": _csv(columns, _marks(plan)),
        f"{name}_path.json": json.dumps(path, allow_nan=False) + "\n",
        f"{name}_motor.csv": _csv(_transposed(motor_rows(plan)), {"angle": "about the tool's x axis from its y axis"}),
    }


def feasible_or_refused(plan: ArmPlan) -> None:
    """Raise NotFeasible where the arm cannot run a plan, saying when, which joint and what value, and what to do."""
    if plan.offence is not None:
        raise NotFeasible(f"the arm cannot run '{plan.scenario.title}': {plan.offence}; {'; or '.join(remedies(plan))}")


def _proof_line(plan: ArmPlan, certificate: Certificate) -> str:
    """What the header says of a proof of the plan's orbit."""
    if plan.unwindings:
        raise InputError(
            "a certificate covers an even drive; this programme stops to turn axis 6 back: leave the certificate out"
        )
    require_proof_of(certificate, plan.scenario)
    return line(certificate)


def cell_hash(cell: Cell) -> str:
    """SHA-256 of all that a programme takes from its cell."""
    return hashlib.sha256(json.dumps(cell.model_dump(mode="python"), sort_keys=True).encode()).hexdigest()


def _header(plan: ArmPlan, judged: Gate) -> list[str]:
    laps = f", {plan.laps:.2f} laps" if plan.laps else ""
    rate = motor_rows(plan)[0]
    return [
        f"helimag {version('helimag')}",
        f"Scenario: {plan.scenario.title}",
        f"Scenario hash: {plan.scenario.hash}",
        *shown(plan, judged),
        f"Arm: {plan.cell.arm.name}",
        f"Cell: {plan.cell.name}",
        f"Cell hash: {cell_hash(plan.cell)}",
        f"Expected duration: {plan.duration:.3f} s{laps}, {len(plan.unwindings)} unwindings",
        f"Motor: {rate['frequency [Hz]']:.6f} Hz about the tool's x axis, moment at "
        f"{rate['angle [deg]']:.3f} deg from its y axis "
        "when the path begins",
        *_for_the_lab(plan),
        "Checked: joint limits and speeds, singularities, arm and magnet against the cell's obstacles",
        "NOT checked: the way from where the arm stands to the first point; the arm against itself and its cables",
    ]


def _for_the_lab(plan: ArmPlan) -> list[str]:
    """Signals, load and the way up, as far as the cell has them."""
    cell, lines = plan.cell, []
    if cell.motor is not None:
        answers = ", ".join(f"$IN[{number}]" for number in sorted(cell.motor.inputs)) or "nothing"
        lines.append(f"Motor: on with $OUT[{cell.motor.run_output}], waits for {answers}; off on a stop")
        if cell.motor.phase_input is not None:
            lines.append(f"Motor: the path begins {lead_time(plan):.6f} s after $IN[{cell.motor.phase_input}] rises")
    if cell.load is not None:
        lines.append(f"Load: {cell.load.mass:g} kg")
    if cell.retreat is not None:
        lines.append(f"At the end the arm goes up by {1e3 * cell.retreat:g} mm")
    return lines


def _shown(found: Deviation) -> str:
    return (
        f"position within {1e6 * found.position:.3f} um, axis within {found.axis:.2e} rad, "
        f"timing within {100 * found.timing:.4f} %"
    )


def _marks(plan: ArmPlan) -> dict[str, str]:
    return {
        "frame": "lab",
        "pose": "tool",
        "motor axis": "against" if plan.reversed_axis else "along",
        "scenario hash": plan.scenario.hash,
    }


def _transposed(rows: list[dict[str, float]]) -> dict[str, list[float]]:
    return {key: [row[key] for row in rows] for key in rows[0]}


def _csv(columns: Mapping[str, list[float]], marks: Mapping[str, str]) -> str:
    """Columns as CSV, after comment lines; numbers so that they read back as the same."""
    lines = "".join(f"# {key}: {value}\n" for key, value in marks.items())
    return lines + csv_text([list(columns), *zip(*columns.values(), strict=True)])


def _write(folder: Path, texts: Mapping[str, str]) -> list[Path]:
    """Write all files or none: all beside first, then renamed."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{folder} cannot be written: {error.strerror or error}") from None
    with contextlib.ExitStack() as stack:
        for name, text in texts.items():
            beside = stack.enter_context(replacing(folder / name))
            ends = "\r\n" if name.endswith((".src", ".dat")) else "\n"
            beside.write_text(text, encoding="ascii", newline=ends)
    return [folder / name for name in texts]
