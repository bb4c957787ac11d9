"""Outcome probabilities in the studio: what a calibration's file says, and what a hostile one may not."""

import io
import json

import h5py
import numpy as np
import pytest

import browser
import helimag as hm
from fits import fit_of

missing = browser.lacking()
if missing is not None:
    pytest.skip(missing, allow_module_level=True)

from helimag.calibration import Noise, check_device  # noqa: E402
from helimag.errors import HelimagError  # noqa: E402
from helimag.studio.hdf5 import check_netcdf  # noqa: E402
from helimag.studio.intake import fit_from_bytes, run_from_bytes  # noqa: E402
from helimag.studio.predicting import RUNS, lab_errors, outcomes  # noqa: E402

ROW = hm.load("paper/fig3c").replaced({"run.duration": "20 s", "run.interval": "0.5 s"})


def packed(fit, tmp_path):
    """A fit as its file's bytes."""
    fit.save(tmp_path / "fit.nc")
    return (tmp_path / "fit.nc").read_bytes()


def altered(content, change):
    """A file of HDF5 with something done to it."""
    held = io.BytesIO(content)
    with h5py.File(held, "r+") as file:
        change(file)
    return held.getvalue()


def test_a_fit_that_was_uploaded_is_the_fit(tmp_path):
    fit = fit_of(ROW)
    found = fit_from_bytes(packed(fit, tmp_path))
    assert np.array_equal(found.samples, fit.samples)
    assert found.plan == fit.plan


def test_outcomes_are_those_of_the_command_line(helimag, tmp_path):
    """Devices of the fit with errors, to every digit that the command line prints."""
    steep = ROW.replaced({"drive.pitch": "16 deg", "run.duration": "150 s", "run.interval": "5 s"})
    place = tmp_path / "steep.toml"
    place.write_text(steep.to_toml(), encoding="utf-8")
    fit = fit_of(steep, free={"device.weight.net_weight": (51.6e-6, 6e-6)})
    content = packed(fit, tmp_path)
    errors = lab_errors({"drive.pitch": 0.5, "drive.frequency": 0.0}, 0.4)
    found = outcomes(steep, fit_from_bytes(content), errors, lambda _: None)
    noise = ("--noise", "drive.pitch=0.5 deg", "--displacement", "0.4 mm", "--draws", RUNS)
    said = json.loads(helimag("simulate", place, "--ensemble", tmp_path / "fit.nc", *noise, "--json").out)
    rows = [{"verdict": str(v), "probability": p, "low_95": a, "high_95": b} for v, (p, a, b) in found.shares.items()]
    assert rows == said["outcomes"]
    assert np.quantile(found.gains, [0.05, 0.95]).tolist() == [said["gain"]["p05"], said["gain"]["p95"]]


def test_errors_alone_are_an_ensemble_of_the_inputs():
    errors = lab_errors({"fluid.viscosity": 0.05}, 0.5)
    found = outcomes(ROW, None, errors, lambda _: None)
    known = hm.Perturbation({"fluid.viscosity": hm.scenario.Normal(ROW.fluid.viscosity, 0.05)}, 0.5e-3)
    assert found.gains.tolist() == hm.ensemble(ROW, known, runs=RUNS).gains.tolist()
    with pytest.raises(hm.InputError, match="nothing is uncertain"):
        outcomes(ROW, None, Noise(), lambda _: None)
    with pytest.raises(hm.InputError, match="Viscosity must be zero or more"):
        lab_errors({"fluid.viscosity": -1.0}, 0.0)
    with pytest.raises(hm.InputError, match="the start must be zero or more"):
        lab_errors({}, float("nan"))


def test_a_fit_of_another_device_is_told():
    fit = fit_of(ROW)
    check_device(fit, ROW.replaced({"drive.pitch": "3 deg", "device.weight.net_weight": "40 uN"}))
    words = r"another device: device\.helix\.length is 11\.7 mm in its run 'run' and 12 mm here"
    with pytest.raises(hm.InputError, match=words):
        check_device(fit, ROW.replaced({"device.helix.length": "12 mm"}))
    densities = {"helix_density": "2 g/cm^3", "head_density": "2 g/cm^3"}
    with pytest.raises(hm.InputError, match="net_weight"):  # that of a device given by densities is none of its inputs
        check_device(fit, ROW.replaced({"device.weight": densities}))


def at_group(file):
    file["elsewhere"] = h5py.ExternalLink("/etc/passwd", "/")


def at_raw_bytes(file):
    """Numbers that lie in another file, byte for byte."""
    del file["samples"]
    file.create_dataset("samples", (20, 2), "f8", external=[("/etc/passwd", 0, 320)])


