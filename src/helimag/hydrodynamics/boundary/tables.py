"""A device's resistance near a plane, tabulated over gap and tilt, and looked up again.

What the plane adds to the resistance in open water is averaged over the roll angle and kept in the device's *level
frame*: the body frame rolled about the long axis until the plane's normal lies in its x-z plane, z away from the plane.
"""

import contextlib
import hashlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError
from helimag.hydrodynamics.boundary.cache import folder, kept_at, question
from helimag.hydrodynamics.boundary.device import device_surfaces
from helimag.hydrodynamics.boundary.mesh import Mesh
from helimag.hydrodynamics.boundary.single_layer import galerkin_matrix
from helimag.hydrodynamics.boundary.solve import Plane, resistance_of
from helimag.scenario import Device

Floats = NDArray[np.float64]

GAPS, TILTS = 17, 9  # nodes, the latter on either side of the tilt at which both ends are equally near
ROLLS = 3  # their mean is free of the first two harmonics of the roll angle
LEAST_GAP, MOST_GAP = 0.2, 100.0  # of the device's largest radius, and of that radius too


@dataclass(frozen=True)
class WallTable:
    """What a floor or surface adds to a device's resistance, per viscosity, in the level frame.

    Attributes
    ----------
    kind
        ``"floor"`` or ``"surface"``.
    middle
        Place along x of the device's middle (m).
    gaps
        Between the plane and the nearest point of the device as it rolls (n,), m; evenly spaced in the logarithm.
    tilts
        Of the long axis, nose away from the plane where positive (2, m), rad, evenly spaced: up to the tilt at which
        nose and tail are equally near, and from there on.
    reach
        How much nearer to the plane than the origin the nearest point is (2, m + 2), m.
    values
        The addition times the distance of the device's middle from the plane (2, n + 2, m + 2, 6, 6): it tends to a
        constant far away. This and ``reach`` have one row beyond each end, for the cubic interpolation.
    """

    kind: Literal["floor", "surface"]
    middle: float
    gaps: Floats
    tilts: Floats
    reach: Floats
    values: Floats

    def gap(self, plane: Plane) -> float:
        """Between the plane and the nearest point of the device as it rolls (m); negative where it touches."""
        tilt = math.asin(max(-1.0, min(1.0, plane.normal[0])))
        side, _, weights, first = self._tilt(tilt)
        return plane.distance - float(weights @ self.reach[side, first : first + 4])

    def added(self, plane: Plane) -> Floats:
        """What the plane adds to the resistance per viscosity, body frame, about the origin (6, 6).

        Bicubic (Catmull-Rom) in tilt and in the logarithm of the gap: what the splines of runs are held against,
        see :mod:`helimag.hydrodynamics.boundary.splines`. A gap below the table's least counts as the
        least: lubrication is not resolved. Beyond the largest the addition falls as one over the distance.
        """
        tilt = math.asin(max(-1.0, min(1.0, plane.normal[0])))
        side, inside, across, column = self._tilt(tilt)
        gap = max(self.gap(plane), float(self.gaps[0]))
        reach = float(across @ self.reach[side, column : column + 4])
        row, along = _place(math.log(gap), math.log(self.gaps[0]), math.log(self.gaps[-1]), len(self.gaps))
        patch = self.values[side, row : row + 4, column : column + 4]
        level = np.einsum("r,c,rcij->ij", along, across, patch) / (gap + reach + self.middle * math.sin(inside))
        turn = np.kron(np.eye(2), level_rotation(plane))
        body: Floats = turn.T @ level @ turn
        return body

    def _tilt(self, tilt: float) -> tuple[int, float, Floats, int]:
        """Side of the table, tilt, weights of four columns and the first of them."""
        side = int(tilt > self.tilts[1, 0])
        first, weights = _place(tilt, self.tilts[side, 0], self.tilts[side, -1], self.tilts.shape[1])
        return side, tilt, weights, first


def level_rotation(plane: Plane) -> Floats:
    """From the body frame to the level frame (3, 3)."""
    roll = math.atan2(plane.normal[1], plane.normal[2])
    cos, sin = math.cos(roll), math.sin(roll)
    return np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])


def _place(value: float, low: float, high: float, count: int) -> tuple[int, Floats]:
    """First of four rows around a value, and their weights, on a padded grid of ``count`` nodes from low to high."""
    at = min(max((value - low) / (high - low) * (count - 1), 0.0), count - 1.0)
    row = min(int(at), count - 2)
    t = at - row
    weights = [-0.5 * t + t**2 - 0.5 * t**3, 1.0 - 2.5 * t**2 + 1.5 * t**3]
    weights += [0.5 * t + 2.0 * t**2 - 1.5 * t**3, -0.5 * t**2 + 0.5 * t**3]
    return row, np.array(weights)


