"""Where the device is in one view: middle and half length of its long axis, to a fraction of a pixel."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from helimag.vision._cv import cv2

Floats = NDArray[np.float64]
Shades = NDArray[np.float32]

ALONG = 0.15  # standard deviation of an end along the axis (px): the wire's end turns with the helix
ACROSS = 0.06  # of the axis sideways (px)
STEEPEST = 0.5  # slope of a line to the blob's own axis from which it is not slender at all
SLENDER = 2.5  # length over width from which the two ends are told apart
SKIRT = 7  # by how much a blob's outline is widened, so that its blurred edge counts (px, odd)


# places in a row
MIDDLE, HALF, SDS, LOPSIDED, COIL, RISE = slice(0, 2), slice(2, 4), slice(4, 8), 9, slice(10, 12), 12
ROW = 13


def along_and_across(off: Floats, half: Floats) -> Floats:
    """Small changes (n, 4) of middle and half length as changes of the numbers that are fitted: of the end at
    ``middle + half`` along the half lengths ``half`` (n, 2), the middle across, the other end along, the half length
    across."""
    along = half / np.linalg.norm(half, axis=1, keepdims=True)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    middle, lean = off[:, MIDDLE], off[:, HALF]
    parts = ((middle + lean, along), (middle, across), (middle - lean, along), (lean, across))
    return np.stack([np.sum(part * way, axis=1) for part, way in parts], axis=1)


@dataclass(frozen=True)
class Detection:
    """The device in one view. Pixels.

    Parameters
    ----------
    middle, half
        (2,): between the two ends, and from there to one of them; which of the two is not known.
    sds
        Standard deviations (4,): of the end at ``middle + half`` along the axis, of the middle across, of the other end
        along, of the half length across.
    darkness
        Missing light, summed over the blob (px^2).
    lopsided
        How much darker the end at ``middle + half`` is than the other, in -1 ... 1.
    coil
        Amplitude (px) and phase with which the centreline winds about the axis, counted from the middle towards
        ``middle + half``; NaN where the device is not slender.
    rise
        Length (px) over which the darkness along the axis rises at the ends; NaN where it is not slender.
    """

    middle: Floats
    half: Floats
    sds: tuple[float, float, float, float]
    darkness: float
    lopsided: float
    coil: complex = complex(np.nan, np.nan)
    rise: float = np.nan

    @property
    def row(self) -> Floats:
        """As numbers, for a table; see the places below."""
        known = (self.darkness, self.lopsided, self.coil.real, self.coil.imag, self.rise)
        return np.array([*self.middle, *self.half, *self.sds, *known])

    def shifted(self, right: float, down: float) -> "Detection":
        """The same, seen from another corner of the picture."""
        return replace(self, middle=self.middle + np.array([right, down]))

    def along(self, other: "Detection") -> "Detection":
        """The same, with the half length pointing as another's does."""
        if float(self.half @ other.half) >= 0.0:
            return self
        return replace(self, half=-self.half, lopsided=-self.lopsided, coil=-self.coil.conjugate())


def blobs(dark: Shades, threshold: float, least_area: float) -> list[tuple[slice, slice, NDArray[np.bool_]]]:
    """Connected dark regions, widened by a skirt: rows, columns, and mask in that box, the largest first."""
    mask = cv2.morphologyEx((dark > threshold).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    order = np.argsort(-stats[1:count, cv2.CC_STAT_AREA]) + 1
    found = []
    for label in order[:6]:
        left, top, width, height, area = stats[label]
        if area < least_area:
            break
        rows = slice(max(0, top - SKIRT), top + height + SKIRT)
        columns = slice(max(0, left - SKIRT), left + width + SKIRT)
        core = (labels[rows, columns] == label).astype(np.uint8)
        wide = cv2.dilate(core, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (SKIRT, SKIRT))) > 0
        others = (labels[rows, columns] != label) & (labels[rows, columns] > 0)
        found.append((rows, columns, wide & ~others))
    return found


def touches_edge(rows: slice, columns: slice, mask: NDArray[np.bool_], shape: tuple[int, ...]) -> bool:
    """Whether a blob may go on beyond the picture."""
    beyond = (rows.start == 0 and mask[0].any()) or (columns.start == 0 and mask[:, 0].any())
    return bool(
        beyond or (rows.stop >= shape[0] and mask[-1].any()) or (columns.stop >= shape[1] and mask[:, -1].any())
    )


