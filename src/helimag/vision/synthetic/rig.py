"""A synthetic rig: two cameras on the tank of the paper, drawn as hard as the real thing, with the truth beside it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.scenario import PAPER_TANK
from helimag.vision._cv import cv2
from helimag.vision.cameras import Camera, Rig, looking
from helimag.vision.films import DEPTHS
from helimag.vision.refraction import Wall

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

STEEPEST = 0.7  # angle to a wall's normal from which a camera sees little (rad)
AWAY = 0.35  # distance of the cameras from the walls (m)


@dataclass(frozen=True, kw_only=True)
class Effects:
    """What makes the pictures hard. Times in s, lengths in m, brightness in grey levels of 255.

    Parameters
    ----------
    dropped
        Share of the frames of each view that are lost.
    clock_offset
        How much the second camera's clock is ahead.
    exposure
        Of a frame; the device moves meanwhile.
    noise
        Standard deviation, at half brightness; shot noise rises with its root.
    reflection
        Contrast of the device's mirror image in the oil's surface, as the front view sees it (total reflection).
    bubble
        Diameter of an air bubble that rises through both views where the device is at half time; 0 for none.
    bits
        A pixel of the films: 8, 10, 12, 14 or 16 in folders, 8 or 10 in .mp4.
    hidden
        (view, from, until): the device is out of that view in between.
    """

    rate: float = 30.0
    exposure: float = 5e-3
    dropped: float = 0.0
    clock_offset: float = 0.0
    noise: float = 2.0
    blur: float = 0.7
    reflection: float = 0.35
    bubble: float = 0.0
    hidden: tuple[int, float, float] | None = None
    bits: int = 8
    seed: int = 0

    def __post_init__(self) -> None:
        if self.bits not in DEPTHS:
            raise InputError(f"bits must be one of {', '.join(map(str, DEPTHS))}; got {self.bits}")
        if not 0.0 <= self.dropped < 0.9:
            raise InputError(f"dropped must be a share from 0 to 0.9; got {self.dropped}")


def paper_rig(*, seed: int = 0, angle: float = 0.0, size: tuple[int, int] = (1280, 1024)) -> Rig:
    """Two cameras on a plexiglass tank of 200 x 80 x 80 mm, 350 mm away, set up as well as a person would.

    One looks along y through the front wall and one from below through the floor: both see the device broadside all
    along the 160 mm of a straight run. From the end of the tank it would be seen end on, head before tail, and its
    heading would hardly be observed. Each camera is off by a degree and some millimetres, drawn from ``seed``.

    Parameters
    ----------
    angle
        Between each optical axis and the normal of its wall (rad), 0 to 0.7; the side that a camera leans to is drawn.

    Returns
    -------
    Rig
        Front and below.

    Raises
    ------
    InputError
        Where the angle is out of range.
    """
    if not 0.0 <= angle <= STEEPEST:
        raise InputError(f"angle must be from 0 to {STEEPEST} rad; got {angle}")
    random = np.random.default_rng(seed)
    sides = np.random.default_rng([seed, 1]).uniform(0.0, 2.0 * np.pi, 2)
    tank = np.array(PAPER_TANK)
    middle = np.array([0.080, 0.0, -0.020])
    front = Wall(np.array([0.08, tank[0, 1] - 0.005, 0.0]), _tilted([0.0, 1.0, 0.0], random), 0.005)
    floor = Wall(np.array([0.08, 0.0, tank[0, 2] - 0.005]), _tilted([0.0, 0.0, 1.0], random), 0.005)
    cameras = []
    for name, wall, up, focal, side in (
        ("front", front, [0.0, 0.0, 1.0], 2500.0, sides[0]),
        ("below", floor, [0.0, -1.0, 0.0], 2600.0, sides[1]),
    ):
        position, ahead = _stand(middle, wall, np.array(up), angle, side)
        target = position + ahead + random.normal(0.0, 2e-3, 3)
        rotation, translation = looking(position + random.normal(0.0, 4e-3, 3), target, np.array(up))
        actual = focal * (1.0 + random.normal(0.0, 0.005))
        centre = np.array(size) / 2.0 - 0.5 + random.normal(0.0, 6.0, 2)
        matrix = np.array([[actual, 0.0, centre[0]], [0.0, actual * 1.0004, centre[1]], [0.0, 0.0, 1.0]])
        distortion = np.array([-0.12, 0.09, 5e-4, -4e-4, 0.0]) * random.normal(1.0, 0.1, 5)
        cameras.append(Camera(name, matrix, distortion, rotation, translation, size, wall))
    return Rig((cameras[0], cameras[1]), tank)


def _stand(middle: Floats, wall: Wall, up: Floats, angle: float, side: float) -> tuple[Floats, Floats]:
    """Where a camera stands that sees a point at an angle to its wall's normal, and from there to where it appears."""
    normal = np.round(wall.normal)
    aside = np.sin(angle) * (np.cos(side) * np.cross(normal, up) + np.sin(side) * up)
    spot = middle
    for thickness, index in (
        (float((middle - wall.point) @ normal) - wall.thickness, wall.indices[2]),
        (wall.thickness, wall.indices[1]),
    ):
        across = aside / index
        spot = spot - thickness * (normal + across / np.sqrt(1.0 - across @ across))
    forward = np.cos(angle) * normal + aside
    position = spot - AWAY * forward
    return position, forward * float((middle - position) @ forward)


