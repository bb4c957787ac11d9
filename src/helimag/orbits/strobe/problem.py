"""A batch of drives whose one-period map can be evaluated: packed once, launched many times."""

import copy
import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache, partial
from itertools import pairwise
from typing import Any, Self

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine import (
    DOP853,
    System,
    pack_bodies,
    pack_drives,
    pack_magnets,
    ready,
    system_of,
)
from helimag.errors import InputError
from helimag.geometry import magnet_start
from helimag.orbits.strobe import chart
from helimag.orbits.strobe.period import Measures, Passage, build_pass
from helimag.orbits.strobe.watching import INTERVAL, Watch
from helimag.physics import magnetics
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import State
from helimag.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Measured = NDArray[np.void]  # (n,), with the fields of Measures

STRIDE = 2e-4  # of the finite differences: radians, and shares of the drive's distance
STEPS_PER_TURN = 12  # at least
DECAY_PER_STEP = 2.5  # at most: step times the fastest relaxation of the roll (DOP853 is stable up to about 6)
MOST_STEPS = 4000
FARTHEST = 1e3  # m, beyond which the field asks for no more steps
SHARE = 64  # passages a thread takes at a time, at most
THREADED_STEPS = 4096  # of a batch, some milliseconds of work, before it is worth beginning threads
LAUNCH_STEPS = 16384  # and steps of a launch, which cannot be interrupted: far less than half a second of work


def require_periodic(scenario: Scenario) -> None:
    """Refuse a drive that has no frame in which it repeats every turn of the magnet.

    Raises
    ------
    InputError
        Where the magnet follows a sampled path, or the arm turns and moves sideways at once.
    """
    if scenario.drive.path is not None:
        raise InputError("drive.path must be absent for an orbit: a magnet on a sampled path repeats nothing")
    across = scenario.drive.velocity[:2]
    if scenario.drive.yaw_rate != 0.0 and any(across):
        raise InputError(
            "drive.yaw_rate and drive.velocity must not both act for an orbit: an arm that turns and moves sideways "
            f"has no frame in which its drive repeats; got {math.degrees(scenario.drive.yaw_rate):g} deg/s with "
            f"({1e3 * across[0]:g}, {1e3 * across[1]:g}) mm/s sideways; set one of them to zero"
        )


def let_go(scenario: Scenario) -> Scenario:
    """The scenario with walls that do not hold the device: one that is held has no free orbit."""
    loose = {"contact": None, "surface_pull": None}
    return scenario.model_copy(update={"workspace": scenario.workspace.model_copy(update=loose)})


@cache
def _kernel(system: System, held: bool) -> wp.Kernel:
    return ready(partial(build_pass, system, DOP853, held), "cpu")


