"""Run a KRL programme on paper: where the tool is, and when.

Reals are rounded to single precision, as the controller holds them. An arm that passes a rounded point keeps its
speed; it starts and stops with $ACC.CP. Between two orientations it turns about one axis at a steady rate, in an arc
with $CIRC_TYPE = #PATH relative to the path. Joint motions run at their speed limits; their accelerations are not
known and left out.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.robot.arm.cell import Arm
from helimag.robot.arm.frames import frame, frames, inverse, turn_vector, vector_turn
from helimag.robot.arm.kinematics import forward, inverse_kinematics, principal
from helimag.robot.krl.instructions import arc_angle, arc_centre
from helimag.robot.krl.reader import Assign, Move, Statement, Wait, read_krl

Floats = NDArray[np.float64]

FEWEST = 5  # poses in a motion
ROUNDING = 1e-6  # m; a shorter way is the rounding of a turn on the spot


@dataclass(frozen=True)
class Playback:
    """What a programme does after its first motion, which brings the arm to the start.

    ``time`` (n,) in s is without the ramps where the arm starts and stops; ``pose`` (n, 4, 4) the tool in $BASE, with
    samples inside every motion, and two at one time where the arm stands still. ``ramps`` is the time that starting
    and stopping adds.
    """

    time: Floats
    pose: Floats
    ramps: float
    start_joints: Floats

    @property
    def duration(self) -> float:
        """Time from the first motion to the last stop (s)."""
        return float(self.time[-1]) + self.ramps


def play(src: str, dat: str, arm: Arm, *, interval: float = math.inf) -> Playback:
    """Interpret a programme.

    Parameters
    ----------
    src, dat
        Texts of the two files.
    arm
        Whose joint angles the programme's PTP motions name.
    interval
        Longest time (s) between two poses; there are five or more in each motion in any case, its end among them.

    Raises
    ------
    InputError
        Where the programme uses what helimag does not read, does not begin with joint angles, or lacks a speed.
    """
    machine = _Machine(arm, interval)
    for statement in read_krl(src, dat):
        machine.take(statement)
    if machine.joints is None or not machine.poses:
        raise InputError("the programme has no motion that begins at joint angles (PTP to an E6AXIS)")
    return Playback(np.array(machine.times), np.array(machine.poses), machine.ramps, machine.start_joints)


@dataclass
class _Machine:
    """The controller's state."""

    arm: Arm
    interval: float
    base: Floats = field(default_factory=lambda: np.eye(4))
    tool: Floats = field(default_factory=lambda: np.eye(4))
    real: dict[str, float] = field(default_factory=dict)
    word: dict[str, str] = field(default_factory=dict)
    joints: Floats | None = None
    start_joints: Floats = field(default_factory=lambda: np.zeros(6))
    times: list[float] = field(default_factory=list)
    poses: list[Floats] = field(default_factory=list)
    ramps: float = 0.0
    running: float | None = (
        None  # speed over acceleration with which the arm passes the last point; None when it stands
    )

    def take(self, statement: Statement) -> None:
        match statement:
            case Assign():
                self._assign(statement)
            case Wait():
                self._stop()
                self._stand(_single(statement.seconds))
            case Move(order="ptp"):
                self._stop()
                self._joints(statement)
            case Move():
                self._line_or_arc(statement)

    def _assign(self, statement: Assign) -> None:
        match statement.value:
            case dict() as aggregate:
                if statement.variable in {"$BASE", "$TOOL"}:
                    setattr(self, statement.variable[1:].lower(), _frame(aggregate))
            case str() as word:
                self.word[statement.variable] = word
            case value:
                self.real[statement.variable] = _single(value)

    def _joints(self, statement: Move) -> None:
        (point,) = statement.points
        if not all(f"A{i}" in point for i in range(1, 7)):
            raise InputError(
                f".src file, line {statement.line}: expected PTP to six joint angles A1 to A6; got {point}"
            )
        target = np.radians([_single(point[f"A{i}"]) for i in range(1, 7)])
        if self.joints is None:
            self.joints = self.start_joints = target
            self._add(0.0, self._tool_at(target))
            return
        percent = np.array([self._needed(f"$VEL_AXIS[{i}]", statement) for i in range(1, 7)])
        duration = float(np.max(np.abs(target - self.joints) / (percent / 100.0 * np.array(self.arm.joint_speed))))
        begin, before = self.times[-1], self.joints
        self.joints = target
        for share in self._shares(duration):
            self._add(begin + share * duration, self._tool_at(before + share * (target - before)))

    def _tool_at(self, joints: Floats) -> Floats:
        return np.asarray(inverse(self.base) @ forward(self.arm, joints) @ self.tool)

    def _line_or_arc(self, statement: Move) -> None:
        if not self.poses:
            raise InputError(f".src file, line {statement.line}: the first motion must be a PTP to joint angles")
        begin, start = self.times[-1], self.poses[-1]
        target = _frame(statement.points[-1])
        by = vector_turn(start[:3, :3].T @ target[:3, :3])
        angle = float(np.linalg.norm(by))
        if statement.order == "circ":
            via = _frame(statement.points[0])[:3, 3]
            try:
                turned = arc_angle(start[:3, 3], via, target[:3, 3])
                centre = arc_centre(start[:3, 3], via, target[:3, 3])
            except ValueError as error:
                raise InputError(f".src file, line {statement.line}: {error}") from None
            normal = np.cross(via - start[:3, 3], target[:3, 3] - start[:3, 3])
            normal = normal / np.linalg.norm(normal)
            length = turned * float(np.linalg.norm(start[:3, 3] - centre))
            along = self.word.get("$CIRC_TYPE", "#PATH") == "#PATH"
            angle = 0.0  # an arc's pace is the path's
        else:
            length = float(np.linalg.norm(target[:3, 3] - start[:3, 3]))
        moving = length > ROUNDING or statement.order == "circ"
        speed = self._needed("$VEL.CP", statement) if moving else 0.0
        duration = length / speed if moving else 0.0
        if angle > 0.0:
            duration = max(duration, angle / math.radians(min(self._needed(f"$VEL.ORI{i}", statement) for i in (1, 2))))
        shares = self._shares(duration)
        if statement.order == "circ":
            poses = _arc(start, target, centre, turned * normal, along, shares)
        else:
            poses = _line(start, target, by, shares)
        pace = length / duration / self._needed("$ACC.CP", statement) if moving else 0.0
        if self.running is None:
            self.ramps += pace / 2.0
        for share, pose in zip(shares, poses, strict=True):
            self._add(begin + share * duration, pose)
        self._follow(poses, statement)
        self.running = pace
        if not statement.rounded:
            self._stop()

    def _follow(self, poses: Floats, statement: Move) -> None:
        """Keep track of the joint angles: at every pose the branch and whole turns nearest to those before."""
        flange = self.base @ poses @ inverse(self.tool)
        for branches in inverse_kinematics(self.arm, flange).joints:
            step = principal(branches - self.joints)
            size = np.where(np.isfinite(step).all(axis=1), np.abs(step).max(axis=1), np.inf)
            if not size.min() < math.pi / 2.0:
                raise InputError(f".src file, line {statement.line}: the arm cannot follow this motion")
            self.joints = self.joints + step[int(np.argmin(size))]

    def _stop(self) -> None:
        if self.running is not None:
            self.ramps += self.running / 2.0
        self.running = None

    def _stand(self, duration: float) -> None:
        if not self.poses:
            return
        self._add(self.times[-1] + duration, self.poses[-1])

    def _shares(self, duration: float) -> Sequence[float]:
        count = max(FEWEST, math.ceil(duration / self.interval))
        return [float(share) for share in np.linspace(0.0, 1.0, count + 1)[1:]]

    def _add(self, time: float, pose: Floats) -> None:
        self.times.append(time)
        self.poses.append(pose)

    def _needed(self, variable: str, statement: Move) -> float:
        value = self.real.get(variable)
        if value is None or not value > 0.0:
            raise InputError(
                f".src file, line {statement.line}: {variable} must be set to a positive number before this motion"
            )
        return value


