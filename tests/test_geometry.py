"""Shared geometry against SciPy's Rotation, the kernels' own formulas, and closed forms."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from helimag.engine import simulate
from helimag.geometry import (
    body_rotations,
    helix_line,
    long_axes,
    magnet_motion,
    magnet_start,
    quaternion_product,
    turn,
)
from helimag.hydrodynamics.resistive_force import centerline
from helimag.plots._shapes import helix_line as drawn
from helimag.robot.arm.frames import angles, rotation
from helimag.runs.comparison import compare
from helimag.scenario import load
from helimag.vision.shape import Shape

RANDOM = np.random.default_rng(4)
QUATERNIONS = Rotation.random(500, rng=4).as_quat(scalar_first=True)
EXACT = 1e-15  # rounding


def test_quaternions_agree_with_scipy():
    scipy = Rotation.from_quat(QUATERNIONS, scalar_first=True)
    assert np.abs(body_rotations(QUATERNIONS) - scipy.as_matrix()).max() <= EXACT
    assert np.abs(long_axes(QUATERNIONS) - scipy.apply([1.0, 0.0, 0.0])).max() <= EXACT
    other = Rotation.random(500, rng=5)
    product = (scipy * other).as_quat(scalar_first=True)
    assert np.abs(quaternion_product(QUATERNIONS, other.as_quat(scalar_first=True)) - product).max() <= EXACT
    batch = QUATERNIONS.reshape(5, 100, 4)
    assert np.array_equal(body_rotations(batch).reshape(500, 3, 3), body_rotations(QUATERNIONS))


def test_turns_and_kuka_angles_agree_with_scipy():
    angle = RANDOM.uniform(-4.0, 4.0, 300)
    for i, axis in enumerate("xyz"):
        assert np.abs(turn(i, angle) - Rotation.from_euler(axis, angle[:, None]).as_matrix()).max() <= EXACT
    abc = RANDOM.uniform(-1.0, 1.0, (300, 3)) * [math.pi, 1.5, math.pi]
    composed = turn(2, abc[:, 0]) @ turn(1, abc[:, 1]) @ turn(0, abc[:, 2])
    assert np.abs(rotation(abc) - composed).max() <= EXACT
    assert angles(composed) == pytest.approx(Rotation.from_matrix(composed).as_euler("ZYX"), abs=1e-13)


@pytest.mark.parametrize("handedness", ["left", "right"])
def test_one_wire_is_resisted_drawn_and_seen(handedness):
    device = load("nose-first/fig3c").replaced({"device.helix.handedness": handedness}).device
    helix, head = device.helix, device.head
    chirality = {"left": 1.0, "right": -1.0}[handedness]
    seen, shown = Shape.of(device).wire(50), drawn(device)
    resisted, tangents, _ = centerline(helix, head.reach)
    for points in (seen, shown, resisted):
        along = -head.reach - points[:, 0]
        angle = np.arctan2(chirality * points[:, 2], points[:, 1])
        assert np.hypot(points[:, 1], points[:, 2]) == pytest.approx(np.full(len(points), helix.radius), rel=1e-12)
        off = np.exp(1j * angle) - np.exp(2j * math.pi * along / helix.pitch)
        assert np.abs(off).max() < 1e-12
    # tangents by central differences of the line itself
    step = 1e-9
    ends = [
        helix_line(-head.reach - resisted[:, 0] + s, radius=helix.radius, pitch=helix.pitch, chirality=chirality,
                   behind=head.reach)
        for s in (-step, step)
    ]  # fmt: skip
    slope = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0], axis=1, keepdims=True)
    assert np.abs(slope - tangents).max() < 1e-5


CHANGES = {
    "about origin": {"drive.pitch_about": "origin"},
    "about magnet": {"drive.pitch_about": "magnet", "drive.velocity": (1e-4, -2e-4, 5e-5)},
    "sampled": {
        "drive.path": {
            "time": [0.0, 2.0, 5.0, 6.0],
            "position": [[0.0, 0.0, 0.15], [0.001, 0.002, 0.151], [0.002, 0.001, 0.15], [0.0, 0.0, 0.149]],
            "yaw": [0.0, 0.3, 0.2, 0.5],
            "pitch": [0.1, 0.2, 0.15, 0.1],
            "phase": [0.0, 0.4, 0.2, 0.1],
        },
        "drive.yaw_rate": 0.0,
        "drive.velocity": (0.0, 0.0, 0.0),
    },
}


@pytest.mark.parametrize("kind", CHANGES)
def test_the_magnet_is_where_the_kernels_have_it(kind):
    scenario = load("nose-first/fig3c").replaced({"run.duration": 6.0, "run.interval": 0.05, **CHANGES[kind]})
    run = simulate(scenario).dataset
    poses = magnet_motion(scenario.drive)(run.time.values)
    spin = np.column_stack([0.0 * poses.spin, np.cos(poses.spin), np.sin(poses.spin)])
    moment = np.einsum("nij,nj->ni", poses.rotation, spin)
    assert np.abs(poses.position - run.rpm_position.values).max() < EXACT
    assert np.abs(moment * scenario.magnet[0].moment - run.rpm_moment.values).max() < 1e-12
    assert magnet_start(scenario.drive) == pytest.approx(poses.position[0], abs=EXACT)
    assert np.abs(run.rpm_position.values[0] - poses.position[0]).max() < EXACT
    assert np.linalg.norm(poses.axis, axis=1) == pytest.approx(np.ones(len(poses.axis)))


def test_pitch_lifts_the_magnet_and_swings_it_about_the_origin():
    """A positive pitch lifts the x axis, so the magnet above the origin swings towards -x (eq. 1)."""
    scenario = load("nose-first/fig3c").replaced({"drive.start": (0.02, 0.01, 0.0), "drive.pitch": 0.3})
    above = np.array([0.02, 0.01, scenario.drive.distance])
    swung = Rotation.from_euler("y", -0.3).apply(above)
    assert magnet_start(scenario.drive) == pytest.approx(swung, abs=EXACT)
    assert swung[0] < 0.02
    about_magnet = scenario.replaced({"drive.pitch_about": "magnet"}).drive
    assert np.array_equal(magnet_start(about_magnet), above)
    assert magnet_motion(about_magnet)(np.zeros(1)).axis[0, 2] == pytest.approx(math.sin(0.3))


def test_a_turned_run_is_turned_back():
    """Comparing a run with itself turned about z finds the turn."""
    scenario = load("nose-first/fig3c").replaced({"run.duration": 6.0, "run.interval": 0.05})
    run = simulate(scenario)
    turned = run.dataset.copy(deep=True)
    turned["position"].values[:] = run.dataset["position"].values @ turn(2, 0.3).T
    found = compare(type(run)(turned), run)
    assert found.yaw == pytest.approx(0.3, abs=1e-9)
    assert np.abs(found.difference).max() < 1e-12
