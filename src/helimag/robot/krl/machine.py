"""The arm under a programme: where its flange is, and when, as the motions follow each other.

An arm that passes a rounded point keeps its speed; it starts and stops with $ACC.CP. Between two orientations it turns
about one axis at a steady rate, in an arc with $CIRC_TYPE = #PATH relative to the path. Joint motions run at their
speed limits; their accelerations are not known and left out. The override slows all of that.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.robot.arm.cell import Arm
from helimag.robot.arm.frames import angles, frame, frames, inverse, turn_vector, vector_turn
from helimag.robot.arm.kinematics import forward, inverse_kinematics, principal
from helimag.robot.krl.course import Piece, check_course
from helimag.robot.krl.instructions import arc_angle, arc_centre
from helimag.robot.krl.settings import Setting, Settings
from helimag.robot.krl.values import Aggregate, Reference, Value, single, split

Floats = NDArray[np.float64]

FEWEST = 5  # poses in a motion
MOST = 200_000  # poses of a programme
MOTIONS = 20_000
ROUNDING = 2e-7  # m; a shorter way is the rounding of a turn on the spot, in single precision a metre away
VIA = 1e-5  # rad; between an auxiliary point's attitude and the arc's
SAME_ANGLE = 1e-6  # rad; a smaller turn is rounding
SAME_PLACE = 1e-12  # m, and of direction cosines: rounding of double precision
LONGEST = 1e6  # s; of one motion or pause
_JOINTS = tuple(f"A{i}" for i in range(1, 7))
_MORE_AXES = tuple(f"E{i}" for i in range(1, 7))


@dataclass(frozen=True)
class Leg:
    """One motion as it was carried out: its line, its length (m), what was set, and the joints (6,) at its end.

    ``first`` and ``last`` are the samples at its two ends; ``rounded`` says that the arm passes its end without a stop.
    ``ramps`` is the time that starting and stopping has added by its end (s). Of what was set, ``assumed`` hangs on
    what ran before the programme. The end of the programme is a leg too, of order ``end``.
    """

    line: int
    order: str
    length: float
    settings: dict[str, Setting]
    override: float | None
    joints: Floats
    first: int
    last: int
    rounded: bool = False
    ramps: float = 0.0
    assumed: frozenset[str] = frozenset()


@dataclass(frozen=True)
class AwaitedInput:
    """A digital input that the arm waits for: from when (s), which one, on or off, and after how many motions and
    switched outputs."""

    time: float
    input: int
    on: bool
    motions: int
    switched: int


@dataclass(frozen=True)
class Switch:
    """A digital output that is set: when (s), which one, to what, and after how many motions."""

    time: float
    output: int
    on: bool
    motions: int


@dataclass
class Machine:
    """The controller's state, and what has been recorded of it: flange frames in the arm's base frame."""

    arm: Arm
    interval: float
    settings: Settings = field(default_factory=Settings)
    joints: Floats | None = None
    times: list[float] = field(default_factory=list)
    flanges: list[Floats] = field(default_factory=list)
    ramps: float = 0.0
    running: float | None = None  # speed over acceleration at the last point that was passed; None when the arm stands
    legs: list[Leg] = field(default_factory=list)
    switches: list[Switch] = field(default_factory=list)
    awaited: list[AwaitedInput] = field(default_factory=list)
    begin: float = 0.0  # when the pause ends that follows the last wait for an input (s)

    def move(
        self, order: str, points: Sequence[Aggregate], roundings: Sequence[str], line: int, *, inside: bool = False
    ) -> None:
        """Carry out a motion; ``inside`` a spline block the arm passes its end without a stop.

        Raises
        ------
        InputError
            Where a setting that it needs is not set, or the arm cannot follow.
        """
        if len(self.legs) >= MOTIONS:
            raise InputError(f"the programme takes more than {MOTIONS} motions to follow")
        first = max(len(self.times) - 1, 0)
        if order in {"ptp", "ptp_rel"}:
            if roundings:
                raise InputError("rounding of a PTP is not followed")
            self.stop()
            length, rounded = 0.0, False
            self._to_joints(self._joint_target(points[0], relative=order == "ptp_rel"))
        else:
            rounded = inside or self._rounded(roundings)
            running = self.running
            length = self._along_path(order, points)
            if self._stayed:  # no controller passes a point on the way to that same point
                self.running, rounded = running, False
                self.stop()
            if not rounded:
                self._slow_down()
        self._record(line, order, length, first, rounded)

    @property
    def _stayed(self) -> bool:
        """Whether the last motion along a path, of ``FEWEST`` poses or more, has left the arm where it was."""
        return float(np.abs(self.flanges[-1] - self.flanges[-1 - FEWEST]).max()) < SAME_PLACE

    def check_course(self, legs: Sequence[Leg]) -> None:
        """Whether motions that have been carried out may stand in one spline block.

        Raises
        ------
        InputError
            Where their course hangs on the controller.
        """
        _, tool = self._frames
        pieces = []
        for leg in legs:
            poses = np.array(self.flanges[leg.first : leg.last + 1]) @ tool
            pieces.append(Piece(leg.order, self.times[leg.last] - self.times[leg.first], poses))
        check_course(pieces)

    def _record(self, line: int, order: str, length: float, first: int, rounded: bool) -> None:
        if self.joints is not None:
            kept, last = dict(self.settings.values), len(self.times) - 1
            override, ramps, assumed = self.settings.override, self.ramps, frozenset(self.settings.assumed)
            self.legs.append(
                Leg(line, order, length, kept, override, self.joints, first, last, rounded, ramps, assumed)
            )

    def wait(self, seconds: float) -> None:
        """Stand still."""
        if not 0.0 <= seconds <= LONGEST:
            raise InputError(f"WAIT SEC must be between 0 and {LONGEST:g} s; got {seconds:g}")
        self.stop()
        if self.flanges:
            self._add(self.times[-1] + seconds, self.flanges[-1])
            if self.awaited and self.awaited[-1].motions == len(self.legs):
                self.begin = self.times[-1]

    def wait_for(self, number: int, *, on: bool) -> None:
        """Stand still until an input is on or off; how long that takes is not the programme's, and not counted."""
        self.stop()
        self.begin = self.times[-1] if self.times else 0.0
        self.awaited.append(AwaitedInput(self.begin, number, on, len(self.legs), len(self.switches)))

    def switch(self, reference: Reference, value: Value) -> None:
        """Set a digital output; the arm stops for it, since no CONTINUE is honoured."""
        if reference.index is None or reference.parts or not isinstance(value, bool):
            raise InputError(f"expected $OUT[number] to be TRUE or FALSE; got {value!r}")
        self.stop()
        now = self.times[-1] if self.times else 0.0
        self.switches.append(Switch(now, reference.index, value, len(self.legs)))

    def end(self) -> None:
        """The programme is over."""
        self.stop()
        self._record(0, "end", 0.0, len(self.times) - 1, False)

    def stop(self) -> None:
        """The arm comes to a stand, whether it was to pass its last point or not."""
        if self.running is not None and self.legs and self.legs[-1].rounded:
            self.legs[-1] = replace(self.legs[-1], rounded=False)
        self._slow_down()

    def _slow_down(self) -> None:
        if self.running is not None:
            self.ramps += self.running / 2.0
        self.running = None

    def _rounded(self, roundings: Sequence[str]) -> bool:
        """Whether the arm passes the target; the setting that rules the rounding must be set."""
        for rounding in roundings:
            if rounding not in {"C_DIS", "C_ORI", "C_SPL"}:
                raise InputError(f"rounding by {rounding} is not followed")
            name = "$APO.CORI" if rounding == "C_ORI" else "$APO.CDIS"
            if not isinstance(self.settings.values.get(name), float):
                raise InputError(f"{name} must be set before a point is rounded by {rounding}")
        return bool(roundings) and self.settings.needed("$ADVANCE") > 0.0

    def _joint_target(self, point: Aggregate, *, relative: bool) -> Floats:
        _no_more_axes(point)
        given = {name: value for name, value in point.items() if name in _JOINTS}
        if set(point) - set(_JOINTS) - set(_MORE_AXES) or not given:
            raise InputError(
                "expected PTP to joint angles A1 to A6; to a pose it depends on status and turn, which are not followed"
            )
        if self.joints is None and (len(given) < len(_JOINTS) or relative):
            raise InputError("the first motion must be a PTP to all six joint angles A1 to A6")
        now = np.zeros(6) if self.joints is None else self.joints
        values = [math.radians(_plain(given[name])) if name in given else None for name in _JOINTS]
        if relative:
            return np.array([a + (v or 0.0) for a, v in zip(now, values, strict=True)])
        return np.array([a if v is None else v for a, v in zip(now, values, strict=True)])

    def _to_joints(self, target: Floats) -> None:
        if not np.abs(target).max() <= 20.0 * math.pi:
            raise InputError("joint angles must be within ten turns")
        percent = np.array([self.settings.needed(f"$VEL_AXIS[{i}]") for i in range(1, 7)])
        if self.joints is None:
            self.joints = target
            self._add(0.0, forward(self.arm, target))
            return
        speeds = percent / 100.0 * self.settings.speed_share * np.array(self.arm.joint_speed)
        duration = _sane(float(np.max(np.abs(target - self.joints) / speeds)))
        begin, before = self.times[-1], self.joints
        self.joints = target
        for share in self._shares(duration):
            self._add(begin + share * duration, forward(self.arm, before + share * (target - before)))

    @property
    def _frames(self) -> tuple[Floats, Floats]:
        """$BASE in the arm's base frame, and $TOOL at the flange."""
        for name in ("$BASE", "$TOOL"):
            if name not in self.settings.frames:
                raise InputError(f"{name} must be set before this motion")
        base, tool = (frame(*split(self.settings.frames[name])) for name in ("$BASE", "$TOOL"))
        return base, tool

    def _along_path(self, order: str, points: Sequence[Aggregate]) -> float:
        """Carry out a line or an arc; returns its length (m)."""
        if self.joints is None:
            raise InputError("the first motion must be a PTP to joint angles")
        base, tool = self._frames
        start = inverse(base) @ self.flanges[-1] @ tool
        target = _target(start, points[-1], relative=order == "lin_rel")
        if self.settings.word("$ORI_TYPE") == "#CONSTANT":
            target = frames(target[:3, 3], start[:3, :3])
        if order == "circ":
            via = _target(start, points[0], relative=False)
            length, duration, poses = self._arc(start, via[:3, 3], target)
            if set(points[0]) & set("ABC"):
                _through(start, via, target, poses)
        else:
            length, duration, poses = self._line(start, target)
        pace = length / duration / self.settings.needed("$ACC.CP") if duration > 0.0 and length > ROUNDING else 0.0
        if self.running is None:
            self.ramps += pace / 2.0
        self.running = pace
        flanges = base @ poses @ inverse(tool)
        begin = self.times[-1]
        for share, flange in zip(self._shares(duration), flanges, strict=True):
            self._add(begin + share * duration, flange)
        self._follow(flanges)
        return length

    def _line(self, start: Floats, target: Floats) -> tuple[float, float, Floats]:
        """Length (m), duration (s) and poses of a line; the slower of way and turn sets the pace."""
        length = float(np.linalg.norm(target[:3, 3] - start[:3, 3]))
        by = vector_turn(start[:3, :3].T @ target[:3, :3])
        angle = float(np.linalg.norm(by))
        duration = length / self._path_speed if length > ROUNDING else 0.0
        if angle > SAME_ANGLE:
            slowest = min(self.settings.needed(f"$VEL.ORI{i}") for i in (1, 2))
            duration = max(duration, angle / math.radians(slowest) / self.settings.speed_share)
        share = np.array(self._shares(_sane(duration)))[:, None]
        positions = start[:3, 3] + share * (target[:3, 3] - start[:3, 3])
        return length, duration, frames(positions, start[:3, :3] @ turn_vector(share * by))

    def _arc(self, start: Floats, via: Floats, target: Floats) -> tuple[float, float, Floats]:
        """Length (m), duration (s) and poses of an arc, whose pace is the path's; the tool turns with it if so set."""
        try:
            turned = arc_angle(start[:3, 3], via, target[:3, 3])
            centre = arc_centre(start[:3, 3], via, target[:3, 3])
        except ValueError as error:
            raise InputError(str(error)) from None
        normal = np.cross(via - start[:3, 3], target[:3, 3] - start[:3, 3])
        whole = turned * normal / np.linalg.norm(normal)
        length = turned * float(np.linalg.norm(start[:3, 3] - centre))
        duration = _sane(length / self._path_speed)
        share = np.array(self._shares(duration))[:, None]
        turning = turn_vector(share * whole)
        positions = centre + np.einsum("nij,j->ni", turning, start[:3, 3] - centre)
        along = self.settings.word("$CIRC_TYPE") == "#PATH"
        path = turning if along else np.broadcast_to(np.eye(3), turning.shape)
        rest = np.zeros(3)
        if self.settings.word("$ORI_TYPE") != "#CONSTANT":
            end = turn_vector(whole) if along else np.eye(3)
            rest = vector_turn(start[:3, :3].T @ end.T @ target[:3, :3])
        return length, duration, frames(positions, path @ start[:3, :3] @ turn_vector(share * rest))

    @property
    def _path_speed(self) -> float:
        return self.settings.needed("$VEL.CP") * self.settings.speed_share

    def _follow(self, flanges: Floats) -> None:
        """Keep track of the joint angles: at every pose the branch and whole turns nearest to those before."""
        for branches in inverse_kinematics(self.arm, flanges).joints:
            step = principal(branches - self.joints)
            size = np.where(np.isfinite(step).all(axis=1), np.abs(step).max(axis=1), np.inf)
            if not size.min() < math.pi / 2.0:
                raise InputError("the arm cannot follow this motion")
            self.joints = self.joints + step[int(np.argmin(size))]

    def _shares(self, duration: float) -> Sequence[float]:
        count = max(FEWEST, math.ceil(duration / self.interval))
        if len(self.times) + count > MOST:
            raise InputError(f"the programme takes more than {MOST} poses to follow")
        return [float(share) for share in np.linspace(0.0, 1.0, count + 1)[1:]]

    def _add(self, time: float, flange: Floats) -> None:
        self.times.append(time)
        self.flanges.append(flange)


