"""A scenario explained: every number against a closed form, magpylib, or a run."""

import json

import magpylib
import numpy as np
import pytest
from scipy.special import ellipe

import helimag as hm
import oracles
from helimag.diagnosis import as_json, as_text, diagnose
from helimag.diagnosis.scenario import balance_distance, carrying_velocity
from helimag.diagnosis.turn import over_a_turn
from helimag.geometry import magnet_start

MOMENT, DEVICE, WEIGHT = 18.89, 6.23e-4, 28.28e-6
MEAN = 2 / np.pi * ellipe(-3)  # of sqrt(1 + 3 sin^2) over a turn: 1.542


def below(**changes):
    """A device straight below a magnet whose axis is level, of simple drag."""
    matrix = np.diag([0.03, 0.04, 0.05, 2e-8, 1e-6, 1e-6])
    matrix[0, 3] = matrix[3, 0] = 3e-6
    given = {"matrix": matrix, "beta": 0.0, "start": (0.0, 0.0, 0.0), "yaw": 0.0, "velocity": (5e-4, 0.0, 0.0)}
    return oracles.scenario_of(oracles.case(**(given | changes)))


def test_pull_below_a_turning_dipole_is_the_closed_form():
    """In step the force is 3 mu0 m M / (4 pi d^4) times sqrt(1 + 3 sin^2): m along B, B = k M (0, -cos, 2 sin)."""
    found = diagnose(below())
    pull = 3e-7 * MOMENT * DEVICE / 0.15**4 * MEAN
    np.testing.assert_allclose(found.pull, [0.0, 0.0, pull], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(found.net_force, [0.0, 0.0, pull - WEIGHT], rtol=1e-12, atol=1e-18)
    assert found.field == pytest.approx((1e-7 * MOMENT / 0.15**3, 2e-7 * MOMENT / 0.15**3), rel=1e-12)


def test_balance_is_where_the_closed_form_carries_the_weight():
    expected = (3e-7 * MOMENT * DEVICE * MEAN / WEIGHT) ** 0.25
    assert diagnose(below()).balance_distance == pytest.approx(expected, abs=2e-9)
    # the start does not matter, only what is straight below the magnet
    assert diagnose(below(start=(0.0, -0.045, 0.01))).balance_distance == pytest.approx(expected, abs=2e-9)


@pytest.mark.parametrize("weight", [0.0, -1e-6, 1.0])
def test_balance_is_nowhere_for_what_floats_and_for_what_is_too_heavy(weight):
    assert balance_distance(below(), weight) is None


def below_magnets(*magnets, distance):
    changes = {"magnet": list(magnets), "drive.distance": distance, "drive.pitch": 0.0, "drive.start": (0, 0, 0)}
    return hm.load("nose-first/fig3c").replaced(changes | {"provenance": {}})


def test_balance_below_a_long_magnet_is_found_though_it_pulls_less_nearer_by():
    """Close to its middle it pulls less than a little way off; by magpylib 19.9 uN at 102 mm, 29.3 at 110, 24.9 at 120.

    There the net force of a turn changes sign twice, and the device is lost below the second place.
    """
    long = {"moment": 10.0, "radius": 0.003, "height": 0.2, "field": "cylinder"}
    scenario = below_magnets(long, distance=0.12).replaced({"drive.pitch": "12.7 deg"})
    found = balance_distance(scenario, 28.28e-6)
    assert 0.110 < found < 0.120
    pull = [over_a_turn(scenario, np.array([[0.0, 0.0, -found * at]]))[1][0, :, 2].mean() for at in (0.999, 1.0, 1.001)]
    assert pull[0] > pull[1] > pull[2]
    assert pull[1] == pytest.approx(28.28e-6, rel=1e-6)


def test_balance_between_two_magnets_is_the_one_nearest_to_the_start():
    """One straight above and one straight below: a device above the lower one is not told of balance below that."""
    one = {"moment": 18.89, "radius": 0.0175, "height": 0.02}
    alone = balance_distance(below_magnets(one, distance=0.15), 28.28e-6)
    both = below_magnets(one, one | {"offset": (0.0, 0.0, -0.29)}, distance=0.15)
    found = balance_distance(both, 28.28e-6)
    assert 0.08 < found < alone
    assert balance_distance(both.replaced({"drive.distance": 0.38}), 28.28e-6) > 0.3


def test_a_device_out_of_step_is_not_said_to_swim():
    limit = diagnose(below()).step_out_frequency
    words = [as_text(diagnose(below().replaced({"drive.frequency": f}))) for f in (0.9 * limit, 1.1 * limit)]
    assert ["were it in step" in text for text in words] == [False, True]


def test_step_out_below_a_cylinder_is_that_of_its_own_field():
    long = {"moment": 10.0, "radius": 0.003, "height": 0.2, "field": "cylinder"}
    found = diagnose(below_magnets(long, distance=0.12))
    assert found.step_out_frequency == pytest.approx(found.roll_rates[0] / (2 * np.pi), rel=1e-6)


def test_step_out_sinking_swimming_and_rolling_are_their_closed_forms():
    found = diagnose(below())
    rolling = 2e-8 - 3e-6**2 / 0.03  # free to swim as it turns
    field = 1e-7 * MOMENT / 0.15**3
    assert found.step_out_frequency == pytest.approx(DEVICE * field / rolling / (2 * np.pi), rel=1e-12)
    assert found.margin == pytest.approx(found.step_out_frequency / 3.3, rel=1e-12)
    assert found.roll_rates == pytest.approx((DEVICE * field / rolling, 2 * DEVICE * field / rolling), rel=1e-12)
    assert found.advance == pytest.approx(-2 * np.pi * 3e-6 / 0.03, rel=1e-12)
    assert found.swimming_speed == pytest.approx(2 * np.pi * 3e-6 / 0.03 * 3.3, rel=1e-12)
    free = np.linalg.inv(np.diag([0.03, 0.04, 0.05]))
    assert found.sinking == pytest.approx((WEIGHT * (free[1, 1] + free[2, 2]) / 2, WEIGHT / 0.03), rel=1e-12)


def test_swimming_speed_is_that_of_a_run():
    """A weightless device straight below a far, strong magnet swims along its axis as the mobility says."""
    scenario = hm.load("nose-first/fig3c").replaced(
        {
            "device.weight": {"net_weight": "0 N", "gravity_center": "0 m"},
            "magnet.moment": "18.89e4 A m^2",
            "device.magnetic_moment": "6.23e-4 A m^2",
            "drive": {
                "frequency": "3.3 Hz",
                "pitch": "0 deg",
                "distance": "3 m",
                "pitch_about": "magnet",
                "start": ["0 m", "0 m", "0 m"],
            },
        }
    )
    found = diagnose(scenario)
    run = hm.simulate(scenario, duration=20 / 3.3, interval=1 / 3.3)
    x = run.dataset.position.values[:, 0]
    assert (x[-1] - x[5]) / 15 == pytest.approx(abs(found.advance), rel=0.01)
    assert found.at_start.swims == "head"


def test_roll_relaxes_as_the_orbits_fastest_floquet_rate():
    """It lies between the rates in the weakest and the strongest field: 44 per s of 41 to 83."""
    scenario = hm.load("nose-first/fig3c").replaced({"drive.frequency": "2.5 Hz"})
    orbit = hm.find_orbit(scenario)
    fastest = max(abs(rate.real) for rate in orbit.rates)
    low, high = diagnose(scenario).roll_rates
    assert low < fastest < high


def test_pull_of_a_cylinder_is_magpylibs():
    scenario = below(distance=0.06).replaced({"magnet.field": "cylinder"})
    fields, forces = over_a_turn(scenario, np.array([[0.0, 0.0, -0.06]]))
    count = fields.shape[1]
    polarization = 4e-7 * np.pi * MOMENT / (np.pi * 0.0175**2 * 0.020)
    source = magpylib.magnet.Cylinder(polarization=(0, 0, polarization), dimension=(0.035, 0.020))
    for j in range(0, count, 7):
        spin = 2 * np.pi * j / count
        frame = np.array([[1, 0, 0], [0, np.sin(spin), np.cos(spin)], [0, -np.cos(spin), np.sin(spin)]])
        here = frame.T @ np.array([0.0, 0.0, -0.06])
        field = frame @ source.getB(here)
        np.testing.assert_allclose(fields[0, j], field, rtol=1e-4, atol=1e-7)
        moment = frame.T @ (DEVICE * field / np.linalg.norm(field))
        step = 2e-4
        gradient = [
            (source.getB(here + step * unit) - source.getB(here - step * unit)) @ moment / (2 * step)
            for unit in np.eye(3)
        ]
        np.testing.assert_allclose(forces[0, j], frame @ gradient, rtol=1e-3, atol=1e-3 * np.abs(gradient).max())


def test_settled_axis_below_a_tilted_magnet_points_half_as_steep():
    found = diagnose(below(beta=np.radians(13.0), about="magnet"))
    elevation = np.arcsin(found.settled.nose[2])
    assert elevation == pytest.approx(-np.arctan(np.tan(np.radians(13.0)) / 2), abs=1e-12)
    assert found.settled.nose[0] > 0.9
    assert found.at_start.nose.tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("changes", "leads", "swims"),
    [
        # below the magnet the field turns the other way round; this coupling swims backwards in a right-handed roll
        ({}, "head", "head"),
        ({"velocity": (-5e-4, 0.0, 0.0)}, "helix", "head"),
        ({"frequency": -3.3}, "head", "helix"),
        ({"velocity": (0.0, 0.0, 0.0)}, None, "head"),
        ({"velocity": (0.0, 0.0, 0.0), "yaw": 0.03, "start": (0.0, -0.045, 0.0)}, "head", "head"),
        ({"velocity": (0.0, 0.0, 0.0), "yaw": -0.03, "start": (0.0, -0.045, 0.0)}, "helix", "head"),
    ],
)
def test_which_end_leads(changes, leads, swims):
    found = diagnose(below(**changes))
    for travel in (found.at_start, found.settled):
        assert (travel.leads, travel.swims) == (leads, swims)
        np.testing.assert_allclose(travel.thrust, travel.nose if swims == "head" else -travel.nose)


