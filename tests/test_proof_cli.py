"""The commands about proofs as a user meets them: how far they have come, what is written, Ctrl-C in the middle."""

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("flint")

import command_line
import helimag as hm
from helimag.proof import Certificate, Proof, Row, read_any
from proof_cells import SCENARIO, cell

WORDS = ("orbit", "s.toml", "--prove", "--certificate", "c.json")


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_ctrl_c_ends_a_proof_at_once_with_one_line_and_status_130(tmp_path: Path) -> None:
    """A real one, in the midst of it: nothing is left of the file that it would have written."""
    words = ["orbit", "nose-first/fig3c", "--set", "drive.frequency=2.5 Hz", "--prove", "--certificate", "c.json"]
    command = [sys.executable, "-m", "helimag", *words, "--verbose"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        assert child.stderr is not None
        while "proving the orbit" not in (line := child.stderr.readline()):
            assert line, "it ended before it began to prove"
        time.sleep(1.0)
        child.send_signal(signal.SIGINT)
        out, err = child.communicate(timeout=300)  # at once, where nothing else computes beside it
    assert (child.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "helimag: interrupted"
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


class Stand:
    """What proves at once, and stops where it is told to."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, stops: str = "") -> None:
        self.stops, self.heard = stops, []
        orbit = hm.Orbit(scenario=SCENARIO, status=hm.orbits.OrbitStatus.NO_ORBIT)
        self.at_decimals = cell("12.7", {}, basin=5e-5)
        self.box, self.row = cell("12.7"), Row("drive.pitch", (cell("12.693"), cell("12.7")))
        self.proof = Proof(
            orbit=orbit, existence=True, stability=True, bound=0.9, box=1e-9, reason="it stays", seconds=1.0,
            certificate=self.at_decimals,
        )  # fmt: skip
        monkeypatch.setattr("helimag.orbits.find_orbit", lambda *_, **__: orbit)
        monkeypatch.setattr("helimag.proof.prove", self.prove)
        monkeypatch.setattr("helimag.proof.tolerated", self.tolerated)
        monkeypatch.setattr("helimag.proof.grown", self.grown)

    def _told(self, name: str, progress) -> None:
        self.heard.append(name)
        progress(0.5)
        if name == self.stops:
            raise KeyboardInterrupt

    def prove(self, _: hm.Orbit, *, progress) -> Proof:
        self._told("prove", progress)
        return self.proof

    def tolerated(self, certificate: Certificate, *, progress) -> Certificate:
        assert certificate is self.at_decimals
        self._told("tolerated", progress)
        return self.box

    def grown(self, box: Certificate, along: str, *, seconds: float, progress, keep) -> Row:
        assert (box, along) == (self.box, "drive.pitch")
        assert 0.0 < seconds <= 600.0
        keep(self.row)
        self._told("grown", progress)
        return self.row


def last_line(said: command_line.Said) -> str:
    """What came after the warnings about the scenario, which a proof does not change."""
    return said.err.splitlines()[-1]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(SCENARIO.to_toml(), encoding="utf-8")
    return tmp_path


def test_a_box_and_a_row_take_the_certificates_place(here: Path, monkeypatch) -> None:
    """One file, of what was proved last; the JSON object says it as well."""
    stand = Stand(monkeypatch)
    plain = command_line.run(*WORDS, "--json")
    assert plain.status == 0, plain.err
    assert read_any((here / "c.json").read_text()).hash == stand.at_decimals.hash
    assert "tolerance" not in json.loads(plain.out)["proof"]
    boxed = json.loads(command_line.run(*WORDS, "--tolerance", "--json").out)["proof"]["tolerance"]
    assert read_any((here / "c.json").read_text()).hash == stand.box.hash == boxed["certificate_sha256"]
    assert boxed["within"] == dict(stand.box.within)
    long = command_line.run(*WORDS, "--tolerance", "--budget", "10 min", "--json")
    row = json.loads(long.out)["proof"]["tolerance"]
    assert read_any((here / "c.json").read_text()).hash == stand.row.hash == row["certificate_sha256"]
    assert row["box"]["drive.pitch"] == [12.689, 12.704]
    assert (row["cells"], row["along"], row["proved"]) == (2, "drive.pitch", True)
    assert stand.heard == ["prove", "prove", "tolerated", "prove", "tolerated", "grown"]


@pytest.mark.usefixtures("here")
def test_a_row_is_said_in_words(monkeypatch) -> None:
    Stand(monkeypatch)
    said = command_line.run(*WORDS, "--tolerance", "--budget", "10 min")
    assert said.status == 0
    assert "drive.pitch from 12.689 to 12.704 deg" in said.out
    assert "2 cells along drive.pitch" in said.out


@pytest.mark.parametrize(
    ("stops", "left", "told"),
    [
        ("prove", None, "helimag: interrupted"),
        ("tolerated", "at_decimals", "helimag: interrupted; what was proved before is in c.json"),
        ("grown", "row", "helimag: interrupted; what was proved before is in c.json"),
    ],
)
def test_ctrl_c_leaves_what_was_proved_before(here: Path, monkeypatch, stops, left, told) -> None:
    stand = Stand(monkeypatch, stops)
    said = command_line.run(*WORDS, "--tolerance", "--budget", "10 min")
    assert (said.status, said.out, last_line(said)) == (130, "", told)
    files = {path.name for path in here.iterdir()} - {"s.toml"}
    assert files == (set() if left is None else {"c.json"})
    if left is not None:
        assert read_any((here / "c.json").read_text()).hash == getattr(stand, left).hash


@pytest.mark.usefixtures("here")
def test_without_a_file_an_interrupted_box_names_none(monkeypatch) -> None:
    Stand(monkeypatch, "tolerated")
    said = command_line.run("orbit", "s.toml", "--prove", "--tolerance")
    assert (said.status, said.out, last_line(said)) == (130, "", "helimag: interrupted")


def test_check_says_what_a_row_makes_up(here: Path, monkeypatch) -> None:
    """And refuses it where a cell does not prove what it claims."""
    row = Row("drive.pitch", (cell("12.693"), cell("12.7")))
    row.save(here / "row.json")
    monkeypatch.setattr("helimag.proof.certificate.claims_of", lambda *_, **__: row.cells[0].claims)
    said = command_line.run("orbit", "check", "row.json")
    assert said.status == 0, said.err
    assert said.out.startswith("row.json: holds; ")
    assert "drive.pitch from 12.689 to 12.704 deg" in said.out
    report = json.loads(command_line.run("orbit", "check", "row.json", "--json").out)
    assert report["box"]["drive.frequency"] == [2.4995, 2.5005]
    assert report["sha256"] == row.hash
    other = replace(row.cells[0].claims, bound=0.5)
    monkeypatch.setattr("helimag.proof.certificate.claims_of", lambda *_, **__: other)
    refused = command_line.run("orbit", "check", "row.json")
    assert (refused.status, refused.out) == (2, "")
    assert "does not prove: bound" in refused.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--prove", "--budget", "10 min"), "add --tolerance"),
        (("--prove", "--tolerance", "--along", "drive.pitch"), "add --budget"),
        (("--prove", "--tolerance", "--budget", "10"), "--budget"),
        (("--prove", "--tolerance", "--budget", "10 min", "--along", "magnet.radius"), "--along must be one of"),
    ],
)
def test_command_refuses_at_once(words, told) -> None:
    said = command_line.run("orbit", "paper/fig3c", *words)
    assert said.status == 2
    assert told in said.err
