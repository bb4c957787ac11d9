"""Sweeps whose points are run with devices of a calibration: shares beside predictions, resuming, refusals, figures."""

import csv
import dataclasses
import json

import numpy as np
import pytest

import helimag as hm
from fits import posterior
from helimag import calibration as cal
from helimag import plots
from helimag.errors import InputError
from helimag.outcomes import End, Verdict
from helimag.runs.shares import in_percent, wilson
from helimag.sweeps import estimate, export, load_plan, nodes_of, parse_plan, resolve, with_ensemble

# a row of Table I that has come to the surface, the floor or neither after 12 s, as its device and its magnet have it
BASE = hm.load("paper/table1-row1").replaced(
    {
        "device.hydrodynamics.model": "lighthill",
        "workspace.surface": 0.003,
        "workspace.floor": -0.004,
        "run.duration": 12.0,
        "provenance": {},
    }
)
WEIGHTS = [50.5e-6, 30e-6, 42e-6, 58e-6, 74e-6, 90e-6]
PLAN = """
name = "how likely it stays"
base = "base.toml"
samples = 40
[[axis]]
field = "drive.distance"
values = ["95 mm", "102 mm", "109 mm"]
[ensemble]
fit = "fit.nc"
draws = 6
seed = 2
noise = { "drive.pitch" = "0.5 deg" }
displacement = "50 um"
"""


@pytest.fixture(scope="module")
def fit():
    moments = [0.6e-3, 0.61e-3, 0.6e-3, 0.62e-3, 0.6e-3, 0.6e-3]
    return posterior(
        BASE, {"device.weight.net_weight": WEIGHTS, "device.magnetic_moment": moments, "fluid.viscosity": [1.0] * 6}
    )


@pytest.fixture(scope="module")
def place(fit, tmp_path_factory):
    folder = tmp_path_factory.mktemp("ensemble")
    (folder / "base.toml").write_text(BASE.to_toml(), encoding="utf-8")
    (folder / "plan.toml").write_text(PLAN, encoding="utf-8")
    fit.save(folder / "fit.nc")
    return folder


@pytest.fixture(scope="module")
def swept(place):
    return hm.sweep(place / "plan.toml", out=place / "s.zarr")


def test_each_point_is_a_prediction(swept, fit):
    """What the store holds is what ``predict`` says of each point by itself, with the same errors."""
    noise = cal.Noise({"drive.pitch": np.radians(0.5)}, 5e-5)
    ends = set()
    for point in swept["distance"].values.tolist():
        scenario = BASE.replaced({"drive.distance": point, "run.interval": 12.0 / 40})
        found = cal.predict(scenario, fit, draws=6, seed=2, noise=noise)
        row = swept.sel(distance=point)
        shares = {each["verdict"]: each["probability"] for each in found.numbers["outcomes"]}
        for verdict in (each for each in Verdict if each.judged):
            name = f"probability_{verdict}".replace("-", "_")
            assert float(row[name]) == shares.get(str(verdict), 0.0), (point, name)
        inside = sum(judgement.escape_time is None for judgement in found.runs.judgements)
        assert float(row["probability_inside"]) == inside / 6
        assert float(row["probability_failed"]) == 0.0
        for name in ("p05", "p50", "p95"):
            assert float(row[f"gain_{name}"]) == found.numbers["gain"][name]
        assert float(row["gain"]) == found.runs.judgement.gain
        ends |= set(shares)
    assert len(ends) > 1
    assert len(set(swept["probability_inside"].values.tolist())) > 1


def test_the_nominal_run_has_the_likeliest_device(swept):
    nodes = nodes_of(swept)
    assert nodes.base.device.weight.net_weight == WEIGHTS[0]
    scenario = nodes.scenario_at((1,))
    assert scenario.hash == bytes(swept["scenario_hash"].values[1].tobytes()).hex()
    alone = BASE.replaced({"device.weight.net_weight": WEIGHTS[0], "run.interval": 12.0 / 40})
    alone = alone.replaced({"device.magnetic_moment": 0.6e-3})
    assert hm.simulate(alone).gain == pytest.approx(float(swept["gain"][1]), rel=1e-12)


