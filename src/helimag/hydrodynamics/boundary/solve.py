"""From a surface to its 6x6 resistance."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.hydrodynamics.boundary.kernels import floor_image, surface_image
from helimag.hydrodynamics.boundary.mesh import Mesh
from helimag.hydrodynamics.boundary.single_layer import galerkin_matrix, image_matrix
from helimag.hydrodynamics.resistive_force import cross_matrices

Floats = NDArray[np.float64]

MOST = 4600  # triangles: a matrix of 1.5 GB
EASE = 3e-4  # share of the mean velocity of a triangle under its own force
IMAGES = {"floor": floor_image, "surface": surface_image}


@dataclass(frozen=True)
class Plane:
    """A flat boundary of the fluid, seen from the body.

    Attributes
    ----------
    kind
        ``"floor"`` does not let the fluid slip, ``"surface"`` is flat and free of stress.
    normal
        Unit vector from the plane into the fluid, body frame.
    distance
        Of the body's origin from the plane (m).
    """

    kind: Literal["floor", "surface"]
    normal: tuple[float, float, float]
    distance: float

    @property
    def rotation(self) -> Floats:
        """From the body frame to one whose z is the normal (3, 3)."""
        normal = np.array(self.normal)
        helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
        first = np.cross(helper, normal)
        first /= np.linalg.norm(first)
        return np.stack([first, np.cross(normal, first), normal])


def surface_resistance(mesh: Mesh, plane: Plane | None = None) -> Floats:
    """6x6 resistance per viscosity of a rigid body with this surface, translation first, about the origin.

    Forces spread evenly over each triangle are chosen such that every triangle's mean velocity is that of the rigid
    motion (Galerkin's method on the single layer, first kind). A part of the surface may lie inside the body.

    Parameters
    ----------
    mesh
        The surface, body frame.
    plane
        A floor or surface beside the body; open water without.

    Returns
    -------
    (6, 6)
        Symmetric positive definite: ``U' G^-1 U`` with G factored by Cholesky. Units m, m^2, m^3.

    Raises
    ------
    InputError
        Where the body reaches through the plane, or its triangles are so thin that G is not positive definite.
    """
    return resistance_of(mesh, galerkin_matrix(mesh), plane)


def resistance_of(mesh: Mesh, open_water: Floats, plane: Plane | None) -> Floats:
    """As `surface_resistance`, from the surface's matrix in open water (3, n, 3, n), which is used up."""
    if plane is None:
        return _solved(mesh, open_water)
    turn = plane.rotation
    above = mesh.moved(turn, np.array([0.0, 0.0, plane.distance]))
    lowest = float(above.corners[:, :, 2].min())
    if not lowest > 0.0:
        raise InputError(
            f"the device reaches {-lowest:.3g} m through the {plane.kind}; its origin, {plane.distance:.3g} m away, "
            "must be farther from it"
        )
    image = image_matrix(above, IMAGES[plane.kind])
    for a in range(3):
        for b in range(3):
            for c in range(3):
                for d in range(3):
                    open_water[a, :, b, :] += turn[c, a] * turn[d, b] * image[c, :, d, :]
    return _solved(mesh, open_water)


def _solved(mesh: Mesh, velocities: Floats) -> Floats:
    from scipy.linalg import LinAlgError, cho_factor, cho_solve

    count = len(mesh)
    motion = np.concatenate([np.broadcast_to(np.eye(3), (count, 3, 3)), -cross_matrices(mesh.centroids)], axis=2)
    motion = motion.transpose(1, 0, 2).reshape(3 * count, 6)
    matrix = velocities.reshape(3 * count, 3 * count)
    _stiffen(matrix, mesh)
    try:
        factor = cho_factor(matrix, overwrite_a=True, check_finite=False)
    except LinAlgError:
        raise InputError(
            f"the body's {count} surface triangles are too thin or too unequal to solve for; give a more even mesh"
        ) from None
    forces = cho_solve(factor, motion, check_finite=False)
    resistance = 8.0 * np.pi * motion.T @ forces
    symmetric: Floats = (resistance + resistance.T) / 2.0
    return symmetric


def _stiffen(matrix: Floats, mesh: Mesh) -> None:
    """Give a uniform pressure inside each closed part, which moves nothing, an energy of its own.

    No rigid motion does work on it, so the resistance does not change; without it the matrix is singular. A pressure
    that changes slowly along a long tube is hardly better: for it every force gets a little more of its own triangle's
    motion, which changes the resistance by some parts in 100,000, and by less on finer surfaces.
    """
    level = np.trace(matrix) / len(matrix)
    matrix[np.diag_indices_from(matrix)] += EASE * level
    for part in range(mesh.part.max() + 1):
        pressure = (mesh.area_vectors * (mesh.part == part)[:, None]).T.ravel()
        size = np.linalg.norm(pressure)
        if size > 0.0:
            pressure /= size
            for row in np.flatnonzero(pressure):
                matrix[row] += level * pressure[row] * pressure
