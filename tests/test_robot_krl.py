"""Programmes: round trip from plan over KRL text to poses, the gate, that nothing gets injected."""

import math
import re
from functools import cache

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from helimag.engine import simulate
from helimag.errors import InputError, NotFeasible
from helimag.geometry import turn
from helimag.orbits import Outlook
from helimag.outcomes import Future
from helimag.robot import (
    as_programmed,
    deviation,
    load_cell,
    plan,
    play,
    rehearsal,
    rehearse,
    report,
    write_krl,
    write_programme,
)
from helimag.robot.krl.grammar import code_of
from helimag.robot.krl.instructions import arc_angle, arc_centre
from helimag.robot.krl.writer import checked_name, comment, name_for, number
from helimag.robot.programme import programme_texts
from helimag.runs.trajectory import Trajectory
from helimag.scenario import load, parse

CELL = load_cell("wide")


@cache
def straight():
    return plan(load("nose-first/table1-row1"), CELL)


@cache
def straight_run():
    return rehearse(straight())


@cache
def circle():
    return plan(load("nose-first/fig3c").replaced({"run.duration": "240 s"}), CELL)


def played(found, **options):
    return deviation(found, play(*write_krl(found, "trip", **options), CELL.arm))


drives = st.fixed_dictionaries(
    {
        "drive.pitch": st.floats(-0.35, 0.35),
        "drive.distance": st.floats(0.1, 0.2),
        "drive.pitch_about": st.sampled_from(["origin", "magnet"]),
        "drive.start": st.tuples(st.floats(-0.03, 0.03), st.floats(-0.05, 0.05), st.just(0.0)),
        "drive.yaw_rate": st.sampled_from([0.0, 1.0, -1.0]).flatmap(
            lambda sign: st.floats(0.01, 0.04).map(lambda rate: sign * rate)
        ),
        "drive.velocity": st.one_of(
            st.just((0.0, 0.0, 0.0)),
            st.tuples(st.floats(-1.5e-3, 1.5e-3), st.floats(-1.5e-3, 1.5e-3), st.floats(0.0, 3e-4)),
        ),
        "run.duration": st.floats(20.0, 35.0),
    }
)


@example(
    changes={
        "drive.pitch": 0.0,
        "drive.distance": 0.125,
        "drive.pitch_about": "origin",
        "drive.start": (0.015625, 0.0, 0.0),
        "drive.yaw_rate": 0.015625,
        "drive.velocity": (0.0010680667512557632, 0.0, 0.0),
        "run.duration": 20.0,
    },
    spline=False,
)
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(changes=drives, spline=st.booleans())
def test_round_trip_of_random_scenarios(changes, spline):
    """ArmPlan, text, parser, poses: 1 um, 1e-6 rad, 0.1 %. A drive too slow to be programmed is refused by name.

    Where points of a spline block are too far apart for its course to be sure, it is refused, and lines serve.
    """
    scenario = load("nose-first/table1-row1").replaced({"workspace": {}, **changes})
    found = plan(scenario, CELL)
    if not found.feasible:
        return
    speeds = np.linalg.norm(np.diff(found.path.at(found.times).position, axis=0), axis=1) / np.diff(found.times)
    if speeds.max() > 0.0 and speeds.min() < 1e-6:
        return
    try:
        trip = played(found, spline=spline)
    except InputError as error:
        assert spline and "the course of a spline block" in str(error)  # noqa: PT017, PT018
        trip = played(found)
    assert trip.position < 1e-6
    assert trip.axis < 1e-6
    assert trip.timing < 1e-3


@pytest.mark.parametrize(
    "name", ["nose-first/fig3a", "nose-first/fig3b", *(f"nose-first/table1-row{row}" for row in range(1, 8))]
)
def test_round_trip_of_the_presets(name):
    scenario = load(name)
    short = scenario.replaced({"run.duration": min(scenario.run.duration, 330.0)})
    trip = played(plan(short, CELL))
    assert trip.acceptable
    assert trip.position < 1e-6
    assert trip.axis < 1e-6
    assert trip.timing < 1e-3


def test_round_trip_with_unwinding():
    found = plan(load("nose-first/fig3c").replaced({"run.duration": "600 s"}), CELL, unwind=True)
    assert len(found.unwindings) >= 1
    assert played(found).acceptable


