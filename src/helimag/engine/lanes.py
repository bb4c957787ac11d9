"""Several runs in one vector register: Warp functions said again in C++, with a register of lanes for every number.

Warp compiles a function for one run at a time. What is translated here is the source of the same functions, statement
for statement, so that there is one definition of each formula, and a lane has the bits that its run by itself would
have (``tests/test_lanes.py``). Loops and branches must be the same for all lanes: they may ask whole numbers only.
"""

import ast
import inspect
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

import warp as wp

from helimag.physics.balance import SHEETS

MOST_MAGNETS_IN_LANES = 4  # of a run
MOST_ROWS = int(SHEETS)  # of an array in a structure
LANES = 8  # doubles in a register of 512 bits; for a processor with narrower ones the compiler takes several

HEAD = f"""
typedef double Lanes __attribute__((ext_vector_type({LANES})));
auto each_sqrt = [](Lanes x) {{ return __builtin_elementwise_sqrt(x); }};
auto each_abs = [](Lanes x) {{ return __builtin_elementwise_abs(x); }};
auto each_min = [](Lanes a, Lanes b) {{ return __builtin_elementwise_min(a, b); }};
auto each_max = [](Lanes a, Lanes b) {{ return __builtin_elementwise_max(a, b); }};
auto each_sign = [](Lanes x) {{ return x < Lanes(0.0) ? Lanes(-1.0) : Lanes(1.0); }};
auto each_where = [](auto asked, Lanes a, Lanes b) {{ return asked ? a : b; }};
auto each_length = [](const auto& a) {{ return __builtin_elementwise_sqrt(wp::dot(a, a)); }};
auto each_dot = [](const auto& a, const auto& b) {{ return wp::dot(a, b); }};
auto each_cw_mul = [](const auto& a, const auto& b) {{ return wp::cw_mul(a, b); }};
auto each_transpose = [](const auto& a) {{ return wp::transpose(a); }};
auto each_zeros = [] {{ return 0; }};
auto in_lanes = [](auto of) {{ return Lanes{{{", ".join(f"of({lane})" for lane in range(LANES))}}}; }};
auto number = [](auto x) {{ if constexpr (__is_same(decltype(x), Lanes)) return x; else return Lanes(double(x)); }};
auto times = [](auto a, auto b) {{
    if constexpr (__is_class(decltype(a)) || __is_class(decltype(b))) return wp::mul(a, b);
    else return a * b;
}};
"""
EACH = ("sqrt", "abs", "min", "max", "sign", "where", "length", "dot", "cw_mul", "transpose", "zeros")
OPERATORS: Mapping[type, str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "/",
    ast.Mod: "%",
    ast.Lt: "<",
    ast.Gt: ">",
    ast.Eq: "==",
    ast.USub: "-",
}


def shape_of(kind: Any) -> tuple[int, ...]:
    """Shape of a Warp vector or matrix type; of any other, none."""
    return tuple(getattr(kind, "_shape_", ()))


def fields_of(kind: Any) -> dict[str, Any]:
    """Types of a Warp structure's fields; of any other type, none."""
    return {name: part.type for name, part in getattr(kind, "vars", {}).items()}


def lanes_type(kind: Any) -> str:
    """C++ type that holds a Warp type in lanes; whole numbers are those of all lanes."""
    if kind is wp.float64 or kind is wp.int32:
        return "Lanes" if kind is wp.float64 else "int"
    if shape := shape_of(kind):
        return f"wp::{('vec_t', 'mat_t')[len(shape) - 1]}<{', '.join(map(str, shape))}, Lanes>"
    if isinstance(kind, wp.array):
        return f"Rows{'x'.join(map(str, shape_of(kind.dtype)))}"
    return f"{kind.key}Lanes"


def numbers_in(kind: Any) -> Iterator[tuple[str, Any]]:
    """How C++ gets at each number in a Warp type, and the number's own type."""
    if kind is wp.float64 or kind is wp.int32:
        yield "", kind
    for name, part in fields_of(kind).items():
        yield from ((f".{name}{rest}", number) for rest, number in numbers_in(part))
    if shape := shape_of(kind):
        rows = [f".c[{i}]" if len(shape) == 1 else f".data[{i}]" for i in range(shape[0])]
        columns = [f"[{j}]" for j in range(shape[1])] if len(shape) == 2 else [""]
        yield from ((row + column, wp.float64) for row in rows for column in columns)


def arrays_in(kind: Any) -> Iterator[tuple[str, Any]]:
    """How C++ gets at each array in a Warp structure, and the type of its rows: vectors or matrices."""
    for name, part in fields_of(kind).items():
        if isinstance(part, wp.array):
            yield f".{name}", part.dtype
        yield from ((f".{name}{rest}", rows) for rest, rows in arrays_in(part))


