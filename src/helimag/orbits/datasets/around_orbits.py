"""Slow flows with their fixed points, and basins, place by place around an orbit."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from helimag.orbits.averaged import Agreement, Basin, Counterpart, SlowFlow
from helimag.orbits.datasets.single import orbit_variables
from helimag.orbits.datasets.variables import ATTITUDE, PLACE, Content, dataset_of, flags, number, places_along, terms
from helimag.orbits.strobe import Orbit
from helimag.outcomes import BasinEnd

if TYPE_CHECKING:
    import xarray


def flow_dataset(
    flow: SlowFlow, orbit: Orbit, counterparts: Sequence[Counterpart] = (), captured: Basin | None = None
) -> "xarray.Dataset":
    """A slow flow on its grid, with the orbit that it is around, its fixed points and the orbits that they stand for.

    Parameters
    ----------
    captured
        A basin of that orbit, whose starts go with it.

    Returns
    -------
    xarray.Dataset
        SI, moving frame.
    """
    dims = ("x", "y", "z")
    data = {
        "velocity": number((*dims, "axis"), flow.velocity, "m/s", "of the settled device in the moving frame"),
        "quaternion": number((*dims, "component"), flow.states[..., 3:], "1", ATTITUDE),
        "settled": flags(dims, flow.settled.astype(int), ("no", "yes"), "whether the attitude there keeps in step"),
    }
    found = [(pair.point, pair.orbit) for pair in counterparts if pair.point is not None]
    if found:
        along = ("fixed_point",)
        rates = np.array([point.rates for point, _ in found])
        nowhere = np.full(3, np.nan)
        orbits = [nowhere if orbit is None else orbit.position for _, orbit in found]
        data |= {
            "fixed_point_position": number((*along, "axis"), [p.position for p, _ in found], "m", "zero of the flow"),
            "fixed_point_error": number(along, [p.error for p, _ in found], "m", "distance to the full model's zero"),
            "fixed_point_stable": flags(along, [int(p.stable) for p, _ in found], ("no", "yes"), "stable in the flow"),
            "fixed_point_growth": number((*along, "rate"), rates.real, "1/s", "real parts of the flow's eigenvalues"),
            "fixed_point_swing": number((*along, "rate"), rates.imag, "rad/s", "their imaginary parts"),
            "orbit_position": number((*along, "axis"), orbits, "m", f"of the orbit beside the fixed point: {PLACE}"),
        }
    if captured is not None:
        along = ("start",)
        caught = captured.captured.astype(int)
        data |= {
            "start_position": number((*along, "axis"), captured.places, "m", "where the averaged model was released"),
            "start_captured": flags(along, caught, ("no", "yes"), "whether it comes to the orbit"),
        }
    data |= orbit_variables(("around",), [orbit], prefix="around_")
    return dataset_of(data, places_along(flow.axes), flow.scenario, Content.FLOW)


def basin_dataset(basin: Basin, agreement: Agreement | None = None) -> "xarray.Dataset":
    """A basin cell by cell; with ``agreement`` also how full runs from some of the starts ended."""
    dims = ("x", "y", "z")
    ran = [end for end in BasinEnd if end is not BasinEnd.NOT_RUN]
    codes = np.array([BasinEnd.of(end).flag for end in basin.ends]).reshape(basin.shape)
    captured = basin.captured.reshape(basin.shape).astype(int)
    data = {
        "end": terms(dims, codes, ran, f"how the run from this start ended by the {basin.engine} model"),
        "captured": flags(dims, captured, ("no", "yes"), "whether the device comes to the orbit"),
        "orbit_position": number(("axis",), basin.orbit.position, "m", PLACE),
        **orbit_variables(("around",), [basin.orbit], prefix="around_"),
    }
    if agreement is not None:
        full = np.full(basin.ends.size, BasinEnd.NOT_RUN.flag)
        full[agreement.starts] = [BasinEnd.of(end).flag for end in agreement.full]
        data["end_by_full_run"] = terms(
            dims, full.reshape(basin.shape), BasinEnd, "how a full run from this start ended"
        )
    about = {"engine": basin.engine, "attitude": basin.attitude, "duration": basin.duration, "volume": basin.volume}
    return dataset_of(data, places_along(basin.axes), basin.orbit.scenario, Content.BASIN, about)
