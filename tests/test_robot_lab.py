"""What a laboratory needs of a programme: motor, load, tank, spline blocks, the way up; and the same in RoboDK."""

import math
import re
import sys
import types
from functools import cache
from importlib import resources

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from helimag.errors import InputError, NotFeasible
from helimag.robot import deviation, load_cell, log_of_playback, plan, play, write_krl, write_programme
from helimag.robot.arm import Load, Motor
from helimag.robot.krl.sequence import lead_time
from helimag.robot.krl.writer import checked_name
from helimag.robot.programme import programme_texts
from helimag.robot.robodk import write_robodk
from helimag.scenario import PAPER_TANK, load

PORTS = {"run_output": 5, "speed_input": 7, "phase_input": 8, "phase_angle": 0.3}
LOAD = Load(mass=1.2, center=(0.0, 0.001, 0.08), inertia=(0.01, 0.011, 0.002))
EQUIPPED = load_cell("wide").model_copy(
    update={"motor": Motor(**PORTS), "load": LOAD, "start_output": 3, "retreat": 0.1}
)
SCENARIOS = {
    "line": ("nose-first/table1-row1", {}),
    "arcs": ("nose-first/fig3c", {"run.duration": 600.0}),
    "drift": ("nose-first/fig3c", {"run.duration": 100.0, "drive.velocity": (2e-4, 0.0, 0.0)}),
    "turn": (
        "nose-first/table1-row1",
        {"drive.velocity": (0.0, 0.0, 0.0), "drive.yaw_rate": 0.03, "run.duration": 40.0},
    ),
}


@cache
def planned(kind):
    name, changes = SCENARIOS[kind]
    return plan(load(name).replaced(changes), EQUIPPED, unwind=True)


@cache
def written(kind, spline=False):
    return write_krl(planned(kind), "lab", spline=spline)


def back(src, dat):
    return play(src, dat, EQUIPPED.arm, inputs=EQUIPPED.inputs)


def differences(src, kind="line"):
    return deviation(planned(kind), back(src, written(kind)[1])).differences


@pytest.mark.parametrize("spline", [False, True])
@pytest.mark.parametrize("kind", [*SCENARIOS])
def test_programmes_with_all_options_read_back_as_the_plan(kind, spline):
    found = deviation(planned(kind), back(*written(kind, spline)))
    assert found.differences == ()
    assert found.acceptable


@pytest.mark.parametrize("waits", ["$IN[7]==TRUE", "($IN[7])", "$IN[7]<>FALSE"])
def test_a_wait_may_be_written_as_people_do(waits):
    src, _ = written("line")
    assert differences(src.replace("WAIT FOR $IN[7]", f"WAIT FOR {waits}")) == ()
    assert differences(src.replace("WAIT FOR $IN[7]", "WAIT FOR $IN[7]==FALSE")) != ()


def test_the_motor_is_started_awaited_and_stopped_in_order():
    src, _ = written("line")
    lead = f"{lead_time(planned('line')):.6f}"
    at_start = ["$OV_PRO=100", "$OUT[5]=TRUE", "WAIT FOR $IN[7]", "WAIT FOR NOT $IN[8]", "WAIT FOR $IN[8]"]
    path = [f"WAIT SEC {lead}", "$OUT[3]=TRUE", "$VEL.CP=0.0008250000", "LIN XP1", "$OUT[3]=FALSE", "$OUT[5]=FALSE"]
    way_up = ["$VEL.CP=0.1000000000", "LIN XUP", "END"]
    assert "\n".join([*at_start, *path, *way_up]) in src
    assert "INTERRUPT DECL 2 WHEN $STOPMESS==TRUE DO lab_OFF ( )\nINTERRUPT ON 2\n" in src
    assert "DEF lab_OFF ( )\n$OUT[5]=FALSE\nLOOP\nHALT\nENDLOOP\nEND\n" in src


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("$OUT[5]=FALSE\nLOOP", "HALT\n$OUT[5]=FALSE\nLOOP", "on a stop the programme sets none"),
        ("$OUT[5]=TRUE\nWAIT FOR $IN[7]", "WAIT FOR $IN[7]\n$OUT[5]=TRUE", "between switching it on and the beginning"),
        ("WAIT FOR $IN[7]\n", "$OUT[3]=TRUE\nWAIT FOR $IN[7]\n", "the programme switches"),
    ],
)
def test_a_handshake_in_another_order_is_not_the_plan_s(old, new, words):
    src, _ = written("line")
    assert old in src
    assert any(words in line for line in differences(src.replace(old, new)))