def test_a_factor_multiplies_the_scenarios_own(place):
    """Twice: the likeliest device is in the base already, and the drawn ones must not have its factor as well."""
    factors = posterior(BASE, {"fluid.viscosity": [1.5, 0.5]}, factors=("fluid.viscosity",))
    factors.save(place / "factors.nc")
    plan = with_ensemble(load_plan(place / "plan.toml"), {"fit": str(place / "factors.nc"), "draws": 2})
    resolved = resolve(plan)
    assert resolved.base.fluid.viscosity == 1.5
    point = resolved.scenario({"drive.distance": 0.1})
    assert {copy.fluid.viscosity for copy in resolved.devices.copies(point).scenarios} == {0.5, 1.5}


def test_a_device_that_a_point_cannot_have_counts_as_failed(place):
    """A moment of zero is refused by the scenario; the other device runs."""
    posterior(BASE, {"device.weight.net_weight": [50e-6, 51e-6], "fluid.viscosity": [1.0, -1.0]}).save(place / "bad.nc")
    plan = with_ensemble(load_plan(place / "plan.toml"), {"fit": str(place / "bad.nc"), "draws": 2, "noise": {}})
    found = hm.sweep(plan, out=place / "bad.zarr")
    assert found["probability_failed"].values.tolist() == [0.5] * 3
    assert np.isfinite(found["gain_p50"].values).all()


def test_a_batch_holds_as_many_runs_as_it_may_however_many_devices_there_are(place, monkeypatch):
    """Few at once, so that memory does not grow with the draws; and each run is the same in whatever company."""
    from helimag.sweeps import compute

    resolved = resolve(load_plan(place / "plan.toml"))
    scenarios = [resolved.scenario({"drive.distance": distance}) for distance in (0.095, 0.102, 0.109)]
    kept = compute.Kept(devices=resolved.devices)
    whole = compute.compute(scenarios, kept)
    sizes, told = [], []
    advance = compute.advance

    def counted(batch, **options):
        sizes.append(len(batch))
        return advance(batch, **options)

    monkeypatch.setattr(compute, "advance", counted)
    for name in ("FEWEST_AT_ONCE", "MOST_AT_ONCE"):
        monkeypatch.setattr(compute, name, 4)
    parts = compute.compute([None, *scenarios], kept, progress=told.append)
    assert sizes == [4, 4, 4, 4, 4, 1]
    assert told == sorted(told)
    assert told[-1] == 1.0
    for name, values in whole.items():
        np.testing.assert_array_equal(parts[name][1:], values, err_msg=name)
    assert np.isnan(parts["probability_inside"][0])


def test_short_runs_are_made_more_at_once_as_far_as_their_samples_fit(monkeypatch):
    from helimag.sweeps import compute

    base = hm.load("nose-first/fig3c").replaced({"run.duration": 0.5, "run.interval": 0.025})
    scenarios = [base.replaced({"drive.pitch": 0.0005 * i}) for i in range(520)]
    advance, sizes = compute.advance, []
    monkeypatch.setattr(compute, "advance", lambda batch, **rest: sizes.append(len(batch)) or advance(batch, **rest))
    monkeypatch.setattr(compute, "MOST_AT_ONCE", 512)
    whole = compute.compute(scenarios)
    monkeypatch.setattr(compute, "SAMPLES_AT_ONCE", 1300)
    parts = compute.compute(scenarios)
    assert sizes == [512, 8, 65, 65, 65, 65, 65, 65, 65, 65]
    for name, values in whole.items():
        np.testing.assert_array_equal(parts[name], values, err_msg=name)


