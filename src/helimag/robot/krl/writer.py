"""KUKA Robot Language: a plan as a .src and a .dat file. Millimetres, degrees, m/s; nothing unchecked gets in."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.robot.arm.cell import Load
from helimag.robot.arm.frames import angles
from helimag.robot.arm.planning import ArmPlan
from helimag.robot.krl.instructions import Order, instructions
from helimag.robot.krl.sequence import (
    DECIMALS,
    AtStart,
    Awaited,
    Going,
    JointSpeed,
    Output,
    PathSpeed,
    Rest,
    Step,
    sequence,
)

Floats = NDArray[np.float64]

LONGEST_NAME = 24
LARGEST = 1e6  # no number of a sane programme is beyond it
SLOWEST = 1e-7  # m/s; ten decimals still hold it to 0.05 %
ABORT = 2  # the interrupt that switches the motor off, before that of IR_STOPM
LONGEST_BLOCK = 400  # motions of a spline block; a controller plans all of it before it moves
_ALONG = frozenset({Order.LINE, Order.ARC})
RESERVED = frozenset(
    [
        "AND",
        "ANIN",
        "ANOUT",
        "B_AND",
        "B_EXOR",
        "B_NOT",
        "B_OR",
        "BOOL",
        "BRAKE",
        "C_DIS",
        "C_ORI",
        "C_PTP",
        "C_SPL",
        "C_VEL",
        "CASE",
        "CHAR",
        "CIRC",
        "CIRC_REL",
        "CONST",
        "CONTINUE",
        "CONFIRM",
        "DECL",
        "DEF",
        "DEFAULT",
        "DEFDAT",
        "DEFFCT",
        "DELAY",
        "DO",
        "ELSE",
        "END",
        "ENDDAT",
        "ENDFCT",
        "ENDFOR",
        "ENDIF",
        "ENDLOOP",
        "ENDSPLINE",
        "ENDSWITCH",
        "ENDWHILE",
        "ENUM",
        "EXIT",
        "EXOR",
        "EXT",
        "EXTFCT",
        "FALSE",
        "FOR",
        "FRAME",
        "GLOBAL",
        "GOTO",
        "HALT",
        "IF",
        "IMPORT",
        "INT",
        "INTERRUPT",
        "LIN",
        "LIN_REL",
        "LOOP",
        "MAXIMUM",
        "MINIMUM",
        "NOT",
        "OFF",
        "ON",
        "OR",
        "POS",
        "E6POS",
        "E6AXIS",
        "AXIS",
        "PRIO",
        "PTP",
        "PTP_REL",
        "PUBLIC",
        "PULSE",
        "REAL",
        "REPEAT",
        "RESUME",
        "RETURN",
        "SCIRC",
        "SEC",
        "SIGNAL",
        "SLIN",
        "SPL",
        "SPLINE",
        "SPTP",
        "STRUC",
        "SWITCH",
        "THEN",
        "TO",
        "TRIGGER",
        "TRUE",
        "UNTIL",
        "WAIT",
        "WHEN",
        "WHILE",
        "WITH",
    ]
)
_NAME = re.compile(rf"[A-Za-z][A-Za-z0-9_]{{0,{LONGEST_NAME - 1}}}")


def checked_name(name: str) -> str:
    """The name, if it can name a KRL module.

    Returns
    -------
    str
        As given.

    Raises
    ------
    InputError
        Where it holds anything but letters, digits and underscores, is too long, or is a word of the language.
    """
    if not _NAME.fullmatch(name) or not name.isascii():
        raise InputError(
            f"a programme's name must be a letter and then letters, digits or underscores, "
            f"{LONGEST_NAME} at most; got {name!r}"
        )
    if name.upper() in RESERVED or name.upper().startswith("BAS"):
        raise InputError(f"a programme's name must not be a word of KRL; got {name!r}")
    return name


def name_for(title: str) -> str:
    """A KRL name made of a scenario's name: every other character becomes an underscore."""
    plain = re.sub(r"[^A-Za-z0-9]+", "_", title).strip("_")[: LONGEST_NAME - 2]
    if not plain or not plain[0].isalpha() or plain.upper() in RESERVED or plain.upper().startswith("BAS"):
        plain = f"P_{plain}"[:LONGEST_NAME]
    return checked_name(plain)


def comment(text: str) -> str:
    """A comment line that stays one: printable ASCII only, everything else escaped, and not too long."""
    escaped = text.encode("unicode_escape").decode("ascii")
    return "; " + "".join(c if " " <= c <= "~" else "?" for c in escaped)[:200]