@pytest.mark.parametrize("frequency", [3.5, -3.5, 0.4])
@pytest.mark.parametrize("phase", [0.0, 1.0, -2.5, 6.0])
def test_the_path_begins_when_the_moment_is_where_the_plan_has_it(frequency, phase):
    """At the reference the moment is at ``phase`` about the motor; the lead later it is along the drive's moment."""
    cell = EQUIPPED.model_copy(update={"motor": Motor(**{**PORTS, "phase_angle": phase})})
    found = plan(load("nose-first/table1-row1").replaced({"drive.frequency": frequency, "run.duration": 20.0}), cell)
    lead = lead_time(found)
    assert 0.0 <= lead < 1.0 / abs(frequency)
    src, dat = write_krl(found, "lab")
    tool = play(src, dat, cell.arm, inputs=cell.inputs).tool(cell)[0, :3, :3]
    sense = -1.0 if found.reversed_axis else 1.0
    angle = phase + sense * 2.0 * math.pi * frequency * lead
    moment = tool @ [0.0, math.cos(angle), math.sin(angle)]
    pitched = Rotation.from_euler("y", -found.scenario.drive.pitch).as_matrix()
    assert moment == pytest.approx(pitched @ [0.0, 1.0, 0.0], abs=1e-6)  # eq. (2) at t = 0: along y


HANDSHAKE = {
    "no start": ("$OUT[5]=TRUE\n", "", "outputs: the programme switches"),
    "another start": ("$OUT[5]=TRUE\n", "$OUT[6]=TRUE\n", "outputs: the programme switches"),
    "not at speed": ("WAIT FOR $IN[7]\n", "", "inputs: the programme waits for"),
    "no edge": ("WAIT FOR NOT $IN[8]\n", "", "inputs: the programme waits for"),
    "falls": ("WAIT FOR NOT $IN[8]\nWAIT FOR $IN[8]", "WAIT FOR $IN[8]\nWAIT FOR NOT $IN[8]", "inputs: the programme"),
    "no lead": (r"WAIT SEC", "WAIT SEC 0.001+", "after the motor's phase reference; the plan has"),
    "no stop on abort": ("INTERRUPT ON 2\n", "", "on a stop the programme sets none; the plan $OUT[5]=FALSE"),
    "on at abort": ("( )\n$OUT[5]=FALSE", "( )\n$OUT[5]=TRUE", "on a stop the programme sets $OUT[5]=TRUE"),
    "another off": ("( )\n$OUT[5]=FALSE", "( )\n$OUT[6]=FALSE", "on a stop the programme sets $OUT[6]=FALSE"),
    "runs on": ("$OUT[5]=FALSE\n$VEL", "$VEL", "outputs: the programme switches"),
    "stays": ("LIN XUP\n", "", "does not go up by 100 mm"),
    "half way up": ("LIN XUP\n", "LIN {Z 152.0}\n", "does not go up by 100 mm"),
    "a little less": ("LIN XUP\n", "XUP.Z=XUP.Z-0.01\nLIN XUP\nXUP.Z=XUP.Z+0.01\n", "is not the way up by 100 mm"),
    "faster up": ("$VEL.CP=0.1000000000\nLIN XUP", "$VEL.CP=0.2\nLIN XUP", "$VEL.CP is not the plan's on the way up"),
    "not at the end": ("LIN XUP\n", "LIN XUP\nWAIT SEC 5\n", "goes on behind the way up"),
    "heavier": ("{M 1.2000", "{M 1.3000", "$LOAD.M is 1.29999"),
    "lopsided": ("CM {X 0.000", "CM {X 5.000", "$LOAD.CM.X is 5"),
    "sluggish": ("J {X 0.010000", "J {X 0.100000", "$LOAD.J.X is 0.1"),
    "no load": (r"$LOAD=", "; $LOAD=", "$LOAD.M is not set"),
    "a numbered tool's load": ("$ADVANCE=3", "TOOL_DATA[1]=$TOOL\nBAS (#TOOL,1)\n$ADVANCE=3", "$LOAD.M is not set"),
}


