"""A device of any shape: a closed triangle mesh in an STL file."""

import hashlib
import math
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from helimag.errors import FileError, InputError
from helimag.files import bytes_of
from helimag.scenario._fields import Length, Part, Size

Floats = NDArray[np.float64]


class Body(Part):
    """The device's surface from an STL file, and how the device's frame lies in the file's.

    STL has no unit, so ``unit`` says what 1 stands for. ``origin`` is the device's origin in the file's coordinates,
    ``long_axis`` points to its nose, ``moment_axis`` along its magnetic moment.
    """

    file: str
    """STL file, text or binary; its name counts from the scenario's folder."""
    unit: Size
    """What 1 stands for in the file."""
    origin: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """The device's origin, in the file's coordinates: positions, forces and gravity centre refer to it."""
    long_axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    """Direction of the nose in the file's coordinates, of any length; body x."""
    moment_axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    """Direction of the magnetic moment in the file's coordinates, at right angles to ``long_axis``; body y."""
    sha256: str | None = None
    """Of the file; filled in where left out, so that a run's own scenario tells what it was."""

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        long, moment = np.array(self.long_axis), np.array(self.moment_axis)
        size = np.linalg.norm(long) * np.linalg.norm(moment)
        if not (math.isfinite(size) and size > 0.0 and abs(long @ moment) < 1e-6 * size):
            raise InputError(
                f".long_axis and .moment_axis must be at right angles; got {self.long_axis} and {self.moment_axis}"
            )
        if self.sha256 is None:
            object.__setattr__(self, "sha256", hashlib.sha256(self._content()).hexdigest())
        return self

    @cached_property
    def corners(self) -> Floats:
        """Corners of the triangles (n, 3, 3) in the body frame (m), in the file's order.

        Raises
        ------
        FileError
            Where the file cannot be read, or is no longer what it was.
        InputError
            Where it is not STL.
        """
        content = self._content()
        if hashlib.sha256(content).hexdigest() != self.sha256:
            raise FileError(f"device.body.file {self.file} has changed: its sha256 is not {self.sha256}")
        placed: Floats = (_triangles(content, self.file) * self.unit - np.array(self.origin)) @ self._rotation.T
        return placed

    @property
    def _rotation(self) -> Floats:
        """From the file's directions to the body frame's."""
        x, y = (np.array(axis) / np.linalg.norm(axis) for axis in (self.long_axis, self.moment_axis))
        return np.stack([x, y, np.cross(x, y)])

    def _content(self) -> bytes:
        try:
            return bytes_of(self.file)
        except FileError as error:
            raise FileError(f"device.body.file: {error}") from None

    @property
    def front(self) -> float:
        """Place of the foremost point along x (m)."""
        return float(self.corners[:, :, 0].max())

    @property
    def rear(self) -> float:
        """Place of the rearmost point along x (m)."""
        return float(self.corners[:, :, 0].min())

    @property
    def radius(self) -> float:
        """Greatest distance of a point from the long axis (m)."""
        return float(np.hypot(self.corners[:, :, 1], self.corners[:, :, 2]).max())


def _triangles(content: bytes, name: str) -> Floats:
    """Corners (n, 3, 3) in an STL file's bytes, text or binary, in its own unit."""
    import io

    import trimesh

    try:
        mesh = trimesh.load_mesh(io.BytesIO(content), file_type="stl", process=False)
        corners = np.asarray(mesh.triangles, dtype=np.float64)
    except (ValueError, IndexError, KeyError, TypeError, AttributeError, trimesh.exchange.stl.HeaderError) as error:
        raise InputError(f"device.body.file {name} is not STL: {error}") from None
    if not len(corners):
        raise InputError(f"device.body.file {name} holds no triangles that can be read: {_size_of(content)}")
    if not np.isfinite(corners).all():
        raise InputError(f"device.body.file {name} must hold triangles with finite corners")
    return corners


def _size_of(content: bytes) -> str:
    """What the length of a file says of it, were it binary STL: 80 bytes of title, a count, 50 bytes a triangle."""
    if len(content) < 84:
        return f"it has {len(content)} bytes"
    count = int.from_bytes(content[80:84], "little")
    return (
        f"as text it has no whole facet, and as binary STL of {count} triangles it needs {84 + 50 * count} bytes, "
        f"not {len(content)}"
    )
