"""The studio without a browser: forces along a run, packets, knobs, state, and the run that is always the last."""

import csv
import io
import json
import re
import threading
import time

import matplotlib.pyplot as plt
import numpy as np
import pytest

import browser
import helimag as hm
from helimag.diagnosis import forces_along
from helimag.geometry import body_rotations
from helimag.orbits import explain

missing = browser.lacking()
if missing is not None:
    pytest.skip(missing, allow_module_level=True)

from helimag.plots._style import styled  # noqa: E402
from helimag.studio import server  # noqa: E402
from helimag.studio.answer import Stage  # noqa: E402
from helimag.studio.downloads import as_csv, file_name, zipped  # noqa: E402
from helimag.studio.jobs import Job  # noqa: E402
from helimag.studio.knobs import BY_PATH, CHOICES, DIRECTION, KNOBS, present  # noqa: E402
from helimag.studio.live import Live, beginning, leapt  # noqa: E402
from helimag.studio.mapping import NODES, STEPS, Axis2D, MapPlane, gain_cells  # noqa: E402
from helimag.studio.panels.tour import Side, stops  # noqa: E402
from helimag.studio.picture import overlaid, pictured  # noqa: E402
from helimag.studio.state import TabState  # noqa: E402

SHORT = hm.load("paper/fig3c").replaced({"run.duration": "60 s"})


@pytest.fixture(scope="module")
def run():
    return hm.simulate(SHORT)


def dipole(places, moment):
    """Flux density (T) at places seen from a dipole (A m^2), the textbook's."""
    r = np.linalg.norm(places, axis=-1, keepdims=True)
    along = places / r
    return 1e-7 * (3.0 * along * np.sum(along * moment, axis=-1, keepdims=True) - moment) / r**3


def turned(axis, start, phase):
    """A vector at right angles to an axis, turned about it."""
    return np.cos(phase) * start + np.sin(phase) * np.cross(axis, start)


def test_forces_along_a_run_are_those_of_a_dipole_by_differences(run):
    """Pull as the gradient of m B by differences, over a turn; thrust from the resistance; the axis from two fields."""
    drive, device = SHORT.drive, SHORT.device
    chosen = [0, 500, 1500]
    time, position = run.dataset["time"].values[chosen], run.dataset["position"].values[chosen]
    nose = body_rotations(run.dataset["quaternion"].values[chosen])[..., 0]
    found = forces_along(SHORT, time, position, nose)
    strength = 18.89
    coupling = hm.resistance(device, SHORT.fluid)[0, 3]
    for i, instant in enumerate(time):
        yaw = drive.yaw_rate * instant
        axis = np.array([np.cos(yaw) * np.cos(drive.pitch), np.sin(yaw) * np.cos(drive.pitch), np.sin(drive.pitch)])
        across = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
        away = position[i] - run.dataset["rpm_position"].values[chosen[i]]
        pull = np.zeros(3)
        for phase in np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False):
            moment = strength * turned(axis, across, phase)
            field = dipole(away, moment)
            own = device.magnetic_moment * field / np.linalg.norm(field)
            step = 1e-5 * np.eye(3)
            pull += (dipole(away + step, moment) - dipole(away - step, moment)) @ own / 2e-5 / 64
        assert found.pull[i] == pytest.approx(pull, rel=1e-6, abs=1e-12)
        about = np.cross(dipole(away, across), dipole(away, np.cross(axis, across)))
        assert found.field_axis[i] == pytest.approx(about / np.linalg.norm(about), abs=1e-9)
        rate = 2.0 * np.pi * drive.frequency * np.sign(about @ nose[i])
        assert found.thrust[i] == pytest.approx(-coupling * rate * nose[i], rel=1e-9)
    assert found.weight == pytest.approx(np.tile([0.0, 0.0, -51.6e-6], (3, 1)))


def unpacked(packet):
    """What a page reads: header and arrays, written apart from the code that packs."""
    length = int.from_bytes(packet[:4], "little")
    header, at, arrays = json.loads(packet[4 : 4 + length]), 4 + length, {}
    for name, shape in header["columns"].items():
        count = int(np.prod(shape))
        arrays[name] = np.frombuffer(packet, "<f4", count, at).reshape(shape)
        at += 4 * count
    assert at == len(packet)
    return header, arrays


