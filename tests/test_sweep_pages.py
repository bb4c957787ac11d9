"""The pages on sweeps run as written, and their SLURM recipe makes the job script that SLURM needs."""

import contextlib
import io
import re
import shlex
from pathlib import Path

import pytest

import command_line
from helimag.sweeps import parse_plan, resolve

PAGES = Path(__file__).parent.parent / "docs" / "howto"
PAGE = PAGES / "sweep-on-a-cluster.md"


def test_the_how_to_runs_as_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = re.findall(
        r"^```(\w+)\n(.*?)^```", (PAGES / "sweep.md").read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    plans = [text for language, text in found if language == "toml"]
    Path("pitch.toml").write_text(plans[0], encoding="utf-8")
    (commands,) = [text for language, text in found if language == "console"]
    for line in (line for line in commands.splitlines() if line.startswith("$ ")):
        done = command_line.run(*shlex.split(line.removeprefix("$ "))[1:])
        assert done.status == 0, done.err
    for name in ("pitch.zarr", "pitch.csv", "pitch.png", "pitch.html"):
        assert Path(name).exists()
    (code,), (shown,) = ([text for language, text in found if language == kind] for kind in ("python", "text"))
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(code, {})
    assert out.getvalue() == shown
    assert resolve(parse_plan(plans[2])).size == 224
    sampled = (
        plans[0].replace('values = ["2 Hz", "3 Hz"]', 'start = "2 Hz"\nstop = "3 Hz"').replace('step = "2 deg"', "")
    )
    assert resolve(parse_plan(sampled + plans[1])).size == 256


@pytest.fixture
def job_script(monkeypatch, tmp_path, capsys):
    """What the recipe prints, without submitting: the recipe is run as written up to its scale()."""
    monkeypatch.chdir(tmp_path)
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]
    before, submit, after = code.partition("cluster.scale(jobs=4)\n")
    assert submit
    assert "helimag.sweep(" in after
    loopback = before.replace('{"dashboard": False}', '{"dashboard": False, "host": "127.0.0.1", "port": 0}')
    assert loopback != before
    space = {}
    exec(compile(loopback, str(PAGE), "exec"), space)
    address = space["cluster"].scheduler_address
    space["cluster"].close()
    return capsys.readouterr().out, address


def test_the_job_script_asks_for_what_the_recipe_says(job_script):
    text, address = job_script
    assert text.startswith("#!/usr/bin/env bash\n")
    options = dict(re.findall(r"^#SBATCH (-\w|--[\w-]+)[= ](.*)$", text, re.MULTILINE))
    assert options["-p"] == "standard"
    assert options["-A"] == "my-account"
    assert options["-n"] == "1"
    assert options["--cpus-per-task"] == "16"
    assert options["--mem"] == "15G"  # 16 GB, in units of 2^30
    assert options["-t"] == "02:00:00"
    *_, prologue, worker = text.strip().splitlines()
    assert prologue == "source ~/helimag/.venv/bin/activate"
    assert worker.startswith(f"python -m distributed.cli.dask_worker {address} ")
    assert "--nthreads 16" in worker
