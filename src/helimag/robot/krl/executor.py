"""Carry out a programme statement by statement: declarations, assignments, branches, loops, sub-programmes."""

from collections.abc import Collection, Mapping, Sequence
from copy import deepcopy
from enum import Enum, auto
from typing import Any

from helimag.errors import InputError
from helimag.robot.krl.basics import bas
from helimag.robot.krl.interrupts import Interrupts
from helimag.robot.krl.machine import Machine
from helimag.robot.krl.routines import Block, Line, Module, Refused, Routine, Statement
from helimag.robot.krl.values import Reference, Value, Variables, evaluate, reference_of

MOST = 200_000  # statements that are carried out
DEEPEST = 20  # calls within calls
INNERMOST = 100  # blocks within blocks, through calls
_MAIN = 2  # scopes that are open in the main programme: its own, and what all share
# what every controller has declared
_GLOBAL = {
    "TOOL_DATA": "FRAME",
    "BASE_DATA": "FRAME",
    "LOAD_DATA": "LOAD",
    "FDAT_ACT": "FDAT",
    "LDAT_ACT": "LDAT",
    "PDAT_ACT": "PDAT",
}
_TABLES = ("TOOL_DATA", "BASE_DATA", "LOAD_DATA")  # of frames and loads by number; the newest controllers have 128


class _Flow(Enum):
    """What comes after a statement."""

    NEXT = auto()
    EXIT = auto()  # of the loop
    RETURN = auto()  # of the routine


