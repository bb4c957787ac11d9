"""Kinematics of the arm against Pinocchio: flange poses, all eight branches, limits, singular and lost poses."""

import math

import numpy as np
import pytest

from helimag.errors import FileError, InputError
from helimag.robot import forward, inverse_kinematics, load_arm, load_cell, within_limits
from helimag.robot.arm.frames import angles, frame, inverse, rotation, turn_vector, vector_turn
from helimag.robot.arm.kinematics import BRANCHES, TURN

pin = pytest.importorskip("pinocchio")


def rotation_angle(first, second):
    """Angles (n,) between rotations, by Pinocchio's logarithm."""
    return np.array([np.linalg.norm(pin.log3(a.T @ b)) for a, b in zip(first, second, strict=True)])


ARM = load_arm("kr10_r1100_2")
COUNT = 10_000


@pytest.fixture(scope="module")
def poses():
    """Random joints within the limits, and their flange frames by Pinocchio from a model of its own."""
    model = pin.Model()
    axes = [(0, 0, -1), (0, 1, 0), (0, 1, 0), (-1, 0, 0), (0, 1, 0), (-1, 0, 0)]
    offsets = [(0, 0, 0.400), (0.025, 0, 0), (0.560, 0, 0), (0.515, 0, 0.025), (0, 0, 0), (0, 0, 0)]
    parent = 0
    for i, (axis, offset) in enumerate(zip(axes, offsets, strict=True)):
        joint = pin.JointModelRevoluteUnaligned(np.array(axis, float))
        parent = model.addJoint(parent, joint, pin.SE3(np.eye(3), np.array(offset, float)), f"axis{i + 1}")
    tip = pin.SE3(pin.utils.rotate("y", np.pi / 2), np.array([0.090, 0, 0]))
    flange = model.addFrame(pin.Frame("flange", parent, 0, tip, pin.FrameType.OP_FRAME))
    data = model.createData()
    low = np.radians([-170, -190, -120, -185, -120, -350])
    high = np.radians([170, 45, 156, 185, 120, 350])
    joints = np.random.default_rng(1).uniform(low, high, (COUNT, 6))
    frames = []
    for row in joints:
        pin.framesForwardKinematics(model, data, row)
        frames.append(data.oMf[flange].homogeneous.copy())
    return joints, np.array(frames)


def test_published_check_pose():
    """Joints (0, -90, 90, 0, 0, 0) deg put the flange at (630, 0, 985) mm, pointing forwards."""
    flange = forward(ARM, np.radians([0.0, -90.0, 90.0, 0.0, 0.0, 0.0]))
    assert flange[:3, 3] == pytest.approx([0.630, 0.0, 0.985], abs=1e-12)
    assert flange[:3, 2] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)


def test_forward_agrees_with_pinocchio(poses):
    joints, flange = poses
    assert np.abs(forward(ARM, joints) - flange).max() < 1e-12


def test_inverse_finds_every_branch_of_ten_thousand_poses(poses):
    """Every solution puts the flange where it was to 1e-9 m and rad; the joints it came from are among them."""
    joints, flange = poses
    solutions = inverse_kinematics(ARM, flange)
    found = [within_limits(ARM, solution) for solution in solutions.joints]
    counts = np.array([len(rows) for rows in found])
    assert counts.min() >= 1
    where = np.repeat(np.arange(COUNT), counts)
    rows = np.concatenate(found)
    back = forward(ARM, rows)
    assert np.linalg.norm(back[:, :3, 3] - flange[where, :3, 3], axis=1).max() < 1e-9
    assert rotation_angle(back[:, :3, :3], flange[where, :3, :3]).max() < 1e-9
    low, high = ARM.limits
    assert np.all((rows >= low - 1e-9) & (rows <= high + 1e-9))
    nearest = np.full(COUNT, np.inf)
    np.minimum.at(nearest, where, np.abs(rows - joints[where]).max(axis=1))
    regular = np.nanmin(solutions.singular, axis=(1, 2)) > 1e-4
    assert regular.sum() > 0.99 * COUNT
    assert nearest[regular].max() < 1e-8


def test_all_eight_branches_are_different_and_agree(poses):
    _, flange = poses
    solutions = inverse_kinematics(ARM, flange[:2000])
    full = solutions.reachable.all(axis=1) & (solutions.singular.min(axis=(1, 2)) > 0.05)
    assert full.sum() > 200
    for one, target in zip(solutions.joints[full], flange[:2000][full], strict=True):
        assert np.abs(forward(ARM, one) - target).max() < 1e-9
        difference = one[:, None] - one[None, :]
        apart = np.abs(difference - TURN * np.round(difference / TURN)).max(axis=2)
        assert apart[~np.eye(BRANCHES, dtype=bool)].min() > 1e-3


def test_whole_turns_of_the_wrist_are_listed():
    """A4 and A6 reach beyond half a turn, so that one branch may be held in several ways."""
    joints = np.radians([10.0, -80.0, 110.0, -178.0, 40.0, -100.0])
    found = within_limits(ARM, inverse_kinematics(ARM, forward(ARM, joints)).joints)
    for turned in ((0, 0), (1, 0), (0, 1), (1, 1)):
        wanted = joints + np.array([0.0, 0.0, 0.0, turned[0], 0.0, turned[1]]) * TURN
        assert np.abs(found - wanted).max(axis=1).min() < 1e-9
    assert np.abs(found - (joints + np.array([0, 0, 0, 0, 0, -TURN]))).max(axis=1).min() > 1e-3