def _single(value: float) -> float:
    return float(np.float32(value))


def _frame(point: dict[str, float]) -> Floats:
    """The frame of a point in mm and degrees."""
    missing = [name for name in "XYZABC" if name not in point]
    if missing:
        raise InputError(f"a pose needs X, Y, Z, A, B and C; it lacks {', '.join(missing)}")
    position = np.array([_single(point[name]) for name in "XYZ"]) / 1e3
    return frame(position, np.radians([_single(point[name]) for name in "ABC"]))


def _line(start: Floats, target: Floats, by: Floats, shares: Sequence[float]) -> Floats:
    share = np.array(shares)[:, None]
    positions = start[:3, 3] + share * (target[:3, 3] - start[:3, 3])
    return frames(positions, start[:3, :3] @ turn_vector(share * by))


def _arc(start: Floats, target: Floats, centre: Floats, turned: Floats, along: bool, shares: Sequence[float]) -> Floats:
    """Poses on an arc by the vector ``turned`` (rad) about ``centre``; the tool turns with it where ``along``."""
    share = np.array(shares)[:, None]
    turning = turn_vector(share * turned)
    positions = centre + np.einsum("nij,j->ni", turning, start[:3, 3] - centre)
    path = turning if along else np.broadcast_to(np.eye(3), turning.shape)
    whole = turn_vector(turned) if along else np.eye(3)
    rest = vector_turn(start[:3, :3].T @ whole.T @ target[:3, :3])
    return frames(positions, path @ start[:3, :3] @ turn_vector(share * rest))
