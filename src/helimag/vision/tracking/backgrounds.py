"""What a view looks like without the device, and how much darker a frame is."""

import numpy as np
from numpy.typing import NDArray

from helimag.vision._cv import cv2

Picture = NDArray[np.uint8]
Shades = NDArray[np.float32]

USUAL = 3.5  # standard deviations of noise within which a sample shows the empty scene
PERCENTILE = 70  # of the sampled frames: the device darkens a pixel in fewer than the other 30 %, mostly


def background(pictures: list[Picture], *, device_length: float, device_area: float) -> Shades:
    """Brightness of the empty scene: (height, width).

    A high percentile over time removes a device that moves, and the mean of what lies near it is not brighter where the
    device passed less often, as a percentile of noise would be. One that hardly moves stays as a dark blob of the
    device's size; it is filled in from around it, while marks of other sizes (dust, edges of the tank) stay.

    Parameters
    ----------
    pictures
        Frames spread over the film.
    device_length, device_area
        As the view shows it (px, px^2).
    """
    scene = _typical(np.stack(pictures))
    side = int(device_length / 2.0) | 1
    closed = cv2.morphologyEx(scene, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)))
    darker = ((closed - scene) > 0.12 * closed).astype(np.uint8)
    marks = cv2.morphologyEx(darker, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(marks, connectivity=8)
    for label in range(1, count):
        extent = max(stats[label, cv2.CC_STAT_WIDTH], stats[label, cv2.CC_STAT_HEIGHT])
        if 0.25 * device_area < stats[label, cv2.CC_STAT_AREA] < 4.0 * device_area and extent < 1.6 * device_length:
            blob = cv2.dilate((labels == label).astype(np.uint8), np.ones((9, 9), np.uint8))
            scene = np.where(blob > 0, closed, scene)
    return np.maximum(np.asarray(scene, np.float32), 1.0)


def _typical(frames: Picture) -> Shades:
    """Mean over time of what is neither darkened nor brightened: (height, width)."""
    bright = _percentile(frames).astype(np.float32)
    sample = np.abs(frames[:, ::8, ::8].astype(np.float32) - bright[::8, ::8])
    noise = max(1.0, 1.5 * float(np.median(sample)))
    total, count = np.zeros_like(bright), np.zeros_like(bright)
    for frame in frames:
        near = np.abs(frame - bright) < USUAL * noise
        total += np.where(near, frame, 0.0)
        count += near
    return np.asarray(np.where(count > 0.0, total / np.maximum(count, 1.0), bright), np.float32)


def _percentile(frames: Picture) -> Picture:
    """The grey level that PERCENTILE of the frames reach at most, bit by bit: eight times faster than sorting them."""
    rank = int(PERCENTILE / 100.0 * (len(frames) - 1))
    level = np.zeros(frames.shape[1:], np.uint8)
    for bit in (128, 64, 32, 16, 8, 4, 2, 1):
        tried = level + np.uint8(bit)
        below = np.zeros(level.shape, np.uint16)
        for frame in frames:
            below += frame < tried
        level = np.where(below <= rank, tried, level)
    return level


def darkness(picture: Picture, scene: Shades) -> Shades:
    """Share of the light that is missing, with the light's level taken from the picture itself: same shape."""
    ratio = picture.astype(np.float32) / scene
    return np.asarray(1.0 - ratio / max(float(np.median(ratio)), 1e-3), np.float32)
