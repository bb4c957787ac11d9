"""Mean velocities of triangles under forces spread evenly over triangles: the Galerkin matrix of a single layer.

The matrix is a table of energies, ``f' G f`` being what the forces f dissipate, and therefore symmetric and, but for
the uniform pressure inside each closed surface, positive.
"""

import numpy as np
from numpy.typing import NDArray

from helimag.hydrodynamics.boundary.kernels import ImageKernel, stokeslet
from helimag.hydrodynamics.boundary.mesh import Mesh
from helimag.hydrodynamics.boundary.triangles import SIX, THREE, TWELVE, TWENTY_FOUR, Rule, stokeslet_mean

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]

NEAR = 2.0  # triangles closer than this many times the sum of their sizes are integrated in closed form
CLOSE = 1.0  # as above: only these can touch
ENTRIES = 1 << 16  # pairs at a time: what a processor's cache holds
NEAR_PAIRS = 20_000  # at a time
IMAGE_PAIRS = 1_000  # at a time


def galerkin_matrix(mesh: Mesh) -> Floats:
    """Velocity per force, times 8 pi mu (1/m): entry [a, i, b, j] is component a on triangle i, force b on triangle j.

    Far pairs by 3 x 3 Gauss points; near ones in closed form over the one triangle and 6 points on the other, 24 where
    they may touch, both ways round.

    Parameters
    ----------
    mesh
        n triangles in open water.

    Returns
    -------
    (3, n, 3, n)
        Symmetric to the last bit.
    """
    count = len(mesh)
    matrix = np.empty((3, count, 3, count))
    rows = max(1, ENTRIES // count)
    for start in range(0, count, rows):
        _fill_far(matrix, mesh, slice(start, min(count, start + rows)))
    one, other, close = near_pairs(mesh)
    for which, rule in ((~close, SIX), (close, TWENTY_FOUR)):
        first, second = one[which], other[which]
        for start in range(0, len(first), NEAR_PAIRS):
            piece = slice(start, start + NEAR_PAIRS)
            _fill_near(matrix, mesh.corners, first[piece], second[piece], rule)
    return matrix


def image_matrix(mesh: Mesh, image: ImageKernel) -> Floats:
    """What a plane at z = 0 adds to `galerkin_matrix` of a surface at z > 0.

    By 3 x 3 Gauss points, by 12 x 12 where a triangle is as near to another's mirror image as to a neighbour: that
    serves down to gaps of about a quarter of a triangle's size.
    """
    count = len(mesh)
    matrix = np.empty((3, count, 3, count))
    rows = max(1, ENTRIES // count)
    for start in range(0, count, rows):
        _fill_image(matrix, mesh, slice(start, min(count, start + rows)), image)
    one, other = _near_images(mesh)
    for start in range(0, len(one), IMAGE_PAIRS):
        piece = slice(start, start + IMAGE_PAIRS)
        _refine_image(matrix, mesh.corners, one[piece], other[piece], image)
    return matrix


def near_pairs(mesh: Mesh) -> tuple[Integers, Integers, NDArray[np.bool_]]:
    """Numbers of the triangles of each near pair, the first not the greater, and whether they may touch.

    A triangle is near itself.
    """
    from scipy.spatial import cKDTree

    centroids, sizes = mesh.centroids, mesh.sizes
    pairs = cKDTree(centroids).query_pairs(2.0 * NEAR * float(sizes.max()), output_type="ndarray")
    gap = np.linalg.norm(centroids[pairs[:, 0]] - centroids[pairs[:, 1]], axis=1)
    share = gap / sizes[pairs].sum(axis=1)
    itself = np.arange(len(mesh))
    pairs = np.concatenate([np.stack([itself, itself], axis=1), pairs[share < NEAR]])
    close = np.concatenate([np.ones(len(mesh), dtype=np.bool_), share[share < NEAR] < CLOSE])
    return pairs[:, 0], pairs[:, 1], close


def _fill_far(matrix: Floats, mesh: Mesh, rows: slice) -> None:
    """Rows of the matrix from the diagonal on, and their mirror images."""
    places, weights = THREE
    spots = np.einsum("qk,nki->qin", places, mesh.corners)
    total = np.zeros((6, rows.stop - rows.start, len(mesh) - rows.start))
    upper = [(a, b) for a in range(3) for b in range(a, 3)]
    for p, here in zip(weights, spots, strict=True):
        for q, there in zip(weights, spots, strict=True):
            tensor = stokeslet(*(here[k, rows, None] - there[k, None, rows.start :] for k in range(3)))
            for k, (a, b) in enumerate(upper):
                total[k] += p * q * tensor[a][b]
    inside = total[:, :, : rows.stop - rows.start]  # has both orders of a pair: their mean is symmetric to the last bit
    inside += inside.transpose(0, 2, 1).copy()
    inside /= 2.0
    for k, (a, b) in enumerate(upper):
        for c, d in {(a, b), (b, a)}:
            matrix[c, rows, d, rows.start :] = total[k]
            matrix[c, rows.start :, d, rows] = total[k].T


def _fill_near(matrix: Floats, corners: Floats, one: Integers, other: Integers, rule: Rule) -> None:
    block = np.zeros((len(one), 3, 3))
    for place, weight in zip(*rule, strict=True):
        block += weight / 2.0 * stokeslet_mean(place @ corners[one], corners[other])
        block += weight / 2.0 * stokeslet_mean(place @ corners[other], corners[one])
    block = (block + block.transpose(0, 2, 1)) / 2.0
    for a in range(3):
        for b in range(3):
            matrix[a, one, b, other] = block[:, a, b]
            matrix[a, other, b, one] = block[:, a, b]


def _fill_image(matrix: Floats, mesh: Mesh, rows: slice, image: ImageKernel) -> None:
    """Rows of the plane's part from the diagonal on, and their mirror images."""
    places, weights = THREE
    spots = np.einsum("qk,nki->qin", places, mesh.corners)
    columns = slice(rows.start, None)
    inside = rows.stop - rows.start
    total = np.zeros((3, 3, inside, len(mesh) - rows.start))
    for p, here in zip(weights, spots, strict=True):
        for q, there in zip(weights, spots, strict=True):
            x, y = (here[k, rows, None] - there[k, None, columns] for k in range(2))
            tensor = image(x, y, here[2, rows, None], there[2, None, columns])
            for a in range(3):
                for b in range(3):
                    total[a, b] += p * q * tensor[a][b]
    square = total[:, :, :, :inside]  # as for the far pairs
    square += square.transpose(1, 0, 3, 2).copy()
    square /= 2.0
    for a in range(3):
        for b in range(3):
            matrix[a, rows, b, columns] = total[a, b]
            matrix[b, rows.stop :, a, rows] = total[a, b, :, inside:].T


def _near_images(mesh: Mesh) -> tuple[Integers, Integers]:
    """Numbers of triangles of which one is near the mirror image of the other, the first not the greater."""
    from scipy.spatial import cKDTree

    sizes, centroids = mesh.sizes, mesh.centroids
    mirrored = centroids * np.array([1.0, 1.0, -1.0])
    found = cKDTree(centroids).query_ball_point(mirrored, NEAR * (sizes + float(sizes.max())))
    other = np.repeat(np.arange(len(mesh)), [len(near) for near in found])
    one = np.concatenate([np.array(near, dtype=np.intp) for near in found])
    gap = np.linalg.norm(centroids[one] - mirrored[other], axis=1)
    near_pair = (one <= other) & (gap < NEAR * (sizes[one] + sizes[other]))
    return one[near_pair], other[near_pair]


def _refine_image(matrix: Floats, corners: Floats, one: Integers, other: Integers, image: ImageKernel) -> None:
    """The plane's part of some pairs anew, by 12 x 12 points."""
    here, there = (np.einsum("qk,nki->nqi", TWELVE[0], corners[which]) for which in (one, other))
    x, y = (here[:, :, None, k] - there[:, None, :, k] for k in range(2))
    tensor = image(x, y, here[:, :, None, 2], there[:, None, :, 2])
    block = np.array([[entry.mean(axis=(1, 2)) for entry in row] for row in tensor])
    itself = one == other
    block[:, :, itself] = (block + block.transpose(1, 0, 2))[:, :, itself] / 2.0
    for a in range(3):
        for b in range(3):
            matrix[a, one, b, other] = block[a, b]
            matrix[b, other, a, one] = block[a, b]