def _target(start: Floats, point: Aggregate, *, relative: bool) -> Floats:
    """The frame (4, 4) that a point names; what it does not name stays as it is at the start."""
    _no_more_axes(point)
    foreign = set(point) - set("XYZABCST") - set(_MORE_AXES)
    given = {name: _plain(value) for name, value in point.items() if name in set("XYZABC")}
    if foreign or not given:
        raise InputError(f"expected a pose with X, Y, Z, A, B or C; got {', '.join(sorted(point)) or 'nothing'}")
    now = dict(zip("XYZABC", (*(1e3 * start[:3, 3]), *np.degrees(angles(start[:3, :3]))), strict=True))
    if relative:
        if any(given.get(name, 0.0) != 0.0 for name in "ABC"):
            raise InputError("LIN_REL with a turn is not followed")
        shift = np.array([given.get(name, 0.0) for name in "XYZ"]) / 1e3
        return frames(start[:3, 3] + shift, start[:3, :3])
    if not set(given) & set("ABC"):
        position = np.array([given.get(name, now[name]) for name in "XYZ"]) / 1e3
        return frames(position, start[:3, :3])
    whole = {**now, **given}  # the arm's own components are not rounded
    return frame(np.array([whole[name] for name in "XYZ"]) / 1e3, np.radians([whole[name] for name in "ABC"]))


