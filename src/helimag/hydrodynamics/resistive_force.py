"""Resistive-force theory of a helix: 6x6 resistance from drag coefficients along the wire (paper, eq. 7)."""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.geometry import CHIRALITY, helix_line
from helimag.scenario import Helix

MOST_TURNS = 100_000  # what the quadrature takes in a second
POINTS_PER_TURN = 24  # Gauss-Legendre; the integrand is a product of low harmonics, so this is at rounding error


def lighthill(helix: Helix, viscosity: float) -> tuple[float, float]:
    """Drag per length along and across the wire (Pa s), J. Lighthill, SIAM Rev. 18 (1976) 161."""
    ratio = 0.18 * helix.pitch * helix.contour_per_length / helix.wire_radius
    return _coefficients(ratio, 0.0, viscosity)


def gray_hancock(helix: Helix, viscosity: float) -> tuple[float, float]:
    """Drag per length along and across the wire (Pa s), J. Gray and G. J. Hancock, J. Exp. Biol. 32 (1955) 802."""
    return _coefficients(2.0 * helix.pitch / helix.wire_radius, -0.5, viscosity)


def _coefficients(ratio: float, shift_along: float, viscosity: float) -> tuple[float, float]:
    """``2 pi mu / (ln ratio + shift)`` along the wire and ``4 pi mu / (ln ratio + 1/2)`` across it."""
    slenderness = math.log(ratio)
    if not min(slenderness + shift_along, slenderness + 0.5) > 0.0:
        raise InputError(
            "device.helix.wire_radius is too thick for resistive-force theory, whose drag would be negative: "
            f"log({ratio:.3g}) {shift_along:+g} must be greater than zero"
        )
    turn = 2.0 * math.pi * viscosity
    return turn / (slenderness + shift_along), 2.0 * turn / (slenderness + 0.5)


def centerline(helix: Helix, start: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Points (n, 3), unit tangents (n, 3) and arc-length weights (n,) along the wire, body frame, m.

    The wire begins ``start`` (m) behind the origin; positions follow ``(-start - u, R cos ku, chi R sin ku)``.
    """
    turns = helix.length / helix.pitch
    if turns > MOST_TURNS:
        raise InputError(f"device.helix.length must be at most {MOST_TURNS} times the pitch; got {turns:.3g} times")
    panels = max(1, math.ceil(turns))
    nodes, weights = np.polynomial.legendre.leggauss(POINTS_PER_TURN)
    edges = np.linspace(0.0, helix.length, panels + 1)
    half = np.diff(edges) / 2.0
    u = (edges[:-1, None] + half[:, None] * (1.0 + nodes)).ravel()
    du = (half[:, None] * weights).ravel()
    k, chi = 2.0 * math.pi / helix.pitch, CHIRALITY[helix.handedness]
    points = helix_line(u, radius=helix.radius, pitch=helix.pitch, chirality=chi, behind=start)
    slope = np.stack(
        [-np.ones_like(u), -k * helix.radius * np.sin(k * u), chi * k * helix.radius * np.cos(k * u)], axis=1
    )
    return points, slope / helix.contour_per_length, du * helix.contour_per_length


def helix_resistance(helix: Helix, start: float, along: float, across: float) -> NDArray[np.float64]:
    """6x6 resistance of the wire about the body origin (SI), translation first: the integral of M ds in eq. (7).

    An element that moves with velocity u feels ``-(along t t' + across (I - t t')) u ds``; in a rigid motion (v, w) the
    element at r moves with v + w x r.
    """
    points, tangents, weights = centerline(helix, start)
    outer = tangents[:, :, None] * tangents[:, None, :]
    local = weights[:, None, None] * (across * np.eye(3) + (along - across) * outer)
    motion = np.concatenate([np.broadcast_to(np.eye(3), local.shape), -cross_matrices(points)], axis=2)
    matrix: NDArray[np.float64] = np.einsum("nij,nik,nkl->jl", motion, local, motion)
    return matrix


def cross_matrices(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrices (n, 3, 3) that take w to ``vectors x w``."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
