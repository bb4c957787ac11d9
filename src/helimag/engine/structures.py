"""Arrays of Warp structures from plain values."""

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray


@cache  # Warp works it out anew at each call, which is a third of the time that a short run is packed in
def _layout(kind: Any) -> Any:
    """How NumPy sees a Warp structure."""
    layout: np.dtype[np.void] = np.dtype(kind.numpy_dtype())
    return layout


def reader(array: Any) -> Callable[[], NDArray[Any]]:
    """What gives the values of a Warp array each time it is called: on the CPU, whose memory is shared, one view."""
    if not array.device.is_cpu:
        return array.numpy  # type: ignore[no-any-return]
    view = array.numpy()
    return lambda: view


def alike(parts: Iterable[tuple[object, ...]]) -> tuple[list[int], list[int]]:
    """The first run of each kind, and of which kind each is, from parts that the runs of a sweep share.

    Parts are told apart as objects and not by their values, which takes a tenth of the time.
    """
    kinds: dict[tuple[int, ...], int] = {}
    firsts: list[int] = []
    which: list[int] = []
    for run, each in enumerate(parts):
        kind = kinds.setdefault(tuple(map(id, each)), len(kinds))
        if kind == len(firsts):
            firsts.append(run)
        which.append(kind)
    return firsts, which


def structs(kind: Any, rows: list[dict[str, object]]) -> NDArray[np.void]:
    """Pack rows of field values, all of the same fields, into an array of a Warp structure; others are zero."""
    packed: Any = np.zeros(len(rows), dtype=_layout(kind))
    for name in rows[0] if rows else ():
        packed[name] = [row[name] for row in rows]  # one by one takes several times as long
    return np.asarray(packed)
