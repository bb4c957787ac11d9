"""What a calibration leaves open: rigs that fit the pictures nearly as well, and where they put a point."""

import numpy as np
from numpy.typing import NDArray

from helimag.vision.calibration.joint import BOARDS, Fitted, Joint
from helimag.vision.calibration.placements import Pose
from helimag.vision.cameras import Rig

Floats = NDArray[np.float64]

KEPT = 0.999  # share of the variance in the tank that the variants that are kept explain


def variants(problem: Joint, fitted: Fitted, rig: Rig, lab: Pose) -> tuple[tuple[Rig, ...], float]:
    """Rigs one standard deviation off, each along an independent direction, and the standard deviation of a point (m).

    The directions are the principal ones of the shifts that the fit's covariance makes over the tank, so a few stand
    for all. A point's covariance is the sum of the outer products of its shifts under each.
    """
    places = np.r_[np.arange(BOARDS), np.arange(problem.datum().start, problem.datum().stop)]
    part = fitted.covariance[np.ix_(places, places)]
    size = np.sqrt(np.maximum(np.diag(part), 1e-30))
    values, vectors = np.linalg.eigh(part / np.outer(size, size))
    roots = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))

    def moved(change: Floats) -> Rig:
        full = fitted.values.copy()
        full[places] += change
        return problem.rig(full, lab)

    points = grid(rig)
    pixels = tuple(camera.project(points) for camera in rig.cameras)
    shifts = np.stack([(moved(root).triangulate(*pixels)[0] - points).ravel() for root in roots.T], axis=1)
    good = np.all(np.isfinite(shifts), axis=1)
    _, strengths, right = np.linalg.svd(shifts[good], full_matrices=False)
    share = np.cumsum(strengths**2) / np.sum(strengths**2)
    count = int(np.searchsorted(share, KEPT)) + 1
    sd = float(np.sqrt(np.sum(strengths**2) / good.sum()))
    return tuple(moved(roots @ direction) for direction in right[:count]), sd


def grid(rig: Rig, count: int = 5) -> Floats:
    """Points (n, 3) spread over the part of the tank that both cameras see (m)."""
    low, high = rig.tank
    inset = 0.1 * (high - low)
    axes = [np.linspace(a, b, count) for a, b in zip(low + inset, high - inset, strict=True)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    seen = [camera.project(points) for camera in rig.cameras]
    inside = [np.all(np.isfinite(p) & (p >= 0) & (p < c.size), axis=1) for p, c in zip(seen, rig.cameras, strict=True)]
    return np.asarray(points[np.all(inside, axis=0)])
