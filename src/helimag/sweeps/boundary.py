"""Where the verdict changes, over two axes: which points to run next, and how well the boundary is known.

The points run so far are joined to triangles (Delaunay). An edge between two runs that differ has the change somewhere
on it, so its middle is worth a run, the longest edges first. Differing means: inside and outside of the wanted verdict;
or, both outside, lost upwards and lost downwards, since a band of bounded runs between them can be narrower than any
grid. Part of the runs goes to edges whose ends agree, the sooner the longer they are and the later their ends were
lost, since that is where bands hide that no pair of runs straddles.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from helimag.outcomes import Verdict

if TYPE_CHECKING:
    import xarray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

ROUND = 32  # points chosen at a time: each round knows the results of the one before
EXPLORE = 0.25  # of a round goes to edges whose ends agree
COARSEST = 3.0  # resolutions: edges whose ends agree are not cut below this
STRADDLE = 0.6  # weight of an edge from lost upwards to lost downwards, beside one that crosses the boundary


@dataclass(frozen=True)
class Seen:
    """Results at points (n, 2) of the unit square: the wanted verdict or not, up or down, how long it held."""

    points: Floats
    inside: Mask
    rises: Mask
    held: Floats  # share of the duration before the device was lost


def start_points(counts: tuple[int, int], total: int) -> Floats:
    """The coarse grid, filled up to a multiple of :data:`ROUND` by a Sobol sequence: (n, 2), at most ``total``."""
    from scipy.stats import qmc

    x, y = (np.linspace(0.0, 1.0, count) for count in counts)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    rest = -len(grid) % ROUND
    more = np.asarray(qmc.Sobol(2, rng=0).random_base2(5))[:rest]
    return np.concatenate([grid, more])[:total]


def next_points(seen: Seen, count: int, resolution: float) -> Floats:
    """Up to ``count`` new points (n, 2) of the unit square; none where all is resolved."""
    edges = _edges(seen.points)
    first, second = edges.T
    length = np.linalg.norm(seen.points[first] - seen.points[second], axis=1)
    crossing = seen.inside[first] != seen.inside[second]
    straddling = ~seen.inside[first] & ~seen.inside[second] & (seen.rises[first] != seen.rises[second])
    urgent = np.where(crossing, length, STRADDLE * length) * ((crossing | straddling) & (length > resolution))
    held = (seen.held[first] + seen.held[second]) / 2.0
    idle = length * (0.25 + held) * (~(crossing | straddling) & (length > COARSEST * resolution))
    middles = (seen.points[first] + seen.points[second]) / 2.0
    chosen: list[Floats] = []
    _take(chosen, middles, urgent, length, count - int(EXPLORE * count))
    _take(chosen, middles, idle, length, count)
    _take(chosen, middles, urgent, length, count)
    return np.array(chosen).reshape(-1, 2)


def _take(chosen: list[Floats], middles: Floats, score: Floats, length: Floats, count: int) -> None:
    """Add the middles of the best edges until there are ``count``, none close to another for the length of its edge."""
    for i in np.argsort(-score, kind="stable"):
        if len(chosen) >= count or score[i] <= 0.0:
            return
        if not chosen or np.linalg.norm(np.array(chosen) - middles[i], axis=1).min() > 0.4 * length[i]:
            chosen.append(middles[i])


def _edges(points: Floats) -> NDArray[np.int64]:
    """Edges of the Delaunay triangulation, each once, in a fixed order: (m, 2)."""
    from scipy.spatial import Delaunay

    simplices = Delaunay(points).simplices
    pairs = np.concatenate([simplices[:, [0, 1]], simplices[:, [1, 2]], simplices[:, [0, 2]]])
    return np.unique(np.sort(pairs, axis=1), axis=0).astype(np.int64)


@dataclass(frozen=True)
class BoundaryLine:
    """The boundary of a verdict: points (n, 2) in SI halfway between two runs that differ, and half that way as error.

    ``gap`` (2,) is the largest extent of an edge whose ends agree: a smaller patch of its own may be missed.
    """

    names: tuple[str, str]
    points: Floats
    error: Floats
    gap: Floats

    @property
    def median_error(self) -> Floats:
        """Median error along each axis (SI): (2,); not a number where there is no boundary."""
        return np.median(self.error, axis=0) if len(self.error) else np.full(2, np.nan)

    @property
    def largest_error(self) -> Floats:
        """Largest error along each axis (SI): (2,)."""
        return self.error.max(axis=0) if len(self.error) else np.full(2, np.nan)


def boundary_line(dataset: "xarray.Dataset", verdict: str = "bounded") -> BoundaryLine:
    """The boundary of a verdict over the two axes of a sweep, from neighbouring runs that differ.

    Parameters
    ----------
    dataset
        A sweep over two axes, on a grid or with points chosen by a plan's [boundary].
    verdict
        Whose boundary.

    Returns
    -------
    BoundaryLine
        Points (n, 2) half way between such runs, and their errors, SI.
    """
    names, points, flags = flat_points(dataset)
    spans = np.ptp(points, axis=0)
    first, second = _edges(points / spans).T
    inside = flags == Verdict.of(verdict)
    crossing = inside[first] != inside[second]
    extent = np.abs(points[first] - points[second])
    return BoundaryLine(
        names=names,
        points=(points[first] + points[second])[crossing] / 2.0,
        error=extent[crossing] / 2.0,
        gap=extent[~crossing].max(axis=0, initial=0.0),
    )


def flat_points(dataset: "xarray.Dataset") -> tuple[tuple[str, str], Floats, NDArray[np.int8]]:
    """Names of a sweep's two axes, its computed points (n, 2) in SI and their verdicts (n,).

    Raises
    ------
    InputError
        Where the sweep has not two axes.
    """
    from helimag.errors import InputError
    from helimag.sweeps.export import axis_names

    names = axis_names(dataset)
    if len(names) != 2:
        raise InputError(f"a boundary is drawn over two axes; this sweep has {', '.join(names)}")
    columns: list[Any] = [dataset[name].broadcast_like(dataset["verdict"]).values.ravel() for name in names]
    flags = dataset["verdict"].values.ravel()
    known = flags != Verdict.NOT_COMPUTED
    return (names[0], names[1]), np.stack(columns, axis=1)[known].astype(float), flags[known]
