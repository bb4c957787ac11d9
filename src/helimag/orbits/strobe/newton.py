"""Newton's method with line search for fixed points of one-period maps, many at once.

Whether a step counts is judged by the length of the simplified correction, which no scaling of the equations changes:
P. Deuflhard, Newton Methods for Nonlinear Problems, Springer 2004, sec. 3.3. The residual itself would not do: the roll
makes up most of it and says little about the place.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.orbits.strobe import chart
from helimag.orbits.strobe.problem import Floats, Ints, Measured, Problem

CONVERGED = 1e-8  # last correction, radians and shares of the distance; the error left is about its square
LONGEST_MOVE = 0.15  # of the distance to the magnet, in one correction
LONGEST_TURN = 0.5  # rad
SHORTEST_SHARE = 1.0 / 64.0  # of a correction, before giving up
DECREASE = 1e-4  # of the correction's length, the least for a step to count (Armijo)


@dataclass(frozen=True)
class Solved:
    """Outcome of a batch of searches; arrays run over the searches."""

    converged: NDArray[np.bool_]
    states: Floats  # (n, 7), the last iterate where not converged
    residual: Floats  # (n,) of the last evaluation
    jacobian: Floats  # (n, 6, 6)
    measures: Measured  # (n,)
    iterations: Ints


def solve(problem: Problem, which: Ints, states: Floats, *, iterations: int = 25, held: bool = False) -> Solved:
    """Search a fixed point of each problem ``which`` from its state; the problem's watch hears how many are done.

    Parameters
    ----------
    states
        (n, 7): where to begin, moving frame.
    held
        Keep the head's place and solve for the orientation alone.
    """
    count = len(which)
    columns = range(3, 6) if held else range(6)
    at = _relaxed(problem, which, states, held)
    value, jacobian, measures = problem.linearized(which, at, columns=columns, held=held)
    step = _correction(value, jacobian, held)
    share = np.ones(count)
    evaluations = np.ones(count, dtype=np.int64)
    done = np.linalg.norm(step, axis=1) < CONVERGED
    active = np.flatnonzero(~done & np.isfinite(step).all(axis=1))
    while active.size:
        problem.watch(1.0 - active.size / count)
        tried = chart.moved(at[active], share[active, None] * step[active], problem.length[which[active]])
        tried = _relaxed(problem, which[active], tried, held)
        new, slope, seen = problem.linearized(which[active], tried, columns=columns, held=held)
        evaluations[active] += 1
        before = np.linalg.norm(_newton(value[active], jacobian[active], held), axis=1)
        after = np.linalg.norm(_newton(new, jacobian[active], held), axis=1)
        better = after < (1.0 - DECREASE * share[active]) * before
        better |= _norm(new, held) < 1e-13
        took, refused = active[better], active[~better]
        at[took], value[took], jacobian[took], measures[took] = tried[better], new[better], slope[better], seen[better]
        step[took] = _correction(value[took], jacobian[took], held)
        share[took] = 1.0
        share[refused] *= 0.5
        done[took] = np.linalg.norm(step[took], axis=1) < CONVERGED
        going = ~done & (share >= SHORTEST_SHARE) & (evaluations < iterations) & np.isfinite(step).all(axis=1)
        active = active[going[active]]
    problem.watch(1.0)
    at[done] = chart.moved(at[done], step[done], problem.length[which[done]])
    return Solved(done, at, _norm(value, held), jacobian, measures, evaluations)


def _relaxed(problem: Problem, which: Ints, states: Floats, held: bool) -> Floats:
    """States a turn later, where the head is free: a guess of the roll misleads the search, and is gone by then."""
    if held:
        return states.copy()
    later, _ = problem.map(which, states)
    # a whole turn of the body changes the quaternion's sign, which means nothing
    sense = np.where(np.sum(later[:, 3:] * states[:, 3:], axis=1) < 0.0, -1.0, 1.0)
    later[:, 3:] *= sense[:, None]
    return later


def _norm(value: Floats, held: bool) -> Floats:
    return np.asarray(np.linalg.norm(value[:, 3:] if held else value, axis=1))


def _correction(value: Floats, jacobian: Floats, held: bool) -> Floats:
    """Newton's step for ``map(x) = x``, cut to where the linear picture may be trusted; nan where singular."""
    step = _newton(value, jacobian, held)
    move = np.linalg.norm(step[:, :3], axis=1) / LONGEST_MOVE
    turn = np.linalg.norm(step[:, 3:], axis=1) / LONGEST_TURN
    return np.asarray(step / np.maximum(1.0, np.maximum(move, turn))[:, None])


def _newton(value: Floats, jacobian: Floats, held: bool) -> Floats:
    """Newton's step (n, 6) for ``map(x) = x``; nan where singular."""
    step = np.zeros_like(value)
    part = slice(3, 6) if held else slice(0, 6)
    step[:, part] = _solved(jacobian[:, part, part] - np.eye(6)[part, part], -value[:, part])
    return step


def _solved(matrices: Floats, right: Floats) -> Floats:
    """Solve a batch of linear systems, nan where a matrix is singular or not finite."""
    result = np.full_like(right, np.nan)
    good = np.asarray(np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(right).all(axis=1))
    good[good] = np.abs(np.linalg.det(matrices[good])) > 1e-300
    result[good] = np.linalg.solve(matrices[good], right[good][:, :, None])[:, :, 0]
    return result
