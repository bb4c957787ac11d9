"""States and resistance against an independent code's data and against SciPy's DOP853 on another right-hand side."""

import json
from pathlib import Path

import numpy as np
import pytest

import helimag as hm
import oracles

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference_states.json").read_text())
DIGITS = {1.0: 1e-9, 10.0: 1e-8, 100.0: 1e-7}  # m, at default accuracy


def reference_case(entry):
    """The entry of the file as a case; the start is that of the circular runs."""
    return oracles.case(
        length=entry["helix_length"],
        diameter=entry["helix_diameter"],
        pitch=entry["helix_pitch"],
        wire=entry["wire_radius"],
        head=entry["head_radius"],
        viscosity=entry["viscosity"],
        rft=entry["rft"],
        moment=entry["m_h"],
        magnets=[((0.0, 0.0, 0.0), entry["M_a"])],
        weight=entry["net_weight"],
        gravity_center=entry["gravity_center"],
        frequency=entry["f_a"],
        beta=np.radians(entry["beta_deg"]),
        yaw=np.radians(entry["yaw_deg_s"]),
        distance=entry["distance"],
    )


@pytest.mark.parametrize("entry", REFERENCE, ids=lambda entry: entry["name"])
def test_resistance_matches_reference_data(entry):
    scenario = oracles.scenario_of(reference_case(entry))
    ours, theirs = hm.resistance(scenario.device, scenario.fluid), np.array(entry["resistance"])
    # "of the matrix's scale": each entry against the geometric mean of its row's and column's diagonal entries
    scale = np.sqrt(np.outer(np.diag(theirs), np.diag(theirs)))
    assert np.abs((ours - theirs) / scale).max() < 1e-6  # measured 1.3e-7: ours is the finer quadrature
    assert np.abs((ours - oracles.resistance(reference_case(entry))) / scale).max() < 1e-12


@pytest.mark.parametrize("entry", REFERENCE, ids=lambda entry: entry["name"])
@pytest.mark.parametrize("interval", [None, 0.013, 100.0])
def test_positions_match_reference_data(entry, interval):
    for t, expected in zip(entry["t"], entry["states"], strict=True):
        state = oracles.run(reference_case(entry), t, interval=interval).final_state
        assert np.abs(state[:3] - expected[:3]).max() < DIGITS[t]
        assert oracles.attitude_difference(state[3:], expected[3:]) < 1e-6


CASES = {
    "1 Hz": {"frequency": 1.0},
    "5 Hz": {"frequency": 5.0},
    "backwards": {"frequency": -3.3},
    "thin fluid": {"viscosity": 0.3},
    "close": {"distance": 0.100},
    "magnet above, moving": {
        "about": "magnet",
        "velocity": (8e-4, -3e-4, 1e-4),
        "yaw": 0.0,
        "distance": 0.102,
        "start": (0.0, 0.0, 0.0),
    },
    "magnet above, moving and yawing": {"about": "magnet", "velocity": (8e-4, -3e-4, 1e-4), "yaw": -0.05},
    "right-handed": {"left": False},
    "gray-hancock": {"rft": "gray-hancock"},
    "no yaw": {"yaw": 0.0},
    "negative pitch": {"beta": np.radians(-7.0)},
    "from densities": {"densities": (4500.0, 7500.0)},
    "two magnets": {"magnets": [((0.01, -0.05, 0.02), 18.89), ((-0.03, 0.04, 0.01), 9.0)]},
    "elsewhere": {"start": (0.02, 0.03, -0.01), "beta": np.radians(20.0)},
    "other device": {"length": 0.009, "diameter": 0.0013, "pitch": 0.0031, "wire": 0.00011, "head": 0.0007},
}


@pytest.mark.parametrize("name", CASES)
def test_states_match_scipy(name):
    c = oracles.case(**CASES[name])
    times = [1.0, 4.0]
    solution = oracles.solve(c, times)
    for t, expected in zip(times, solution.y.T, strict=True):
        state = oracles.run(c, t).final_state
        assert np.abs(state[:3] - expected[:3]).max() < (1e-9 if t == 1.0 else 1e-8)
        # the big head makes steps long: it is off by up to 1e-5 at whatever interval
        assert oracles.attitude_difference(state[3:], expected[3:]) < (1e-5 if name == "other device" else 1e-6)


def test_start_from_a_given_state_matches_scipy():
    """Not level, far off the axis, and the quaternion neither of unit length nor with a positive scalar."""
    state = np.array([0.02, -0.06, 0.01, -0.4, 0.5, -0.3, 0.9])
    expected = oracles.solve(oracles.case(), [3.0], state).y[:, 0]
    ours = oracles.run(oracles.case(), 3.0, initial_state=state).final_state
    assert np.abs(ours[:3] - expected[:3]).max() < 1e-8
    assert oracles.attitude_difference(ours[3:], expected[3:]) < 1e-6
    assert np.isclose(np.linalg.norm(ours[3:]), 1.0, rtol=1e-14)


def test_what_is_recorded_beside_the_state():
    """RPM, field, lag, long axis, attack angle, gap: all against the oracle's formulas, at every sample."""
    c = oracles.case(magnets=[((0.01, -0.05, 0.02), 18.89), ((-0.03, 0.04, 0.01), 9.0)])
    data = oracles.run(c, 2.0, interval=0.05).dataset
    for i, t in enumerate(data.time.values):
        position, rotation = data.position.values[i], oracles.matrix_of(data.quaternion.values[i])
        places, axis = oracles.rpm(c, t)
        field = sum(
            oracles.field_and_force(position - place, moment * axis, axis)[0]
            for place, (_, moment) in zip(places, c["magnets"], strict=True)
        )
        centre = oracles.rpm(c | {"magnets": [((0.0, 0.0, 0.0), 1.0)]}, t)[0][0]
        np.testing.assert_allclose(data.rpm_position.values[i], centre, atol=1e-15)
        np.testing.assert_allclose(data.rpm_moment.values[i], 27.89 * axis, atol=1e-12)
        np.testing.assert_allclose(data.field.values[i], field, rtol=1e-11, atol=1e-17)
        np.testing.assert_allclose(data.long_axis.values[i], rotation[:, 0], atol=1e-14)
        body_field = rotation.T @ field
        lag = np.arctan2(body_field[2], body_field[1])
        assert np.isclose(np.exp(1j * data.phase_lag.values[i]), np.exp(1j * lag), atol=1e-11)
        assert np.isclose(np.sin(data.attack_angle.values[i]), rotation[2, 0], atol=1e-14)
        assert np.isclose(data.gap.values[i], np.linalg.norm(position - centre), rtol=1e-14)
