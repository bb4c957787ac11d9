"""What a programme does, against the plan it was written from: where the magnet is, when, and what was set."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from helimag.robot.arm.cell import Cell
from helimag.robot.arm.path import tool_frames
from helimag.robot.arm.planning import ArmPlan
from helimag.robot.arm.retreat import APPROACH_SPEED, retreat_frames
from helimag.robot.krl.instructions import Order, instructions
from helimag.robot.krl.interpreter import Playback
from helimag.robot.krl.machine import ROUNDING, Leg
from helimag.robot.krl.sequence import APPROACH, Awaited, Output, handshake, lead_time
from helimag.robot.krl.settings import DEFAULTS, Setting
from helimag.robot.krl.values import single
from helimag.robot.krl.writer import load_settings, number, standing

Floats = NDArray[np.float64]

POSITION = 1e-6  # m; these three are what a programme is held to
AXIS = 1e-6  # rad
TIMING = 1e-3  # of the duration
JOINTS = 1e-6  # rad; at the ends of joint motions
PACE = 2e-3  # of a motion's own duration: how much later or earlier it may make the arm
SINGLE = 1e-6  # of a setting: single precision after a little arithmetic
ARM = 1.0  # m; weighs axis against position where times are matched: a yawing axis tells the time best
TO_START = 2  # motions: by the joints, and on by a line as short as their rounding
STEP = 1e-3  # s; of the differences that give the speed
NEARLY = 1e-4  # m; a line that is meant to be the way up
LEAD = 1e-4  # s; of the motor's phase: a tenth of a degree at 3 Hz
SLACK = 1e-3  # s; programme times carry the rounding of the speeds
_BY_JOINTS = frozenset({"ptp", "ptp_rel"})
_OF_JOINTS = ("$VEL_AXIS", "$ACC_AXIS", "$ADVANCE", "$LOAD")
_UNUSED = frozenset({"$APO.CPTP", "$APO.CVEL"})  # of roundings that are refused
_ON_PATH = frozenset({"lin", "circ", "spl", "lin_rel"})


@dataclass(frozen=True)
class Deviation:
    """Largest deviations of a programme: position (m), attitude (rad), timing (share of the duration).

    The attitude is the tool's: its x axis is the magnet's rotation axis, and a turn about that turns the magnet too.

    ``differences`` are settings, joint angles and outputs that are not the plan's, each in a line of words.
    """

    position: float
    axis: float
    timing: float
    duration: float
    differences: tuple[str, ...] = ()

    @property
    def acceptable(self) -> bool:
        """Whether all three are within 1 um, 1e-6 rad and 0.1 %, and nothing else differs."""
        within = self.position < POSITION and self.axis < AXIS and self.timing < TIMING
        return within and not self.differences


def deviation(plan: ArmPlan, playback: Playback) -> Deviation:
    """Compare a programme with the plan.

    Every pose of the programme is held against the nearest planned pose around its time: what is left is the
    deviation in position and axis, and how far in time that pose lies is the deviation in timing, as is the
    difference in duration with the ramps of start and stop. An unwinding is compared in position only: the rotation
    axis leaves the path there on purpose. Every setting that could change a motion is held against what the plan
    would have written, whether the motions at hand need it or not.
    """
    from scipy.spatial.transform import Rotation

    on_way_up = tuple(_up(plan, playback))
    beside = (*_handshake(plan, playback), *_switches(plan, playback))
    playback = on_path(plan.cell, playback)
    times, unwinding = path_time(plan, playback.time)
    sign = -1.0 if plan.reversed_axis else 1.0
    pose = playback.tool(plan.cell)
    position, axis = pose[:, :3, 3], sign * pose[:, :3, 0]  # of the magnet
    late = np.where(unwinding, 0.0, _lateness(plan, times, position, axis))
    planned = plan.path.at(_inside(plan, times - late))
    away = np.linalg.norm(position - planned.position, axis=1)
    wanted = tool_frames(planned, plan.roll, plan.reversed_axis)[:, :3, :3]
    # the whole tool is held to its attitude: a turn about the motor's axis would turn the magnet with it
    turned = Rotation.from_matrix(np.swapaxes(wanted, 1, 2) @ pose[:, :3, :3]).magnitude()
    late_at_end = playback.duration - plan.duration
    timing = max(float(np.abs(late).max()), abs(late_at_end)) / plan.duration
    differences = (
        *playback.faults,
        *_paces(plan, playback, late),
        *_settings(plan, playback),
        *_assumed(playback),
        *_joints(plan, playback),
        *on_way_up,
        *beside,
    )
    off_axis = float(turned[~unwinding].max())
    return Deviation(float(away.max()), off_axis, timing, playback.duration, tuple(dict.fromkeys(differences)))


def on_path(cell: Cell, playback: Playback) -> Playback:
    """A programme without the way up at its end, its time counted from when the path begins."""
    legs, until = playback.legs, playback.time.size
    ramps = playback.ramps
    way_up = _way_up(cell, playback)
    if way_up is not None:
        legs = tuple(leg for leg in legs if leg is not way_up)
        until, ramps = way_up.first + 1, max((leg.ramps for leg in legs if leg.last <= way_up.first), default=0.0)
    time = playback.time[:until] - playback.begin
    return replace(playback, time=time, flange=playback.flange[:until], ramps=ramps, legs=legs, begin=0.0)


def _way_up(cell: Cell, playback: Playback) -> Leg | None:
    """The last motion, where it is a line up by the cell's retreat."""
    moves = [leg for leg in playback.legs if leg.order != "end"]
    if cell.retreat is None or len(moves) < 3 or moves[-1].order != "lin":
        return None
    first, last = playback.tool(cell)[[moves[-1].first, moves[-1].last], :3, 3]
    return moves[-1] if np.abs(last - first - [0.0, 0.0, cell.retreat]).max() < NEARLY else None


