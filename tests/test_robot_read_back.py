"""Logs and programmes as magnet paths of a simulation, sampled paths in the time loop, the jitter study."""

import math

import numpy as np
import pytest

from helimag.engine import simulate
from helimag.errors import FileError, InputError
from helimag.geometry import magnet_motion
from helimag.robot import load_cell, plan, play, write_krl
from helimag.robot.jitter import Jitter, Shake, SpeedRipple, jittered, load_jitter, measured_jitter, study
from helimag.robot.logs import Log, log_of, log_of_playback, read_log, replayed
from helimag.robot.programme import programme_texts
from helimag.robot.timed import timed_table
from helimag.scenario import load, parse

CELL = load_cell("wide")
CIRCLE = load("nose-first/fig3c").replaced({"run.duration": "30 s", "run.interval": "0.5 s"})


def sampled(scenario, count, **changes):
    """The scenario's own path as samples."""
    times = np.linspace(0.0, scenario.run.duration, count)
    poses = magnet_motion(scenario.drive)(times)
    path = {
        "time": times.tolist(),
        "position": poses.position.tolist(),
        "yaw": (scenario.drive.yaw_rate * times).tolist(),
        **changes,
    }
    return scenario.replaced({"drive.path": path, "drive.yaw_rate": 0.0, "drive.velocity": (0.0, 0.0, 0.0)})


def test_sampled_path_gives_the_run_of_the_closed_form():
    exact, splined = simulate(CIRCLE), simulate(sampled(CIRCLE, 121))
    assert np.abs(exact.dataset.rpm_position.values - splined.dataset.rpm_position.values).max() < 1e-9
    assert np.abs(exact.dataset.rpm_moment.values - splined.dataset.rpm_moment.values).max() < 1e-9
    assert np.abs(exact.final_state[:3] - splined.final_state[:3]).max() < 1e-7
    assert splined.gain == pytest.approx(exact.gain, rel=1e-5)


def test_cubic_interpolation_is_of_fourth_order():
    """Halving the distance of the samples cuts the error of a circle sixteenfold."""
    times = np.linspace(0.0, 30.0, 997)
    exact = magnet_motion(CIRCLE.drive)(times).position
    errors = []
    for count in (9, 17, 33):
        spline = sampled(CIRCLE, count).drive.path.spline(CIRCLE.drive.pitch)
        errors.append(np.abs(spline(times)[:, :3] - exact).max())
    assert 10.0 < errors[0] / errors[1] < 26.0
    assert 10.0 < errors[1] / errors[2] < 26.0


def test_phase_of_a_path_is_added_to_the_spin():
    """A phase that grows evenly is a higher frequency."""
    times = np.linspace(0.0, 30.0, 61)
    faster = sampled(CIRCLE, 61, phase=(2.0 * math.pi * 0.05 * times).tolist())
    direct = CIRCLE.replaced({"drive.frequency": CIRCLE.drive.frequency + 0.05})
    a, b = simulate(faster), simulate(direct)
    assert np.abs(a.dataset.rpm_moment.values - b.dataset.rpm_moment.values).max() < 1e-8
    assert np.abs(a.final_state[:3] - b.final_state[:3]).max() < 1e-6


def test_sampled_scenario_survives_its_file():
    scenario = sampled(CIRCLE, 31)
    again = parse(scenario.to_toml())
    assert again == scenario
    assert again.hash == scenario.hash != CIRCLE.hash


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ({"position": [[0, 0, 0.1]], "time": [0.0]}, "two samples"),
        ({"position": [[0, 0, 0.1], [0, 0, 0.1]], "time": [0.0, 0.0]}, "rise"),
        ({"position": [[0, 0, 0.1], [0, 0, 0.1]], "speed": [0.001]}, "waypoint"),
        ({"position": [[0, 0, 0.1], [0.1, 0, 0.1]], "time": [0.0, 90.0], "speed": [0.1]}, "either time or speed"),
        ({"position": [[0, 0, 0.1], [0.1, 0, 0.1]], "time": [0.0, 90.0], "yaw": [0.0]}, "yaw must have 2"),
        ({"position": [[0, 0, 0.1], [0.1, 0, 0.1]], "time": [0.0, 90.0], "pitch": [0.0, 1.6]}, "pitch must be between"),
        ({"position": [[0, 0, 0.1], [0.1, 0, 0.1]], "time": [0.0, 9.0]}, "run.duration must not exceed"),
    ],
)
def test_bad_paths_are_refused(path, words):
    with pytest.raises(InputError, match=words):
        CIRCLE.replaced({"drive.path": path, "drive.yaw_rate": 0.0})
    with pytest.raises(InputError, match="takes the place"):
        CIRCLE.replaced({"drive.path": sampled(CIRCLE, 31).drive.path.model_dump()})


