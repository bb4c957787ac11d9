"""KUKA Robot Language: a plan as a .src and a .dat file. Millimetres, degrees, m/s; nothing unchecked gets in."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.robot.arm.frames import angles
from helimag.robot.arm.planning import ArmPlan
from helimag.robot.krl.instructions import Instruction, Order, instructions, tool_poses

Floats = NDArray[np.float64]

LONGEST_NAME = 24
LARGEST = 1e6  # no number of a sane programme is beyond it
SLOWEST = 1e-7  # m/s; ten decimals still hold it to 0.05 %
APPROACH_SPEED = 0.1  # m/s, where a turn sets the pace
APPROACH = 10  # % of the joint speeds, on the way to the first point
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
        Write SLIN and SCIRC instead of LIN and CIRC.

    Raises
    ------
    InputError
        Where a name or a number does not fit into the language, or a motion is too slow to be written.
    """
    checked_name(name)
    orders = instructions(plan)
    src = "\n".join([*_opening(plan, name, header, spline), *_body(plan, orders, spline), "END", ""])
    dat = "\n".join([*_points(plan, name, orders), "ENDDAT", ""])
    return src, dat


def _opening(plan: ArmPlan, name: str, header: Iterable[str], spline: bool) -> Iterator[str]:
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
        f"$BASE={{{pose(frame_pose(cell.lab_in_base))}}}",
        f"$TOOL={{{pose(frame_pose(cell.tool_in_flange))}}}",
        *(f"{name}={value}" for name, value in standing(plan).items()),
        f"$VEL.CP={number(APPROACH_SPEED, 10)}",
    )
    yield from _joint_speed(APPROACH)
    yield "PTP XSTART"
    # joint angles in single precision are off by some 50 nm; a pose in the lab frame is not
    yield f"{'S' if spline else ''}LIN XBEGIN"
    # half an override halves the arm and not the magnet; whoever wants one on the way to the start may have it
    yield "$OV_PRO=100"


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


def _joint_speed(percent: int) -> Iterator[str]:
    for i in range(1, 7):
        yield f"$VEL_AXIS[{i}]={percent}"


def _body(plan: ArmPlan, orders: Sequence[Instruction], spline: bool) -> Iterator[str]:
    output = plan.cell.start_output
    if output is not None:
        yield f"$OUT[{int(output)}]=TRUE"
    speed, joint_speed = None, APPROACH
    for i, order in enumerate(orders, start=1):
        if order.order in {Order.LINE, Order.ARC}:
            if order.speed < SLOWEST:
                raise InputError(
                    f"the arm must move at {1e3 * SLOWEST:g} mm/s or faster to be programmed; "
                    f"at {order.begin:.2f} s the path asks "
                    f"for {1e3 * order.speed:.3g} mm/s"
                )
            if number(order.speed, 10) != speed:
                speed = number(order.speed, 10)
                yield f"$VEL.CP={speed}"
        if order.order is Order.JOINTS and round(100.0 * order.speed) != joint_speed:
            joint_speed = round(100.0 * order.speed)
            yield from _joint_speed(joint_speed)
        yield _motion(order, i, "S" if spline else "")
        if order.order is Order.JOINTS:  # the pose that it has turned back to
            yield f"{'S' if spline else ''}LIN XP{i - 1}"
    if output is not None:
        yield f"$OUT[{int(output)}]=FALSE"


def _motion(order: Instruction, i: int, prefix: str) -> str:
    match order.order:
        case Order.JOINTS:
            return f"PTP XP{i}"
        case Order.LINE:
            return f"{prefix}LIN XP{i}" + (" C_DIS" if order.rounded else "")
        case Order.TURN:
            return f"{prefix}LIN XP{i}" + (
                " C_ORI" if order.rounded and not prefix else " C_DIS" if order.rounded else ""
            )
        case Order.ARC:
            return f"{prefix}CIRC XV{i}, XP{i}" + (" C_DIS" if order.rounded else "")
        case Order.WAIT:
            return f"WAIT SEC {number(order.end - order.begin, 6)}"


def _points(plan: ArmPlan, name: str, orders: Sequence[Instruction]) -> Iterator[str]:
    yield f"DEFDAT {name}"
    yield f"DECL E6AXIS XSTART={{{axes(plan.joints[0])}}}"
    yield f"DECL E6POS XBEGIN={{{pose(tool_poses(plan, plan.times[:1])[0])}}}"
    for i, order in enumerate(orders, start=1):
        if order.via is not None:
            yield f"DECL E6POS XV{i}={{{pose(order.via)}}}"
        if order.order is Order.JOINTS:
            yield f"DECL E6AXIS XP{i}={{{axes(order.target)}}}"
        elif order.order is not Order.WAIT:
            yield f"DECL E6POS XP{i}={{{pose(order.target)}}}"
