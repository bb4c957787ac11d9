"""The pictures of a session, and the board's corners in them."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError, InputError
from helimag.vision.calibration.boards import Board
from helimag.vision.calibration.session import Session
from helimag.vision.films import Picture, bits_of, eight_bits, read_raw

Floats = NDArray[np.float64]
Corners = tuple[NDArray[np.int64], Floats]  # numbers (n,) of the board's corners and where they are seen (n, 2) in px
Found = list[dict[str, dict[str, Corners]]]  # by camera, then "air" or "oil", then file name

PICTURES = (".png", ".tif", ".tiff", ".bmp", ".jpg")
LEAST_AIR = 6
TRIED = 4  # pictures that tell which pattern is printed
SAME_SHARE = 0.1  # by which markers may look smaller beside their squares: blur takes 5 % of a small one


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
    raw = {file.name: read_raw(file) for file in files}
    bits = bits_of(list(raw.values()))
    return {name: eight_bits(picture, bits) for name, picture in raw.items()}


def find_boards(session: Session, watch: Callable[[float], None]) -> tuple[Board, Found, list[tuple[int, int]]]:
    """The board as it is printed, its corners in every picture of both cameras, and the pictures' sizes.

    Raises
    ------
    InputError
        Where a camera's pictures differ in size, too few in air show the board, or it is another board.
    """
    found: Found = []
    sizes = []
    board: Board | None = None
    for number, view in enumerate(session.views):
        air, oil = read_pictures(view.air), read_pictures(view.oil)
        shapes = {picture.shape for picture in (*air.values(), *oil.values())}
        if len(shapes) > 1:
            raise InputError(f"pictures of camera {view.name} must all have the same size; got {sorted(shapes)}")
        height, width = shapes.pop()
        sizes.append((width, height))
        board = board or _printed(session.board, list(air.values()))
        seen: dict[str, dict[str, Corners]] = {}
        for kind, pictures in (("air", air), ("oil", oil)):
            corners = {name: board.find(picture) for name, picture in pictures.items()}
            seen[kind] = {name: pair for name, pair in corners.items() if pair[0].size}
        if view.lens is None and len(seen["air"]) < LEAST_AIR:
            remedy = "take more" if len(air) < LEAST_AIR else "check [board] against the printed one"
            raise InputError(
                f"camera {view.name} needs the board in at least {LEAST_AIR} pictures in air; it was found in "
                f"{len(seen['air'])} of {len(air)}: {remedy}"
            )
        found.append(seen)
        watch(0.3 * (number + 1))
    return board or session.board, found, sizes


def _printed(board: Board, pictures: list[Picture]) -> Board:
    """The board with the pattern, of today or of before OpenCV 4.6, of which the pictures show more.

    Raises
    ------
    InputError
        Where they show a chessboard without markers, or markers of another size.
    """
    some = pictures[:TRIED]
    both = (board, replace(board, legacy=not board.legacy))
    counts = [sum(kind.find(picture)[0].size for picture in some) for kind in both]
    if not any(counts):
        if any(board.is_plain(picture) for picture in some):
            raise InputError(
                "[board] must be a ChArUco board: the pictures show a plain chessboard, whose corners cannot be told "
                "apart from two sides; print one with markers (docs: Track with two cameras)"
            )
        return board
    chosen = both[int(np.argmax(counts))]
    shares = [share for picture in some if (share := chosen.marker_share(picture)) is not None]
    declared = board.marker / board.square
    if shares and not abs(float(np.median(shares)) / declared - 1.0) <= SAME_SHARE:
        raise InputError(
            f"[board] must have the printed one's sizes: its markers' sides are {np.median(shares):.3f} of its "
            f"squares' in the pictures, and {declared:.3f} by marker and square"
        )
    return chosen


def common(first: Corners, second: Corners) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Corners that two pictures share: numbers, and pixels in each."""
    numbers, one, two = np.intersect1d(first[0], second[0], return_indices=True)
    return numbers, first[1][one], second[1][two]