class Translation:
    """C++ for some Warp functions over lanes, and for what they call and the structures they take.

    Its text is to stand inside a function: lambdas and local types, in the order in which they need each other.
    """

    def __init__(self) -> None:
        self._parts = [HEAD]
        self._names: dict[int, str] = {}

    @property
    def text(self) -> str:
        """All so far."""
        return "\n".join(self._parts)

    def structure(self, kind: Any) -> str:
        """C++ type for a Warp type; the definition of a structure is added where it is new.

        An array in a structure is rows in lanes, which may be written to wherever it was handed on to, as in Warp.
        """
        name, known = lanes_type(kind), set(self._names.values())
        if isinstance(kind, wp.array) and name not in known:
            row = lanes_type(kind.dtype)
            self._names[id(kind)] = name
            access = f"{row}& operator[](int i) const {{ return at[i]; }}"
            self._parts.append(f"struct {name} {{ mutable {row} at[{MOST_ROWS}]; {access} }};")
        elif hasattr(kind, "vars") and name not in known:
            fields = "".join(f" {self.structure(part)} {field};" for field, part in fields_of(kind).items())
            self._names[id(kind)] = name
            self._parts.append(f"struct {name} {{{fields} }};")
        return name

    def function(self, function: wp.Function) -> str:
        """Name of the C++ lambda for a Warp function, which is added where it is new."""
        if id(function) not in self._names:
            writer = _Writer(self, function.func)
            body = writer.written()
            name = f"{function.func.__name__}_{len(self._names)}"
            self._names[id(function)] = name
            self._parts.append(f"auto {name} = [&]({writer.takes}) __attribute__((always_inline)) {{\n{body}\n}};")
        return self._names[id(function)]


