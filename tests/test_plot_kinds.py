"""plot draws every file that any command writes: the figure that its command makes, where it makes one."""

import re

import numpy as np
import pytest

import helimag as hm
from command_line import run
from helimag.runs import read_netcdf, write_netcdf
from helimag.sweeps import swept_in

SCENARIO = ("paper/fig3c", "--set", "drive.pitch=14.4 deg", "--set", "drive.distance=148 mm")
PITCH = ("--vary", "drive.pitch", "--from", "14.2 deg", "--to", "14.6 deg")
MAP = ("--vary", "drive.pitch=14 deg..16 deg", "--vary", "drive.distance=146 mm..150 mm", "--nodes", "3")
PLAN = """
base = "paper/fig3c"
duration = "5 s"
[[axis]]
field = "drive.pitch"
values = ["13 deg", "16 deg"]
[[axis]]
field = "drive.frequency"
values = ["3 Hz", "3.3 Hz"]
"""
ORBITS = {
    "orbits": ("orbit", *SCENARIO),
    "branches of orbits": ("orbit", *SCENARIO, *PITCH),
    "stability map": ("orbit", "map", *SCENARIO, *MAP),
    "slow flow": ("orbit", "flow", *SCENARIO, "--nodes", "4", "--box", "10 mm"),
    "basin of attraction": (
        *("orbit", "basin", *SCENARIO, "--engine", "averaged", "--nodes", "2", "--check", "1"),
        *("--box", "8 mm", "--duration", "60 s"),
    ),
}


SPOILT = {  # what another program may have made of a file, and what is said of it
    "orbits": {
        "position must be known": lambda d: d.assign(position=d["position"] * np.nan),
        "growth holds 1e+300": lambda d: d.assign(growth=d["growth"] * 0.0 + 1e300),
        "there is no orbit, branch, map": lambda d: d.assign_attrs(content=[1, 2]),
    },
    "branches of orbits": {"position must be known": lambda d: d.assign(position=d["position"] * np.nan)},
    "stability map": {
        "drive_pitch must hold numbers that rise": lambda d: d.isel(drive_pitch=slice(None, None, -1)),
        "drive_distance must hold numbers": lambda d: d.assign_coords(drive_distance=d["drive_distance"] * np.nan),
        "is empty": lambda d: d.isel(drive_pitch=slice(0, 0)),
    },
    "slow flow": {
        "x must hold numbers that rise": lambda d: d.assign_coords(x=d["x"] * 0.0),
        "velocity holds 1e+300": lambda d: d.assign(velocity=d["velocity"] * 0.0 + 1e300),
    },
    "basin of attraction": {
        "captured and end do not agree": lambda d: d.assign(captured=1 - d["captured"]),
        "its volume is not that": lambda d: d.assign_attrs(volume=2.0 * d.attrs["volume"] + 1e-9),
        "z must hold numbers that rise": lambda d: d.assign_coords(z=-d["z"]),
        "two starts or more along each side": lambda d: d.isel(y=[0]),
        "basin of attraction is not whole: float()": lambda d: d.assign_attrs(duration=[1.0, 2.0]),
    },
}