class Executor:
    """Runs a module on a machine; every refusal names its line."""

    def __init__(
        self, module: Module, machine: Machine, inputs: Collection[int] = (), kept: Mapping[str, Value] | None = None
    ) -> None:
        self.module, self.machine, self.inputs = module, machine, frozenset(inputs)
        self.shared = Variables(types=dict(_GLOBAL), sizes=dict.fromkeys(_TABLES, 128))
        self.kept = dict(kept or {})
        self.scopes: list[Variables] = []
        self.done = self.depth = self.loops = 0
        self.interrupts = Interrupts(module.routines)

    def run(self) -> None:
        """Carry out the declarations and then the main programme.

        A data list keeps what a run leaves in it: ``kept`` are those values, with which the next run begins, and
        afterwards those that this one has changed.
        """
        self.scopes = [self.shared]
        for line in self.module.declarations:
            self._carried_out(line)
        self.shared.values |= self.kept
        before = deepcopy(self.shared.values)
        self._call(self.module.main)
        self.kept = {name: value for name, value in self.shared.values.items() if before.get(name) != value}
        self.machine.end()

    def _call(self, routine: Routine) -> None:
        if len(self.scopes) > DEEPEST:
            raise InputError(f"expected calls at most {DEEPEST} deep")
        self.scopes.append(Variables())
        loops, self.loops = self.loops, 0
        self._all(routine.body)
        self.loops = loops
        self.scopes.pop()

    def _all(self, statements: Sequence[Statement]) -> _Flow:
        for statement in statements:
            flow = self._block(statement) if isinstance(statement, Block) else self._carried_out(statement)
            if flow is not _Flow.NEXT:
                return flow
        return _Flow.NEXT

    def _carried_out(self, line: Line) -> _Flow:
        self._count(line)
        try:
            return self._line(line)
        except Refused:
            raise
        except InputError as error:
            raise line.refused(error) from None

    def _count(self, line: Line) -> None:
        self.done += 1
        if self.done > MOST:
            raise line.refused(f"the programme carries out more than {MOST} statements")

    def _line(self, line: Line) -> _Flow:
        parts = line.parts
        match line.kind:
            case "assign":
                self._write(reference_of(parts[0], self._read), self._value(parts[1]))
            case "declaration":
                self._declare(parts, opaque=line.file == ".dat")  # data lists hold much that nothing moves by
            case "ptp" | "lin" | "circ" | "spl" | "ptp_rel" | "lin_rel":
                self._move(line, line.kind, parts)
            case "wait":
                self.machine.wait(self._number(parts[0], "WAIT SEC"))
            case "wait_for":
                self._wait_for(parts[0])
            case "call":
                self._called(str(parts[0]), [argument.children[0] for argument in parts[1:]])
            case "interrupt_decl" | "interrupt_global" | "interrupt_on" | "interrupt_off":
                in_main = len(self.scopes) == _MAIN
                self.interrupts.carry_out(line, moving=bool(self.machine.legs), in_main=in_main)
            case "exit_":
                if not self.loops:
                    raise InputError("EXIT stands in no loop")
                return _Flow.EXIT
            case "return_":
                return _Flow.RETURN
            case "halt":
                raise InputError("HALT: the arm would stand until somebody starts it again, while the magnet spins on")
            case "unread":
                raise InputError(line.unread)
            case "continue_":
                raise InputError("CONTINUE lets what stands behind it happen while the arm is still on its way")
            case "nothing":
                pass
            case kind:
                raise InputError(f"expected a statement that belongs here; got {kind}")
        return _Flow.NEXT

    def _move(self, line: Line, order: str, parts: list[Any], *, inside: bool = False) -> None:
        points = [self._point(part.children[0]) for part in parts if _is(part, "point")]
        words = [str(part) for part in parts if isinstance(part, str)]
        roundings = [word for word in words if word[0] != "#"]
        if any(word not in {"#BASE", *roundings} for word in words):
            raise InputError("motion in the tool's frame is not followed")
        own = [setting for part in parts if _is(part, "with_") for setting in part.children]
        kept, assumed = dict(self.machine.settings.values), set(self.machine.settings.assumed)
        for setting in own:  # these hold for the one motion
            reference = reference_of(setting.children[0], self._read)
            if reference.name not in {"$VEL", "$ACC", "$ORI_TYPE", "$CIRC_TYPE", "$APO"}:
                raise InputError(f"{reference} after WITH is not followed")
            self.machine.settings.write(reference, self._value(setting.children[1]))
        self.machine.move(order, points, roundings, line.number, inside=inside)
        if own:
            self.machine.settings.values, self.machine.settings.assumed = kept, assumed

    def _point(self, tree: Any) -> dict[str, Any]:
        value = self._value(tree)
        if not isinstance(value, dict):
            raise InputError(f"expected a point; got {value!r}")
        return value

    def _called(self, name: str, arguments: list[Any]) -> None:
        routine = self.module.routines.get(name)
        if name == "BAS" and routine is None:
            bas([self._value(argument) for argument in arguments], self.machine.settings, self.shared)
            return
        if routine is None:
            raise InputError(f"{name} is not in this file, so what it does is not known")
        if arguments or routine.parameters or routine.function:
            raise InputError(f"{name} takes parameters or is a function, which is not followed")
        self._call(routine)

    def _wait_for(self, condition: Any) -> None:
        """A wait for an input that somebody answers on, or for what is true already."""
        inner, on = _wanted(condition)
        if inner.data == "reference":
            reference = reference_of(inner, self._read)
            if reference.name == "$IN" and reference.index in self.inputs and not reference.parts:
                self.machine.wait_for(reference.index, on=on)
                return
        if not self._truth(condition):
            raise InputError("the programme would wait here for ever")
        self.machine.stop()

    def _declare(self, parts: list[Any], *, opaque: bool) -> None:
        constant = str(parts[0]) == "CONST"
        kind, *names = parts[1:] if constant else parts
        for declared in names:
            reference = reference_of(declared.children[0], self._read)
            if reference.parts:
                raise InputError(f"expected a name to declare; got {reference}")
            self.scopes[-1].declare(str(kind), reference.name, size=reference.index, opaque=opaque)
            if self.scopes[-1] is not self.shared and reference.name in self.shared.types:
                raise InputError(f"'{reference.name}' is declared in the .dat file or by the controller already")
            if len(declared.children) > 1:
                self._write(Reference(reference.name), self._value(declared.children[1]))
            if constant:
                self.scopes[-1].constants.add(reference.name)

    def _block(self, block: Block) -> _Flow:
        head = block.head
        self._count(head)
        if self.depth >= INNERMOST:
            raise head.refused(f"expected blocks at most {INNERMOST} deep, those of calls included")
        self.depth += 1
        try:
            match head.kind:
                case "if_":
                    return self._if(block)
                case "switch":
                    return self._switch(block)
                case "for_":
                    return self._for(block)
                case "spline":
                    return self._spline(block)
                case _:
                    return self._loop(block)
        except Refused:
            raise
        except InputError as error:
            raise head.refused(error) from None
        finally:
            self.depth -= 1

    def _if(self, block: Block) -> _Flow:
        (_, then), *otherwise = block.arms
        if self._truth(block.head.parts[0]):
            return self._all(then)
        return self._all(otherwise[0][1]) if otherwise else _Flow.NEXT

    def _switch(self, block: Block) -> _Flow:
        wanted = self._value(block.head.parts[0])
        if isinstance(wanted, bool) or not isinstance(wanted, (int, str)):
            raise InputError(f"SWITCH takes a whole number, a character or a word; got {wanted!r}")
        for opening, body in block.arms[1:]:
            values = [self._value(part) for part in opening.parts]
            if any(type(value) is not type(wanted) for value in values):
                raise opening.refused(f"CASE must be of the kind of its SWITCH, {wanted!r}")
            if opening.kind == "default" or wanted in values:
                return self._all(body)
        return _Flow.NEXT

    def _for(self, block: Block) -> _Flow:
        name, *bounds = block.head.parts
        first, last, *rest = (self._number(bound, "FOR") for bound in bounds)
        step = rest[0] if rest else 1
        if not all(isinstance(value, int) for value in (first, last, step)) or step == 0:
            raise InputError("FOR must count in whole numbers, and not by zero")
        at = first
        while at <= last if step > 0 else at >= last:
            self._count(block.head)
            self._write(Reference(str(name)), at)
            flow = self._round(block)
            if flow is _Flow.RETURN:
                return flow
            if flow is _Flow.EXIT:
                return _Flow.NEXT
            at = self._number_of(Reference(str(name))) + step
        self._forget(str(name))  # controllers do not agree on what it is when the loop is over
        return _Flow.NEXT

    def _round(self, block: Block) -> _Flow:
        """What a loop holds, once."""
        self.loops += 1
        flow = self._all(block.arms[0][1])
        self.loops -= 1
        return flow

    def _loop(self, block: Block) -> _Flow:
        """LOOP, WHILE and REPEAT."""
        kind = block.head.kind
        while kind != "while_" or self._truth(block.head.parts[0]):
            self._count(block.head)
            flow = self._round(block)
            if flow is _Flow.RETURN:
                return flow
            if flow is _Flow.EXIT or (kind == "repeat" and self._truth(block.arms[1][0].parts[0])):
                break
        return _Flow.NEXT

    def _spline(self, block: Block) -> _Flow:
        """A spline block: its motions one after the other, passed without a stop, if that is how any controller goes.

        Between points the course is the controller's own; it is followed where it cannot leave the chords.
        """
        inner, end = block.arms[0][1], block.arms[1][0]
        motions = [line for line in inner if not isinstance(line, Block) and line.kind in {"spl", "lin", "circ"}]
        if not inner or len(motions) != len(inner):
            raise InputError("a spline block of anything but SPL, SLIN and SCIRC is not followed")
        first = len(self.machine.legs)
        for i, line in enumerate(motions):
            self._count(line)
            if any(isinstance(part, str) for part in line.parts):
                raise line.refused("a point inside a spline block is not rounded by itself")
            try:
                closing = end.parts if i == len(motions) - 1 else []
                self._move(line, line.kind, [*block.head.parts, *line.parts, *closing], inside=i < len(motions) - 1)
            except Refused:
                raise
            except InputError as error:
                raise line.refused(error) from None
        self.machine.check_course(self.machine.legs[first:])
        return _Flow.NEXT

    def _value(self, tree: Any) -> Value:
        return evaluate(tree, self._read)

    def _truth(self, tree: Any) -> bool:
        value = self._value(tree)
        if not isinstance(value, bool):
            raise InputError(f"expected TRUE or FALSE; got {value!r}")
        return value

    def _number(self, tree: Any, what: str) -> float:
        value = self._value(tree)
        if isinstance(value, (bool, str, dict)):
            raise InputError(f"expected {what} and a number; got {value!r}")
        return value

    def _number_of(self, reference: Reference) -> int:
        value = self._read(reference)
        if isinstance(value, bool) or not isinstance(value, int):
            raise InputError(f"{reference} must be a whole number; got {value!r}")
        return value

    def _read(self, reference: Reference) -> Value:
        if reference.name in {"$IN", "$ANIN", "$OUT"}:
            raise InputError(f"{reference} is an input or output, which is not known on paper")
        if reference.name[0] == "$":
            return self.machine.settings.read(reference)
        home = self._home(reference)
        if reference.name not in home.types and not self.module.declarations:
            raise InputError(f"'{reference.name}' is not declared; no .dat file was found that could declare it")
        return home.read(reference)

    def _write(self, reference: Reference, value: Value) -> None:
        if reference.name == "$OUT":
            self.machine.switch(reference, value)
        elif reference.name[0] == "$":
            self.machine.settings.write(reference, value)
        else:
            self._home(reference).write(reference, value)

    def _forget(self, name: str) -> None:
        """Take a variable its value; what has none cannot be read."""
        self._home(Reference(name)).values.pop(name, None)

    def _home(self, reference: Reference) -> Variables:
        """Where a variable is declared: in the routine, or for all of them."""
        own = self.scopes[-1]
        return own if reference.name in own.types else self.shared


def _wanted(condition: Any) -> tuple[Any, bool]:
    """What a condition is about, and which truth it asks for: ``$IN[1]``, ``NOT $IN[1]`` or ``$IN[1]==FALSE``."""
    if condition.data == "not_":
        return condition.children[0], False
    if condition.data == "both" and condition.children[1] in {"==", "<>"} and _is(condition.children[2], "truth"):
        inner, sign, truth = condition.children
        return inner, (truth.children[0] == "TRUE") is (sign == "==")
    return condition, True


def _is(part: Any, kind: str) -> bool:
    return not isinstance(part, str) and part.data == kind
