"""Find the device in two streams of frames: a small window once it is known, the whole picture when it is lost."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.vision._cv import cv2
from helimag.vision.cameras import Camera, Rig
from helimag.vision.films import Film, Picture, ahead, together
from helimag.vision.shape import Shape
from helimag.vision.tracking.backgrounds import Shades, background, darkness
from helimag.vision.tracking.detection import ROW, Detection, blobs, measure, touches_edge
from helimag.vision.tracking.pose import disagreement, lengths

Floats = NDArray[np.float64]

SAMPLES = 32  # frames for the background
FIRST_CONTRAST = 0.25  # darkness from which a blob counts while the device's own is not known
HALF_CONTRAST = 0.45  # of the device's darkness: fainter blobs, such as reflections, are not it
STEADY = 0.3  # change of summed darkness from which a blob is not the device alone
FARTHEST = 50e-3  # by which lines of sight may miss each other while the clocks are not aligned (m)
BEYOND = 1.5e-3  # that a triangulated device may be outside the oil (m)
SAME_LENGTH = 0.15  # by which the length of a found device may differ from what is expected
TURNED = 0.25  # of its length: change of the half length between frames from which a blob is something else
LOOK_BACK = 300  # frames without a partner in the other view that are gone through again once there is one
LOST_AFTER = 4  # missed frames after which the whole picture is searched


class Sighting(NamedTuple):
    """One view over time: times (n,), rows of :class:`Detection` (n, 13), NaN where the device was not seen; and
    whether the film's frames are predicted from one another with loss."""

    time: Floats
    rows: Floats
    predicted: bool = False


