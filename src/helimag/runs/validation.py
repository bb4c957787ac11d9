"""Whether a dataset that was read from a file can be a run: sizes, types and values, before anything is made of it."""

import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from helimag.errors import InputError
from helimag.outcomes import End, Limit

if TYPE_CHECKING:
    import xarray

SIZES = {"axis": 3, "other_axis": 3, "component": 4, "wall": len(Limit)}
LARGEST = 1e12  # SI, of any variable: what no run comes near, and figures can still be drawn of
NO_CHARACTER = re.compile("[\ud800-\udfff]")  # what Python makes of bytes that are no text
UNIT = 1e-3  # how far a quaternion's length may be from 1

# attributes that are numbers: least value of each, which it must exceed where True
NUMBERS = {
    "initial_gap": (0.0, False),
    "frame_interval": (0.0, True),
    "clock_offset": (-math.inf, False),
    "position_accuracy": (0.0, False),
    "wall_time": (0.0, False),
    "steps": (0.0, False),
    "rejected_steps": (0.0, False),
}
TEXTS = ("name", "source", "scenario", "scenario_hash", "versions", "validity_warnings", "gaps", "frames", "accuracy")


def check_run(dataset: "xarray.Dataset", variables: Mapping[str, tuple[tuple[str, ...], str, str]]) -> None:
    """Refuse what cannot be a run.

    Parameters
    ----------
    dataset
        As read from a file.
    variables
        By name: dimensions, unit and meaning of those that are known; others are passed over.

    Raises
    ------
    InputError
        Naming the variable or attribute, what is expected and what is there.
    """
    _check_shape(dataset, "time", ("time",))
    time = np.asarray(dataset["time"].values, dtype=np.float64)
    if time.size == 0 or not np.all(np.isfinite(time)) or not np.all(np.diff(time) > 0.0) or abs(time[-1]) > LARGEST:
        raise InputError("time must hold finite seconds that rise from sample to sample")
    for name, (dims, _, _) in variables.items():
        if name in dataset:
            _check_shape(dataset, name, dims)
            _check_values(dataset, name)
    for name in NUMBERS.keys() & dataset.attrs.keys():
        _check_number(dataset.attrs, name)
    for name in TEXTS:
        text = dataset.attrs.get(name, "")
        if not isinstance(text, str) or NO_CHARACTER.search(text):
            raise InputError(f"its attribute {name} must be text; got {ascii(text)[:60]}")
    End.of(dataset.attrs["end"])


def _check_shape(dataset: "xarray.Dataset", name: str, dims: tuple[str, ...]) -> None:
    found = dataset[name]
    if found.dims != dims:
        raise InputError(f"{name} must have the dimensions {', '.join(dims)}; got {', '.join(map(str, found.dims))}")
    for dim in dims:
        if found.sizes[dim] != SIZES.get(dim, found.sizes[dim]):
            raise InputError(f"{name} must have {SIZES[dim]} entries along {dim}; got {found.sizes[dim]}")
    if found.dtype.kind not in "fiu":
        raise InputError(f"{name} must hold numbers; got {found.dtype}")


def _check_values(dataset: "xarray.Dataset", name: str) -> None:
    """No absurd number anywhere; in a simulated run nothing that is missing either."""
    values = np.asarray(dataset[name].values, dtype=np.float64)
    known = values[~np.isnan(values)]
    if np.any(np.abs(known) > LARGEST):
        raise InputError(f"{name} must hold sensible numbers; got {known[np.abs(known) > LARGEST][0]:g}")
    if dataset.attrs.get("source") == "simulated" and known.size < values.size:
        raise InputError(f"{name} must be known at every sample of a simulated run; {values.size - known.size} are nan")
    if name == "quaternion" and np.any(np.abs(np.linalg.norm(values, axis=1) - 1.0) > UNIT):
        raise InputError("quaternion must have the length 1 at every sample")


def _check_number(attributes: Mapping[Any, Any], name: str) -> None:
    least, above = NUMBERS[name]
    value = attributes[name]
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not (math.isfinite(number) and number >= least and not (above and number == least)):
        raise InputError(f"its attribute {name} must be a finite number of {least:g} or more; got {value!r}")
