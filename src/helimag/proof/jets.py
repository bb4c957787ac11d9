"""Numbers with derivatives: a value, its gradient and, if wanted, its second and third derivatives, in some variables.

The values may be floats, NumPy arrays, balls or series of balls: whatever adds and multiplies. Derivatives that are
zero are not kept. Products, quotients and roots follow the rules of calculus and nothing else, so that an enclosure of
the values gives enclosures of the derivatives.
"""

from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import Any

Value = Any
Pair = tuple[int, int]
Triple = tuple[int, int, int]
VARIABLES = 6


class Jet:
    """A value with its gradient ``g`` by variable, second derivatives ``h`` by pair and third ones ``t`` by triple.

    Pairs and triples are in order. What is None is not known, of a jet that depends on a variable; a result knows
    what all that went into it knew.
    """

    __slots__ = ("g", "h", "t", "v")
    __array_ufunc__ = None  # an array times a jet is a jet of arrays, not an array of jets

    def __init__(
        self,
        v: Value,
        g: dict[int, Value] | None = None,
        h: dict[Pair, Value] | None = None,
        t: dict[Triple, Value] | None = None,
    ) -> None:
        self.v, self.g, self.h, self.t = v, g or {}, h, t

    @property
    def derivatives(self) -> tuple[dict[Any, Value] | None, ...]:
        """The gradient, second and third derivatives."""
        return self.g, self.h, self.t

    def __add__(self, other: Value) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(self.v + other, self.g, self.h, self.t)
        second = _sum(self.h or {}, other.h or {}) if _known(self, other, "h") else None
        third = _sum(self.t or {}, other.t or {}) if _known(self, other, "t") else None
        return Jet(self.v + other.v, _sum(self.g, other.g), second, third)

    __radd__ = __add__

    def __neg__(self) -> "Jet":
        return self.scaled(-1)

    def __sub__(self, other: Value) -> "Jet":
        less: Jet = self + (-other)
        return less

    def __rsub__(self, other: Value) -> "Jet":
        less = self.scaled(-1)
        return Jet(other + less.v, less.g, less.h, less.t)

    def scaled(self, by: Value) -> "Jet":
        """Times something that does not depend on the variables."""
        second = None if self.h is None else {key: by * value for key, value in self.h.items()}
        third = None if self.t is None else {key: by * value for key, value in self.t.items()}
        return Jet(by * self.v, {key: by * value for key, value in self.g.items()}, second, third)

    def __mul__(self, other: Value) -> "Jet":
        if not isinstance(other, Jet):
            return self.scaled(other)
        first = _sum({i: other.v * a for i, a in self.g.items()}, {i: self.v * b for i, b in other.g.items()})
        second = _second_of_product(self, other) if _known(self, other, "h") else None
        third = _third_of_product(self, other) if _known(self, other, "t") else None
        return Jet(self.v * other.v, first, second, third)

    __rmul__ = __mul__

    def __truediv__(self, by: Value) -> "Jet":
        if isinstance(by, Jet):
            return self * by.inverse()
        second = None if self.h is None else {key: value / by for key, value in self.h.items()}
        third = None if self.t is None else {key: value / by for key, value in self.t.items()}
        return Jet(self.v / by, {key: value / by for key, value in self.g.items()}, second, third)

    def through(self, value: Value, slope: Value, bend: Value, jerk: Value) -> "Jet":
        """A function of this number, from its value and first three derivatives here."""
        first = {i: slope * a for i, a in self.g.items()}
        if self.h is None:
            return Jet(value, first)
        indices = sorted(self.g)
        second = {key: slope * a for key, a in self.h.items()}
        for i, j in combinations_with_replacement(indices, 2):
            _add(second, (i, j), bend * (self.g[i] * self.g[j]))
        if self.t is None:
            return Jet(value, first, second)
        third = {key: slope * a for key, a in self.t.items()}
        _add_mixed(third, {key: bend * a for key, a in self.h.items()}, self.g)
        for i, j, k in combinations_with_replacement(indices, 3):
            _add(third, (i, j, k), jerk * (self.g[i] * self.g[j] * self.g[k]))
        return Jet(value, first, second, third)

    def __rtruediv__(self, other: Value) -> "Jet":
        return self.inverse().scaled(other)

    def __abs__(self) -> "Jet":
        return self if self.v > 0 else self.scaled(-1)

    def cos(self) -> "Jet":
        """Cosine, of balls."""
        cosine, sine = self.v.cos(), self.v.sin()
        return self.through(cosine, -sine, -cosine, sine)

    def sin(self) -> "Jet":
        """Sine, of balls."""
        cosine, sine = self.v.cos(), self.v.sin()
        return self.through(sine, cosine, -sine, -cosine)

    def inverse(self) -> "Jet":
        """One over this number."""
        one = 1 / self.v
        square = one * one
        return self.through(one, -square, 2 * (square * one), -6 * (square * square))

    def inverse_root(self) -> "Jet":
        """One over the square root of this number."""
        root = self.v.rsqrt() if hasattr(self.v, "rsqrt") else self.v**-0.5
        square = root * root
        slope = (root * square) / -2
        bend = (slope * square * 3) / -2
        return self.through(root, slope, bend, (bend * square * 5) / -2)


