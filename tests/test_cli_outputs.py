"""What the shell is taught, what plot refuses, and how presets are shown."""

import json
import sys

import pytest

import helimag as hm
from command_line import run
from helimag.files import discard_left


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
    said = run("plot", "map.nc", "-o", "map.png")
    assert said.status == 2
    assert said.err.startswith("helimag: map.nc: a trajectory needs time")
    assert "plot draws what simulate, robot replay, vision, orbit, sweep, calibrate or robot program wrote" in said.err


def test_presets_stand_in_columns():
    lines = run("presets").out.splitlines()
    assert len(lines) > 10
    assert len({line.index(" Hz") - len(line.split()[1]) for line in lines}) == 1


def test_a_written_preset_has_no_empty_tables():
    text = run("presets", "paper/fig3c").out
    assert "[workspace" not in text
    assert "[drive]" in text
    assert hm.scenario.parse(text).hash == hm.load("paper/fig3c").hash


def test_vision_writes_only_what_it_is_told_to(tmp_path, monkeypatch):
    """Without -o nothing is written; with it the run, and a figure of it."""
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{i / 10},{i},0,{-0.1 * i}\n" for i in range(5))
    (tmp_path / "track.csv").write_text("time [s],x [mm],y [mm],z [mm]\n" + rows)
    told = run("vision", "import", "track.csv", "--gap", "102 mm")
    assert told.status == 0
    assert "|y|           0.400 mm" in told.out
    assert [file.name for file in tmp_path.iterdir()] == ["track.csv"]
    told = run("vision", "import", "track.csv", "--gap", "102 mm", "-o", "m.nc", "-o", "m.png", "--json")
    assert told.status == 0
    assert json.loads(told.out)["files"] == ["m.nc", "m.png"]
    assert (tmp_path / "m.nc").stat().st_size > 0
    assert (tmp_path / "m.png").stat().st_size > 0
    told = run("vision", "calibrate", "none.toml", "-o", "rig.nc")
    assert told.status == 2
    assert "--output must end in .json (the rig)" in told.err


def test_a_clip_is_looked_at_before_the_films(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a.mp4", "b.mp4", "rig.json"):
        (tmp_path / name).write_text("no film")
    track = ("vision", "track", "a.mp4", "b.mp4", "--rig", "rig.json", "--gap", "0.1 m", "--review")
    for clip, message in (
        ("clip.mov", "--review must end in .mp4, .avi (a clip); got 'clip.mov'"),
        ("new/clip.mp4", "new/clip.mp4 cannot be written: there is no folder 'new'"),
        ("./b.mp4", "--review must not be one of the films; got 'b.mp4'"),
    ):
        assert run(*track, clip) == (2, "", f"helimag: {message}\n")


FILMING = [("simulate", "paper/fig3c"), ("plot", "run.nc"), ("robot", "replay", "log.csv", "paper/fig3c")]


@pytest.mark.parametrize("words", FILMING, ids=" ".join)
def test_a_film_without_pyav_is_refused_before_the_run(words, tmp_path, monkeypatch):
    """Neither run.nc nor log.csv is there: what is to be written is looked at first."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "av", None)
    said = run(*words, "-o", "film.MP4")
    assert (said.status, said.out) == (2, "")
    assert said.err.startswith("helimag: filming needs av: ")
    assert list(tmp_path.iterdir()) == []


SWEEP = """
base = "nose-first/fig3c"
duration = "1 s"
samples = 20
[[axis]]
field = "drive.frequency"
values = ["2 Hz", "3 Hz"]
"""


def test_names_and_options_of_earlier_versions_are_taken(tmp_path, monkeypatch):
    """A store without a suffix, --export, --animate and netCDF-4 by its other names; capital letters too."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plan.toml").write_text(SWEEP, encoding="utf-8")
    told = run("sweep", "plan.toml", "-o", "store", "--export", "table.CSV", "--export", "data.h5", "--json")
    assert (told.status, json.loads(told.out)["files"]) == (0, ["store", "table.CSV", "data.h5"])
    assert hm.load_sweep("store")["verdict"].size == 2
    assert len((tmp_path / "table.CSV").read_text("utf-8").splitlines()) == 3
    told = run("simulate", "paper/fig3c", "--duration", "1 s", "--no-orbit", "-o", "run.h5", "-o", "run.nc4")
    assert told.status == 0
    assert (tmp_path / "run.h5").read_bytes() == (tmp_path / "run.nc4").read_bytes()
    told = run("plot", "run.h5", "--animate", "run.png", "-o", "again.png")
    assert told.status == 0
    assert (tmp_path / "run.png").read_bytes() == (tmp_path / "again.png").read_bytes()
    told = run("plot", "data.h5", "-o", "store")
    assert told.status == 2
    assert "--output must end in .png, .svg, .pdf (a figure)" in told.err


def test_what_goes_on_says_so_where_it_is_interrupted(tmp_path, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("helimag.calibration.calibrate", stopped)
    told = run("calibrate", "plan.toml", "-o", str(tmp_path / "fit.nc"))
    again = f"run the same command again to go on from what is kept beside {tmp_path / 'fit.nc'}"
    assert (told.status, told.out, told.err) == (130, "", f"helimag: interrupted; {again}\n")


def test_only_what_was_to_become_the_file_itself_is_discarded(tmp_path):
    mine, others = tmp_path / ".fit.nc.ab_12xyz.part", tmp_path / ".fit.nc.png.ab_12xyz.part"
    for left in (mine, others, tmp_path / "fit.nc"):
        left.touch()
    discard_left(tmp_path / "fit.nc")
    assert sorted(path.name for path in tmp_path.iterdir()) == [others.name, "fit.nc"]
