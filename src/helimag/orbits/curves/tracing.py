"""Trace a curve in the plane of two inputs along which a multiplier of a map's fixed point stays on the unit circle.

Unknowns are the fixed point and both inputs; equations are ``map(x; p) = x`` and a test function of the map's Jacobian.
Newton's corrections are the shortest ones (Moore-Penrose), so that no direction is singled out and folds over either
input are passed. W. J. F. Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, SIAM 2000, ch. 2-4;
Y. A. Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed., Springer 2004, ch. 10.
"""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from helimag.errors import InputError
from helimag.orbits.curves.crossings import UNNAMED, Crossing, Floats

STRIDE = 2e-4  # of the differences: coordinates, and shares of the inputs' ranges
FIRST_STEP = 0.005  # of arclength over coordinates and shares
LONGEST_STEP = 0.06
SPACING = 1.0 / 64.0  # of the ranges, between points at most
SHORTEST_STEP = 1e-6
CORRECTED = 1e-8  # size of the last correction
CORRECTIONS = 8
LONGEST_CORRECTION = 0.2
TURN = 0.9  # least cosine between tangents one step apart
LOCATED = 1e-7  # of arclength: how well the end of a curve is
MOST_POINTS = 1000
EDGE = "edge of the map"
CLOSED = "closed"
FAILED = "the search for the next point failed"


@dataclass(frozen=True)
class Place:
    """A state, and the inputs as shares (2,) of their ranges."""

    state: Floats
    shares: Floats


class Family(Protocol):
    """Maps of n coordinates over two inputs. Offsets (n + 2,) are coordinates around a place's state, then shares."""

    def moved(self, place: Place, by: Floats) -> Place:
        """The place at an offset."""

    def offset(self, place: Place, to: Place) -> Floats:
        """The offset of one place from another, inverse of ``moved``."""

    def images(self, place: Place, offsets: Floats) -> Floats:
        """Images (m, n) of the states at offsets (m, n + 2), in the coordinates around the place's state.

        Raises
        ------
        InputError
            Where an input cannot take such a value.
        """

    def refused(self, place: Place) -> str | None:
        """Why a fixed point there does not count, if so."""


@dataclass(frozen=True)
class Node:
    """A point of a curve: place, the map's Jacobian (n, n), what is on the unit circle, unit tangent (n + 2,)."""

    place: Place
    jacobian: Floats
    crossing: Crossing
    tangent: Floats

    @property
    def loss(self) -> float:
        """Negative where the curve bounds what is stable."""
        return float(self.crossing.losses(self.jacobian).max())


@dataclass(frozen=True)
class Trace:
    """A curve in order, and why it stops at either end."""

    nodes: list[Node]
    ends: tuple[str, str]


def trace(family: Family, first: Node) -> Trace:
    """Follow a curve both ways until it leaves the ranges, closes, or bounds what is stable no longer."""
    forth, end = _one_way(family, first)
    if end == CLOSED:
        return Trace([first, *forth], (CLOSED, CLOSED))
    back, begin = _one_way(family, replace(first, tangent=-first.tangent))
    return Trace([*reversed(back), first, *forth], (begin, end))


def on_curve(family: Family, crossing: Crossing, place: Place) -> Node | None:
    """The point of a curve nearest to a place; None where the search fails."""
    found = _corrected(family, crossing, place, None, None)
    return None if found is None else found[0]


def advanced(family: Family, at: Node, step: float) -> Node | None:
    """The point of the curve a step along the tangent."""
    found = _corrected(family, at.crossing, family.moved(at.place, step * at.tangent), None, at.tangent)
    return None if found is None else found[0]


def _one_way(family: Family, first: Node) -> tuple[list[Node], str]:
    """Points after the first along its tangent, and why there are no more."""
    nodes: list[Node] = []
    at, step = first, FIRST_STEP
    while len(nodes) < MOST_POINTS:
        step = min(step, LONGEST_STEP, SPACING / max(float(np.linalg.norm(at.tangent[-2:])), 1e-9))
        if step < SHORTEST_STEP:
            return nodes, FAILED
        taken = _taken(family, at, step)
        if taken is None:
            return nodes, EDGE
        new, landed, iterations = taken
        if new is None or (_strays(at, new) and step > 100.0 * SHORTEST_STEP):
            step *= 0.5
            continue
        if nodes and _between(family, at, first, new):
            return [*nodes, first], CLOSED
        if new.loss >= 0.0:
            end, name = _end(family, at, new)
            return [*nodes, end], name
        why = family.refused(new.place)
        if why is not None:
            if step > 1e-3:
                step *= 0.5
                continue
            return nodes, why
        nodes.append(new)
        if landed:
            return nodes, EDGE
        at = new
        step *= 1.5 if iterations <= 3 else 0.7
    return nodes, f"{MOST_POINTS} points, the most that are traced"


def _strays(at: Node, new: Node) -> bool:
    """Whether a step turned too far or was too long to draw."""
    wide = np.linalg.norm(new.place.shares - at.place.shares) > 1.2 * SPACING
    return bool(wide or new.tangent @ at.tangent < TURN)


