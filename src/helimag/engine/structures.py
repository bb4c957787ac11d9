"""Arrays of Warp structures from plain values."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def structs(kind: Any, rows: list[dict[str, object]]) -> NDArray[np.void]:
    """Pack rows of field values into an array of a Warp structure; fields not named are zero."""
    packed: Any = np.zeros(len(rows), dtype=kind.numpy_dtype())
    for i, row in enumerate(rows):
        for name, value in row.items():
            packed[name][i] = value
    return np.asarray(packed)
