"""KUKA Robot Language read back: a grammar of the subset that arm programmes use, and the statements found."""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from helimag.errors import InputError, MissingExtra

if TYPE_CHECKING:
    import lark

# one statement: the language has one a line, and so messages can name it
_GRAMMAR = r"""
?start: "DEF" NAME "(" ")"                       -> nothing
    | "DEFDAT" NAME "PUBLIC"?                    -> nothing
    | ("END" | "ENDDAT")                         -> nothing
    | "GLOBAL"? "INTERRUPT" "DECL" NUMBER "WHEN" variable "==" value "DO" NAME "(" ")" -> nothing
    | "INTERRUPT" "ON" NUMBER                    -> nothing
    | "BAS" "(" value ("," value)? ")"           -> bas
    | "DECL" "GLOBAL"? NAME variable "=" value   -> declare
    | variable "=" value                         -> assign
    | "WAIT" "SEC" value                         -> wait
    | "PTP" point ROUNDING*                      -> ptp
    | ("LIN" | "SLIN") point ROUNDING*           -> lin
    | ("CIRC" | "SCIRC") point "," point ROUNDING* -> circ
?point: aggregate | variable
?value: NUMBER -> number
    | WORD -> word
    | aggregate
    | variable
aggregate: "{" (NAME ":")? component ("," component)* "}"
component: NAME value
variable: (NAME | SYSTEM) ("[" NUMBER "]")? ("." NAME)*
ROUNDING.2: /C_(DIS|VEL|ORI|PTP|SPL)\b/
WORD: /#[A-Z_][A-Z0-9_]*|TRUE\b|FALSE\b/
SYSTEM: /\$[A-Z_][A-Z0-9_]*/
NAME: /[A-Z_][A-Z0-9_]*/
NUMBER: /[-+]?(\d+\.?\d*|\.\d+)(E[-+]?\d+)?/
%ignore /[ \t]+/
"""


@dataclass(frozen=True)
class Move:
    """A motion statement: ``order`` is ptp, lin or circ; points are named numbers as written (mm, degrees)."""

    order: str
    points: tuple[dict[str, float], ...]
    rounded: bool
    line: int


@dataclass(frozen=True)
class Assign:
    """``variable = value``, the value a number, a word, or an aggregate."""

    variable: str
    value: float | str | dict[str, float]
    line: int


@dataclass(frozen=True)
class Wait:
    """A pause (s)."""

    seconds: float
    line: int


Statement = Move | Assign | Wait
_Value = float | str | dict[str, float]


@cache
def _parser() -> "lark.Lark":
    try:
        import lark
    except ImportError:
        raise MissingExtra("reading KRL needs lark: pip install 'helimag[robot]'") from None
    return lark.Lark(_GRAMMAR, parser="lalr")


def read_krl(src: str, dat: str = "") -> list[Statement]:
    """The statements of a programme in order, its points looked up in its declarations. Case does not matter.

    Raises
    ------
    InputError
        Where a line is outside the subset, or a point is not declared; names the file and the line.
    MissingExtra
        Where lark is not installed.
    """
    declared: dict[str, _Value] = {}
    statements: list[Statement] = []
    for text, source in ((dat, ".dat"), (src, ".src")):
        for line, written in enumerate(text.splitlines(), start=1):
            code = written.partition(";")[0].strip().upper()
            if code and not code.startswith("&"):
                try:
                    statement = _statement(code, line, declared)
                except InputError as error:
                    raise InputError(f"{source} file, line {line}: {error}") from None
                if statement is not None:
                    statements.append(statement)
    return statements


def _statement(code: str, line: int, declared: dict[str, _Value]) -> Statement | None:
    """Read one line; a declaration goes into ``declared``, anything without effect gives None."""
    import lark

    try:
        tree = _parser().parse(code)
    except lark.exceptions.UnexpectedInput:
        raise InputError(f"expected a statement of the subset that helimag reads; got {code[:80]!r}") from None
    parts = [part for part in tree.children if not (isinstance(part, lark.Token) and part.type == "ROUNDING")]
    match tree.data:
        case "declare":
            declared[_name(parts[1])] = _value(parts[2], declared)
            return None
        case "assign":
            return Assign(_name(parts[0]), _value(parts[1], declared), line)
        case "wait":
            seconds = _value(parts[0], declared)
            if not isinstance(seconds, float):
                raise InputError(f"expected WAIT SEC and a number; got {code!r}")
            return Wait(seconds, line)
        case "ptp" | "lin" | "circ" as order:
            points = tuple(_point(part, declared) for part in parts)
            return Move(order, points, len(parts) < len(tree.children), line)
        case "bas":
            command = _value(parts[0], declared)
            if command != "#INITMOV":
                raise InputError(f"BAS ({command}) is not in the subset that helimag reads; only BAS (#INITMOV,0) is")
    return None


def _name(tree: Any) -> str:
    """A variable's name as written, such as $VEL_AXIS[1] or $VEL.CP."""
    first, *rest = (str(token) for token in tree.children)
    return first + "".join(f"[{part}]" if part.isdigit() else f".{part}" for part in rest)


def _value(tree: Any, declared: dict[str, _Value]) -> _Value:
    match tree.data:
        case "number":
            return float(tree.children[0])
        case "word":
            return str(tree.children[0])
        case "aggregate":
            parts = [part for part in tree.children if not isinstance(part, str)]
            values = {str(part.children[0]): _value(part.children[1], declared) for part in parts}
            return {key: value for key, value in values.items() if isinstance(value, float)}
    name = _name(tree)
    if name not in declared:
        raise InputError(f"'{name}' is not declared")
    return declared[name]


def _point(tree: Any, declared: dict[str, _Value]) -> dict[str, float]:
    value = _value(tree, declared)
    if not isinstance(value, dict):
        raise InputError(f"expected a point; got {value!r}")
    return value
