"""What a run's file says in its attributes, and that any netCDF reader can read them."""

import shutil
import subprocess

import h5py
import numpy as np
import pytest

import helimag as hm
from command_line import run

OCTAVE = """
pkg load netcdf
name = '{}';
printf('%s\\n', ncreadatt(name, '/', 'verdict'));
printf('%s\\n', ncreadatt(name, '/', 'reason'));
printf('%s\\n', ncreadatt(name, '/', 'outlook'));
printf('%.17g\\n', ncreadatt(name, '/', 'gain'));
printf('%.17g\\n', ncreadatt(name, '/', 'input_drive_pitch'));
printf('%s\\n', ncreadatt(name, 'position', 'units'));
printf('%.17g\\n', ncread(name, 'position')(3, end));
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    place = tmp_path_factory.mktemp("attributes") / "run.nc"
    assert run("simulate", "paper/fig3c", "--duration", "7 s", "--no-accuracy", "-o", place).status == 0
    return place


def test_a_run_says_what_it_was_judged_and_with_which_inputs(written):
    again, scenario = hm.Trajectory.load(written), hm.load("paper/fig3c")
    told = again.attributes
    assert told["gain"] == again.gain
    assert told["verdict"] == str(again.verdict)
    assert told["reason"] == again.judgement.reason
    assert told["outlook_reason"]
    assert told["input_drive_pitch"] == np.radians(12.7)
    assert told["input_fluid_viscosity"] == scenario.fluid.viscosity
    assert told["inputs"] == "frequency 3.3 Hz, pitch 12.7 deg, distance 150 mm, yaw rate 1.8 deg/s"


def test_what_is_judged_anew_is_written_anew(written, tmp_path):
    part = hm.Trajectory(hm.Trajectory.load(written).dataset.isel(time=slice(0, 20)))
    part.save(tmp_path / "part.nc")
    again = hm.Trajectory.load(tmp_path / "part.nc")
    assert again.attributes["gain"] == part.gain != hm.Trajectory.load(written).gain


def test_texts_are_of_fixed_length(written):
    """MATLAB's and Octave's netCDF read no attribute that is a string of variable length."""
    with h5py.File(written) as file:
        parts = [file, *(file[name] for name in file)]
        kinds = {(part.name, name): part.attrs.get_id(name).dtype for part in parts for name in part.attrs}
    texts = {place: kind for place, kind in kinds.items() if h5py.check_string_dtype(kind) is not None}
    assert {place for place, kind in texts.items() if kind.hasobject} == set()
    assert len(texts) > 20
    assert kinds["/", "verdict"].kind == "S"


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="needs GNU Octave: apt-get install octave octave-netcdf")
def test_octave_reads_them(written):
    said = subprocess.run(
        ["octave-cli", "--no-gui", "--quiet", "--eval", OCTAVE.format(written)],
        capture_output=True,
        text=True,
        check=True,
    )
    again = hm.Trajectory.load(written)
    verdict, reason, outlook, gain, pitch, units, height = said.stdout.splitlines()
    assert (verdict, reason, outlook) == tuple(again.attributes[name] for name in ("verdict", "reason", "outlook"))
    assert (float(gain), float(pitch)) == (again.gain, np.radians(12.7))
    assert units == "m"
    assert float(height) == again.final_state[2]
