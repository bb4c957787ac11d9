"""Which end leads: where a scenario says it, how a run starts then, and what is reported of it."""

import json
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import helimag as hm
from helimag.diagnosis import diagnose
from helimag.engine import forward, start_attitude, start_state
from helimag.ensembles import Perturbation
from helimag.robot.logs import Log, replayed
from helimag.runs import leading_end, path_cosine
from helimag.scenario import Input, parse

STRAIGHT = hm.load("nose-first/table1-row1")
CIRCLE = hm.load("nose-first/fig3c")
BACK = {"drive.velocity": ("-0.825 mm/s", 0.0, 0.0)}
REVERSED = {"drive.yaw_rate": "-1.8 deg/s"}
PATH = {"position": [(0.0, 0.0, 0.102), (0.0, 0.05, 0.102)], "time": [0.0, 200.0], "yaw": [1.0, 1.0]}
SAMPLED = STRAIGHT.replaced({"drive.velocity": (0.0, 0.0, 0.0), "drive.path": PATH})


def matrix(scenario):
    w, x, y, z = start_attitude(scenario)
    return Rotation.from_quat([x, y, z, w]).as_matrix()


@pytest.mark.parametrize(
    ("scenario", "changes", "way"),
    [
        (STRAIGHT, {}, 0.0),
        (STRAIGHT, BACK, math.pi),
        (CIRCLE, {}, 0.0),
        (CIRCLE, REVERSED, math.pi),
        (STRAIGHT.replaced({"drive.velocity": (0.0, 0.0, 0.0)}), {}, 0.0),
        (SAMPLED, {}, 1.0),  # along the axis, which yaws by 1 rad, on the side of y
        (SAMPLED, {"drive.path": {**PATH, "yaw": [-1.0, -1.0]}}, math.pi - 1.0),
    ],
)
def test_the_end_that_leads_points_where_the_drive_goes(scenario, changes, way):
    scenario = scenario.replaced(changes)
    ahead = np.array([math.cos(way), math.sin(way), 0.0])
    np.testing.assert_allclose(forward(scenario), ahead, atol=1e-12)
    for heading, sign in (("head", 1.0), ("helix", -1.0)):
        turned = matrix(scenario.replaced({"drive.heading": heading}))
        np.testing.assert_allclose(turned[:, 0], sign * ahead, atol=1e-12)
        side = [-math.sin(scenario.drive.angles[0]), math.cos(scenario.drive.angles[0]), 0.0]
        np.testing.assert_allclose(turned[:, 1], side, atol=1e-12)  # beside the magnet's moment


def test_who_changes_a_start_changes_no_other_run():
    for heading in ("head", "helix", None):
        scenario = hm.load("nose-first/fig3c").replaced({"drive.heading": heading})
        before = start_attitude(scenario).tolist()
        start_attitude(scenario)[:] = 0.0
        assert start_attitude(scenario).tolist() == before


def test_left_out_it_is_level_along_x_whatever_the_drive():
    for scenario in (STRAIGHT, STRAIGHT.replaced(BACK), CIRCLE.replaced(REVERSED), SAMPLED):
        np.testing.assert_array_equal(start_state(scenario), [*scenario.drive.start, 1.0, 0.0, 0.0, 0.0])


def test_a_whole_attitude_is_that_of_the_papers_appendix():
    yaw, pitch, roll = 0.4, -0.1, 2.0
    turned = matrix(STRAIGHT.replaced({"drive.heading": (yaw, pitch, roll)}))
    about = [Rotation.from_rotvec(v).as_matrix() for v in ([0, 0, yaw], [0, -pitch, 0], [roll, 0, 0])]
    np.testing.assert_allclose(turned, about[0] @ about[1] @ about[2], atol=1e-14)
    assert math.asin(turned[2, 0]) == pytest.approx(pitch)  # the attack angle


def test_it_is_read_from_a_file_and_written_back_and_part_of_the_hash():
    text = STRAIGHT.to_toml()
    assert "heading" not in text
    word = STRAIGHT.replaced({"drive.heading": "helix"})
    angles = STRAIGHT.replaced({"drive.heading": ["180 deg", "-6 deg", "0 deg"]})
    for scenario in (word, angles):
        assert parse(scenario.to_toml()) == scenario
    assert len({STRAIGHT.hash, word.hash, angles.hash}) == 3
    assert STRAIGHT.replaced({"drive.heading": None}).hash == STRAIGHT.hash


