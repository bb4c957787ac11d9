"""Lenses that OpenCV or MATLAB calibrated: matrix and distortion out of YAML, XML, JSON or .mat files."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError, InputError
from helimag.files import bytes_of
from helimag.vision._cv import cv2

Floats = NDArray[np.float64]

MATRICES = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "K", "M{0}", "cameraMatrix{0}", "camera_matrix_{0}")
DISTORTIONS = (
    "distortion_coefficients",
    "distCoeffs",
    "Distortion_Coefficients",
    "dist_coeffs",
    "D",
    "D{0}",
    "distCoeffs{0}",
    "dist_coeffs_{0}",
)
TO_STRUCT = "s = toStruct(cameraParams); save('lens.mat', '-struct', 's', '-v7')"


def read_lens(path: Path, number: int) -> tuple[Floats, Floats]:
    """Matrix (3, 3) and distortion (5,) as OpenCV has them, pixels counted from 0.

    OpenCV's ``FileStorage`` (.yml, .yaml, .xml, .json) is read by the names of its samples; of MATLAB the structure
    that ``toStruct`` makes of ``cameraParameters`` or ``stereoParameters``, as .mat (version 7 or before) or JSON.
    MATLAB counts pixels from 1, and before R2022b its ``IntrinsicMatrix`` is transposed.

    Parameters
    ----------
    number
        1 or 2: which camera of a pair is meant where the file holds two.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where it holds no lens, with the names found in it.
    """
    if not path.is_file():
        raise FileError(f"there is no file '{path}' with a lens")
    match path.suffix.lower():
        case ".mat":
            matrix, distortion = _matlab(_mat(path), number, path)
        case ".json":
            matrix, distortion = _json(path, number)
        case ".yml" | ".yaml" | ".xml":
            matrix, distortion = _opencv(path, number)
        case _:
            raise InputError(f"a lens must be a .yml, .yaml, .xml, .json or .mat file; got '{path}'")
    if matrix.shape != (3, 3) or not np.all(np.isfinite(matrix)) or not (matrix[0, 0] > 0.0 and matrix[1, 1] > 0.0):
        raise InputError(f"{path} must have a camera matrix of 3 x 3 with focal lengths in px; got {matrix.tolist()}")
    if distortion.size > 5 and np.any(distortion[5:] != 0.0):
        raise InputError(f"{path} has {distortion.size} coefficients of distortion; k1, k2, p1, p2, k3 are understood")
    return matrix, np.pad(distortion[:5], (0, max(0, 5 - distortion.size)))


def _opencv(path: Path, number: int) -> tuple[Floats, Floats]:
    names: list[str] = []
    values = []
    try:
        storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
        names = list(storage.root().keys())
        for known in (MATRICES, DISTORTIONS):
            wanted = [name.format(number) for name in known]
            value = next((storage.getNode(name).mat() for name in wanted if name in names), None)
            if value is None:
                raise InputError(
                    f"{path} must have a matrix named {', '.join(wanted)}; it has {', '.join(names) or 'nothing'}"
                )
            values.append(np.asarray(value, dtype=np.float64))
    except (cv2.error, SystemError):
        raise InputError(
            f"{path} must be a file of OpenCV's FileStorage, as cv::Mat with rows, cols, dt and data; it has "
            f"{', '.join(names) or 'nothing that OpenCV reads'} (a camera_info of ROS is none)"
        ) from None
    return values[0], values[1].ravel()


def _json(path: Path, number: int) -> tuple[Floats, Floats]:
    try:
        data = json.loads(bytes_of(path).decode("utf-8"))
    except (ValueError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not JSON: {error}") from None
    if isinstance(data, Mapping) and any(isinstance(part, Mapping) and "type_id" in part for part in data.values()):
        return _opencv(path, number)
    return _matlab(data, number, path)


def _mat(path: Path) -> Any:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        return loadmat(path, simplify_cells=True)
    except NotImplementedError:
        raise InputError(f"{path} is a .mat file of version 7.3; save it with '-v7'") from None
    except (MatReadError, ValueError, TypeError, OSError) as error:
        raise InputError(f"{path} is not a .mat file: {error}") from None


def _matlab(data: Any, number: int, path: Path) -> tuple[Floats, Floats]:
    names = [name for name in data if not name.startswith("__")] if isinstance(data, Mapping) else []
    if isinstance(data, Mapping):
        pair = data.get(f"CameraParameters{number}")
        if isinstance(pair, Mapping):
            return _matlab(pair, number, path)
        if len(names) == 1 and isinstance(data[names[0]], Mapping):
            return _matlab(data[names[0]], number, path)
    try:
        matrix = np.array(data["K"] if "K" in names else np.transpose(data["IntrinsicMatrix"]), dtype=np.float64)
        radial = np.atleast_1d(np.array(data["RadialDistortion"], dtype=np.float64))
        tangential = np.atleast_1d(np.array(data["TangentialDistortion"], dtype=np.float64))
    except (KeyError, TypeError, ValueError):
        raise InputError(
            f"{path} must hold a structure with K or IntrinsicMatrix, RadialDistortion and TangentialDistortion; "
            f"it has {', '.join(names) or 'nothing that can be read'}; in MATLAB: {TO_STRUCT}"
        ) from None
    if matrix.shape == (3, 3):
        matrix[:2, 2] -= 1.0
    return matrix, np.concatenate([radial[:2], tangential[:2], radial[2:3]])
