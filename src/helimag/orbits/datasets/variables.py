"""Variables with units and CF flags, a dataset with its provenance, and the way into a file."""

from collections.abc import Iterable, Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from helimag.outcomes import Term, cf_flags
from helimag.runs import write_netcdf
from helimag.runs.trajectory import versions
from helimag.scenario import Input, Scenario

if TYPE_CHECKING:
    import xarray

Variable = tuple[tuple[str, ...], Any, dict[str, object]]


class Content(Enum):
    """What a file about orbits holds: its attribute ``content``, and its title."""

    ORBITS = "orbits"
    BRANCHES = "branches of orbits"
    MAP = "stability map"
    FLOW = "slow flow"
    BASIN = "basin of attraction"
    COMPARISON = "runs against orbits"

    @property
    def word(self) -> str:
        """As in the file's attribute."""
        return self.name.lower()


STABILITY = ("no_orbit", "unstable", "stable")
PLACE = "head when a turn of the magnet begins, moving frame"
ATTITUDE = "rotation from body to moving frame, scalar first, when a turn of the magnet begins"


def number(dims: tuple[str, ...], values: Any, units: str, meaning: str) -> Variable:
    """Numbers with a unit, and what they mean."""
    return dims, np.asarray(values, dtype=np.float64), {"units": units, "long_name": meaning}


def flags(dims: tuple[str, ...], codes: Any, words: Sequence[str], meaning: str) -> Variable:
    """A CF flag variable: small whole numbers, and what each of them means."""
    meanings = " ".join(word.replace(" ", "_") for word in words)
    values: NDArray[np.int8] = np.arange(len(words), dtype=np.int8)
    return (
        dims,
        np.asarray(codes, dtype=np.int8),
        {
            "long_name": meaning,
            "flag_values": values,
            "flag_meanings": meanings,
        },
    )


def terms(dims: tuple[str, ...], codes: Any, words: Iterable[Term], meaning: str, *, zero: str = "") -> Variable:
    """A CF flag variable of the vocabulary's own numbers; ``zero`` says what 0 means where no term has it."""
    known = cf_flags(words, zero=zero)
    values: NDArray[np.int8] = np.array(known["flag_values"], dtype=np.int8)
    return dims, np.asarray(codes, dtype=np.int8), {"long_name": meaning, **known, "flag_values": values}


def stability(dims: tuple[str, ...], growth: NDArray[np.float64], meaning: str) -> Variable:
    """Flags of :data:`STABILITY` by the real part of the leading rate (1/s), nan where there is no orbit."""
    return flags(dims, np.where(np.isnan(growth), 0, np.where(growth < 0.0, 2, 1)), STABILITY, meaning)


def about_input(scenario: Scenario, path: str) -> dict[str, object]:
    """Unit and path of an input, as attributes."""
    kind = Input(path).kind(scenario)
    return {"units": "1" if kind is None else kind.si, "long_name": path}


def places_along(axes: Sequence[NDArray[np.float64]]) -> dict[str, Variable]:
    """Axes of a grid of places (m) as coordinates x, y and z."""
    return {
        name: ((name,), axis, {"units": "m", "long_name": f"{name} of the head, moving frame"})
        for name, axis in zip("xyz", axes, strict=True)
    }


def dataset_of(
    data: dict[str, Variable],
    coordinates: dict[str, Variable],
    scenario: Scenario,
    content: Content,
    about: dict[str, object] | None = None,
) -> "xarray.Dataset":
    """A dataset that says where it comes from: scenario, versions and frames, and what else is known ``about`` it."""
    import xarray

    return xarray.Dataset(
        data,
        coordinates,
        {
            "Conventions": "CF-1.11",
            "title": content.value,
            "content": content.word,
            "name": scenario.title,
            "source": "simulated",
            "frames": "moving: yaws and translates with the drive, the lab frame at t = 0; z up; angles in rad",
            **(about or {}),
            "scenario": scenario.to_toml(),
            "scenario_hash": scenario.hash,
            "versions": versions(),
        },
    )


def save_dataset(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write netCDF beside ``path`` first, then rename it.

    Raises
    ------
    FileError
        Where the file cannot be written; nothing is left behind.
    """
    write_netcdf(dataset, path)
