"""Figures of orbits: lines end where stability does, curves lie where they belong."""

import math
from pathlib import Path

import numpy as np
import pytest

import helimag as hm
from helimag import Plan, plots
from helimag.orbits import BoundaryCurve, Branch, Change, StabilityMap, follow
from helimag.outcomes import Verdict
from helimag.plots.sweeps import draw_sweep
from helimag.sweeps import Axis

FREQUENCY = Axis(field="drive.frequency", start="2 Hz", stop="3 Hz", count=9)
PITCH = Axis(field="drive.pitch", start="4 deg", stop="16 deg", count=3)


@pytest.fixture(scope="module")
def scenario() -> hm.Scenario:
    return hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})


@pytest.fixture(scope="module")
def branch(scenario: hm.Scenario) -> Branch:
    return follow(hm.find_orbit(scenario), "drive.pitch", math.radians(12.0), math.radians(17.0))


def a_curve(scenario: hm.Scenario, **changes: object) -> BoundaryCurve:
    first, second = np.radians([6.0, 8.0, 12.0]), np.array([3.4, 2.5, 2.1])
    given = {"kind": Change.FOLD, "ends": ("fold-Neimark-Sacker", "edge of the map")} | changes
    return BoundaryCurve(
        scenario=scenario,
        paths=("drive.pitch", "drive.frequency"),
        first=first,
        second=second,
        states=np.zeros((3, 7)),
        swing=np.zeros(3),
        **given,
    )


def test_lines_of_a_branch_end_at_its_events(branch: Branch) -> None:
    (fold,) = branch.events
    for axes, height in zip(
        plots.draw_branches([branch]).axes, (1e3 * fold.orbit.mean_position[2], fold.orbit.growth), strict=True
    ):
        stable, unstable = (
            next(line for line in axes.lines if line.get_label() == label) for label in ("stable", "unstable")
        )
        for line, others in ((stable, True), (unstable, False)):
            drawn = np.array(line.get_data()).T
            at = np.argmax(drawn[:, 0])
            assert drawn[at] == pytest.approx([math.degrees(fold.value), height])
            assert at in (0, len(drawn) - 1)
            assert len(drawn) == 1 + sum(point.orbit.stable is others for point in branch.points)


def test_a_branch_followed_while_stable_is_drawn_stable_alone(branch: Branch) -> None:
    orbit = branch.points[branch.origin].orbit
    short = follow(orbit, "drive.pitch", math.radians(12.0), math.radians(17.0), while_stable=True)
    axes = plots.draw_branches([short]).axes[0]
    labels = [line.get_label() for line in axes.lines]
    assert labels == ["stable", "fold"]
    assert np.max(axes.lines[0].get_xdata()) == pytest.approx(math.degrees(short.events[0].value))


def test_a_stability_map_shows_curves_in_the_units_of_its_axes(scenario: hm.Scenario) -> None:
    values = np.radians([4.0, 10.0, 16.0]), np.array([2.0, 2.5, 3.0])
    growth = np.full((3, 3), -1e-3)
    growth[2] = np.nan
    result = StabilityMap(scenario, ("drive.pitch", "drive.frequency"), values, growth, growth, np.zeros((3, 3, 7)))
    curves = [a_curve(scenario), a_curve(scenario, kind=Change.NEIMARK_SACKER, ends=("closed", "closed"))]
    figure = plots.draw_stability(result, curves)
    fold, mark, swing = figure.axes[0].lines
    np.testing.assert_allclose(fold.get_xdata(), [6.0, 8.0, 12.0])
    np.testing.assert_allclose(fold.get_ydata(), [3.4, 2.5, 2.1])
    assert (mark.get_xdata()[0], mark.get_ydata()[0]) == pytest.approx((6.0, 3.4))
    assert fold.get_linestyle() != swing.get_linestyle()
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["fold", "fold-Neimark-Sacker", "Neimark-Sacker"]
    other = StabilityMap(scenario, ("drive.pitch", "drive.distance"), values, growth, growth, np.zeros((3, 3, 7)))
    with pytest.raises(hm.InputError, match="over the map's inputs"):
        plots.draw_stability(other, curves)


def test_a_stability_map_without_stable_orbits_says_so_and_has_no_scale(scenario: hm.Scenario) -> None:
    values = np.radians([4.0, 10.0]), np.array([2.0, 2.5, 3.0])
    unstable = np.full((2, 3), 1e-3)
    paths = ("drive.pitch", "drive.frequency")
    (axes,) = plots.draw_stability(StabilityMap(scenario, paths, values, unstable, unstable, np.zeros((2, 3, 7)))).axes
    assert [text.get_text() for text in axes.texts] == ["no stable orbit in these ranges"]
    assert axes.get_title().splitlines()[0] == scenario.title
    assert axes.get_xlim() == pytest.approx((4.0, 10.0))


def a_sweep(folder: Path, *axes: Axis) -> object:
    plan = Plan(base="nose-first/fig3c", duration="4 s", samples=20, axis=axes)
    data = hm.sweep(plan, out=folder / "s.zarr").load()
    data["verdict"].values[:] = Verdict.FELL.flag
    return data


def test_curves_lie_over_maps_of_the_same_inputs_either_way_round(tmp_path: Path, scenario: hm.Scenario) -> None:
    data = a_sweep(tmp_path, FREQUENCY, PITCH)
    (plain,) = draw_sweep(data).axes
    (axes,) = draw_sweep(data, curves=[a_curve(scenario)]).axes
    curve = axes.lines[0]
    np.testing.assert_allclose(curve.get_xdata(), [3.4, 2.5, 2.1])
    np.testing.assert_allclose(curve.get_ydata(), [6.0, 8.0, 12.0])
    assert (axes.get_xlim(), axes.get_ylim()) == (plain.get_xlim(), plain.get_ylim())
    fine = PITCH.model_copy(update={"count": 9})
    (axes,) = draw_sweep(
        a_sweep(tmp_path / "b", fine, FREQUENCY.model_copy(update={"count": 2})), curves=[a_curve(scenario)]
    ).axes
    np.testing.assert_allclose(axes.lines[0].get_xdata(), [6.0, 8.0, 12.0])


def test_curves_lie_over_the_panels_of_their_other_inputs_alone(tmp_path: Path, scenario: hm.Scenario) -> None:
    distance = Axis(field="drive.distance", values=("140 mm", "150 mm"))
    data = a_sweep(tmp_path, distance, FREQUENCY, PITCH)
    empty, full = draw_sweep(data, curves=[a_curve(scenario)]).axes
    assert (len(empty.lines), len(full.lines)) == (0, 2)
    # the arm's way begins above the start
    for change in ({"fluid.viscosity": "2 Pa s"}, {"drive.distance": "160 mm"}, {"drive.start": ["0 mm"] * 3}):
        with pytest.raises(hm.InputError, match="belongs to no map"):
            draw_sweep(data, curves=[a_curve(scenario.replaced(change))])
    later = scenario.replaced({"run.duration": "5 s", "workspace": {}})
    assert len(draw_sweep(data, curves=[a_curve(later)]).axes[1].lines) == 2
