"""The scenario that a result's file keeps is the one that was run: an edited text is refused wherever it is read."""

import json
import shutil

import pytest
import xarray

import helimag as hm
from command_line import run as helimag
from helimag.errors import FileError, InputError
from helimag.runs import read_netcdf, write_netcdf
from helimag.scenario import parse, scalar_inputs, varied
from helimag.sweeps import export, load_sweep, swept_in

PLAN = """
base = "nose-first/fig3c"
duration = "2 s"
[[axis]]
field = "drive.pitch"
values = ["4 deg", "5 deg"]
"""
EDITS = {
    "another pitch": ('pitch = "12.7 deg"', 'pitch = "12 deg"'),
    "another drag": ('model = "lighthill"', 'model = "gray_hancock"'),
    "a last digit": ('frequency = "3.3 Hz"', 'frequency = "3.3000000000000003 Hz"'),
    "another viscosity": ('viscosity = "1 Pa s"', 'viscosity = "2 Pa s"'),
    "no scenario": ("[drive]", "[driven]"),
    "no TOML": ("[drive]", "[drive"),
}


def edited(text, edit):
    old, new = EDITS[edit]
    assert old in text
    return text.replace(old, new, 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run, a sweep as store and as netCDF, and orbits."""
    place = tmp_path_factory.mktemp("kept")
    hm.simulate("nose-first/fig3c", duration="2 s").save(place / "run.nc")
    (place / "plan.toml").write_text(PLAN)
    export(hm.sweep(place / "plan.toml", out=place / "sweep.zarr", threads=1), place / "sweep.nc")
    assert helimag("orbit", "nose-first/fig3c", "-o", place / "orbit.nc").status in {0, 1}
    return place


@pytest.mark.parametrize("edit", EDITS)
@pytest.mark.parametrize("name", ["run.nc", "orbit.nc", "sweep.nc"])
def test_a_file_whose_scenario_was_edited_is_refused(folder, tmp_path, name, edit):
    """Written anew as a whole, as an editor of netCDF does, so that its checksum is right or gone."""
    dataset = read_netcdf(folder / name)
    dataset.attrs["scenario"] = edited(dataset.attrs["scenario"], edit)
    write_netcdf(dataset, tmp_path / name)
    told = helimag("plot", tmp_path / name, "-o", tmp_path / "figure.png")
    assert (told.status, told.out) == (2, "")
    assert "its scenario" in told.err or "scenario is not the one that was run" in told.err
    assert told.err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("name", ["run.nc", "orbit.nc", "sweep.nc", "sweep.zarr"])
def test_a_file_that_nobody_edited_is_read(folder, tmp_path, name):
    assert helimag("plot", folder / name, "-o", tmp_path / "figure.png").status == 0


def test_a_file_of_another_version_is_read(folder, tmp_path):
    """Which may have made another scenario of the same text."""
    dataset = read_netcdf(folder / "run.nc")
    dataset.attrs["scenario"] = edited(dataset.attrs["scenario"], "another pitch")
    dataset.attrs["versions"] = json.dumps({**json.loads(dataset.attrs["versions"]), "helimag": "0.0.9"})
    write_netcdf(dataset, tmp_path / "run.nc")
    assert parse(hm.Trajectory.load(tmp_path / "run.nc").scenario_toml).drive.pitch < 0.21


STORED = {
    "scenario": ('frequency = "3.3 Hz"', 'frequency = "3.4 Hz"', "scenario.drive.frequency is '3.4 Hz'"),
    "plan": ('"4 deg"', '"6 deg"', "axis"),
    "identity": ("3.3 Hz", "3.4 Hz", "plan_hash does not agree"),
    "plan_hash": ("", "f", "plan_hash does not agree"),
    "method": ("multirevolution", "direct", "method is 'direct'"),
}


@pytest.mark.parametrize("key", STORED)
def test_a_store_whose_plan_or_scenario_was_edited_is_refused(folder, tmp_path, key):
    store = shutil.copytree(folder / "sweep.zarr", tmp_path / "sweep.zarr")
    head = json.loads((store / "zarr.json").read_text())
    old, new, why = STORED[key]
    assert old in head["attributes"][key]
    head["attributes"][key] = head["attributes"][key].replace(old, new, 1)
    (store / "zarr.json").write_text(json.dumps(head))
    with pytest.raises(FileError, match=r"sweep\.zarr: its ") as caught:
        load_sweep(store)
    assert why in str(caught.value)
    dataset = xarray.load_dataset(folder / "sweep.nc", engine="h5netcdf")
    dataset.attrs[key] = head["attributes"][key]
    with pytest.raises(InputError, match="its "):
        swept_in(dataset)


def test_what_is_written_has_its_own_hash():
    """A text that did not give the numbers back to their last digit would make every file of them one to refuse."""
    odd = 1.0 + 2.0**-40
    for name in hm.preset_names():
        base = hm.load(name)
        numbers = {each.path: each.value(base) for each in scalar_inputs(base)}
        told = varied(base, {path: odd * value for path, value in numbers.items() if path.startswith("device.")})
        assert parse(told.to_toml()).hash == told.hash
