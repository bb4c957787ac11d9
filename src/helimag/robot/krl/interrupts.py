"""Interrupts on stop messages, which come after all that is followed; others are refused."""

from collections.abc import Mapping
from typing import Any

from helimag.errors import InputError
from helimag.robot.krl.grammar import tree_of
from helimag.robot.krl.routines import Block, Line, Routine, Statement
from helimag.robot.krl.values import Reference, Value, evaluate, reference_of

Switched = tuple[tuple[int, bool], ...]  # outputs by number, and to what they are set

_STOPPED = "$STOPMESS==TRUE"
_USUAL = ("3", "IR_STOPM")  # the one interrupt of every programme: it reports stops
_NUMBERS = frozenset(map(str, (*range(1, 40), *range(81, 129))))  # others are the controller's
_ONLY = "an interrupt's routine may set outputs and halt; more is not followed"


class Interrupts:
    """What a programme has declared to happen when the arm is stopped."""

    def __init__(self, routines: Mapping[str, Routine]) -> None:
        self._routines = routines
        self._declared: dict[str, Switched] = {}
        self._active: set[str] = set()

    @property
    def on_stop(self) -> Switched:
        """The outputs that are set when the arm is stopped."""
        return tuple(entry for number in sorted(self._active) for entry in self._declared[number])

    def carry_out(self, line: Line, *, moving: bool, in_main: bool = True) -> None:
        """INTERRUPT DECL, ON or OFF; ``moving`` says that the arm has moved already, ``in_main`` where the line stands.

        Raises
        ------
        InputError
            Where it is on anything but stops, is not declared, does more than set outputs and halt, or ends with the
            sub-programme that declares it.
        """
        parts: list[Any] = [str(part) if isinstance(part, str) else part for part in line.parts]
        if line.kind in {"interrupt_decl", "interrupt_global"}:
            number, condition, name = parts
            if not in_main and line.kind == "interrupt_decl":
                raise InputError("an interrupt that a sub-programme declares ends with it; write GLOBAL INTERRUPT DECL")
            if number not in _NUMBERS:
                raise InputError(f"an interrupt's number must be 1 to 39 or 81 to 128; got {number}")
            if condition != tree_of(f"WAIT FOR {_STOPPED}").children[0]:
                raise InputError("what an interrupt does while the arm moves is not followed; only those on stops are")
            self._declared[number] = (
                () if (number, name) == _USUAL and name not in self._routines else self._switched(name)
            )
            return
        named = set(parts) or set(self._declared)
        if not self._declared or not named <= set(self._declared):
            raise InputError("the interrupt is not declared")
        if moving and any(self._declared[number] for number in named):
            raise InputError("what is done on a stop must not change once the arm has moved")
        self._active = self._active - named if line.kind == "interrupt_off" else self._active | named

    def _switched(self, name: str) -> Switched:
        routine = self._routines.get(name)
        if routine is None or routine.parameters or routine.function:
            raise InputError(f"{name} is not a routine in this file, so what it does on a stop is not known")
        switched = [_switching(statement) for statement in routine.body]
        halts = switched.index(None) if None in switched else len(switched)  # what stands behind a halt comes too late
        return tuple(found for found in switched[:halts] if found is not None)


def _switching(statement: Statement) -> tuple[int, bool] | None:
    """The output that a statement sets; None where it halts."""
    if isinstance(statement, Block):
        inner = [each for _, arm in statement.arms for each in arm]
        if statement.head.kind != "loop" or any(isinstance(each, Block) or each.kind != "halt" for each in inner):
            raise statement.head.refused(_ONLY)
        return None
    if statement.kind == "halt":
        return None
    if statement.kind != "assign":
        raise statement.refused(_ONLY)
    reference = reference_of(statement.parts[0], _unknown)
    value = evaluate(statement.parts[1], _unknown)
    if reference.name != "$OUT" or reference.index is None or reference.parts or not isinstance(value, bool):
        raise statement.refused(_ONLY)
    return reference.index, value


def _unknown(reference: Reference) -> Value:
    raise InputError(f"{reference} is not known when the arm is stopped")
