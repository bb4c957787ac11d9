"""Run scenarios: one or many, on CPU threads or a GPU. The only caller of the time loop."""

import json
import math
import os
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.checks import cautions
from helimag.engine import loop
from helimag.engine.kernels import ready
from helimag.engine.packing import (
    initial_gap,
    pack_bodies,
    pack_bounds,
    pack_clocks,
    pack_drives,
    pack_magnets,
    pose_model,
    start_state,
    structs,
)
from helimag.engine.step import Clock
from helimag.errors import InputError, RunError
from helimag.physics import magnetics
from helimag.physics.balance import Body
from helimag.physics.kinematics import State
from helimag.runs.gain import End, Heights, Judgement, judge
from helimag.runs.trajectory import Trajectory, versions
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

TOLERANCE = 3e-7  # of one step; positions are then within 1e-8 m after 100 s on the reference runs
LAUNCH_SECONDS = 0.25  # how long a launch may take before the host gets a word in
RUNS_PER_TASK = 8
MAGNET_MODELS = {"dipole": magnetics.point_dipole, "cylinder": magnetics.cylinder}
ENDS = {
    loop.Status.HORIZON: End.HORIZON,
    loop.Status.CONTACT: End.CONTACT,
    loop.Status.FALL: End.FALL,
    loop.Status.FLOOR: End.FLOOR,
    loop.Status.SURFACE: End.SURFACE,
    loop.Status.WALL: End.WALL,
}


@dataclass(frozen=True)
class History:
    """What the time loop recorded of one run: the raw material of a trajectory, and enough for a judgement."""

    scenario: Scenario
    time: Floats
    records: Floats
    status: loop.Status
    steps: int
    rejected: int
    wall_time: float

    @property
    def states(self) -> Floats:
        """Head position (m) and quaternion w, x, y, z at each sample: (n, 7)."""
        return self.records[:, :7]

    @property
    def heights(self) -> Heights:
        """What a judgement needs."""
        slips, low, high, mean, attack, square = self.records[:, 7:].T
        return Heights(
            time=self.time,
            low=low,
            high=high,
            mean=mean,
            attack=attack,
            attack_square=square,
            slips=int(slips[-1]),
            initial_gap=initial_gap(self.scenario),
            end=ENDS[self.status],
        )

    def judge(self) -> Judgement:
        """Gain and verdict."""
        return judge(self.heights)


class _Task:
    """A few runs of a batch: advances them launch by launch on one thread, and can be told to stop in between."""

    def __init__(
        self, scenarios: Sequence[Scenario], states: Floats, tolerance: float, device: str, stop: threading.Event
    ) -> None:
        self.scenarios = scenarios
        self.device = device
        self.stop = stop
        self.kernel = loop.build_advance(MAGNET_MODELS[scenarios[0].magnet[0].field], pose_model(scenarios[0]))
        inputs = (
            (pack_bodies(scenarios), Body),
            (pack_magnets(scenarios), magnetics.Magnet),
            (pack_clocks(scenarios, tolerance), Clock),
            (pack_bounds(scenarios), loop.Bounds),
        )
        self.inputs = [wp.array(values, dtype=kind, device=device) for values, kind in inputs]
        self.inputs.insert(1, pack_drives(scenarios, device))
        step = 1e-3 / np.array([abs(scenario.drive.frequency) for scenario in scenarios])
        progress = structs(loop.Progress, [{"state": s, "step": h} for s, h in zip(states, step, strict=True)])
        self.progress = wp.array(progress, dtype=loop.Progress, device=device)
        self.samples = np.array([_sample_count(scenario) for scenario in scenarios])
        self.records = np.full((len(scenarios), self.samples.max(), 13), np.nan)
        self.done = 0.0  # simulated seconds, all runs together

    def advance(self) -> list[History]:
        """Take the runs to their ends; empty where told to stop."""
        begun = time.perf_counter()
        first, chunk, total = 0, 2, int(self.samples.max())
        while first < total:
            if self.stop.is_set():
                return []
            last = min(first + chunk, total)
            records = wp.zeros((len(self.scenarios), last - first), dtype=loop.Record, device=self.device)
            launched = time.perf_counter()
            wp.launch(
                self.kernel,
                dim=len(self.scenarios),
                inputs=[*self.inputs, first, last, self.progress, records],
                device=self.device,
            )
            self.records[:, first:last] = records.numpy()
            took = time.perf_counter() - launched
            progress = self.progress.numpy()
            running = progress["status"] == loop.Status.RUNNING
            self.done = float(np.where(running, progress["time"], [s.run.duration for s in self.scenarios]).sum())
            if not running.any():
                break
            first = last
            chunk = max(1, int(chunk * min(4.0, LAUNCH_SECONDS / max(took, 1e-6))))
        return [self._history(i, progress[i], time.perf_counter() - begun) for i in range(len(self.scenarios))]

    def _history(self, run: int, progress: np.void, wall_time: float) -> History:
        scenario = self.scenarios[run]
        times = np.arange(self.samples[run]) * scenario.run.sample_interval
        times[times >= float(loop.NEARLY_ONE) * scenario.run.duration] = scenario.run.duration
        end = float(progress["time"])
        count = min(int(np.searchsorted(times, end)) + 1, times.size)
        times = times[:count].copy()
        times[-1] = end
        return History(
            scenario=scenario,
            time=times,
            records=self.records[run, :count].copy(),
            status=loop.Status(int(progress["status"])),
            steps=int(progress["steps"]),
            rejected=int(progress["rejected"]),
            wall_time=wall_time / len(self.scenarios),
        )


