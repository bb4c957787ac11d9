"""Test functions of a map's Jacobian that vanish where multipliers lie on the unit circle.

W. J. F. Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, SIAM 2000, ch. 3-4; Y. A. Kuznetsov,
Elements of Applied Bifurcation Theory, 3rd ed., Springer 2004, ch. 9 and 10.
"""

from dataclasses import dataclass
from itertools import combinations
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from helimag.orbits.curves.branch import Change

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

FOLD_WITH_SWING = "fold-Neimark-Sacker"
DOUBLE_ONE = "Bogdanov-Takens"
DOUBLE_MINUS_ONE = "1:2 resonance"
UNNAMED = "another rate crosses"
NAMES = {  # of the point where besides this kind another multiplier is at +1, at -1, or a pair is on the circle
    Change.FOLD: (DOUBLE_ONE, "fold-flip", FOLD_WITH_SWING),
    Change.PERIOD_DOUBLING: ("fold-flip", DOUBLE_MINUS_ONE, "flip-Neimark-Sacker"),
    Change.NEIMARK_SACKER: (FOLD_WITH_SWING, "flip-Neimark-Sacker", "double Neimark-Sacker"),
}
CODIMENSION_TWO = frozenset(name for names in NAMES.values() for name in names)
ONE_VECTOR = 1e-8  # second singular value above which a double multiplier has one eigenvector, as generic ones have


@dataclass(frozen=True)
class Criterion:
    """A test function's value; a change dJ of the Jacobian (n, n) changes it by the sum of ``left_k . dJ right_k``."""

    value: float
    left: Floats  # (n, k)
    right: Floats  # (n, k)


class Crossing(Protocol):
    """What lies on the unit circle along a curve, with what is needed to tell it from the other multipliers."""

    @property
    def kind(self) -> Change:
        """Which change of stability it makes."""

    @property
    def angle(self) -> float:
        """Argument of the multiplier on the circle, rad."""

    def criterion(self, jacobian: Floats) -> Criterion:
        """The test function at a Jacobian (n, n)."""

    def renewed(self, jacobian: Floats) -> Self:
        """The same fitted to the Jacobian at a point of the curve, for use in its neighbourhood."""

    def losses(self, jacobian: Floats) -> Floats:
        """(2,), negative where the curve bounds what is stable: logarithm of the largest other multiplier's size, and
        what is zero where this crossing becomes one of another kind."""

    def named(self, jacobian: Floats) -> str:
        """The codimension-two point where a loss passes zero."""


@dataclass(frozen=True)
class OneReal:
    """A real multiplier at ``target``: +1 at a fold, -1 at a period doubling.

    The test function is the last unknown g of ``(J - target) v + g left = 0, right . v = 1``: zero where the matrix is
    singular, and smooth there, at folds too.
    """

    target: float
    left: Floats  # (n,) borders, near the null vectors
    right: Floats

    @classmethod
    def near(cls, jacobian: Floats, target: float) -> Self:
        """The multiplier nearest to the target, at a Jacobian where it is about there."""
        u, _, vh = np.linalg.svd(jacobian - target * np.eye(len(jacobian)))
        return cls(target, u[:, -1], vh[-1])

    @property
    def kind(self) -> Change:
        return Change.FOLD if self.target > 0.0 else Change.PERIOD_DOUBLING

    @property
    def angle(self) -> float:
        return 0.0 if self.target > 0.0 else np.pi

    def criterion(self, jacobian: Floats) -> Criterion:
        n = len(jacobian)
        shifted = jacobian - self.target * np.eye(n)
        matrix = np.block([[shifted, self.left[:, None]], [self.right[None], np.zeros((1, 1))]])
        unit = np.eye(n + 1)[n]
        v, w = np.linalg.solve(matrix, unit), np.linalg.solve(matrix.T, unit)
        return Criterion(float(v[n]), -w[:n, None], v[:n, None])

    def renewed(self, jacobian: Floats) -> Self:
        found = self.criterion(jacobian)
        left, right = -found.left[:, 0], found.right[:, 0]
        return type(self)(self.target, left / np.linalg.norm(left), right / np.linalg.norm(right))

    def losses(self, jacobian: Floats) -> Floats:
        others = self._others(jacobian)
        return np.array([_size(others), -np.inf])

    def named(self, jacobian: Floats) -> str:
        name = _name(self.kind, self._others(jacobian))
        singular = np.linalg.svd(jacobian - self.target * np.eye(len(jacobian)), compute_uv=False)
        return UNNAMED if name in (DOUBLE_ONE, DOUBLE_MINUS_ONE) and singular[-2] < ONE_VECTOR else name

    def _others(self, jacobian: Floats) -> Complexes:
        values = np.linalg.eigvals(jacobian).astype(np.complex128)
        critical = values[np.argmin(np.abs(values - self.target))]
        others = np.delete(values, np.argmin(np.abs(values - self.target)))
        if others.size:
            # two that are nearly the same are each good to the root of the rounding only, but their sum is not
            partner = int(np.argmin(np.abs(others - self.target)))
            if others[partner].imag == 0.0 or others[partner] == critical.conjugate():
                others[partner] = others[partner].real + critical.real - self.target
        return others


