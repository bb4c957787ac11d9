"""The SLURM recipe of the documentation makes the job script that SLURM needs."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parent.parent / "docs" / "howto" / "sweep-on-a-cluster.md"


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