def _taken(family: Family, at: Node, step: float) -> tuple[Node | None, bool, int] | None:
    """One step, cut where it would leave the ranges; with whether it landed on an edge. None where it stands there."""
    way = _way_out(at.place.shares, at.place.shares + step * at.tangent[-2:])
    if way is None:
        found = _corrected(family, at.crossing, family.moved(at.place, step * at.tangent), None, at.tangent)
        if found is None:
            return None, False, 0
        way = _way_out(at.place.shares, found[0].place.shares)
        if way is None:
            return found[0], False, found[1]
    share, edge, limit = way
    if share * step < 1e-9:
        return None
    predicted = family.moved(at.place, share * step * at.tangent)
    shares = predicted.shares.copy()
    shares[edge] = limit
    found = _corrected(family, at.crossing, Place(predicted.state, shares), edge, at.tangent)
    if found is None or np.any(np.abs(found[0].place.shares - 0.5) > 0.5 + 1e-9):
        return None, False, 0
    return found[0], True, found[1]


def _way_out(begin: Floats, end: Floats) -> tuple[float, int, float] | None:
    """Share of the way to where it first leaves the unit square, the input that does, and at which value."""
    limits = np.clip(end, 0.0, 1.0)
    outside = np.flatnonzero(limits != end)
    if not outside.size:
        return None
    ways = [max(float((limits[k] - begin[k]) / (end[k] - begin[k])), 0.0) for k in outside]
    first = int(np.argmin(ways))
    return ways[first], int(outside[first]), float(limits[outside[first]])


def _between(family: Family, at: Node, first: Node, new: Node) -> bool:
    """Whether the first point of a curve lies on the step between two later ones: then it is closed."""
    ahead, behind = family.offset(at.place, first.place), family.offset(new.place, first.place)
    step = family.offset(at.place, new.place)
    length = float(np.linalg.norm(step))
    along = float(ahead @ step) / length
    aside = float(np.linalg.norm(ahead - along / length * step))
    same = first.tangent @ at.tangent > 0.5
    return bool(same and ahead @ step > 0.0 and behind @ step <= 0.0 and aside < 0.3 * length)


def _end(family: Family, at: Node, beyond: Node) -> tuple[Node, str]:
    """The point between two neighbours where the curve ceases to bound what is stable; and its name."""
    whole = float(np.linalg.norm(family.offset(at.place, beyond.place)))

    def reached(step: float) -> Node:
        found = advanced(family, at, step)
        if found is None:
            raise np.linalg.LinAlgError(FAILED)
        return found

    end = beyond
    try:
        far = next(step for step in (whole, 1.2 * whole, 1.5 * whole) if reached(step).loss >= 0.0)
        end = reached(float(brentq(lambda step: reached(step).loss if step else at.loss, 0.0, far, xtol=LOCATED)))
    except (np.linalg.LinAlgError, StopIteration):
        return end, UNNAMED
    return end, end.crossing.named(end.jacobian)


def _corrected(
    family: Family, crossing: Crossing, place: Place, held: int | None, along: Floats | None
) -> tuple[Node, int] | None:
    """Newton's method from a predicted place, one input held where ``held`` says so; None where it does not converge.

    The tangent points along ``along`` where that is given.
    """
    for iteration in range(CORRECTIONS):
        try:
            value, matrix, jacobian = _equations(family, crossing, place)
            step = _shortest(matrix, -value, held)
        except (InputError, np.linalg.LinAlgError):
            return None
        if not np.linalg.norm(step) < LONGEST_CORRECTION:
            return None
        place = family.moved(place, step)
        if np.linalg.norm(step) < CORRECTED:
            tangent = np.linalg.svd(matrix)[2][-1]
            if along is not None and tangent @ along < 0.0:
                tangent = -tangent
            return Node(place, jacobian, crossing.renewed(jacobian), tangent), iteration
    return None


def _shortest(matrix: Floats, right: Floats, held: int | None) -> Floats:
    """The shortest solution of equations with one more unknown, or the one that leaves an input as it is."""
    if not np.isfinite(matrix).all() or not np.isfinite(right).all():
        return np.full(matrix.shape[1], np.nan)
    if held is None:
        return np.asarray(np.linalg.lstsq(matrix, right)[0])
    row = np.zeros((1, matrix.shape[1]))
    row[0, matrix.shape[1] - 2 + held] = 1.0
    return np.asarray(np.linalg.solve(np.vstack([matrix, row]), np.append(right, 0.0)))


def _equations(family: Family, crossing: Crossing, place: Place) -> tuple[Floats, Floats, Floats]:
    """Residual (n + 1,), its derivative (n + 1, n + 2), and the map's Jacobian (n, n), by central differences.

    How the test function changes needs second derivatives of the map, only along the criterion's right vectors.
    """
    n = family.offset(place, place).size - 2
    along = STRIDE * np.eye(n + 2)
    images = family.images(place, np.concatenate([np.zeros((1, n + 2)), along, -along]))
    slopes = (images[1 : n + 3] - images[n + 3 :]).T / (2.0 * STRIDE)
    jacobian = slopes[:, :n]
    if not np.isfinite(images).all():
        raise np.linalg.LinAlgError("the map is not finite")
    test = crossing.criterion(jacobian)
    count = test.right.shape[1]
    vectors = np.column_stack([test.right.T, np.zeros((count, 2))])
    sizes = np.linalg.norm(vectors, axis=1)
    vectors = STRIDE * vectors / sizes[:, None]
    corners = [a * along[:, None] + b * vectors[None] for a in (1.0, -1.0) for b in (1.0, -1.0)]
    seen = family.images(place, np.concatenate([corner.reshape(-1, n + 2) for corner in corners]))
    pp, pm, mp, mm = seen.reshape(4, n + 2, count, n)
    mixed = (pp - pm - mp + mm) / (4.0 * STRIDE**2) * sizes[None, :, None]
    gradient = np.einsum("ik,jki->j", test.left, mixed)
    matrix = np.vstack([slopes - np.eye(n, n + 2), gradient])
    return np.append(images[0], test.value), matrix, jacobian
