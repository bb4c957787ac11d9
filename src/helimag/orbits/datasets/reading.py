"""Files about orbits, back into what was computed."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from helimag.errors import InputError
from helimag.orbits.averaged import Basin, FixedPoint, SlowFlow
from helimag.orbits.curves import BoundaryCurve, Branch, Change, Event, Point, StabilityMap
from helimag.orbits.datasets.checking import check_basin, check_numbers
from helimag.orbits.datasets.single import orbits_in
from helimag.orbits.datasets.variables import Content
from helimag.orbits.strobe import Floats, Orbit
from helimag.outcomes import BasinEnd
from helimag.scenario import Scenario, check_kept, parse
from helimag.scenario.inputs import varied

if TYPE_CHECKING:
    import xarray


class KnownMap(NamedTuple):
    """A stability map and its boundary."""

    map: StabilityMap
    boundary: list[BoundaryCurve]


class KnownFlow(NamedTuple):
    """A slow flow, the orbit that it is around, its fixed points, and the starts that were followed in it."""

    flow: SlowFlow
    orbit: Orbit
    fixed_points: list[FixedPoint]
    captured: Basin | None


Known = list[Orbit] | list[Branch] | KnownMap | KnownFlow | Basin


def content_of(dataset: "xarray.Dataset") -> Content | None:
    """What a dataset about orbits holds; None where it is about something else."""
    said = dataset.attrs.get("content")
    return next((each for each in Content if isinstance(said, str) and each.word == said), None)


def known_in(dataset: "xarray.Dataset") -> Known:
    """What :mod:`helimag.orbits.datasets` made into this dataset.

    Returns
    -------
    list of Orbit, list of Branch, KnownMap, KnownFlow or Basin
        As its content is. Orbits come without their Jacobian, points of a branch without the direction of travel.

    Raises
    ------
    InputError
        Where it holds nothing of the kind, or not all that it must.
    """
    content = content_of(dataset)
    if content is None or content not in READERS:
        raise InputError("there is no orbit, branch, map, flow or basin in this file")
    try:
        check_kept(dataset.attrs)
        check_numbers(dataset, content)
        known = READERS[content](dataset, parse(str(dataset.attrs["scenario"]), "the file's scenario"))
    except InputError:
        raise
    except (KeyError, IndexError, ValueError, TypeError, AttributeError, OverflowError) as error:
        why = " ".join(str(error).split())[:200]
        raise InputError(f"the file's {content.value} is not whole: {why}") from None
    if known == []:
        raise InputError(f"there are no {content.value} in this file: none was found, or it is damaged")
    return known


def _orbits(dataset: "xarray.Dataset", scenario: Scenario) -> list[Orbit]:
    return orbits_in(dataset, [scenario] * dataset.sizes["orbit"])


def _branches(dataset: "xarray.Dataset", scenario: Scenario) -> list[Branch]:
    path = str(dataset.attrs["input"])
    name = path.replace(".", "_")
    values, owners = _numbers(dataset, name), _numbers(dataset, "branch")
    orbits = orbits_in(dataset, [varied(scenario, {path: float(value)}) for value in values])
    nowhere = np.full(7, np.nan)
    points = [Point(float(value), orbit, nowhere) for value, orbit in zip(values, orbits, strict=True)]
    events, on = _events(dataset, scenario, path, name)
    result = []
    for number, ends in enumerate(_pairs(dataset.attrs["ends"])):
        own = [point for point, owner in zip(points, owners, strict=True) if owner == number]
        along = [point.value for point in own]
        mine = [event for event, owner in zip(events, on, strict=True) if owner == number]
        result.append(Branch(path, min(along), max(along), own, mine, ends, 0))
    return result


def _events(dataset: "xarray.Dataset", scenario: Scenario, path: str, name: str) -> tuple[list[Event], Floats]:
    """Changes of stability, and the number of the branch of each."""
    if "change_kind" not in dataset:
        return [], np.empty(0)
    values, places = _numbers(dataset, f"change_{name}"), _numbers(dataset, "change_index")
    orbits = orbits_in(dataset, [varied(scenario, {path: float(value)}) for value in values], prefix="change_")
    kinds = _changes(dataset, "change_kind")
    each = zip(kinds, values, orbits, places, strict=True)
    events = [Event(kind, float(value), orbit, int(place)) for kind, value, orbit, place in each]
    return events, _numbers(dataset, "change_branch")


def _map(dataset: "xarray.Dataset", scenario: Scenario) -> KnownMap:
    first, second = (str(dim) for dim in dataset["stability"].dims)
    paths = str(dataset[first].attrs["long_name"]), str(dataset[second].attrs["long_name"])
    values = _numbers(dataset, first), _numbers(dataset, second)
    known = StabilityMap(
        scenario, paths, values, _numbers(dataset, "growth"), _numbers(dataset, "swing"), _states(dataset)
    )
    if "boundary_curve" not in dataset:
        return KnownMap(known, [])
    owners, kinds = _numbers(dataset, "boundary_curve"), _changes(dataset, "boundary_kind")
    along = [_numbers(dataset, f"boundary_{name}") for name in (first, second)]
    states, swing = _states(dataset, "boundary_"), _numbers(dataset, "boundary_swing")
    curves = []
    for number, ends in enumerate(_pairs(dataset.attrs["boundary_ends"])):
        own = np.flatnonzero(owners == number)
        curves.append(
            BoundaryCurve(scenario, paths, kinds[own[0]], along[0][own], along[1][own], states[own], swing[own], ends)
        )
    return KnownMap(known, curves)


def _flow(dataset: "xarray.Dataset", scenario: Scenario) -> KnownFlow:
    axes = _axes(dataset)
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    states = np.concatenate([places, _numbers(dataset, "quaternion")], axis=-1)
    settled = _numbers(dataset, "settled") > 0.0
    flow = SlowFlow(scenario, axes, _numbers(dataset, "velocity"), states, settled)
    (orbit,) = orbits_in(dataset, [scenario], prefix="around_")
    points: list[FixedPoint] = []
    if "fixed_point_position" in dataset:
        rates = _numbers(dataset, "fixed_point_growth") + 1j * _numbers(dataset, "fixed_point_swing")
        errors = _numbers(dataset, "fixed_point_error")
        found = zip(_numbers(dataset, "fixed_point_position"), rates, errors, strict=True)
        points = [FixedPoint(position, rate, float(error)) for position, rate, error in found]
    return KnownFlow(flow, orbit, points, _starts(dataset, orbit))


def _starts(dataset: "xarray.Dataset", orbit: Orbit) -> Basin | None:
    """The starts that go with a flow."""
    if "start_position" not in dataset:
        return None
    places, captured = _numbers(dataset, "start_position"), _numbers(dataset, "start_captured") > 0.0
    sides = [np.unique(column).size for column in places.T]
    ends = np.where(captured, str(BasinEnd.CAPTURED), str(BasinEnd.NOT_RUN))
    shape = sides[0], sides[1], sides[2]
    return Basin(orbit, shape, places, captured, ends, float("nan"), float("nan"), "averaged")


def _basin(dataset: "xarray.Dataset", scenario: Scenario) -> Basin:
    check_basin(dataset)
    axes = _axes(dataset)
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    (orbit,) = orbits_in(dataset, [scenario], prefix="around_")
    ends = np.array([str(BasinEnd.of(int(code))) for code in _numbers(dataset, "end").ravel()])
    about = dataset.attrs
    known = Basin(
        orbit,
        (axes[0].size, axes[1].size, axes[2].size),
        places,
        _numbers(dataset, "captured").ravel() > 0.0,
        ends,
        float(about["volume"]),
        float(about["duration"]),
        str(about["engine"]),
    )
    return known if about["attitude"] == known.attitude else replace(known, attitude="released")


def _numbers(dataset: "xarray.Dataset", name: str) -> Floats:
    return np.asarray(dataset[name].values, dtype=np.float64)


def _states(dataset: "xarray.Dataset", prefix: str = "") -> Floats:
    return np.concatenate([_numbers(dataset, f"{prefix}position"), _numbers(dataset, f"{prefix}quaternion")], axis=-1)


def _axes(dataset: "xarray.Dataset") -> tuple[Floats, Floats, Floats]:
    return _numbers(dataset, "x"), _numbers(dataset, "y"), _numbers(dataset, "z")


def _changes(dataset: "xarray.Dataset", name: str) -> list[Change]:
    """A flag variable's changes of stability."""
    meanings = str(dataset[name].attrs["flag_meanings"]).split()
    by_word = {str(change).replace(" ", "_"): change for change in Change}
    return [by_word[meanings[int(code)]] for code in dataset[name].values]


def _pairs(text: str) -> list[tuple[str, str]]:
    """Ends of curves, as the files' attributes have them."""
    pairs = [part.split(", ", 1) for part in str(text).split("; ")]
    return [(first, last) for first, last in pairs]


READERS: "dict[Content, Callable[[xarray.Dataset, Scenario], Known]]" = {
    Content.ORBITS: _orbits,
    Content.BRANCHES: _branches,
    Content.MAP: _map,
    Content.FLOW: _flow,
    Content.BASIN: _basin,
}