def written_path(scenario, tmp_path):
    texts = programme_texts(plan(scenario, CELL), accept_unbounded=True, name="run")
    (tmp_path / "path.csv").write_text(texts["run_path.csv"])
    return tmp_path / "path.csv"


@pytest.mark.parametrize("name", ["nose-first/fig3c", "nose-first/table1-row1"])
def test_written_path_read_back_gives_the_planned_run(name, tmp_path):
    """The CSV of the timed path is itself a log; so is the KRL programme run on paper."""
    scenario = load(name).replaced({"run.duration": "40 s", "run.interval": "1 s"})
    planned = simulate(scenario)
    log = read_log(written_path(scenario, tmp_path), CELL)
    found = plan(scenario, CELL)
    krl = log_of_playback(play(*write_krl(found, "run"), CELL.arm, interval=0.25), scenario, CELL)
    exact = log_of(timed_table(found), found.reversed_axis)
    for one, tolerance in ((log, 1e-8), (exact, 1e-8), (krl, 1e-6)):
        run = simulate(replayed(scenario, one, "log"))
        assert np.abs(run.dataset.rpm_position.values - planned.dataset.rpm_position.values).max() < tolerance
        assert (
            np.abs(run.dataset.rpm_moment.values - planned.dataset.rpm_moment.values).max() / 18.89 < 100.0 * tolerance
        )


def test_log_in_the_base_frame_at_the_flange(tmp_path):
    """The same poses measured at the flange in the arm's base frame, in other units."""
    path = written_path(CIRCLE, tmp_path)
    tool = read_log(path, CELL)
    flange = CELL.lab_in_base @ tool.tool @ np.linalg.inv(CELL.tool_in_flange)
    from helimag.robot.arm.frames import angles

    lines = [
        "# frame: base",
        "# pose: flange",
        "# motor axis: against" if tool.reversed_axis else "# motor axis: along",
    ]
    lines.append("c [rad],b [rad],a [rad],z [m],y [m],x [m],note,time [ms]")
    for time, pose in zip(tool.time, flange, strict=True):
        a, b, c = angles(pose[:3, :3])
        x, y, z = pose[:3, 3]
        lines.append(",".join(map(str, (c, b, a, z, y, x, "text", 1e3 * time))))
    (tmp_path / "flange.csv").write_text("\n".join(lines))
    again = read_log(tmp_path / "flange.csv", CELL)
    assert np.abs(again.tool - tool.tool).max() < 1e-9
    assert again.time == pytest.approx(tool.time)
    assert again.motor is None


