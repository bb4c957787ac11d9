"""Mobility from resistance."""

import numpy as np
from numpy.typing import NDArray


def mobility(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverse of a resistance, through scaling that keeps metres and radians from spoiling its condition.

    Returns
    -------
    ndarray
        (6, 6), SI, translation first.

    Examples
    --------
    >>> import numpy as np
    >>> mobility(np.diag([2.0, 2.0, 2.0, 4.0, 4.0, 4.0])).diagonal()
    array([0.5 , 0.5 , 0.5 , 0.25, 0.25, 0.25])
    """
    scale = 1.0 / np.sqrt(np.diag(matrix))
    return scale[:, None] * np.linalg.inv(scale[:, None] * matrix * scale) * scale