def number(value: float, decimals: int) -> str:
    """A KRL real with fixed decimals, never with an exponent.

    Raises
    ------
    InputError
        Where the value is not finite or absurdly large.
    """
    if not math.isfinite(value) or abs(value) > LARGEST:
        raise InputError(f"a programme's numbers must be finite and below {LARGEST:g}; got {value}")
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def pose(values: Floats) -> str:
    """A pose (6,) in m and rad as the inside of a KRL aggregate."""
    shown = [*(number(1e3 * v, 6) for v in values[:3]), *(number(math.degrees(v), 8) for v in values[3:])]
    return ", ".join(f"{name} {value}" for name, value in zip("XYZABC", shown, strict=True))


def axes(joints: Floats) -> str:
    """Joint angles (6,) in rad as the inside of a KRL aggregate."""
    return ", ".join(f"A{i + 1} {number(math.degrees(joint), 8)}" for i, joint in enumerate(joints))


def frame_pose(matrix: Floats) -> Floats:
    """Position and angles (6,) of a frame (4, 4)."""
    return np.concatenate([matrix[:3, 3], angles(matrix[:3, :3])])


def write_krl(plan: ArmPlan, name: str, header: Sequence[str] = (), *, spline: bool = False) -> tuple[str, str]:
    """The texts of NAME.src and NAME.dat.

    Parameters
    ----------
    name
        Of the module.
    header
        Lines of text that open the .src file as comments.
    spline
        Write spline motions: blocks of SPL and SCIRC from stop to stop, which keep $VEL.CP at their points.

    Returns
    -------
    tuple of str
        Of .src and .dat.

    Raises
    ------
    InputError
        Where a name or a number does not fit into the language, or a motion is too slow to be written.
    """
    checked_name(name)
    steps = sequence(plan)
    src = "\n".join([*_opening(plan, name, header), *_body(steps, spline), "END", *_on_abort(plan, name), ""])
    dat = "\n".join([*_points(name, steps), "ENDDAT", ""])
    return src, dat


def _opening(plan: ArmPlan, name: str, header: Iterable[str]) -> Iterator[str]:
    cell = plan.cell
    yield from ("&ACCESS RVP", "&REL 1", f"DEF {name} ( )")
    yield from (comment(line) for line in header)
    yield from (
        ";FOLD INI",
        "  ;FOLD BASISTECH INI",
        "    GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )",
        "    INTERRUPT ON 3",
        "    BAS (#INITMOV,0 )",
        "  ;ENDFOLD (BASISTECH INI)",
        ";ENDFOLD (INI)",
    )
    if cell.motor is not None:
        yield f"INTERRUPT DECL {ABORT} WHEN $STOPMESS==TRUE DO {_abort_name(name)} ( )"
        yield f"INTERRUPT ON {ABORT}"
    yield from (
        f"$BASE={{{pose(frame_pose(cell.lab_in_base))}}}",
        f"$TOOL={{{pose(frame_pose(cell.tool_in_flange))}}}",
    )
    if cell.load is not None:
        yield f"$LOAD={_load(cell.load)}"
    yield from (f"{name}={value}" for name, value in standing(plan).items())


def _abort_name(name: str) -> str:
    return f"{name[: LONGEST_NAME - 4]}_OFF"


def _on_abort(plan: ArmPlan, name: str) -> Iterator[str]:
    """What runs when the arm is stopped: the motor off, and no way to go on, since the device has been released."""
    if plan.cell.motor is not None:
        yield f"DEF {_abort_name(name)} ( )"
        yield f"$OUT[{plan.cell.motor.run_output}]=FALSE"
        yield from ("LOOP", "HALT", "ENDLOOP", "END")


def _load(load: Load) -> str:
    """$LOAD: kilograms, millimetres and kg m^2, along the flange's axes."""
    center = ",".join(f"{name} {number(1e3 * value, 3)}" for name, value in zip("XYZ", load.center, strict=True))
    inertia = ",".join(f"{name} {number(value, 6)}" for name, value in zip("XYZ", load.inertia, strict=True))
    return f"{{M {number(load.mass, 4)},CM {{{center},A 0.0,B 0.0,C 0.0}},J {{{inertia}}}}}"


def load_settings(load: Load | None) -> dict[str, str]:
    """The parts of $LOAD by name, as they are written."""
    if load is None:
        return {}
    center, inertia = zip("XYZ", load.center, strict=True), zip("XYZ", load.inertia, strict=True)
    return {
        "$LOAD.M": number(load.mass, 4),
        **{f"$LOAD.CM.{name}": number(1e3 * value, 3) for name, value in center},
        **{f"$LOAD.CM.{name}": "0.0" for name in "ABC"},
        **{f"$LOAD.J.{name}": number(value, 6) for name, value in inertia},
    }


