"""Values of KRL: whole numbers, reals in single precision, truths, words, aggregates; variables and expressions."""

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from helimag.errors import InputError

if TYPE_CHECKING:
    import lark

LARGEST = 1e9  # no number of a sane programme is beyond it


class Word(str):
    """A word of an enumeration, such as ``#BASE``."""


class Text(str):
    """A string; nothing that moves depends on one."""


Aggregate = dict[str, Any]
Value = bool | int | float | Word | Text | Aggregate

_POINT = ("X", "Y", "Z", "A", "B", "C")
_JOINTS = ("A1", "A2", "A3", "A4", "A5", "A6")
_MORE_AXES = ("E1", "E2", "E3", "E4", "E5", "E6")
_WAY = ("S", "T")
# structures: which components a variable of the type may have; None where nothing that moves depends on them
STRUCTURES: Mapping[str, frozenset[str] | None] = {
    "FRAME": frozenset(_POINT),
    "POS": frozenset((*_POINT, *_WAY)),
    "E6POS": frozenset((*_POINT, *_WAY, *_MORE_AXES)),
    "AXIS": frozenset(_JOINTS),
    "E6AXIS": frozenset((*_JOINTS, *_MORE_AXES)),
    "FDAT": None,
    "LDAT": None,
    "PDAT": None,
    "LOAD": None,
}
PLAIN = frozenset({"INT", "REAL", "BOOL", "CHAR"})


def single(value: float) -> float:
    """A real as the controller holds it."""
    return float(np.float32(value))


@dataclass(frozen=True)
class Reference:
    """A variable as it is written: name, index, components."""

    name: str
    index: int | None = None
    parts: tuple[str, ...] = ()

    @property
    def variable(self) -> str:
        """Name with its index, such as ``$VEL_AXIS[1]``."""
        return self.name if self.index is None else f"{self.name}[{self.index}]"

    def __str__(self) -> str:
        return ".".join((self.variable, *self.parts))


@dataclass
class Variables:
    """Variables that a programme declares, with their types; an array's elements are variables of their own."""

    types: dict[str, str] = field(default_factory=dict)
    values: dict[str, Value] = field(default_factory=dict)
    sizes: dict[str, int] = field(default_factory=dict)
    constants: set[str] = field(default_factory=set)

    def declare(self, kind: str, name: str, *, size: int | None = None, opaque: bool = False) -> None:
        """Make a variable known; an ``opaque`` one may be of any type, as long as nobody asks for its value.

        Raises
        ------
        InputError
            Where the type is not known, or the variable is declared already.
        """
        if not opaque and kind not in STRUCTURES and kind not in PLAIN:
            raise InputError(f"expected a type that helimag reads; got {kind}")
        if name in self.types:
            raise InputError(f"'{name}' is declared twice")
        self.types[name] = kind
        if size is not None:
            self.sizes[name] = size

    def _checked(self, reference: Reference) -> str:
        """The type of a variable that is declared as it is written: an array with an index in it, another without.

        A string is an array of characters that is written and read without an index.
        """
        if reference.name not in self.types:
            raise InputError(f"'{reference.name}' is not declared")
        kind, size = self.types[reference.name], self.sizes.get(reference.name)
        if size is None and reference.index is not None:
            raise InputError(f"'{reference.name}' is declared without a size, so {reference.variable} is none of it")
        if size is not None and reference.index is None and kind != "CHAR":
            raise InputError(f"'{reference.name}' is declared as {reference.name}[{size}]: which of them is meant?")
        if size is not None and reference.index is not None and reference.index > size:
            raise InputError(f"the index of {reference.name} must be from 1 to {size}; got {reference.index}")
        return kind

    def read(self, reference: Reference) -> Value:
        """The value of a variable or of a component of it.

        Raises
        ------
        InputError
            Where it is not declared or has no value.
        """
        kind = self._checked(reference)
        if kind not in STRUCTURES and kind not in PLAIN:
            raise InputError(f"'{reference.name}' is of type {kind}, which helimag does not read")
        value: Any = self.values.get(reference.variable)
        for part in reference.parts:
            value = value.get(part) if isinstance(value, dict) else None
        if value is None:
            raise InputError(f"'{reference}' has no value here")
        return value  # type: ignore[no-any-return]

    def write(self, reference: Reference, value: Value) -> None:
        """Give a variable, or one component of it, a value.

        Raises
        ------
        InputError
            Where it is not declared, or the value is not of its type.
        """
        kind = self._checked(reference)
        if reference.name in self.constants:
            raise InputError(f"'{reference.name}' is declared CONST and cannot be given another value")
        if kind not in STRUCTURES and kind not in PLAIN:
            return
        if not reference.parts:
            self.values[reference.variable] = typed(value, kind, str(reference))
            return
        if kind not in STRUCTURES or len(reference.parts) > 1:
            raise InputError(f"'{reference}' is no component of a {kind}")
        part = reference.parts[0]
        new = typed({part: value}, kind, str(reference))
        old = self.values.get(reference.variable)
        self.values[reference.variable] = {**(old if isinstance(old, dict) else {}), **new}  # type: ignore[dict-item]