GOOD = """# frame: lab
# pose: tool
time [s],x [mm],y [mm],z [mm],a [deg],b [deg],c [deg]
0,0,0,150,0,0,0
1,1,0,150,0,0,0
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("# frame: lab\n", "", "frame: lab"),
        ("# pose: tool", "# pose: elbow", "pose: tool"),
        ("x [mm]", "x", "unit"),
        ("x [mm]", "x [deg]", "length"),
        ("z [mm],", "", "lacks z"),
        ("1,1,0", "0,1,0", "line 5: time must rise"),
        ("1,1,0", "1,one,0", "line 5: column 2"),
        ("1,1,0", "1,nan,0", "line 5: column 2"),
        ("\n1,1,0,150,0,0,0", "", "two rows"),
        ("# pose: tool", "# frame: base\n# pose: tool", "both '# frame: lab' and '# frame: base'"),
        ("z [mm]", "z [m]", "line 4: z must be within 100 m either way; got 150 m; check its unit"),
        ("1,1,0,150,0,0,0", "1,1,0,150,0,361,0", "line 5: b must be within 6.28 rad either way"),
    ],
)
def test_bad_logs_are_refused(tmp_path, old, new, words):
    (tmp_path / "good.csv").write_text(GOOD)
    assert read_log(tmp_path / "good.csv", CELL).time[-1] == 1.0
    (tmp_path / "log.csv").write_text(GOOD.replace(old, new))
    with pytest.raises(InputError) as caught:
        read_log(tmp_path / "log.csv", CELL)
    assert words in str(caught.value)
    with pytest.raises(FileError):
        read_log(tmp_path / "none.csv", CELL)


def log_with_motor(tmp_path, interval, motor, rows=60):
    """A log of a magnet that stands above the origin, with a column of motor angles (deg) by the time (s)."""
    times = interval * np.arange(rows)
    lines = [f"{time:.6f},{1e-3 * time:.6f},0,150,0,0,0,{motor(time):.6f}" for time in times]
    marks, heads = GOOD.splitlines()[:2], GOOD.splitlines()[2] + ",motor [deg]"
    (tmp_path / "log.csv").write_text("\n".join([*marks, heads, *lines]) + "\n")
    return read_log(tmp_path / "log.csv", CELL)


def test_a_motor_recorded_within_a_turn_too_seldom_is_refused(tmp_path):
    """3.3 Hz in rows of 0.9 s would read as -0.03 Hz; in rows of 0.1 s, or without jumps in any rows, it is 3.3 Hz."""
    per_second = 360.0 * CIRCLE.drive.frequency
    seldom = log_with_motor(tmp_path, 0.9, lambda time: (per_second * time) % 360.0)
    for use in (lambda log: replayed(CIRCLE, log, "log"), lambda log: measured_jitter(CIRCLE, log, "log")):
        with pytest.raises(InputError, match=r"makes 2\.97 turns; record it at least every 0\.13 s, or without jumps"):
            use(seldom)
    often = log_with_motor(tmp_path, 0.1, lambda time: (per_second * time) % 360.0)
    whole = log_with_motor(tmp_path, 0.9, lambda time: per_second * time)
    for log in (often, whole):
        assert measured_jitter(CIRCLE, log, "log").frequency_error == pytest.approx(0.0, abs=1e-6)
        assert np.abs(replayed(CIRCLE, log, "log").drive.path.phase).max() < 1e-6


def test_motors_that_jump_back_or_turn_the_other_way_are_refused(tmp_path):
    per_second = 360.0 * CIRCLE.drive.frequency
    with pytest.raises(InputError, match=r"motor jumps back by 6\d\d deg, and is not within one turn"):
        log_with_motor(tmp_path, 0.05, lambda time: (per_second * time) % 720.0)
    with pytest.raises(InputError, match="turns the other way round"):
        measured_jitter(CIRCLE, log_with_motor(tmp_path, 0.1, lambda time: -per_second * time), "log")


def test_a_tool_that_rolls_takes_the_magnet_with_it():
    """Without a recorded motor angle, a tool that turns about the motor's axis adds that turn to the spin."""
    from helimag.geometry import turn
    from helimag.robot.arm.frames import frames

    time = np.linspace(0.0, 30.0, 61)
    poses = magnet_motion(CIRCLE.drive)(time)
    roll = 0.3 * time
    log = Log(time, frames(poses.position, poses.rotation @ turn(0, roll)), None, False)
    path = replayed(CIRCLE, log, "log").drive.path
    assert path.phase == pytest.approx(roll.tolist(), abs=1e-9)


@pytest.mark.parametrize("reversed_axis", [False, True])
def test_recorded_motor_angles_give_the_moment_in_the_lab(reversed_axis):
    """The moment is the tool's (0, cos, sin) of the motor's angle, however the tool is held and turned."""
    from helimag.geometry import turn
    from helimag.robot.arm.frames import frames
    from helimag.robot.arm.path import magnet_path

    time = np.linspace(0.0, 30.0, 301)
    poses = magnet_motion(CIRCLE.drive)(time)
    facing = turn(2, math.pi if reversed_axis else 0.0)
    tool = frames(poses.position, poses.rotation @ facing @ turn(0, 0.4 + 0.1 * time))
    motor = (-1.0 if reversed_axis else 1.0) * 2.0 * math.pi * 3.3 * time + 0.7
    found = magnet_path(replayed(CIRCLE, Log(time, tool, motor, reversed_axis), "log")).at(time)
    seen = np.einsum("nij,nj->ni", tool[:, :3, :3], np.column_stack([0.0 * motor, np.cos(motor), np.sin(motor)]))
    spin = np.column_stack([0.0 * found.spin, np.cos(found.spin), np.sin(found.spin)])
    assert np.abs(np.einsum("nij,nj->ni", found.rotation, spin) - seen).max() < 1e-9