def standing(plan: ArmPlan) -> dict[str, str]:
    """The settings that stand from the first motion to the last, by name, as they are written."""
    turn_speeds = number(math.degrees(_turn_speed(plan)), 10)
    return {
        "$IPO_MODE": "#BASE",
        "$ORI_TYPE": "#VAR",
        "$CIRC_TYPE": "#PATH",
        "$ADVANCE": "3",
        "$ACC.CP": number(plan.cell.acceleration, 6),
        "$APO.CDIS": number(1e3 * plan.cell.approximation, 6),
        "$APO.CORI": "0.5",
        "$VEL.ORI1": turn_speeds,
        "$VEL.ORI2": turn_speeds,
    }


def _turn_speed(plan: ArmPlan) -> float:
    """Angular speed (rad/s) for $VEL.ORI: that of a turn on the spot, or one that is out of the way."""
    turning = any(order.order is Order.TURN for order in instructions(plan))
    return abs(plan.path.yaw_rate) if turning else plan.cell.speed_share * plan.cell.arm.joint_speed[5]


def _body(steps: Sequence[Step], spline: bool) -> Iterator[str]:
    at = 0
    while at < len(steps):
        block = _block(steps, at) if spline else []
        if len(block) > 1:
            yield from _spline(block)
            at += len(block)
        else:
            yield from _lines(steps[at], "S" if spline else "")
            at += 1


def _block(steps: Sequence[Step], at: int) -> list[Step]:
    """The steps from one on that are passed without a stop, up to the one that stops: motions and their speeds."""
    block: list[Step] = []
    for step in steps[at : at + LONGEST_BLOCK]:
        if not isinstance(step, PathSpeed | Going) or (isinstance(step, Going) and step.order not in _ALONG):
            break
        if isinstance(step, PathSpeed) and not block:  # the speed that a block begins with is set before it
            break
        block.append(step)
        if isinstance(step, Going) and not step.rounded:
            return block
    while block and isinstance(block[-1], PathSpeed):
        block.pop()
    return block


def _spline(block: Sequence[Step]) -> Iterator[str]:
    """A block of spline motions; a speed other than that before the block goes with each motion that it holds for."""
    speed = ""
    yield "SPLINE"
    for step in block:
        match step:
            case PathSpeed():
                speed = f" WITH $VEL.CP={_path_speed(step)}"
            case Going(order=Order.ARC):
                yield f"  SCIRC {step.via_name}, {step.name}{speed}"
            case Going():
                yield f"  SPL {step.name}{speed}"
    rounded = isinstance(block[-1], Going) and block[-1].rounded
    yield "ENDSPLINE" + (" C_SPL" if rounded else "")


def _lines(step: Step, prefix: str) -> Iterator[str]:
    match step:
        case PathSpeed():
            yield f"$VEL.CP={_path_speed(step)}"
        case JointSpeed():
            yield from (f"$VEL_AXIS[{i}]={step.percent}" for i in range(1, 7))
        case AtStart():
            # half an override halves the arm and not the magnet; whoever wants one on the way to the start may have it
            yield "$OV_PRO=100"
        case Output():
            yield f"$OUT[{step.number}]={'TRUE' if step.on else 'FALSE'}"
        case Awaited():
            yield f"WAIT FOR {'' if step.on else 'NOT '}$IN[{step.number}]"
        case Rest():
            yield f"WAIT SEC {number(step.seconds, 6)}"
        case Going():
            yield _motion(step, prefix)


def _path_speed(step: PathSpeed) -> str:
    if step.speed < SLOWEST:
        raise InputError(
            f"the arm must move at {1e3 * SLOWEST:g} mm/s or faster to be programmed; at {step.time:.2f} s the path "
            f"asks for {1e3 * step.speed:.3g} mm/s"
        )
    return number(step.speed, DECIMALS)


def _motion(step: Going, prefix: str) -> str:
    match step.order:
        case Order.JOINTS:
            return f"PTP {step.name}"
        case Order.ARC:
            return f"{prefix}CIRC {step.via_name}, {step.name}" + (" C_DIS" if step.rounded else "")
        case Order.TURN if step.rounded and not prefix:
            return f"LIN {step.name} C_ORI"
        case _:
            return f"{prefix}LIN {step.name}" + (" C_DIS" if step.rounded else "")


def _points(name: str, steps: Sequence[Step]) -> Iterator[str]:
    yield f"DEFDAT {name}"
    written = set()
    for step in steps:
        if isinstance(step, Going) and step.name not in written:
            written.add(step.name)
            if step.via is not None:
                yield f"DECL E6POS {step.via_name}={{{pose(step.via)}}}"
            kind, inside = ("E6AXIS", axes) if step.order is Order.JOINTS else ("E6POS", pose)
            yield f"DECL {kind} {step.name}={{{inside(step.target)}}}"