@dataclass(frozen=True)
class Pair:
    """Two multipliers with product one: a complex pair on the circle at a Neimark-Sacker point.

    The test function is the logarithm of their product, by the map's restriction to the plane that belongs to both. It
    stays smooth where they meet on the real axis, beyond which they are two real ones of product one.

    ``swing`` is the square root of their logarithms' product, by which the pair is known again: its angle.
    """

    swing: complex

    @property
    def kind(self) -> Change:
        return Change.NEIMARK_SACKER

    @property
    def angle(self) -> float:
        return self.swing.real

    def criterion(self, jacobian: Floats) -> Criterion:
        left, right, inner = self._plane(jacobian)
        return Criterion(float(np.log(np.linalg.det(inner))), left @ np.linalg.inv(inner).T, right)

    def renewed(self, jacobian: Floats) -> Self:
        return type(self)(self._chosen(jacobian)[2])

    def losses(self, jacobian: Floats) -> Floats:
        inner = self._plane(jacobian)[2]
        others = self._chosen(jacobian)[3]
        return np.array([_size(others), np.trace(inner) ** 2 / 4.0 - np.linalg.det(inner)])

    def named(self, jacobian: Floats) -> str:
        if np.argmax(self.losses(jacobian)) == 0:
            return _name(self.kind, self._chosen(jacobian)[3])
        return DOUBLE_ONE if np.trace(self._plane(jacobian)[2]) > 0.0 else DOUBLE_MINUS_ONE

    def _chosen(self, jacobian: Floats) -> tuple[float, float, complex, Complexes]:
        """Sum and product of the pair's multipliers, its swing, and the other multipliers."""
        values = np.linalg.eigvals(jacobian).astype(np.complex128)
        best, cost = None, np.inf
        for i, j in combinations(range(len(values)), 2):
            a, b = values[i], values[j]
            if a != b.conjugate() and (a.imag != 0.0 or b.imag != 0.0 or a.real * b.real <= 0.0):
                continue
            swing = np.sqrt(complex((np.log(a) * np.log(a if a.imag else b).conjugate()).real))
            here = abs(np.log(abs(a * b))) + abs(swing - self.swing)
            if here < cost:
                best, cost = (i, j, complex(swing)), here
        if best is None:
            raise np.linalg.LinAlgError("no two multipliers make a pair")
        i, j, swing = best
        a, b = values[i], values[j]
        return float((a + b).real), float((a * b).real), swing, np.delete(values, [i, j])

    def _plane(self, jacobian: Floats) -> tuple[Floats, Floats, Floats]:
        """Left and right bases (n, 2) of the pair's plane, with ``left.T @ right`` one, and the map within it."""
        total, product, _, _ = self._chosen(jacobian)
        u, _, vh = np.linalg.svd(jacobian @ jacobian - total * jacobian + product * np.eye(len(jacobian)))
        right = vh[-2:].T
        left = u[:, -2:] @ np.linalg.inv(right.T @ u[:, -2:])
        return left, right, left.T @ jacobian @ right


def _size(others: Complexes) -> float:
    return float(np.log(np.max(np.abs(others), initial=1e-300)))


def _name(kind: Change, others: Complexes) -> str:
    lead = others[np.argmax(np.abs(others))]
    return NAMES[kind][2 if abs(lead.imag) > 1e-9 else int(lead.real < 0.0)]
