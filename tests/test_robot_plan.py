"""From scenario and cell to joints: the magnet's path, checks against limits and boxes, laps, unwinding."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize

from helimag.engine import simulate
from helimag.errors import InputError
from helimag.robot import forward, load_cell, magnet_path, plan, report
from helimag.robot.arm.collision import capsules, clearances, segment_box_distance, tool_frames_in_base
from helimag.robot.arm.path import MotionKind
from helimag.robot.timed import timed_table
from helimag.scenario import load

CELL = load_cell("wide")
CIRCLES = [f"nose-first/fig3{letter}" for letter in "abc"]
STRAIGHT = [f"nose-first/table1-row{row}" for row in range(1, 8)]


@cache
def nine_laps():
    return plan(load("nose-first/fig3c"), CELL, unwind=True)


def changed(**tables):
    """The default cell with fields replaced."""
    data = CELL.model_dump(mode="python")
    for name, value in tables.items():
        data[name] = {**data[name], **value} if isinstance(value, dict) else value
    return type(CELL).model_validate(data)


@pytest.mark.parametrize("name", ["nose-first/fig3a", "nose-first/table1-row1"])
@pytest.mark.parametrize("about", ["origin", "magnet"])
def test_path_is_the_one_that_the_simulation_uses(name, about):
    """Position and moment against those that the kernels write, with velocity and yaw together."""
    scenario = load(name).replaced(
        {
            "drive.pitch_about": about,
            "drive.yaw_rate": "2.5 deg/s",
            "drive.velocity": ["1 mm/s", "-0.5 mm/s", "0.2 mm/s"],
            "run.duration": "3 s",
            "run.interval": "0.1 s",
        }
    )
    run = simulate(scenario).dataset
    poses = magnet_path(scenario).at(run.time.values)
    moment = np.stack([np.zeros(poses.time.size), np.cos(poses.spin), np.sin(poses.spin)], axis=1)
    turned = np.einsum("nij,nj->ni", poses.rotation, moment)
    assert np.abs(poses.position - run.rpm_position.values).max() < 1e-12
    assert np.abs(turned - run.rpm_moment.values / scenario.magnet[0].moment).max() < 1e-11


@pytest.mark.parametrize("name", STRAIGHT)
def test_straight_runs_of_table_1_are_feasible(name):
    found = plan(load(name), CELL)
    assert found.feasible
    assert [motion.kind for motion in found.motions] == [MotionKind.LINE]
    margins = report(found)["margins"]
    assert min(margins["joint_limits_deg"].values()) > 10.0
    assert margins["singularity_deg"] > 10.0
    assert min(margins["obstacles_mm"].values()) > 20.0


@pytest.mark.parametrize("name", CIRCLES)
def test_circles_of_fig_3_wind_the_wrist_up(name):
    """Nine laps do not fit into the 700 deg of axis 6: refused with time, joint, value; the laps that fit pass."""
    scenario = load(name)
    found = plan(scenario, CELL)
    assert not found.feasible
    assert (found.offence.kind, found.offence.joint) == ("limit", "A6")
    assert abs(found.offence.value) > math.radians(350.0)
    assert 1.8 < found.laps_allowed < 700.0 / 360.0 + 0.1
    assert report(found)["laps"] == pytest.approx(9.0)
    within = plan(scenario.replaced({"run.duration": math.floor(found.offence.time)}), CELL)
    assert within.feasible
    if name == "nose-first/fig3c":
        assert not plan(scenario.replaced({"run.duration": found.offence.time + 12.0}), CELL).feasible


def test_plan_puts_the_magnet_where_the_scenario_wants_it():
    """Joints to tool by forward kinematics, against the path: a way round that does not share the inverse."""
    for name in ("nose-first/fig3c", "nose-first/table1-row3"):
        found = plan(load(name).replaced({"run.duration": 150.0}), CELL)
        tool = np.linalg.inv(CELL.lab_in_base) @ tool_frames_in_base(CELL, found.joints)
        poses = found.path.at(found.times)
        assert np.abs(tool[:, :3, 3] - poses.position).max() < 1e-12
        sign = -1.0 if found.reversed_axis else 1.0
        assert np.abs(sign * tool[:, :3, 0] - poses.axis).max() < 1e-12
        assert np.abs(np.diff(found.joints, axis=0)).max() < math.radians(6.0)
        low, high = CELL.arm.limits
        assert np.all((found.joints >= low) & (found.joints <= high))


def test_unwinding_makes_nine_laps_feasible():
    found = nine_laps()
    assert found.feasible
    assert 7 <= len(found.unwindings) <= 8
    low, high = CELL.arm.limits
    assert np.all((found.joints >= low) & (found.joints <= high))
    each = 360.0 / (0.5 * 433.0)
    assert found.duration == pytest.approx(1800.0 + each * len(found.unwindings))
    table = timed_table(found)
    assert np.all(np.diff(table.time) >= 0.0)
    assert table.time[-1] == pytest.approx(found.duration)
    inside = table.tool[table.unwinding]
    stops = np.array([found.path.at(np.array([stop.time])).position[0] for stop in found.unwindings])
    away = np.linalg.norm(inside[:, None, :3, 3] - stops[None], axis=2).min(axis=1)
    assert away.max() < 1e-9
    turned = np.array([stop.turns for stop in found.unwindings])
    assert np.all(np.abs(turned) == 1)
    assert len(set(turned)) == 1


def test_unwinding_needs_the_magnet_on_the_sixth_axis():
    off = changed(tool={"magnet": (0.02, 0.0, 0.13)})
    with pytest.raises(InputError, match=r"tool\.magnet on the flange's z axis"):
        plan(load("nose-first/fig3c"), off, unwind=True)


@pytest.mark.parametrize(
    ("cell", "kind", "words"),
    [
        (changed(base={"position": (1.4, 0.0, 0.25)}), "reach", "out of reach"),
        (changed(speed_share=1e-6), "speed", "would turn at"),
        (changed(clearance=0.2), "collision", "mm away"),
        (changed(singularity_margin=1.5), "singularity", "from a singularity"),
    ],
)
def test_infeasible_cells_are_refused_with_time_joint_and_value(cell, kind, words):
    found = plan(load("nose-first/table1-row1"), cell)
    assert not found.feasible
    data = report(found)
    assert data["offence"]["kind"] == kind
    assert data["offence"]["time_s"] >= 0.0
    assert words in data["offence"]["text"]
    assert data["offence"]["joint"]
    assert data["remedies"]
    if kind != "reach":
        assert math.isfinite(data["offence"]["value"])


def test_speed_offence_names_the_speed():
    """A yaw of 300 deg/s is more than half of axis 6' 433 deg/s."""
    scenario = load("nose-first/fig3c").replaced({"drive.yaw_rate": "300 deg/s", "run.duration": "1 s"})
    found = plan(scenario, CELL)
    assert found.offence.kind == "speed"
    assert found.offence.value > found.offence.limit


