"""Orbits over grids of any dimension, over a whole range of an input, and against the verdicts of a sweep."""

import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

import helimag as hm
from helimag.cli import main
from helimag.gain import Verdict
from helimag.orbits import Why, compare_with_orbits, stable_segments, survey
from helimag.orbits.against import _why, away_from_boundary
from helimag.orbits.spreading import Spread
from helimag.sweeps import nodes_of

# as from a shell
pytestmark = pytest.mark.filterwarnings("ignore:Cyclopts application invoked without tokens")

PLAN = """
base = "paper/fig3c"
duration = "900 s"
[[axis]]
field = "drive.pitch"
values = ["4.2 deg", "8 deg", "12.7 deg", "20 deg"]
[[axis]]
field = "drive.frequency"
values = ["2.2 Hz", "2.5 Hz", "3.3 Hz"]
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("against")
    (folder / "plan.toml").write_text(PLAN)
    hm.sweep(folder / "plan.toml", out=folder / "runs.zarr")
    return folder / "runs.zarr"


def test_spread_over_three_inputs_finds_what_is_found_one_by_one() -> None:
    base = hm.load("paper/fig3c")
    values = {
        "drive.frequency": [2.2, 2.5, 2.8],
        "drive.pitch": [math.radians(p) for p in (8.0, 11.0, 14.0)],
        "drive.distance": [0.145, 0.150],
    }

    def scenario_at(node: tuple[int, ...]) -> hm.Scenario:
        return base.replaced({path: line[i] for (path, line), i in zip(values.items(), node, strict=True)})

    found = Spread(scenario_at, (3, 3, 2), length=0.15)
    found.seek_all_over()
    found.spread(lambda _: None)
    for node in ((0, 0, 0), (2, 1, 1), (2, 2, 0)):
        orbit = hm.find_orbit(scenario_at(node))
        assert found.stable[node] == orbit.stable
        if orbit.stable:
            assert found.growth[node] == pytest.approx(orbit.growth, rel=1e-4)
            assert found.states[node][:3] == pytest.approx(orbit.position, abs=1e-8)
    assert found.stable.sum() > 9


def test_survey_finds_the_stable_stretch_that_the_scenario_is_not_in() -> None:
    scenario = hm.load("paper/fig3c")
    assert not hm.find_orbit(scenario).stable
    (branch,) = survey(scenario, "drive.pitch", math.radians(6.5), math.radians(13.0))
    (part,) = stable_segments(branch)
    assert part.why_high == "fold"
    inside, outside = (
        hm.find_orbit(scenario.replaced({"drive.pitch": part.high + by}), near=branch.events[-1].orbit)
        for by in (-1e-4, 1e-4)
    )
    assert inside.found
    assert not outside.stable
    assert survey(scenario, "drive.pitch", math.radians(6.5), math.radians(13.0), known=[branch]) == [branch]


def test_nodes_of_a_sweep_are_the_scenarios_that_were_run(store: Path) -> None:
    nodes = nodes_of(hm.load_sweep(store))
    assert nodes.verdicts.shape == (4, 3)
    node = (2, 1)
    assert nodes.values_at(node) == {"drive.pitch": pytest.approx(math.radians(12.7)), "drive.frequency": 2.5}
    scenario = nodes.scenario_at(node)
    assert scenario is not None
    assert scenario.run.duration == 900.0
    assert str(hm.simulate(scenario).verdict) == nodes.verdicts[node]


def test_nodes_need_a_grid(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(
        'base = "paper/fig3c"\nduration = "10 s"\nsample = { method = "sobol", count = 4 }\n'
        '[[axis]]\nfield = "drive.pitch"\nstart = "4 deg"\nstop = "8 deg"\n'
    )
    dataset = hm.sweep(tmp_path / "plan.toml", out=tmp_path / "runs.zarr")
    with pytest.raises(hm.InputError, match="grid"):
        nodes_of(dataset)


def test_each_difference_is_run_on_and_named(store: Path) -> None:
    nodes = nodes_of(hm.load_sweep(store))
    result = compare_with_orbits(nodes.scenario_at, nodes.verdicts)
    assert result.stable[2].tolist() == [True, True, False]
    assert not result.stable[3].any()
    listed = {case.node: case for case in result.cases}
    for node in np.ndindex(result.verdicts.shape):
        inside = result.verdicts[node] in ("bounded", "drifting")
        assert (node in listed) == (result.verdicts[node] == "drifting" or inside != result.stable[node])
    late = listed[2, 2]  # Fig. 3(C): inside at its horizon, attracted at 2275 s
    assert late.why is Why.SLOW_DRIFT
    assert late.later is Verdict.ATTRACTED
    assert late.later_end == pytest.approx(2275.0, abs=5.0)
    assert listed[1, 2].why is Why.BASIN
    assert result.beside[1, 2]
    assert "starts outside the basin" in result.text


@pytest.mark.parametrize(
    ("verdict", "stable", "stays", "beside", "why"),
    [
        (Verdict.FELL, True, False, True, Why.BASIN),
        (Verdict.DRIFTING, True, False, True, Why.BASIN),
        (Verdict.FELL, True, True, True, Why.SOON),
        (Verdict.DRIFTING, True, True, True, Why.SLOW_DRIFT),
        (Verdict.DRIFTING, False, False, False, Why.SLOW_DRIFT),
        (Verdict.BOUNDED, False, False, False, Why.SHORT),
        (Verdict.BOUNDED, False, True, False, Why.OTHER),
        (Verdict.FELL, True, False, False, Why.UNEXPLAINED),
    ],
)
def test_reasons(verdict: Verdict, stable: bool, stays: bool, beside: bool, why: Why) -> None:
    assert _why(verdict, stable, stays, beside) is why
    assert why.meaning


def test_nodes_beside_the_boundary_are_those_with_a_neighbour_of_the_other_kind() -> None:
    stable = np.zeros((5, 5), dtype=bool)
    stable[0, 0] = True
    away = away_from_boundary(stable)
    assert not away[:2, :2].any()
    assert away.sum() == 21


def test_the_command_prints_draws_and_reports(
    store: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    picture, data = tmp_path / "map.png", tmp_path / "map.nc"
    words = ["orbit", "against", store, "--json", "-o", picture, "-o", data]
    monkeypatch.setattr(sys, "argv", ["helimag", *(str(word) for word in words)])
    main()
    out, err = capsys.readouterr()
    assert err == ""
    report = json.loads(out)
    assert report["nodes"] == 12
    assert {case["why"] for case in report["cases"]} >= {"slow drift", "starts outside the basin"}
    assert picture.stat().st_size > 10_000
    with xarray.open_dataset(data, engine="h5netcdf", decode_timedelta=False) as opened:
        meanings = opened.why.attrs["flag_meanings"].split()
        explained = int((opened.why > 0).sum())
        assert meanings[int(opened.why.values[2, 2])] == "slow_drift"
    assert explained == len(report["cases"])
