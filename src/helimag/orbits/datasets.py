"""Orbits, maps, flows and basins as labelled datasets with units and provenance, and into netCDF.

Every file is flat: numbers with units, CF flags for what is one of a few words, and no text but in attributes, so that
xarray, MATLAB (``ncread``) and any HDF5 reader open it. ``axis`` runs over x, y, z, ``component`` over w, x, y, z.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.outcomes import BasinEnd, Term, Verdict, Why, cf_flags
from helimag.runs import versions, write_netcdf
from helimag.scenario import Scenario
from helimag.scenario.inputs import Input

if TYPE_CHECKING:
    import xarray

    from helimag.orbits import (
        Agreement,
        Basin,
        BoundaryCurve,
        Branch,
        Comparison,
        Counterpart,
        Orbit,
        SlowFlow,
        StabilityMap,
    )

Variable = tuple[tuple[str, ...], Any, dict[str, object]]

STABILITY = ("no_orbit", "unstable", "stable")
PLACE = "head when a turn of the magnet begins, moving frame"
ATTITUDE = "rotation from body to moving frame, scalar first, when a turn of the magnet begins"


def map_dataset(result: "StabilityMap", boundary: Sequence["BoundaryCurve"] = ()) -> "xarray.Dataset":
    """A stability map over its two inputs, with its boundary point by point."""
    names = [path.replace(".", "_") for path in result.paths]
    dims = names[0], names[1]
    inputs = [_input(result.scenario, path) for path in result.paths]
    axes: dict[str, Variable] = {
        name: ((name,), values, about) for name, values, about in zip(names, result.values, inputs, strict=True)
    }
    data = {
        "stability": _flags(dims, _stability(result.growth), STABILITY, "whether an orbit was found, and a stable one"),
        "growth": _number(dims, result.growth, "1/s", "real part of the leading rate; stable where negative"),
        "swing": _number(dims, result.swing, "rad/s", "imaginary part of the leading rate"),
        "position": _number((*dims, "axis"), result.states[..., :3], "m", PLACE),
        "quaternion": _number((*dims, "component"), result.states[..., 3:], "1", ATTITUDE),
    }
    if boundary:
        data |= _boundary(boundary, names, inputs)
    return _dataset(data, axes, result.scenario, "stability map")


def flow_dataset(flow: "SlowFlow", counterparts: Sequence["Counterpart"] = ()) -> "xarray.Dataset":
    """A slow flow on its grid, with its fixed points and the orbits that they stand for."""
    dims = ("x", "y", "z")
    data = {
        "velocity": _number((*dims, "axis"), flow.velocity, "m/s", "of the settled device in the moving frame"),
        "quaternion": _number((*dims, "component"), flow.states[..., 3:], "1", ATTITUDE),
        "settled": _flags(dims, flow.settled.astype(int), ("no", "yes"), "whether the attitude there keeps in step"),
    }
    found = [(pair.point, pair.orbit) for pair in counterparts if pair.point is not None]
    if found:
        along = ("fixed_point",)
        rates = np.array([point.rates for point, _ in found])
        nowhere = np.full(3, np.nan)
        orbits = [nowhere if orbit is None else orbit.position for _, orbit in found]
        data |= {
            "fixed_point_position": _number((*along, "axis"), [p.position for p, _ in found], "m", "zero of the flow"),
            "fixed_point_error": _number(along, [p.error for p, _ in found], "m", "distance to the full model's zero"),
            "fixed_point_stable": _flags(along, [int(p.stable) for p, _ in found], ("no", "yes"), "stable in the flow"),
            "fixed_point_growth": _number((*along, "rate"), rates.real, "1/s", "real parts of the flow's eigenvalues"),
            "fixed_point_swing": _number((*along, "rate"), rates.imag, "rad/s", "their imaginary parts"),
            "orbit_position": _number((*along, "axis"), orbits, "m", f"of the orbit beside the fixed point: {PLACE}"),
        }
    return _dataset(data, _places(flow.axes), flow.scenario, "slow flow")


def basin_dataset(basin: "Basin", agreement: "Agreement | None" = None) -> "xarray.Dataset":
    """A basin cell by cell; with ``agreement`` also how full runs from some of the starts ended."""
    dims = ("x", "y", "z")
    ran = [end for end in BasinEnd if end is not BasinEnd.NOT_RUN]
    codes = np.array([BasinEnd.of(end).flag for end in basin.ends]).reshape(basin.shape)
    captured = basin.captured.reshape(basin.shape).astype(int)
    data = {
        "end": _terms(dims, codes, ran, f"how the run from this start ended by the {basin.engine} model"),
        "captured": _flags(dims, captured, ("no", "yes"), "whether the device comes to the orbit"),
        "orbit_position": _number(("axis",), basin.orbit.position, "m", PLACE),
    }
    if agreement is not None:
        full = np.full(basin.ends.size, BasinEnd.NOT_RUN.flag)
        full[agreement.starts] = [BasinEnd.of(end).flag for end in agreement.full]
        data["end_by_full_run"] = _terms(
            dims, full.reshape(basin.shape), BasinEnd, "how a full run from this start ended"
        )
    about = {"engine": basin.engine, "duration": basin.duration, "volume": basin.volume}
    return _dataset(data, _places(basin.axes), basin.orbit.scenario, "basin of attraction", about)


def branches_dataset(branches: Sequence["Branch"]) -> "xarray.Dataset":
    """Branches over one input, orbit by orbit in order of arclength, one after another; and where stability changes."""
    scenario = branches[0].points[0].orbit.scenario
    name, about = branches[0].path.replace(".", "_"), _input(scenario, branches[0].path)
    along = ("point",)
    orbits = [point.orbit for branch in branches for point in branch.points]
    numbers = np.repeat(np.arange(len(branches), dtype=float), [len(branch.points) for branch in branches])
    values = np.concatenate([branch.values for branch in branches])
    data: dict[str, Variable] = {
        name: (along, values, about),
        "branch": _number(along, numbers, "1", "number of the branch that a point belongs to"),
        **_orbits(along, orbits),
    }
    events = [event for branch in branches for event in branch.events]
    if events:
        kinds = tuple(dict.fromkeys(str(event.kind) for event in events))
        codes = [kinds.index(str(event.kind)) for event in events]
        data |= {
            f"change_{name}": (("change",), np.array([event.value for event in events]), about),
            "change_kind": _flags(("change",), codes, kinds, "what happens to the orbit's stability"),
            "change_position": _number(("change", "axis"), [event.orbit.position for event in events], "m", PLACE),
        }
    ends = "; ".join(", ".join(branch.ends) for branch in branches)
    return _dataset(data, {}, scenario, "branches of orbits", {"ends": ends})


class Along(NamedTuple):
    """Values of an input, SI or text, with its unit, along a dimension of a grid."""

    dimension: str
    unit: str
    values: Sequence[float | str]


def comparison_dataset(
    result: "Comparison", scenario: Scenario, inputs: Mapping[str, Along], dimensions: Sequence[str]
) -> "xarray.Dataset":
    """Verdicts of a grid of runs beside orbits.

    Parameters
    ----------
    scenario
        What the runs have in common.
    inputs
        By dotted path; text is numbered.
    dimensions
        Of the grid, in order. One that a single input runs along gets that input's name.
    """
    paths = {dim: [path for path, given in inputs.items() if given.dimension == dim] for dim in dimensions}
    names = {dim: on[0].replace(".", "_") if len(on) == 1 else dim for dim, on in paths.items()}
    dims = tuple(names.values())
    named: dict[str, Variable] = {}
    for path, (along, unit, values) in inputs.items():
        dim = (names[along],)
        if any(isinstance(value, str) for value in values):
            words = list(dict.fromkeys(str(value) for value in values))
            variable = _flags(dim, [words.index(str(value)) for value in values], words, path)
        else:
            variable = _number(dim, values, unit, path)
        named[path.replace(".", "_")] = variable
    judged = [verdict for verdict in Verdict if verdict.judged]
    verdicts = np.array([Verdict.of(word).flag if word else 0 for word in result.verdicts.flat])
    codes = np.zeros(result.verdicts.shape, dtype=int)
    for case in result.cases:
        codes[case.node] = case.why.flag
    data = {
        "verdict": _terms(dims, verdicts.reshape(result.verdicts.shape), judged, "run", zero="none"),
        "stability": _flags(dims, _stability(result.growth), STABILITY, "whether an orbit is known, and a stable one"),
        "why": _terms(
            dims, codes, Why, "why run and orbit differ, or what becomes of an undecided run", zero="nothing to explain"
        ),
        "growth": _number(dims, result.growth, "1/s", "real part of the leading rate; stable where negative"),
        "position": _number((*dims, "axis"), result.states[..., :3], "m", PLACE),
        "away": _flags(dims, result.away.astype(int), ("no", "yes"), "whether no neighbour differs in stability"),
    }
    shares: dict[str, object] = {"agreement": result.share(), "agreement_beside_orbit": result.share(beside=True)}
    return _dataset(data, named, scenario, "runs against orbits", shares)


def _stability(growth: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.asarray(np.where(np.isnan(growth), 0, np.where(growth < 0.0, 2, 1)))


def save_dataset(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write netCDF beside ``path`` first, then rename it.

    Raises
    ------
    FileError
        Where the file cannot be written; nothing is left behind.
    """
    write_netcdf(dataset, path)