def test_a_packet_holds_the_run(run):
    header, arrays = unpacked(pictured(run).packet)
    assert header["verdict"] == str(run.verdict)
    assert arrays["time"][-1] == 60.0
    last = 1e3 * run.dataset["position"].values[-1]
    assert arrays["position"][-1] == pytest.approx(last, rel=1e-6)
    assert arrays["gap"][0] == pytest.approx(150.0)
    # the magnet's moment, put together as the page does
    third = np.cross(arrays["axis"], arrays["across"])
    spin = arrays["spin"][:, None]
    moments = np.cos(spin) * arrays["across"] + np.sin(spin) * third
    some = np.isin(run.dataset["time"].values.astype("f4"), arrays["time"])
    assert moments == pytest.approx(run.dataset["rpm_moment"].values[some] / 18.89, abs=2e-6)
    wire = np.array(header["device"]["wire"])
    assert np.ptp(wire[:, 0]) == pytest.approx(11.7, abs=1e-3)
    _, other = unpacked(overlaid(run).packet)
    assert other["attack"][-1] == pytest.approx(np.degrees(run.dataset["attack_angle"].values[-1]), rel=1e-5)


@pytest.mark.parametrize("knob", KNOBS, ids=lambda knob: knob.path)
def test_a_knob_sets_what_it_shows(knob):
    scenario = hm.load("paper/table1-row1")
    value = round(0.6 * knob.low + 0.4 * knob.high, 6)
    assert knob.value(knob.changed(scenario, value)) == pytest.approx(value, rel=1e-12)
    with pytest.raises(hm.InputError):
        knob.changed(scenario, float("nan"))


def test_a_typed_value_is_that_of_a_file():
    """12.7 deg by hand is 12.7 deg in a file, to the last bit."""
    text = BY_PATH["drive.pitch"].changed(SHORT, 12.7)
    assert text.drive.pitch == hm.load("paper/fig3c").drive.pitch
    assert DIRECTION not in {knob.path for knob in present(SHORT)}  # there is no velocity to turn
    for choice in CHOICES:
        for word in choice.words:
            assert choice.value(choice.changed(SHORT, word)) == word
        with pytest.raises(hm.InputError):
            choice.changed(SHORT, "<script>")


def test_undo_and_redo():
    one = TabState.of(SHORT)
    two = one.shown(SHORT.replaced({"drive.frequency": 2.0})).committed(one.toml)
    three = two.shown(SHORT.replaced({"drive.frequency": 1.5})).committed(two.toml)
    assert three.undone().scenario.drive.frequency == 2.0
    assert three.undone().undone().toml == one.toml
    assert three.undone().redone() == three
    assert one.undone() == one
    assert three.redone() == three
    assert three.undone().shown(SHORT).committed(two.toml).future == ()
    assert TabState.stored(three.data) == three


def heard(ask, until=150.0):
    """News of a live run, until what becomes of the last question is known."""
    news, last, done = [], [0], threading.Event()

    def tell(given):
        news.append(given)
        if given.number == last[0] and (given.stage is Stage.AFTERWARDS or given.problem):
            done.set()

    live = Live(tell)
    try:
        last[0] = ask(live)
        if any(given.number == last[0] and given.stage is Stage.AFTERWARDS for given in news):
            done.set()
        assert done.wait(until)
    finally:
        live.close()
    return news, last[0]


def test_the_last_question_is_always_answered_and_none_is_replayed():
    pitches = np.linspace(0.1, 0.25, 40)

    def ask(live):
        for pitch in pitches:
            number = live.ask(SHORT.replaced({"drive.pitch": float(pitch)}))
            time.sleep(0.002)
        return number

    news, last = heard(ask)
    whole = hm.simulate(SHORT.replaced({"drive.pitch": float(pitches[-1])}))
    final = [given for given in news if given.number == last]
    assert final[-1].answer.gain == whole.gain
    assert final[-1].answer.outlook == explain(whole).text
    numbers = [given.number for given in news]
    assert numbers == sorted(numbers)
    assert len({given.number for given in news if given.stage is Stage.AFTERWARDS}) < len(pitches)


def test_a_run_that_nobody_waits_for_is_given_up():
    def ask(live):
        # with an arm that turns and moves sideways, nothing is leapt over: seconds of work
        held = {"workspace.contact": "hold", "workspace.floor": "-200 mm", "drive.velocity": (1e-6, 0.0, 0.0)}
        live.ask(SHORT.replaced({"run.duration": "300000 s", "run.interval": "100 s", **held}))
        time.sleep(0.3)
        return live.ask(SHORT)

    news, last = heard(ask)
    assert last == 2
    assert {given.number for given in news if given.stage is not Stage.FIRST} == {2}


LONG = SHORT.replaced({"run.duration": "1200 s"})


def test_a_long_run_is_first_answered_by_leaps():
    """All of it, close to the run itself."""
    first = leapt(LONG, lambda _: None)
    assert first.dataset["time"].values[-1] == 1200.0
    assert first.dataset.attrs["share_of_turns_leapt_over"] > 0.5
    assert first.gain == pytest.approx(hm.simulate(LONG).gain, rel=1e-4)


