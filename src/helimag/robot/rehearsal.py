"""What a programme will do to the device: simulated with its unwindings, and the gate that rests on it."""

from collections.abc import Callable

import numpy as np

from helimag.errors import InputError
from helimag.outcomes import End, Verdict
from helimag.robot.arm.planning import Plan
from helimag.robot.logs import log_of, replayed
from helimag.robot.timed import timed_table
from helimag.runs.trajectory import Trajectory
from helimag.scenario import Scenario, parse

WHOLE = 1.0 - 1e-9  # of the programme's duration: what counts as all of it


def as_programmed(plan: Plan) -> Scenario:
    """The scenario as its programme runs it: with the unwindings, where there are any."""
    if not plan.unwindings:
        return plan.scenario
    lasting = plan.scenario.replaced({"run.duration": plan.duration})
    return replayed(lasting, log_of(timed_table(plan), plan.reversed_axis), "the programme's own path")


def rehearse(plan: Plan, *, progress: Callable[[float], None] | None = None) -> Trajectory:
    """Simulate what the programme of a plan does, unwindings included, from its start to its end.

    Parameters
    ----------
    plan
        A feasible one.
    progress
        Called with the fraction done, some times a second.

    Raises
    ------
    RunError
        Where the numbers broke down.
    """
    from helimag.engine import simulate

    return simulate(as_programmed(plan), progress=progress)


def checked_run(plan: Plan, run: Trajectory) -> Trajectory:
    """The run, if it is the simulation of this plan's programme: its path, its start, and all of its time.

    Raises
    ------
    InputError
        Where it is a run of something else, was measured, began elsewhere, or stops short of the programme's end.
    """
    remedy = "leave the run out, and the programme's own is simulated"
    attributes, text = run.dataset.attrs, run.scenario_toml
    if attributes.get("source") != "simulated" or text is None or "quaternion" not in run.dataset:
        raise InputError(f"run must be a simulated one that holds its scenario and attitudes; {remedy}")
    wanted, hash_ = as_programmed(plan), parse(text, "the run's scenario").hash
    if hash_ != wanted.hash:
        what = f"the path of '{wanted.name}' with the programme's {len(plan.unwindings)} unwindings"
        raise InputError(
            f"run must be of {what} over {wanted.run.duration:.6g} s (hash {wanted.hash[:12]}); "
            f"got one of hash {hash_[:12]}; {remedy}"
        )
    time = run.heights.time
    first = np.concatenate([run.dataset["position"].values[0], run.dataset["quaternion"].values[0]])
    if time[0] != 0.0 or not np.array_equal(first, [*wanted.drive.start, 1.0, 0.0, 0.0, 0.0]):
        raise InputError(f"run must begin as the scenario does, at 0 s and drive.start, level along x; {remedy}")
    if run.heights.end is End.HORIZON and time[-1] < WHOLE * plan.duration:
        raise InputError(
            f"run must last as long as the programme, {plan.duration:.6g} s; it stops at {time[-1]:.6g} s; {remedy}"
        )
    return run


def bounded(run: Trajectory) -> bool:
    """Whether a programme may be written without being asked for in so many words."""
    return run.verdict is Verdict.BOUNDED


def shown(plan: Plan, run: Trajectory) -> list[str]:
    """What was simulated, for how long, and what came of it: lines for the head of a programme."""
    path = f"with its {len(plan.unwindings)} unwindings" if plan.unwindings else "without unwindings"
    judgement = run.judgement
    return [
        f"Simulated: the programme's own path {path}, {judgement.end_time:.3f} s of {plan.duration:.3f} s",
        f"Simulated path's hash: {as_programmed(plan).hash}",
        f"Verdict: {judgement.verdict}; {judgement.reason}",
    ]