@dataclass
class _View:
    """What is known of the device in one view."""

    camera: Camera
    scene: Shades
    length: float  # of the device seen broadside (px)
    area: float  # that it darkens (px^2)
    head: float  # length of its head (px)
    turns: float  # of the helix over its length
    times: list[float] = field(default_factory=list)
    rows: list[Floats] = field(default_factory=list)
    last: Detection | None = None
    last_time: float = 0.0
    speed: Floats = field(default_factory=lambda: np.zeros(2))
    level: float = 0.0  # typical summed darkness, 0 while not known
    contrast: float = 0.0
    missed: int = 10**6
    candidates: list[Detection] = field(default_factory=list)
    pending: deque[tuple[int, float, list[Detection]]] = field(default_factory=lambda: deque(maxlen=LOOK_BACK))

    @property
    def lost(self) -> bool:
        return self.missed > LOST_AFTER

    def look(self, picture: Picture, time: float) -> Detection | None:
        """The device near where it is expected."""
        if self.last is None:
            return None
        shape = picture.shape
        expected = self.last.middle + self.speed * (time - self.last_time)
        reach = np.abs(self.last.half) + 16.0 + 6.0 * self.missed
        left, top = np.clip((expected - reach).astype(int), 0, (shape[1] - 16, shape[0] - 16))
        right, bottom = np.clip((expected + reach).astype(int) + 1, 16, (shape[1], shape[0]))
        window = (slice(int(top), int(bottom)), slice(int(left), int(right)))
        dark = darkness(picture[window], self.scene[window])
        best: Detection | None = None
        for rows, columns, mask in blobs(dark, HALF_CONTRAST * self.contrast, 0.1 * self.area):
            if touches_edge(rows, columns, mask, dark.shape):
                continue
            seen = measure(dark, rows, columns, mask, head_length=self.head, turns=self.turns)
            if seen is None or abs(seen.darkness / self.level - 1.0) > STEADY or self._turned(seen):
                continue
            moved = seen.shifted(left, top)
            if best is None or np.linalg.norm(moved.middle - expected) < np.linalg.norm(best.middle - expected):
                best = moved
        return best

    def _turned(self, seen: Detection) -> bool:
        """Whether a blob points elsewhere, or is of another length, than the device did a moment ago."""
        if self.last is None:
            return False
        change = np.linalg.norm(seen.along(self.last).half - self.last.half)
        return bool(change > TURNED * self.length / 2.0 * (1.0 + 0.2 * self.missed))

    def scan(self, picture: Picture) -> list[Detection]:
        """Everything in the whole picture that may be the device."""
        rough = cv2.subtract(self.coarse, picture[::2, ::2])
        share = FIRST_CONTRAST if not self.contrast else HALF_CONTRAST * self.contrast
        mask = cv2.dilate((rough > share * self.coarse).astype(np.uint8), np.ones((3, 3), np.uint8))
        count, _, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
        found = []
        for left, top, width, height, area in 2 * stats[1:count]:
            if 2 * area < 0.15 * self.area or max(width, height) > 2.0 * self.length:
                continue
            window = (
                slice(max(0, top - 16), min(picture.shape[0], top + height + 16)),
                slice(max(0, left - 16), min(picture.shape[1], left + width + 16)),
            )
            dark = darkness(picture[window], self.scene[window])
            for rows, columns, blob in blobs(dark, share, 0.1 * self.area):
                if touches_edge(rows, columns, blob, dark.shape):
                    continue
                seen = measure(dark, rows, columns, blob, head_length=self.head, turns=self.turns)
                if seen is not None and self.plausible(seen):
                    found.append(seen.shifted(window[1].start, window[0].start))
        return found[:8]

    @cached_property
    def coarse(self) -> Picture:
        """The scene at half the size."""
        return np.clip(self.scene[::2, ::2], 0, 255).astype(np.uint8)

    def plausible(self, seen: Detection) -> bool:
        """Whether a blob is as dark as the device; before it is known, as the device should be."""
        if self.level:
            return abs(seen.darkness / self.level - 1.0) <= STEADY
        size = 2.0 * np.linalg.norm(seen.half) / self.length
        return bool(0.35 < seen.darkness / self.area < 1.6 and size < 1.4)

    def accept(self, seen: Detection, time: float, picture: Picture) -> Detection:
        """Take a detection as the device; it comes back with the sense of the one before."""
        if self.last is not None and self.missed <= LOST_AFTER and time > self.last_time:
            speed = (seen.middle - self.last.middle) / (time - self.last_time)
            self.speed = 0.6 * self.speed + 0.4 * speed
            seen = seen.along(self.last)
        else:
            self.speed = np.zeros(2)
        self.last, self.last_time, self.missed = seen, time, 0
        self.level = seen.darkness if not self.level else 0.97 * self.level + 0.03 * seen.darkness
        if not self.contrast:
            self.contrast = self._contrast(seen, picture)
        return seen

    def _contrast(self, seen: Detection, picture: Picture) -> float:
        """Darkness of the device where it is darkest."""
        low = np.maximum((seen.middle - np.abs(seen.half) - 8).astype(int), 0)
        high = (seen.middle + np.abs(seen.half) + 8).astype(int)
        window = (slice(low[1], high[1]), slice(low[0], high[0]))
        dark = darkness(picture[window], self.scene[window])
        return float(np.percentile(dark[dark > FIRST_CONTRAST], 75))


def search(
    films: tuple[Film, Film], rig: Rig, shape: Shape, *, progress: Callable[[float], None] | None = None
) -> tuple[Sighting, Sighting]:
    """Go through both films once and note where each view shows the device. Memory: a few frames, and 0.1 kB a frame
    of notes.

    Raises
    ------
    InputError
        Where a film's pictures are not the calibrated camera's, or the device is never found in both views.
    """
    views = []
    for film, camera in zip(films, rig.cameras, strict=True):
        if film.size != camera.size:
            raise InputError(
                f"{film.path} must have the pictures of the calibrated camera '{camera.name}', "
                f"{camera.size[0]} x {camera.size[1]}; got {film.size[0]} x {film.size[1]}"
            )
        views.append(_begin(film, rig, camera, shape))
    total = max(1, films[0].announced + films[1].announced)
    sources = (ahead(films[0].frames()), ahead(films[1].frames()))
    try:
        for number, (which, time, picture) in enumerate(together(*sources)):
            _step(views, which, time, picture, rig, shape)
            if progress is not None and number % 20 == 0:
                progress(min(1.0, number / total))
    finally:
        for source in sources:
            source.close()  # type: ignore[attr-defined]
    for view in views:
        if not any(np.isfinite(row[0]) for row in view.rows):
            raise InputError(
                f"the device was never found in view '{view.camera.name}' (together with the other); check "
                f"that both films "
                "show the same run, that the calibration is theirs, and that the device is darker than its background"
            )
    one, two = (
        Sighting(np.array(view.times), np.stack(view.rows), film.predicted)
        for view, film in zip(views, films, strict=True)
    )
    return one, two