def test_distance_to_a_box_against_an_optimiser():
    random = np.random.default_rng(3)
    low, high = np.array([-0.1, -0.2, -0.3]), np.array([0.2, 0.1, 0.3])
    begin, end = random.uniform(-1.0, 1.0, (2, 15, 3))
    found = segment_box_distance(begin, end, low, high)
    for a, b, distance in zip(begin, end, found, strict=True):

        def gap(v, a=a, b=b):
            return np.sum((a + v[0] * (b - a) - v[1:]) ** 2)

        bounds = [(0.0, 1.0), *zip(low, high, strict=True)]
        best = min(minimize(gap, [s, 0, 0, 0], bounds=bounds, method="L-BFGS-B").fun for s in (0.1, 0.5, 0.9))
        assert distance == pytest.approx(math.sqrt(best), abs=2e-5)
    inside = segment_box_distance(np.array([[-1.0, 0, 0]]), np.array([[1.0, 0, 0]]), low, high)
    assert inside[0] == pytest.approx(0.0, abs=1e-8)
    corner = segment_box_distance(np.array([[0.5, 0.5, 0.7]]), np.array([[0.5, 0.5, 0.7]]), low, high)
    assert corner[0] == pytest.approx(math.hypot(0.3, 0.4, 0.4), abs=1e-12)


def test_capsules_follow_the_arm():
    joints = np.radians([[0.0, -90.0, 90.0, 0.0, 0.0, 0.0]])
    parts = dict(zip(capsules(CELL, joints, 0.02).names, range(7), strict=True))
    found = capsules(CELL, joints, 0.02)
    to_base = CELL.lab_in_base
    wrist = to_base[:3, :3] @ found.end[0, parts["forearm"]] + to_base[:3, 3]
    assert wrist == pytest.approx([0.540, 0.0, 0.985])
    magnet = to_base[:3, :3] @ found.begin[0, parts["magnet"]] + to_base[:3, 3]
    assert magnet == pytest.approx(forward(CELL.arm, joints)[0, :3, 3] + [0.130, 0.0, 0.0])


def test_clearance_counts_the_radius_of_the_magnet():
    """102 mm up, less the ball that a 35 mm by 20 mm cylinder sweeps, less the tank's rim at 20 mm."""
    found = plan(load("nose-first/table1-row1"), CELL)
    reach = math.hypot(0.0175, 0.010)
    parts = capsules(CELL, found.joints, reach)
    tank = clearances(parts, CELL.obstacle[0])[:, parts.names.index("magnet")]
    assert tank == pytest.approx(0.102 - reach - 0.020, abs=1e-8)


def test_waypoints_with_speeds_are_a_path():
    """A square of waypoints, each way at its own speed; the motions stay within 1 um of the spline between them."""
    data = {
        "position": [["0 mm", "0 mm", "150 mm"], ["40 mm", "0 mm", "150 mm"], ["40 mm", "40 mm", "155 mm"]],
        "speed": ["2 mm/s", "4 mm/s"],
        "yaw": ["0 deg", "30 deg", "80 deg"],
    }
    scenario = load("nose-first/table1-row1").replaced(
        {"drive.path": data, "drive.velocity": [0.0, 0.0, 0.0], "run.duration": "30 s"}
    )
    path = magnet_path(scenario)
    corner = 20.0 + math.hypot(40.0, 5.0) / 4.0
    assert scenario.drive.path.duration == pytest.approx(corner)
    at = path.at(np.array([0.0, 20.0, 30.0]))
    assert at.position[1] == pytest.approx([0.04, 0.0, 0.15])
    assert math.degrees(math.atan2(at.axis[1, 1], at.axis[1, 0])) == pytest.approx(30.0)
    assert plan(scenario, CELL).feasible
    for motion in path.motions[:: max(1, len(path.motions) // 40)]:
        times = np.linspace(motion.begin, motion.end, 9)
        position = path.at(times).position
        chord = position[0] + np.linspace(0.0, 1.0, 9)[:, None] * (position[-1] - position[0])
        assert np.linalg.norm(position - chord, axis=1).max() < 4e-7
    assert path.motions[0].begin == 0.0
    assert path.motions[-1].end == 30.0