class Problem:
    """One-period maps of a batch of scenarios, in the frame that moves with each drive.

    Parameters
    ----------
    scenarios
        At least one; their magnets may have different field models.
    watch
        Told some times a second how far a search with these maps has come; what it raises stops the search.

    Raises
    ------
    InputError
        Where the batch is empty, or a drive is not periodic.
    """

    def __init__(self, scenarios: Sequence[Scenario], *, watch: Watch | None = None) -> None:
        if not scenarios:
            raise InputError("scenarios must hold at least one; got none")
        for scenario in scenarios:
            require_periodic(scenario)
        self.scenarios = list(scenarios)
        self.watch = watch or Watch()
        systems = [system_of(let_go(scenario)) for scenario in scenarios]
        self.systems = list(dict.fromkeys(systems))
        self._system = np.array([self.systems.index(system) for system in systems])
        bodies, self.roll = _packed_bodies(scenarios)
        self._bodies = wp.array(bodies, dtype=Swimmer, device="cpu")
        self._surroundings = [system.medium.pack(scenarios, "cpu") for system in self.systems]
        self._others = [
            pack_drives(scenarios, "cpu"),
            wp.array(pack_magnets(scenarios), dtype=magnetics.FieldSource, device="cpu"),
        ]
        self.period = np.array([1.0 / abs(scenario.drive.frequency) for scenario in scenarios])
        self.length = np.array([scenario.drive.distance for scenario in scenarios])
        self.arm = np.array([magnet_start(scenario.drive) for scenario in scenarios])
        self.contact = np.array([scenario.contact_distance for scenario in scenarios])
        self.lowest = self.arm[:, 2] - 3.0 * np.abs(
            self.arm[:, 2] - np.array([scenario.drive.start[2] for scenario in scenarios])
        )

    def __len__(self) -> int:
        return len(self.scenarios)

    def watched(self, watch: Watch) -> Self:
        """The same maps, for a part of a search that has a watch of its own."""
        same = copy.copy(self)
        same.watch = watch
        return same

    def steps(self, which: Ints, states: Floats) -> Ints:
        """Steps a period that keep the integrator stable and accurate at these states: the roll relaxes fastest."""
        offset = np.clip(states[:, :3] - self.arm[which], -FARTHEST, FARTHEST)  # a lost search may be at any number
        gap = np.linalg.norm(offset, axis=1)
        # a magnet at an offset may be nearer than the RPM's centre, never nearer than contact
        fastest = self.roll[which] / np.maximum(gap, self.contact[which] / 2.0) ** 3
        needed = np.ceil(self.period[which] * fastest / DECAY_PER_STEP)
        bounded = np.clip(np.nan_to_num(needed, nan=MOST_STEPS), STEPS_PER_TURN, MOST_STEPS)
        return np.asarray(bounded.astype(np.int64))

    def advance(
        self, which: Ints, states: Floats, steps: Ints, begin: Floats, end: Floats, *, held: bool = False
    ) -> tuple[Floats, Measured]:
        """Take states (n, 7) of problems ``which`` (n,) from phase ``begin`` to ``end``, as shares of the period.

        Returns
        -------
        states, measures
            (n, 7), and (n,) with the fields of :class:`helimag.orbits.strobe.period.Measures`.
        """
        passages: Any = np.zeros(len(which), dtype=Passage.numpy_dtype())  # type: ignore[attr-defined]
        passages["problem"], passages["steps"] = which, steps
        passages["begin"], passages["end"] = begin * self.period[which], end * self.period[which]
        results, measures = np.empty((len(which), 7)), no_measures(len(which))
        work = [
            partial(self._launch, _kernel(system, held), around, passages, states, results, measures, part)
            for number, (system, around) in enumerate(zip(self.systems, self._surroundings, strict=True))
            for part in self._parts(which, steps, number)
        ]
        _done_together(work, self.watch)
        return results, measures

    def _parts(self, which: Ints, steps: Ints, system: int) -> list[slice] | list[Ints]:
        """Parts of a batch for one launch each, of those with these formulas."""
        if len(self.systems) == 1:
            return _cut(steps)
        every = np.flatnonzero(self._system[which] == system)
        return [every[part] for part in _cut(steps[every])]

    def _launch(
        self,
        kernel: wp.Kernel,
        surroundings: wp.array,
        passages: NDArray[np.void],
        states: Floats,
        results: Floats,
        measures: Measured,
        part: slice | Ints,
    ) -> None:
        """Make the passages numbered ``part``, and write their results in their places."""
        count = len(states[part])
        out = wp.zeros(count, dtype=State, device="cpu"), wp.zeros(count, dtype=Measures, device="cpu")
        given = wp.array(passages[part], dtype=Passage, device="cpu"), wp.array(states[part], dtype=State, device="cpu")
        wp.launch(kernel, dim=count, inputs=[self._bodies, surroundings, *self._others, *given, *out], device="cpu")
        results[part], measures[part] = out[0].numpy(), out[1].numpy()

    def map(self, which: Ints, states: Floats, *, periods: int = 1, held: bool = False) -> tuple[Floats, Measured]:
        """States after some whole periods, and the measures of the last one."""
        measures = no_measures(len(which))
        for _ in range(periods):
            zero = np.zeros(len(which))
            states, measures = self.advance(which, states, self.steps(which, states), zero, zero + 1.0, held=held)
        return states, measures

    def linearized(
        self,
        which: Ints,
        states: Floats,
        *,
        begin: Floats | float = 0.0,
        end: Floats | float = 1.0,
        steps: Ints | None = None,
        columns: Sequence[int] = range(6),
        held: bool = False,
    ) -> tuple[Floats, Floats, Measured]:
        """The map at each state with its Jacobian, in the chart around the state, by central differences.

        Parameters
        ----------
        columns
            Coordinates to differentiate by.

        Returns
        -------
        value, jacobian, measures
            (n, 6), (n, 6, 6), (n,). The value is where the state's image lies in the chart around the state. Columns
            of the Jacobian that were not asked for are zero.
        """
        count, many = len(which), 1 + 2 * len(columns)
        length = self.length[which]
        along = STRIDE * np.eye(6)[list(columns)]
        offsets = np.concatenate([np.zeros((1, 6)), along, -along])
        starts = chart.moved(states[:, None, :], offsets[None], np.broadcast_to(length[:, None], (count, many)))
        taken = self.steps(which, states) if steps is None else steps
        begins, ends = (np.repeat(np.broadcast_to(np.asarray(phase, float), (count,)), many) for phase in (begin, end))
        images, measures = self.advance(
            np.repeat(which, many), starts.reshape(-1, 7), np.repeat(taken, many), begins, ends, held=held
        )
        images = images.reshape(count, many, 7)
        value = chart.coordinates(images[:, 0], states, length)
        # differences in the chart around the image itself, where the rotation vectors are small
        away = chart.coordinates(images[:, 1:], images[:, :1], np.broadcast_to(length[:, None], (count, many - 1)))
        jacobian = np.zeros((count, 6, 6))
        half = len(columns)
        jacobian[:, :, list(columns)] = np.swapaxes(away[:, :half] - away[:, half:], 1, 2) / (2.0 * STRIDE)
        return value, jacobian, measures.reshape(count, many)[:, 0]