def test_poses_out_of_reach_are_reported():
    far = inverse_kinematics(ARM, frame([2.0, 0.0, 0.5], [0.0, math.pi / 2, 0.0]))
    assert not far.reachable.any()
    assert np.isnan(far.joints).all()
    near = inverse_kinematics(ARM, frame([0.025 + 0.090, 0.0, 0.400], [0.0, math.pi / 2, 0.0]))
    assert not near.reachable[:4].any()


@pytest.mark.parametrize(
    ("joints", "which"),
    [
        ([10.0, -60.0, 90.0, 30.0, 0.0, 20.0], 2),
        ([0.0, -90.0, math.degrees(math.atan2(25.0, 515.0)), 30.0, 40.0, 0.0], 1),
    ],
)
def test_singular_poses_are_reported_and_still_solved(joints, which):
    flange = forward(ARM, np.radians(joints))
    solutions = inverse_kinematics(ARM, flange)
    assert np.nanmin(solutions.singular[:, which]) < 1e-5
    held = solutions.joints[solutions.reachable]
    assert len(held) >= 2
    assert np.abs(forward(ARM, held) - flange).max() < 1e-7


def test_wrist_over_the_first_axis_is_singular():
    """The wrist's centre is put on the first axis by choosing the elbow for it."""
    height = 0.400 + 0.7
    flange = frame([0.0, 0.0, height + 0.090], [0.0, 0.0, 0.0])
    solutions = inverse_kinematics(ARM, flange)
    assert solutions.reachable.any()
    assert np.nanmin(solutions.singular[:, 0]) < 1e-9


def test_another_arm_has_other_numbers():
    """Half the size and other signs: the flange is half as far, and the axis turns the other way."""
    other = ARM.model_dump(mode="python")
    other["link"] = {name: value / 2.0 for name, value in other["link"].items()}
    other["joint_sign"] = (1, 1, 1, -1, 1, -1)
    small = type(ARM).model_validate(other)
    joints = np.radians([30.0, -80.0, 100.0, 10.0, 20.0, 30.0])
    mirrored = joints * np.array([-1, 1, 1, 1, 1, 1])
    assert forward(small, joints)[:3, 3] == pytest.approx(forward(ARM, mirrored)[:3, 3] / 2.0, abs=1e-12)
    solutions = inverse_kinematics(small, forward(small, joints))
    assert np.nanmin(np.abs(solutions.joints - joints).max(axis=1)) < 1e-9


def test_arm_file_beside_the_cell(tmp_path):
    from importlib import resources

    data = resources.files("helimag.robot") / "data"
    arm = (data / "kr10_r1100_2.toml").read_text().replace("KUKA KR10 R1100-2", "mine").replace('"560 mm"', '"600 mm"')
    (tmp_path / "mine.toml").write_text(arm)
    cell = (data / "default_cell.toml").read_text().replace('"kr10_r1100_2"', '"mine.toml"')
    (tmp_path / "cell.toml").write_text(cell)
    loaded = load_cell(tmp_path / "cell.toml")
    assert loaded.arm.name == "mine"
    assert loaded.arm.link.a2 == 0.6


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"560 mm"', '"560 deg"', ["link.a2", "length"]),
        ('"560 mm"', "560", ["link.a2", "unit"]),
        ('"300 deg/s"', '"-300 deg/s"', ["joint_speed", "positive"]),
        ('"45 deg"', '"-195 deg"', ["joint_min", "axis 2"]),
        ("name =", "nmae =", ["nmae"]),
    ],
)
def test_bad_arm_files_are_refused(tmp_path, old, new, words):
    from importlib import resources

    text = (resources.files("helimag.robot") / "data" / "kr10_r1100_2.toml").read_text()
    assert old in text
    (tmp_path / "arm.toml").write_text(
        text.replace(old, new, 1) if old != "name =" else text.replace("\nname =", "\nnmae =")
    )
    with pytest.raises(InputError) as caught:
        load_arm(tmp_path / "arm.toml")
    for word in words:
        assert word in str(caught.value)


def test_missing_files_are_refused(tmp_path):
    with pytest.raises(FileError, match="neither"):
        load_arm("no_such_arm")
    with pytest.raises(FileError, match="neither"):
        load_cell(tmp_path / "none.toml")
    for load in (load_arm, load_cell):
        with pytest.raises(FileError, match="cannot be read"):
            load("a" * 5000)  # longer than a name may be
    (tmp_path / "cell.toml").write_text(f'arm = "{"a" * 5000}"')
    with pytest.raises(FileError, match="cannot be read"):
        load_cell(tmp_path / "cell.toml")


def test_frames_are_their_own_inverses():
    random = np.random.default_rng(2)
    abc = random.uniform(-1.0, 1.0, (200, 3)) * np.array([math.pi, 1.5, math.pi])
    assert rotation_angle(rotation(angles(rotation(abc))), rotation(abc)).max() < 1e-12
    upright = rotation(np.array([[0.3, math.pi / 2, -0.2], [0.3, -math.pi / 2, 0.5]]))
    assert rotation_angle(rotation(angles(upright)), upright).max() < 1e-7
    whole = frame([0.1, 0.2, 0.3], [0.4, 0.5, 0.6])
    assert np.abs(inverse(whole) @ whole - np.eye(4)).max() < 1e-15
    for length in (0.0, 1e-9, 1e-3, 1.0, math.pi - 1e-9, math.pi):
        vector = length * np.array([2.0, -1.0, 2.0]) / 3.0
        turned = turn_vector(vector)
        assert np.abs(turned - pin.exp3(vector)).max() < 1e-12
        assert np.abs(turn_vector(vector_turn(turned)) - turned).max() < 1e-7
