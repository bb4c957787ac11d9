"""The paper's formulas as Warp functions: one formula, one function, for kernels and for Python alike."""

import os
import sys
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

__all__ = ["evaluate"]


def _start_warp() -> None:
    """Start Warp without its greeting, and without its remark that there is no GPU, which nobody asked for.

    The remark comes from native code, so the file descriptor itself is diverted; anything else said there is passed on.
    """
    wp.config.quiet = True
    wp.config.log_level = wp.LOG_ERROR
    sys.stderr.flush()
    with tempfile.TemporaryFile() as said:
        kept = os.dup(2)
        try:
            os.dup2(said.fileno(), 2)
            wp.init()
        finally:
            os.dup2(kept, 2)
            os.close(kept)
        said.seek(0)
        rest = [line for line in said.read().decode(errors="replace").splitlines() if "CUDA driver" not in line]
    if rest:
        print("\n".join(rest), file=sys.stderr)


_start_warp()


def evaluate(formula: Callable[..., Any], *arguments: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Evaluate a formula of this package over arrays.

    Parameters
    ----------
    formula
        A Warp function such as :func:`helimag.physics.magnetics.dipole_field`.
    *arguments
        One array an argument: (n, 3) for vectors, (n,) for scalars. A single vector (3,) or number serves every row.

    Returns
    -------
    array
        (n, 3) or (n,), SI.
    """
    types = list(formula.input_types.values())  # type: ignore[attr-defined]
    shapes = [
        np.asarray(value).shape[: np.ndim(value) - (3 in getattr(kind, "_shape_", ()))]
        for value, kind in zip(arguments, types, strict=True)
    ]
    (rows,) = np.broadcast_shapes(*shapes, (1,))
    given = []
    for value, kind in zip(arguments, types, strict=True):
        width = tuple(getattr(kind, "_shape_", ()))
        full = np.ascontiguousarray(np.broadcast_to(np.asarray(value, dtype=np.float64), (rows, *width)))
        given.append(wp.array(full, dtype=kind, device="cpu"))
    result: NDArray[np.float64] = wp.map(formula, *given).numpy()
    return result