def _through(start: Floats, via: Floats, target: Floats, poses: Floats) -> None:
    """Refuse an auxiliary point whose attitude is not the arc's there: some controllers go through it, some do not."""
    share = arc_angle(start[:3, 3], via[:3, 3], target[:3, 3])
    centre = arc_centre(start[:3, 3], via[:3, 3], target[:3, 3])
    first, there = start[:3, 3] - centre, via[:3, 3] - centre
    normal = np.cross(via[:3, 3] - start[:3, 3], target[:3, 3] - start[:3, 3])
    at = math.atan2(float(np.cross(first, there) @ normal) / float(np.linalg.norm(normal)), float(first @ there))
    step = vector_turn(start[:3, :3].T @ poses[0, :3, :3]) * len(poses)  # the tool turns steadily about one axis
    expected = start[:3, :3] @ turn_vector(step * (at % (2.0 * math.pi)) / share)
    off = float(np.linalg.norm(vector_turn(expected.T @ via[:3, :3])))
    if off > VIA:
        raise InputError(
            f"the auxiliary point's A, B, C are {math.degrees(off):.3g} deg off the arc's attitude there; "
            "whether the arm turns to them hangs on the controller ($CIRC_MODE)"
        )


def _no_more_axes(point: Aggregate) -> None:
    moved = [name for name in _MORE_AXES if point.get(name, 0.0) != 0.0]
    if moved:
        raise InputError(f"{', '.join(moved)}: further axes than six are not followed")


def _plain(value: Any) -> float:
    if isinstance(value, (bool, str, dict)):
        raise InputError(f"expected a number; got {value!r}")
    return single(value)


def _sane(duration: float) -> float:
    if not duration <= LONGEST:
        raise InputError(f"the motion would take {duration:g} s")
    return duration
