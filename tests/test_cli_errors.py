"""The command line under bad input: one clear line, status 2, nothing on stdout, nothing left behind."""

import json
import os
import subprocess
import sys

import pytest

import helimag as hm
from helimag.hydrodynamics.boundary import cache

TEXT = hm.load("nose-first/fig3c").to_toml()


def refused(result, *parts):
    status, out, err = result
    assert status == 2, err
    assert out == ""
    assert err.count("\n") == 1, err
    assert err.startswith("helimag: ")
    assert "Traceback" not in err
    for part in parts:
        assert part in err


def write(path, old="", new=""):
    assert old in TEXT
    path.write_text(TEXT.replace(old, new, 1) if old else TEXT, encoding="utf-8")
    return path


@pytest.mark.parametrize("command", ["simulate", "resistance"])
@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ('"12.7 deg"', '"150 mm"', ["drive.pitch", "an angle", "150 mm"]),
        ("[fluid]", "[fluid]\ntemperature = 3", ["fluid.temperature", "not a known key"]),
        ('"0.94 mm"', '"-0.94 mm"', ["device.helix.outer_diameter", "positive", "-0.94 mm"]),
        ('"0.2128 mm"', '"0.6 mm"', ["device.helix", "wire_radius", "0.6 mm"]),
        ('"1 Pa s"', '"nan Pa s"', ["fluid.viscosity", "nan"]),
        ('"1 Pa s"', '"inf Pa s"', ["fluid.viscosity", "inf"]),
        ('"1 Pa s"', "1", ["fluid.viscosity", "unit"]),
        ("[fluid]", "[fluid", ["TOML"]),
    ],
)
def test_bad_files(helimag, tmp_path, command, old, new, parts):
    refused(helimag(command, write(tmp_path / "a.toml", old, new)), "a.toml", *parts)


@pytest.mark.parametrize(
    ("old", "new", "end"),
    [
        ("frequency =", "frequncy =", "did you mean frequency?"),
        ("duration =", "Duration =", "did you mean duration?"),
        ('radius = "0.3603', 'radus = "0.3603', "did you mean radius?"),
        ('shape = "sphere"', 'shape = "cylinder"', "device.head.radius is not a known key; got '0.3603 mm'"),
        ("[fluid]", "[fluid]\ntemperature = 3", "fluid.temperature is not a known key; got 3"),
    ],
)
def test_a_key_that_is_meant_for_another_is_told_which(helimag, tmp_path, old, new, end):
    """Only keys of the same part and form, and nothing where none is alike."""
    status, out, err = helimag("simulate", write(tmp_path / "a.toml", old, new))
    assert (status, out) == (2, "")
    assert err.endswith(f"{end}\n")


@pytest.mark.parametrize(
    ("words", "end"),
    [
        (("Paper/fig3C",), "'Paper/fig3C' is neither; did you mean paper/fig3c?"),
        (("absent.toml",), "'absent.toml' is neither"),
        (
            ("paper/fig3c", "--set", "pitch=1 deg"),
            "did you mean device.helix.pitch or drive.pitch or drive.path.pitch?",
        ),
        (("paper/fig3c", "--set", "drive.pich=1 deg"), "did you mean drive.pitch?"),
        (("paper/fig3c", "--set", "drive.colour=1"), "pitch_about, start, heading, path"),
    ],
)
def test_a_name_that_is_meant_for_another_is_told_which(helimag, words, end):
    status, out, err = helimag("simulate", *words)
    assert (status, out) == (2, "")
    assert err.endswith(f"{end}\n")


def test_a_plan_in_the_place_of_a_scenario_is_named(helimag, tmp_path):
    for table, what in (("axis", "sweep"), ("free", "calibration")):
        (tmp_path / "plan.toml").write_text(f'base = "paper/fig3c"\n[[{table}]]\n')
        refused(helimag("simulate", tmp_path / "plan.toml"), f"plan.toml is the plan of a {what}, not a scenario")