@pytest.mark.parametrize("change", [*HANDSHAKE])
def test_a_changed_handshake_load_or_way_up_is_found(change):
    old, new, words = HANDSHAKE[change]
    src, _ = written("line")
    assert old in src
    assert any(words in each for each in differences(src.replace(old, new, 1)))


def test_the_motor_is_switched_where_the_path_begins_and_ends():
    """Not before the arm has gone to the start, which takes who knows how long, nor behind the way up."""
    src, _ = written("line")
    on, off = "$OUT[5]=TRUE\n", "$OUT[5]=FALSE\n"
    early = src.replace(on, "", 1).replace("PTP XSTART\n", f"{on}PTP XSTART\n", 1)
    assert any("$OUT[5]=TRUE does not stand where the path begins" in each for each in differences(early))
    head, gap, tail = src.partition("LIN XP1\n")
    late = head + gap + tail.replace(off, "", 1).replace("LIN XUP\n", f"LIN XUP\n{off}", 1)
    assert any("$OUT[5]=FALSE does not stand where it ends" in each for each in differences(late))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("WAIT FOR $IN[7]", "WAIT FOR $IN[9]", r"\$IN\[9\] is an input"),
        ("LOOP\nHALT\nENDLOOP\n", "PTP XSTART\n", "may set outputs and halt"),
        ("LOOP\nHALT\nENDLOOP\n", "LOOP\n$OUT[5]=TRUE\nENDLOOP\n", "may set outputs and halt"),
        ("DEF lab_OFF ( )", "DEF lab_ON ( )", "LAB_OFF is not a routine in this file"),
        ("$STOPMESS==TRUE DO lab", "$IN[8]==TRUE DO lab", "only those on stops are"),
        ("LIN XP1", "INTERRUPT OFF 2\nLIN XP1", "must not change once the arm has moved"),
        ("{M 1.2000", "{M 0.0", r"\$LOAD.M must be a number above 0"),
    ],
)
def test_what_cannot_be_followed_of_a_handshake_is_refused(old, new, words):
    src, dat = written("line")
    assert old in src
    with pytest.raises(InputError, match=words):
        back(src.replace(old, new, 1), dat)


def test_a_replayed_programme_is_its_path_alone():
    """Neither the wait for the motor nor the way up is part of what the device swims under."""
    found = planned("line")
    log = log_of_playback(back(*written("line")), found.scenario, EQUIPPED)
    assert log.time[0] == pytest.approx(0.0, abs=1e-9)
    assert log.time[-1] == pytest.approx(193.9, abs=0.01)
    assert log.tool[-1, 2, 3] == pytest.approx(0.102, abs=1e-6)
    assert np.linalg.norm(log.tool[1, :3, 3] - log.tool[0, :3, 3]) > 1e-3


