"""Closed surfaces made of flat triangles."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]


@dataclass(frozen=True)
class Mesh:
    """Triangles on one or several closed surfaces.

    Attributes
    ----------
    corners
        Places of the corners of each triangle (n, 3, 3), m; counter-clockwise seen from the fluid.
    part
        Number of the closed surface that each triangle belongs to (n,), from 0.
    """

    corners: Floats
    part: Integers

    @classmethod
    def of(cls, vertices: Floats, faces: Integers) -> "Mesh":
        """One closed surface from vertices (k, 3) and the numbers of each triangle's corners (n, 3)."""
        return cls(vertices[faces], np.zeros(len(faces), dtype=np.intp))

    def __len__(self) -> int:
        return len(self.corners)

    @property
    def centroids(self) -> Floats:
        """Centres of the triangles (n, 3), m."""
        center: Floats = self.corners.mean(axis=1)
        return center

    @property
    def sizes(self) -> Floats:
        """Greatest distance of a corner from the centre (n,), m."""
        farthest: Floats = np.linalg.norm(self.corners - self.centroids[:, None], axis=2).max(axis=1)
        return farthest

    @property
    def area_vectors(self) -> Floats:
        """Outward normals with the length of the area (n, 3), m^2."""
        a, b, c = self.corners.transpose(1, 0, 2)
        return np.cross(b - a, c - a) / 2.0

    @property
    def volumes(self) -> Floats:
        """Volume that each part encloses (m^3), negative where its surface is inside out."""
        cones = np.einsum("ni,ni->n", self.centroids, self.area_vectors) / 3.0
        volumes: Floats = np.bincount(self.part, weights=cones).astype(np.float64)
        return volumes

    @property
    def areas(self) -> Floats:
        """Area of each part's surface (m^2)."""
        areas: Floats = np.bincount(self.part, weights=np.linalg.norm(self.area_vectors, axis=1)).astype(np.float64)
        return areas

    @property
    def heights(self) -> Floats:
        """Least height of each triangle, over its longest edge (n,), m; nought where its corners lie on a line."""
        edges = np.linalg.norm(np.roll(self.corners, -1, axis=1) - self.corners, axis=2)
        heights: Floats = 2.0 * np.linalg.norm(self.area_vectors, axis=1) / edges.max(axis=1)
        return heights

    @property
    def volume(self) -> float:
        """Enclosed volume (m^3)."""
        return float(self.volumes.sum())

    def moved(self, rotation: Floats, shift: Floats) -> "Mesh":
        """The surface turned by a rotation (3, 3), then shifted (3,)."""
        return Mesh(self.corners @ rotation.T + shift, self.part)

    def without(self, dropped: NDArray[np.bool_]) -> "Mesh":
        """The surface without some triangles (n,)."""
        return Mesh(self.corners[~dropped], self.part[~dropped])


def joined(meshes: list[Mesh]) -> Mesh:
    """Several closed surfaces as one body, each part keeping a number of its own."""
    starts = np.concatenate([[0], np.cumsum([mesh.part.max() + 1 for mesh in meshes])[:-1]])
    parts = [mesh.part + start for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(np.concatenate([mesh.corners for mesh in meshes]), np.concatenate(parts))


def bisected(mesh: Mesh, longest: float) -> Mesh:
    """The same surface with every triangle halved across its longest edge until none is longer than ``longest`` (m).

    Neighbours need not match corner to corner: the solver asks for a surface without gaps, not for shared corners.
    """
    done, todo = [], [mesh]
    while todo:
        piece = todo.pop()
        edges = np.linalg.norm(np.roll(piece.corners, -1, axis=1) - piece.corners, axis=2)
        long = edges.max(axis=1) > longest
        done.append(piece.without(long))
        if long.any():
            todo.append(halved(Mesh(piece.corners[long], piece.part[long])))
    return Mesh(np.concatenate([m.corners for m in done]), np.concatenate([m.part for m in done]))


def halved(mesh: Mesh) -> Mesh:
    """The same surface with every triangle cut in two, from the middle of its longest edge to the corner across."""
    edges = np.linalg.norm(np.roll(mesh.corners, -1, axis=1) - mesh.corners, axis=2)
    row, edge = np.arange(len(mesh)), edges.argmax(axis=1)
    a, b, c = (mesh.corners[row, (edge + k) % 3] for k in range(3))
    middle = (a + b) / 2.0
    both = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return Mesh(both, np.tile(mesh.part, 2))


def quartered(mesh: Mesh) -> Mesh:
    """The same surface with every triangle cut into four of its own shape."""
    a, b, c = mesh.corners.transpose(1, 0, 2)
    ab, bc, ca = (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0
    four = [np.stack(corners, axis=1) for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return Mesh(np.concatenate(four), np.tile(mesh.part, 4))
