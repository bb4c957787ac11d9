"""Integrals over flat triangles: Gauss points, and the Stokeslet's in closed form."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rule = tuple[Floats, Floats]  # barycentric places (n, 3) and weights (n,) that sum to 1

# D. A. Dunavant, Int. J. Numer. Meth. Eng. 21 (1985) 1129: barycentric places and weights, exact for degree 2 and 4
_FIRST, _SECOND = (0.108103018168070, 0.445948490915965), (0.816847572980459, 0.091576213509771)


def _orbit(corner: float, other: float) -> Floats:
    return np.array([[corner, other, other], [other, corner, other], [other, other, corner]])


def _quartered(rule: Rule) -> Rule:
    """A rule on each of the four triangles that a triangle's middles of edges make."""
    places, weights = rule
    half = np.eye(3) / 2.0
    corners = [np.array([half[k] + half[j] for j in range(3)]) for k in range(3)]
    middles = np.array([half[0] + half[1], half[1] + half[2], half[2] + half[0]])
    return np.concatenate([places @ quarter for quarter in (*corners, middles)]), np.tile(weights / 4.0, 4)


THREE = _orbit(2.0 / 3.0, 1.0 / 6.0), np.full(3, 1.0 / 3.0)
SIX = (
    np.concatenate([_orbit(*_FIRST), _orbit(*_SECOND)]),
    np.concatenate([np.full(3, 0.223381589678011), np.full(3, 0.109951743655322)]),
)
TWELVE, TWENTY_FOUR = _quartered(THREE), _quartered(SIX)


def stokeslet_mean(points: Floats, corners: Floats) -> Floats:
    """Mean over a triangle of ``1/R + r r'/R^3``, with r from the triangle's places to a point.

    With t, m, s an edge's distance, outward normal and direction in the triangle's plane, w the height above it, and L
    and D the integrals of 1/R and l/R along an edge, the divergence theorem gives for the components in the plane
    ``I0 P - sum (t L m m' + D m s')``, for the mixed ones ``-w sum L (n m' + m n')``, for the normal one ``|w| solid
    angle``, where ``I0 = sum t L - |w| solid angle`` is the potential of the triangle (D. R. Wilton et al., IEEE Trans.
    Antennas Propag. 32 (1984) 276; the solid angle by A. van Oosterom and J. Strackee, 1983).

    Parameters
    ----------
    points
        Where (n, 3), m.
    corners
        A triangle for each point (n, 3, 3), m.

    Returns
    -------
    (n, 3, 3)
        Symmetric, 1/m.
    """
    edges = np.roll(corners, -1, axis=1) - corners
    cross = np.cross(edges[:, 0], edges[:, 1])
    doubled = np.linalg.norm(cross, axis=1)
    normal = cross / doubled[:, None]
    lengths = np.linalg.norm(edges, axis=2)
    along = edges / lengths[:, :, None]
    outward = np.cross(along, normal[:, None])
    r = corners - points[:, None]
    height = np.einsum("ni,ni->n", r[:, 0], normal)
    reach = np.einsum("nki,nki->nk", r, outward)
    distance = np.linalg.norm(r, axis=2)
    log, difference = _edge_integrals(np.einsum("nki,nki->nk", r, along), lengths, distance)
    rise = np.abs(height) * _solid_angle(r, distance)
    potential = (reach * log).sum(axis=1) - rise
    total = 2.0 * potential[:, None, None] * np.eye(3)
    total += (rise - potential)[:, None, None] * normal[:, :, None] * normal[:, None, :]
    lean = -height[:, None, None] * normal[:, :, None] * np.einsum("nk,nki->ni", log, outward)[:, None, :]
    total += lean + lean.transpose(0, 2, 1)
    edge_sum = np.einsum("nki,nkj->nij", outward, (reach * log)[:, :, None] * outward + difference[:, :, None] * along)
    total -= (edge_sum + edge_sum.transpose(0, 2, 1)) / 2.0
    mean: Floats = total / (doubled / 2.0)[:, None, None]
    return mean


def _edge_integrals(start: Floats, lengths: Floats, distance: Floats) -> tuple[Floats, Floats]:
    """Integrals of 1/R and of l/R along each edge (n, 3), which begins at l = ``start``."""
    end, far = start + lengths, np.roll(distance, -1, axis=1)
    behind = start + end < 0.0  # of two equal forms the one that does not cancel
    top = np.where(behind, distance - start, far + end)
    bottom = np.where(behind, far - end, distance + start)
    # on an edge 1/R has no integral, but all that it is multiplied with is nought there: any finite number will do
    return np.log(top / np.maximum(bottom, np.finfo(float).tiny)), far - distance


def _solid_angle(r: Floats, distance: Floats) -> Floats:
    """Of triangles with corners at ``r`` (n, 3, 3) from the eye, without sign."""
    triple = np.abs(np.einsum("ni,ni->n", r[:, 0], np.cross(r[:, 1], r[:, 2])))
    pairs = np.einsum("nki,nki->nk", r, np.roll(r, -1, axis=1))
    below = distance.prod(axis=1) + (pairs * np.roll(distance, -2, axis=1)).sum(axis=1)
    angle: Floats = 2.0 * np.arctan2(triple, below)
    return angle