def test_a_way_up_that_the_arm_cannot_go_is_not_feasible(tmp_path):
    found = plan(load("nose-first/table1-row1"), EQUIPPED.model_copy(update={"retreat": 1.5}))
    assert not found.feasible
    assert found.offence.time > 193.9
    with pytest.raises(NotFeasible, match="lower retreat in the cell"):
        write_programme(found, tmp_path)
    lid = {"name": "lid", "low": (0.17, -0.3, 0.43), "high": (0.3, 0.3, 0.5)}  # above the wrist where the path ends
    under = EQUIPPED.model_copy(update={"obstacle": (EQUIPPED.obstacle[0].model_copy(update=lid),), "retreat": 0.25})
    assert plan(load("nose-first/table1-row1"), under.model_copy(update={"retreat": None})).feasible
    assert plan(load("nose-first/table1-row1"), under).offence.kind == "collision"


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('start_output = 5\n[motor]\nrun_output = 5', "motor.run_output must be another output than start_output"),
        ("[motor]\nrun_output = 5\nspeed_input = 7\nphase_input = 7", "motor.phase_input must be another input"),
        ("[motor]\nrun_output = 0", "motor.run_output: input should be greater than or equal to 1"),
        ('[load]\nmass = "12 kg"\ncenter = ["0 mm", "0 mm", "0 mm"]', "load.mass must be at most 10 kg"),
        ('[load]\nmass = "-1 kg"\ncenter = ["0 mm", "0 mm", "0 mm"]', "load.mass must be positive"),
    ],
)  # fmt: skip
def test_cells_that_do_not_fit_together_are_refused(tmp_path, table, words):
    text = (resources.files("helimag.robot") / "data" / "default_cell.toml").read_text(encoding="utf-8")
    (tmp_path / "cell.toml").write_text(text.replace("[base]", f"{table}\n[base]", 1))
    with pytest.raises(InputError, match=re.escape(words)):
        load_cell(tmp_path / "cell.toml")


def test_one_tank_serves_scenario_cell_and_films():
    """200 x 80 x 80 mm (section III), the same box in the default cell, the walls of Table I and the synthetic rig."""
    from helimag.vision import paper_rig

    tank = load_cell().tank
    assert np.array(tank.high) - tank.low == pytest.approx([0.2, 0.08, 0.08], abs=1e-12)
    assert np.array([tank.low, tank.high]) == pytest.approx(np.array(PAPER_TANK), abs=1e-12)
    assert paper_rig().tank == pytest.approx(np.array(PAPER_TANK))
    walls = load("nose-first/table1-row1").workspace.walls
    assert (walls.x, walls.y) == ((tank.low[0], tank.high[0]), (tank.low[1], tank.high[1]))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"drive.start": (0.0, -0.045, 0.0), "workspace": {}}, "drive.start must be inside the cell's tank, y from"),
        ({"drive.start": (0.0, 0.0, 0.01), "workspace": {}}, "z from -76.5 mm to 3.5 mm; got '10 mm'"),
        ({"workspace.walls.x": (-0.02, 0.25)}, "workspace must lie inside the cell's tank, x from -20 mm to 180 mm"),
        ({"workspace.floor": -0.09}, "workspace must lie inside the cell's tank, z from"),
    ],
)
def test_a_device_outside_the_tank_is_refused(changes, words):
    with pytest.raises(InputError, match=re.escape(words)):
        plan(load("nose-first/table1-row1").replaced(changes), load_cell())


def test_spline_blocks_reach_from_stop_to_stop():
    """A circle is one block of arcs between two unwindings, a drifting one a curve through its points."""
    src, _ = written("arcs", spline=True)
    stops = len(planned("arcs").unwindings) + 1
    assert stops > 1
    motions = re.findall(r"^  (SCIRC|SPL|SLIN) ", src, re.M)
    assert set(motions) == {"SCIRC"}
    assert src.count("SPLINE\n  SCIRC") in {stops, stops - 1}  # a last arc by itself needs no block
    drift, _ = written("drift", spline=True)
    ends = re.findall(r"^ENDSPLINE.*$", drift, re.M)
    assert ends == ["ENDSPLINE C_SPL"] * (len(ends) - 1) + ["ENDSPLINE"]  # blocks of 400 at most, passed without a stop
    assert len(re.findall(r"^  SPL XP\d+( WITH \$VEL\.CP=0\.\d{10})?$", drift, re.M)) == len(planned("drift").motions)


