"""Symmetries of the equations that every run must share: rotation about z, translation, mirrors, changes of scale.

A drive always starts with the RPM at azimuth and spin angle zero, so a rotated or shifted scenario is reached through
time: in the frame that yaws with the drive the equations repeat with every turn of the magnet.
"""

import numpy as np
import pytest

import oracles

TURN = 1 / 3.3


def moved(state, rotation, shift=(0.0, 0.0, 0.0)):
    """A state rotated about the lab's origin, then shifted."""
    return np.concatenate(
        [rotation @ state[:3] + shift, oracles.quaternion_of(rotation @ oracles.matrix_of(state[3:]))]
    )


def same(a, b, position=2e-9, attitude=1e-6):
    assert np.abs(a[:3] - b[:3]).max() < position
    assert oracles.attitude_difference(a[3:], b[3:]) < attitude


@pytest.mark.parametrize("about", ["origin", "magnet"])
@pytest.mark.parametrize("turns", [5, 33])
def test_rotation_about_z(about, turns):
    """Seen from the yawed arm, a run that goes on is a run that starts in the state rotated back."""
    c = oracles.case(about=about, yaw=np.radians(11.0))
    back = oracles.turn("z", -c["yaw"] * turns * TURN)
    first = oracles.run(c, turns * TURN, tolerance=1e-9).final_state
    both = oracles.run(c, (turns + 7) * TURN, tolerance=1e-9).final_state
    again = oracles.run(c, 7 * TURN, tolerance=1e-9, initial_state=moved(first, back)).final_state
    same(again, moved(both, back))


@pytest.mark.parametrize("about", ["origin", "magnet"])
def test_time_and_place_with_a_moving_magnet(about):
    """Without yaw, going on is starting again from the state shifted by what the magnet has moved."""
    c = oracles.case(about=about, yaw=0.0, velocity=(8e-4, -4e-4, 1e-4))
    shift = -np.array(c["velocity"]) * 9 * TURN
    first = oracles.run(c, 9 * TURN, tolerance=1e-9).final_state
    both = oracles.run(c, 14 * TURN, tolerance=1e-9).final_state
    again = oracles.run(c, 5 * TURN, tolerance=1e-9, initial_state=moved(first, np.eye(3), shift)).final_state
    same(again, moved(both, np.eye(3), shift))


def test_place_does_not_matter_where_pitch_is_about_the_magnet():
    shift = np.array([0.3, -0.2, 0.1])
    here = oracles.case(about="magnet", yaw=0.0)
    there = oracles.case(about="magnet", yaw=0.0, start=tuple(np.array(here["start"]) + shift))
    same(oracles.run(there, 5.0).final_state, moved(oracles.run(here, 5.0).final_state, np.eye(3), shift))


def test_rotation_of_start_and_velocity_by_half_a_turn():
    """Half a turn about z is a pitch and a spin of the other sign, for a device that is round about its long axis."""
    matrix = np.diag([0.10, 0.13, 0.13, 8e-9, 6e-6, 6e-6])
    matrix[0, 3] = matrix[3, 0] = 3e-6
    c = oracles.case(matrix=matrix, velocity=(8e-4, -4e-4, 1e-4), start=(0.01, -0.04, 0.0))
    half = oracles.turn("z", np.pi)
    other = c | {
        "beta": -c["beta"],
        "frequency": -c["frequency"],
        "velocity": tuple(half @ c["velocity"]),
        "start": tuple(half @ c["start"]),
    }
    # the other magnet is then reversed throughout; so is the moment of a device rolled by half a turn
    roll = oracles.turn("x", np.pi)
    state = np.concatenate([half @ c["start"], oracles.quaternion_of(half @ roll)])
    end = oracles.run(other, 5.0, initial_state=state).final_state
    expected = oracles.run(c, 5.0).final_state
    same(
        end, np.concatenate([half @ expected[:3], oracles.quaternion_of(half @ oracles.matrix_of(expected[3:]) @ roll)])
    )


def mirrored(state, lab):
    """Mirror in the lab by ``lab`` (diagonal), and in the body's x-y plane, which leaves a proper rotation."""
    rotation = np.diag(lab) @ oracles.matrix_of(state[3:]) @ np.diag([1.0, 1.0, -1.0])
    return np.concatenate([lab * state[:3], oracles.quaternion_of(rotation)])


def test_mirror_fore_and_aft():
    """x mirrored: pitch, yaw and handedness change sign; the spin does not, as both moments are reversed."""
    lab = np.array([-1.0, 1.0, 1.0])
    c = oracles.case(start=(0.01, -0.045, 0.0), velocity=(8e-4, -4e-4, 1e-4))
    other = c | {
        "beta": -c["beta"],
        "yaw": -c["yaw"],
        "left": False,
        "start": (-0.01, -0.045, 0.0),
        "velocity": (-8e-4, -4e-4, 1e-4),
    }
    end = oracles.run(other, 10.0, initial_state=mirrored(oracles.start_of(c), lab)).final_state
    same(end, mirrored(oracles.run(c, 10.0).final_state, lab))


def test_mirror_left_and_right():
    """y mirrored: yaw, handedness and the sense of rotation change sign; the mirrored spin begins half a turn later."""
    lab = np.array([1.0, -1.0, 1.0])
    c = oracles.case()
    other = c | {"yaw": -c["yaw"], "frequency": -c["frequency"], "left": False, "start": (0.0, 0.045, 0.0)}
    back = oracles.turn("z", -c["yaw"] * 0.5 * TURN)
    half = moved(oracles.run(c, 0.5 * TURN, tolerance=1e-9).final_state, back)
    later = moved(oracles.run(c, 20.5 * TURN, tolerance=1e-9).final_state, back)
    end = oracles.run(other, 20 * TURN, tolerance=1e-9, initial_state=mirrored(half, lab)).final_state
    same(end, mirrored(later, lab))


@pytest.mark.parametrize(
    ("length", "time", "viscosity", "share"), [(2, 0.5, 4, 2), (0.3, 1.7, 0.2, 0.9), (1, 10, 1, 1), (1, 1, 7, 0.1)]
)
def test_scaling(length, time, viscosity, share):
    """Lengths, times and forces in other units: the dimensionless run is the same.

    Drag gives force as viscosity length^2 / time, the magnet m M / length^4: m M goes with viscosity length^6 / time.
    """
    c = oracles.case(velocity=(8e-4, -4e-4, 1e-4))
    both = viscosity * length**6 / time
    other = c | {
        name: c[name] * length for name in ("length", "diameter", "pitch", "wire", "head", "gravity_center", "distance")
    }
    other |= {
        "viscosity": c["viscosity"] * viscosity,
        "weight": c["weight"] * viscosity * length**2 / time,
        "moment": c["moment"] * both**share,
        "magnets": [((0.0, 0.0, 0.0), 18.89 * both ** (1 - share))],
        "frequency": c["frequency"] / time,
        "yaw": c["yaw"] / time,
        "velocity": tuple(v * length / time for v in c["velocity"]),
        "start": tuple(x * length for x in c["start"]),
    }
    one, two = oracles.run(c, 10.0), oracles.run(other, 10.0 * time)
    expected = oracles.states_of(one) * [length, length, length, 1, 1, 1, 1]
    np.testing.assert_allclose(oracles.states_of(two), expected, atol=1e-10 * max(1, length))
    np.testing.assert_allclose(two.dataset.phase_lag.values[5:], one.dataset.phase_lag.values[5:], atol=1e-8)
    assert two.gain == pytest.approx(one.gain, rel=1e-9)
    assert two.dataset.attrs["steps"] == one.dataset.attrs["steps"]