def test_a_device_whose_numbers_break_down_counts_as_failed(place, monkeypatch):
    from helimag.sweeps import compute

    resolved = resolve(load_plan(place / "plan.toml"))
    advance = compute.advance

    def broken(batch, **options):
        first, second, *rest = advance(batch, **options)
        return [first, dataclasses.replace(second, status=End.NOT_FINITE), *rest]

    monkeypatch.setattr(compute, "advance", broken)
    rows = compute.compute([resolved.scenario({"drive.distance": 0.1})], compute.Kept(devices=resolved.devices))
    assert rows["probability_failed"].tolist() == [1 / 6]
    assert sum(rows[name][0] for name in compute.PROBABILITIES) == pytest.approx(5 / 6)


def contents(store):
    return {str(path.relative_to(store)): path.read_bytes() for path in sorted(store.rglob("*")) if path.is_file()}


def test_it_goes_on_to_the_same_bits_and_refuses_another_fit(place, swept):
    """Chunks as small as two points, so that a stop leaves some."""
    from helimag.sweeps import run

    class StopError(Exception):
        pass

    def stop(progress):
        if progress.done:
            raise StopError

    assert run.SweepProgress(total=21).total == resolve(load_plan(place / "plan.toml")).runs == 3 * 7
    with pytest.raises(StopError):
        hm.sweep(place / "plan.toml", out=place / "half.zarr", progress=stop, threads=1)
    assert not np.all(hm.load_sweep(place / "half.zarr")["verdict"].values)
    again = hm.sweep(place / "plan.toml", out=place / "half.zarr")
    assert np.all(again["verdict"].values)
    assert contents(place / "half.zarr") == contents(place / "s.zarr")
    other = posterior(BASE, {"device.weight.net_weight": [WEIGHTS[0], *(w + 1e-9 for w in WEIGHTS[1:])]})
    other.save(place / "other.nc")
    plan = with_ensemble(load_plan(place / "plan.toml"), {"fit": str(place / "other.nc")})
    with pytest.raises(InputError, match="holds another plan"):
        hm.sweep(plan, out=place / "s.zarr")
    assert parse_plan(swept.attrs["plan"]).ensemble.draws == 6


