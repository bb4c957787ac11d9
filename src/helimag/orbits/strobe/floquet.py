"""Floquet multipliers of an orbit: eigenvalues of the one-period map's Jacobian, and the rates that they stand for."""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.orbits.strobe.problem import Floats, Problem

Complexes = NDArray[np.complex128]

RESOLVED = 1e-6  # smaller multipliers drown in the differences' rounding (about 1e-9) and are taken from the parts
STEPS_A_PART = 3
SWEEPS = 3


def multipliers_of(jacobian: Floats) -> Complexes:
    """Eigenvalues (..., 6), the slowest decay or fastest growth first."""
    values = np.linalg.eigvals(jacobian).astype(np.complex128)
    order = np.lexsort((-values.imag, -np.round(np.abs(values), 14)), axis=-1)
    return np.take_along_axis(values, order, axis=-1)


def rates_of(multipliers: Complexes, period: Floats) -> Complexes:
    """Rates (1/s): logarithms of the multipliers over the period, imaginary part within half a turn a period."""
    safe = np.where(np.abs(multipliers) > 0.0, multipliers, 1e-300)
    return np.asarray(np.log(safe) / np.asarray(period)[..., None])


def fast_multipliers(problem: Problem, state: Floats, multipliers: Complexes) -> Complexes:
    """The same multipliers with those too small for the whole period's Jacobian resolved.

    The period is cut into parts short enough that nothing decays much in one; the product of the parts' Jacobians is
    factored as it is formed (orthogonal iteration), so that small factors are not lost beside large ones. What is found
    there is a size: such multipliers are given as real and positive.
    """
    small = np.abs(multipliers) < RESOLVED
    if not small.any():
        return multipliers
    which = np.zeros(1, dtype=np.int64)
    steps = int(problem.steps(which, state[None])[0])
    parts = math.ceil(steps / STEPS_A_PART)
    phase = np.arange(parts + 1) / parts
    every = np.zeros(parts, dtype=np.int64)
    few = np.full(parts, STEPS_A_PART, dtype=np.int64)
    counts = few * np.maximum(np.arange(parts), 1)
    starts, _ = problem.advance(every, np.repeat(state[None], parts, axis=0), counts, 0.0 * phase[:-1], phase[:-1])
    _, jacobians, _ = problem.linearized(every, starts, begin=phase[:-1], end=phase[1:], steps=few)
    frame = np.eye(6)
    sizes = np.zeros(6)
    for _ in range(SWEEPS):
        sizes[:] = 0.0
        for jacobian in jacobians:
            frame, triangle = np.linalg.qr(jacobian @ frame)
            sizes += np.log(np.abs(np.diag(triangle)))
    result = multipliers.copy()
    result[small] = np.exp(np.sort(sizes)[::-1][small])
    return result
