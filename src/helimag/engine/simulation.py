"""Run scenarios, one or many, and get labelled trajectories back."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.checks import cautions
from helimag.engine.accuracy import SURE, Accuracy, accuracy_of, refined
from helimag.engine.batch import TOLERANCE
from helimag.engine.history import History
from helimag.engine.methods import DEFAULT, method_named
from helimag.engine.observe import observed
from helimag.engine.running import advance
from helimag.errors import RunError
from helimag.geometry import long_axes
from helimag.outcomes import End, Reason
from helimag.runs.heights import Heights
from helimag.runs.trajectory import Trajectory, versions
from helimag.scenario import Scenario, as_scenario, drive_inputs, scalar_inputs

Floats = NDArray[np.float64]

OWN_SHARE = 0.4  # of the time of a run and the same with finer steps: these take the rest


def simulate(
    scenario: Scenario | str | Path,
    *,
    duration: float | str | None = None,
    interval: float | str | None = None,
    initial_state: Floats | None = None,
    tolerance: float = TOLERANCE,
    method: str = DEFAULT,
    device: str = "cpu",
    accuracy: bool = False,
    refine: bool | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Run one scenario.

    Parameters
    ----------
    scenario
        What to run, or its name or path as :func:`helimag.load` takes it.
    duration, interval
        Instead of the scenario's own: seconds, or text with a unit.
    initial_state
        (7,): head position (m) and quaternion w, x, y, z; default the scenario's start.
    tolerance
        Of one step, see :func:`advance`.
    method
        ``"multirevolution"``: leaps over turns of the magnet where the device keeps in step and nothing is near, see
        :mod:`helimag.engine.leaps`, and direct steps elsewhere; or ``"direct"``: steps all the way.
    device
        ``"cpu"`` or a CUDA device such as ``"cuda"``.
    accuracy
        Run it again with finer steps and keep the difference, see :class:`helimag.engine.accuracy.Accuracy`.
    refine
        Where the device loses step or is drawn into the magnet, which multiplies errors, return the run with finer
        steps, see :func:`helimag.engine.accuracy.refined`; other runs stay as they are. False: all have steps as asked
        for, as those of sweeps and ensembles have. None: refine, unless a looser tolerance than the default is asked
        for, which is to be fast.
    progress
        Called with the fraction done, some times a second.

    Returns
    -------
    Trajectory
        The run, with its gain and verdict.

    Raises
    ------
    InputError
        Where a value does not fit.
    RunError
        Where the numbers broke down.
    """
    changes = {"run.duration": duration, "run.interval": interval}
    given = {path: value for path, value in changes.items() if value is not None}
    scenario = as_scenario(scenario)
    states: Any = None if initial_state is None else [initial_state]
    chosen: dict[str, Any] = {"tolerance": tolerance, "method": method_named(method), "device": device}
    refine = _refines(tolerance) if refine is None else refine
    own = OWN_SHARE if accuracy or refine else 1.0
    (rough,) = advance(
        [scenario.replaced(given) if given else scenario],
        initial_states=states,
        **chosen,
        progress=_part(progress, 0.0, own),
    )
    rest, told = _part(progress, own, 1.0), None
    again = _part(rest, 0.0, OWN_SHARE if accuracy else 1.0)
    (history,) = refined([rough], **chosen, progress=again) if refine else [rough]
    finer = history is not rough
    chosen["tolerance"] = SURE if finer else tolerance
    if accuracy:
        part = _part(rest, OWN_SHARE if finer else 0.0, 1.0)
        told = accuracy_of(history, **chosen, rough=rough if finer else None, progress=part)
    if progress is not None:
        progress(1.0)
    return trajectory_of(history, tolerance=chosen["tolerance"], accuracy=told)


def _refines(tolerance: float) -> bool:
    """Whether runs are refined where nothing is said of it: who asks for looser steps wants to be fast."""
    return tolerance <= TOLERANCE


def _part(progress: Callable[[float], None] | None, begin: float, end: float) -> Callable[[float], None] | None:
    """The progress of one of two pieces of work, as a share of both."""
    return None if progress is None else lambda done: progress(begin + (end - begin) * done)