def _boundary(
    boundary: Sequence["BoundaryCurve"], names: Sequence[str], inputs: Sequence[dict[str, object]]
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
        "boundary_kind": _flags(along, codes, kinds, "what happens where stability ends"),
        "boundary_curve": (along, numbers, {"units": "1", "long_name": "number of the curve that the point is on"}),
        "boundary_swing": _number(along, swing, "rad/s", "imaginary part of the critical rate"),
        "boundary_position": _number((*along, "axis"), states[:, :3], "m", PLACE),
        "boundary_quaternion": _number((*along, "component"), states[:, 3:], "1", ATTITUDE),
    }


def _orbits(along: tuple[str, ...], orbits: Sequence["Orbit"]) -> dict[str, Variable]:
    states, multipliers = np.array([o.state for o in orbits]), np.array([o.multipliers for o in orbits])
    rates = np.array([o.rates for o in orbits])
    lead = rates[np.arange(len(orbits)), np.argmax(rates.real, axis=1)]
    each = (*along, "multiplier")
    return {
        "stable": _flags(along, [int(o.stable) for o in orbits], ("no", "yes"), "whether the orbit is stable"),
        "growth": _number(along, lead.real, "1/s", "real part of the leading rate; stable where negative"),
        "swing": _number(along, np.abs(lead.imag), "rad/s", "imaginary part of the leading rate"),
        "position": _number((*along, "axis"), states[:, :3], "m", PLACE),
        "mean_position": _number((*along, "axis"), [o.mean_position for o in orbits], "m", "mean over the period"),
        "quaternion": _number((*along, "component"), states[:, 3:], "1", ATTITUDE),
        "multiplier_real": _number(each, multipliers.real, "1", "Floquet multipliers, real part"),
        "multiplier_imaginary": _number(each, multipliers.imag, "1", "Floquet multipliers, imaginary part"),
        "attack_angle": _number(along, [o.attack_angle for o in orbits], "rad", "mean over the period"),
        "wobble": _number(along, [o.wobble for o in orbits], "rad", "standard deviation of the attack angle"),
    }


