"""The joint fit of lenses, extrinsics, walls, indices and boards to all pictures, in air and in the tank."""

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.vision.calibration.pictures import Found
from helimag.vision.calibration.placements import Pose
from helimag.vision.calibration.session import Session
from helimag.vision.calibration.shared_errors import excess, widening
from helimag.vision.cameras import Camera, Rig
from helimag.vision.refraction import Wall

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

INDEX_RANGE = (1.05, 1.9)  # of liquids, with room for a wrong first guess
LENS = 8  # fx, fy, cx, cy, k1, k2, p1, p2 of a camera
SECOND, WALLS, INDEX = 2 * LENS, 2 * LENS + 6, 2 * LENS + 12
WALL_INDEX, THICKNESS, BOARDS = INDEX + 1, INDEX + 2, INDEX + 4
UNTOLD = (WALL_INDEX, THICKNESS, THICKNESS + 1)  # by pictures: walls that lie elsewhere look nearly the same
ROBUST = 0.5  # px from which a corner counts less
ROUNDS = 40  # of Levenberg and Marquardt's method; from a good start it needs 4 to 8
SETTLED = 1e-6  # share of the cost that a round must still gain
STUCK = 1e8  # damping beyond which no step helps
SPREAD_OF_MEDIAN = 1.4826  # standard deviation of normal noise over the median of its size
OUTLYING = 5.0  # standard deviations from which a corner does not count
STEP = 1e-7  # of the differences, relative to a parameter's size


class Corners(NamedTuple):
    """All corners of one camera in one medium: board frame (n, 3) in m, picture (n,), pixels (n, 2)."""

    view: int
    medium: str
    points: Floats
    picture: NDArray[np.int64]
    pixels: Floats


class Given(NamedTuple):
    """Values that are measured by other means: their places (k,), the values, and their weights (px a unit)."""

    places: NDArray[np.int64]
    values: Floats
    weights: Floats

    def off(self, values: Floats) -> Floats:
        """By how much a fit's values are off what is given (k,), in px."""
        return np.asarray(self.weights * (values[self.places] - self.values))


@dataclass(frozen=True)
class Fitted:
    """Values that fit best, their covariance, residuals (px), and which of those counted."""

    values: Floats
    covariance: Floats
    residuals: Floats
    counted: Flags

    @property
    def noise(self) -> float:
        """Of a corner's coordinate (px, standard deviation)."""
        return float(np.std(self.residuals[self.counted]))

    def clean(self) -> Flags:
        """Residuals of corners that lie where corners with the usual noise lie; blur and glare move some further."""
        pairs = np.abs(self.residuals.reshape(-1, 2)).max(axis=1)
        usual = SPREAD_OF_MEDIAN * float(np.median(np.abs(self.residuals)))
        return np.repeat(pairs < OUTLYING * usual, 2)

    def spread(self, place: int) -> float:
        """Standard deviation of one value."""
        return float(np.sqrt(max(self.covariance[place, place], 0.0)))