def measure(
    dark: Shades, rows: slice, columns: slice, mask: NDArray[np.bool_], *, head_length: float, turns: float
) -> Detection | None:
    """Measure a blob; None where it has no extent, or too little is darker than around it to tell.

    A slender blob's axis is a weighted line through its columns' centres. The weights fade out towards the ends
    (Hann), so
    that the coils, whose number is not whole, do not lean it: unweighted, a helix of 4.5 turns leans by up to
    12 R / (k L^2), half a degree. Its ends are where the darkness along the axis crosses half its typical level.

    Parameters
    ----------
    head_length
        Length (px) over which the darkness of the two ends is compared.
    turns
        Of the helix over the device's length.
    """
    down, right = np.nonzero(mask)
    weight = np.asarray(dark[rows, columns][down, right], dtype=np.float64)
    total = float(weight.sum())
    if not total >= 4.0:
        return None
    u, v = right + float(columns.start), down + float(rows.start)
    middle = np.array([weight @ u, weight @ v]) / total
    du, dv = u - middle[0], v - middle[1]
    cross = float(weight @ (du * dv))
    spread = np.array([[weight @ (du * du), cross], [cross, weight @ (dv * dv)]]) / total
    (small, large), axes = np.linalg.eigh(spread)
    if not large > 0.0:  # noise counts with its sign, so sums of squares may be negative
        return None
    along = axes[:, 1]
    half, width = np.sqrt(3.0 * large), np.sqrt(3.0 * max(small, 0.08))
    if half < SLENDER * width:
        along_sd, across_sd = 0.56 * width + 0.1, 0.02 * width + 0.05
        return Detection(middle, half * along, (along_sd, across_sd, along_sd, 0.5 * width), total, 0.0)
    leaning = _line(np.stack([u, v], axis=1), weight, middle, along, half)
    if leaning is None:
        return None
    middle, along = leaning
    du, dv = u - middle[0], v - middle[1]
    s, n = du * along[0] + dv * along[1], dv * along[0] - du * along[1]
    ends = _ends(s, weight)
    if ends is None:
        return None
    low, high, rise = ends
    first = weight[(s > low - 2.0) & (s < low + head_length)].sum()
    last = weight[(s < high + 2.0) & (s > high - head_length)].sum()
    centre, reach = middle + along * (low + high) / 2.0, (high - low) / 2.0
    place = s - (low + high) / 2.0
    fade = np.where(np.abs(place) < reach, weight * (1.0 + np.cos(np.pi * place / reach)), 0.0)
    coil = 2.0 * np.sum(fade * n * np.exp(-1j * np.pi * turns / reach * place)) / fade.sum()
    sds = (ALONG, ACROSS, ALONG, 2.0 * ACROSS)
    lopsided = float((last - first) / (last + first)) if last + first > 0.0 else 0.0
    return Detection(centre, along * reach, sds, total, lopsided, complex(coil), rise)


def _line(pixels: Floats, weight: Floats, middle: Floats, along: Floats, half: float) -> tuple[Floats, Floats] | None:
    """Point and direction of the line through a slender blob, with weights that fade out towards the ends."""
    for _ in range(2):
        off = pixels - middle
        s, n = off @ along, off @ np.array([-along[1], along[0]])
        fade = np.where(np.abs(s) < half, weight * (1.0 + np.cos(np.pi * s / half)), 0.0)
        total = float(fade.sum())
        if not total > 0.0:
            return None
        mean_s, mean_n = fade @ s / total, fade @ n / total
        wide = float(fade @ (s - mean_s) ** 2)
        if not wide > 0.0:
            return None
        slope = float(fade @ ((s - mean_s) * (n - mean_n))) / wide
        if not abs(slope) < STEEPEST:
            return None
        across = np.array([-along[1], along[0]])
        middle = middle + (mean_n - slope * mean_s) * across
        along = (along + slope * across) / np.hypot(1.0, slope)
    return middle, along


def _ends(s: Floats, weight: Floats) -> tuple[float, float, float] | None:
    """Where the darkness along the axis rises through half its typical level, where it falls again, and how fast (px).

    None where it does not, as in noise.
    """
    low = np.floor(s.min()) - 1.0
    place = s - low
    cell = place.astype(int)
    share = place - cell
    size = int(cell.max()) + 3
    raw = np.bincount(cell, weight * (1.0 - share), size) + np.bincount(cell + 1, weight * share, size)
    profile = np.convolve(raw, [0.25, 0.5, 0.25], mode="same")
    if not profile.max() > 0.0:
        return None
    level = 0.5 * float(np.median(profile[profile > 0.25 * profile.max()]))
    above = np.flatnonzero(profile > level)
    first, last = int(above[0]), int(above[-1])
    if first == 0 or last + 1 >= profile.size:
        return None
    up, down = profile[first] - profile[first - 1], profile[last] - profile[last + 1]
    begin = low + first - float((profile[first] - level) / up)
    end = low + last + float((profile[last] - level) / down)
    return (begin, end, float(level / up + level / down)) if end > begin else None
