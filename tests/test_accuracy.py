"""How far to trust the places of a run: what is printed bounds what is true."""

import json

import numpy as np
import pytest

import helimag as hm
from command_line import run as helimag
from helimag.engine import DOP853, accuracy_of, advance, refined


def random_runs(count):
    rng = np.random.default_rng(14)
    for _ in range(count):
        changes = {
            "drive.frequency": f"{rng.uniform(2.0, 4.0)} Hz",
            "drive.pitch": f"{rng.uniform(5.0, 15.0)} deg",
            "drive.distance": f"{rng.uniform(130.0, 170.0)} mm",
            "run.duration": "60 s",
        }
        yield hm.load("paper/fig3c").replaced(changes)


def test_the_error_that_is_told_bounds_the_true_one():
    """Beside direct steps ten thousand times finer, and mostly within fourfold: a bound that says something."""
    runs = list(random_runs(20))
    told = [accuracy_of(history) for history in advance(runs)]
    exact = advance(runs, tolerance=1e-12, method=DOP853)
    true = []
    for history, fine, found in zip(advance(runs), exact, told, strict=True):
        inside = slice(None) if found.first_slip is None else history.time < found.first_slip
        true.append(np.linalg.norm(history.states[inside, :3] - fine.states[inside, :3], axis=1).max())
    ratios = np.array([found.in_step for found in told]) / np.array(true)
    assert (ratios >= 1.0).sum() >= 19
    assert np.median(ratios) < 4.0


def test_a_run_that_loses_step_is_known_to_be_sensitive():
    """Nose first, Fig. 3(C) loses step at 129-143 s, which multiplies errors."""
    (history,) = advance([hm.load("nose-first/fig3c").replaced({"run.duration": "300 s"})])
    found = accuracy_of(history)
    assert 120.0 < found.first_slip < 150.0
    assert found.sensitive
    assert found.after_slip > 1e3 * found.in_step
    assert "trust the outcome, not places" in found.text


def test_a_run_that_loses_step_is_made_again_with_finer_steps():
    """Steps of the default tolerance are wrong by 0.08 mm after the device has lost step; finer ones tell it all."""
    changes = {"drive.frequency": 2.7637, "drive.pitch": 0.1646, "drive.distance": 0.1468, "drive.yaw_rate": 0.0401}
    scenario = hm.load("nose-first/fig3c").replaced(changes | {"run.duration": 200.0, "run.interval": 1.0})
    (ours,), (exact,) = advance([scenario]), advance([scenario], tolerance=1e-11, method=DOP853)
    (finer,) = refined([ours])
    told, first = accuracy_of(finer, tolerance=1e-10, rough=ours), accuracy_of(ours)
    away, before = (np.linalg.norm(run.states[:, :3] - exact.states[:, :3], axis=1).max() for run in (finer, ours))
    assert before > 1e-5 > first.in_step
    assert away <= max(told.in_step, told.after_slip) <= 5e-7
    assert (told.sensitive, first.sensitive) == (True, True)
    assert (told.refined, first.refined) == (True, False)
    assert told.text.endswith("trust the outcome, not places or slips (steps at a tolerance of 1e-10)")


def test_a_run_that_is_drawn_in_is_made_again_with_finer_steps():
    """Fig. 3(A) is drawn into the magnet after 1280 s, by errors of ten micrometres 0.2 ms sooner or later."""
    (ours,), (exact,) = (
        advance([hm.load("paper/fig3a")]),
        advance([hm.load("paper/fig3a")], tolerance=1e-11, method=DOP853),
    )
    (finer,) = refined([ours])
    assert not ours.slips.any()
    assert abs(ours.time[-1] - exact.time[-1]) > 1e-4
    assert finer.time[-1] == pytest.approx(exact.time[-1], abs=1e-5)
    assert finer.judge().gain == pytest.approx(exact.judge().gain, abs=3e-6)


SLIPPING = hm.load("paper/fig3c").replaced(
    {"drive.frequency": "5 Hz", "drive.distance": "170 mm", "run.duration": "20 s"}
)
IN_STEP = hm.load("paper/fig3c").replaced({"run.duration": "20 s"})


def test_an_outcome_that_depends_on_the_steps_is_told():
    """Such devices slip on an edge, from where rounding decides; here a run that is drawn in stands for one of them."""
    slips, near = advance([SLIPPING, IN_STEP.replaced({"drive.distance": "60 mm"})])
    told = accuracy_of(slips, tolerance=1e-10, rough=near)
    assert told.other_verdict == str(near.judge().verdict) == "attracted"
    assert "; the outcome depends on the steps as well: with others the verdict is 'attracted'" in told.text
    assert accuracy_of(slips, tolerance=1e-10, rough=slips).other_verdict is None