def test_round_trip_of_a_turn_on_the_spot_and_of_standing_still():
    """Pitch about the magnet, device at the origin: the magnet turns in place, or with no yaw does nothing but spin."""
    base = {"drive.velocity": (0.0, 0.0, 0.0), "run.duration": "60 s"}
    for rate in ("2 deg/s", "0 deg/s"):
        found = plan(load("nose-first/table1-row1").replaced({**base, "drive.yaw_rate": rate}), CELL)
        assert found.feasible
        src, _ = write_krl(found, "still")
        assert ("WAIT SEC 60.000000" in src) == (rate == "0 deg/s")
        assert played(found).acceptable


def test_round_trip_of_waypoints():
    points = [
        ["0 mm", "0 mm", "140 mm"],
        ["30 mm", "10 mm", "145 mm"],
        ["60 mm", "0 mm", "150 mm"],
        ["80 mm", "0 mm", "150 mm"],
    ]
    path = {
        "position": points,
        "speed": ["2 mm/s", "2 mm/s", "1.5 mm/s"],
        "yaw": ["0 deg", "20 deg", "5 deg", "0 deg"],
        "pitch": ["5 deg", "8 deg", "10 deg", "10 deg"],
    }
    changes = {"drive.path": path, "drive.velocity": (0.0, 0.0, 0.0), "run.duration": "20 s", "workspace": {}}
    assert played(plan(load("nose-first/table1-row1").replaced(changes), CELL)).acceptable


@pytest.mark.parametrize("seed", range(5))
def test_round_trip_in_other_cells(seed):
    """The base turned, the motor askew, the magnet off the sixth axis; a line, and a path with bends and a halt."""
    random = np.random.default_rng(seed)
    base = {"position": (0.62, random.uniform(-0.1, 0.1), 0.25), "angles": tuple(random.uniform(-0.3, 0.3, 3))}
    tool = {"axis": (1.0, *random.uniform(-0.5, 0.5, 2)), "magnet": (random.uniform(-0.03, 0.03), 0.0, 0.13)}
    cell = CELL.model_copy(
        update={
            "obstacle": (),
            "base": CELL.base.model_copy(update=base),
            "tool": CELL.tool.model_copy(update=tool),
        }
    )
    bends = {
        "time": [0.0, 4.0, 8.0, 12.0],
        "position": [[0.0, 0.0, 0.14], [0.004, 0.002, 0.141], [0.004, 0.002, 0.141], [0.002, 0.005, 0.14]],
        "yaw": [0.0, *random.uniform(-0.1, 0.1, 3)],
        "pitch": [*random.uniform(-0.1, 0.1, 4)],
    }
    for changes in (
        {"run.duration": 20.0},
        {"drive.path": bends, "drive.velocity": (0.0, 0.0, 0.0), "run.duration": 12.0},
    ):
        found = plan(load("nose-first/table1-row1").replaced({"workspace": {}, **changes}), cell)
        assert found.feasible
        trip = deviation(found, play(*write_krl(found, "trip"), cell.arm))
        assert trip.differences == ()
        assert trip.acceptable


def test_a_programme_that_was_tampered_with_is_noticed():
    src, dat = write_krl(straight(), "trip")
    slow = src.replace("$VEL.CP=0.0008250000", "$VEL.CP=0.0008270000")
    assert slow != src
    assert deviation(straight(), play(slow, dat, CELL.arm)).timing > 2e-3
    aside = dat.replace("DECL E6POS XP1={X 159.967500, Y 0.000000", "DECL E6POS XP1={X 159.967500, Y 0.002000")
    assert aside != dat
    assert deviation(straight(), play(src, aside, CELL.arm)).position > 1.5e-6
    tilted = re.sub(r"(XP1=.*?B )(-?[\d.]+)", lambda m: f"{m[1]}{float(m[2]) + 1e-3:.8f}", dat)
    assert deviation(straight(), play(src, tilted, CELL.arm)).axis > 1e-5


def test_speeds_have_ten_decimals_and_the_paper_s_is_exact():
    src, _ = write_krl(straight(), "trip")
    assert "$VEL.CP=0.0008250000" in src
    for value in re.findall(r"\$VEL\.CP=(\S+)", write_krl(circle(), "trip")[0]):
        assert re.fullmatch(r"\d+\.\d{7,}", value)


