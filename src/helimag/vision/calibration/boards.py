"""ChArUco boards: found in pictures, and drawn into them ray by ray."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline

from helimag.errors import InputError
from helimag.vision._cv import cv2
from helimag.vision.cameras import Camera

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

TEXELS = 120  # of a square's side in the board's picture
GRID = 8  # pixels between rays that are traced; the board's coordinates are smooth in between
LEAST_CORNERS = 8  # of a board that is used


@dataclass(frozen=True)
class Board:
    """A ChArUco board; its frame has the origin at the corner of the first square, x along rows, y down, z into the
    board.

    Parameters
    ----------
    columns, rows
        Squares.
    square, marker
        Sides of a square and of a marker (m).
    dictionary
        Name of an OpenCV marker dictionary, such as "DICT_4X4_50".
    """

    columns: int = 8
    rows: int = 6
    square: float = 9e-3
    marker: float = 6.75e-3
    dictionary: str = "DICT_4X4_50"

    @cached_property
    def _board(self) -> Any:
        number = getattr(cv2.aruco, self.dictionary, None)
        if not self.dictionary.startswith("DICT_") or number is None:
            raise InputError(
                f"board.dictionary must name a marker dictionary such as 'DICT_4X4_50'; got '{self.dictionary}'"
            )
        dictionary = cv2.aruco.getPredefinedDictionary(number)
        try:
            return cv2.aruco.CharucoBoard((self.columns, self.rows), self.square, self.marker, dictionary)
        except cv2.error as error:
            raise InputError(f"board cannot be made from these sizes: {error}") from None

    @cached_property
    def corners(self) -> Floats:
        """Inner corners in the board's frame (m): (n, 3)."""
        return np.asarray(self._board.getChessboardCorners(), dtype=np.float64)

    @cached_property
    def _detector(self) -> Any:
        return cv2.aruco.CharucoDetector(self._board)

    def find(self, picture: Picture) -> tuple[NDArray[np.int64], Floats]:
        """Numbers (n,) and pixels (n, 2) of the inner corners seen; none where fewer than eight are."""
        pixels, numbers, _, _ = self._detector.detectBoard(picture)
        if numbers is None or len(numbers) < LEAST_CORNERS:
            return np.zeros(0, np.int64), np.zeros((0, 2))
        return np.asarray(numbers, np.int64).ravel(), np.asarray(pixels, np.float64).reshape(-1, 2)

    def draw(self, camera: Camera, rotation: Floats, place: Floats, random: np.random.Generator) -> Picture:
        """Photograph the board: rays go from pixels through the wall to the board's plane.

        Parameters
        ----------
        rotation, place
            (3, 3) and (3,): from the board's frame to the lab (m).
        """
        width, height = camera.size
        margin = self.square / 4.0
        size = np.array([self.columns, self.rows]) * self.square
        outline = np.array(
            [
                [-margin, -margin, 0],
                [size[0] + margin, -margin, 0],
                [*(size + margin), 0],
                [-margin, size[1] + margin, 0],
            ]
        )
        seen = camera.project(outline @ rotation.T + place)
        shade = 190.0 + 12.0 * random.normal() * (np.mgrid[0:height, 0:width][1] / width - 0.5)
        picture = shade * 0.45
        low = np.clip(np.floor(seen.min(axis=0)).astype(int) - 2 * GRID, 0, (width - GRID, height - GRID))
        high = np.clip(np.ceil(seen.max(axis=0)).astype(int) + 2 * GRID, GRID, (width, height))
        inside = self._sampled(camera, rotation, place, low, high)
        region = (slice(low[1], high[1]), slice(low[0], high[0]))
        white = inside >= 0.0
        picture[region] = np.where(white, shade[region] * (0.12 + 0.88 * inside / 255.0), picture[region])
        picture = cv2.GaussianBlur(picture, (0, 0), 0.7) + random.normal(0.0, 2.0, picture.shape)
        return np.asarray(np.clip(picture + 0.5, 0, 255), dtype=np.uint8)

    def _sampled(
        self, camera: Camera, rotation: Floats, place: Floats, low: NDArray[np.int64], high: NDArray[np.int64]
    ) -> Floats:
        """Brightness of the board in a box of pixels, averaged over 2 x 2 rays a pixel; -1 beside the board."""
        columns = np.arange(low[0] - GRID, high[0] + GRID + 1, GRID, dtype=np.float64)
        rows = np.arange(low[1] - GRID, high[1] + GRID + 1, GRID, dtype=np.float64)
        pixels = np.stack(np.meshgrid(columns, rows), axis=-1)
        origins, directions = camera.rays(pixels)
        normal = rotation[:, 2]
        hits = origins + directions * (((place - origins) @ normal) / (directions @ normal))[..., None]
        local = (hits - place) @ rotation / self.square * TEXELS - 0.5
        texture = self._board.generateImage((self.columns * TEXELS, self.rows * TEXELS), marginSize=0, borderBits=1)
        edge = TEXELS // 4
        texture = cv2.copyMakeBorder(texture, edge, edge, edge, edge, cv2.BORDER_CONSTANT, value=255)
        zoom = float(np.hypot(*(local[1:, :, :2] - local[:-1, :, :2]).reshape(-1, 2).mean(axis=0))) / GRID
        texture = cv2.GaussianBlur(texture, (0, 0), max(0.3, 0.25 * zoom))
        total = np.zeros((high[1] - low[1], high[0] - low[0]))
        fine_x = np.arange(low[0], high[0], dtype=np.float64)
        fine_y = np.arange(low[1], high[1], dtype=np.float64)
        maps = [RectBivariateSpline(rows, columns, local[..., axis]) for axis in (0, 1)]
        for dy in (-0.25, 0.25):
            for dx in (-0.25, 0.25):
                u, v = (np.asarray(spline(fine_y + dy, fine_x + dx), np.float32) + edge for spline in maps)
                total += _look_up(texture, u, v)
        return np.where(total >= 0.0, total / 4.0, -1.0)


def _look_up(texture: Picture, u: NDArray[np.float32], v: NDArray[np.float32]) -> Floats:
    values = cv2.remap(texture.astype(np.float32), u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    outside = (u < 0) | (v < 0) | (u > texture.shape[1] - 1) | (v > texture.shape[0] - 1)
    return np.asarray(np.where(outside, -1.0e4, values), dtype=np.float64)
