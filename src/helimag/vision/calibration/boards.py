"""ChArUco boards: found in pictures."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.vision._cv import cv2
from helimag.vision.calibration.corners import refined

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

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
    legacy
        Whether the pattern is that of OpenCV before 4.6; with an even number of rows it begins with the other colour.
    """

    columns: int = 8
    rows: int = 6
    square: float = 9e-3
    marker: float = 6.75e-3
    dictionary: str = "DICT_4X4_50"
    legacy: bool = False

    @cached_property
    def _board(self) -> Any:
        number = getattr(cv2.aruco, self.dictionary, None)
        if not self.dictionary.startswith("DICT_") or number is None:
            raise InputError(
                f"board.dictionary must name a marker dictionary such as 'DICT_4X4_50'; got '{self.dictionary}'"
            )
        dictionary = cv2.aruco.getPredefinedDictionary(number)
        try:
            board = cv2.aruco.CharucoBoard((self.columns, self.rows), self.square, self.marker, dictionary)
            board.setLegacyPattern(self.legacy)
            return board
        except cv2.error as error:
            raise InputError(f"board cannot be made from these sizes: {error}") from None

    @cached_property
    def corners(self) -> Floats:
        """Inner corners in the board's frame (m): (n, 3)."""
        return np.asarray(self._board.getChessboardCorners(), dtype=np.float64)

    def picture(self, texels: int) -> Picture:
        """The printed board without a margin, each square so many texels wide."""
        size = (self.columns * texels, self.rows * texels)
        return np.asarray(self._board.generateImage(size, marginSize=0, borderBits=1), np.uint8)

    @cached_property
    def _detector(self) -> Any:
        return cv2.aruco.CharucoDetector(self._board)

    def find(self, picture: Picture) -> tuple[NDArray[np.int64], Floats]:
        """Numbers (n,) and pixels (n, 2) of the inner corners seen; none where fewer than eight are."""
        pixels, numbers, _, _ = self._detector.detectBoard(picture)
        if numbers is None or len(numbers) < LEAST_CORNERS:
            return np.zeros(0, np.int64), np.zeros((0, 2))
        placed, known = refined(picture, np.asarray(pixels, np.float64).reshape(-1, 2))
        if known.sum() < LEAST_CORNERS:
            return np.zeros(0, np.int64), np.zeros((0, 2))
        return np.asarray(numbers, np.int64).ravel()[known], placed[known]

    def is_plain(self, picture: Picture) -> bool:
        """Whether a picture shows a chessboard of this size without markers."""
        inner = (self.columns - 1, self.rows - 1)
        return bool(min(inner) > 2 and cv2.findChessboardCornersSB(picture, inner)[0])

    def marker_share(self, picture: Picture) -> float | None:
        """Side of the markers seen over that of the squares seen; None where too few are."""
        pixels, numbers, corners, names = self._detector.detectBoard(picture)
        if numbers is None or len(numbers) < LEAST_CORNERS or names is None:
            return None
        plane = self.corners[np.asarray(numbers).ravel(), :2]
        back, _ = cv2.findHomography(np.asarray(pixels, np.float64).reshape(-1, 2), plane)
        sides = []
        for four in corners:
            placed = cv2.perspectiveTransform(np.asarray(four, np.float64).reshape(1, 4, 2), back)[0]
            sides.append(np.linalg.norm(placed - np.roll(placed, 1, axis=0), axis=1).mean())
        return float(np.median(sides)) / self.square