def test_helix_first_thrust_rises_with_pitch_where_head_first_sinks():
    """Below the magnet the nose points down by half the pitch: a helix-first device is driven up by more pitch."""
    nose = diagnose(below(beta=0.2, about="magnet")).settled
    tail = diagnose(below(beta=0.2, about="magnet", frequency=-3.3)).settled
    assert nose.thrust[2] < -0.05
    assert tail.thrust[2] > 0.05


def test_a_path_carries_the_device_with_its_own_speed_and_yaw():
    scenario = below(velocity=(0.0, 0.0, 0.0))
    path = {
        "position": [["0 mm", "0 mm", "150 mm"], ["10 mm", "0 mm", "150 mm"], ["20 mm", "0 mm", "150 mm"]],
        "time": ["0 s", "10 s", "20 s"],
        "yaw": ["0 deg", "10 deg", "20 deg"],
    }
    moved = scenario.replaced(
        {"drive.path": path, "drive.start": ["0 mm", "-5 mm", "0 mm"], "run": {"duration": "20 s"}}
    )
    expected = [1e-3 + np.radians(1.0) * 0.005, 0.0, 0.0]
    np.testing.assert_allclose(carrying_velocity(moved), expected, atol=1e-12)


def test_sources_are_those_of_the_file():
    found = diagnose(hm.load("nose-first/fig3c"))
    assert found.sources["fitted"] == [
        "device.helix.wire_radius",
        "device.head.radius",
        "device.weight.net_weight",
        "device.weight.gravity_center",
    ]
    assert sum(map(len, found.sources.values())) == len(found.scenario.provenance)


