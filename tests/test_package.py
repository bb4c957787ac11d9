"""The wheel and the source distribution: built, looked into, installed into an environment of their own, and run."""

import os
import shutil
import site
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("hatchling", reason="building needs hatchling: make venv")

ROOT = Path(__file__).parents[1]
NEEDED = ("pyproject.toml", "README.md", "LICENSE", "src")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def shell(*words, cwd):
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [str(word) for word in words], cwd=cwd, env=clean, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def copied(folder):
    """What a build needs, away from the checkout."""
    tree = folder / "tree"
    tree.mkdir()
    for name in NEEDED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, tree / name)
    return tree


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Wheel of the checkout, source distribution, and the wheel that is built from that alone."""
    folder = tmp_path_factory.mktemp("package")
    tree = copied(folder)
    shell(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-t", "sdist", "-d", folder / "dist", cwd=tree)
    (wheel,) = (folder / "dist").glob("*.whl")
    (source,) = (folder / "dist").glob("*.tar.gz")
    with tarfile.open(source) as packed:
        packed.extractall(folder / "unpacked", filter="data")
    (inner,) = (folder / "unpacked").iterdir()
    shell(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder / "again", cwd=inner)
    (again,) = (folder / "again").glob("*.whl")
    return wheel, again


def test_the_wheel_holds_all_of_the_package_and_nothing_else(built):
    wheel, again = built
    with zipfile.ZipFile(wheel) as one, zipfile.ZipFile(again) as other:
        names = set(one.namelist())
        assert names == set(other.namelist()), "the source distribution builds the same wheel"
    mine = {
        path.relative_to(ROOT / "src").as_posix() for path in (ROOT / "src" / "helimag").rglob("*") if path.is_file()
    }
    mine = {name for name in mine if "__pycache__" not in name}
    assert {name for name in names if ".dist-info/" not in name} == mine
    assert any(name.endswith("/licenses/LICENSE") for name in names)


def test_an_installed_wheel_runs(built, tmp_path):
    """In an environment that has nothing but this wheel, and finds what it depends on where this one has it."""
    shell(sys.executable, "-m", "venv", "--without-pip", "own", cwd=tmp_path)
    python = tmp_path / "own" / "bin" / "python"
    shell(
        sys.executable,
        "-m",
        "pip",
        "--python",
        python,
        "install",
        "--quiet",
        "--no-index",
        "--no-deps",
        built[1],
        cwd=tmp_path,
    )
    (place,) = (tmp_path / "own" / "lib").glob("python*/site-packages")
    (place / "dependencies.pth").write_text("\n".join(site.getsitepackages()), encoding="utf-8")
    where = shell(python, "-c", "import helimag; print(helimag.__file__)", cwd=tmp_path)
    assert where.startswith(str(tmp_path))
    command = tmp_path / "own" / "bin" / "helimag"
    assert shell(command, "--version", cwd=tmp_path).strip() == PROJECT["version"]
    assert "paper/fig3c" in shell(command, "presets", cwd=tmp_path)
    assert '"published' in shell(command, "presets", "paper/fig3c", cwd=tmp_path)


def test_the_pythons_that_it_is_for_are_named():
    versions = {line.rsplit(" ", 1)[1] for line in PROJECT["classifiers"] if "Python :: 3." in line}
    assert versions == {"3.11", "3.12", "3.13", "3.14"}
    assert PROJECT["requires-python"] == ">=3.11"


@pytest.mark.nightly
def test_a_wheel_installs_with_what_it_asks_for(built, tmp_path):
    """From the package index, into an empty environment: what a user gets."""
    shell(sys.executable, "-m", "venv", "own", cwd=tmp_path)
    python = tmp_path / "own" / "bin" / "python"
    shell(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", built[0], cwd=tmp_path)
    said = shell(tmp_path / "own" / "bin" / "helimag", "simulate", "paper/fig3c", "--duration", "7 s", cwd=tmp_path)
    assert said.startswith("paper/fig3c, run.duration 7 s: undecided")