class Joint:
    """The fit, in the first camera's frame: [two lenses | second camera 6 | walls 2 x 3 | oil's index | walls' index |
    walls' two thicknesses | boards 6 each].

    Thicknesses and the walls' index count as measured once, since pictures hardly tell them. A wall is (lean x, lean y,
    distance) in its own camera's frame: its normal is along (lean x, lean y, 1). The board of a picture that one camera
    took alone is in that camera's frame.
    """

    def __init__(self, session: Session, found: Found, cameras: tuple[Camera, Camera], names: dict[str, list[str]]):
        self.session = session
        self.cameras = cameras
        self.pictures: list[tuple[str, str, tuple[int, ...]]] = [
            (kind, name, (0, 1)) for kind in ("air", "oil") for name in names[kind]
        ]
        for view in (0, 1):
            alone = sorted(set(found[view]["air"]) - set(names["air"]))
            self.pictures += [("air", name, (view,)) for name in alone]
        self.groups = [self._group(found, view, medium) for view in (0, 1) for medium in ("air", "oil")]
        sizes = np.cumsum([0] + [2 * group.pixels.shape[0] for group in self.groups])
        self.rows = [slice(int(a), int(b)) for a, b in itertools.pairwise(sizes)]

    @cached_property
    def picture(self) -> NDArray[np.int64]:
        """Number of the picture that each residual is of."""
        return np.concatenate([np.repeat(group.picture, 2) for group in self.groups])

    @cached_property
    def in_oil(self) -> Flags:
        """Residuals of pictures in the tank: (2 x corners,)."""
        return np.concatenate([np.full(2 * group.pixels.shape[0], group.medium == "oil") for group in self.groups])

    def widened(self, fitted: Fitted) -> tuple[Fitted, float]:
        """A fit with a covariance that allows for errors which the corners of one picture share, and by how much; and
        for a datum that is seen less sharply than the other pictures."""
        counted = fitted.counted
        jacobian, residuals = self.jacobian(fitted.values)[counted], fitted.residuals[counted]
        picture = self.picture[counted]
        factor = widening(np.delete(jacobian, UNTOLD, axis=1), residuals, picture, BOARDS - len(UNTOLD))
        covariance = fitted.covariance * factor
        datum, rows = self.datum(), picture == (self.datum().start - BOARDS) // 6
        covariance[datum, datum] += excess(jacobian[rows, datum], residuals[rows], factor * fitted.noise**2)
        return replace(fitted, covariance=covariance), factor

    def _group(self, found: Found, view: int, medium: str) -> Corners:
        points, picture, pixels = [], [], []
        for index, (kind, name, views) in enumerate(self.pictures):
            if kind == medium and view in views:
                numbers, seen = found[view][kind][name]
                points.append(self.session.board.corners[numbers])
                picture.append(np.full(numbers.size, index))
                pixels.append(seen)
        return Corners(view, medium, np.concatenate(points), np.concatenate(picture), np.concatenate(pixels))

    def camera(self, values: Floats, view: int) -> Camera:
        """With the lens and the wall that the values say, in its own frame."""
        fx, fy, cx, cy, *bent = values[LENS * view : LENS * (view + 1)]
        matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
        lean_x, lean_y, distance = values[WALLS + 3 * view : WALLS + 3 * view + 3]
        normal = np.array([lean_x, lean_y, 1.0]) / np.sqrt(1.0 + lean_x**2 + lean_y**2)
        indices = (self.session.indices[0], float(values[WALL_INDEX]), float(values[INDEX]))
        wall = Wall(distance * normal, normal, float(values[THICKNESS + view]), indices)
        return replace(self.cameras[view], matrix=matrix, distortion=np.array([*bent, 0.0]), wall=wall)

    def residuals(self, values: Floats) -> Floats:
        """Pixels by which the corners are seen beside where they should be: (2 x corners,)."""
        second = Pose.from_six(values[SECOND : SECOND + 6])
        boards = Pose.many(values[BOARDS:].reshape(-1, 6))
        alone = np.array([len(views) == 1 for _, _, views in self.pictures])
        parts = []
        for view, medium, points, picture, pixels in self.groups:
            local = np.einsum("nij,nj->ni", boards[0][picture], points) + boards[1][picture]
            if view == 1:
                local = np.where(alone[picture][:, None], local, second.of(local))
            camera = self.camera(values, view)
            seen = (camera if medium == "oil" else replace(camera, wall=None)).project(local)
            parts.append((seen - pixels).ravel())
        return np.nan_to_num(np.concatenate(parts), nan=1e3)

    def jacobian(self, values: Floats) -> Floats:
        """By differences; a board's pose moves its own picture only, so all boards are moved at once."""
        base = self.residuals(values)
        jacobian = np.zeros((base.size, values.size))
        picture = self.picture
        rows = np.arange(base.size)
        for column in range(BOARDS):
            moved = values.copy()
            step = STEP * max(1.0, abs(values[column]))
            moved[column] += step
            jacobian[:, column] = (self.residuals(moved) - base) / step
        for column in range(6):
            moved = values.copy()
            moved[BOARDS + column :: 6] += STEP
            jacobian[rows, BOARDS + 6 * picture + column] = (self.residuals(moved) - base) / STEP
        return jacobian

    def fit(
        self, start: Floats, *, counted: Flags | None = None, oil_known: bool = False, noise: float = 0.1
    ) -> Fitted:
        """Least squares from a start, with what the session gives of the walls, and where known of the oil's index.

        Parameters
        ----------
        counted
            Residuals that count; default all.
        noise
            Of a corner (px), with which what is given is weighed against the corners.
        """
        given = self._given(oil_known, noise)
        values, residuals = start, self.residuals(start)
        count = np.ones(residuals.size, bool) if counted is None else counted

        def total(values: Floats, residuals: Floats) -> float:
            return _cost(residuals[count]) + 0.5 * float(np.sum(given.off(values) ** 2))

        damping, cost = 1e-4, total(values, residuals)
        for _ in range(ROUNDS):
            scaled, slope, size = self._linear(values, residuals, count, given)
            gained = 0.0
            while damping < STUCK and gained == 0.0:
                step = -size * np.linalg.solve(scaled + damping * np.eye(size.size), size * slope)
                tried = values + step
                tried[[INDEX, WALL_INDEX]] = np.clip(tried[[INDEX, WALL_INDEX]], *INDEX_RANGE)
                tried[THICKNESS : THICKNESS + 2] = np.maximum(tried[THICKNESS : THICKNESS + 2], 0.0)
                fresh = self.residuals(tried)
                lower = total(tried, fresh)
                damping *= 0.1 if lower < cost else 10.0
                if lower < cost:
                    gained, cost = (cost - lower) / cost, lower
                    values, residuals = tried, fresh
            if gained < SETTLED:
                break
        freedom = max(1, int(count.sum()) - size.size)
        inverse = np.linalg.pinv(scaled, rcond=1e-14, hermitian=True) * np.outer(size, size)
        return Fitted(values, inverse * 2.0 * cost / freedom, residuals, count)

    def _given(self, oil_known: bool, noise: float) -> Given:
        """What the session gives of walls and oil, weighed against corners with a noise (px)."""
        session = self.session
        places = [*UNTOLD] + [INDEX] * oil_known
        values = [session.indices[1], session.thickness, session.thickness, session.indices[2]]
        sds = [session.index_sds[0], session.thickness_sd, session.thickness_sd, session.index_sds[1]]
        count = len(places)
        return Given(np.array(places), np.array(values[:count]), noise / np.array(sds[:count]))

    def _linear(self, values: Floats, residuals: Floats, counted: Flags, given: Given) -> tuple[Floats, Floats, Floats]:
        """Normal matrix scaled to a diagonal of ones, slope of the cost, and the scales: columns differ by nine
        orders."""
        trust = counted / np.sqrt(1.0 + (residuals / ROBUST) ** 2)
        jacobian = self.jacobian(values)
        normal = jacobian.T @ (jacobian * trust[:, None])
        slope = jacobian.T @ (trust * residuals)
        normal[given.places, given.places] += given.weights**2
        slope[given.places] += given.weights * given.off(values)
        size = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-30))
        return normal * np.outer(size, size), slope, size

    def rms(self, fitted: Fitted, view: int, medium: str | None = None) -> float:
        """Root mean square distance (px) between a camera's corners that counted and where they should be."""
        squares = [
            fitted.residuals[rows][fitted.counted[rows]] ** 2
            for group, rows in zip(self.groups, self.rows, strict=True)
            if group.view == view and medium in (None, group.medium)
        ]
        return float(np.sqrt(2.0 * np.mean(np.concatenate(squares))))

    def datum(self) -> slice:
        """Where the datum board's pose is among the values."""
        at = BOARDS + 6 * self.pictures.index(("oil", self.session.datum, (0, 1)))
        return slice(at, at + 6)

    def rig(self, values: Floats, lab: Pose) -> Rig:
        """The rig in the lab frame, which the datum fixes."""
        first = Pose.from_six(values[self.datum()]).after(lab.inverse)
        poses = (first, Pose.from_six(values[SECOND : SECOND + 6]).after(first))
        cameras = []
        for view, pose in enumerate(poses):
            camera = self.camera(values, view)
            wall = camera.wall or Wall(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.0)
            to_lab = pose.inverse
            normal = to_lab.rotation @ wall.normal
            placed = replace(wall, point=to_lab.of(wall.point), normal=normal / np.linalg.norm(normal))
            cameras.append(replace(camera, rotation=pose.rotation, translation=pose.translation, wall=placed))
        return Rig((cameras[0], cameras[1]), self.session.tank)


def _cost(residuals: Floats) -> float:
    """Half the sum of squares, of which large ones count like their size only (soft L1)."""
    return float(np.sum(ROBUST**2 * (np.sqrt(1.0 + (residuals / ROBUST) ** 2) - 1.0)))