def test_the_command_prints_what_was_found(helimag):
    scenario = hm.load("nose-first/fig3c")
    status, out, err = helimag("doctor", "nose-first/fig3c", "--json")
    assert (status, err) == (0, "")
    report = json.loads(out)
    assert report == json.loads(json.dumps(as_json(diagnose(scenario))))
    assert {check["name"] for check in report["checks"] if not check["holds"]} == {
        "slenderness",
        "pitch_angle",
        "enclosing_body",
        "boundary_drag",
    }
    assert helimag("doctor", "nose-first/fig3c").out == as_text(diagnose(scenario)) + "\n"
    status, _, err = helimag("doctor", "--set", "drive.pitch=1 deg")
    assert status == 2
    assert "--set needs a scenario" in err


def test_no_words_have_a_minus_before_nothing():
    """A device that starts 0.02 mm above its balance: the height of the balance is -0.02 mm, and zero in words."""
    beside = diagnose(below()).balance_distance - 2e-5
    found = diagnose(below().replaced({"drive.distance": beside}))
    assert magnet_start(found.scenario.drive)[2] - found.balance_distance == pytest.approx(-2e-5, abs=1e-8)
    assert "at a height of 0.0 mm" in as_text(found)


def test_words_give_the_numbers_in_shown_units():
    found = diagnose(below())
    text = as_text(found)
    assert f"{1e3 * found.balance_distance:.1f} mm straight below" in text
    assert f"at a height of {150 - 1e3 * found.balance_distance:.1f} mm" in text
    assert f"{1e6 * found.pull[2]:.2f}) uN" in text
    failed = [line.strip() for line in text.splitlines() if "DOES NOT HOLD" in line]
    assert [line.removeprefix("DOES NOT HOLD ").partition(":")[0] for line in failed] == [
        "enclosing_body",  # drag about the head only: no body of this shape turns so easily about its middle
        "step_out",
    ]
