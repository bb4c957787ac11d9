"""The rates at the stages of a step, and sums of them."""

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine import tableau
from helimag.physics.kinematics import State

STAGES = tableau.STAGES
Stages = wp.types.matrix(shape=(STAGES, 7), dtype=wp.float64)


def weighted_sum(weights: NDArray[np.float64], kind: Any = Stages) -> wp.Function:
    """Make the function that sums a step's stages with these weights, left to right; absent ones cost nothing.

    Stages are rows of a matrix, or of another ``kind``, such as an array of states.
    """
    used = np.flatnonzero(weights).tolist()
    factors = [wp.float64(float(weights[j])) for j in used]
    count = len(used)

    @wp.func
    def total(k: kind) -> State:
        result = wp.static(factors[0]) * k[wp.static(used[0])]
        for i in range(1, wp.static(count)):
            result += wp.static(factors[i]) * k[wp.static(used[i])]
        return result

    return total
