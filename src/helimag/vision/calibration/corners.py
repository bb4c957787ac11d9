"""Corners of a chessboard to a hundredth of a pixel: two blurred edges that cross, fitted to the pixels around each."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

REACH = 5  # pixels each way of a corner that are fitted
WIDTH = 2.0  # of the weights (px, standard deviation): the nearest marker is some 4 px away
ROUNDS = 12  # of Gauss and Newton's method; it needs 4 to 6
LARGEST = np.array([1.0, 1.0, 0.3, 0.3, 0.5, np.inf, np.inf])  # step of a round: px, px, rad, rad, log blur, grey, grey
SETTLED = 1e-4  # px that a last step may move
FARTHEST = 2.5  # px from where it was found that a corner may lie
SHARPEST, WIDEST = 0.2, 4.0  # blur (px) of what is a corner
FAINTEST = 5.0  # grey levels by which white and black lie on either side of the middle


def refined(picture: Picture, corners: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Corners (n, 2) in px, each from a fit, and which of them (n,) a fit was found for.

    An edge blurred by a Gaussian is an error function of the distance to it, and a corner of a chessboard the product
    of two: level + contrast erf(d1 / (sqrt(2) blur)) erf(d2 / (sqrt(2) blur)). The point to which all gradients around
    are perpendicular, which OpenCV's ``cornerSubPix`` seeks, goes to and fro by 0.02 px with the place on the grid of
    pixels, and its ChArUco detector ends that search at steps of 0.1 px: errors of 0.05 px, and of 2 px at times where
    squares look small, which no normal law describes.

    Parameters
    ----------
    corners
        (n, 2) in px, to a pixel or two.
    """
    base = np.round(corners).astype(np.int64)
    size = np.array([picture.shape[1], picture.shape[0]])
    within = np.all((base >= REACH) & (base < size - REACH), axis=1)
    result, known = corners.copy(), np.zeros(corners.shape[0], bool)
    if within.any():
        result[within], known[within] = _fitted(picture, base[within], corners[within] - base[within])
    return result, known


def _fitted(picture: Picture, base: NDArray[np.int64], off: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Corners (n, 2) that lie ``off`` (n, 2) the pixels ``base`` (n, 2), and which of them (n,) hold."""
    across = np.arange(-REACH, REACH + 1)
    down, right = (grid.ravel() for grid in np.meshgrid(across, across, indexing="ij"))
    seen = picture[base[:, 1, None] + down, base[:, 0, None] + right].astype(np.float64)
    weight = np.exp(-0.5 * ((right - off[:, :1]) ** 2 + (down - off[:, 1:]) ** 2) / WIDTH**2)
    values = _start(seen, weight, right - off[:, :1], down - off[:, 1:])
    values[:, :2] = off
    for _ in range(ROUNDS):
        shade, slopes = _corner(values, right, down)
        weighted = (slopes * weight[..., None]).transpose(0, 2, 1)
        normal = weighted @ slopes
        pull = (weighted @ (seen - shade)[..., None])[..., 0]
        scale = 1.0 / np.sqrt(np.einsum("nii->ni", normal) + 1e-12)
        scaled = normal * scale[:, :, None] * scale[:, None, :] + 1e-9 * np.eye(7)
        step = np.linalg.solve(scaled, (pull * scale)[..., None])[..., 0] * scale
        values = values + np.clip(step, -LARGEST, LARGEST)
        values[:, 4] = np.clip(values[:, 4], np.log(SHARPEST), np.log(WIDEST))
        last = np.abs(step[:, :2]).max(axis=1)
        if not np.any(last >= SETTLED):
            break
    near = np.hypot(*(values[:, :2] - off).T) < FARTHEST
    return base + values[:, :2], near & (last < SETTLED) & (np.abs(values[:, 6]) > FAINTEST)


def _start(seen: Floats, weight: Floats, x: Floats, y: Floats) -> Floats:
    """Values (n, 7) near a corner's: the edges run where the saddle that fits its pixels is level."""
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    weighted = (terms * weight[..., None]).transpose(0, 2, 1)
    saddle = np.linalg.solve(weighted @ terms, weighted @ seen[..., None])[..., 0]
    both, twist, uneven = saddle[:, 3] + saddle[:, 5], saddle[:, 4], saddle[:, 3] - saddle[:, 5]
    middle = 0.5 * np.arctan2(twist, uneven)
    apart = 0.5 * np.arccos(np.clip(-both / np.maximum(np.hypot(uneven, twist), 1e-12), -0.95, 0.95))
    low, high = np.percentile(seen, (10.0, 90.0), axis=1)
    none = np.zeros_like(low)
    # along ``middle`` the saddle is bright, and the distances to the two edges have opposite signs there
    return np.stack([none, none, middle + apart, middle - apart, none, (low + high) / 2.0, (low - high) / 2.0], axis=1)


def _corner(values: Floats, right: NDArray[np.int64], down: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Brightness (n, pixels) of corners, and its slopes (n, pixels, 7) over place, directions of both edges, logarithm
    of the blur, level and contrast."""
    x, y = right - values[:, :1], down - values[:, 1:2]
    blur, level, contrast = np.exp(values[:, 4:5]), values[:, 5:6], values[:, 6:7]
    edges, steepness, distances, turns = [], [], [], []
    for column in (2, 3):
        sine, cosine = np.sin(values[:, column : column + 1]), np.cos(values[:, column : column + 1])
        distance = cosine * y - sine * x
        edges.append(erf(distance / (np.sqrt(2.0) * blur)))
        steepness.append(np.sqrt(2.0 / np.pi) / blur * np.exp(-0.5 * (distance / blur) ** 2))
        distances.append(distance)
        turns.append((sine, -cosine, -cosine * x - sine * y))
    one, two = contrast * steepness[0] * edges[1], contrast * steepness[1] * edges[0]
    slopes = np.stack(
        [
            one * turns[0][0] + two * turns[1][0],
            one * turns[0][1] + two * turns[1][1],
            one * turns[0][2],
            two * turns[1][2],
            -one * distances[0] - two * distances[1],
            np.ones_like(x),
            edges[0] * edges[1],
        ],
        axis=-1,
    )
    return level + contrast * edges[0] * edges[1], slopes
