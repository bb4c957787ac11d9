"""Whether the numbers of a file about orbits can be what it says it holds, before anything is made or drawn of them."""

from typing import TYPE_CHECKING

import numpy as np

from helimag.errors import InputError
from helimag.orbits.datasets.variables import Content
from helimag.outcomes import BasinEnd

if TYPE_CHECKING:
    import xarray

LARGEST = 1e12  # SI, of any number that is known: what nothing here comes near, and figures can still be drawn of
SAME = 1e-6  # how far a volume may be from that of its cells
# where an orbit is known by its place; on a map places are nan where none was found
PLACED = {
    Content.ORBITS: ("position",),
    Content.BRANCHES: ("position",),
    Content.MAP: (),
    Content.FLOW: ("around_position",),
    Content.BASIN: ("around_position",),
}


def check_numbers(dataset: "xarray.Dataset", content: Content) -> None:
    """Refuse absurd numbers, empty arrays, axes that do not rise, and orbits without a place.

    Raises
    ------
    InputError
        Naming the variable.
    """
    if content is Content.ORBITS and dataset.sizes.get("orbit") == 0:  # none was found
        return
    for name, variable in dataset.variables.items():
        if 0 in variable.shape:
            raise InputError(f"the file's {content.value} is not whole: {name} is empty")
        if variable.dtype.kind == "f":
            known = variable.values[np.isfinite(variable.values)]
            if np.any(np.abs(known) > LARGEST):
                raise InputError(f"the file's {content.value} is not whole: {name} holds {np.abs(known).max():g}")
    for name in dataset.dims:
        if name in dataset.variables and dataset.variables[name].dtype.kind in "fiu":
            values = np.asarray(dataset.variables[name].values, dtype=np.float64)
            if not np.isfinite(values).all() or np.any(np.diff(values) <= 0.0):
                raise InputError(f"the file's {content.value} is not whole: {name} must hold numbers that rise")
    for name in PLACED[content]:
        if not np.isfinite(np.asarray(dataset[name].values, dtype=np.float64)).all():
            raise InputError(f"the file's {content.value} is not whole: {name} must be known")


def check_basin(dataset: "xarray.Dataset") -> None:
    """Refuse a basin whose tally, ends and volume are not of each other.

    Raises
    ------
    InputError
        Saying which are not.
    """
    captured = np.asarray(dataset["captured"].values) > 0
    if np.any(captured != (np.asarray(dataset["end"].values) == BasinEnd.CAPTURED.flag)):
        raise InputError("the file's basin is not whole: captured and end do not agree")
    sides = [np.diff(np.asarray(dataset[name].values, dtype=np.float64)) for name in "xyz"]
    if any(side.size == 0 for side in sides):
        raise InputError("the file's basin is not whole: it must have two starts or more along each side")
    volume = float(np.prod([side.mean() for side in sides])) * int(captured.sum())
    if not abs(float(dataset.attrs["volume"]) - volume) <= SAME * volume:
        raise InputError("the file's basin is not whole: its volume is not that of the cells that are captured")
