"""Where the device is in one view: middle and half length of its long axis, to a fraction of a pixel."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from helimag.vision._cv import cv2

Floats = NDArray[np.float64]
Shades = NDArray[np.float32]

ALONG = 0.15  # standard deviation of an end along the axis (px): the wire's end turns with the helix
ACROSS = 0.06  # of the axis sideways (px)
SLENDER = 2.5  # length over width from which the two ends are told apart
SKIRT = 7  # by how much a blob's outline is widened, so that its blurred edge counts (px, odd)


@dataclass(frozen=True)
class Detection:
    """The device in one view. Pixels.

    Parameters
    ----------
    middle, half
        (2,): between the two ends, and from there to one of them; which of the two is not known.
    middle_sd, half_sd
        Standard deviations (2,), along the axis and across.
    darkness
        Missing light, summed over the blob (px^2).
    lopsided
        How much darker the end at ``middle + half`` is than the other, in -1 ... 1.
    """

    middle: Floats
    half: Floats
    middle_sd: tuple[float, float]
    half_sd: tuple[float, float]
    darkness: float
    lopsided: float

    @property
    def row(self) -> Floats:
        """As numbers, for a table."""
        return np.array([*self.middle, *self.half, *self.middle_sd, *self.half_sd, self.darkness, self.lopsided])

    def shifted(self, right: float, down: float) -> "Detection":
        """The same, seen from another corner of the picture."""
        return replace(self, middle=self.middle + np.array([right, down]))

    def along(self, other: "Detection") -> "Detection":
        """The same, with the half length pointing as another's does."""
        if float(self.half @ other.half) >= 0.0:
            return self
        return replace(self, half=-self.half, lopsided=-self.lopsided)


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
    dark: Shades, rows: slice, columns: slice, mask: NDArray[np.bool_], *, head_length: float
) -> Detection | None:
    """Measure a blob; None where it has no extent.

    A slender blob's axis is a weighted line through its columns' centres. The weights fade out towards the ends
    (Hann), so
    that the coils, whose number is not whole, do not lean it: unweighted, a helix of 4.5 turns leans by up to
    12 R / (k L^2), half a degree. Its ends are where the darkness along the axis crosses half its typical level.

    Parameters
    ----------
    head_length
        Length (px) over which the darkness of the two ends is compared.
    """
    down, right = np.nonzero(mask)
    weight = np.asarray(dark[rows, columns][down, right], dtype=np.float64)
    total = float(weight.sum())
    if total < 4.0:
        return None
    u, v = right + float(columns.start), down + float(rows.start)
    middle = np.array([weight @ u, weight @ v]) / total
    du, dv = u - middle[0], v - middle[1]
    cross = float(weight @ (du * dv))
    spread = np.array([[weight @ (du * du), cross], [cross, weight @ (dv * dv)]]) / total
    (small, large), axes = np.linalg.eigh(spread)
    if not large > 0.0:
        return None
    along = axes[:, 1]
    half, width = np.sqrt(3.0 * large), np.sqrt(3.0 * max(small, 0.08))
    if half < SLENDER * width:
        sd = 0.02 * width
        return Detection(middle, half * along, (3 * sd + 0.1, sd + 0.05), (0.5 * width, 0.5 * width), total, 0.0)
    for _ in range(2):
        s = du * along[0] + dv * along[1]
        n = dv * along[0] - du * along[1]
        fade = np.where(np.abs(s) < half, weight * (1.0 + np.cos(np.pi * s / half)), 0.0)
        mean_s, mean_n = fade @ s / fade.sum(), fade @ n / fade.sum()
        slope = float(fade @ ((s - mean_s) * (n - mean_n)) / (fade @ (s - mean_s) ** 2))
        sideways = mean_n - slope * mean_s
        across = np.array([-along[1], along[0]])
        middle = middle + sideways * across
        along = (along + slope * across) / np.hypot(1.0, slope)
        du, dv = u - middle[0], v - middle[1]
    s = du * along[0] + dv * along[1]
    ends = _ends(s, weight)
    if ends is None:
        return None
    low, high = ends
    first = weight[(s > low - 2.0) & (s < low + head_length)].sum()
    last = weight[(s < high + 2.0) & (s > high - head_length)].sum()
    centre = middle + along * (low + high) / 2.0
    sd = (ALONG / np.sqrt(2.0), ACROSS)
    sd_half = (ALONG / np.sqrt(2.0), 2.0 * ACROSS)
    return Detection(centre, along * (high - low) / 2.0, sd, sd_half, total, float((last - first) / (last + first)))


def _ends(s: Floats, weight: Floats) -> tuple[float, float] | None:
    """Where the darkness along the axis rises through half its typical level, and where it falls again (px)."""
    low = np.floor(s.min()) - 1.0
    place = s - low
    cell = place.astype(int)
    share = place - cell
    size = int(cell.max()) + 3
    raw = np.bincount(cell, weight * (1.0 - share), size) + np.bincount(cell + 1, weight * share, size)
    profile = np.convolve(raw, [0.25, 0.5, 0.25], mode="same")
    level = 0.5 * float(np.median(profile[profile > 0.25 * profile.max()]))
    above = np.flatnonzero(profile > level)
    first, last = int(above[0]), int(above[-1])
    if first == 0 or last + 1 >= profile.size:
        return None
    rise = first - (profile[first] - level) / (profile[first] - profile[first - 1])
    fall = last + (profile[last] - level) / (profile[last] - profile[last + 1])
    return low + float(rise), low + float(fall)