def test_other_runs_stay_as_they_are():
    slips, keeps = advance([SLIPPING, IN_STEP])
    finer, kept = refined([slips, keeps])
    assert (finer is slips, kept is keeps) == (False, True)
    (fine,) = advance([SLIPPING], tolerance=1e-10)
    assert refined([fine], tolerance=1e-10)[0] is fine  # asked for, and not made twice


@pytest.mark.parametrize(
    ("tolerance", "refine", "taken"), [(1e-5, None, 1e-5), (1e-5, True, 1e-10), (1e-7, None, 1e-10)]
)
def test_looser_steps_than_the_default_are_taken_as_asked_for(tolerance, refine, taken):
    asked = hm.simulate(SLIPPING, tolerance=tolerance, refine=refine)
    assert asked.attributes["tolerance"] == taken
    assert asked.gain == advance([SLIPPING], tolerance=taken)[0].judge().gain
    assert hm.simulate_many([SLIPPING], tolerance=tolerance, refine=refine)[0].gain == asked.gain


def test_single_runs_are_refined_and_a_batch_alike():
    """What is given by default is the run at the finer tolerance, to the bit, and its file says which that was."""
    asked, fine = (hm.simulate(SLIPPING, tolerance=given, refine=False) for given in (3e-7, 1e-10))
    ours, among = hm.simulate(SLIPPING), hm.simulate_many([IN_STEP, SLIPPING])[1]
    assert ours.gain == among.gain == fine.gain != asked.gain
    np.testing.assert_array_equal(ours.final_state, fine.final_state)
    assert [run.attributes["tolerance"] for run in (ours, among, fine, asked)] == [1e-10, 1e-10, 1e-10, 3e-7]
    assert hm.simulate_many([SLIPPING], refine=False)[0].gain == asked.gain == advance([SLIPPING])[0].judge().gain
    assert hm.simulate(IN_STEP).attributes["tolerance"] == 3e-7
    assert hm.simulate(SLIPPING, accuracy=True).gain == ours.gain


def test_a_refined_run_begins_where_it_began_to_the_bit():
    """Also where the quaternion's length, once normalised, is one but for rounding."""
    state = np.array([*SLIPPING.drive.start, 1.0, 1.0, 1.0, 2.0])
    fine, again = (hm.simulate(SLIPPING, initial_state=state, **steps) for steps in ({"tolerance": 1e-10}, {}))
    assert again.attributes["tolerance"] == 1e-10
    np.testing.assert_array_equal(again.final_state, fine.final_state)


@pytest.mark.parametrize("accuracy", [False, True])
def test_progress_rises_to_the_end_of_the_last_run(accuracy):
    seen, own = [], []
    hm.simulate(SLIPPING, accuracy=accuracy, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-2:] == pytest.approx([1.0, 1.0])
    assert any(0.4 < done < 1.0 for done in seen) is accuracy
    hm.simulate(IN_STEP, progress=own.append)
    assert own[-1] == 1.0


def test_it_goes_with_the_run(tmp_path):
    scenario = hm.load("paper/fig3c")
    assert "accuracy" not in hm.simulate(scenario, duration=30.0).attributes
    run = hm.simulate(scenario, duration=30.0, accuracy=True)
    run.save(tmp_path / "run.nc")
    told = json.loads(hm.Trajectory.load(tmp_path / "run.nc").attributes["accuracy"])
    assert told["first_slip"] is None
    assert told["text"] == f"places within {told['in_step']:.1g} m, by the same run with finer steps"


@pytest.mark.parametrize(("option", "there"), [((), True), (("--no-accuracy",), False)])
def test_the_command_says_it(option, there):
    said = helimag("simulate", "paper/fig3c", "--duration=30 s", "--no-orbit", *option)
    assert ("  accuracy      places within " in said.out) is there
    report = json.loads(helimag("simulate", "paper/fig3c", "--duration=30 s", "--no-orbit", "--json", *option).out)
    assert (report["accuracy"] is not None) is there


@pytest.mark.parametrize(("option", "refine", "tolerance"), [((), True, 1e-10), (("--no-refine",), False, 3e-7)])
def test_the_command_gives_the_run_that_python_gives(option, refine, tolerance):
    changes = [f"--set={path}={value}" for path, value in (("drive.frequency", "5 Hz"), ("drive.distance", "170 mm"))]
    said = helimag("simulate", "paper/fig3c", *changes, "--duration=20 s", "--no-orbit", "--json", *option)
    report = json.loads(said.out)
    assert report["gain"] == hm.simulate(SLIPPING, refine=refine).gain
    assert report["tolerance"] == tolerance
    assert report["accuracy"]["refined"] is refine