def _begin(film: Film, rig: Rig, camera: Camera, shape: Shape) -> _View:
    scale = float(camera.scale(rig.tank.mean(axis=0)[None])[0])
    area = scale**2 * (shape.brightness_length * shape.helix_length + 2.0 * shape.head_radius * 2.0 * shape.head_reach)
    scene = background(film.sample(SAMPLES), device_length=shape.length * scale, device_area=area)
    return _View(camera, scene, shape.length * scale, area, 2.0 * shape.head_reach * scale, shape.turns)


def _step(views: list[_View], which: int, time: float, picture: Picture, rig: Rig, shape: Shape) -> None:
    view, other = views[which], views[1 - which]
    seen = None if view.lost else view.look(picture, time)
    if seen is None and view.lost:
        view.candidates = view.scan(picture)
        seen = _matched(view, other, which, rig, shape)
    view.times.append(time)
    if seen is None:
        view.missed += 1
        view.rows.append(np.full(ROW, np.nan))
        if view.lost:
            view.pending.append((len(view.rows) - 1, time, view.candidates))
        return
    view.rows.append(view.accept(seen, time, picture).row)
    _look_back(view)


def _look_back(view: _View) -> None:
    """Go back over frames in which the device was seen, but not yet known to be it, from where it was recognised."""
    view.candidates = []
    place, when = view.last, view.last_time
    while view.pending and place is not None:
        index, time, candidates = view.pending.pop()
        reach = 16.0 + 200.0 * (when - time)
        near = [
            candidate
            for candidate in candidates
            if view.plausible(candidate)
            and np.linalg.norm(candidate.middle - place.middle) < reach
            and np.linalg.norm(candidate.along(place).half - place.half) < TURNED * view.length / 2.0
        ]
        if not near:
            continue
        distances = [float(np.linalg.norm(candidate.middle - place.middle)) for candidate in near]
        place, when = near[int(np.argmin(distances))].along(place), time
        view.rows[index] = place.row
    view.pending.clear()


def _matched(view: _View, other: _View, which: int, rig: Rig, shape: Shape) -> Detection | None:
    """The candidate that fits the other view: lines of sight meet in the oil, and it is as dark as the device should
    be."""
    partners = [other.last] if not other.lost and other.last is not None else other.candidates
    best, least = None, np.inf
    for mine, theirs in product(view.candidates, partners):
        pixels = (mine.middle, theirs.middle) if which == 0 else (theirs.middle, mine.middle)
        point, miss = rig.triangulate(pixels[0][None], pixels[1][None])
        if not np.isfinite(miss[0]) or miss[0] > FARTHEST or not rig.inside(point, BEYOND)[0]:
            continue
        seen = (mine, theirs) if which == 0 else (theirs, mine)
        rows = (seen[0].row[None], seen[1].row[None])
        length = float(lengths(rig, *rows)[0])
        if not (
            abs(length / shape.length - 1.0) < SAME_LENGTH and disagreement(rig, *rows)[0] < SAME_LENGTH * shape.length
        ):
            continue
        usual = view.level or view.area
        cost = float(miss[0]) / FARTHEST + abs(float(np.log(mine.darkness / usual)))
        if cost < least:
            best, least = mine, cost
    return best
