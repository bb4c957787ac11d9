"""Run a KRL programme on paper: where the arm is, and when."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.robot.arm.cell import Arm, Cell
from helimag.robot.arm.frames import inverse
from helimag.robot.krl.executor import Executor
from helimag.robot.krl.machine import AwaitedInput, Leg, Machine, Switch
from helimag.robot.krl.routines import Module, module_of
from helimag.robot.krl.values import Value

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Playback:
    """What a programme does after its first motion, which brings the arm to the start.

    ``time`` (n,) in s is without the ramps where the arm starts and stops; ``flange`` (n, 4, 4) the flange in the arm's
    base frame, with samples inside every motion, and several at one time where a motion takes none. ``ramps`` is the
    time that starting and stopping adds. ``legs`` are the motions with what was set for each, ``switches`` the outputs
    set, ``awaited`` the inputs that the arm waits for, ``on_stop`` the outputs that are set when it is stopped. The
    path begins at ``begin`` (s), after the last wait for an input and the pause that follows it. ``faults`` are lines
    that can be understood, and that no controller takes.
    """

    time: Floats
    flange: Floats
    ramps: float
    legs: tuple[Leg, ...]
    switches: tuple[Switch, ...]
    awaited: tuple[AwaitedInput, ...] = ()
    on_stop: tuple[tuple[int, bool], ...] = ()
    begin: float = 0.0
    faults: tuple[str, ...] = ()

    @property
    def override_set(self) -> bool:
        """Whether the programme sets the override itself; where it does not, all of it is taken for granted."""
        return self.legs[-1].override is not None

    @property
    def duration(self) -> float:
        """Time from the first motion to the last stop (s)."""
        return float(self.time[-1]) + self.ramps

    def tool(self, cell: Cell) -> Floats:
        """Frames (n, 4, 4) of the cell's own tool in its lab frame, whatever the programme sets $BASE and $TOOL to."""
        return np.asarray(inverse(cell.lab_in_base) @ self.flange @ cell.tool_in_flange)


def play(src: str, dat: str, arm: Arm, *, interval: float = math.inf, inputs: Collection[int] = ()) -> Playback:
    """Interpret a programme.

    Parameters
    ----------
    src, dat
        Texts of the two files.
    arm
        Whose joint angles the programme's PTP motions name.
    interval
        Longest time (s) between two poses; there are five or more in each motion in any case, its end among them.
    inputs
        Numbers of the inputs that somebody answers on, so that the programme may wait for them.

    Returns
    -------
    Playback
        What arm and motor do over time.

    Raises
    ------
    InputError
        Where the programme uses what helimag does not follow, does not begin with joint angles, or lacks a setting; it
        names the line.
    """
    module = module_of(src, dat)
    machine = Machine(arm, interval)
    executor = Executor(module, machine, inputs)
    executor.run()
    if machine.joints is None or not machine.flanges:
        raise InputError("the programme has no motion that begins at joint angles (PTP to an E6AXIS)")
    if executor.kept:
        _check_again(machine, module, inputs, executor.kept)
    return Playback(
        np.array(machine.times),
        np.array(machine.flanges),
        machine.ramps,
        tuple(machine.legs),
        tuple(machine.switches),
        tuple(machine.awaited),
        executor.interrupts.on_stop,
        machine.begin,
        module.faults,
    )


def _check_again(first: Machine, module: Module, inputs: Collection[int], kept: Mapping[str, Value]) -> None:
    """Refuse a programme whose next run goes elsewhere, by what this one has left in its data list."""
    again = Machine(first.arm, first.interval)
    changed = ", ".join(sorted(kept))
    try:
        Executor(module, again, inputs, kept).run()
    except InputError as error:
        raise InputError(
            f"the programme changes {changed}, which its data list keeps, and cannot be run twice: {error}"
        ) from None
    if not _alike(first, again):
        raise InputError(
            f"the programme changes {changed}, which its data list keeps: run a second time, the arm goes elsewhere"
        )


def _alike(one: Machine, other: Machine) -> bool:
    """Whether two runs move the arm and switch its outputs alike."""
    if len(one.times) != len(other.times) or len(one.legs) != len(other.legs) or one.switches != other.switches:
        return False
    settings = all(a.settings == b.settings for a, b in zip(one.legs, other.legs, strict=True))
    return settings and bool(
        np.allclose(one.times, other.times, atol=1e-6) and np.allclose(one.flanges, other.flanges, atol=1e-7)
    )