def variables(values: Sequence[Value], *, order: int = 1, one: Value = 1) -> list[Jet]:
    """The variables themselves at these values, with derivatives of an order; ``one`` is what these are counted in."""
    return [
        Jet(value, {i: one}, {} if order > 1 else None, {} if order > 2 else None) for i, value in enumerate(values)
    ]


def known(derivatives: dict[Any, Value] | None) -> dict[Any, Value]:
    """Derivatives that a result needs: what is None is not zero.

    Raises
    ------
    TypeError
        Where they are not known.
    """
    if derivatives is None:
        raise TypeError("derivatives are needed that were not asked of what this was made of")
    return derivatives


def _known(a: Jet, b: Jet, name: str) -> bool:
    """Whether derivatives of a name are known of both: what depends on no variable has none."""
    return all(getattr(each, name) is not None or not each.g for each in (a, b))


def _second_of_product(a: Jet, b: Jet) -> dict[Pair, Value]:
    second = {key: b.v * value for key, value in (a.h or {}).items()}
    second = _sum(second, {key: a.v * value for key, value in (b.h or {}).items()})
    for i, x in a.g.items():
        for j, y in b.g.items():
            term = x * y
            _add(second, (i, j) if i <= j else (j, i), 2 * term if i == j else term)
    return second


def _third_of_product(a: Jet, b: Jet) -> dict[Triple, Value]:
    third = {key: b.v * value for key, value in (a.t or {}).items()}
    third = _sum(third, {key: a.v * value for key, value in (b.t or {}).items()})
    _add_mixed(third, a.h or {}, b.g)
    _add_mixed(third, b.h or {}, a.g)
    return third


def _add_mixed(third: dict[Triple, Value], second: dict[Pair, Value], first: dict[int, Value]) -> None:
    """Add the products of second and first derivatives: each triple parts into a pair and a single in three ways."""
    for (i, j), x in second.items():
        for k, y in first.items():
            term, ways = x * y, 1 + (i == k) + (j == k)
            if ways > 1:
                term = ways * term
            key = (i, j, k) if k >= j else (i, k, j) if k >= i else (k, i, j)
            if key in third:  # not by a function: this is where a proof spends its time
                third[key] += term
            else:
                third[key] = term


def _add(into: dict[Any, Value], key: Any, value: Value) -> None:
    into[key] = into[key] + value if key in into else value


def _sum(a: dict[Any, Value], b: dict[Any, Value]) -> dict[Any, Value]:
    if not a:
        return dict(b)
    result = dict(a)
    for key, value in b.items():
        result[key] = result[key] + value if key in result else value
    return result