def test_circles_are_arcs_passed_without_a_stop():
    src, dat = write_krl(circle(), "trip")
    arcs = [line for line in src.splitlines() if line.startswith("CIRC")]
    assert len(arcs) == math.ceil(240.0 * 1.8 / 90.0)
    assert all(line.endswith("C_DIS") for line in arcs[:-1])
    assert not arcs[-1].endswith("C_DIS")
    assert "DECL E6POS XV1=" in dat


def test_spline_motions_are_written_on_request():
    src, _ = write_krl(circle(), "trip", spline=True)
    assert "SPLINE\n  SCIRC XV1, XP1\n  SCIRC XV2, XP2\n" in src
    assert "SLIN XP1" in write_krl(straight(), "trip", spline=True)[0]


@pytest.mark.parametrize(
    "name",
    [
        "",
        "1abc",
        "a b",
        "a;b",
        "a\nEND",
        "a()",
        "päper",
        "x" * 25,
        "LIN",
        "end",
        "BAS",
        "$VEL",
        "a.src",
        "../a",
        "a{b}",
        "a\x00",
    ],
)
def test_names_that_are_no_krl_names_are_refused(name):
    with pytest.raises(InputError, match="programme's name"):
        checked_name(name)
    with pytest.raises(InputError, match="programme's name"):
        write_krl(straight(), name)


@given(st.text(max_size=60))
def test_any_title_gives_a_krl_name(title):
    assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,23}", name_for(title))


@given(st.text(max_size=300))
def test_any_text_stays_one_comment(text):
    line = comment(text)
    assert line.startswith("; ")
    assert line.isascii()
    assert line.isprintable()
    assert code_of(line) == ""


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e7])
def test_numbers_that_do_not_fit_are_refused(value):
    with pytest.raises(InputError, match="finite"):
        number(value, 6)


@given(st.floats(-1e6, 1e6))
def test_numbers_are_plain(value):
    assert re.fullmatch(r"-?\d+\.\d{7}", number(value, 7))
    assert float(number(value, 7)) == pytest.approx(value, abs=6e-8)


def test_a_hostile_scenario_name_injects_nothing():
    hostile = 'x\nPTP {A1 90}\r\n$VEL.CP=2\n;FOLD"""\nimport os\n"}\x85\u2028END'
    # refused where scenarios are read, and no programme relies on that
    scenario = load("nose-first/table1-row1").model_copy(update={"name": hostile})
    texts = programme_texts(plan(scenario, CELL), run=straight_run(), accept_unbounded=True)
    clean = programme_texts(straight(), run=straight_run(), accept_unbounded=True)
    (src,) = (text for name, text in texts.items() if name.endswith(".src"))
    (plain,) = (text for name, text in clean.items() if name.endswith(".src"))

    def code(text):
        lines = (line.partition(";")[0].strip() for line in re.split(r"[\r\n\x85\u2028]", text))
        return [line for line in lines if line and not line.startswith("DEF")]

    assert code(src) == code(plain)
    (script,) = (text for name, text in texts.items() if name.endswith(".py"))
    assert "import os" not in [line.strip() for line in script.splitlines()]
    compile(script, "script", "exec")
    assert all(re.fullmatch(r"[A-Za-z0-9_]+\.(src|dat|py|csv|json)", name) for name in texts)


def test_unbounded_runs_need_to_be_accepted_and_carry_a_warning(tmp_path):
    judgement = straight_run().judgement
    assert judgement.verdict != "bounded"
    with pytest.raises(InputError, match=rf"not bounded \({judgement.verdict}: .*--accept-unbounded"):
        write_programme(straight(), tmp_path)  # simulates for itself
    assert list(tmp_path.iterdir()) == []
    paths = write_programme(straight(), tmp_path, run=straight_run(), accept_unbounded=True)
    text = next(path for path in paths if path.suffix == ".src").read_text()
    said = f"; WARNING: NOTHING SHOWS THAT THE DEVICE STAYS. the run is not bounded ({judgement.verdict}: "
    assert said in text.splitlines()[3]
    assert f"; Verdict: {judgement.verdict}; {judgement.reason}" in text.splitlines()
    ended = f"; Simulated: the programme's own path without unwindings, {judgement.end_time:.3f} s of 193.900 s"
    assert ended in text.splitlines()


