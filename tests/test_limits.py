"""Limits: what no laboratory has is refused in one line with the reason, before anything runs; runs can be stopped."""

import math
import os
import signal
import subprocess
import sys
import time

import pytest

from helimag import InputError
from helimag.sweeps import estimate, parse_plan, resolve
from helimag.sweeps.run import sweep

PLAN = 'base = "nose-first/fig3c"\nduration = "30 s"\nsamples = 20\n'


def refused(said, *parts):
    status, out, err = said
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    for part in parts:
        assert part in err, err


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ("drive.frequency=1e9 Hz", ["drive.frequency must be at most 10000 Hz either way", "no motor"]),
        ("drive.frequency=-1e9 Hz", ["at most 10000 Hz either way", "'-1e+09 Hz'"]),
        ("drive.frequency=1e-9 Hz", ["at least 1e-06 Hz", "eleven days"]),
        ("drive.yaw_rate=1e5 deg/s", ["drive.yaw_rate must be at most 3600 deg/s", "no arm"]),
        ("drive.distance=1000 km", ["drive.distance must be at most 100000 mm", "Earth"]),
        ("drive.start=['1 Mm','0 m','0 m']", ["drive.start"]),
        ("drive.start.y=-1e9 m", ["drive.start.1 must be at most 100000 mm either way"]),
        ("device.helix.length=1e-12 m", ["device.helix.length must be at least 1e-09 m", "continuum"]),
        ("drive.velocity=['1e4 m/s','0 m/s','0 m/s']", ["drive.velocity.0 must be at most 100000 mm/s"]),
        ("run.duration=1e-320 s", ["run.duration must be at least 1e-09 s"]),
        ("run.duration=1e12 s", ["run.duration must be at most 1e+09 s", "thirty years"]),
        ("fluid.viscosity=1e9 Pa s", ["fluid.viscosity must be at most 1e+06 Pa s", "within a day"]),
        ("fluid.viscosity=1e-300 Pa s", ["fluid.viscosity must be at least 1e-06 Pa s", "gases"]),
    ],
)
def test_a_scenario_beyond_sense_is_refused_with_the_reason(helimag, change, parts):
    refused(helimag("simulate", "nose-first/fig3c", "--set", change), *parts)


@pytest.mark.parametrize(
    ("text", "runs"),
    [
        ('[[axis]]\nfield = "drive.pitch"\nstart = "1 deg"\nstop = "9 deg"\ncount = 1e12\n', "1e+12 runs"),
        (
            '[[axis]]\nfield = "drive.pitch"\nstart = "1 deg"\nstop = "9 deg"\ncount = 1' + "0" * 400 + "\n",
            "1e+18 runs",
        ),
        ('[[axis]]\nfield = "drive.pitch"\nstart = "1 deg"\nstop = "9 deg"\nstep = "1e-300 deg"\n', "8e+300 runs"),
        (
            "".join(
                f'[[axis]]\nfield = "{field}"\nstart = "{low} {unit}"\nstop = "{high} {unit}"\ncount = 1000\n'
                for field, low, high, unit in [
                    ("drive.pitch", 1, 9, "deg"),
                    ("drive.frequency", 1, 4, "Hz"),
                    ("drive.distance", 100, 200, "mm"),
                    ("drive.yaw_rate", 1, 2, "deg/s"),
                ]
            ),
            "1e+12 runs",
        ),
        (
            '[[axis]]\nfield = "drive.pitch"\nstart = "1 deg"\nstop = "9 deg"\n'
            '[sample]\nmethod = "sobol"\ncount = 2000000\n',
            "2000000 runs",
        ),
    ],
)
def test_a_plan_of_too_many_runs_is_refused_with_their_number(helimag, tmp_path, text, runs):
    place = tmp_path / "plan.toml"
    place.write_text(PLAN + text)
    begun = time.monotonic()
    refused(helimag("sweep", place, "-o", tmp_path / "s.zarr"), runs, "a sweep at most 1000000", "[sample]")
    refused(helimag("sweep", place, "--dry-run"), runs)
    assert time.monotonic() - begun < 5.0
    assert not (tmp_path / "s.zarr").exists()