COURSES = {
    "a corner": ("SPLINE\nSLIN {X 40,Y 0}\nSLIN {X 40,Y 30}\nENDSPLINE", "slows down at a corner, here of 8"),
    "far apart": ("SPLINE\nSPL {X 40,Y 1}\nSPL {X 80,Y 0}\nENDSPLINE", "course of a spline block between its points"),
    "beside an arc": ("SPLINE\nSCIRC {X 5,Y 5}, {X 10,Y 0}\nSPL {X 20,Y 0}\nENDSPLINE", "between its points"),
    "a turn of its own": ("SPLINE\nSPL {X 40,A 1,B -13,C 0}\nSPL {X 80,A 0}\nENDSPLINE", "between its points"),
    "twice the same": ("SPLINE\nSPL {X 40}\nSPL {X 40}\nENDSPLINE", "has no length"),
    "rounded inside": ("SPLINE\nSPL {X 40} C_DIS\nSPL {X 80}\nENDSPLINE", "not rounded by itself"),
    "empty": ("SPLINE\nENDSPLINE", "anything but SPL, SLIN and SCIRC"),
}


@pytest.mark.parametrize("course", [*COURSES])
def test_spline_blocks_whose_course_is_the_controllers_are_refused(course):
    block, words = COURSES[course]
    src, dat = written("line")
    with pytest.raises(InputError, match=words):
        back(src.replace("LIN XP1\n", f"{block}\nLIN XP1\n"), dat)


def test_a_straight_spline_block_is_followed_and_timed():
    """Three points on the line are the line; half the speed for one of them is found by its time."""
    src, dat = written("line")
    for speed, fits in (("", True), (" WITH $VEL.CP=0.0004", False)):
        block = f"SPLINE\nSPL {{X 40}}\nSPL {{X 80}}{speed}\nSPL XP1\nENDSPLINE\n"
        found = deviation(planned("line"), back(src.replace("LIN XP1\n", block), dat))
        assert found.acceptable is fits
        assert (found.timing < 1e-3) is fits


class Recorder:
    """A stand-in for RoboDK's arm that keeps what it is told."""

    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        return lambda *values: self.calls.append((name, values))


def told(monkeypatch, found, arm=None):
    """The calls that the script of a plan makes; the poses are those of RoboDK's own package."""
    pytest.importorskip("robodk.robomath")
    arm = arm or Recorder()
    link = types.ModuleType("robodk.robolink")
    link.ITEM_TYPE_ROBOT = 2
    link.Robolink = lambda: types.SimpleNamespace(ItemUserPick=lambda *_: arm)
    monkeypatch.setitem(sys.modules, "robodk.robolink", link)
    exec(compile(write_robodk(found, "lab", ["a\nb"]), "lab.py", "exec"), {})
    return arm.calls


@pytest.mark.parametrize("kind", [*SCENARIOS])
def test_the_robodk_script_is_the_krl_programme(monkeypatch, kind):
    """Motion by motion: flange, speed, rounding, outputs, inputs and pauses are those of the KRL as it is read back."""
    found, playback = planned(kind), back(*written(kind))
    state = {"setRounding": None, "setSpeed": None, "setSpeedJoints": None}
    moves, beside = [], []
    for name, values in told(monkeypatch, found):
        if name in {"setPoseFrame", "setPoseTool"}:
            state[name] = np.array(values[0].rows)
        elif name in {"setRounding", "setSpeed", "setSpeedJoints"}:
            state[name] = values[0]
        elif name in {"MoveJ", "MoveL", "MoveC"}:
            moves.append((name, values, dict(state)))
        elif name != "setAcceleration":
            beside.append((name, *values))
    legs = [leg for leg in playback.legs if leg.order != "end"]
    assert [name for name, *_ in moves] == [
        {"ptp": "MoveJ", "lin": "MoveL", "circ": "MoveC"}[leg.order] for leg in legs
    ]
    for (name, values, now), leg in zip(moves, legs, strict=True):
        if name == "MoveJ":
            assert np.radians(values[0]) == pytest.approx(leg.joints, abs=1e-6)
        else:
            target = np.array(values[-1].rows)
            pose = now["setPoseFrame"] @ target @ np.linalg.inv(now["setPoseTool"])
            flange = playback.flange[leg.last].copy()
            flange[:3, 3] *= 1e3
            assert pose == pytest.approx(flange, abs=1e-3)  # um and mrad; KRL's reals are single
            if leg.length > 1e-6:
                assert now["setSpeed"] == pytest.approx(1e3 * leg.settings["$VEL.CP"], rel=1e-5)
        assert now["setRounding"] == pytest.approx(1e3 * EQUIPPED.approximation if leg.rounded else -1.0)
    switches = [("setDO", each.output, int(each.on)) for each in playback.switches]
    assert [call for call in beside if call[0] == "setDO"] == switches
    assert [call[1:] for call in beside if call[0] == "waitDI"] == [(e.input, int(e.on)) for e in playback.awaited]
    assert [call[1] for call in beside if call[0] == "Pause"] == [pytest.approx(1e3 * playback.begin, abs=1e-3)]


