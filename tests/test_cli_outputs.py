"""What the shell is taught, what plot refuses, and how presets are shown."""

import helimag as hm
from command_line import run


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
