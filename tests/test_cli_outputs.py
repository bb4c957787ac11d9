"""What `-o` promises alike in every command, and what the shell is taught."""

import pytest

import helimag as hm
from command_line import run


@pytest.mark.parametrize(
    "words",
    [
        ("simulate", "paper/fig3c"),
        ("design", "paper/fig3c"),
        ("compare", "measured.nc", "simulated.nc"),
        ("robot", "replay", "log.csv", "paper/fig3c"),
        ("vision", "import", "track.csv", "--gap", "0.1 m"),
        ("vision", "track", "a.mp4", "b.mp4", "--rig", "rig.json"),
        ("vision", "calibrate", "calibration.toml"),
        ("orbit", "map", "paper/fig3c", "--vary", "drive.pitch=4 deg..9 deg", "--vary", "drive.frequency=2 Hz..3 Hz"),
    ],
    ids=lambda words: " ".join(words[:2]),
)
def test_a_file_in_a_folder_that_is_not_there_is_refused_before_anything_is_read(words, tmp_path, monkeypatch):
    """No input exists either: where that is what is said, the output was looked at too late."""
    monkeypatch.chdir(tmp_path)
    said = run(*words, "-o", "new/result.nc")
    assert (said.status, said.out) == (2, "")
    assert said.err == "helimag: new/result.nc cannot be written: there is no folder 'new'\n"
    assert list(tmp_path.iterdir()) == []


def test_the_shell_is_taught_every_command_in_the_users_home(tmp_path, monkeypatch):
    home, work = tmp_path / "home", tmp_path / "work"
    home.mkdir()
    work.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("SHELL", "/bin/bash")
    monkeypatch.chdir(work)
    assert run("--install-completion", "--shell", "bash").status == 0
    assert list(work.iterdir()) == []
    (script,) = (path for path in home.rglob("*helimag*") if path.is_file())
    text = script.read_text("utf-8")
    assert {"simulate", "sweep", "orbit", "basin", "read-back", "--method"} <= set(text.replace("'", " ").split())
    assert str(script) in (home / ".bashrc").read_text("utf-8")


def test_a_file_that_holds_no_run_is_refused_with_what_can_be_drawn(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    import xarray

    xarray.Dataset({"stable": ("x", [1.0])}).to_netcdf("map.nc", engine="h5netcdf")
    said = run("plot", "map.nc")
    assert said.status == 2
    assert said.err.startswith("helimag: map.nc: a trajectory needs time")
    assert "plot draws what simulate, robot replay, vision or calibrate wrote, and sweeps" in said.err


def test_presets_stand_in_columns():
    lines = run("presets").out.splitlines()
    assert len(lines) > 10
    assert len({line.index(" Hz") - len(line.split()[1]) for line in lines}) == 1


def test_a_written_preset_has_no_empty_tables():
    text = run("presets", "paper/fig3c").out
    assert "[workspace" not in text
    assert "[drive]" in text
    assert hm.scenario.parse(text).hash == hm.load("paper/fig3c").hash