class Stopped(Recorder):
    """An arm whose run is stopped at its third motion along the path."""

    def __getattr__(self, name):
        if name == "MoveL" and sum(called == "MoveL" for called, _ in self.calls) == 2:
            raise KeyboardInterrupt
        return super().__getattr__(name)


def test_a_robodk_script_that_is_stopped_switches_the_motor_off_as_the_krl_does(monkeypatch):
    arm, krl = Stopped(), back(*written("turn"))
    with pytest.raises(KeyboardInterrupt):
        told(monkeypatch, planned("turn"), arm)
    after = arm.calls[[i for i, (name, _) in enumerate(arm.calls) if name == "MoveL"][-1] + 1 :]
    assert [values for name, values in after if name == "setDO"] == [(n, int(on)) for n, on in krl.on_stop] == [(5, 0)]
    bare = plan(planned("turn").scenario, EQUIPPED.model_copy(update={"motor": None}))
    assert '"off_on_a_stop": []' in write_robodk(bare, "lab")


OPTIONS = {  # of a cell: what the programme has with it
    "none": {"motor": None, "load": None, "start_output": None, "retreat": None},
    "motor alone": {"motor": Motor(run_output=1), "load": None, "start_output": None, "retreat": None},
    "no phase": {"motor": Motor(run_output=1, speed_input=2), "retreat": 0.05},
    "phase alone": {"motor": Motor(run_output=1, phase_input=4, phase_angle=-2.0), "start_output": 9},
    "output alone": {"motor": None, "start_output": 9, "retreat": 0.02},
    "rounding and acceleration": {"approximation": 2e-3, "acceleration": 0.25},
}


@pytest.mark.parametrize("option", [*OPTIONS])
def test_robodk_and_krl_are_one_programme_with_every_option_of_a_cell(monkeypatch, option):
    """Outputs, inputs, pauses and motions in one order; the KRL's are its text, the script's what it calls."""
    still = {"drive.velocity": (0.0, 0.0, 0.0), "run.duration": 20.0}
    for changes in ({"run.duration": 20.0}, still, {**still, "drive.yaw_rate": 0.05}):
        found = plan(load("nose-first/table1-row1").replaced(changes), EQUIPPED.model_copy(update=OPTIONS[option]))
        src, _ = write_krl(found, "lab")
        main = src.split("\nEND\n")[0]
        spelt = {
            r"\$OUT\[(\d+)\]=(TRUE|FALSE)": lambda number, on: ("setDO", int(number), int(on == "TRUE")),
            r"WAIT FOR (NOT )?\$IN\[(\d+)\]": lambda no, number: ("waitDI", int(number), int(not no)),
            r"WAIT SEC ([\d.]+)()": lambda seconds, _: ("Pause", pytest.approx(1e3 * float(seconds))),
            r"(PTP|LIN|CIRC) \w+()": lambda order, _: ({"PTP": "MoveJ", "LIN": "MoveL", "CIRC": "MoveC"}[order],),
            r"\$VEL\.CP=([\d.]+)()": lambda speed, _: ("setSpeed", pytest.approx(1e3 * float(speed))),
        }
        wanted = []
        for line in main.splitlines():
            for pattern, call in spelt.items():
                match = re.match(pattern, line)
                if match:
                    wanted.append(call(*match.groups()))
        calls = told(monkeypatch, found)
        heard = [
            (name,) if name.startswith("Move") else (name, *values)
            for name, values in calls
            if name in {"setDO", "waitDI", "Pause", "MoveJ", "MoveL", "MoveC", "setSpeed"}
        ]
        assert heard == wanted
        assert ("setAcceleration", (1e3 * found.cell.acceleration,)) in calls
        roundings = {values[0] for name, values in calls if name == "setRounding"}
        assert roundings <= {-1.0, 1e3 * found.cell.approximation}


