"""A few runs with the same formulas: packed once, advanced together launch by launch."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.columns import build_columns
from helimag.engine.control import Control, pack_controls
from helimag.engine.events import Bounds, pack_bounds
from helimag.engine.history import History
from helimag.engine.lanes import MOST_MAGNETS_IN_LANES
from helimag.engine.loop import build_advance
from helimag.engine.medium import OPEN_WATER
from helimag.engine.methods import MULTIREVOLUTION, Method
from helimag.engine.packing import pack_bodies, pack_drives, pack_magnets
from helimag.engine.progress import Progress
from helimag.engine.samples import Record, Schedule, pack_schedules, sample_times
from helimag.engine.structures import reader, structs
from helimag.engine.system import MAGNET_MODELS, System, clear_of_walls, frame_moves, leaps_hold
from helimag.engine.turn_memory import memory_reader, pack_memory
from helimag.outcomes import End
from helimag.physics.balance import Swimmer
from helimag.physics.magnetics import FieldSource
from helimag.scenario import Drive, Scenario

Floats = NDArray[np.float64]

TOLERANCE = 3e-7  # of one step; positions are then within 1e-8 m after 100 s on the reference runs
FIRST_STEP = 1e-3  # of a turn of the magnet
FEWEST_TURNS = 36.0  # of a run that leaps: from there on leaps pay in the mean, alone too; benchmarks/leaps.py


@dataclass(frozen=True)
class Stepping:
    """How runs are advanced.

    Attributes
    ----------
    method
        What takes the steps.
    tolerance
        Of one step, in quaternion components and in positions over the helix' length.
    device
        ``"cpu"`` or a CUDA device such as ``"cuda"``.
    """

    method: Method = MULTIREVOLUTION
    tolerance: float = TOLERANCE
    device: str = "cpu"


def _room_abreast(runs: int) -> list[wp.array]:
    """What the kernel for runs abreast writes on."""
    from helimag.engine.pool import room

    return room(runs)


def started(system: System, scenarios: Sequence[Scenario], states: Floats) -> NDArray[np.void]:
    """Where runs stand before their first step, from states (n, 7)."""
    rows = [
        {"state": state, "middle": state, "step": FIRST_STEP / abs(scenario.drive.frequency)}
        for state, scenario in zip(states, scenarios, strict=True)
    ]
    progress: Any = structs(Progress, rows)
    progress["leap"]["ready"] = [first_leap(system, scenario.drive) for scenario in scenarios]
    return np.asarray(progress)


def method_for(system: System, scenario: Scenario, method: Method) -> Method:
    """What takes a run's steps: leaps only where there are turns enough, and a frame moves with the drive."""
    turns = abs(scenario.drive.frequency) * scenario.run.duration
    if method.leaps and (turns < FEWEST_TURNS or math.isinf(first_leap(system, scenario.drive))):
        return _without_leaps(method)
    return method


@cache
def _without_leaps(method: Method) -> Method:
    return replace(method, leaps=False)


def first_leap(system: System, drive: Drive) -> float:
    """When a leap may first be tried (s): never where no frame moves with the drive."""
    return 1.0 / abs(drive.frequency) if frame_moves(system, drive) else math.inf


def fits_lanes(system: System, scenarios: Sequence[Scenario], settings: Stepping) -> bool:
    """Whether lanes of vector registers are of use: on a CPU, for an even drive, magnets of runs cut alike.

    The formulas must be those that :mod:`helimag.engine.lanes` is known to translate.
    """
    known = system.magnet in MAGNET_MODELS.values() and clear_of_walls(system).medium.lanes
    if not (leaps_hold(system) and known and settings.device == "cpu"):
        return False
    slices = pack_magnets(scenarios)["slices"]
    return slices.shape[1] <= MOST_MAGNETS_IN_LANES and not np.ptp(slices, axis=0).any()


def steps_abreast(system: System, method: Method) -> bool:
    """Whether direct steps go into lanes: in open water, by a method that is known to be translated."""
    return system.medium == OPEN_WATER and method.lanes


def goes_abreast(system: System, scenarios: Sequence[Scenario], settings: Stepping) -> bool:
    """Whether steps or turns of several runs are taken at once: where lanes fit, and all water is open."""
    turns = settings.method.leaps and clear_of_walls(system).medium == OPEN_WATER
    of_use = turns or steps_abreast(system, settings.method)
    return len(scenarios) > 1 and of_use and fits_lanes(system, scenarios, settings)


def build_kernel(system: System, method: Method, lanes: bool, abreast: bool) -> wp.Kernel:
    """Make the kernel that takes runs their way: each by itself, or several at once."""
    if not abreast:
        return build_advance(system, method, lanes)
    from helimag.engine.pool import build_advance_abreast

    return build_advance_abreast(system, replace(method, name=""), steps_abreast(system, method))