def typed(value: Value, kind: str, name: str) -> Value:
    """A value as a variable of a type holds it.

    Raises
    ------
    InputError
        Where it does not fit.
    """
    if kind in STRUCTURES:
        if not isinstance(value, dict):
            raise InputError(f"{name} must be a {kind}; got {value!r}")
        known = STRUCTURES[kind]
        if known is None:
            return dict(value)
        for part, number in value.items():
            if part not in known:
                raise InputError(f"{name} is a {kind}, which has no component {part}")
            if isinstance(number, (bool, str, dict)):
                raise InputError(f"{name}: {part} must be a number; got {number!r}")
        return {part: single(number) for part, number in value.items()}
    fits = {"REAL": (int, float), "INT": (int,), "BOOL": (bool,), "CHAR": (Text,)}[kind]
    if not isinstance(value, fits) or (isinstance(value, bool) and kind != "BOOL"):
        raise InputError(f"{name} must be a value of type {kind}; got {value!r}")
    return single(value) if kind == "REAL" else value  # type: ignore[arg-type]


def reference_of(tree: "lark.Tree", read: Callable[[Reference], Value]) -> Reference:
    """A reference with its index worked out."""
    first, *rest = tree.children
    index, parts = None, []
    for child in rest:
        if isinstance(child, str):
            parts.append(str(child))
        else:
            found = evaluate(child, read)
            if isinstance(found, bool) or not isinstance(found, int) or not 0 < found < 10_000:
                raise InputError(f"the index of {first} must be a whole number from 1 on; got {found!r}")
            index = found
    return Reference(str(first), index, tuple(parts))


def evaluate(tree: Any, read: Callable[[Reference], Value]) -> Value:
    """The value of an expression, its variables read by ``read``.

    Raises
    ------
    InputError
        Where a variable is not known, types do not fit, or a number is beyond all sense.
    """
    match tree.data:
        case "number":
            return _number(str(tree.children[0]))
        case "truth":
            return str(tree.children[0]) == "TRUE"
        case "word":
            return Word(tree.children[0])
        case "string":
            return Text(tree.children[0][1:-1])
        case "reference":
            return read(reference_of(tree, read))
        case "aggregate":
            return _aggregate(tree, read)
        case "function_of":
            return _function(str(tree.children[0]), [_numeric(evaluate(child, read)) for child in tree.children[1:]])
        case "sign":
            value: int | float = _numeric(evaluate(tree.children[1], read))
            return -value if tree.children[0] == "-" else value
        case "not_":
            return not _truth(evaluate(tree.children[0], read))
        case "both":
            left, sign, right = tree.children
            return _both(evaluate(left, read), str(sign), evaluate(right, read))
        case "compound":
            return compound(*(evaluate(child, read) for child in tree.children))
    raise InputError(f"expected an expression; got {tree.data}")


def _number(text: str) -> int | float:
    if text.isdigit():
        return int(_sane(int(text[:30])))
    return float(_sane(float(text)))


def _sane(value: float) -> Any:
    if not math.isfinite(value) or abs(value) > LARGEST:
        raise InputError(f"expected numbers of at most {LARGEST:g}; got {value:g}")
    return value if isinstance(value, int) else single(value)