def test_offset_jitter_is_a_shifted_path():
    """An offset of the magnet is the same as a device that starts the other way off, seen from its start."""
    scenario = load("nose-first/table1-row1").replaced({"run.duration": "40 s", "workspace": {}})
    shifted = jittered(scenario, Jitter(offset=(0.0, 0.0, 2e-3)), np.random.default_rng(0))
    nearer = scenario.replaced({"drive.distance": scenario.drive.distance + 2e-3})
    a, b = simulate(shifted), simulate(nearer)
    assert np.abs(a.final_state[:3] - b.final_state[:3]).max() < 1e-6


def test_speed_ripple_moves_along_the_path():
    scenario = load("nose-first/table1-row1").replaced({"run.duration": "20 s"})
    ripple = SpeedRipple(frequency=1.0, share=0.2)
    path = jittered(scenario, Jitter(speed=(ripple,)), np.random.default_rng(0)).drive.path
    position = np.array(path.position)
    assert np.ptp(position[:, 1:], axis=0).max() == 0.0
    speed = np.gradient(position[:, 0], np.array(path.time))[5:-5]
    assert speed.max() == pytest.approx(0.825e-3 * 1.2, rel=0.02)
    assert speed.min() == pytest.approx(0.825e-3 * 0.8, rel=0.03)


def test_spectrum_of_a_log_is_found_again():
    """Known offset, line and frequency error, put into a log and taken out of it."""
    scenario = load("nose-first/table1-row1").replaced({"run.duration": "40 s"})
    time = np.linspace(0.0, 40.0, 4001)
    poses = magnet_motion(scenario.drive)(time)
    from helimag.robot.arm.frames import frames

    position = poses.position + np.array([1e-4, -2e-4, 0.0])
    position[:, 2] += 5e-5 * np.sin(2.0 * math.pi * 7.0 * time)
    motor = 2.0 * math.pi * scenario.drive.frequency * 1.002 * time
    found = measured_jitter(scenario, Log(time, frames(position, poses.rotation), motor, False), "test")
    assert found.offset == pytest.approx((1e-4, -2e-4, 0.0), abs=1e-6)
    strongest = max(found.shake, key=lambda shake: abs(shake.amplitude[2]))
    assert strongest.frequency == pytest.approx(7.0, abs=0.03)
    assert strongest.amplitude[2] == pytest.approx(5e-5, rel=0.05)
    assert found.frequency_error == pytest.approx(0.002, rel=1e-6)
    assert found.source == "measured: test"


def test_study_reports_each_kind_of_error_and_all():
    scenario = load("nose-first/table1-row1").replaced({"run.duration": "10 s", "workspace": {}})
    jitter = Jitter(
        speed=(SpeedRipple(frequency=2.0, share=0.1),),
        shake=(Shake(frequency=2.0, amplitude=(0.0, 0.0, 1e-4)),),
        offset=(0.0, 0.0, 1e-3),
        frequency_error=0.01,
    )
    found = study(scenario, jitter, draws=2)
    assert list(found) == ["speed", "shake", "offset", "frequency_error", "all"]
    assert [len(each.gains) for each in found.values()] == [2, 2, 1, 1, 2]
    nominal = found["all"].judgement.gain
    assert nominal == pytest.approx(simulate(scenario).gain, rel=1e-6)
    assert found["offset"].gains.mean() != pytest.approx(nominal, rel=1e-3)
    assert found["shake"].gains.std() > 0.0


def test_jitter_files(tmp_path):
    text = """
frequency_error = 0.001
offset = ["0.1 mm", "0 mm", "0 mm"]
[[speed]]
frequency = "5 Hz"
share = 0.02
[[shake]]
frequency = "12 Hz"
amplitude = ["0 mm", "0 mm", "0.05 mm"]
"""
    (tmp_path / "jitter.toml").write_text(text)
    found = load_jitter(tmp_path / "jitter.toml")
    assert found.shake[0].amplitude[2] == 5e-5
    assert set(found.parts) == {"speed", "shake", "offset", "frequency_error", "all"}
    (tmp_path / "bad.toml").write_text(text.replace('"5 Hz"', '"5 mm"'))
    with pytest.raises(InputError, match=r"speed.0.frequency"):
        load_jitter(tmp_path / "bad.toml")
    with pytest.raises(InputError, match="samples"):
        jittered(
            load("nose-first/table1-row1"),
            Jitter(shake=(Shake(frequency=1e4, amplitude=(0, 0, 0)),)),
            np.random.default_rng(0),
        )