def test_a_plan_that_fits_is_not_refused():
    axis = '[[axis]]\nfield = "drive.pitch"\nstart = "1 deg"\nstop = "9 deg"\ncount = 1000\n'
    other = '[[axis]]\nfield = "drive.frequency"\nstart = "1 Hz"\nstop = "4 Hz"\ncount = 1000\n'
    assert resolve(parse_plan(PLAN + axis + other)).size == 1_000_000
    with pytest.raises(InputError, match=r"trajectory keeps 3e\+09 samples"):
        resolve(parse_plan(PLAN + 'trajectory = "10 ms"\n' + axis + other))


ZIPPED = "".join(
    f'[[axis]]\nfield = "{field}"\nvalues = ["{one}", "{two}"]\nzip = "NAME"\n'
    for field, one, two in [("drive.frequency", "2 Hz", "3 Hz"), ("drive.pitch", "9 deg", "8 deg")]
)
RESERVED = (
    "time axis byte component chunk file point gain verdict reason scenario_hash checksum distance speed position"
)


@pytest.mark.parametrize("name", [*RESERVED.split(), "end_time", "yaw_rate", "escape_time"])
def test_reserved_names_are_refused_before_the_first_run(helimag, tmp_path, name):
    place = tmp_path / "plan.toml"
    place.write_text(PLAN + 'trajectory = "1 s"\n' + ZIPPED.replace("NAME", name))
    refused(helimag("sweep", place, "-o", tmp_path / "s.zarr"), f"zip must not be '{name}'", "choose another name")
    refused(helimag("sweep", place, "--dry-run"), name)
    assert not (tmp_path / "s.zarr").exists()


@pytest.mark.parametrize("name", ["", "a b", "a/b", "../x", "1a", "\u00e9", "-"])
def test_a_zip_has_a_plain_name(name):
    with pytest.raises(InputError, match=r"axis\.0\.zip"):
        parse_plan(PLAN + ZIPPED.replace("NAME", name))


def test_a_zip_may_have_its_own_axis_name_or_any_other(tmp_path):
    for name in ("case", "frequency", "pitch"):
        text = PLAN.replace("30 s", "1 s") + ZIPPED.replace("NAME", name)
        data = sweep(parse_plan(text), out=tmp_path / f"{name}.zarr", threads=1)
        assert data["gain"].dims == (name,)
        assert data["pitch"].values == pytest.approx([math.radians(9), math.radians(8)])
    assert estimate(parse_plan(text), threads=1).runs == 2


def test_a_run_of_decades_is_stopped_by_ctrl_c():
    words = ("simulate", "nose-first/fig3c", "--set", "drive.frequency=2.5 Hz", "--duration", "1e9 s", "--no-orbit")
    command = [sys.executable, "-m", "helimag", *words]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as under_way:
        time.sleep(8.0)  # imports and kernels from the cache
        assert under_way.poll() is None
        os.kill(under_way.pid, signal.SIGINT)
        begun = time.monotonic()
        _, err = under_way.communicate(timeout=60.0)
    assert time.monotonic() - begun < 10.0  # a second on a free machine; the run itself would take minutes
    assert under_way.returncode == 130
    assert err.splitlines()[-1] == "helimag: interrupted"
    assert "Traceback" not in err


@pytest.mark.parametrize("module", ["helimag.cli", "helimag.cli.design", "cyclopts"])
def test_ctrl_c_while_the_command_is_still_being_read(module):
    code = (
        "import sys\nclass Stopped:\n    def find_spec(self, name, *_):\n"
        f"        if name == '{module}': raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Stopped())\nfrom helimag.__main__ import main\nmain()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "presets"], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "helimag: interrupted\n")