def test_files_that_are_none(helimag, tmp_path):
    (tmp_path / "empty.toml").touch()
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    (tmp_path / "nested.toml").write_text("a = " + "[" * 9999)
    refused(helimag("simulate", tmp_path / "empty.toml"), "empty.toml")
    refused(helimag("simulate", tmp_path / "binary.toml"), "binary.toml", "text")
    refused(helimag("simulate", tmp_path / "nested.toml"), "nested.toml")
    refused(helimag("simulate", tmp_path), str(tmp_path))
    refused(helimag("simulate", tmp_path / "missing.toml"), "missing.toml", "preset")
    refused(helimag("simulate", ""), "directory")
    refused(helimag("presets", "paper/fig9"), "paper/fig9")


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        (["--set", "drive.pitch=150 mm"], ["drive.pitch", "angle", "150 mm"]),
        (["--set", "drive.pich=1 deg"], ["drive.pich"]),
        (["--set", "drive.pitch"], ["--set", "drive.pitch"]),
        (["--set", "provenance=3"], ["provenance"]),
        (["--set", "drive.start=[1, 2]"], ["drive.start"]),
        (["--set", "drive.start=[1, 2"], ["--set", "TOML"]),
        (["--set", "device.helix.wire_radius=1 mm"], ["wire_radius", "1 mm"]),
        (["--duration", "soon"], ["run.duration", "a time", "soon"]),
        (["--duration=-1 s"], ["run.duration", "positive"]),
        (["--duration", "nan s"], ["run.duration", "nan"]),
        (["--interval", "0 s"], ["run.interval", "positive"]),
        (["--interval", "1e-9 s"], ["interval"]),
        (["--device", "abacus"], ["device", "abacus"]),
        (["--set", "device.helix.length=99 m", "--set", "device.helix.pitch=10 um"], ["device.helix.length"]),
        (["--nonsense"], ["--nonsense"]),
        (["--set", "drive.pitch", "12 deg"], ["nothing takes '12 deg'", "--set drive.pitch='12 deg'"]),
        (["--duration", "5", "s"], ["nothing takes 's'", "--duration '5 s'"]),
    ],
)
def test_bad_options(helimag, options, parts):
    refused(helimag("simulate", "nose-first/fig3c", *options), *parts)