def test_the_whole_answer_is_of_the_run_itself():
    news, _ = heard(lambda live: live.ask(LONG))
    stages = [given.stage for given in news]
    assert stages == sorted(stages, key=list(Stage).index)  # a first answer that is late is not told
    assert stages[-2:] == [Stage.WHOLE, Stage.AFTERWARDS]
    assert news[-2].answer.gain == hm.simulate(LONG).gain


def test_a_run_that_slips_is_refined_when_the_hand_rests():
    """At once it has steps as sweeps have; then the numbers, and the picture, are those of the command."""
    slipping = SHORT.replaced({"drive.frequency": "5 Hz", "drive.distance": "170 mm"})
    news, _ = heard(lambda live: live.ask(slipping))
    assert [given.stage for given in news] == [Stage.WHOLE, Stage.WHOLE, Stage.AFTERWARDS]
    asked, finer = hm.simulate(slipping, refine=False), hm.simulate(slipping)
    assert [given.answer.gain for given in news] == [asked.gain, finer.gain, finer.gain]
    assert asked.gain != finer.gain
    assert news[1].picture.packet != news[0].picture.packet
    assert news[2].run is news[1].run
    assert news[2].answer.outlook == explain(finer).text


def test_a_run_that_leaps_gave_is_not_made_again(monkeypatch):
    made = []
    simulate = hm.simulate
    monkeypatch.setattr(
        "helimag.studio.live.simulate", lambda *given, **more: made.append(1) or simulate(*given, **more)
    )
    monkeypatch.setattr("helimag.studio.live.TEDIOUS", 1e9)  # however slow the machine is
    news, _ = heard(lambda live: live.ask(LONG))
    assert len(made) == 1
    assert [given.stage for given in news] == [Stage.WHOLE, Stage.AFTERWARDS]
    assert news[0].run is news[1].run
    news, _ = heard(lambda live: live.ask(SHORT))
    assert len(made) == 2
    assert [given.stage for given in news] == [Stage.WHOLE, Stage.AFTERWARDS]


def test_without_leaps_the_beginning_is_the_first_answer(monkeypatch):
    """Where the arm yaws and moves sideways; and where the device slips, so that leaps take as long as the run."""
    assert leapt(LONG.replaced({"drive.velocity": (1e-6, 0.0, 0.0)}), lambda _: None) is None
    monkeypatch.setattr("helimag.studio.live.TEDIOUS", -1.0)
    monkeypatch.setattr("helimag.engine.running.PATIENCE", 1e-4)  # so that it is looked at before it ends
    assert leapt(LONG, lambda _: None) is None
    assert beginning(LONG, lambda _: None).dataset["time"].values[-1] == pytest.approx(200.0)
    news, _ = heard(lambda live: live.ask(LONG))
    assert {given.stage for given in news} >= {Stage.WHOLE, Stage.AFTERWARDS}
    assert all(given.run.dataset["time"].values[-1] == 200.0 for given in news if given.stage is Stage.FIRST)


def test_the_outlook_waits_for_the_hand(monkeypatch):
    """What becomes of the device is not looked for while questions follow each other."""
    monkeypatch.setattr("helimag.studio.live.REST", 1.5)
    news, told = [], threading.Event()

    def tell(given):
        news.append(given)
        if given.stage is Stage.WHOLE:
            told.set()

    live = Live(tell)
    for pitch in (0.15, 0.16, 0.17):
        told.clear()
        live.ask(SHORT.replaced({"drive.pitch": pitch}))
        assert told.wait(60.0)
    live.close()
    assert [given.stage for given in news] == [Stage.WHOLE] * 3


def test_a_run_that_cannot_be_says_why_and_the_next_is_answered():
    bad = SHORT.replaced({"device.hydrodynamics.model": "matrix", "device.hydrodynamics.resistance": [[0.0] * 6] * 6})
    news, _ = heard(lambda live: live.ask(bad))
    assert news[-1].problem is not None
    assert "diagonal" in news[-1].problem


def test_an_error_that_nobody_foresaw_is_said_and_the_next_question_is_answered(monkeypatch, caplog):
    def broken(_):
        raise ZeroDivisionError("<script>")

    with monkeypatch.context() as patch:
        patch.setattr("helimag.studio.live.pictured", broken)
        news, _ = heard(lambda live: live.ask(SHORT))
        assert news[-1].problem.startswith("an error that was not foreseen (ZeroDivisionError)")
    assert "ZeroDivisionError: <script>" in caplog.text
    failed = []
    job = Job(Live(lambda _: None))
    job.start(broken, failed.append, failed.append)
    until = time.monotonic() + 10.0
    while not failed and time.monotonic() < until:
        time.sleep(0.01)
    assert failed == [news[-1].problem]


