"""The paper's formulas as Warp functions: one formula, one function, for kernels and for Python alike."""

import os
import sys
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.errors import FileError

__all__ = ["evaluate"]


def _start_warp() -> None:
    """Start Warp without its greeting, and without its remark that there is no GPU, which nobody asked for.

    The remark comes from native code, so the file descriptor itself is diverted; anything else said there is passed on.
    """
    wp.config.quiet = True
    wp.config.log_level = wp.LOG_ERROR
    try:
        rest = [line for line in _said_by(wp.init) if "CUDA driver" not in line]
    except OSError as error:
        place = error.filename or wp.config.kernel_cache_dir
        where = "XDG_CACHE_HOME" if os.environ.get("XDG_CACHE_HOME") else "HOME"  # as Warp looks for it
        raise FileError(
            f"the folder of compiled kernels, {place}, cannot be made: {error.strerror or error}; let {where}, or "
            "WARP_CACHE_PATH, name a folder that can be written"
        ) from None
    if rest:
        print("\n".join(rest), file=sys.stderr)


def _said_by(task: Callable[[], object]) -> list[str]:
    """Lines that a task writes to the process' standard error, where there is one."""
    try:
        kept = os.dup(2)
    except OSError:  # closed: nothing can be said
        task()
        return []
    if sys.stderr is not None:
        sys.stderr.flush()
    with tempfile.TemporaryFile() as said:
        try:
            os.dup2(said.fileno(), 2)
            task()
        finally:
            os.dup2(kept, 2)
            os.close(kept)
        said.seek(0)
        return said.read().decode(errors="replace").splitlines()


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
