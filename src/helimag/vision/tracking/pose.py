"""Position and long axis of the device from both views at once, with covariance."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.vision.cameras import Rig
from helimag.vision.tracking.detection import HALF, SDS, along_and_across

Floats = NDArray[np.float64]

ITERATIONS = 6
FREEDOM = 3  # eight measured numbers less five unknown
SHIFT, TURN = 1e-6, 1e-5  # of the differences (m, rad)


class Fit(NamedTuple):
    """Middle (n, 3) in m, axis (n, 3) of open sense with two tangents (n, 2, 3), and the fit's quality.

    ``gain`` (n, 5, 8) is by how much middle and two turns move with each measured number (m/px and rad/px), ``misfit``
    (n,) chi-square a degree of freedom, ``apart`` (n,) the root mean square of what the fit leaves of the numbers (px),
    ``rest`` (n, 8) that over their standard deviations.
    """

    middle: Floats
    axis: Floats
    tangents: Floats
    gain: Floats
    misfit: Floats
    apart: Floats
    rest: Floats


class DevicePoses(NamedTuple):
    """Head (n, 3) in m, long axis (n, 3) from helix to head, how both move with the measured numbers (n, 3, 8), and
    misfit a degree of freedom."""

    head: Floats
    axis: Floats
    head_gain: Floats
    axis_gain: Floats
    misfit: Floats


def first_guess(rig: Rig, first: Floats, second: Floats) -> tuple[Floats, Floats]:
    """Middles (n, 3) by triangulation, and axes from the ends, paired across the views so that their lines of sight
    meet."""
    middle, _ = rig.triangulate(first[:, :2], second[:, :2])
    best, least = np.zeros_like(middle), np.full(middle.shape[0], np.inf)
    for sign in (1.0, -1.0):
        front, miss_front = rig.triangulate(first[:, :2] + first[:, 2:4], second[:, :2] + sign * second[:, 2:4])
        rear, miss_rear = rig.triangulate(first[:, :2] - first[:, 2:4], second[:, :2] - sign * second[:, 2:4])
        axis = (front - rear) / np.linalg.norm(front - rear, axis=1, keepdims=True)
        better = miss_front + miss_rear < least
        best[better], least[better] = axis[better], (miss_front + miss_rear)[better]
    return middle, best


def disagreement(rig: Rig, first: Floats, second: Floats) -> Floats:
    """By how much the ends' lines of sight miss each other (n,) in m, once the middles are made to meet.

    It tells whether two views show the same body even while their clocks are not aligned.
    """
    middle, _ = rig.triangulate(first[:, :2], second[:, :2])
    one, two = first.copy(), second.copy()
    one[:, :2], two[:, :2] = (camera.project(middle) for camera in rig.cameras)
    least = np.full(middle.shape[0], np.inf)
    for sign in (1.0, -1.0):
        misses = [
            rig.triangulate(one[:, :2] + end * one[:, 2:4], two[:, :2] + sign * end * two[:, 2:4])[1]
            for end in (1.0, -1.0)
        ]
        least = np.fmin(least, np.maximum(*misses))
    return least


def lengths(rig: Rig, first: Floats, second: Floats) -> Floats:
    """Distance between the ends as seen (n,) in m, each from the view that shows the device less foreshortened."""
    middle, axis = first_guess(rig, first, second)
    sizes = [np.linalg.norm(rows[:, 2:4], axis=1) for rows in (first, second)]
    scales = [
        np.linalg.norm(camera.project(middle + 1e-3 * axis) - camera.project(middle - 1e-3 * axis), axis=1) / 2e-3
        for camera in rig.cameras
    ]
    return np.asarray(2.0 * np.where(scales[0] >= scales[1], sizes[0] / scales[0], sizes[1] / scales[1]))


def residuals(rig: Rig, seen: tuple[Floats, Floats], middle: Floats, axis: Floats, length: float) -> Floats:
    """Measured less predicted over standard deviation (n, 8), of each view the four numbers of
    :func:`~helimag.vision.tracking.detection.along_and_across`."""
    parts = []
    for camera, rows in zip(rig.cameras, seen, strict=True):
        ends = camera.project(np.stack([middle + length / 2.0 * axis, middle - length / 2.0 * axis], axis=1))
        centre, half = ends.mean(axis=1), (ends[:, 0] - ends[:, 1]) / 2.0
        sign = np.where(np.sum(rows[:, 2:4] * half, axis=1) >= 0.0, 1.0, -1.0)
        off = np.concatenate([rows[:, :2] - centre, rows[:, 2:4] - sign[:, None] * half], axis=1)
        parts.append(along_and_across(off, rows[:, HALF]) / rows[:, SDS])
    return np.concatenate(parts, axis=1)


def _tangents(axis: Floats) -> Floats:
    """Two unit vectors across each axis: (n, 2, 3)."""
    helper = np.where(np.abs(axis[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    one = np.cross(axis, helper)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    return np.stack([one, np.cross(axis, one)], axis=1)


def _moved(middle: Floats, axis: Floats, tangents: Floats, change: Floats) -> tuple[Floats, Floats]:
    turned = axis + np.einsum("nk,nki->ni", change[:, 3:], tangents)
    return middle + change[:, :3], turned / np.linalg.norm(turned, axis=1, keepdims=True)


def solve(rig: Rig, first: Floats, second: Floats, length: float) -> Fit:
    """Fit middle and axis of a body of known length to both views of n instants, by Gauss-Newton.

    Parameters
    ----------
    first, second
        Rows (n, 13) of :class:`~helimag.vision.tracking.detection.Detection`, all finite.
    length
        Between the ends as seen (m).

    Returns
    -------
    Fit
        With axes whose sense, nose or tail first, is open.
    """
    seen = (first, second)
    middle, axis = first_guess(rig, first, second)
    count = middle.shape[0]
    jacobian = np.zeros((count, 8, 5))
    for _ in range(ITERATIONS):
        base = residuals(rig, seen, middle, axis, length)
        tangents = _tangents(axis)
        for column in range(5):
            step = np.zeros((count, 5))
            step[:, column] = SHIFT if column < 3 else TURN
            moved = _moved(middle, axis, tangents, step)
            jacobian[:, :, column] = (residuals(rig, seen, *moved, length) - base) / step[0, column]
        scale = np.array([1e-3, 1e-3, 1e-3, 1.0, 1.0])  # so that the matrix is well conditioned
        scaled = jacobian * scale
        normal = np.einsum("nki,nkj->nij", scaled, scaled) + 1e-9 * np.eye(5)
        right = np.einsum("nki,nk->ni", scaled, base)
        change = -np.linalg.solve(normal, right[..., None])[..., 0] * scale
        limit = np.minimum(1.0, 0.3 / np.maximum(np.abs(change[:, 3:]).max(axis=1), 1e-12))
        middle, axis = _moved(middle, axis, tangents, change * limit[:, None])
        if np.abs(change[:, :3]).max() < 1e-8:
            break
    base = residuals(rig, seen, middle, axis, length)
    spread = np.concatenate([first[:, SDS], second[:, SDS]], axis=1)
    gain = -(np.linalg.inv(normal) @ scaled.transpose(0, 2, 1)) * scale[:, None] / spread[:, None, :]
    apart = np.sqrt(np.mean((base * spread) ** 2, axis=1))
    return Fit(middle, axis, tangents, gain, np.sum(base * base, axis=1) / FREEDOM, apart, base)


def oriented(fit: Fit, darker: Floats, ahead: float) -> DevicePoses:
    """Choose the sense of the axes: continuous over the run, towards the end that is darker in most frames.

    Parameters
    ----------
    darker
        (n,): how much darker the end along ``fit.axis`` is than the other.
    ahead
        From the middle between the ends to the head's centre (m).
    """
    sense = np.ones(fit.axis.shape[0])
    for i in range(1, sense.size):
        sense[i] = sense[i - 1] * (1.0 if float(fit.axis[i] @ fit.axis[i - 1]) >= 0.0 else -1.0)
    if float(sense @ darker) < 0.0:
        sense = -sense
    axis = sense[:, None] * fit.axis
    turns = fit.tangents.transpose(0, 2, 1) * sense[:, None, None]
    none, one = np.zeros((sense.size, 3, 3)), np.broadcast_to(np.eye(3), (sense.size, 3, 3))
    to_head = np.concatenate([one, ahead * turns], axis=2)
    to_axis = np.concatenate([none, turns], axis=2)
    return DevicePoses(
        fit.middle + ahead * axis,
        axis,
        to_head @ fit.gain,
        to_axis @ fit.gain,
        fit.misfit,
    )


def darker_end(rig: Rig, fit: Fit, seen: tuple[Floats, Floats]) -> Floats:
    """How much darker the end along the fitted axis looks than the other, both views together: (n,)."""
    total = np.zeros(fit.axis.shape[0])
    for camera, rows in zip(rig.cameras, seen, strict=True):
        ahead = camera.project(fit.middle + 1e-3 * fit.axis) - camera.project(fit.middle)
        total += np.sign(np.sum(ahead * rows[:, 2:4], axis=1)) * rows[:, 9]
    return total
