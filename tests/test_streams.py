"""Standard output and error that are closed, full, or read by nobody: every command's help, refusals and results."""

import io
import os
import sys
import warnings
from pathlib import Path

import pytest

import helimag as hm
from helimag.cli import main
from test_cli_common import ALL, IDS

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="streams of Unix")
LAB = Path(__file__).parent / "data"
ROW = "paper/table1-row1"
SHORT = ("--set", "run.duration=2 s")
FIG = "nose-first/fig3c"
ORBIT = (FIG, "--set", "drive.frequency=2.5 Hz")
SWEEP = 'base = "short.toml"\n[[axis]]\nfield = "drive.pitch"\nvalues = ["4 deg", "5 deg"]\n'
# words with which each command gives a result, from the folder of inputs below
RESULTS: dict[tuple[str, ...], tuple[str, ...]] = {
    ("presets",): (),
    ("simulate",): (FIG, *SHORT, "--no-orbit", "--no-accuracy"),
    ("sweep",): ("sweep.toml", "-o", "sweep.zarr", "--threads", "1"),
    ("orbit",): ORBIT,
    ("plot",): ("run.nc", "-o", "run.svg"),
    ("resistance",): (FIG,),
    ("robot", "check"): (ROW,),
    ("robot", "program"): (ROW, "--accept-unbounded", "-o", "programme"),
    ("robot", "read-back"): ("row1.src", ROW),
    ("robot", "replay"): ("log.csv", ROW, *SHORT),
    ("compare",): ("run.nc", "run.nc"),
    ("vision", "import"): ("track.csv", "--gap", "0.1 m", "-o", "track.nc"),
    ("studio",): ("--no-browser", "--json"),
    ("doctor",): (FIG,),
    ("cite",): (FIG,),
}
# what takes long, or needs what takes long to make: its help and its refusals are tried here all the same
DEAR = {
    ("orbit", "map"),
    ("orbit", "flow"),
    ("orbit", "basin"),
    ("orbit", "against"),
    ("orbit", "check"),
    ("design",),
    ("calibrate",),
    ("reproduce",),
    ("robot", "jitter"),
    ("vision", "render"),
    ("vision", "calibrate"),
    ("vision", "track"),
}


class Broken:
    """Streams as a shell may hand them over; ``read`` is what could be read of standard error."""

    def __init__(self, out: str, err: str) -> None:
        self.out, self._err = _stream(out), (_stream(err) if err != "heard" else io.StringIO())
        self.err = self._err

    def said(self, words: tuple[str, ...]) -> tuple[int, str]:
        """Exit status of a command, and what it said where somebody hears it."""
        with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Cyclopts application invoked without tokens")
            patch.setattr(sys, "argv", ["helimag", *words])
            patch.setattr(sys, "stdout", self.out)
            patch.setattr(sys, "stderr", self.err)
            try:
                main()
                status = 0
            except SystemExit as end:
                status = int(end.code or 0)
        for stream in (self.out, self._err):
            if stream is not None and not isinstance(stream, io.StringIO):
                stream.close()
        return status, self._err.getvalue() if isinstance(self._err, io.StringIO) else ""


def _stream(kind: str):
    """What Python makes of a stream that a shell hands over."""
    if kind == "closed":
        return None
    if kind == "full":
        return open("/dev/full", "w", encoding="utf-8")
    if kind == "left":
        reader, writer = os.pipe()
        os.close(reader)
        return os.fdopen(writer, "w", encoding="utf-8")
    return open(os.devnull, "w", encoding="utf-8")


# out, err: status of a command that prints on out, and what can be heard of it
LOST = {
    ("closed", "heard"): (2, "helimag: standard output cannot be written: Bad file descriptor\n"),
    ("full", "heard"): (2, "helimag: standard output cannot be written: No space left on device\n"),
    ("left", "heard"): (1, ""),
    ("closed", "closed"): (2, ""),
    ("full", "full"): (2, ""),
    ("left", "left"): (1, ""),
    ("taken", "closed"): (0, ""),
    ("taken", "full"): (0, ""),
    ("taken", "left"): (0, ""),
}
STATES = pytest.mark.parametrize("streams", LOST, ids="-".join)


def test_every_command_is_tried_here():
    assert set(RESULTS) | DEAR == set(ALL)
    assert not set(RESULTS) & DEAR


@STATES
@pytest.mark.parametrize("words", ALL, ids=IDS)
def test_help_that_is_lost_is_no_success(words, streams):
    assert Broken(*streams).said((*words, "--help")) == LOST[streams]


@STATES
@pytest.mark.parametrize("words", ALL, ids=IDS)
def test_a_refusal_that_nobody_hears_is_a_refusal(words, streams):
    status, told = Broken(*streams).said((*words, "--no-such-option"))
    assert status == 2
    assert told.count("\n") == (streams[1] == "heard")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """A folder with what the commands read."""
    folder = tmp_path_factory.mktemp("streams")
    short = hm.load(FIG).replaced({"run.duration": "2 s"})
    (folder / "short.toml").write_text(short.to_toml(), encoding="utf-8")
    (folder / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    (folder / "programme").mkdir()
    hm.simulate(short).save(folder / "run.nc")
    for suffix in ("src", "dat"):
        (folder / f"row1.{suffix}").write_bytes((LAB / f"krl/krl-vel-aggregate-right/row1.{suffix}").read_bytes())
    (folder / "log.csv").write_bytes((LAB / "tables/log-semicolon-comma.csv").read_bytes())
    (folder / "track.csv").write_bytes((LAB / "tables/trk-semicolon.csv").read_bytes())
    return folder


def told(_scenario, *, tell, **_named):
    """In place of a server that would not end."""
    tell("http://localhost:8137/")


@pytest.mark.parametrize("words", RESULTS, ids=" ".join)
def test_a_result_that_is_lost_is_no_success(words, inputs, monkeypatch):
    monkeypatch.chdir(inputs)
    monkeypatch.setattr("helimag.studio.serve", told)
    for streams in (("full", "full"), ("left", "closed")):
        assert Broken(*streams).said((*words, *RESULTS[words])) == ({"full": 2, "left": 1}[streams[0]], "")
    status, heard = Broken("closed", "heard").said((*words, *RESULTS[words]))
    assert status == 2
    assert "Traceback" not in heard
    assert heard.splitlines()[-1] == "helimag: standard output cannot be written: Bad file descriptor"