def wall_table(device: Device, kind: Literal["floor", "surface"]) -> WallTable:
    """The table of a device near a floor or surface, from the disk where it has been made before.

    It is made on the coarsest surface of the device, a few hundred solutions in some minutes: the addition is a part of
    the resistance, so it need not be as precise as the resistance in open water that it is added to.
    """
    text = f"table {GAPS} {TILTS} {ROLLS} {LEAST_GAP} {MOST_GAP} {kind} {question(device, None)}"
    path = folder() / f"{hashlib.sha256(text.encode()).hexdigest()}.npz"
    made = _read(path, kind)
    if made is not None:
        return made
    rolls = 1 if device.helix is None and device.body is None else ROLLS  # a head looks the same from all sides
    table = make_table(next(device_surfaces(device)), kind, rolls=rolls)
    with contextlib.suppress(FileError, OSError), kept_at(path) as beside, beside.open("wb") as file:
        np.savez(file, middle=table.middle, gaps=table.gaps, tilts=table.tilts, reach=table.reach, values=table.values)
    return table


def _read(path: Path, kind: Literal["floor", "surface"]) -> WallTable | None:
    """The table in a file; None where there is none or it is not whole.

    A sheet's checksum tells what has changed in it; what has changed in the head of one may be anything to a reader.
    """
    try:
        with path.open("rb") as file, np.load(file) as kept:
            return WallTable(kind, float(kept["middle"]), kept["gaps"], kept["tilts"], kept["reach"], kept["values"])
    except (OSError, ValueError, KeyError, EOFError, BadZipFile, RuntimeError):  # or NotImplementedError, a kind of it
        return None


def make_table(
    mesh: Mesh, kind: Literal["floor", "surface"], *, gaps: int = GAPS, tilts: int = TILTS, rolls: int = ROLLS
) -> WallTable:
    """The table of a body with a given surface."""
    x, r = _profile(mesh)
    middle = float(x.min() + x.max()) / 2.0
    largest = float(r.max())
    nodes = np.geomspace(LEAST_GAP * largest, MOST_GAP * largest, gaps)
    turning = _equal_tilt(x, r, middle)
    panels = np.stack([np.linspace(-np.pi / 2.0, turning, tilts), np.linspace(turning, np.pi / 2.0, tilts)])
    ends = x >= middle, x < middle
    reach = np.array(
        [[_reach(x[end], r[end], tilt) for tilt in panel] for end, panel in zip(ends, panels, strict=True)]
    )
    open_water = galerkin_matrix(mesh)
    free = resistance_of(mesh, open_water.copy(), None)
    values = np.empty((2, gaps, tilts, 6, 6))
    for side in range(2):
        for column, tilt in enumerate(panels[side]):
            for row, gap in enumerate(nodes):
                distance = gap + float(reach[side, column])
                added = _mean_over_roll(mesh, open_water, kind, tilt, distance, rolls) - free
                values[side, row, column] = added * (distance + middle * math.sin(tilt))
    return WallTable(kind, middle, nodes, panels, padded(reach, 1), padded(padded(values, 1), 2))


def _mean_over_roll(
    mesh: Mesh, open_water: Floats, kind: Literal["floor", "surface"], tilt: float, distance: float, rolls: int
) -> Floats:
    """Resistance near the plane in the level frame, averaged over the roll angle (6, 6)."""
    total = np.zeros((6, 6))
    for roll in 2.0 * np.pi * np.arange(rolls) / rolls:
        normal = math.sin(tilt), math.cos(tilt) * math.sin(roll), math.cos(tilt) * math.cos(roll)
        plane = Plane(kind, normal, distance)
        turn = np.kron(np.eye(2), level_rotation(Plane(kind, (0.0, math.sin(roll), math.cos(roll)), distance)))
        total += turn @ resistance_of(mesh, open_water.copy(), plane) @ turn.T
    return total / rolls


def _profile(mesh: Mesh) -> tuple[Floats, Floats]:
    """Places along x and distances from the long axis (m) of the surface's corners."""
    corners = mesh.corners.reshape(-1, 3)
    return corners[:, 0], np.hypot(corners[:, 1], corners[:, 2])


def _reach(x: Floats, r: Floats, tilt: float) -> float:
    """How much nearer to a plane than the origin some corners come as the device rolls (m)."""
    return float(np.max(-x * math.sin(tilt) + r * math.cos(tilt)))


def _equal_tilt(x: Floats, r: Floats, middle: float) -> float:
    """The tilt at which the front half reaches as near to a plane as the rear half (rad)."""
    from scipy.optimize import brentq

    nose, tail = x >= middle, x < middle
    turning: float = brentq(
        lambda tilt: _reach(x[nose], r[nose], tilt) - _reach(x[tail], r[tail], tilt), -math.pi / 2.0, math.pi / 2.0
    )
    return turning


def padded(values: Floats, axis: int) -> Floats:
    """The values with one more row beyond each end of an axis, on the parabola through the last three."""
    along = np.moveaxis(values, axis, 0)
    first = 3.0 * along[0] - 3.0 * along[1] + along[2]
    last = 3.0 * along[-1] - 3.0 * along[-2] + along[-3]
    return np.moveaxis(np.concatenate([first[None], along, last[None]]), 0, axis)
