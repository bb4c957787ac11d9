"""What a programme will do to the device: simulated with its unwindings, and the gate that rests on it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from helimag.engine import start_state
from helimag.errors import InputError
from helimag.orbits import Outlook, explain
from helimag.outcomes import End, Verdict
from helimag.robot.arm.planning import ArmPlan
from helimag.robot.logs import log_of, replayed
from helimag.robot.timed import timed_table
from helimag.runs.trajectory import Trajectory
from helimag.scenario import Scenario, parse

WHOLE = 1.0 - 1e-9  # of the programme's duration: what counts as all of it
ROUNDING = 1e-9  # m, rad and s: a path computed again, on another processor or at another address, differs by less


def as_programmed(plan: ArmPlan) -> Scenario:
    """The scenario as its programme runs it: with the unwindings, where there are any."""
    if not plan.unwindings:
        return plan.scenario
    lasting = plan.scenario.replaced({"run.duration": plan.duration})
    return replayed(lasting, log_of(timed_table(plan), plan.reversed_axis), "the programme's own path")


def rehearse(plan: ArmPlan, *, progress: Callable[[float], None] | None = None) -> Trajectory:
    """Simulate what the programme of a plan does, unwindings included, from its start to its end.

    Parameters
    ----------
    plan
        A feasible one.
    progress
        Called with the fraction done, some times a second.

    Returns
    -------
    Trajectory
        The simulated run.

    Raises
    ------
    RunError
        Where the numbers broke down.
    """
    from helimag.engine import simulate

    return simulate(as_programmed(plan), progress=progress)


def checked_run(plan: ArmPlan, run: Trajectory) -> Trajectory:
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
    wanted, got = as_programmed(plan), parse(text, "the run's scenario")
    if not _same_motion(wanted, got):
        what = f"the path of '{wanted.name}' with the programme's {len(plan.unwindings)} unwindings"
        raise InputError(
            f"run must be of {what} over {wanted.run.duration:.6g} s (hash {wanted.hash[:12]}); "
            f"got one of hash {got.hash[:12]}; {remedy}"
        )
    time = run.heights.time
    first = np.concatenate([run.dataset["position"].values[0], run.dataset["quaternion"].values[0]])
    if time[0] != 0.0 or not np.array_equal(first, start_state(wanted)):
        raise InputError(f"run must begin as the scenario does, at 0 s, at drive.start and with its heading; {remedy}")
    if run.heights.end is End.HORIZON and time[-1] < WHOLE * plan.duration:
        raise InputError(
            f"run must last as long as the programme, {plan.duration:.6g} s; it stops at {time[-1]:.6g} s; {remedy}"
        )
    return run


def _same_motion(one: Scenario, other: Scenario) -> bool:
    """Whether two scenarios decide the same run: all the same, but for rounding of a sampled path and its end."""
    ours, theirs = one.decisive, other.decisive
    durations = [part["run"].pop("duration") for part in (ours, theirs)]
    paths = [part["drive"].pop("path", {}) for part in (ours, theirs)]
    return (
        ours == theirs
        and abs(durations[0] - durations[1]) < ROUNDING
        and paths[0].keys() == paths[1].keys()
        and all(_alike(column, paths[1][name]) for name, column in paths[0].items())
    )


def _alike(one: object, other: object) -> bool:
    ours, theirs = np.asarray(one), np.asarray(other)
    return ours.shape == theirs.shape and bool(np.all(np.abs(ours - theirs) < ROUNDING))


@dataclass(frozen=True)
class Gate:
    """Whether a programme may be written without being asked for in so many words: bounded, and not known to leave.

    Attributes
    ----------
    run
        The simulation of the programme.
    outlook
        The outlook of the scenario's run; None where the verdict is not bounded, and none is sought.
    """

    run: Trajectory
    outlook: Outlook | None

    @property
    def passes(self) -> bool:
        """Whether nothing is to be said against it."""
        return self.outlook is not None and not self.outlook.future.leaves

    @property
    def objection(self) -> str:
        """What is to be said against it."""
        if self.outlook is None:
            return f"the run is not bounded ({self.run.verdict}: {self.run.judgement.reason})"
        return f"the run is bounded, but does not stay ({self.outlook.future}: {self.outlook.text})"


def gate(plan: ArmPlan, run: Trajectory) -> Gate:
    """Judge the run of a programme, and where it is bounded, follow the scenario's own run after its horizon.

    Unwindings end with the programme, so what is continued is then the run without them.

    Raises
    ------
    RunError
        Where the numbers broke down.
    """
    from helimag.engine import simulate

    if run.verdict is not Verdict.BOUNDED:
        return Gate(run, None)
    return Gate(run, explain(simulate(plan.scenario) if plan.unwindings else run))


def shown(plan: ArmPlan, gate: Gate) -> list[str]:
    """What was simulated, for how long, and what came of it: lines for the head of a programme."""
    path = f"with its {len(plan.unwindings)} unwindings" if plan.unwindings else "without unwindings"
    judgement = gate.run.judgement
    simulated = parse(gate.run.scenario_toml or "", "the run's scenario")
    outlook = [] if gate.outlook is None else [f"Outlook: {gate.outlook.future}; {gate.outlook.text}"]
    return [
        f"Simulated: the programme's own path {path}, {judgement.end_time:.3f} s of {plan.duration:.3f} s",
        f"Simulated path's hash: {simulated.hash}",
        f"Verdict: {judgement.verdict}; {judgement.reason}",
        *outlook,
    ]