def _sample_count(scenario: Scenario) -> int:
    return math.ceil(scenario.run.duration / scenario.run.sample_interval * (1.0 - 1e-12)) + 1


def advance(
    scenarios: Sequence[Scenario],
    *,
    initial_states: Floats | None = None,
    tolerance: float = TOLERANCE,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[History]:
    """Run a batch and return the raw histories, in order. A run that breaks down has status ``NOT_FINITE``.

    Parameters
    ----------
    scenarios
        At least one; all with the same magnet field model.
    initial_states
        (runs, 7): head position (m) and quaternion w, x, y, z (normalised here). Default: :func:`start_state`.
    tolerance
        Of one step, in quaternion components and in positions over the helix' length.
    device
        ``"cpu"`` or a CUDA device such as ``"cuda"``.
    threads
        CPU threads; default one a core.
    progress
        Called in this thread with the fraction done, some times a second.

    Raises
    ------
    InputError
        Where the batch is empty, mixes field models or kinds of path, or its states do not fit.
    """
    if not scenarios:
        raise InputError("scenarios must hold at least one; got none")
    if len({scenario.magnet[0].field for scenario in scenarios}) > 1:
        raise InputError(
            "scenarios of one batch must have the same magnet.field; run the others in a batch of their own"
        )
    if len({scenario.drive.path is None for scenario in scenarios}) > 1:
        raise InputError(
            "scenarios of one batch must all have a drive.path or none; run the others in a batch of their own"
        )
    if not tolerance > 0.0:
        raise InputError(f"tolerance must be greater than zero; got {tolerance}")
    states = _checked_states(scenarios, initial_states)
    ready(loop.build_advance(MAGNET_MODELS[scenarios[0].magnet[0].field], pose_model(scenarios[0])), device)
    stop = threading.Event()
    size = RUNS_PER_TASK if device == "cpu" else len(scenarios)
    slices = [slice(i, i + size) for i in range(0, len(scenarios), size)]
    tasks: list[_Task] = []

    def work(part: slice) -> list[History]:
        task = _Task(scenarios[part], states[part], tolerance, device, stop)
        tasks.append(task)
        return task.advance()

    total = math.fsum(scenario.run.duration for scenario in scenarios)
    workers = (threads or os.cpu_count() or 1) if device == "cpu" else 1
    with ThreadPoolExecutor(workers) as pool:
        futures = [pool.submit(work, part) for part in slices]
        try:
            _watch(futures, lambda: progress and progress(math.fsum(task.done for task in tasks) / total))
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return [history for future in futures for history in future.result()]


def _watch(futures: list[Future[list[History]]], report: Callable[[], object]) -> None:
    """Wait for all futures, reporting now and then; the first failure is raised at once."""
    pending = set(futures)
    while pending:
        done, pending = wait(pending, timeout=0.1, return_when=FIRST_COMPLETED)
        for future in done:
            future.result()
        report()


def _checked_states(scenarios: Sequence[Scenario], given: Floats | None) -> Floats:
    if given is None:
        return np.array([start_state(scenario) for scenario in scenarios])
    try:
        states = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"initial_states must be numbers of shape ({len(scenarios)}, 7); got {given!r}") from None
    if states.shape != (len(scenarios), 7) or not np.all(np.isfinite(states)):
        raise InputError(f"initial_states must be finite numbers of shape ({len(scenarios)}, 7); got {states.shape}")
    lengths = np.linalg.norm(states[:, 3:], axis=1, keepdims=True)
    if not np.all(lengths > 0.0):
        raise InputError("initial_states must have quaternions that are not zero")
    states[:, 3:] /= lengths
    return states