class _Writer:
    """The statements of one function, written in C++."""

    def __init__(self, translation: Translation, python: Any) -> None:
        tree = ast.parse(textwrap.dedent(inspect.getsource(python)))
        self._source = next(node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
        self._translation = translation
        closure = inspect.getclosurevars(python)
        self._known: dict[str, Any] = {**python.__globals__, **closure.nonlocals}
        self._types = dict(python.__annotations__)
        self._names = [argument.arg for argument in self._source.args.args]
        self._scopes = [set(self._names)]
        self._made = 0

    @property
    def takes(self) -> str:
        """The function's parameters."""
        stored = {
            ast.unparse(node)
            for node in ast.walk(self._source)
            if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store)
        }
        kinds = {name: "auto" if name in stored else "const auto&" for name in self._names}
        return ", ".join(f"{kind} {name}_" for name, kind in kinds.items())

    def written(self) -> str:
        """The function's body."""
        return self._block(self._source.body)

    def _block(self, statements: list[ast.stmt], *variables: str) -> str:
        """Statements with variables of their own."""
        self._scopes.append(set(variables))
        lines = [self._statement(s) for s in statements if not isinstance(s, ast.Expr)]  # docstrings
        self._scopes.pop()
        return "\n".join(lines)

    def _statement(self, node: ast.stmt) -> str:
        match node:
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=value):
                self._made += 1
                parts = [self._assigned(target, f"found{self._made}.r{i}") for i, target in enumerate(targets)]
                return f"auto found{self._made} = {self._value(value)}; {' '.join(parts)}"
            case ast.Assign(targets=[target], value=value):
                return self._assigned(target, self._value(value), value)
            case ast.AugAssign(target=target, op=op, value=value):
                return f"{self._value(target)} {OPERATORS[type(op)]}= {self._value(value)};"
            case ast.For():
                return self._loop(node)
            case ast.If(test=test, body=body, orelse=[]):
                asked = f"({self._value(test)})" if isinstance(test, ast.Name) else self._value(test)
                return f"if {asked} {{\n{self._block(body)}\n}}"
            case ast.Return(value=ast.Tuple(elts=values)):
                found = " ".join(f"auto v{i} = {self._value(value)};" for i, value in enumerate(values))
                kept = " ".join(f"decltype(v{i}) r{i};" for i in range(len(values)))
                given = ", ".join(f"v{i}" for i in range(len(values)))
                return f"{found} struct All {{ {kept} }}; return All{{{given}}};"
            case ast.Return(value=ast.expr() as value):
                return f"return {self._value(value)};"
        raise self._unknown(node)

    def _assigned(self, target: ast.expr, value: str, made: ast.expr | None = None) -> str:
        """An assignment, which declares a variable where its name is new."""
        match target:
            case ast.Name(id=name):
                if isinstance(made, ast.Call) and shape_of(self._meant(made.func)):
                    self._types[name] = self._meant(made.func)
                if any(name in scope for scope in self._scopes):
                    return f"{name}_ = {value};"
                self._scopes[-1].add(name)
                return f"auto {name}_ = {value};"
            case ast.Subscript(value=ast.Name(id=name), slice=at) if self._is_row(target):
                return f"{name}_.set_row({self._value(at)}, {value});"
        return f"{self._value(target)} = {value};"

    def _loop(self, node: ast.For) -> str:
        """A loop; one that picks constants by its variable is written out."""
        match node:
            case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"), args=bounds)):
                first = bounds[0] if len(bounds) > 1 else ast.Constant(0)
                if "wp.static" not in ast.unparse(node.body):  # type: ignore[arg-type]
                    low, high, body = self._value(first), self._value(bounds[-1]), self._block(node.body, name)
                    return f"for (int {name}_ = {low}; {name}_ < {high}; ++{name}_) {{\n{body}\n}}"
                turns = []
                for i in range(int(self._meant(first)), int(self._meant(bounds[-1]))):
                    self._known[name] = i
                    turns.append(f"{{\n{self._block(node.body)}\n}}")
                self._known.pop(name, None)
                return "\n".join(turns)
        raise self._unknown(node)

    def _value(self, node: ast.expr) -> str:
        match node:
            case ast.Constant(value=int(value)):
                return str(int(value))
            case ast.Constant(value=float(value)):
                return value.hex()
            case ast.Name(id=name) if any(name in scope for scope in self._scopes):
                return f"{name}_"
            case ast.Name(id=name) | ast.Call(func=ast.Attribute(value=ast.Name(id="wp"), attr="static" as name)):
                return self._constant(self._meant(node))
            case ast.Attribute(value=value, attr=attr):
                return f"{self._value(value)}.{attr}"
            case ast.Subscript(value=value, slice=ast.Tuple(elts=[row, column])):
                return f"{self._value(value)}.data[{self._value(row)}][{self._value(column)}]"
            case ast.Subscript(value=value, slice=at) if self._is_row(node):
                return f"{self._value(value)}.get_row({self._value(at)})"
            case ast.Subscript(value=value, slice=at):
                return f"{self._value(value)}[{self._value(at)}]"
            case ast.UnaryOp(op=op, operand=value):
                return f"({OPERATORS[type(op)]}{self._value(value)})"
            case ast.BinOp(left=left, op=ast.Mult(), right=right):
                return f"times({self._value(left)}, {self._value(right)})"
            case ast.BinOp(left=left, op=op, right=right) | ast.Compare(left=left, ops=[op], comparators=[right]):
                return f"({self._value(left)} {OPERATORS[type(op)]} {self._value(right)})"
            case ast.Call(func=ast.Attribute(value=ast.Name(id="wp"), attr=name), args=given) if name in EACH:
                return f"each_{name}({', '.join(self._value(value) for value in given)})"
            case ast.Call(func=called, args=given) if getattr(self._meant(called), "func", self) is not None:
                return self._call(self._meant(called), given)
        raise self._unknown(node)

    def _call(self, called: Any, given: list[ast.expr]) -> str:
        """A call: of a function, of one of Warp's own, or of a type for a value of it."""
        values = [self._value(value) for value in given]
        if isinstance(called, wp.Function):
            return f"{self._translation.function(called)}({', '.join(values)})"
        if called is int:
            return values[0]
        if called is wp.float64:
            return f"number({values[0]})"
        kind, filled = self._translation.structure(called), ", ".join(values)
        if fields_of(called):
            return f"{kind}{{{filled}}}"
        plain = shape_of(called)[:1] < (5,) or len(values) == 1  # those have a constructor of their own
        return f"{kind}({filled})" if plain and values else f"{kind}({{{filled}}})" if values else f"{kind}{{}}"

    def _constant(self, value: Any) -> str:
        """A constant that the kernel is built with."""
        if isinstance(value, wp.float64 | float):
            return f"Lanes({float(value).hex()})"
        if isinstance(value, int | wp.int32):
            return str(int(value))
        if len(shape_of(type(value))) == 1:
            return f"{lanes_type(type(value))}({{{', '.join(self._constant(number) for number in value)}}})"
        raise TypeError(f"{value!r} is no constant that is known here")

    def _meant(self, node: ast.expr) -> Any:
        """What a name, or what is static, is in Python."""
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "wp.static":
            (node,) = node.args
        return eval(ast.unparse(node), self._known)

    def _is_row(self, node: ast.Subscript) -> bool:
        """Whether a subscript is a matrix' row."""
        kind = self._types.get(ast.unparse(node.value))
        return not isinstance(node.slice, ast.Tuple) and len(shape_of(kind)) == 2

    def _unknown(self, node: ast.AST) -> TypeError:
        return TypeError(f"{self._source.name} says what cannot be said over lanes: {ast.unparse(node)}")