def _aggregate(tree: "lark.Tree", read: Callable[[Reference], Value]) -> Aggregate:
    result: Aggregate = {}
    known: frozenset[str] | None = None
    for component in tree.children:
        if isinstance(component, str):  # the name of the type
            known = STRUCTURES.get(str(component))
            continue
        name = str(component.children[0])
        if known is not None and name not in known:
            raise InputError(f"{tree.children[0]} has no component {name}")
        if name in result:
            raise InputError(f"component {name} is given twice")
        result[name] = evaluate(component.children[1], read)
    return result


# the language's own functions; angles in degrees
_FUNCTIONS: dict[str, tuple[int, Callable[..., Any]]] = {
    "ABS": (1, abs),
    "SQRT": (1, math.sqrt),
    "SIN": (1, lambda angle: math.sin(math.radians(angle))),
    "COS": (1, lambda angle: math.cos(math.radians(angle))),
    "TAN": (1, lambda angle: math.tan(math.radians(angle))),
    "ACOS": (1, lambda cosine: math.degrees(math.acos(cosine))),
    "ATAN2": (2, lambda y, x: math.degrees(math.atan2(y, x))),
}


def _function(name: str, arguments: list[Any]) -> Value:
    count, function = _FUNCTIONS.get(name, (-1, abs))
    if count != len(arguments):
        raise InputError(f"{name} with {len(arguments)} values is not a function that helimag follows")
    try:
        return _sane(function(*arguments))  # type: ignore[no-any-return]
    except ValueError:
        raise InputError(f"{name} is not defined at {', '.join(f'{value:g}' for value in arguments)}") from None


def _numeric(value: Value) -> Any:
    if isinstance(value, (bool, str, dict)):
        raise InputError(f"expected a number; got {value!r}")
    return value


def _truth(value: Value) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"expected TRUE or FALSE; got {value!r}")
    return value


_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}
_LOGIC: dict[str, Callable[[bool, bool], bool]] = {"AND": operator.and_, "OR": operator.or_, "EXOR": operator.xor}
_ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {"+": operator.add, "-": operator.sub, "*": operator.mul}


def _both(left: Value, sign: str, right: Value) -> Value:
    if sign in _LOGIC:
        return _LOGIC[sign](_truth(left), _truth(right))
    if sign in {"==", "<>"} and type(left) is type(right) and isinstance(left, (bool, str)):
        return bool(_COMPARE[sign](left, right))
    a, b = _numeric(left), _numeric(right)
    if sign in _COMPARE:
        return bool(_COMPARE[sign](a, b))
    if sign != "/":
        return _sane(_ARITHMETIC[sign](a, b))  # type: ignore[no-any-return]
    if b == 0:
        raise InputError("expected no division by zero")
    whole = isinstance(a, int) and isinstance(b, int)
    return _sane(math.trunc(a / b) if whole else a / b)  # type: ignore[no-any-return]


def compound(left: Value, right: Value) -> Value:
    """The geometric operator: the frame ``right``, seen in ``left``, as ``left``'s own frame sees it."""
    from helimag.robot.arm.frames import angles, frame

    if not isinstance(left, dict) or not isinstance(right, dict):
        raise InputError("expected frames on both sides of ':'")
    pose = frame(*split(left)) @ frame(*split(right))
    values = (*(1e3 * pose[:3, 3]), *np.degrees(angles(pose[:3, :3])))
    return {name: single(value) for name, value in zip(_POINT, values, strict=True)}


def split(point: Mapping[str, Any]) -> tuple[Any, Any]:
    """Position (3,) in m and angles A, B, C (3,) in rad of a whole frame in mm and degrees.

    Raises
    ------
    InputError
        Where a component is missing.
    """
    missing = [name for name in _POINT if name not in point]
    if missing:
        raise InputError(f"a pose needs X, Y, Z, A, B and C; it lacks {', '.join(missing)}")
    values = np.array([single(_numeric(point[name])) for name in _POINT])
    return values[:3] / 1e3, np.radians(values[3:])