def simulate_many(
    scenarios: Sequence[Scenario],
    *,
    initial_states: Floats | None = None,
    tolerance: float = TOLERANCE,
    method: str = DEFAULT,
    device: str = "cpu",
    threads: int | None = None,
    refine: bool | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Trajectory]:
    """Run a batch of scenarios in parallel and return their trajectories, in order.

    Parameters
    ----------
    scenarios
        At least one; they may differ in everything.
    initial_states
        (runs, 7): head position (m) and quaternion w, x, y, z; default each scenario's start.
    tolerance
        Of one step, see :func:`advance`.
    method
        ``"multirevolution"``: leaps over turns of the magnet where the device keeps in step and nothing is near, see
        :mod:`helimag.engine.leaps`, and direct steps elsewhere; or ``"direct"``: steps all the way.
    device
        ``"cpu"`` or a CUDA device such as ``"cuda"``.
    threads
        CPU threads; default one a core.
    refine
        As for :func:`simulate`.
    progress
        Called with the fraction done, some times a second.

    Returns
    -------
    list of Trajectory
        The runs, in the scenarios' order.

    Raises
    ------
    InputError
        Where the batch is empty, or its states do not fit.
    RunError
        Where the numbers of a run broke down.
    """
    chosen: dict[str, Any] = {
        "tolerance": tolerance,
        "method": method_named(method),
        "device": device,
        "threads": threads,
    }
    refine = _refines(tolerance) if refine is None else refine
    own = OWN_SHARE if refine else 1.0
    ran = advance(scenarios, initial_states=initial_states, **chosen, progress=_part(progress, 0.0, own))
    histories = refined(ran, **chosen, progress=_part(progress, own, 1.0)) if refine else ran
    if progress is not None:
        progress(1.0)
    return [
        trajectory_of(history, tolerance=tolerance if history is rough else SURE)
        for history, rough in zip(histories, ran, strict=True)
    ]


def _inputs(scenario: Scenario) -> dict[str, str | float]:
    """The drive in words, and every number of a scenario by its path (SI, radians), for readers that know no TOML."""
    numbers = {f"input_{given.path.replace('.', '_')}": given.value(scenario) for given in scalar_inputs(scenario)}
    return {"inputs": drive_inputs(scenario), **numbers}


def trajectory_of(history: History, *, tolerance: float = TOLERANCE, accuracy: Accuracy | None = None) -> Trajectory:
    """A history as a labelled trajectory, with the RPM's pose, the field and the phase lag added.

    ``tolerance``, of the run's steps, goes with it as an attribute, and so does ``accuracy`` where it was looked for.

    Returns
    -------
    Trajectory
        What :func:`simulate` returns.

    Raises
    ------
    RunError
        Where the run's numbers broke down.
    """
    scenario = history.scenario
    if history.status is End.NOT_FINITE:
        raise RunError(f"the run '{scenario.title}' {Reason.NUMBERS_BROKE_DOWN.text(time=history.time[-1])}")
    states = history.states
    seen = observed(scenario, history.time, states)
    long_axis = long_axes(states[:, 3:])
    heights = history.heights
    return Trajectory.from_arrays(
        history.time,
        {
            "position": states[:, :3],
            "quaternion": states[:, 3:],
            "long_axis": long_axis,
            "attack_angle": np.arcsin(np.clip(long_axis[:, 2], -1.0, 1.0)),
            **seen,
            "gap": np.linalg.norm(states[:, :3] - seen["rpm_position"], axis=1),
            "height_low": heights.low,
            "height_high": heights.high,
            "height_mean": heights.mean,
            "attack_mean": heights.attack,
            "attack_mean_square": heights.attack_square,
            "slips": history.slips,
            **_contacts(history),
        },
        {
            "name": scenario.title,
            "source": "simulated",
            "frames": "lab: z up; body: x from helix to head, y along the moment; angles in rad",
            "initial_gap": heights.initial_gap,
            "end": str(heights.end),
            **_slowness(heights),
            **_inputs(scenario),
            "scenario": scenario.to_toml(),
            "scenario_hash": scenario.hash,
            "versions": versions(),
            "validity_warnings": json.dumps([caution.as_dict() for caution in cautions([scenario])]),
            **_engine_of(history),
            "tolerance": tolerance,
            "steps": history.steps,
            "rejected_steps": history.rejected,
            "wall_time": history.wall_time,
            **({} if accuracy is None else {"accuracy": json.dumps(_told(accuracy))}),
        },
    )


def _told(accuracy: Accuracy) -> dict[str, object]:
    """How far to trust the places, as an attribute's JSON."""
    return asdict(accuracy) | {"enough": accuracy.enough, "text": accuracy.text}


def _engine_of(history: History) -> dict[str, object]:
    """What took the run's steps: where it leapt over turns, over what share of them, and how many it followed."""
    if not history.leapt:
        return {"integrator": "DOP853, adaptive"}
    return {
        "integrator": "DOP853, adaptive; multi-revolution where the device keeps in step",
        "share_of_turns_leapt_over": history.leapt,
        "turns_followed_for_leaps": int(history.progress["leap"]["followed"]),
    }


def _contacts(history: History) -> dict[str, Floats]:
    """Which walls pushed between samples, and the contacts with each; nothing where none can."""
    if not history.scenario.workspace.holds:
        return {}
    by_wall = {f"contact_{name}": values for name, values in history.contacts.items()}
    return {"walls": history.records["walls"], **by_wall}


def _slowness(heights: Heights) -> dict[str, object]:
    """Slow times as attributes (s): of a lap, where there are laps, and in which an error of height grows e-fold."""
    slow = heights.slow
    known = {} if slow is None else {"lap_time": slow.lap, "fold_time": slow.fold}
    return {name: time for name, time in known.items() if time is not None}