def test_the_robodk_wrist_turns_back_at_the_krl_pace(monkeypatch):
    """MoveJ of an unwinding: one turn of axis 6 at its speed takes what the plan says; then back to the exact pose."""
    found = planned("arcs")
    calls = told(monkeypatch, found)
    turned = [i for i, (name, _) in enumerate(calls) if name == "MoveJ"][1:]
    assert len(turned) == len(found.unwindings) > 0
    for i, stop in zip(turned, found.unwindings, strict=True):
        speeds = [values[0] for name, values in calls[:i] if name == "setSpeedJoints"]
        assert 360.0 * abs(stop.turns) / speeds[-1] == pytest.approx(stop.duration, rel=1e-6)
        assert calls[i + 1][0] == "MoveL"


def test_headers_say_what_the_lab_must_know():
    found = plan(load("nose-first/table1-row1").replaced({"run.duration": 20.0}), EQUIPPED)
    texts = programme_texts(found, name="lab", accept_unbounded=True)
    src = texts["lab.src"]
    assert "; Motor: on with $OUT[5], waits for $IN[7], $IN[8]; off on a stop" in src
    assert "; Load: 1.2 kg" in src
    assert "; At the end the arm goes up by 100 mm" in src


def test_the_files_of_a_changed_scenario_have_another_name_than_the_preset_s():
    """Both go into one folder; neither takes the other's place."""
    row = load("nose-first/table1-row1").replaced({"run.duration": 20.0})
    preset = row.replaced({"name": "mine"})  # a name of its own
    slower = row.replaced({"drive.velocity": (5e-4, 0.0, 0.0)})
    names = [sorted(programme_texts(plan(each, EQUIPPED), accept_unbounded=True))[0] for each in (row, slower, preset)]
    assert names[2] == "mine.dat"
    for name, each in zip(names, (row, slower), strict=False):
        assert name == f"nose_first_table1_{each.hash[:6]}.dat"
        assert checked_name(name.removesuffix(".dat"))


def test_a_course_that_is_not_sure_is_refused_with_the_remedy():
    """Yaw and a sideways way at once: chords whose turn a smooth course could leave by 1.4e-5 rad."""
    changes = {
        "workspace": {},
        "drive.pitch": 0.3499433742966992,
        "drive.distance": 0.09131363417552142,
        "drive.pitch_about": "origin",
        "drive.start": (0.018498924409721774, 0.0016930600593658973, 0.0),
        "drive.yaw_rate": -0.031143473095525114,
        "drive.velocity": (-0.00010897494631501698, -0.00010080297919893037, 0.00020459901812223854),
        "run.duration": 23.517580531639254,
    }
    found = plan(load("nose-first/table1-row1").replaced(changes), load_cell())
    assert found.feasible
    with pytest.raises(InputError, match=r"course of a spline block .*leave --spline out"):
        programme_texts(found, accept_unbounded=True, spline=True, name="arc")
    assert "arc.src" in programme_texts(found, accept_unbounded=True, name="arc")
