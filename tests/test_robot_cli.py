"""The robot commands and the RoboDK script, from outside."""

import json
import sys
import types
from functools import partial

import numpy as np
import pytest

from helimag.robot import load_cell, plan
from helimag.robot.arm.frames import rotation
from helimag.robot.robodk import write_robodk
from helimag.scenario import load

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
    status, out, _ = run("check", "nose-first/fig3c")
    assert status == 0
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
        (("program", "nose-first/fig3c", "-o", "{}"), "A6 would pass its limit"),
        (("check", "nose-first/fig3c", "--cell", "{}/none.toml"), "neither"),
        (("read-back", "{}/none.src", "nose-first/fig3c"), "there is no file"),
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


def test_jitter_prints_each_kind(run, tmp_path):
    (tmp_path / "jitter.toml").write_text('offset = ["0 mm", "0 mm", "1 mm"]\n')
    status, out, _ = run("jitter", *SHORT[:1], tmp_path / "jitter.toml", *SHORT[1:])
    assert status == 0
    assert "none" in out
    assert "offset" in out


def test_robodk_script_makes_the_plan_s_moves(monkeypatch):
    """The script runs against a stand-in for RoboDK that records what it is told, its angles spelled out."""
    found = plan(load("nose-first/fig3c").replaced({"run.duration": "100 s"}), load_cell())
    calls = []

    class Arm:
        def __getattr__(self, name):
            return lambda *values: calls.append((name, values))

    def kuka_2_pose(values):
        pose = np.eye(4)
        pose[:3, :3] = rotation(np.radians(values[3:]))
        pose[:3, 3] = values[:3]
        return pose

    link = types.ModuleType("robodk.robolink")
    link.ITEM_TYPE_ROBOT = 2
    link.Robolink = lambda: types.SimpleNamespace(ItemUserPick=lambda *_: Arm())
    math_module = types.ModuleType("robodk.robomath")
    math_module.KUKA_2_Pose = kuka_2_pose
    for name, module in {
        "robodk": types.ModuleType("robodk"),
        "robodk.robolink": link,
        "robodk.robomath": math_module,
    }.items():
        monkeypatch.setitem(sys.modules, name, module)
    exec(compile(write_robodk(found, "lap", ["a\nb"]), "lap.py", "exec"), {})
    arcs = [values for name, values in calls if name == "MoveC"]
    assert len(arcs) == 2
    speeds = [values[0] for name, values in calls if name == "setSpeed"]
    ends = found.path.at(np.array([motion.end for motion in found.motions]))
    radius = np.hypot(*ends.position[0, :2])
    assert speeds == pytest.approx([1e3 * radius * np.radians(1.8)] * 2)
    for (via, target), position, axis in zip(arcs, ends.position, ends.axis, strict=True):
        assert target[:3, 3] == pytest.approx(1e3 * position, abs=1e-6)
        assert abs(target[:3, 0] @ axis) == pytest.approx(1.0, abs=1e-12)
        assert np.hypot(*via[:2, 3]) == pytest.approx(1e3 * radius, abs=1e-6)
    (start,) = (values[0] for name, values in calls if name == "MoveJ")
    assert np.radians(start) == pytest.approx(found.joints[0])
