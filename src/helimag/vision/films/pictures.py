"""Gray pictures of eight bits from decoded frames and from files of any depth."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError, InputError
from helimag.vision._cv import cv2

Picture = NDArray[np.uint8]
Raw = NDArray[np.uint8] | NDArray[np.uint16]

DEPTHS = (8, 10, 12, 14, 16)  # bits that cameras give
WHOLE = ("yuv420p", "yuvj420p", "gray", "yuvj422p", "yuv422p", "yuvj444p")  # formats whose first plane is brightness


def gray(frame: Any) -> Picture:
    """Brightness of a frame, black at 0: (height, width)."""
    if frame.format.name not in WHOLE:
        return np.asarray(frame.to_ndarray(format="gray"))
    plane = frame.planes[0]
    picture = np.frombuffer(plane, np.uint8).reshape(frame.height, plane.line_size)[:, : frame.width]
    full = frame.format.name.startswith("yuvj") or frame.format.name == "gray" or frame.color_range == 2
    return picture if full else np.asarray(cv2.LUT(picture, _FULL_RANGE))


_FULL_RANGE = np.clip((np.arange(256) - 16) * 255.0 / 219.0 + 0.5, 0, 255).astype(np.uint8)


def read_raw(file: Path) -> Raw:
    """Brightness as a file holds it, 8 or 16 bits a pixel: (height, width).

    Raises
    ------
    FileError
        Where it cannot be read as a picture.
    InputError
        Where its pixels are not whole numbers.
    """
    picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH)
    if picture is None:
        raise FileError(f"{file} cannot be read as a picture")
    if picture.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{file} must have pixels of 8 to 16 bits; it has {picture.dtype}")
    return picture.astype(np.uint8) if picture.dtype == np.uint8 else picture.astype(np.uint16)


def bits_of(pictures: list[Raw]) -> int:
    """Depth that pictures of one camera have: the least of 8, 10, 12, 14 and 16 bits that holds the brightest pixel.

    Files of 16 bits a pixel hold the 10 or 12 of most cameras, and do not say so.
    """
    if all(picture.dtype == np.uint8 for picture in pictures):
        return 8
    peak = max(int(picture.max()) for picture in pictures)
    return next(bits for bits in DEPTHS if peak < 2**bits)


def eight_bits(picture: Raw, bits: int) -> Picture:
    """The same at eight bits, given how many of its bits count; brighter pixels are white."""
    if picture.dtype == np.uint8:
        return np.asarray(picture, np.uint8)
    return np.asarray(np.minimum(picture >> (bits - 8), 255), np.uint8)
