"""Whether triangles make a closed surface, outside out and free of crossings, and what is wrong where they do not."""

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.hydrodynamics.boundary.mesh import Mesh

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]

SAME = 1e-6  # corners closer than this share of the body's size are one
FLAT = 1e-9  # sine of an angle, below which a line counts as lying in a plane
NAMED = 3  # places named in a message


def checked(corners: Floats, name: str) -> Mesh:
    """The surface that triangles (n, 3, 3) make, each of its closed pieces a part of its own.

    Triangles that are thinner than the distance at which corners are one close gaps between others, as CAD programs
    leave them; they have no surface of their own and are left out.

    Raises
    ------
    InputError
        Where it is open, where neighbours face opposite ways, where it encloses nothing, where it is inside out or
        where triangles cross.
    """
    size = float(np.ptp(corners, axis=(0, 1)).max())
    if not size > 0.0:
        raise InputError(f"{name} encloses nothing: all its corners are at one place")
    faces, vertices = _numbered(corners, SAME * size)
    points = (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2]) | (faces[:, 2] == faces[:, 0])
    faces = faces[~points]
    _check_edges(faces, vertices, name)
    mesh = Mesh(vertices[faces], _pieces(faces, len(vertices)))
    _check_volumes(mesh, name)
    thin = mesh.heights < SAME * size
    mesh, faces = mesh.without(thin), faces[~thin]
    _check_crossings(mesh, faces, name)
    return mesh


def _numbered(corners: Floats, grid: float) -> tuple[Integers, Floats]:
    """Numbers of each triangle's corners (n, 3) and their places (k, 3), corners at one place having one number."""
    flat = corners.reshape(-1, 3)
    _, first, number = np.unique(np.round(flat / grid).astype(np.int64), axis=0, return_index=True, return_inverse=True)
    return number.reshape(-1, 3).astype(np.intp), flat[first]


def _check_edges(faces: Integers, vertices: Floats, name: str) -> None:
    """Every edge must be met once in each direction."""
    ways = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges, counts = np.unique(np.sort(ways, axis=1), axis=0, return_counts=True)
    if np.any(counts == 1):
        raise InputError(f"{name} is open: {_places(edges[counts == 1], vertices)} belong to one triangle only")
    if np.any(counts > 2):
        raise InputError(f"{name} is no single surface: {_places(edges[counts > 2], vertices)} belong to three or more")
    directed, times = np.unique(ways, axis=0, return_counts=True)
    if np.any(times > 1):
        where = _places(directed[times > 1], vertices)
        raise InputError(f"{name} is partly inside out: at {where} neighbours face opposite ways")


def _check_volumes(mesh: Mesh, name: str) -> None:
    """Every piece must enclose something, outside out; a cavity is no part of what the fluid sees."""
    volumes, areas = mesh.volumes, mesh.areas
    if not (len(mesh) and np.all(abs(volumes) > FLAT * areas**1.5)):
        raise InputError(f"{name} encloses nothing: its faces lie on each other; give it a thickness")
    if np.all(volumes < 0.0):
        raise InputError(
            f"{name} is inside out: it encloses {mesh.volume:.3g} m^3; reverse the order of every triangle's corners"
        )
    if np.any(volumes < 0.0):
        worst = int(volumes.argmin())
        what = f"{np.sum(mesh.part == worst)} triangles around {abs(volumes[worst]):.3g} m^3"
        raise InputError(
            f"{name} has {volumes.size} pieces, and one is inside out ({what}); "
            "reverse the order of its corners, or leave it out where it is a cavity"
        )


def _places(edges: Integers, vertices: Floats) -> str:
    """How many edges there are, and where the first few lie."""
    middles = vertices[edges].mean(axis=1)
    some = "; ".join("({:.4g}, {:.4g}, {:.4g})".format(*(1e3 * place)) for place in middles[:NAMED])
    return f"{len(edges)} edges (the first near {some} mm)"


def _pieces(faces: Integers, vertices: int) -> Integers:
    """Number of the connected piece of each triangle (n,)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ways = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_matrix((np.ones(len(ways)), (ways[:, 0], ways[:, 1])), shape=(vertices, vertices))
    _, label = connected_components(graph, directed=False)
    _, part = np.unique(label[faces[:, 0]], return_inverse=True)
    return part.astype(np.intp)


def _check_crossings(mesh: Mesh, faces: Integers, name: str) -> None:
    """No edge may pass through a triangle that it shares no corner with."""
    from scipy.spatial import cKDTree

    radius = 2.0 * float(mesh.sizes.max())
    pairs = cKDTree(mesh.centroids).query_pairs(radius, output_type="ndarray")
    gap = np.linalg.norm(mesh.centroids[pairs[:, 0]] - mesh.centroids[pairs[:, 1]], axis=1)
    pairs = pairs[gap < mesh.sizes[pairs].sum(axis=1)]
    apart = np.all(faces[pairs[:, 0]][:, :, None] != faces[pairs[:, 1]][:, None, :], axis=(1, 2))
    pairs = pairs[apart]
    crossing = _pierced(mesh.corners[pairs[:, 0]], mesh.corners[pairs[:, 1]])
    crossing |= _pierced(mesh.corners[pairs[:, 1]], mesh.corners[pairs[:, 0]])
    if np.any(crossing):
        places = mesh.centroids[pairs[crossing][:, 0]][:NAMED]
        some = "; ".join("({:.4g}, {:.4g}, {:.4g})".format(*(1e3 * place)) for place in places)
        raise InputError(f"{name} crosses itself: {crossing.sum()} pairs of triangles do (the first near {some} mm)")


def _pierced(triangles: Floats, others: Floats) -> NDArray[np.bool_]:
    """Whether an edge of the other triangle passes through each triangle (n,)."""
    found = np.zeros(len(triangles), dtype=np.bool_)
    for k in range(3):
        start, way = others[:, k], others[:, (k + 1) % 3] - others[:, k]
        found |= _hit(triangles, start, way)
    return found


def _hit(triangles: Floats, start: Floats, way: Floats) -> NDArray[np.bool_]:
    """Whether the way from a start crosses each triangle (T. Moeller and B. Trumbore, J. Graph. Tools 2 (1997) 21)."""
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(way, second)
    spread = np.einsum("ni,ni->n", first, across)
    size = [np.linalg.norm(vector, axis=1) for vector in (first, second, way)]
    parallel = np.abs(spread) <= FLAT * size[0] * size[1] * size[2]  # touching neighbours in one plane do not cross
    scale = 1.0 / np.where(parallel, 1.0, spread)
    from_corner = start - triangles[:, 0]
    u = scale * np.einsum("ni,ni->n", from_corner, across)
    turned = np.cross(from_corner, first)
    v = scale * np.einsum("ni,ni->n", way, turned)
    t = scale * np.einsum("ni,ni->n", second, turned)
    hit: NDArray[np.bool_] = ~parallel & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t >= 0.0) & (t <= 1.0)
    return hit
