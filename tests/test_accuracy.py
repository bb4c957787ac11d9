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


def test_where_places_depend_on_the_steps_finer_ones_are_taken():
    """Steps of the default tolerance are wrong by 0.08 mm after the device has lost step; finer ones tell it all."""
    changes = {"drive.frequency": 2.7637, "drive.pitch": 0.1646, "drive.distance": 0.1468, "drive.yaw_rate": 0.0401}
    scenario = hm.load("nose-first/fig3c").replaced(changes | {"run.duration": 200.0, "run.interval": 1.0})
    (ours,), (exact,) = advance([scenario]), advance([scenario], tolerance=1e-11, method=DOP853)
    finer, told = refined(ours)
    first = accuracy_of(ours)
    away, before = (np.linalg.norm(run.states[:, :3] - exact.states[:, :3], axis=1).max() for run in (finer, ours))
    assert before > 1e-5 > first.in_step
    assert away <= max(told.in_step, told.after_slip) <= 5e-7
    assert told.finer_steps == pytest.approx(27000.0)
    assert (told.sensitive, first.sensitive) == (True, True)
    assert told.text.endswith("trust the outcome, not places or slips (steps of a 27000 times finer tolerance)")


def test_a_run_whose_steps_do_stays_as_it_is():
    (ours,) = advance([hm.load("paper/fig3c").replaced({"run.duration": "60 s"})])
    kept, told = refined(ours)
    assert kept is ours
    assert told == accuracy_of(ours)
    assert "tolerance" not in told.text


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


def test_the_command_refines_where_it_is_asked_to(tmp_path):
    """Fig. 3(A) is drawn into the magnet after 1280 s, by errors of ten micrometres 0.2 ms sooner or later."""
    plain, finer = (
        helimag("simulate", "paper/fig3a", "--no-orbit", *option)
        for option in ((), ("--refine", "-o", tmp_path / "r.nc"))
    )
    assert "; --refine takes finer steps\n" in plain.out
    assert "times finer tolerance)\n" in finer.out
    run = hm.Trajectory.load(tmp_path / "r.nc")
    told = json.loads(run.attributes["accuracy"])
    assert told["enough"]
    assert told["in_step"] < 5e-7
    (exact,) = advance([hm.load("paper/fig3a")], tolerance=1e-11, method=DOP853)
    assert run.judgement.end_time == pytest.approx(exact.time[-1], abs=1e-5)
    assert run.gain == pytest.approx(exact.judge().gain, abs=3e-6)
