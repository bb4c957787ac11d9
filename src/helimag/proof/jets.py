"""Numbers with derivatives: a value, its gradient and, if wanted, its second derivatives, in six variables.

The values may be floats, NumPy arrays, balls or series of balls: whatever adds and multiplies. Derivatives that are
zero are not kept. Products, quotients and roots follow the rules of calculus and nothing else, so that an enclosure of
the values gives enclosures of the derivatives.
"""

from collections.abc import Sequence
from typing import Any

Value = Any
VARIABLES = 6


class Jet:
    """A value with its gradient ``g`` by variable and second derivatives ``h`` by pair (i <= j), None if not kept."""

    __slots__ = ("g", "h", "v")
    __array_ufunc__ = None  # an array times a jet is a jet of arrays, not an array of jets

    def __init__(
        self, v: Value, g: dict[int, Value] | None = None, h: dict[tuple[int, int], Value] | None = None
    ) -> None:
        self.v, self.g, self.h = v, g or {}, h

    def __add__(self, other: Value) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(self.v + other, self.g, self.h)
        return Jet(self.v + other.v, _sum(self.g, other.g), _both(self.h, other.h))

    __radd__ = __add__

    def __neg__(self) -> "Jet":
        return self.scaled(-1)

    def __sub__(self, other: Value) -> "Jet":
        less: Jet = self + (-other)
        return less

    def __rsub__(self, other: Value) -> "Jet":
        less = self.scaled(-1)
        return Jet(other + less.v, less.g, less.h)

    def scaled(self, by: Value) -> "Jet":
        """Times something that does not depend on the variables."""
        second = None if self.h is None else {key: by * value for key, value in self.h.items()}
        return Jet(by * self.v, {key: by * value for key, value in self.g.items()}, second)

    def __mul__(self, other: Value) -> "Jet":
        if not isinstance(other, Jet):
            return self.scaled(other)
        first = _sum({i: other.v * a for i, a in self.g.items()}, {i: self.v * b for i, b in other.g.items()})
        if self.h is None and other.h is None:
            return Jet(self.v * other.v, first)
        second = {key: other.v * a for key, a in (self.h or {}).items()}
        second = _sum(second, {key: self.v * b for key, b in (other.h or {}).items()})
        for i, a in self.g.items():
            for j, b in other.g.items():
                key, term = (min(i, j), max(i, j)), a * b
                if i == j:
                    term = 2 * term
                second[key] = second[key] + term if key in second else term
        return Jet(self.v * other.v, first, second)

    __rmul__ = __mul__

    def __truediv__(self, by: Value) -> "Jet":
        if isinstance(by, Jet):
            return self * by.inverse()
        second = None if self.h is None else {key: value / by for key, value in self.h.items()}
        return Jet(self.v / by, {key: value / by for key, value in self.g.items()}, second)

    def through(self, value: Value, slope: Value, bend: Value) -> "Jet":
        """A function of this number, from its value, first and second derivative here."""
        first = {i: slope * a for i, a in self.g.items()}
        if self.h is None:
            return Jet(value, first)
        second = {key: slope * a for key, a in self.h.items()}
        indices = sorted(self.g)
        for n, i in enumerate(indices):
            for j in indices[n:]:
                term = bend * (self.g[i] * self.g[j])
                second[i, j] = second[i, j] + term if (i, j) in second else term
        return Jet(value, first, second)

    def __rtruediv__(self, other: Value) -> "Jet":
        return self.inverse().scaled(other)

    def __abs__(self) -> "Jet":
        return self if self.v > 0 else self.scaled(-1)

    def cos(self) -> "Jet":
        """Cosine, of balls."""
        cosine, sine = self.v.cos(), self.v.sin()
        return self.through(cosine, -sine, -cosine)

    def sin(self) -> "Jet":
        """Sine, of balls."""
        cosine, sine = self.v.cos(), self.v.sin()
        return self.through(sine, cosine, -sine)

    def inverse(self) -> "Jet":
        """One over this number."""
        one = 1 / self.v
        square = one * one
        return self.through(one, -square, 2 * (square * one))

    def inverse_root(self) -> "Jet":
        """One over the square root of this number."""
        root = self.v.rsqrt() if hasattr(self.v, "rsqrt") else self.v**-0.5
        square = root * root
        slope = (root * square) / -2
        return self.through(root, slope, (slope * square * 3) / -2)


def variables(values: Sequence[Value], *, second: bool = False, one: Value = 1) -> list[Jet]:
    """The six variables themselves at these values; ``one`` is what their derivatives are counted in."""
    return [Jet(value, {i: one}, {} if second else None) for i, value in enumerate(values)]


def _sum(a: dict[Any, Value], b: dict[Any, Value]) -> dict[Any, Value]:
    if not a:
        return dict(b)
    result = dict(a)
    for key, value in b.items():
        result[key] = result[key] + value if key in result else value
    return result


def _both(a: dict[Any, Value] | None, b: dict[Any, Value] | None) -> dict[Any, Value] | None:
    return None if a is None and b is None else _sum(a or {}, b or {})
