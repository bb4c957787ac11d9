"""The pictures of a session, and the board's corners in them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError, InputError
from helimag.vision._cv import cv2
from helimag.vision.calibration.session import Session

Floats = NDArray[np.float64]
Corners = tuple[NDArray[np.int64], Floats]  # numbers (n,) of the board's corners and where they are seen (n, 2) in px
Found = list[dict[str, dict[str, Corners]]]  # by camera, then "air" or "oil", then file name

PICTURES = (".png", ".tif", ".tiff", ".bmp", ".jpg")
LEAST_AIR = 6


def read_pictures(folder: Path) -> dict[str, NDArray[np.uint8]]:
    """Gray pictures of a folder by file name.

    Raises
    ------
    FileError
        Where there is no such folder, or a picture cannot be read.
    InputError
        Where it holds none.
    """
    if not folder.is_dir():
        raise FileError(f"there is no folder '{folder}' with pictures of the board")
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in PICTURES)
    if not files:
        raise InputError(f"{folder} holds no picture of the board")
    pictures = {}
    for file in files:
        picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
        if picture is None:
            raise FileError(f"{file} cannot be read as a picture")
        pictures[file.name] = np.asarray(picture, np.uint8)
    return pictures


def find_boards(session: Session, watch: Callable[[float], None]) -> tuple[Found, list[tuple[int, int]]]:
    """The board's corners in every picture of both cameras, and the pictures' sizes.

    Raises
    ------
    InputError
        Where a camera's pictures differ in size, or too few in air show the board.
    """
    found: Found = []
    sizes = []
    for number, view in enumerate(session.views):
        air, oil = read_pictures(view.air), read_pictures(view.oil)
        shapes = {picture.shape for picture in (*air.values(), *oil.values())}
        if len(shapes) > 1:
            raise InputError(f"pictures of camera {view.name} must all have the same size; got {sorted(shapes)}")
        height, width = shapes.pop()
        sizes.append((width, height))
        seen = {}
        for kind, pictures in (("air", air), ("oil", oil)):
            corners = {name: session.board.find(picture) for name, picture in pictures.items()}
            seen[kind] = {name: pair for name, pair in corners.items() if pair[0].size}
        if len(seen["air"]) < LEAST_AIR:
            remedy = "take more" if len(air) < LEAST_AIR else "check [board] against the printed one"
            raise InputError(
                f"camera {view.name} needs the board in at least {LEAST_AIR} pictures in air; it was found in "
                f"{len(seen['air'])} of {len(air)}: {remedy}"
            )
        found.append(seen)
        watch(0.3 * (number + 1))
    return found, sizes


def common(first: Corners, second: Corners) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Corners that two pictures share: numbers, and pixels in each."""
    numbers, one, two = np.intersect1d(first[0], second[0], return_indices=True)
    return numbers, first[1][one], second[1][two]