def at_virtual(file):
    layout = h5py.VirtualLayout((20, 2), "f8")
    layout[:] = h5py.VirtualSource("/etc/passwd", "x", (20, 2))
    del file["samples"]
    file.create_virtual_dataset("samples", layout)


def as_bomb(file):
    del file["samples"]
    file.create_dataset("samples", (10**9, 2), "f8", chunks=(10**6, 2), compression="gzip")


def as_long_words(file):
    file.create_dataset("words", (1000,), "S1000000", chunks=(1,))


def as_many_parts(file):
    for i in range(600):
        file.create_group(f"part{i}")


def of_a_ring(file):
    file["ring"] = h5py.SoftLink("/ring")


HOSTILE = {
    "a link to another file": (at_group, "must not link"),
    "another file's bytes as numbers": (at_raw_bytes, "not name another file"),
    "a virtual dataset": (at_virtual, "not name another file"),
    "a bomb": (as_bomb, "when it is unpacked"),
    "names of a gigabyte": (as_long_words, "when it is unpacked"),
    "a thousand parts": (as_many_parts, "parts"),
    "a link to itself": (of_a_ring, "must not link"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_netcdf_is_refused_before_it_is_read(name, tmp_path):
    change, words = HOSTILE[name]
    content = altered(packed(fit_of(ROW), tmp_path), change)
    for read in (fit_from_bytes, lambda given: run_from_bytes(given, ".nc", 0.15), check_netcdf):
        with pytest.raises(hm.InputError, match=words):
            read(content)


def with_plan(change):
    """A change of the plan's text."""

    def made(file):
        held = file.attrs["plan"]
        file.attrs["plan"] = change(held.decode() if isinstance(held, bytes) else held)

    return made


def with_a_body(text):
    """The calibrated device from a file of this machine."""
    head, _, rest = text.partition("[run.base.device]")
    head = head or text
    body = '[run.base.device]\nbody = { file = "/etc/passwd", unit = "mm" }\n'
    return f"{head}{body}{rest}"


DAMAGED = {
    "a body of this machine": (with_plan(with_a_body), "must not name a file"),
    "a base of this machine": (
        with_plan(lambda _: '[[run]]\nname = "x"\nbase = "/etc/passwd"\nobserved = []\n'),
        "must hold the scenarios",
    ),
    "no plan": (lambda file: file.attrs.pop("plan"), "must hold the scenarios|damaged"),
    "a plan that is no text": (lambda file: file.attrs.create("plan", 3.0), "must hold the scenarios|damaged"),
    "a deep plan": (with_plan(lambda _: "a = " + "[" * 3000 + "]" * 3000), "nested deeper"),
    "script for a plan": (with_plan(lambda _: "<script>alert(1)</script>"), "is not valid TOML"),
    "another kind": (lambda file: file.attrs.modify("format", "<script>"), "is not a calibration"),
    "samples of nothing": (lambda file: file["samples"].__setitem__(0, np.nan), "not all finite"),
    "samples without their plan": (
        with_plan(lambda text: text.replace('input = "fluid.viscosity"', 'input = "fluid.density"')),
        "damaged",
    ),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_fit_is_refused(name, tmp_path, monkeypatch):
    change, words = DAMAGED[name]
    content = altered(packed(fit_of(ROW), tmp_path), change)
    own = tmp_path / "own"
    own.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(own))
    with pytest.raises(HelimagError, match=words) as refusal:
        fit_from_bytes(content)
    assert list(own.iterdir()) == []
    assert "root:" not in str(refusal.value)
    assert len(str(refusal.value)) < 600


def test_other_netcdf_is_no_fit(tmp_path):
    hm.simulate(ROW).save(tmp_path / "run.nc")
    with pytest.raises(HelimagError, match="plan must hold"):
        fit_from_bytes((tmp_path / "run.nc").read_bytes())
    with pytest.raises(HelimagError, match="cannot be read as netCDF"):
        fit_from_bytes(b"CDF\x01" + bytes(200))
    with pytest.raises(HelimagError):
        run_from_bytes(packed(fit_of(ROW), tmp_path), ".nc", 0.15)


def test_a_fit_of_other_inputs_is_no_fit_for_this_run():
    """Devices that a scenario cannot have are refused, not left out."""
    fit = fit_of(ROW, free={"device.helix.length": (-1.0, 0.1)})
    with pytest.raises(HelimagError):
        outcomes(ROW, fit, Noise(), lambda _: None)
