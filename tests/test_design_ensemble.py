"""Designs over the devices that a calibration leaves: the likeliest to stay, and a share that runs show."""

import json

import numpy as np
import pytest

import helimag as hm
from fits import posterior
from helimag import calibration as cal
from helimag.design import candidates, design, full_runs
from helimag.design.likely import likeliest
from helimag.design.task import DesignTask
from helimag.engine import advance
from helimag.ensembles import Devices
from helimag.orbits import Watch
from helimag.outcomes import Verdict
from helimag.runs.shares import in_percent
from helimag.scenario import varied

BASE = hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})
WEIGHT = BASE.device.weight.net_weight
LIMITS = {"drive.frequency": (2.0, 3.2), "drive.pitch": (np.radians(6.0), np.radians(16.0))}


@pytest.fixture
def quick(monkeypatch):
    for module, name, value in (
        (candidates, "SAMPLES", 16),
        (candidates, "SOLVED", 3),
        (full_runs, "LONGEST_RUN", 2400.0),
    ):
        monkeypatch.setattr(module, name, value)


@pytest.fixture(scope="module")
def fit():
    """Of ten devices; the heaviest and the lightest are lost wherever the limits allow to go."""
    return posterior(BASE, {"device.weight.net_weight": [WEIGHT, *(WEIGHT * np.linspace(0.5, 1.5, 9)).tolist()]})


@pytest.mark.usefixtures("quick")
def test_the_share_of_a_design_is_that_of_runs_with_its_devices(fit):
    devices = cal.drawn(fit, BASE, draws=10)
    found = design(BASE, speed=4.5e-4, limits=LIMITS, devices=devices)
    assert found.orbit.stable
    assert found.orbit.speed == pytest.approx(4.5e-4, rel=1e-5)
    assert found.tolerances == {}
    assert "±" not in found.text
    runs = advance([varied(found.scenario, {"device.weight.net_weight": w}) for w in fit.samples[:, 0].tolist()])
    staying = sum(run.judge().verdict is Verdict.BOUNDED for run in runs)
    assert 0 < staying < 10
    assert found.bounded == staying
    assert sum(found.verdicts.values()) == 10
    share, low, high = found.probability
    assert share == staying / 10
    assert low < share < high
    said = f"bounded with a probability of {in_percent(share)}% ({in_percent(low)}% to {in_percent(high)}%"
    assert said in found.text


def test_the_candidate_that_most_devices_stay_with_is_taken(monkeypatch):
    """The second is on an orbit of the same device; the first has a pitch at which errors of pitch lose most runs."""
    monkeypatch.setattr(full_runs, "LONGEST_RUN", 2400.0)
    middle = hm.find_orbit(BASE)
    task = DesignTask(BASE, {"drive.pitch": (np.radians(3.0), np.radians(25.0))}, {}, 0)
    interval = hm.orbits.stable_interval(middle, "drive.pitch", *(np.radians([3.0, 25.0])))
    edge = hm.find_orbit(BASE.replaced({"drive.pitch": interval.high - np.radians(0.05)}), near=middle)
    noise = cal.Noise({"drive.pitch": np.radians(1.0)})
    devices = Devices((), np.empty(0), np.empty((12, 0)), noise)
    tried = []
    found = likeliest(task, devices, [edge, middle], True, Watch(), tried)
    assert found.orbit is middle
    assert tried == []
    assert sum(found.verdicts.values()) == 12
    assert found.bounded > 8


@pytest.mark.usefixtures("quick")
def test_the_command_and_what_it_refuses(fit, helimag, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "base.toml").write_text(BASE.to_toml(), encoding="utf-8")
    fit.save("fit.nc")
    limits = ["--limit", "drive.frequency=2 Hz..3.2 Hz", "--limit", "drive.pitch=6 deg..16 deg"]
    status, out, err = helimag("design", "base.toml", *limits, "--ensemble", "fit.nc", "--runs", "4", "--json")
    assert (status, err) == (0, "")
    told = json.loads(out)
    assert sum(told["runs"].values()) == 4
    assert told["probability_bounded"]["share"] == told["runs"]["bounded"] / 4
    assert told["inputs"]["drive.pitch"]["tolerance"] is None
    for options, said in (
        (["--ensemble", "fit.nc", "--limit", "device.weight.net_weight=20 uN..30 uN"], "the calibration decides it"),
        (["--ensemble", "fit.nc", "--limit", "device.helix.length=3 mm..4 mm"], "says nothing of others"),
        (["--noise", "drive.pitch=1 deg"], "--noise goes with --ensemble only"),
        (["--ensemble", "fit.nc", "--set", "device.helix.length=4 mm"], "of another device: device.helix.length"),
        (["--ensemble", "base.toml"], "cannot be read as netCDF"),
    ):
        status, out, err = helimag("design", "base.toml", *options)
        assert (status, out) == (2, "")
        assert said in err
        assert len(err.splitlines()) == 1