@pytest.mark.parametrize("name", ["missing/run.nc", "folder", "file/run.nc"])
def test_outputs_that_cannot_be_written(helimag, tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("keep me")
    before = sorted(tmp_path.rglob("*"))
    refused(helimag("simulate", "nose-first/fig3c", "--duration", "0.1 s", "-o", tmp_path / name), name)
    assert sorted(tmp_path.rglob("*")) == before
    assert (tmp_path / "file").read_text() == "keep me"


def test_a_trajectory_is_written_as_netcdf_alone(helimag, tmp_path):
    refused(helimag("simulate", "nose-first/fig3c", "-o", tmp_path / "run.csv"), "--output", ".nc", "run.csv")
    assert not list(tmp_path.iterdir())


def test_a_scenario_is_no_plan(helimag, tmp_path):
    place = write(tmp_path / "mine.toml")
    refused(helimag("sweep", place, "-o", tmp_path / "a.zarr"), "mine.toml", "scenario, not a plan", "[[axis]]")


def test_output_into_a_place_that_takes_no_files(helimag):
    refused(helimag("simulate", "nose-first/fig3c", "--duration", "0.1 s", "-o", "/proc/run.nc"), "/proc/run.nc")


def test_a_failed_write_keeps_what_was_there(tmp_path, monkeypatch):
    target = tmp_path / "run.nc"
    target.write_text("older run")
    run = hm.simulate(hm.load("nose-first/fig3c"), duration=0.1)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(hm.FileError, match="No space left"):
        run.save(target)
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    assert target.read_text() == "older run"


def test_a_run_that_fails_has_status_1(helimag):
    status, out, err = helimag("simulate", "nose-first/fig3c", "--set", "device.weight.net_weight=1e300 N", "--json")
    assert (status, out) == (1, "")
    assert err.count("\n") == 1
    assert "broke down" in err


KEYS = "gain output_y_m input_u_m verdict reason end_time_s escape_time_s slips wobble_deg attack_angle_deg final_state"


def test_json_is_one_object_and_nothing_else(helimag, tmp_path):
    status, out, err = helimag("simulate", write(tmp_path / "a.toml"), "--duration", "7.1 s", "--json")
    assert status == 0
    report = json.loads(out)
    assert err.splitlines() == [f"helimag: warning: {warning['text']}" for warning in report["warnings"]]
    assert report.keys() >= {*KEYS.split(), "wall_time_s"}
    assert report["end_time_s"] == 7.1
    run = hm.simulate(hm.load("nose-first/fig3c"), duration=7.1)
    assert report["final_state"] == run.final_state.tolist()
    assert report["gain"] == run.gain


def test_resistance_json(helimag):
    status, out, _ = helimag("resistance", "nose-first/fig3c", "--json")
    report = json.loads(out)
    scenario = hm.load("nose-first/fig3c")
    assert status == 0
    assert report["resistance"] == hm.resistance(scenario.device, scenario.fluid).tolist()
    assert report["model"] == "lighthill"
    assert len(report["mobility"]) == 6
    assert report["bound_violated"] is True  # resistive-force theory of this device is more than an enclosing body's
    assert report["error_estimate"] is None


def test_resistance_of_the_boundary_model(helimag, tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "folder", lambda: tmp_path)
    ball = ["--set", "device.helix.length=0.5 mm", "--set", "device.hydrodynamics.model=boundary"]
    status, out, _ = helimag("resistance", "nose-first/fig3c", "--json", *ball)
    report = json.loads(out)
    assert (status, report["bound_violated"], report["model"]) == (0, False, "boundary")
    assert 0.0 < report["error_estimate"] <= 0.01
    _, out, _ = helimag("resistance", "nose-first/fig3c", *ball)
    assert "estimated error 0." in out
    assert "encloses" not in out
    assert "encloses the device, which cannot be" in helimag("resistance", "nose-first/fig3c")[1]


def test_written_run_is_what_was_run(helimag, tmp_path):
    target = tmp_path / "run.nc"
    status, *_ = helimag("simulate", "nose-first/fig3c", "--duration", "2 s", "-o", target)
    assert status == 0
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    again, run = hm.Trajectory.load(target), hm.simulate(hm.load("nose-first/fig3c"), duration=2.0)
    assert again.final_state.tolist() == run.final_state.tolist()
    assert again.judgement == run.judgement
    assert again.dataset.position.attrs["units"] == "m"


HEAVY = {"warp", "xarray", "pint", "numpy", "matplotlib", "scipy", "h5py", "pydantic"}


@pytest.mark.parametrize("words", [["--help"], ["simulate", "--help"], ["--version"]])
def test_help_imports_nothing_heavy(words):
    code = f"""
import sys
sys.argv = ["helimag", *{words!r}]
from helimag.cli import main
try:
    main()
except SystemExit as stop:
    status = stop.code
else:
    status = 0
print(sorted({HEAVY!r} & sys.modules.keys()), status or 0, file=sys.stderr)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[] 0"
    assert done.stdout


def test_interpreter_prints_no_banner_on_stdout():
    """From a process of its own: Warp's greeting and compiling must not get in."""
    done = subprocess.run(
        [sys.executable, "-m", "helimag", "simulate", "nose-first/fig3c", "--duration", "1 s", "--json"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout)["end_time_s"] == 1.0
    words = [sys.executable, "-m", "helimag", "simulate", "nowhere"]
    bad = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (bad.returncode, bad.stdout) == (2, "")
