"""Whether a dataset that was read from a file can be a run: sizes, types and values, before anything is made of it."""

import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from helimag import quantities as q
from helimag.errors import InputError
from helimag.outcomes import End, Limit
from helimag.scenario import check_kept

if TYPE_CHECKING:
    import xarray

LABELS = {
    "axis": ("x", "y", "z"),
    "other_axis": ("x", "y", "z"),
    "component": ("w", "x", "y", "z"),
    "wall": tuple(str(wall) for wall in Limit),
}
SIZES = {dim: len(labels) for dim, labels in LABELS.items()}
SAME_UNIT = {"m": q.LENGTH, "s": q.TIME, "rad": q.ANGLE}  # of these, other names of the unit are understood
# what may be missing from a measured run at some samples
MAY_MISS = frozenset({"attack_angle_sd", "misfit", "position_covariance", "position_noise", "quaternion", "long_axis"})
LEVEL = 1e-9  # m; a magnet less than this above the device is level with it
LARGEST = 1e12  # SI, of any variable: what no run comes near, and figures can still be drawn of
NO_CHARACTER = re.compile("[\ud800-\udfff]")  # what Python makes of bytes that are no text
UNIT = 1e-3  # how far a quaternion's length may be from 1

# attributes that are numbers: least value of each, which it must exceed where True
NUMBERS = {
    "initial_gap": (0.0, False),
    "frame_interval": (0.0, True),
    "frames_first": (-math.inf, False),
    "film_begin": (-math.inf, False),
    "film_end": (-math.inf, False),
    "clock_offset": (-math.inf, False),
    "clock_offset_sd": (-1.0, False),  # -1 where it is not known
    "position_accuracy": (0.0, False),
    "scale_sd": (0.0, False),
    "lap_time": (0.0, True),
    "fold_time": (0.0, True),
    "tolerance": (0.0, True),
    "wall_time": (0.0, False),
    "steps": (0.0, False),
    "rejected_steps": (0.0, False),
}
ENDLESS = ("lap_time", "fold_time")  # which are infinite where nothing moves the device
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
    _check_unit(dataset, "time", "s")
    _check_labels(dataset)
    time = np.asarray(dataset["time"].values, dtype=np.float64)
    if time.size == 0 or not np.all(np.isfinite(time)) or not np.all(np.diff(time) > 0.0) or abs(time[-1]) > LARGEST:
        raise InputError("time must hold finite seconds that rise from sample to sample")
    for name, (dims, unit, _) in variables.items():
        if name in dataset:
            _check_shape(dataset, name, dims)
            _check_unit(dataset, name, unit)
            _check_values(dataset, name)
    _check_extremes(dataset)
    for name in NUMBERS.keys() & dataset.attrs.keys():
        _check_number(dataset.attrs, name)
    for name in TEXTS:
        text = dataset.attrs.get(name, "")
        if not isinstance(text, str) or NO_CHARACTER.search(text):
            raise InputError(f"its attribute {name} must be text; got {ascii(text)[:60]}")
    check_kept(dataset.attrs)
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


def _check_unit(dataset: "xarray.Dataset", name: str, unit: str) -> None:
    """A unit that a file states must be the one in which the numbers are read; many programs state none."""
    found = dataset[name].attrs.get("units")
    if found is None or found == unit or (unit == "1" and found == ""):
        return
    try:
        same = unit in SAME_UNIT and q.parse(f"1 {found}", SAME_UNIT[unit]) == 1.0
    except InputError:
        same = False
    if not same:
        raise InputError(f"{name} must be in {unit}; its units are {ascii(found)[:40]}")


def _check_labels(dataset: "xarray.Dataset") -> None:
    """Axes that are labelled must be so in the order in which they are read."""
    for dim, labels in LABELS.items():
        if dim in dataset.coords:
            found = tuple(str(label) for label in dataset.coords[dim].values.ravel())
            if found != labels and len(found) == len(labels):  # another number of them is refused where it is read
                raise InputError(f"{dim} must be labelled {', '.join(labels)}; got {', '.join(found)[:60]}")


def _check_extremes(dataset: "xarray.Dataset") -> None:
    """The lowest and the highest head since a sample must lie to either side of its mean."""
    if not {"height_low", "height_high"} <= set(dataset.variables):
        return
    low, high = (np.asarray(dataset[name].values, dtype=np.float64) for name in ("height_low", "height_high"))
    mean = np.asarray(dataset["height_mean"].values, dtype=np.float64) if "height_mean" in dataset else (low + high) / 2
    slack = UNIT * (float(np.max(high)) - float(np.min(low))) + LEVEL
    if np.any(low > mean + slack) or np.any(mean > high + slack):
        raise InputError("height_low must be below height_mean, and that below height_high, at every sample")


def _check_values(dataset: "xarray.Dataset", name: str) -> None:
    """No absurd number anywhere; in a simulated run nothing that is missing either."""
    values = np.asarray(dataset[name].values, dtype=np.float64)
    known = values[~np.isnan(values)]
    if np.any(np.abs(known) > LARGEST):
        raise InputError(f"{name} must hold sensible numbers; got {known[np.abs(known) > LARGEST][0]:g}")
    simulated = dataset.attrs.get("source") == "simulated"
    if known.size < values.size and (simulated or name not in MAY_MISS):
        of_what = "a simulated run" if simulated else "a run"
        raise InputError(f"{name} must be known at every sample of {of_what}; {values.size - known.size} are nan")
    if name == "quaternion" and np.any(np.abs(np.linalg.norm(values, axis=1) - 1.0) > UNIT):
        raise InputError("quaternion must have the length 1 at every sample")


def _check_number(attributes: Mapping[Any, Any], name: str) -> None:
    least, above = NUMBERS[name]
    value = attributes[name]
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if name in ENDLESS and number == math.inf:
        return
    if name == "initial_gap" and 0.0 < number < LEVEL:
        raise InputError(
            f"its attribute {name} must be a sensible height of the magnet above the device; got {number:g} m"
        )
    if not (math.isfinite(number) and number >= least and not (above and number == least) and number <= LARGEST):
        bound = f"above {least:g}" if above else f"of {least:g} or more"
        raise InputError(f"its attribute {name} must be a finite number {bound}; got {_plain(value)!r}")


def _plain(value: Any) -> Any:
    """A number as people write it, out of NumPy's own."""
    return value.item() if isinstance(value, np.generic) else value
