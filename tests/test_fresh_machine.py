"""A machine that has never run helimag: an empty home and an empty cache of compiled kernels."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
SAID = "helimag: compiling a kernel for this machine and keeping it (about ten seconds) ...\n"

# a sample of every command's refusals; {} is an empty folder but for what FILES says
FILES = {
    "far.toml": "offset = 3\n",
    "plan.toml": 'base = "paper/fig3c"\n[[axis]]\nfield = "drive.pich"\nvalues = ["4 deg"]\n',
    "track.csv": "a,b\n1,2\n",
    "run.nc": "this is no netCDF file",
}
LONG = ("--set", "device.helix.length=99 m", "--set", "device.helix.pitch=10 um")
SIDEWAYS = ("--set", 'drive.velocity=["1 mm/s", "0 m/s", "0 m/s"]')
MAP = ("--vary", "drive.pitch=4 deg..8 deg", "--vary", "drive.frequency=2 Hz..3 Hz")
REFUSALS = [
    ("simulate", "paper/fig3c", *LONG),
    ("simulate", "paper/fig3c", "--device", "abacus"),
    ("simulate", "paper/fig3c", "--interval", "1e-9 s"),
    ("simulate", "paper/fig3c", "-o", "{}/none/run.nc"),
    ("simulate", "paper/fig3c", "-o", "/proc/run.nc"),
    ("resistance", "paper/fig3c", *LONG),
    ("orbit", "paper/fig3c", *LONG),
    ("orbit", "paper/fig3c", *SIDEWAYS),
    ("orbit", "paper/fig3c", "--vary", "drive.pith", "--from", "8 deg", "--to", "9 deg"),
    ("orbit", "paper/fig3c", "--vary", "drive.pitch", "--from", "9 deg", "--to", "8 deg"),
    ("orbit", "map", "paper/fig3c", *LONG, *MAP),
    ("orbit", "map", "paper/fig3c", *MAP[:2]),
    ("orbit", "map", "paper/fig3c", *MAP, "--nodes", "1"),
    ("orbit", "flow", "paper/fig3c", "--box", "abc"),
    ("orbit", "flow", "paper/fig3c", *LONG),
    ("orbit", "basin", "paper/fig3c", *SIDEWAYS),
    ("orbit", "basin", "paper/fig3c", "--nodes", "0"),
    ("orbit", "against", "{}/none.zarr"),
    ("design", "paper/fig3c", "--speed", "3 mm"),
    ("design", "paper/fig3c", *LONG),
    ("design", "paper/fig3c", "--limit", "drive.pitch"),
    ("sweep", "{}/plan.toml", "-o", "{}/s.zarr"),
    ("sweep", "{}/plan.toml"),
    ("plot", "{}/run.nc"),
    ("compare", "{}/run.nc", "{}/none.nc"),
    ("reproduce", "fig9", "-o", "{}"),
    ("robot", "check", "paper/fig3c", "--cell", "{}/none.toml"),
    ("robot", "program", "paper/fig3c", "-o", "{}/out"),
    ("robot", "program", "paper/table1-row1", "-o", "{}/out", "--name", "x();HALT"),
    ("robot", "read-back", "{}/none.src", "paper/fig3c"),
    ("robot", "replay", "{}/track.csv", "paper/fig3c"),
    ("robot", "jitter", "paper/table1-row1", "{}/far.toml"),
    ("vision", "render", "{}/run.nc", "-o", "{}/films"),
    ("vision", "calibrate", "{}/far.toml", "-o", "{}/rig.json"),
    ("vision", "track", "{}/a.mp4", "{}/b.mp4", "--rig", "{}/rig.json", "--gap", "1 mm", "-o", "{}/m.nc"),
    ("vision", "import", "{}/track.csv", "--gap", "1 mm", "-o", "{}/m.nc"),
]
ALL_IN_ONE_PROCESS = """
import json, sys
import command_line
print(json.dumps([command_line.run(*words) for words in json.load(sys.stdin)]))
"""


def fresh(home: Path) -> dict[str, str]:
    """The environment of a user who has just been given an account."""
    homes = {name: str(home) for name in ("HOME", "XDG_CACHE_HOME", "WARP_CACHE_PATH", "MPLCONFIGDIR")}
    return {**os.environ, **homes, "PYTHONPATH": os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])}


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[tuple[int, str, str]]]:
    """What all refusals said, from one process; the cache of kernels is still empty after them."""
    folder, home = tmp_path_factory.mktemp("files"), tmp_path_factory.mktemp("home")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    words = json.dumps([[word.format(folder) for word in line] for line in REFUSALS])
    done = subprocess.run(
        [sys.executable, "-c", ALL_IN_ONE_PROCESS],
        input=words,
        env=fresh(home),
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    yield json.loads(done.stdout)
    assert not [path for path in home.rglob("*") if path.suffix in (".cpp", ".o", ".meta", ".cubin")]
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)


@pytest.mark.parametrize("number", range(len(REFUSALS)), ids=[" ".join(words[:3]) for words in REFUSALS])
def test_bad_input_is_refused_before_anything_is_compiled(answers: list[tuple[int, str, str]], number: int) -> None:
    status, out, err = answers[number]
    assert (status, out) == (2, ""), err
    assert err.startswith("helimag: ")
    assert err.count("\n") == 1, err
    assert "compiling" not in err


def test_the_first_run_says_that_it_compiles_and_the_second_says_nothing(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "helimag", "simulate", "paper/fig3c", "--duration", "1 s", "--no-orbit", "--json"]
    first, second = (
        subprocess.run(command, env=fresh(tmp_path), cwd=tmp_path, capture_output=True, text=True, check=True)
        for _ in range(2)
    )
    assert first.stderr.startswith(SAID)
    compiled = [place.parent.name.rpartition("_")[0] for place in tmp_path.rglob("*.o")]
    assert len(compiled) >= 2
    assert len(set(compiled)) == len(compiled), "a kernel is compiled once, not again where it is launched"
    of_compiling = [SAID, *(line for line in first.stderr.splitlines(keepends=True) if line.endswith(" s so far\n"))]
    warnings = [line for line in first.stderr.splitlines(keepends=True) if line not in of_compiling]
    assert all(line.startswith("helimag: warning: ") for line in warnings)
    assert second.stderr == "".join(warnings), "the same warnings, and nothing of compiling"
    states = [json.loads(done.stdout)["final_state"] for done in (first, second)]
    assert states[0] == states[1]
