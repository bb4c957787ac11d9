"""Films of a run as a rig's cameras would take them: refraction, lens, blur, noise, compression, lost frames."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from helimag.errors import InputError
from helimag.runs.trajectory import Trajectory
from helimag.vision._cv import cv2
from helimag.vision.cameras import Camera, Rig
from helimag.vision.films import FilmWriter
from helimag.vision.shape import Shape
from helimag.vision.silhouette import Box, outline, silhouette
from helimag.vision.synthetic.rig import Effects, backdrop

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

FOLDERS = (".png", ".tiff")  # kinds of pictures that make a folder instead of a file
SUBFRAMES = 3  # instants an exposure is averaged over
COARSEST = 0.05  # longest interval between a run's samples (s): a turn at 3.5 Hz takes 0.29 s
OPACITY = 0.9
NOISY = 12  # noisy backdrops that frames are drawn on in random order
BUBBLE_SPEED = 8e-3  # of a rising bubble (m/s)


class FilmedMotion:
    """A run between its samples: position by spline, attitude by the shortest rotation.

    Raises
    ------
    InputError
        Where the run has no attitude, or samples too far apart.
    """

    def __init__(self, run: Trajectory) -> None:
        time = np.asarray(run.dataset["time"].values, dtype=np.float64)
        if "quaternion" not in run.dataset:
            raise InputError("a run must have quaternions to be rendered; a measured one has none")
        if time.size < 4 or float(np.diff(time).max()) > COARSEST:
            raise InputError(
                f"a run must have a sample at least every {COARSEST} s to be rendered; simulate it with "
                f"--interval '0.02 s'"
            )
        attitude = np.asarray(run.dataset["quaternion"].values)
        self.start, self.end = float(time[0]), float(time[-1])
        self._place = CubicSpline(time, np.asarray(run.dataset["position"].values))
        self._turn = Slerp(time, Rotation.from_quat(attitude, scalar_first=True))

    def pose(self, times: Floats) -> tuple[Floats, Floats]:
        """Head positions (n, 3) in m and rotation matrices (n, 3, 3) from body to lab."""
        inside = np.clip(times, self.start, self.end)
        return np.asarray(self._place(inside)), np.asarray(self._turn(inside).as_matrix())


@dataclass(frozen=True)
class _Scene:
    camera: Camera
    view: int
    backdrops: list[Picture]
    light: Floats
    surface: float
    mirror: float | None


def render_run(
    run: Trajectory,
    rig: Rig,
    folder: str | Path,
    *,
    shape: Shape | None = None,
    effects: Effects | None = None,
    kind: str = ".mp4",
    start: float = 0.0,
    duration: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Path]:
    """Draw both views of a run, with the truth beside them.

    Parameters
    ----------
    run
        Simulated, with samples at most 0.05 s apart.
    folder
        Gets a film a view, named after the cameras, and ``truth.nc``, the run at the first camera's frames.
    kind
        ".mp4" (H.264), ".avi" (MJPEG), ".png" or ".tiff" (a folder of pictures a view).
    start, duration
        Part of the run to draw (s); default all of it.

    Returns
    -------
    dict
        Paths by camera name, and "truth".

    Raises
    ------
    InputError
        Where the run's samples are too far apart, or it begins outside the rig's tank.
    """
    effects = effects or Effects()
    shape = shape or _shape_of(run)
    motion = FilmedMotion(run)
    _begins_inside(motion, rig)
    begin, end, count = _span(motion, start, duration, effects.rate)
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(effects.seed)
    times = begin + np.arange(count) / effects.rate
    paths: dict[str, Path] = {}
    shown: list[Floats] = []
    lead = max(0.0, -effects.clock_offset)  # no film may begin before its clock's zero
    for view, camera in enumerate(rig.cameras):
        scene = _scene(rig, view, effects, random)
        shift = 0.0 if view == 0 else 0.37 / effects.rate  # the cameras are not triggered together
        kept = random.uniform(size=count) >= effects.dropped
        kept[[0, -1]] = True
        shown.append(times[kept] + shift)
        paths[camera.name] = target / (camera.name if kind in FOLDERS else f"{camera.name}{kind}")
        ahead = lead + (effects.clock_offset if view == 1 else 0.0) - begin
        pictures = kind if kind in FOLDERS else None
        with FilmWriter(
            paths[camera.name], camera.size, pictures=pictures, rate=effects.rate, bits=effects.bits
        ) as film:
            for index, time in enumerate(shown[view]):
                film.write(_frame(scene, motion, shape, effects, time, begin, end, random), time + ahead)
                if progress is not None:
                    progress((view + index / shown[view].size) / 2.0)
    paths["truth"] = target / "truth.nc"
    _truth(run, motion, shown[0], begin - lead).save(paths["truth"])
    return paths


def _span(motion: FilmedMotion, start: float, duration: float | None, rate: float) -> tuple[float, float, int]:
    """First and last instant of the part that is filmed (s), and its number of frames."""
    begin = motion.start + start
    end = motion.end if duration is None else min(motion.end, begin + duration)
    count = int((end - begin) * rate + 1e-9)
    if count < 4:
        raise InputError(f"a film needs at least 4 frames; the chosen part of the run lasts {end - begin:.3g} s")
    return begin, end, count


def _shape_of(run: Trajectory) -> Shape:
    from helimag.scenario import parse

    return Shape() if run.scenario_toml is None else Shape.of(parse(run.scenario_toml).device)


def _truth(run: Trajectory, motion: FilmedMotion, times: Floats, begin: float) -> Trajectory:
    position, turn = motion.pose(times)
    axis = turn[:, :, 0]
    variables = {
        "position": position,
        "long_axis": axis,
        "attack_angle": np.arcsin(np.clip(axis[:, 2], -1.0, 1.0)),
        "quaternion": np.asarray(Rotation.from_matrix(turn).as_quat(scalar_first=True)),
    }
    attributes: dict[str, object] = {
        "name": f"truth of {run.dataset.attrs.get('name', 'a run')}",
        "source": "rendered",
        "initial_gap": run.dataset.attrs["initial_gap"],
        "end": run.dataset.attrs["end"],
    }
    if run.scenario_toml is not None:
        attributes["scenario"] = run.scenario_toml
    return Trajectory.from_arrays(times - begin, variables, attributes)


def _begins_inside(motion: FilmedMotion, rig: Rig) -> None:
    first, _ = motion.pose(np.array([motion.start]))
    if not rig.inside(first[0]):
        low, high, here = (1e3 * corner for corner in (*rig.tank, first[0]))
        ranges = ", ".join(f"{a} {x:g} to {y:g} mm" for a, x, y in zip("xyz", low, high, strict=True))
        at = ", ".join(f"{x:.4g}" for x in here)
        raise InputError(f"a run must begin inside the rig's tank ({ranges}) to be filmed; got ({at}) mm")


def _scene(rig: Rig, view: int, effects: Effects, random: np.random.Generator) -> _Scene:
    light = backdrop(rig, view, random)
    noisy = [_noisy(light, effects, random) for _ in range(NOISY)]
    surface = float(rig.tank[1, 2])
    mirror = surface if view == 0 and effects.reflection > 0.0 else None
    return _Scene(rig.cameras[view], view, noisy, light, surface, mirror)


def _noisy(light: Floats, effects: Effects, random: np.random.Generator) -> Picture:
    """Shot noise and read noise, rounded to grey levels."""
    spread = effects.noise * np.sqrt(0.3 + 0.7 * np.clip(light, 0.0, None) / 127.0)
    noise = random.standard_normal(light.shape, dtype=np.float32)
    return np.clip(light + spread * noise + 0.5, 0, 255).astype(np.uint8)


def _frame(
    scene: _Scene,
    motion: FilmedMotion,
    shape: Shape,
    effects: Effects,
    time: float,
    begin: float,
    end: float,
    random: np.random.Generator,
) -> Picture:
    picture = scene.backdrops[int(random.integers(NOISY))].copy()
    instants = time + effects.exposure * ((np.arange(SUBFRAMES) + 0.5) / SUBFRAMES - 0.5)
    position, turn = motion.pose(instants)
    hidden = effects.hidden
    if hidden is None or hidden[0] != scene.view or not hidden[1] <= time - begin < hidden[2]:
        _darken(picture, scene, _body(scene.camera, position, turn, shape), OPACITY, effects, random)
        if scene.mirror is not None:
            flip = np.diag([1.0, 1.0, -1.0])
            image = _body(scene.camera, position @ flip + [0.0, 0.0, 2.0 * scene.mirror], flip @ turn, shape)
            _darken(picture, scene, image, OPACITY * effects.reflection, effects, random)
    if effects.bubble > 0.0:
        half = (begin + end) / 2.0
        rise = np.array([[0.0, 0.0, BUBBLE_SPEED * (time - half)]])
        centre = motion.pose(np.array([half]))[0] + np.array([-5e-3, 0.0, 0.0]) + rise
        if scene.surface > centre[0, 2] + effects.bubble / 2.0:
            _bubble(picture, scene, centre, effects, random)
    return picture


Marks = tuple[Box, Any]


def _body(camera: Camera, position: Floats, turn: Floats, shape: Shape) -> Marks:
    """Share of each pixel that the body covers over the exposure, in a box (left, top, right, bottom)."""
    box = outline(camera, position, turn, shape)
    if box is None:
        return (0, 0, 0, 0), None
    return box, np.mean([silhouette(camera, *pose, shape, box) for pose in zip(position, turn, strict=True)], axis=0)


def _darken(
    picture: Picture, scene: _Scene, marks: Marks, opacity: float, effects: Effects, random: np.random.Generator
) -> None:
    (left, top, right, bottom), cover = marks
    height, width = picture.shape
    if cover is None or right <= 0 or bottom <= 0 or left >= width or top >= height:
        return
    cover = cv2.GaussianBlur(cover, (0, 0), effects.blur)
    a, b, c, d = max(left, 0), max(top, 0), min(right, width), min(bottom, height)
    part = cover[b - top : d - top, a - left : c - left] * opacity
    region = picture[b:d, a:c].astype(np.float64)
    # noise is already in the backdrop; it is kept, scaled as shot noise scales
    light = scene.light[b:d, a:c]
    through = 1.0 - part
    fresh = (region - light) * np.sqrt(through) + light * through + random.normal(0.0, 0.3, region.shape)
    picture[b:d, a:c] = np.clip(fresh + 0.5, 0, 255).astype(np.uint8)


def _bubble(picture: Picture, scene: _Scene, centre: Floats, effects: Effects, random: np.random.Generator) -> None:
    """A bubble in back light: a dark disc with a bright middle."""
    spot = scene.camera.project(centre)[0]
    if not np.all(np.isfinite(spot)):
        return
    radius = effects.bubble / 2.0 * float(scene.camera.scale(centre)[0])
    box = int(radius + 8)
    left, top = int(spot[0]) - box, int(spot[1]) - box
    cover = np.zeros((2 * box + 1, 2 * box + 1), np.float32)
    place = np.round((spot - (left, top)) * 16).astype(int)
    cv2.circle(cover, (int(place[0]), int(place[1])), round(radius * 16), 1.0, -1, cv2.LINE_AA, 4)
    cv2.circle(cover, (int(place[0]), int(place[1])), round(radius * 0.4 * 16), 0.1, -1, cv2.LINE_AA, 4)
    _darken(picture, scene, ((left, top, left + cover.shape[1], top + cover.shape[0]), cover), 0.8, effects, random)
