"""Where things stand in each other's frames."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """Rotation (3, 3) and translation (3,) from one frame to another (m)."""

    rotation: Floats
    translation: Floats

    def of(self, points: Floats) -> Floats:
        return np.asarray(points @ self.rotation.T + self.translation)

    def after(self, first: "Pose") -> "Pose":
        return Pose(self.rotation @ first.rotation, self.rotation @ first.translation + self.translation)

    @property
    def inverse(self) -> "Pose":
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    @property
    def six(self) -> Floats:
        return np.concatenate([Rotation.from_matrix(self.rotation).as_rotvec(), self.translation])

    @classmethod
    def from_six(cls, values: Floats) -> "Pose":
        return cls(np.asarray(Rotation.from_rotvec(values[:3]).as_matrix()), np.asarray(values[3:]))

    @staticmethod
    def many(sixes: Floats) -> tuple[Floats, Floats]:
        """Rotations (n, 3, 3) and translations (n, 3) of many poses (n, 6)."""
        return np.asarray(Rotation.from_rotvec(sixes[:, :3]).as_matrix()), sixes[:, 3:]