def _number(dims: tuple[str, ...], values: Any, units: str, meaning: str) -> Variable:
    return dims, np.asarray(values, dtype=np.float64), {"units": units, "long_name": meaning}


def _flags(dims: tuple[str, ...], codes: Any, words: Sequence[str], meaning: str) -> Variable:
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


def _terms(dims: tuple[str, ...], codes: Any, terms: Iterable[Term], meaning: str, *, zero: str = "") -> Variable:
    """A CF flag variable of the vocabulary's own numbers; ``zero`` says what 0 means where no term has it."""
    flags = cf_flags(terms, zero=zero)
    values: NDArray[np.int8] = np.array(flags["flag_values"], dtype=np.int8)
    return dims, np.asarray(codes, dtype=np.int8), {"long_name": meaning, **flags, "flag_values": values}


def _input(scenario: Scenario, path: str) -> dict[str, object]:
    kind = Input(path).kind(scenario)
    return {"units": "1" if kind is None else kind.si, "long_name": path}


def _places(axes: Sequence[NDArray[np.float64]]) -> dict[str, Variable]:
    return {
        name: ((name,), axis, {"units": "m", "long_name": f"{name} of the head, moving frame"})
        for name, axis in zip("xyz", axes, strict=True)
    }


def _dataset(
    data: dict[str, Variable],
    coordinates: dict[str, Variable],
    scenario: Scenario,
    title: str,
    about: dict[str, object] | None = None,
) -> "xarray.Dataset":
    import xarray

    return xarray.Dataset(
        data,
        coordinates,
        {
            "Conventions": "CF-1.11",
            "title": title,
            "name": scenario.title,
            "source": "simulated",
            "frames": "moving: yaws and translates with the drive, the lab frame at t = 0; z up; angles in rad",
            **(about or {}),
            "scenario": scenario.to_toml(),
            "scenario_hash": scenario.hash,
            "versions": versions(),
        },
    )
