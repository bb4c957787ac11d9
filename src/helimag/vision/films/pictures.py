"""Gray pictures from decoded frames and from files."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError
from helimag.vision._cv import cv2

Picture = NDArray[np.uint8]


def gray(frame: Any) -> Picture:
    """Brightness of a frame, black at 0: (height, width)."""
    if frame.format.name not in ("yuv420p", "yuvj420p", "gray", "yuvj422p", "yuv422p", "yuvj444p"):
        return np.asarray(frame.to_ndarray(format="gray"))
    plane = frame.planes[0]
    picture = np.frombuffer(plane, np.uint8).reshape(frame.height, plane.line_size)[:, : frame.width]
    full = frame.format.name.startswith("yuvj") or frame.format.name == "gray" or frame.color_range == 2
    return picture if full else np.asarray(cv2.LUT(picture, _FULL_RANGE))


_FULL_RANGE = np.clip((np.arange(256) - 16) * 255.0 / 219.0 + 0.5, 0, 255).astype(np.uint8)


def read_picture(file: Path) -> Picture:
    picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH)
    if picture is None:
        raise FileError(f"{file} cannot be read as a picture")
    if picture.dtype == np.uint16:
        picture = (picture // 257).astype(np.uint8)
    return np.asarray(picture, dtype=np.uint8)