@pytest.mark.parametrize("value", ["tail", "", 3.0, ["1 deg", "2 deg"], ["1 mm", "0 deg", "0 deg"], {"x": 1}, True])
def test_anything_else_is_refused_by_name(value):
    with pytest.raises(hm.InputError, match=r"drive\.heading"):
        STRAIGHT.replaced({"drive.heading": value})


def test_a_sweep_may_choose_between_the_ends():
    assert Input("drive.heading").choices(STRAIGHT) == ("helix", "head")
    with pytest.raises(hm.InputError, match="choice of helix, head"):
        Input("drive.heading").check(STRAIGHT)


def test_a_mirrored_scenario_is_the_mirrored_run():
    """Nose along -x under a left-handed drive is the x-mirror of nose along x under a right-handed one."""
    scenario = hm.load("paper/fig3c").replaced({"run.duration": 120.0})
    mirrored = scenario.replaced(
        {
            "device.helix.handedness": "right",
            "drive.yaw_rate": -scenario.drive.yaw_rate,
            "drive.pitch": -scenario.drive.pitch,
            "drive.heading": None,
        }
    )
    run, other = (hm.simulate(each).dataset["position"].values for each in (scenario, mirrored))
    np.testing.assert_allclose(run, other * [-1.0, 1.0, 1.0], atol=1e-7)
    assert np.ptp(run[:, 0]) > 0.02


def test_ensembles_jitter_about_the_heading():
    scenario = CIRCLE.replaced({"drive.heading": "helix"})
    copies = Perturbation(displacement=1e-5).copies(scenario, 5, np.random.default_rng(1))
    np.testing.assert_allclose(copies.states[:, 3:], np.tile([0.0, 0.0, 1.0, 0.0], (5, 1)), atol=1e-15)


def test_a_replayed_log_keeps_the_heading_whatever_the_arm_does_first():
    scenario = STRAIGHT.replaced({"drive.heading": "helix"})
    time = np.linspace(0.0, 10.0, 101)
    pose = np.tile(np.eye(4), (101, 1, 1))
    pose[:, :3, :3] = Rotation.from_euler("y", -scenario.drive.pitch).as_matrix()
    pose[:, 2, 3], pose[:, 0, 3] = 0.102, 0.825e-3 * time
    pose[1, 0, 3] = -1e-4  # a jerk backwards
    again = replayed(scenario, Log(time, pose, None, False), "test")
    assert forward(again)[0] == -1.0
    np.testing.assert_allclose(np.abs(start_attitude(again) @ start_attitude(scenario)), 1.0, rtol=1e-12)


def test_the_leading_end_is_told_from_the_path():
    angle = np.linspace(0.0, 6.0, 200)
    circle = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1)
    assert path_cosine(circle, along) == pytest.approx(1.0, abs=1e-3)
    tilted = -math.cos(0.3) * along + math.sin(0.3) * np.array([0.0, 0.0, 1.0])
    assert path_cosine(circle, tilted) == pytest.approx(-math.cos(0.3), abs=1e-3)
    gaps = circle.copy()
    gaps[50:60] = np.nan
    assert path_cosine(gaps, along) == pytest.approx(1.0, abs=2e-2)
    assert math.isnan(path_cosine(np.ones((5, 3)), along[:5]))
    assert [leading_end(x) for x in (0.9, -0.9, 0.1, math.nan)] == ["head", "helix", "neither", "neither"]


def test_runs_orbits_and_the_doctor_agree_on_it(helimag):
    scenario = hm.load("paper/fig3c")
    assert diagnose(scenario).at_start.leads == "helix"
    status, out, _ = helimag("simulate", "paper/fig3c", "--duration", "200 s", "--no-orbit", "--json")
    assert status == 0
    told = json.loads(out)
    assert told["leads"] == "helix"
    assert told["leading_cosine"] < -0.8
    orbit = hm.find_orbit(scenario)
    assert orbit.leading_end == "helix"
    assert orbit.leading_cosine < -0.8
    status, out, _ = helimag("simulate", "paper/fig3c", "--duration", "20 s", "--no-orbit")
    assert "leads         helix (mean cosine of nose and velocity -" in out


def test_the_robot_asks_for_the_scenarios_own_start():
    scenario = STRAIGHT.replaced({"drive.heading": "helix", "run.duration": 1.0})
    run = hm.simulate(scenario)
    np.testing.assert_allclose(run.dataset["quaternion"].values[0], start_attitude(scenario), atol=1e-15)
