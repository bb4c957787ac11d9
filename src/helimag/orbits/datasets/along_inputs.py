"""Maps of stability with their boundaries, and branches, over inputs."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from helimag.orbits.curves import BoundaryCurve, Branch, StabilityMap
from helimag.orbits.datasets.single import orbit_variables
from helimag.orbits.datasets.variables import (
    ATTITUDE,
    PLACE,
    Content,
    Variable,
    about_input,
    dataset_of,
    flags,
    number,
    stability,
)
from helimag.orbits.strobe import Orbit

if TYPE_CHECKING:
    import xarray


def map_dataset(result: StabilityMap, boundary: Sequence[BoundaryCurve] = ()) -> "xarray.Dataset":
    """A stability map over its two inputs, with its boundary point by point."""
    names = [path.replace(".", "_") for path in result.paths]
    dims = names[0], names[1]
    inputs = [about_input(result.scenario, path) for path in result.paths]
    axes: dict[str, Variable] = {
        name: ((name,), values, about) for name, values, about in zip(names, result.values, inputs, strict=True)
    }
    data = {
        "stability": stability(dims, result.growth, "whether an orbit was found, and a stable one"),
        "growth": number(dims, result.growth, "1/s", "real part of the leading rate; stable where negative"),
        "swing": number(dims, result.swing, "rad/s", "imaginary part of the leading rate"),
        "position": number((*dims, "axis"), result.states[..., :3], "m", PLACE),
        "quaternion": number((*dims, "component"), result.states[..., 3:], "1", ATTITUDE),
    }
    if boundary:
        data |= _boundary(boundary, names, inputs)
    ends = {"boundary_ends": "; ".join(", ".join(curve.ends) for curve in boundary)} if boundary else {}
    return dataset_of(data, axes, result.scenario, Content.MAP, {**ends})


def branches_dataset(branches: Sequence[Branch]) -> "xarray.Dataset":
    """Branches over one input, orbit by orbit in order of arclength, one after another; and where stability changes."""
    scenario = branches[0].points[0].orbit.scenario
    name, about = branches[0].path.replace(".", "_"), about_input(scenario, branches[0].path)
    along = ("point",)
    orbits = [point.orbit for branch in branches for point in branch.points]
    numbers = np.repeat(np.arange(len(branches), dtype=float), [len(branch.points) for branch in branches])
    values = np.concatenate([branch.values for branch in branches])
    data: dict[str, Variable] = {
        name: (along, values, about),
        "branch": number(along, numbers, "1", "number of the branch that a point belongs to"),
        **orbit_variables(along, orbits),
    }
    located = [(place, event) for place, branch in enumerate(branches) for event in branch.events]
    events = [event for _, event in located]
    if events:
        kinds = tuple(dict.fromkeys(str(event.kind) for event in events))
        codes = [kinds.index(str(event.kind)) for event in events]
        data |= {
            f"change_{name}": (("change",), np.array([event.value for event in events]), about),
            "change_kind": flags(("change",), codes, kinds, "what happens to the orbit's stability"),
            "change_branch": number(("change",), [place for place, _ in located], "1", "number of its branch"),
            "change_index": number(("change",), [event.index for event in events], "1", "points of the branch before"),
            **orbit_variables(("change",), [event.orbit for event in events], prefix="change_"),
        }
    ends = "; ".join(", ".join(branch.ends) for branch in branches)
    return dataset_of(data, {}, scenario, Content.BRANCHES, {"input": branches[0].path, "ends": ends})


def orbits_dataset(orbits: Sequence[Orbit]) -> "xarray.Dataset":
    """Orbits of one scenario, one after another."""
    return dataset_of(orbit_variables(("orbit",), orbits), {}, orbits[0].scenario, Content.ORBITS)


def _boundary(
    boundary: Sequence[BoundaryCurve], names: Sequence[str], inputs: Sequence[dict[str, object]]
) -> dict[str, Variable]:
    """Points of all curves in one row, each curve's in order along it."""
    along = ("boundary_point",)
    kinds = tuple(dict.fromkeys(str(curve.kind) for curve in boundary))
    sizes = [len(curve.first) for curve in boundary]
    values = [np.concatenate([getattr(curve, name) for curve in boundary]) for name in ("first", "second")]
    codes = np.repeat([kinds.index(str(curve.kind)) for curve in boundary], sizes)
    numbers = np.repeat(np.arange(len(boundary), dtype=np.int32), sizes)
    states = np.concatenate([curve.states for curve in boundary])
    swing = np.concatenate([curve.swing for curve in boundary])
    return {
        f"boundary_{names[0]}": (along, values[0], inputs[0]),
        f"boundary_{names[1]}": (along, values[1], inputs[1]),
        "boundary_kind": flags(along, codes, kinds, "what happens where stability ends"),
        "boundary_curve": (along, numbers, {"units": "1", "long_name": "number of the curve that the point is on"}),
        "boundary_swing": number(along, swing, "rad/s", "imaginary part of the critical rate"),
        "boundary_position": number((*along, "axis"), states[:, :3], "m", PLACE),
        "boundary_quaternion": number((*along, "component"), states[:, 3:], "1", ATTITUDE),
    }
