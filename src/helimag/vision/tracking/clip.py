"""A clip to check a track by eye: both views with the track drawn on, and the path in space."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag.runs.trajectory import Trajectory
from helimag.vision._cv import cv2
from helimag.vision.cameras import Camera, Rig
from helimag.vision.films import Film, FilmWriter, ahead
from helimag.vision.shape import Shape

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

WIDTH, HEIGHT = 640, 512  # of a view in the clip
PATH_HEIGHT = 400
TRACK, NOW, GAP, INK = (0, 114, 178), (213, 94, 0), (204, 121, 167), (60, 60, 60)


def review(
    run: Trajectory,
    first: str | Path,
    second: str | Path,
    rig: Rig,
    path: str | Path,
    *,
    shape: Shape | None = None,
    rate: float | None = None,
    every: int = 1,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write the clip (.mp4 or .avi) of a measured run.

    Parameters
    ----------
    run
        What :func:`helimag.vision.track` made of the two films.
    every
        Show one frame in so many.
    """
    shape = shape or Shape()
    films = (Film(first, rate=rate), Film(second, rate=rate))
    time = np.asarray(run.dataset["time"].values)
    head = np.asarray(run.dataset["position"].values)
    tail = head + (shape.tail) * np.asarray(run.dataset["long_axis"].values)
    segment = np.asarray(run.dataset["segment"].values)
    seen = [(camera.project(head), camera.project(tail)) for camera in rig.cameras]
    offset = float(run.dataset.attrs.get("clock_offset", 0.0))
    step = float(run.dataset.attrs.get("frame_interval", 1.0 / 30.0))
    stage = _Stage(rig, head)
    followers = ahead(films[1].frames())
    current = next(followers)
    coming = next(followers, None)
    leaders = ahead(films[0].frames())
    try:
        with FilmWriter(path, (2 * WIDTH, HEIGHT + PATH_HEIGHT), colour=True, rate=round(1.0 / step)) as clip:
            for number, (now, picture) in enumerate(leaders):
                while coming is not None and abs(coming[0] - now - offset) <= abs(current[0] - now - offset):
                    current, coming = coming, next(followers, None)
                if number % every:
                    continue
                place = int(np.searchsorted(time, now + step / 4.0)) - 1
                tracked = place >= 0 and abs(time[place] - now) < step / 4.0
                views = []
                for view, shot in enumerate((picture, current[1])):
                    views.append(_view(shot, rig.cameras[view], *seen[view], segment, place, tracked))
                space = stage.draw(head, segment, place, tracked, now)
                clip.write(np.vstack([np.hstack(views), space]), (number // every) * step)
                if progress is not None and number % 10 == 0:
                    progress(min(1.0, number / max(1, films[0].announced)))
    finally:
        leaders.close()  # type: ignore[attr-defined]
        followers.close()  # type: ignore[attr-defined]


def _view(
    shot: Picture, camera: Camera, head: Floats, tail: Floats, segment: Floats, place: int, tracked: bool
) -> Picture:
    reduced = cv2.resize(cv2.cvtColor(shot, cv2.COLOR_GRAY2RGB), (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    small = np.asarray(reduced, np.uint8)
    zoom = np.array([WIDTH / camera.size[0], HEIGHT / camera.size[1]])
    _polylines(small, head[: place + 1] * zoom, segment[: place + 1], TRACK)
    if tracked:
        nose, rear = (tuple(int(v) for v in np.round(16 * zoom * end[place])) for end in (head, tail))
        cv2.line(small, nose, rear, NOW, 1, cv2.LINE_AA, 4)
        cv2.circle(small, nose, 4 * 16, NOW, 1, cv2.LINE_AA, 4)
    _label(small, camera.name, (10, 22), INK)
    if not tracked:
        _label(small, "gap", (10, 44), GAP)
    return small


def _polylines(picture: Picture, points: Floats, segment: Floats, colour: tuple[int, int, int]) -> None:
    """The path, broken where samples are missing."""
    if not len(points):
        return
    for part in np.split(points, np.flatnonzero(np.diff(segment)) + 1):
        cv2.polylines(picture, [np.round(16 * part).astype(np.int32)], False, colour, 1, cv2.LINE_AA, 4)


def _label(picture: Picture, text: str, place: tuple[int, int], colour: tuple[int, int, int]) -> None:
    cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, colour, 1, cv2.LINE_AA)


class _Stage:
    """The tank in a parallel projection from the front, above and to the right."""

    def __init__(self, rig: Rig, head: Floats) -> None:
        turn, lift = np.radians(-25.0), np.radians(20.0)
        across = np.array([np.cos(turn), -np.sin(turn), 0.0])
        up = np.array([np.sin(lift) * np.sin(-turn), np.sin(lift) * np.cos(turn), np.cos(lift)])
        self.axes = np.stack([across, -up], axis=1)
        low, high = rig.tank
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        flat = corners @ self.axes
        size = np.ptp(flat, axis=0)
        self.zoom = min((2 * WIDTH - 120) / size[0], (PATH_HEIGHT - 60) / size[1])
        self.shift = np.array([WIDTH, PATH_HEIGHT / 2]) - self.zoom * (flat.min(axis=0) + size / 2.0)
        self.empty = np.full((PATH_HEIGHT, 2 * WIDTH, 3), 255, np.uint8)
        for a in range(8):
            for b in range(a + 1, 8):
                if np.sum(corners[a] != corners[b]) == 1:
                    ends = np.round(16 * self._at(corners[[a, b]])).astype(int)
                    cv2.line(
                        self.empty, tuple(ends[0].tolist()), tuple(ends[1].tolist()), (190, 190, 190), 1, cv2.LINE_AA, 4
                    )
        self.floor = low[2]
        self.low = low
        _label(
            self.empty,
            f"tank {1e3 * (high - low)[0]:.0f} x {1e3 * (high - low)[1]:.0f} x {1e3 * (high - low)[2]:.0f} mm",
            (20, 30),
            INK,
        )
        del head

    def _at(self, points: Floats) -> Floats:
        return np.asarray(points @ self.axes * self.zoom + self.shift)

    def draw(self, head: Floats, segment: Floats, place: int, tracked: bool, now: float) -> Picture:
        picture = self.empty.copy()
        shadow = head[: place + 1].copy()
        shadow[:, 2] = self.floor
        _polylines(picture, self._at(shadow), segment[: place + 1], (200, 200, 200))
        _polylines(picture, self._at(head[: place + 1]), segment[: place + 1], TRACK)
        _label(picture, f"t {now:7.2f} s", (20, 54), INK)
        if tracked:
            spot = np.round(16 * self._at(head[place : place + 1])[0]).astype(int)
            cv2.circle(picture, (int(spot[0]), int(spot[1])), 4 * 16, NOW, -1, cv2.LINE_AA, 4)
            x, y, z = 1e3 * head[place]
            _label(picture, f"x {x:6.1f}  y {y:6.1f}  z {z:6.1f} mm", (20, 78), INK)
        return picture
