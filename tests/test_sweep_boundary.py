"""The adaptive mode: finds thin bands, stays in its budget, states an error bar that holds, and resumes."""

import math

import numpy as np
import pytest

import helimag
from helimag import Plan
from helimag.outcomes import Verdict
from helimag.sweeps import Axis, Boundary, boundary_line, load_sweep
from helimag.sweeps.boundary import ROUND, Seen, next_points, start_points
from helimag.sweeps.run import sweep


def explore(judge, counts, budget, resolution=0.01):
    """The rounds of a sweep, with a formula in place of runs: the points, and which are inside."""
    unit = start_points(counts, budget)
    while len(unit) < budget:
        new = next_points(Seen(unit, *judge(unit)), min(ROUND, budget - len(unit)), resolution)
        if len(new) == 0:
            break
        unit = np.concatenate([unit, new])
    return unit, judge(unit)[0]


def band(width, *, tells_side):
    """A slanting band; outside, devices are lost the sooner the farther, perhaps upwards above and downwards below."""

    def judge(unit):
        off = unit[:, 1] - (0.62 - 0.25 * unit[:, 0])
        inside = np.abs(off) < width / 2.0
        rises = off > 0.0 if tells_side else np.zeros(len(unit), bool)
        return inside, rises, np.where(inside, 1.0, 0.9 * np.exp(-np.abs(off) / 0.15))

    return judge


@pytest.mark.parametrize("tells_side", [True, False])
def test_a_band_of_a_thirtieth_is_found_where_the_grid_sees_none(tells_side):
    judge = band(1.0 / 30.0, tells_side=tells_side)
    grid = start_points((5, 6), 30)
    assert not judge(grid)[0].any()
    unit, inside = explore(judge, (5, 6), 200)
    assert len(unit) <= 200
    assert inside.sum() >= 15
    assert np.ptp(unit[inside, 0]) > 0.8  # along its whole length


def test_the_error_bar_holds_the_boundary_and_shrinks_with_the_budget():
    judge = band(0.3, tells_side=True)
    errors = []
    for budget in (64, 128, 256):
        unit, inside = explore(judge, (4, 4), budget)
        line = boundary_line(dataset(unit, inside))
        for (x, y), (dx, dy) in zip(line.points, line.error, strict=True):
            corners = np.array([[x - dx, y - dy], [x + dx, y + dy], [x - dx, y + dy], [x + dx, y - dy]])
            assert len(set(judge(corners)[0].tolist())) == 2, "the bar does not reach over the boundary"
        errors.append(np.hypot(*line.median_error))
    assert errors[0] > 1.5 * errors[1] > 2.0 * errors[2]


def test_it_ends_before_the_budget_where_all_is_resolved():
    unit, _ = explore(band(0.3, tells_side=True), (4, 4), 4000, resolution=0.1)
    assert len(unit) < 400


def dataset(unit, inside):
    import xarray

    plan = Plan(
        base="nose-first/fig3c",
        axis=(
            Axis(field="drive.frequency", start="1 Hz", stop="2 Hz", count=4),
            Axis(field="drive.distance", start="1 m", stop="2 m", count=4),
        ),
        boundary=Boundary(budget=64),
    )
    flags = np.where(inside, Verdict.BOUNDED.flag, Verdict.FELL.flag).astype(np.int8)
    return xarray.Dataset(
        {"verdict": ("point", flags)},
        {
            "frequency": ("point", unit[:, 0], {"long_name": "drive.frequency"}),
            "distance": ("point", unit[:, 1], {"long_name": "drive.distance"}),
        },
        {"plan": plan.to_toml()},
    )


def real(budget, duration="1800 s"):
    return Plan(
        base="nose-first/fig3c",
        duration=duration,
        axis=(
            Axis(field="drive.frequency", start="3.25 Hz", stop="3.45 Hz", count=3),
            Axis(field="drive.pitch", start="3 deg", stop="23 deg", count=5),
        ),
        boundary=Boundary(budget=budget, resolution=0.02),
    )


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    store = tmp_path_factory.mktemp("boundary") / "s.zarr"
    return store, helimag.sweep(real(112), out=store).load()


def test_the_devices_own_band_is_found_between_the_coarse_runs(found):
    data = found[1]
    assert not np.any(data["verdict"].values[:15] == Verdict.BOUNDED)  # the grid: 3 x 5 runs, 5 deg apart
    inside = data["verdict"].values == Verdict.BOUNDED
    assert inside.sum() >= 3
    column = Plan(
        base="nose-first/fig3c",
        duration="1800 s",
        changes={"drive.frequency": "3.3 Hz"},
        axis=(Axis(field="drive.pitch", start="9 deg", stop="13 deg", step="0.25 deg"),),
    )
    line = helimag.sweep(column, out=found[0].parent / "column.zarr").load()
    bounded = line["pitch"].values[line["verdict"].values == Verdict.BOUNDED]
    # one degree wide at 3.3 Hz; below it runs lose step for so long that a tolerance decides which of them stay
    assert 0.7 < math.degrees(np.ptp(bounded)) < 1.6
    near = inside & (np.abs(data["frequency"].values - 3.3) < 0.06)
    assert np.any(
        (data["pitch"].values[near] >= bounded[0] - 0.01) & (data["pitch"].values[near] <= bounded[-1] + 0.01)
    )
    assert np.all(np.isfinite(boundary_line(data).median_error))


def test_a_resumed_search_takes_the_same_way(tmp_path):
    plan = real(64, duration="150 s")
    helimag.sweep(plan, out=tmp_path / "alone.zarr")

    def interrupt(progress):
        if progress.done >= 40:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(plan, out=tmp_path / "s.zarr", progress=interrupt)
    helimag.sweep(plan, out=tmp_path / "s.zarr")
    whole, again = (load_sweep(tmp_path / name).load() for name in ("alone.zarr", "s.zarr"))
    assert whole.identical(again)
    assert whole.sizes["point"] == 64