def simulate(
    scenario: Scenario,
    *,
    duration: float | str | None = None,
    interval: float | str | None = None,
    initial_state: Floats | None = None,
    tolerance: float = TOLERANCE,
    device: str = "cpu",
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Run one scenario.

    Parameters
    ----------
    scenario
        What to run.
    duration, interval
        Instead of the scenario's own: seconds, or text with a unit.
    initial_state
        (7,): head position (m) and quaternion w, x, y, z; default the scenario's start, level along x.
    tolerance
        Of one step, see :func:`advance`.
    device
        ``"cpu"`` or a CUDA device such as ``"cuda"``.
    progress
        Called with the fraction done, some times a second.

    Raises
    ------
    InputError
        Where a value does not fit.
    RunError
        Where the numbers broke down.
    """
    changes = {"run.duration": duration, "run.interval": interval}
    given = {path: value for path, value in changes.items() if value is not None}
    states: Any = None if initial_state is None else [initial_state]
    (history,) = advance(
        [scenario.replaced(given) if given else scenario],
        initial_states=states,
        tolerance=tolerance,
        device=device,
        progress=progress,
    )
    return trajectory_of(history)


def simulate_many(
    scenarios: Sequence[Scenario],
    *,
    initial_states: Floats | None = None,
    tolerance: float = TOLERANCE,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Trajectory]:
    """Run a batch of scenarios in parallel and return their trajectories, in order.

    Parameters
    ----------
    scenarios
        At least one; all with the same magnet field model.
    initial_states
        (runs, 7): head position (m) and quaternion w, x, y, z; default each scenario's start, level along x.
    tolerance
        Of one step, see :func:`advance`.
    device
        ``"cpu"`` or a CUDA device such as ``"cuda"``.
    threads
        CPU threads; default one a core.
    progress
        Called with the fraction done, some times a second.

    Raises
    ------
    InputError
        Where the batch is empty, mixes field models, or its states do not fit.
    RunError
        Where the numbers of a run broke down.
    """
    histories = advance(
        scenarios,
        initial_states=initial_states,
        tolerance=tolerance,
        device=device,
        threads=threads,
        progress=progress,
    )
    return [trajectory_of(history) for history in histories]


def trajectory_of(history: History) -> Trajectory:
    """A history as a labelled trajectory, with the RPM's pose, the field and the phase lag added.

    Raises
    ------
    RunError
        Where the run's numbers broke down.
    """
    scenario = history.scenario
    if history.status is loop.Status.NOT_FINITE:
        raise RunError(
            f"the run '{scenario.name}' broke down at {history.time[-1]:.6g} s: no step is small enough; check the "
            "scenario for extreme values (a viscosity near zero, a magnet that the device starts very close to)"
        )
    states = history.states
    seen = _observe(scenario, history.time, states)
    long_axis = _long_axis(states)
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
            "slips": history.records[:, 7],
        },
        {
            "name": scenario.name,
            "source": "simulated",
            "frames": "lab: z up; body: x from helix to head, y along the moment; angles in rad",
            "initial_gap": heights.initial_gap,
            "end": str(heights.end),
            "scenario": scenario.to_toml(),
            "scenario_hash": scenario.hash,
            "versions": versions(),
            "validity_warnings": json.dumps([caution.as_dict() for caution in cautions([scenario])]),
            "integrator": "DOP853, adaptive",
            "steps": history.steps,
            "rejected_steps": history.rejected,
            "wall_time": history.wall_time,
        },
    )


def _observe(scenario: Scenario, times: Floats, states: Floats) -> dict[str, Floats]:
    """RPM position and moment, field at the head and phase lag, by the kernels' own formulas."""
    kernel = loop.build_observe(MAGNET_MODELS[scenario.magnet[0].field], pose_model(scenario))
    ready(kernel, "cpu")
    count = times.size
    position, moment, field = (wp.zeros(count, dtype=wp.vec3d, device="cpu") for _ in range(3))
    lag = wp.zeros(count, dtype=wp.float64, device="cpu")
    drive = pack_drives([scenario], "cpu")
    magnets = wp.array(pack_magnets([scenario])[0], dtype=magnetics.Magnet, device="cpu")
    given = [wp.array(times, dtype=wp.float64, device="cpu"), wp.array(states, dtype=State, device="cpu")]
    wp.launch(kernel, dim=count, inputs=[drive, magnets, *given, position, moment, field, lag], device="cpu")
    return {
        "rpm_position": position.numpy(),
        "rpm_moment": moment.numpy(),
        "field": field.numpy(),
        "phase_lag": lag.numpy(),
    }


def _long_axis(states: Floats) -> Floats:
    """Unit vector from helix to head, lab frame: the first column of the rotation matrix."""
    w, x, y, z = states[:, 3:].T
    return np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)], axis=1)