def slow_circle(duration):
    """Fig. 3(C) at 2.5 Hz, where the device comes to a stable orbit; with unwindings where the wrist needs them."""
    changes = {"drive.frequency": "2.5 Hz", "run.duration": duration}
    return plan(load("nose-first/fig3c").replaced(changes), CELL, unwind=True)


@cache
def long_run():
    found = slow_circle("1800 s")
    return found, rehearse(found)


def test_a_bounded_run_needs_no_word_and_carries_no_warning(tmp_path):
    found, run = long_run()
    paths = write_programme(found, tmp_path, run=run, name="nine")
    head = next(path for path in paths if path.suffix == ".src").read_text().splitlines()[:20]
    assert not any("WARNING" in line for line in head)
    assert f"; Verdict: bounded; {run.judgement.reason}" in head
    (outlook,) = (line for line in head if line.startswith("; Outlook: "))
    assert outlook.startswith("; Outlook: coming to a stable orbit; inside for 1800 s")


def test_a_shortened_run_does_not_open_the_gate(tmp_path):
    """The same device, drive and arm for 300 s, which need no unwinding: nobody knows, and the header says so."""
    short = slow_circle("300 s")
    with pytest.raises(
        InputError, match=r"not bounded \(undecided: .* too short .*run 1000 s or more.*accept-unbounded"
    ):
        write_programme(short, tmp_path)
    assert list(tmp_path.iterdir()) == []
    text = programme_texts(short, accept_unbounded=True, name="short")["short.src"]
    assert "; WARNING: NOTHING SHOWS THAT THE DEVICE STAYS. the run is not bounded (undecided: " in text.splitlines()[3]
    assert "; Verdict: undecided; inside for 300 s, which is too short to tell whether it stays" in text


@pytest.mark.parametrize("future", Future)
def test_a_bounded_run_that_leaves_when_it_goes_on_does_not_open_the_gate(monkeypatch, future):
    found, run = long_run()
    monkeypatch.setattr(rehearsal, "explain", lambda _: Outlook(future, "told by the orbits"))
    judged = rehearsal.gate(found, run)
    assert judged.passes == (future not in {Future.LEAVES, Future.GONE, Future.HELD})
    if not judged.passes:
        with pytest.raises(InputError, match=rf"bounded, but does not stay \({future}: told by the orbits\)"):
            programme_texts(found, run=run, name="nine")


def test_the_remedy_for_a_wound_up_wrist_is_no_short_run():
    found = report(plan(load("nose-first/fig3c"), CELL))
    assert "can leave open whether the device stays" in found["remedies"][0]
    assert not any("set run.duration" in remedy for remedy in found["remedies"])


def changed_run(**attributes):
    return Trajectory(straight_run().dataset.assign_attrs(attributes))


CHEATS = {
    "another scenario": (lambda: simulate(load("nose-first/table1-row7"), duration=2.0), "run must be of the path"),
    "a shorter duration": (lambda: simulate(straight().scenario, duration=20.0), "run must be of the path"),
    "the end cut off": (
        lambda: Trajectory(changed_run(end="horizon").dataset.isel(time=slice(0, 50))),
        r"last as long as the programme, 193\.9 s; it stops at 5\.",
    ),
    "another start": (
        lambda: simulate(straight().scenario, initial_state=[0.0, 0.001, 0.0, 1.0, 0.0, 0.0, 0.0]),
        "run must begin as the scenario does",
    ),
    "the beginning cut off": (
        lambda: Trajectory(straight_run().dataset.isel(time=slice(5, None))),
        "run must begin as the scenario does",
    ),
    "a measured run": (lambda: changed_run(source="measured"), "run must be a simulated one"),
    "another's hash typed in": (
        lambda: Trajectory(
            simulate(load("nose-first/table1-row7"), duration=2.0).dataset.assign_attrs(
                scenario_hash=straight().scenario.hash
            )
        ),
        "run must be of the path",
    ),
}


