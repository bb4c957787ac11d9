"""What goes wrong around a run: full disks, closed streams, folders that cannot be used. One line, nothing left."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import helimag as hm

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="limits and shells of Unix")
HELIMAG = f"{shlex.quote(sys.executable)} -m helimag"
LIMITED = """
import resource, signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
from helimag.cli import main
from helimag.runs import Trajectory
save = Trajectory.save
def limited(self, path):
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, resource.RLIM_INFINITY))
    save(self, path)
Trajectory.save = limited
main()
"""  # a whole run with its kernels first: only the writing meets a full disk


def shell(line, **environment):
    command = ["bash", "-c", line]
    return subprocess.run(
        command, env={**os.environ, **environment}, capture_output=True, text=True, check=False, timeout=100
    )


@pytest.mark.parametrize("room", [0, 1, 100, 4096, 50_000, 200_000])
def test_a_full_disk_while_a_run_is_written(tmp_path, room):
    target = tmp_path / "run.nc"
    target.write_text("older run")
    words = ["simulate", "nose-first/fig3c", "--duration", "20 s", "--no-orbit", "-o", str(target)]
    command = [sys.executable, "-c", LIMITED.replace("ROOM", str(room)), *words]
    found = subprocess.run(command, capture_output=True, text=True, check=False, timeout=100)
    assert found.returncode == 2, found.stderr
    assert found.stderr.splitlines()[-1] == f"helimag: {target} cannot be written: File too large"
    assert "Traceback" not in found.stderr
    assert found.stdout == ""
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    assert target.read_text() == "older run"


@pytest.mark.parametrize(
    ("line", "status", "said"),
    [
        ("presets | head -0; exit ${PIPESTATUS[0]}", 1, ""),
        ("--help | head -0; exit ${PIPESTATUS[0]}", 1, ""),
        ("presets >&-", 2, "helimag: standard output cannot be written: Bad file descriptor\n"),
        ("presets >&- 2>&- <&-", 2, ""),
        ("presets --quiet >&-", 0, ""),
        ("presets 2>&-", 0, ""),
        ("presets >/dev/full", 2, "helimag: standard output cannot be written: No space left on device\n"),
        ("--help >/dev/full", 2, "helimag: standard output cannot be written: No space left on device\n"),
        ("presets >/dev/full 2>/dev/full", 2, ""),
        ("presets nowhere 2>/dev/full", 2, ""),
        ("presets nowhere 2>&-", 2, ""),
    ],
)
def test_streams_that_take_nothing(line, status, said):
    found = shell(f"{HELIMAG} {line}")
    assert (found.returncode, found.stderr) == (status, said)


@pytest.mark.parametrize("locale", ["LC_ALL=C PYTHONUTF8=0 PYTHONCOERCECLOCALE=0", "PYTHONIOENCODING=ascii"])
def test_a_terminal_without_the_signs_gets_others(tmp_path, locale):
    """A scenario's name that ASCII cannot show; and a file whose name is no text in any encoding."""
    text = hm.load("nose-first/fig3c").to_toml().replace('name = "nose-first/fig3c"', 'name = "gr\u00f6\u00dfer"')
    assert "gr\u00f6\u00dfer" in text
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    found = shell(f"cd {tmp_path}; {locale} {HELIMAG} doctor a.toml; {locale} {HELIMAG} cite $'b\\xff.toml'")
    assert found.returncode == 2
    assert "gr\\xf6\\xdfer" in found.stdout
    assert found.stderr.count("\n") == 1
    assert "a TOML file; 'b\\udcff.toml' is neither" in found.stderr


def test_a_run_whose_reader_has_gone_is_still_written(tmp_path):
    target = tmp_path / "run.nc"
    run = f"{HELIMAG} simulate nose-first/fig3c --duration '2 s' --no-orbit -o {target}"
    line = f"{run} | head -0; exit ${{PIPESTATUS[0]}}"
    found = shell(line)
    assert "Traceback" not in found.stderr
    assert "Exception" not in found.stderr
    assert found.returncode == 1
    assert hm.Trajectory.load(target).dataset["time"].values[-1] == 2.0


def test_a_file_opened_with_standard_output_closed_does_not_get_what_is_printed(tmp_path):
    target = tmp_path / "run.nc"
    found = shell(f"{HELIMAG} simulate nose-first/fig3c --duration '2 s' --no-orbit -o {target} >&- 2>&-")
    assert found.returncode == 2  # the run is kept; what was to be said of it is lost
    assert hm.Trajectory.load(target).dataset["time"].values[-1] == 2.0


@pytest.mark.parametrize("command", ["simulate nose-first/fig3c --duration '1 s' --no-orbit", "doctor"])
@pytest.mark.parametrize("name", ["HOME", "WARP_CACHE_PATH", "XDG_CACHE_HOME"])
def test_a_folder_for_kernels_that_cannot_be_made(tmp_path, command, name):
    file = tmp_path / "file"
    file.touch()
    environment = {"HOME": str(tmp_path), name: str(file / "below")}
    unset = " ".join({"XDG_CACHE_HOME", "WARP_CACHE_PATH"} - {name})
    found = shell(f"unset {unset}; {HELIMAG} {command}", **environment)
    assert (found.returncode, found.stdout) == (2, "")
    assert found.stderr.count("\n") == 1
    assert found.stderr.startswith(f"helimag: the folder of compiled kernels, {file}")
    at_fault = "XDG_CACHE_HOME" if name == "XDG_CACHE_HOME" else "HOME"
    assert f"Not a directory; let {at_fault}, or WARP_CACHE_PATH, name a folder that can be written" in found.stderr


def test_no_room_for_compiled_kernels(tmp_path):
    line = f"trap '' XFSZ; ulimit -f 1; {HELIMAG} simulate nose-first/fig3c --duration '1 s' --no-orbit"
    found = shell(line, WARP_CACHE_PATH=str(tmp_path))
    assert (found.returncode, found.stdout) == (2, "")
    assert f"compiled kernels cannot be kept in {tmp_path}" in found.stderr.splitlines()[-1]
    assert "File too large; make room there" in found.stderr
    assert "Traceback" not in found.stderr


def test_figures_say_nothing_of_a_home_that_is_none(tmp_path):
    run = hm.simulate(hm.load("nose-first/fig3c"), duration=2.0)
    run.save(tmp_path / "run.nc")
    cache = os.environ.get("WARP_CACHE_PATH", str(Path.home() / ".cache" / "warp"))
    found = shell(
        f"unset MPLCONFIGDIR; {HELIMAG} plot {tmp_path}/run.nc -o {tmp_path}/run.png --quiet",
        HOME="/dev/null",
        WARP_CACHE_PATH=cache,
    )
    assert (found.returncode, found.stdout, found.stderr) == (0, "", "")


@pytest.mark.parametrize("place", [".", "..", "/", "", "./", "tests"])
def test_folders_that_are_no_sweep_are_not_drawn(helimag, tmp_path, monkeypatch, place):
    (tmp_path / "in" / "tests").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "in")
    status, out, err = helimag("plot", place, "-o", "a.png")
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert "is not a sweep's store: it has no zarr.json" in err