@pytest.mark.parametrize("kind", ORBITS)
def test_what_orbit_wrote_is_drawn_as_orbit_drew_it(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = run(*ORBITS[kind], "-o", "it.nc", "-o", "made.png")
    assert made.status == 0, made.err
    assert made.out.endswith("  written to    it.nc\n  written to    made.png\n")
    drawn = run("plot", "it.nc", "-o", "drawn.png")
    assert drawn == (0, f"it.nc: {kind}\n  written to    drawn.png\n", "")
    if kind == "orbits":
        write_netcdf(read_netcdf("it.nc").isel(orbit=[]), "none.nc")
        said = run("plot", "none.nc", "-o", "none.png")
        told = "none.nc: there are no orbits in this file: none was found, or it is damaged"
        assert said == (2, "", f"helimag: {told}\n")
    assert (tmp_path / "drawn.png").read_bytes() == (tmp_path / "made.png").read_bytes()
    for words, spoil in SPOILT[kind].items():
        with pytest.raises(hm.InputError, match=re.escape(words)):
            hm.orbits.known_in(spoil(read_netcdf("it.nc")))


def test_a_run_is_drawn_and_a_measured_one_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = run("simulate", "paper/fig3c", "--duration", "7 s", "--no-orbit", "-o", "run.nc", "-o", "made.png")
    assert said.status == 0
    assert run("plot", "run.nc", "-o", "drawn.png").out == "run.nc: a run\n  written to    drawn.png\n"
    assert (tmp_path / "drawn.png").read_bytes() == (tmp_path / "made.png").read_bytes()
    lines = "\n".join(f"{0.1 * i},{i},0,{-i}" for i in range(90))
    (tmp_path / "track.csv").write_text(f"time [s],x [mm],y [mm],z [mm]\n{lines}\n")
    assert run("vision", "import", "track.csv", "--gap", "100 mm", "-o", "track.nc").status == 0
    assert run("plot", "track.nc", "-o", "track.png").out == "track.nc: a run\n  written to    track.png\n"


def test_a_sweep_is_drawn_from_its_store_and_from_its_netcdf(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plan.toml").write_text(PLAN)
    outputs = ("-o", "s.zarr", "-o", "s.nc", "-o", "made.png", "-o", "s.csv", "-o", "s.html")
    said = run("sweep", "plan.toml", *outputs)
    assert said.status == 0, said.err
    names = [line.removeprefix("  written to    ") for line in said.out.splitlines() if line.startswith("  written")]
    assert names == [name for name in outputs if name != "-o"]
    for source in ("s.zarr", "s.nc"):
        assert run("plot", source, "-o", "drawn.png", "-o", "drawn.html").status == 0
        assert (tmp_path / "drawn.png").read_bytes() == (tmp_path / "made.png").read_bytes()
        assert (tmp_path / "drawn.html").read_text() == (tmp_path / "s.html").read_text()
    whole = read_netcdf("s.nc")
    for words, spoil in {
        "a sweep needs the values of drive.frequency": whole.drop_vars("frequency"),
        "a sweep's drive.pitch must hold numbers": whole.assign_coords(pitch=whole["pitch"] * np.nan),
        "a sweep's verdict must be one of those": whole.assign(verdict=whole["verdict"] + 100),
        "a sweep's gain must lie along its axes": whole.assign(gain=("pitch", np.zeros(2))),
        "a sweep needs plan": whole.assign_attrs(plan=1.0),
    }.items():
        with pytest.raises(hm.InputError, match=re.escape(words)):
            swept_in(spoil)
    film = run("plot", "s.zarr", "-o", "s.mp4")
    assert film.status == 2
    assert film.err.endswith("(an interactive page) for a sweep; got 's.mp4'\n")


def test_the_path_of_a_programme_is_drawn(tmp_path, monkeypatch):
    from helimag.robot import load_cell, plan, programme_texts, read_timed, timed_table

    monkeypatch.chdir(tmp_path)
    scenario = hm.load("paper/table1-row1")
    planned = plan(scenario, load_cell())
    texts = programme_texts(planned, accept_unbounded=True)
    (name,) = (name for name in texts if name.endswith("_path.csv"))
    (tmp_path / name).write_text(texts[name])
    assert run("plot", name, "-o", "joints.png").out == f"{name}: a robot's path\n  written to    joints.png\n"
    assert read_timed(name).joints == pytest.approx(timed_table(planned).joints, abs=1e-12)


@pytest.mark.parametrize("name", ["proof.json", "rig.json", "mine.toml", "film.mp4", "programme.src"])
def test_what_cannot_be_drawn_is_refused_in_a_line(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text("{}")
    said = run("plot", name, "-o", "a.png")
    assert (said.status, said.out) == (2, "")
    assert said.err.startswith(f"helimag: {name} holds nothing to draw: plot draws what simulate, ")
    assert not (tmp_path / "a.png").exists()


def test_a_file_about_orbits_that_is_not_whole_is_refused_in_a_line(tmp_path, monkeypatch):
    import xarray

    monkeypatch.chdir(tmp_path)
    xarray.Dataset(attrs={"content": "map", "scenario": hm.load("paper/fig3c").to_toml()}).to_netcdf(
        "map.nc", engine="h5netcdf"
    )
    said = run("plot", "map.nc", "-o", "a.png")
    assert (said.status, said.out) == (2, "")
    assert said.err.startswith("helimag: map.nc: the file's stability map is not whole: ")