@pytest.mark.parametrize("cheat", CHEATS)
def test_only_the_programmes_own_run_opens_the_gate(tmp_path, cheat):
    make, words = CHEATS[cheat]
    with pytest.raises(InputError, match=words) as caught:
        write_programme(straight(), tmp_path, run=make(), accept_unbounded=True)
    assert "\n" not in str(caught.value)
    assert "leave the run out" in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("off", "opens"), [(1e-15, True), (1e-12, True), (1e-7, False)])
def test_a_path_computed_again_opens_the_gate_and_another_does_not(off, opens):
    """NumPy's sums round otherwise at another address: one programme's path is the same run whatever its last bits."""
    found, run = long_run()
    scenario = parse(run.scenario_toml, "the run's")
    path = scenario.drive.path.model_dump()
    path["yaw"] = [yaw + off for yaw in path["yaw"]]
    moved = scenario.replaced({"drive.path": path})
    assert moved.hash != scenario.hash
    again = Trajectory(run.dataset.assign_attrs(scenario=moved.to_toml(), scenario_hash=moved.hash))
    if opens:
        assert rehearsal.checked_run(found, again) is again
    else:
        with pytest.raises(InputError, match="with the programme's 8 unwindings"):
            rehearsal.checked_run(found, again)


def test_nobody_states_the_verdict():
    with pytest.raises(TypeError, match="verdict"):
        write_programme(straight(), "nowhere", verdict="bounded", reason="settled")


def test_unwindings_are_part_of_the_judged_run():
    """A run without them, or with others, is no run of the programme."""
    found = plan(load("nose-first/fig3c").replaced({"run.duration": "420 s", "run.interval": "1 s"}), CELL, unwind=True)
    assert len(found.unwindings) == 1
    own = as_programmed(found)
    assert own.run.duration == pytest.approx(420.0 + found.unwindings[0].duration)
    with pytest.raises(InputError, match="with the programme's 1 unwindings"):
        programme_texts(found, run=simulate(found.scenario), accept_unbounded=True)
    slower = CELL.model_copy(update={"speed_share": 0.25})
    other = plan(found.scenario, slower, unwind=True)
    assert other.unwindings != found.unwindings
    with pytest.raises(InputError, match="with the programme's 1 unwindings"):
        programme_texts(found, run=rehearse(other), accept_unbounded=True)
    texts = programme_texts(found, accept_unbounded=True, name="lap")
    assert f"; Simulated path's hash: {own.hash}" in texts["lap.src"].splitlines()
    assert "; Simulated: the programme's own path with its 1 unwindings," in texts["lap.src"]


def test_infeasible_plans_are_not_written(tmp_path):
    found = plan(load("nose-first/fig3c"), CELL)
    with pytest.raises(NotFeasible, match=r"cannot run 'nose-first/fig3c': at 38\d\.\d\d s A6 would pass"):
        write_programme(found, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_arcs_against_a_circle():
    """Centre and angle of the arc through three points of a known circle, more and less than half a turn."""
    centre, radius = np.array([0.1, -0.2, 0.3]), 0.07
    tilt = turn(1, 0.4) @ turn(0, -0.7)
    for angle in (0.2, 1.5, 3.0, 4.5, 6.0):
        points = [centre + radius * tilt @ np.array([math.cos(a), math.sin(a), 0.0]) for a in (0.0, angle / 2, angle)]
        assert arc_centre(*points) == pytest.approx(centre, abs=1e-12)
        assert arc_angle(*points) == pytest.approx(angle, abs=1e-9)
    with pytest.raises(ValueError, match="line"):
        arc_centre(np.zeros(3), np.array([1.0, 0, 0]), np.array([2.0, 0, 0]))


def test_arc_turns_the_tool_with_the_path():
    """Half way through the first arc the tool has yawed by half its angle, without tilting."""
    found = circle()
    src, dat = write_krl(found, "trip")
    playback = play(src, dat, CELL.arm, interval=5.0)
    assert np.all(np.diff(playback.time) >= 0.0)
    tool = playback.tool(CELL)[:, :3, :3]
    first = tool[0]
    for time, pose in zip(playback.time[::7], tool[::7], strict=True):
        apart = pose.T @ turn(2, math.radians(1.8) * time) @ first
        assert Rotation.from_matrix(apart).magnitude() < 2e-6