def packed(
    system: System,
    scenarios: Sequence[Scenario],
    settings: Stepping,
    progress: wp.array,
    records: wp.array,
    memory: Any,
) -> Any:
    """Runs as the kernels take them, from where they stand."""
    runs, device = build_columns(system)(), settings.device
    runs.bodies = wp.array(pack_bodies(scenarios), dtype=Swimmer, device=device)
    runs.surroundings = system.medium.pack(scenarios, device)
    runs.drives = pack_drives(scenarios, device)
    runs.magnets = wp.array(pack_magnets(scenarios), dtype=FieldSource, device=device)
    controls = pack_controls(scenarios, settings.tolerance, system.medium.longest_step)
    runs.controls = wp.array(controls, dtype=Control, device=device)
    runs.bounds = wp.array(pack_bounds(scenarios), dtype=Bounds, device=device)
    runs.schedules = wp.array(pack_schedules(scenarios), dtype=Schedule, device=device)
    runs.progress, runs.records, runs.memory = progress, records, memory
    return runs


class Batch:
    """A few runs that are advanced together.

    Parameters
    ----------
    system
        The formulas, the same for all.
    scenarios
        At least one.
    progress
        (runs,): where each stands, see :func:`started` and :attr:`History.progress`.
    settings
        How they are advanced.
    records, memories
        What was recorded of each before, and what it remembers, where they go on.
    """

    def __init__(
        self,
        system: System,
        scenarios: Sequence[Scenario],
        progress: NDArray[np.void],
        settings: Stepping,
        records: Sequence[NDArray[np.void]] = (),
        memories: Sequence[dict[str, Floats]] = (),
    ) -> None:
        self.scenarios = scenarios
        self._device = settings.device
        lanes, abreast = fits_lanes(system, scenarios, settings), goes_abreast(system, scenarios, settings)
        self._kernel = build_kernel(system, settings.method, lanes, abreast)
        self._begun = time.perf_counter()
        self._progress = wp.array(progress, dtype=Progress, device=settings.device)
        self._read_progress = reader(self._progress)
        runs = {(run.duration, run.sample_interval): run for run in (scenario.run for scenario in scenarios)}
        times = {key: sample_times(run) for key, run in runs.items()}  # of a sweep, most often one
        self._times = [times[scenario.run.duration, scenario.run.sample_interval] for scenario in scenarios]
        most = max(times.size for times in self._times)
        self._records = wp.zeros((len(scenarios), most), dtype=Record, device=settings.device)
        self._read_records = reader(self._records)
        for run, known in enumerate(records):
            if known.size:
                self._records[run, : known.size].assign(known)
        kept = memories or [{}] * len(scenarios)
        self._leaps = settings.method.leaps
        looks = clear_of_walls(system).medium != OPEN_WATER
        memory = pack_memory(kept if self._leaps else (), settings.device, looks=looks)
        self._remembered = memory_reader(memory)
        self._runs = packed(system, scenarios, settings, self._progress, self._records, memory)
        self._threads, self._room = (1, _room_abreast(len(scenarios))) if abreast else (len(scenarios), [])
        # progress and memories as of the last launch; replaced as a whole, so that other threads may read them
        self._latest = progress.copy(), list(kept)

    @property
    def running(self) -> bool:
        """Whether any run has not come to its end."""
        return bool((self._latest[0]["status"] == End.RUNNING).any())

    @property
    def done(self) -> float:
        """Simulated seconds that are behind, all runs together; a run that ended early has all of its behind."""
        durations = [scenario.run.duration for scenario in self.scenarios]
        stand, _ = self._latest
        return float(np.where(stand["status"] == End.RUNNING, stand["time"], durations).sum())

    def launch(self, budget: int) -> tuple[float, float]:
        """Let each run try up to ``budget`` steps; how long that took, and reading where they stand then (s)."""
        begun = time.perf_counter()
        inputs = [self._runs, budget, *self._room]
        wp.launch(self._kernel, dim=self._threads, inputs=inputs, device=self._device)
        wp.synchronize_device(self._device)
        stepped = time.perf_counter()
        stand = self._read_progress().copy()
        going_on = (stand["status"] == End.RUNNING) & self._leaps
        self._latest = stand, self._remembered(going_on)
        return stepped - begun, time.perf_counter() - stepped

    def histories(self) -> list[History]:
        """What has been recorded so far; may be called while another thread advances the runs."""
        (stand, memories), records = self._latest, self._read_records()
        share = (time.perf_counter() - self._begun) / len(self.scenarios)
        ends = {flag: End.of(flag) for flag in set(stand["status"].tolist())}
        names = ("status", "sample", "time", "steps", "rejected")
        numbers = zip(*(stand[name].tolist() for name in names), strict=True)  # one by one takes longer
        found = []
        for run, (status, count, end, steps, rejected) in enumerate(numbers):
            times = self._times[run][:count].copy()
            if status != End.RUNNING.flag:
                times[-1] = end
            history = History(
                scenario=self.scenarios[run],
                time=times,
                records=records[run, :count].copy(),
                status=ends[status],
                steps=steps,
                rejected=rejected,
                wall_time=share,
                progress=stand[run],  # a view of what no launch changes
                memory=memories[run],
            )
            found.append(history)
        return found