def no_measures(count: int) -> Measured:
    """Room for the measures of so many passages."""
    dtype: Any = Measures.numpy_dtype()  # type: ignore[attr-defined]
    return np.zeros(count, dtype=dtype)


def _cut(steps: Ints) -> list[slice]:
    """Parts of a batch of passages of so many steps (n,) for the threads, each short enough for one launch."""
    count, total = len(steps), int(steps.sum())
    if total < min(THREADED_STEPS, LAUNCH_STEPS):
        return [slice(0, count)]
    parts = -(-count // SHARE) if count > 2 * SHARE else min(os.cpu_count() or 1, max(1, count // 32))
    even = np.array([SHARE * i if count > 2 * SHARE else count * i // parts for i in range(parts)] + [count])
    full = 1 + np.flatnonzero(np.diff(np.cumsum(steps, dtype=np.int64) // LAUNCH_STEPS))
    return [slice(a, b) for a, b in pairwise(np.union1d(even, full).tolist())]


def _done_together(work: Sequence[Callable[[], None]], watch: Watch) -> None:
    """Do all work on as many threads as there are cores; none is left when this returns or raises."""
    workers = min(os.cpu_count() or 1, len(work))
    if workers <= 1:
        for each in work:
            each()
            watch.pulse()
        return
    pool = ThreadPoolExecutor(workers, thread_name_prefix="helimag-orbits")
    try:
        futures = [pool.submit(each) for each in work]
        pending = set(futures)
        while pending:
            _, pending = wait(pending, timeout=INTERVAL)
            watch.pulse()
        for future in futures:
            future.result()
    finally:
        pool.shutdown(cancel_futures=True)


def _packed_bodies(scenarios: Sequence[Scenario]) -> tuple[NDArray[np.void], Floats]:
    """Devices as the kernels take them, each worked out once; and their rates of roll relaxation times gap^3."""
    keys = [(scenario.device, scenario.fluid) for scenario in scenarios]
    seen: dict[Any, int] = {}
    firsts: list[Scenario] = []
    for scenario, key in zip(scenarios, keys, strict=True):
        if key not in seen:
            seen[key] = len(firsts)
            firsts.append(scenario)
    bodies = pack_bodies(firsts)[[seen[key] for key in keys]]
    moments = np.array([math.fsum(magnet.dipole_moment for magnet in scenario.magnet) for scenario in scenarios])
    spin = bodies["mobility"].reshape(len(keys), 6, 6)[:, 3, 3]
    return bodies, 2e-7 * moments * bodies["magnetic_moment"] * spin
