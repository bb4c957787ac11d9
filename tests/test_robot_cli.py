"""The robot commands and the RoboDK script, from outside."""

import json
from functools import partial

import pytest

pytestmark = pytest.mark.filterwarnings("ignore:Cyclopts application invoked:UserWarning")


@pytest.fixture
def run(helimag):
    return partial(helimag, "robot")


SHORT = ("nose-first/table1-row1", "--set", "run.duration=20 s", "--set", "workspace={}")


def test_check_reports_a_straight_run_as_feasible(run):
    status, out, _ = run("check", "nose-first/table1-row3", "--json")
    report = json.loads(out)
    assert status == 0
    assert report["feasible"] is True
    assert report["offence"] is None
    assert report["duration_s"] == pytest.approx(193.9)


def test_check_reports_a_circle_with_the_laps_it_allows(run):
    status, out, err = run("check", "nose-first/fig3c", "--cell", "wide")
    assert status == 1
    assert "cannot run 'nose-first/fig3c'" in err
    assert len(err.strip().splitlines()) == 1
    assert "NOT feasible" in out
    assert "A6 would pass its limit of 350.00 deg" in out
    assert "of 9.00 laps" in out
    assert "feasible with 8 unwindings" in out or "feasible with 7 unwindings" in out


def test_programme_is_written_read_back_and_replayed(run, tmp_path):
    status, out, err = run("program", *SHORT, "-o", tmp_path, "--name", "row1", "--accept-unbounded", "--json")
    assert status == 0, err
    assert len(json.loads(out)["files"]) == 6
    status, out, _ = run("read-back", tmp_path / "row1.src", *SHORT, "--json")
    assert status == 0
    assert json.loads(out)["position_m"] < 1e-6
    status, _, err = run("read-back", tmp_path / "row1.src", "nose-first/table1-row7")
    assert status == 1
    assert "not the programme of this scenario" in err
    for log in ("row1_path.csv", "row1.src"):
        status, out, _ = run("replay", tmp_path / log, *SHORT, "--json", "-o", tmp_path / "run.nc")
        assert status == 0
        both = json.loads(out)
        assert both["replayed"]["gain"] == pytest.approx(both["planned"]["gain"], rel=1e-4)
        assert (tmp_path / "run.nc").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("program", "nose-first/table1-row1", "-o", "{}", "--name", "x();HALT"), "programme's name"),
        (("program", "nose-first/table1-row1", "-o", "{}"), "--accept-unbounded"),
        (
            ("check", "nose-first/fig3c"),
            "must be inside the cell's tank, y from -40 mm to 40 mm; got '-45 mm'",
        ),
        (("check", "nose-first/fig3c", "--cell", "{}/none.toml"), "neither"),
        (("read-back", "{}/none.src", "nose-first/table1-row1"), "there is no file"),
        (("replay", "{}/none.csv", "nose-first/fig3c"), "there is no file"),
        (("jitter", "nose-first/table1-row1", "{}/none.toml"), "there is no file"),
    ],
)
def test_bad_input_is_one_line_and_status_2(run, tmp_path, arguments, words):
    by_verdict = words == "--accept-unbounded"
    status, out, err = run(*(argument.format(tmp_path) for argument in arguments), refused_by_a_run=by_verdict)
    assert status == 2
    assert out == ""
    assert words in err
    assert len(err.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_programme_that_the_arm_cannot_run_is_no_bad_input(run, tmp_path):
    status, out, err = run("program", "nose-first/fig3c", "--cell", "wide", "-o", tmp_path)
    assert status == 1
    assert out == ""
    assert "A6 would pass its limit" in err
    assert list(tmp_path.iterdir()) == []


def test_jitter_prints_each_kind(run, tmp_path):
    (tmp_path / "jitter.toml").write_text('offset = ["0 mm", "0 mm", "1 mm"]\n')
    status, out, _ = run("jitter", *SHORT[:1], tmp_path / "jitter.toml", *SHORT[1:])
    assert status == 0
    kinds = {line.split()[0]: line for line in out.splitlines()[1:]}
    assert set(kinds) == {"none", "offset", "all"}
    assert "(one run)" in kinds["none"]  # of which no spread is known
    assert "(one run)" in kinds["offset"]