def test_a_job_waits_for_the_live_run_and_can_be_stopped():
    live = Live(lambda _: None)
    job, done, failed = Job(live), [], []
    begun = threading.Event()

    def work(progress):
        begun.set()
        for _ in range(2000):
            time.sleep(0.002)
            progress(0.5)

    job.start(work, done.append, failed.append)
    assert begun.wait(10.0)
    job.stop()
    job.start(lambda progress: progress(1.0) or "answer", done.append, failed.append)
    until = time.monotonic() + 10.0
    while not done and time.monotonic() < until:
        time.sleep(0.01)
    assert (done, failed) == (["answer"], [])
    live.close()


def test_a_map_covers_its_plane_once_and_its_cells_are_runs():
    quick = SHORT.replaced({"run.duration": "20 s"})
    frequency, pitch = (Axis2D.around(BY_PATH[path], quick, "near") for path in ("drive.frequency", "drive.pitch"))
    plane = MapPlane(quick, frequency, pitch)
    done = set()
    cells = [cell for part in gain_cells(plane, STEPS[0], done, lambda _: None) for cell in part]
    assert len(cells) == len(done) == len(range(0, NODES, STEPS[0])) ** 2
    x, y, _, _, gain, verdict, words, inside = cells[10]
    alone = hm.simulate(plane.at(x, y))
    assert (gain, verdict, inside) == (alone.gain, str(alone.verdict), alone.verdict.inside)
    assert words == f"{alone.verdict}, gain {alone.gain:.3f}"
    assert plane.holds_for(plane.at(x, y))
    assert not plane.holds_for(quick.replaced({"drive.distance": "151 mm"}))


def test_files_are_named_by_letters_alone(run):
    assert file_name("../../etc/passwd <script>") == "etc-passwd-script"
    assert file_name("///") == "run"
    assert zipped({"a": b"b"})[:2] == b"PK"
    assert as_csv(run).splitlines()[0].startswith(b"time [s],x [m]")


HOSTILE = [
    "../../x",
    "..\\..\\x",
    "a\r\nX-Header: b",
    'a"; filename="b.exe',
    "=cmd|' /C calc'!A0",
    "\u202egnp.exe",
    "%2e%2e%2f",
    "x" * 999,
]


@pytest.mark.parametrize("name", HOSTILE)
def test_no_name_gets_into_a_file_s_name_or_a_cell(name):
    """Of a scenario, which names every file that the studio gives."""
    assert re.fullmatch("[A-Za-z0-9-]{1,60}", file_name(name))
    odd = hm.simulate(SHORT.replaced({"name": "odd", "run.duration": "2 s"}))
    odd.dataset.attrs["name"] = name
    odd.dataset["gap"].attrs["units"] = name
    head, *rows = csv.reader(io.StringIO(as_csv(odd).decode(), newline=""))
    assert head[:4] == ["time [s]", "x [m]", "y [m]", "z [m]"]
    assert not any(cell.startswith(("=", "+", "@", "\t", "\r", "\n")) for cell in head)
    np.testing.assert_array_equal([float(row[2]) for row in rows], odd.dataset["position"].values[:, 1])
    assert min(float(row[3]) for row in rows) < 0.0  # negative numbers are numbers, and no formulas


def test_figures_that_two_tabs_ask_for_at_once_are_drawn_one_after_the_other():
    """Matplotlib has one style for all threads: drawn at once, each would be in parts of the other's."""
    before, inside, leave, order = dict(plt.rcParams), threading.Event(), threading.Event(), []

    def first():
        with styled("slide"):
            inside.set()
            leave.wait(60.0)
            order.append(plt.rcParams["font.size"])

    def second():
        with styled("small"):
            order.append(plt.rcParams["font.size"])

    threads = [threading.Thread(target=first), threading.Thread(target=second)]
    threads[0].start()
    assert inside.wait(60.0)
    threads[1].start()
    threads[1].join(0.2)  # it would be through by now
    leave.set()
    for thread in threads:
        thread.join(60.0)
    sizes = []
    for size in ("slide", "small"):
        with styled(size):
            sizes.append(plt.rcParams["font.size"])
    assert order == sizes
    assert sizes[0] != sizes[1]
    assert dict(plt.rcParams) == before


def test_a_port_that_cannot_be_is_refused():
    with pytest.raises(hm.InputError, match="--port 99999 cannot be used"):
        server.serve("paper/fig3c", port=99999, browser=False)


def test_the_tour_takes_two_minutes_and_moves_knobs_within_their_range():
    nothing = [lambda *_: None] * 7
    found = stops(Side(*nothing))
    assert sum(stop.seconds for stop in found) == pytest.approx(115.0, abs=10.0)
    for stop in found:
        if stop.knob:
            knob = BY_PATH[stop.knob]
            assert knob.low <= stop.to <= knob.high
        assert len(stop.words) < 110