def _up(plan: ArmPlan, playback: Playback) -> Iterator[str]:
    """Whether the arm goes up from the end of the path as planned: where to, how fast, and nothing behind it."""
    height, leg = plan.cell.retreat, _way_up(plan.cell, playback)
    if height is None:
        return
    if leg is None:
        yield f"the programme does not go up by {1e3 * height:g} mm at its end"
        return
    pose = playback.tool(plan.cell)[[leg.first, leg.last]]
    off = np.abs(pose - retreat_frames(plan, np.array([0.0, height])))
    if off[:, :3, 3].max() > POSITION or off[:, :3, :3].max() > AXIS:
        yield f"{_where(leg)}: the last motion is not the way up by {1e3 * height:g} mm from the end of the path"
    if not _alike(leg.settings.get("$VEL.CP", 0.0), _value(number(APPROACH_SPEED, 10))):
        yield f"{_where(leg)}: $VEL.CP is not the plan's on the way up, {APPROACH_SPEED:g}"
    if playback.time[-1] > playback.time[leg.last] + SLACK:
        yield f"{_where(leg)}: the programme goes on behind the way up"


def _handshake(plan: ArmPlan, playback: Playback) -> Iterator[str]:
    """Whether the programme waits for the motor as planned, begins in phase, and stops it when the arm is stopped."""
    wanted = [(step.number, step.on) for step in handshake(plan) if isinstance(step, Awaited)]
    found = [(each.input, each.on) for each in playback.awaited]
    if found != wanted:
        yield f"inputs: the programme waits for {_states('$IN', found)}; the plan for {_states('$IN', wanted)}"
    elif any(each.motions != TO_START for each in playback.awaited):
        yield "inputs: the programme does not wait for the motor where the path begins"
    elif any(each.switched != 1 for each in playback.awaited):  # the motor, and not yet the run
        yield "inputs: the programme does not wait for the motor between switching it on and the beginning of the path"
    lead = playback.begin - (playback.awaited[-1].time if playback.awaited else 0.0)
    if abs(lead - lead_time(plan)) > LEAD:
        yield f"the path begins {lead:.6f} s after the motor's phase reference; the plan has {lead_time(plan):.6f} s"
    motor = plan.cell.motor
    off = () if motor is None else ((motor.run_output, False),)
    if playback.on_stop != off:
        yield f"on a stop the programme sets {_states('$OUT', playback.on_stop)}; the plan {_states('$OUT', off)}"


def _lateness(plan: ArmPlan, times: Floats, position: Floats, axis: Floats) -> Floats:
    """How much later (s) than planned the magnet is where it is: Gauss-Newton on position and ``ARM`` times axis."""
    late = np.zeros_like(times)
    for _ in range(2):
        now = times - late
        before, here, after = (plan.path.at(_inside(plan, now + shift)) for shift in (-STEP, 0.0, STEP))
        span = np.maximum(after.time - before.time, STEP)[:, None]
        rate = np.concatenate([after.position - before.position, ARM * (after.axis - before.axis)], axis=1) / span
        ahead = np.concatenate([position - here.position, ARM * (axis - here.axis)], axis=1)
        square = np.einsum("ni,ni->n", rate, rate)
        late -= np.where(square > 0.0, np.einsum("ni,ni->n", ahead, rate) / np.where(square > 0.0, square, 1.0), 0.0)
    return late


def _inside(plan: ArmPlan, times: Floats) -> Floats:
    return np.clip(times, 0.0, plan.path.duration)


