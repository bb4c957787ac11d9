"""Arrays of Warp structures from plain values."""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray


def structs(kind: Any, rows: list[dict[str, object]]) -> NDArray[np.void]:
    """Pack rows of field values into an array of a Warp structure; fields not named are zero."""
    packed: Any = np.zeros(len(rows), dtype=_dtype(kind))
    for i, row in enumerate(rows):
        for name, value in row.items():
            packed[name][i] = value
    return np.asarray(packed)


@cache  # Warp works it out anew each time, at a tenth of a short run's cost
def _dtype(kind: Any) -> np.dtype[np.void]:
    found: np.dtype[np.void] = np.dtype(kind.numpy_dtype())
    return found
