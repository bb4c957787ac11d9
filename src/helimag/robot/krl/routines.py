"""The lines of a programme sorted into routines and blocks: what stands inside what."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from helimag.errors import InputError
from helimag.robot.krl.grammar import code_of, tree_of

if TYPE_CHECKING:
    import lark

DEEPEST = 50  # blocks in blocks


class Refused(InputError):
    """A line that is not followed; the message names it."""


@dataclass(frozen=True)
class Line:
    """One line of code: which of the two files it stands in, where, and its tree."""

    file: str
    number: int
    tree: "lark.Tree | None"
    unread: str = ""  # why the line was not understood; that matters where it would be carried out
    opens: bool = False  # a line that was not understood, and begins a block

    @property
    def kind(self) -> str:
        """What the statement is, as the grammar names it; ``unread`` where it is none."""
        return "unread" if self.tree is None else str(self.tree.data)

    @property
    def parts(self) -> "list[Any]":
        """What the statement consists of."""
        return [] if self.tree is None else list(self.tree.children)

    def refused(self, why: object) -> "Refused":
        """An error that names the line."""
        return Refused(f"{self.file} file, line {self.number}: {why}")


@dataclass(frozen=True)
class Block:
    """A statement that holds others: its arms are (the line that opens the arm, the statements in it)."""

    head: Line
    arms: "tuple[tuple[Line, tuple[Line | Block, ...]], ...]"


Statement = Line | Block


@dataclass
class Routine:
    """A programme or sub-programme."""

    name: str
    parameters: bool
    function: bool
    body: list[Statement] = field(default_factory=list)


@dataclass(frozen=True)
class Module:
    """A programme: the declarations of its .dat file, and its routines, the one that runs first."""

    declarations: tuple[Line, ...]
    main: Routine
    routines: dict[str, Routine]
    faults: tuple[str, ...] = ()  # what is understood, and no controller takes


_ARMS: dict[str, tuple[str, ...]] = {
    "if_": ("else_",),
    "switch": ("case", "default"),
    "for_": (),
    "while_": (),
    "repeat": (),
    "loop": (),
    "spline": (),
}
_ENDS = {
    "if_": "endif",
    "switch": "endswitch",
    "for_": "endfor",
    "while_": "endwhile",
    "repeat": "until",
    "loop": "endloop",
    "spline": "endspline",
}
_OPENS = re.compile(r"(IF|SWITCH|FOR|WHILE|REPEAT|LOOP|SPLINE)\b")
_OUTER = {"def_", "function", "end", "defdat", "enddat"}
_INNER = {*_ENDS.values(), *(arm for arms in _ARMS.values() for arm in arms)}


def module_of(src: str, dat: str) -> Module:
    """Sort the two files of a programme; statements without a DEF around them are a programme of their own.

    Raises
    ------
    InputError
        Where a line is outside the subset, a block does not close, or the files are not of one programme.
    """
    declarations, dat_head = _declarations(list(_lines(dat, ".dat")))
    routines: dict[str, Routine] = {}
    rest = iter(list(_lines(src, ".src")))
    bare = Routine("", False, False)
    for line in rest:
        if line.kind not in {"def_", "function"}:
            if routines:
                raise line.refused("expected DEF: the line stands behind the END of a programme")
            bare.body.append(_statement(line, rest, 0))
            continue
        if bare.body:
            raise line.refused("expected no statements before the first DEF")
        routine = _routine(line, rest)
        if routine.name in routines:
            raise line.refused(f"{routine.name} is defined twice")
        routines[routine.name] = routine
    main = next(iter(routines.values()), bare)
    if dat_head is not None and main.name and dat_head.parts[0] != main.name:
        raise dat_head.refused(f"DEFDAT {dat_head.parts[0]} does not belong to DEF {main.name} of the .src file")
    if main.parameters or main.function:
        raise InputError(f".src file: {main.name} takes parameters or is a function; it is no programme by itself")
    faults = [fault for each in (bare, *routines.values()) for fault in _misdeclared(each.body)]
    return Module(declarations, main, routines, tuple(faults))


def _lines(text: str, file: str) -> Iterator[Line]:
    begun = False
    for number, written in enumerate(_split(text, file), start=1):
        code = code_of(written)
        if not begun and code.startswith("&"):  # what editors note above a programme
            continue
        if code:
            begun = True
            try:
                yield Line(file, number, tree_of(code))
            except InputError as error:
                yield Line(file, number, None, str(error), _OPENS.match(code) is not None)


def _split(text: str, file: str) -> list[str]:
    """Lines as a controller breaks them: a comment may hold other breaks, and no line a carriage return in it."""
    lines = text.replace("\r\n", "\n").split("\n")
    broken = next((number for number, line in enumerate(lines, start=1) if "\r" in line), 0)
    if broken:
        raise Refused(
            f"{file} file, line {broken}: a carriage return without a line feed; some editors break the line there, "
            "controllers do not"
        )
    return lines


def _misdeclared(body: Sequence[Statement], begun: bool = False) -> Iterator[str]:
    """Declarations that no controller takes: behind a statement, or with values, which only data lists give."""
    for statement in body:
        if isinstance(statement, Block):
            begun = True
            for _, inner in statement.arms:
                yield from _misdeclared(inner, begun=True)
        elif statement.kind in {"declaration", "nothing"}:
            if begun:
                yield f"line {statement.number}: a declaration behind a statement, which no controller takes"
            if any(_gives(part) for part in statement.parts):
                yield f"line {statement.number}: a value in a declaration, which controllers take in the .dat file only"
        elif statement.kind != "unread":
            begun = True


def _gives(part: Any) -> bool:
    """Whether a part of a declaration gives a value, or says that it is for good."""
    return str(part) == "CONST" if isinstance(part, str) else part.data == "declared" and len(part.children) > 1


def _declarations(lines: Sequence[Line]) -> tuple[tuple[Line, ...], Line | None]:
    """The declarations between DEFDAT and ENDDAT, and the line that names the module."""
    if not lines:
        return (), None
    head, end = lines[0], lines[-1]
    if head.kind != "defdat":
        raise head.refused(head.unread or "expected DEFDAT")
    if end.kind != "enddat":
        raise end.refused(end.unread or "expected ENDDAT as the last line")
    found = [line for line in lines[1:-1] if line.kind != "nothing"]
    for line in found:
        if line.kind not in {"declaration", "assign"}:
            raise line.refused(line.unread or "expected a declaration")
        if line.kind == "assign" and str(line.parts[0].children[0])[0] == "$":
            raise line.refused("a data list sets no settings of the controller; set it in the .src file")
    return tuple(found), head


def _routine(head: Line, rest: Iterator[Line]) -> Routine:
    names = [str(child) for child in head.parts if isinstance(child, str)]
    has_parameters = any(not isinstance(child, str) for child in head.parts)
    routine = Routine(names[-1], has_parameters, head.kind == "function")
    for line in rest:
        if line.kind == "end":
            return routine
        routine.body.append(_statement(line, rest, 0))
    raise head.refused(f"{routine.name} has no END")


def _statement(line: Line, rest: Iterator[Line], depth: int) -> Statement:
    if line.kind in _INNER or line.kind in _OUTER:
        raise line.refused("expected a statement; the block that this line belongs to is not open")
    if line.kind not in _ENDS:
        if line.opens:  # what follows could stand in it or not
            raise line.refused(line.unread)
        return line
    if depth >= DEEPEST:
        raise line.refused(f"expected blocks at most {DEEPEST} deep")
    arms: list[tuple[Line, list[Statement]]] = [(line, [])]
    for inner in rest:
        if inner.kind == _ENDS[line.kind]:
            if line.kind in {"repeat", "spline"}:  # the closing line says something too
                arms.append((inner, []))
            return Block(line, tuple((opening, tuple(body)) for opening, body in arms))
        if inner.kind in _OUTER:
            break
        if inner.kind in _ARMS[line.kind]:
            if arms[-1][0].kind in {"else_", "default"}:
                raise inner.refused("expected the end of the block after its last branch")
            arms.append((inner, []))
        elif arms[-1][0].kind == "switch":
            raise inner.refused("expected CASE: no statement may stand between SWITCH and its first branch")
        else:
            arms[-1][1].append(_statement(inner, rest, depth + 1))
    raise line.refused("the block that begins here has no end")