def path_time(plan: ArmPlan, times: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Path times of programme times (n,), and whether the arm is unwinding then."""
    path_times = times.copy()
    unwinding = np.zeros(times.shape, dtype=bool)
    delay = 0.0
    for unwound in plan.unwindings:
        begin = unwound.time + delay
        inside = (times > begin + SLACK) & (times < begin + unwound.duration - SLACK)
        unwinding |= inside
        delay += unwound.duration
        path_times = np.where(
            inside, unwound.time, np.where(times >= begin + unwound.duration - SLACK, times - delay, path_times)
        )
    return path_times, unwinding


def _paces(plan: ArmPlan, playback: Playback, late: Floats) -> Iterator[str]:
    """Motions that are faster or slower than planned, though the programme as a whole is in time.

    A programme with as many motions as the plan is held to the plan's times and stops one by one; another, which may
    cut the same path into other pieces, to losing or gaining no time in a motion. Motions as short as the rounding of
    single precision cannot be timed.
    """
    legs = [leg for leg in playback.legs if leg.order in _ON_PATH]
    planned = _planned_motions(plan)
    one_by_one = len(legs) == len(planned)
    for i, leg in enumerate(legs):
        took = float(playback.time[leg.last] - playback.time[leg.first])
        wanted, rounded, on_spot = planned[i] if one_by_one else (took, leg.rounded, False)
        off = abs(took - wanted)
        if not one_by_one and leg.length > POSITION:
            off = abs(float(late[leg.last] - late[leg.first]))
        extent = max(ARM * _turned(playback, leg) if on_spot else leg.length, ROUNDING)
        if off > max(took, wanted) * (PACE + POSITION / extent):
            yield f"line {leg.line}: the motion takes {took:.6g} s, {off:.3g} s off the plan"
        if leg.rounded is not rounded and i < len(legs) - 1:
            yield f"line {leg.line}: the point is {'' if leg.rounded else 'not '}rounded, unlike the plan's"
    stops, meant = sum(not leg.rounded for leg in legs), sum(not rounded for _, rounded, _ in planned)
    if not one_by_one and stops != meant:
        yield f"the arm stops {stops} times along the path; the plan has {meant} stops"


def _turned(playback: Playback, leg: Leg) -> float:
    """The chord (rad, for small angles) by which the flange turns in a motion."""
    return float(np.abs(playback.flange[leg.last, :3, :3] - playback.flange[leg.first, :3, :3]).max())


def _planned_motions(plan: ArmPlan) -> list[tuple[float, bool, bool]]:
    """How long (s) each motion along the path takes as it is written, whether it is rounded, whether it only turns.

    To the path's own come those to the start, and back to the path after unwinding.
    """
    motions = [(0.0, False, False)]
    for order in instructions(plan):
        if order.order is Order.JOINTS:
            motions.append((0.0, False, False))
        elif order.order is not Order.WAIT:
            motions.append((order.end - order.begin, order.rounded, order.order is Order.TURN))
    return motions


def _settings(plan: ArmPlan, playback: Playback) -> Iterator[str]:
    """Settings that are not the plan's at a motion, or at the end."""
    wanted = {name: _value(text) for name, text in (standing(plan) | load_settings(plan.cell.load)).items()}
    speeds = {_value(number(order.speed, 10)) for order in instructions(plan) if order.order in {Order.LINE, Order.ARC}}
    for i, leg in enumerate(playback.legs):
        allowed: dict[str, set[Setting]] = {name: {value} for name, value in wanted.items()}
        percents = {float(APPROACH) if i == 0 else float(plan.cell.joint_percent)}
        if leg.order != "ptp":
            percents.add(float(APPROACH))
        allowed |= {f"$VEL_AXIS[{axis}]": set(percents) for axis in range(1, 7)}
        if leg.length <= POSITION:  # longer ones tell by their timing
            approach = _value(number(APPROACH_SPEED, 10))
            allowed["$VEL.CP"] = {approach} if i == 1 else {approach, *speeds}
        yield from _unlike(leg, allowed)
        if i > 1 and leg.override not in {None, 100.0}:
            yield f"{_where(leg)}: $OV_PRO is {leg.override:g}; the plan has 100"
        if i == 1 and leg.order not in _BY_JOINTS and "$VEL.CP" not in leg.settings:  # of no length, so it needs none
            yield f"{_where(leg)}: $VEL.CP is not set"


def _assumed(playback: Playback) -> Iterator[str]:
    """Settings that hang on what ran before the programme, each at the first motion that they can change."""
    told: set[str] = set()
    for leg in playback.legs:
        for name in sorted(name for name in leg.assumed - told if _matters(name, leg)):
            told.add(name)
            yield f"{_where(leg)}: {name} is what ran before left it at; set it, or call BAS (#INITMOV,0)"


def _value(text: str) -> Setting:
    return text if text.startswith("#") else single(float(text))


def _unlike(leg: Leg, allowed: dict[str, set[Setting]]) -> Iterator[str]:
    """Differences between what is set at one motion and what may be; what the plan leaves alone must be left alone."""
    for name in _standing(allowed):
        if name not in leg.settings and _matters(name, leg):
            yield f"{_where(leg)}: {name} is not set"
    for name, value in leg.settings.items():
        if not _matters(name, leg):
            continue
        choices = allowed.get(name)
        if choices is None and (name == "$VEL.CP" or value == DEFAULTS.get(name)):
            continue
        if choices is None:
            yield f"{_where(leg)}: {name} is {_shown(value)}; the plan leaves it as it is"
        elif not any(_alike(value, choice) for choice in choices):
            planned = " or ".join(map(_shown, sorted(choices, key=str)))
            yield f"{_where(leg)}: {name} is {_shown(value)}; the plan has {planned}"


def _matters(name: str, leg: Leg) -> bool:
    """Whether a setting can change a motion: those of the path do not change one of the joints to joint angles."""
    return name not in _UNUSED and (leg.order not in _BY_JOINTS or name.startswith(_OF_JOINTS))


def _standing(allowed: dict[str, set[Setting]]) -> list[str]:
    """The settings that must not be left to the controller; a speed that a motion lacks has been refused before."""
    return [name for name in allowed if name not in {"$VEL.CP", *(f"$VEL_AXIS[{axis}]" for axis in range(1, 7))}]


def _alike(value: Setting, planned: Setting) -> bool:
    """Equal words, or numbers equal to the rounding of single precision."""
    if isinstance(value, str) or isinstance(planned, str):
        return value == planned
    return abs(value - planned) <= SINGLE * abs(planned)


def _where(leg: Leg) -> str:
    return "at the end" if leg.order == "end" else f"line {leg.line}"


def _shown(value: Setting) -> str:
    return value if isinstance(value, str) else f"{value:.9g}"


def _joints(plan: ArmPlan, playback: Playback) -> Iterator[str]:
    """Joint motions that do not end where the plan has the joints: a wrist may be whole turns off in the same pose."""
    times = [0.0, *(unwinding.time for unwinding in plan.unwindings)]
    wanted = [plan.joints[int(np.searchsorted(plan.times, time - 1e-9))] for time in times]
    found = [leg for leg in playback.legs if leg.order in _BY_JOINTS]
    if len(found) != len(wanted):
        yield f"the programme has {len(found)} joint motions; the plan has {len(wanted)}"
    for leg, joints in zip(found, wanted, strict=False):
        off = np.abs(leg.joints - joints)
        if off.max() > JOINTS:
            worst = int(np.argmax(off))
            yield (
                f"{_where(leg)}: A{worst + 1} goes to {np.degrees(leg.joints[worst]):.6f} deg; "
                f"the plan has {np.degrees(joints[worst]):.6f} deg"
            )
    ends = [leg for leg in playback.legs if leg.order == "end"]
    last = plan.joints[-1]
    if ends and np.abs(ends[-1].joints - last).max() > np.pi:
        yield "at the end the wrist is whole turns off the plan's"


def _switches(plan: ArmPlan, playback: Playback) -> Iterator[str]:
    """Outputs that are switched otherwise than planned."""
    on = [step.number for step in handshake(plan) if isinstance(step, Output)]
    wanted = [*((number, True) for number in on), *((number, False) for number in reversed(on))]
    found = [(switch.output, switch.on) for switch in playback.switches]
    if found != wanted:
        yield f"outputs: the programme switches {_states('$OUT', found)}; the plan {_states('$OUT', wanted)}"
        return
    late = TIMING * plan.duration
    moves = [leg for leg in playback.legs if leg.order != "end"]
    along = len(moves) - (_way_up(plan.cell, playback) is not None)
    for switch in playback.switches:
        if switch.motions != (TO_START if switch.on else along):
            where = "where the path begins" if switch.on else "where it ends"
            yield f"$OUT[{switch.output}]={'TRUE' if switch.on else 'FALSE'} does not stand {where}"
        begins = 0.0 if plan.cell.motor is not None and switch.output == plan.cell.motor.run_output else playback.begin
        due = begins if switch.on else playback.begin + plan.duration
        if abs(switch.time - due) > late:
            yield f"$OUT[{switch.output}] is not switched at the beginning and the end of the path"


def _states(kind: str, entries: Iterable[tuple[int, bool]]) -> str:
    return ", ".join(f"{kind}[{number}]={'TRUE' if on else 'FALSE'}" for number, on in entries) or "none"