def _tilted(normal: list[float], random: np.random.Generator) -> Floats:
    tilted = np.array(normal) + random.normal(0.0, 4e-3, 3)
    return np.asarray(tilted / np.linalg.norm(tilted))


def backdrop(rig: Rig, view: int, random: np.random.Generator) -> Floats:
    """Brightness of the tank without the device, uneven, with dust, scratches and the tank's edges: (height, width)."""
    camera = rig.cameras[view]
    width, height = camera.size
    down, across = np.mgrid[0:height, 0:width]
    x, y = across / width - 0.5 + 0.1 * random.normal(), down / height - 0.5 + 0.1 * random.normal()
    light = 205.0 * (1.0 - 0.45 * (x * x + y * y) + 0.12 * random.normal() * x + 0.12 * random.normal() * y)
    patches = cv2.resize(random.normal(0.0, 1.0, (8, 10)), (width, height), interpolation=cv2.INTER_CUBIC)
    light = light * (1.0 + 0.015 * patches)
    dark = np.zeros((height, width), np.float32)
    for _ in range(60):  # dust on the walls
        spot = (int(random.uniform(0, width)), int(random.uniform(0, height)))
        cv2.circle(dark, spot, int(random.integers(1, 3)), float(random.uniform(0.05, 0.3)), -1, cv2.LINE_AA)
    for _ in range(4):  # scratches
        (left, top), (right, bottom) = (random.uniform(0, 1, (2, 2)) * (width, height)).astype(int).tolist()
        shade = float(random.uniform(0.03, 0.1))
        cv2.line(dark, (left, top), (right, bottom), shade, 1, cv2.LINE_AA)
    for start, end in _edges(rig, view):
        line = camera.project(np.linspace(start, end, 40))
        cv2.polylines(dark, [np.round(line).astype(np.int32)], False, 0.5, 3, cv2.LINE_AA)
    return np.asarray(light * (1.0 - cv2.GaussianBlur(dark, (0, 0), 0.8)))


def _edges(rig: Rig, view: int) -> list[tuple[Floats, Floats]]:
    """The edges of the oil on the wall that lies opposite the camera."""
    low, high = rig.tank
    if view == 0:
        corners = [(low[0], low[2]), (high[0], low[2]), (high[0], high[2]), (low[0], high[2])]
        points = [np.array([x, high[1], z]) for x, z in corners]
    else:
        points = [
            np.array([x, y, high[2]])
            for x, y in [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
        ]
    return list(zip(points, points[1:] + points[:1], strict=True))