def test_the_command_with_an_ensemble(place, helimag, swept, monkeypatch):
    monkeypatch.chdir(place)
    (place / "plain.toml").write_text(PLAN.split("[ensemble]")[0], encoding="utf-8")
    options = ("--ensemble", "fit.nc", "--draws", "6", "--seed", "2")
    options += ("--noise", "drive.pitch=0.5 deg", "--displacement", "50 um")
    status, out, err = helimag("sweep", "plain.toml", *options, "--dry-run", "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)["runs"] == 21
    status, out, _ = helimag("sweep", "plain.toml", *options, "-o", "c.zarr", "-o", "c.csv", "--json")
    assert status == 0
    assert json.loads(out)["runs"] == 21
    told = json.loads(out)["ensemble"]
    assert told["draws"] == 6
    assert told["most_inside"] == swept["probability_inside"].values.max()
    assert told["most_inside_95"] == list(wilson(told["most_inside"], 6))
    low, most = (in_percent(share) for share in (told["most_inside_95"][0], told["most_inside"]))
    words = helimag("sweep", "plain.toml", *options, "-o", "c.zarr")[1]
    assert f" to {most}% ({low}% to " in words
    assert "stay to the end, with 95 % confidence at each point" in words
    for name in ("gain", "gain_p95", "probability_wall_limited"):
        assert np.array_equal(hm.load_sweep("c.zarr")[name].values, swept[name].values)
    rows = list(csv.DictReader((place / "c.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(row["probability_inside (1)"]) for row in rows] == swept["probability_inside"].values.tolist()
    export(swept, place / "c.nc")
    status, out, _ = helimag("sweep", "plan.toml", "--draws", "2", "--dry-run", "--json")
    assert (status, json.loads(out)["runs"]) == (0, 9)
    assert estimate(place / "plan.toml").runs == 21


def test_a_trial_counts_the_runs_of_devices(place, monkeypatch):
    """One point of seven runs is as many as a trial of eight may begin; the estimate is of all points."""
    from helimag.sweeps import trial

    begun = []
    monkeypatch.setattr(trial, "TRIAL_SECONDS", 0.0)  # as if whole runs took too long
    monkeypatch.setattr(trial, "_seconds", lambda made, *_: begun.append(len(made)) or 1.0 * len(made))
    monkeypatch.setattr(trial, "_store", lambda _: (1000, 0.25))
    found = estimate(place / "plan.toml", threads=2)
    assert begun == [1]
    assert (found.whole, found.trial_runs, found.runs, found.bytes) == (False, 7, 21, 1000)
    assert found.seconds == pytest.approx(3.25)  # of three points, and what the store takes


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("drive.distance", "device.weight.net_weight", "is an axis of the plan, but the calibration decides it"),
        (
            "drive.distance",
            "device.helix.length",
            "'device.helix.length' is an axis of the plan, but the calibration is",
        ),
        ("fit.nc", "none.nc", "there is no file"),
        ("fit.nc", "base.toml", "cannot be read as netCDF"),
        ("draws = 6", "draws = 0", "draws"),
        ('"0.5 deg"', '"0.5 mm"', "ensemble.noise drive.pitch: "),
        ('"0.5 deg"', '"0 deg"', "must be above zero"),
        (
            "[[axis]]",
            '[changes]\n"device.helix.length" = "3 mm"\n[[axis]]',
            "is of another device: device.helix.length",
        ),
        (
            'values = ["95 mm", "102 mm", "109 mm"]',
            'start = "95 mm"\nstop = "109 mm"',
            "must be a grid or list or range",
        ),
        ("[ensemble]", "[boundary]\nbudget = 32\n[ensemble]", "has no [boundary]"),
    ],
)
def test_an_ensemble_that_does_not_fit_says_so_in_one_line(place, helimag, old, new, said):
    others = {"device.weight.net_weight": '["50 uN"]', "device.helix.length": '["3 mm", "4 mm"]'}
    values = ('["95 mm", "102 mm", "109 mm"]', others[new]) if new in others else ("", "")
    (place / "wrong.toml").write_text(PLAN.replace(old, new, 1).replace(*values), encoding="utf-8")
    status, out, err = helimag("sweep", str(place / "wrong.toml"), "-o", str(place / "wrong.zarr"))
    assert (status, out) == (2, "")
    assert said in err
    assert len(err.splitlines()) == 1
    assert not (place / "wrong.zarr").exists()


def test_options_without_an_ensemble_are_refused(place, helimag, monkeypatch):
    monkeypatch.chdir(place)
    (place / "plain.toml").write_text(PLAN.split("[ensemble]")[0], encoding="utf-8")
    status, _, err = helimag("sweep", "plain.toml", "--draws", "3", "--dry-run")
    assert status == 2
    assert "--draws goes with --ensemble only" in err


def test_figures_show_the_shares(swept):
    """A line has a band and a second axis; a plane has the shares themselves as its colours, and their scale."""
    (line,) = [axes for axes in plots.draw_sweep(swept).axes if axes.get_ylabel() == "share that stays"]
    np.testing.assert_array_equal(line.lines[0].get_ydata(), swept["probability_inside"].values)
    plane = xarray_plane(swept)
    figure = plots.draw_sweep(plane)
    mesh = figure.axes[0].collections[0]
    np.testing.assert_array_equal(np.ravel(mesh.get_array()), plane["probability_inside"].values.T.ravel())
    assert figure.axes[-1].get_ylabel() == "share of devices that stay to the end"
    page = plots.interactive_sweep(swept)
    assert any("of the devices stay to the end" in text for trace in page.data for text in np.ravel(trace.text) if text)


def xarray_plane(swept):
    """The same sweep along a second axis too, as a plan over two would give it."""
    pitches = [-0.2, -0.1]
    plan = PLAN.replace("[ensemble]", '[[axis]]\nfield = "drive.pitch"\nvalues = ["-11 deg", "-6 deg"]\n[ensemble]')
    plane = swept.drop_vars("pitch").expand_dims(pitch=pitches, axis=1).transpose("distance", "pitch", ...)
    plane["pitch"].attrs |= swept["pitch"].attrs
    return plane.assign_attrs(plan=plan)
