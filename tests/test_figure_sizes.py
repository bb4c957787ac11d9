"""Figures of every kind in every size: nothing is clipped, no words lie over other words, and the words are as large.

What is drawn is made by hand and computed by nobody; only how it is laid out counts here.
"""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from matplotlib.transforms import Bbox

import fits
import helimag as hm
from command_line import run as typed
from helimag import plots
from helimag.orbits import Basin, Branch, Change, FixedPoint, KnownMap, Orbit, OrbitStatus, SlowFlow, StabilityMap
from helimag.orbits.curves.branch import Event, Point
from helimag.outcomes import BasinEnd, Verdict
from helimag.robot import load_cell, plan, timed_table
from helimag.runs import Trajectory, compare
from helimag.sweeps import Axis
from helimag.vision import staged

SIZES = {"small": (88.0, None), "print": (180.0, None), "slide": (160.0, 90.0)}  # mm
WORDS = {"small": 7.0, "print": 7.0, "slide": 8.5}  # points, of an axis' label
# than the page, in print
NARROWER = dict.fromkeys(("sweep map", "sweep curve", "stability", "what a file holds"), 120.0)
MM = 1.0 / 25.4
GRID = np.linspace(-20e-3, 20e-3, 5)


@pytest.fixture(scope="module")
def scenario():
    return hm.load("paper/fig3c")


@pytest.fixture(scope="module")
def trajectory(scenario):
    """A run with all that can be drawn of one."""
    time = np.linspace(0.0, 1800.0, 181)
    turn = np.radians(1.8) * time
    level = np.zeros_like(time)
    values = {
        "position": 1e-3 * np.stack([20.0 * np.cos(turn), 20.0 * np.sin(turn), 20.0 - 20.0 * np.exp(-time / 300.0)], 1),
        "quaternion": np.stack([np.cos(turn / 2), level, level, np.sin(turn / 2)], axis=1),
        "rpm_position": 1e-3 * np.stack([60.0 * np.cos(turn), 60.0 * np.sin(turn), level + 150.0], axis=1),
        "gap": 0.14 + 0.01 * np.sin(turn),
        "attack_angle": -0.2 + 0.1 * np.sin(turn),
        "phase_lag": 0.5 + 0.2 * np.sin(turn),
        "slips": np.floor(time / 900.0),
    }
    more = {"name": "paper/fig3c", "initial_gap": 0.15, "end": "horizon", "scenario": scenario.to_toml()}
    return Trajectory.from_arrays(time, values, more)


def an_orbit(scenario, x=-12e-3, growth=-2e-3):
    rates = np.array([growth, -0.01 + 0.03j, -0.01 - 0.03j, -1.0, -2.0, -3.0], dtype=complex)
    state = np.array([x, -20e-3, 22e-3, 1.0, 0.0, 0.0, 0.0])
    return Orbit(
        scenario=scenario,
        status=OrbitStatus.FOUND,
        state=state,
        multipliers=np.exp(rates / 3.3),
        rates=rates,
        mean_position=state[:3],
    )


@pytest.fixture(scope="module")
def orbit(scenario):
    return an_orbit(scenario)


@pytest.fixture(scope="module")
def branch(scenario):
    values = np.radians(np.linspace(8.0, 16.0, 9))
    points = [
        Point(value, an_orbit(scenario, x=-0.05 * value, growth=0.1 * (value - 0.26)), np.zeros(7)) for value in values
    ]
    event = Event(Change.NEIMARK_SACKER, 0.26, an_orbit(scenario, x=-0.013, growth=0.0), 8)
    ends = ("edge", "edge")
    return Branch(path="drive.pitch", points=points, events=[event], ends=ends, origin=0, low=0.1, high=0.3)


def a_basin(orbit, shape=(4, 4, 4)):
    axes = [np.linspace(-18e-3, 18e-3, n) + middle for n, middle in zip(shape, orbit.position, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    words = [str(end) for end in BasinEnd]
    ends = np.array([words[i % len(words)] for i in range(len(places))])
    return Basin(orbit, shape, places, ends == words[0], ends, 1e-6, 1200.0, "averaged")


@pytest.fixture(scope="module")
def flow(scenario, orbit):
    axes = tuple(GRID + middle for middle in orbit.position)
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    velocity = -1e-2 * (places - orbit.position)
    states = np.concatenate([places, np.zeros((*places.shape[:3], 4))], axis=-1)
    settled = np.ones(places.shape[:3], dtype=bool)
    settled[0] = False
    return SlowFlow(scenario, axes, velocity, states, settled)


@pytest.fixture(scope="module")
def stability(scenario):
    values = np.radians(np.linspace(4.0, 20.0, 6)), np.linspace(2.0, 3.5, 5)
    growth = -1e-3 * np.exp(values[0][:, None] + values[1])
    paths = ("drive.pitch", "drive.frequency")
    return StabilityMap(scenario, paths, values, growth, growth, np.zeros((6, 5, 7)))


def swept(folder, *axes):
    """A sweep of runs that last a moment, with every verdict among them."""
    asked = hm.Plan(name="gain", base="paper/fig3c", duration="0.2 s", samples=20, axis=axes)
    data = hm.sweep(asked, out=folder / "s.zarr").load()
    known = [verdict.flag for verdict in Verdict if verdict != Verdict.NOT_COMPUTED]
    data["verdict"].values[:] = np.resize(known, data["verdict"].shape)
    data["gain"].values[:] = np.linspace(0.2, 1.8, data["gain"].size).reshape(data["gain"].shape)
    return data


PITCH = Axis(field="drive.pitch", start="2 deg", stop="24 deg", count=4)
FREQUENCY = Axis(field="drive.frequency", values=("2 Hz", "3 Hz"))
DISTANCE = Axis(field="drive.distance", values=("140 mm", "145 mm", "150 mm", "155 mm"))


@pytest.fixture(scope="module")
def sweeps(tmp_path_factory):
    asked = {"map": (FREQUENCY, PITCH), "curve": (PITCH,), "many": (DISTANCE, FREQUENCY, PITCH)}
    return {name: swept(tmp_path_factory.mktemp(name), *axes) for name, axes in asked.items()}


@pytest.fixture(scope="module")
def arm():
    return plan(hm.load("nose-first/fig3c").replaced({"run.duration": "500 s"}), load_cell("wide"))


def a_straight_run(number):
    time = np.linspace(0.0, 320.0, 65)
    height = -1e-5 * number * time
    return plots.StraightRun(
        title=f"{number}   6°, 102 mm, 0.5 mm/s",
        remark="surface (surface)\n16 of 16 perturbed\n|y| 31.50 mm (27.61)\nangle -6.0° (-6°)",
        time=time,
        height=height,
        perturbed=[(time, 1.1 * height)],
        measured=2e-3,
        floor=-31.5e-3,
        surface=1e-3,
    )


def cases(trajectory):
    remark = "gain at 1400 s: 0.920; paper 1.247\nperturbed: 32 attracted; gain 0.91 to 0.92"
    time, height = trajectory.dataset["time"].values, trajectory.dataset["position"].values[:, 2]
    return [
        plots.Case(
            trajectory=trajectory,
            title=f"{letter}   152 mm, 12.7°",
            remark=remark,
            perturbed=[(time, height)],
            published_time=1300.0,
        )
        for letter in "ABC"
    ]


def passes(data):
    return [plots.Passes(f, "pitch", data, data) for f in (2.0, 2.25, 2.5, 2.75, 3.0, 3.3)]


def measured_beside_simulated():
    simulated = staged("wobbling", duration=4.0)
    data = simulated.dataset
    values = {
        "position": data["position"].values[::3] + 1e-5,
        "position_covariance": np.broadcast_to(1e-10 * np.eye(3), (data["time"].values[::3].size, 3, 3)),
        "attack_angle": data["attack_angle"].values[::3],
    }
    named = {"name": "measured", "initial_gap": 0.102, "end": "horizon"}
    measured = Trajectory.from_arrays(data["time"].values[::3], values, named)
    return compare(measured, simulated, align="none")


DRAWN = {
    "run": lambda ask: plots.draw_run(ask("trajectory"), size=ask.size),
    "side by side": lambda ask: plots.draw_side_by_side(cases(ask("trajectory")), size=ask.size),
    "straight runs": lambda ask: plots.draw_straight_runs([a_straight_run(i) for i in range(1, 8)], size=ask.size),
    "orbits": lambda ask: plots.draw_orbits([ask("orbit"), an_orbit(ask("scenario"), growth=2e-3)], size=ask.size),
    "branches": lambda ask: plots.draw_branches([ask("branch")], size=ask.size),
    "stability": lambda ask: plots.draw_stability(ask("stability"), size=ask.size),
    "what a file holds": lambda ask: plots.draw_known(KnownMap(ask("stability"), []), size=ask.size),
    "flow": lambda ask: plots.draw_flow(
        ask("flow"),
        ask("orbit"),
        a_basin(ask("orbit")),
        fixed_points=[
            FixedPoint(ask("orbit").position, np.full(3, -1e-2, complex), 1e-3),
            FixedPoint(ask("orbit").position + 5e-3, np.full(3, 1e-2, complex), 1e-3),
        ],
        size=ask.size,
    ),
    "basin": lambda ask: plots.draw_basin(a_basin(ask("orbit")), size=ask.size),
    "sweep map": lambda ask: plots.draw_sweep(ask("sweeps")["map"], size=ask.size),
    "sweep curve": lambda ask: plots.draw_sweep(ask("sweeps")["curve"], size=ask.size),
    "sweep panels": lambda ask: plots.draw_sweep(ask("sweeps")["many"], size=ask.size),
    "passes": lambda ask: plots.draw_passes(passes(ask("sweeps")["curve"]), size=ask.size),
    "comparison": lambda ask: plots.draw_comparison(measured_beside_simulated(), size=ask.size),
    "joints": lambda ask: plots.draw_joints(ask("arm"), size=ask.size),
    "timed path": lambda ask: plots.draw_timed(timed_table(ask("arm")), "fig3c_path", size=ask.size),
    "cell": lambda ask: plots.draw_cell(ask("arm"), size=ask.size),
    "fit": lambda ask: plots.draw_fit(fits.fit_of(ask("scenario")), size=ask.size),
}


def test_every_function_that_draws_is_tried_here():
    drawing = {name for name in plots.__all__ if name.startswith("draw_")}
    text = str([function.__code__.co_names for function in DRAWN.values()])
    assert {name for name in drawing if name not in text} == set()


def drawn_words(figure):
    """Every text that is drawn, with its box (dots); of one that is aslant, none."""
    found = []
    draw = Text.draw

    def watched(self, renderer, *args, **kwargs):
        draw(self, renderer, *args, **kwargs)
        if self.get_visible() and self.get_text().strip():
            box = self.get_window_extent(renderer)
            lines = self.get_text().split("\n")
            empty = 0.0 if lines[0] else box.height / len(lines)  # room for a name that stands there
            found.append((self, Bbox.from_extents(box.x0, box.y0, box.x1, box.y1 - empty)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Text, "draw", watched)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    return found, np.asarray(canvas.buffer_rgba())[..., :3]


def overlapping(words):
    """Pairs of words whose boxes share more than what is empty above letters; of words aslant nothing is said."""
    straight = [(text.get_text(), box) for text, box in words if text.get_rotation() % 90 == 0]
    pairs = []
    for (one, a), (other, b) in combinations(straight, 2):
        shared = Bbox.intersection(a, b)
        if shared is not None and min(shared.width, shared.height) > 2.5:
            pairs.append((one, other))
    return pairs


@pytest.fixture(params=SIZES)
def size(request):
    return request.param


@pytest.mark.parametrize("kind", DRAWN)
def test_a_figure_in_a_size_has_its_words_apart_and_whole(kind, size, request):
    def ask(name):
        return request.getfixturevalue(name)

    ask.size = size
    figure = DRAWN[kind](ask)
    width, height = SIZES[size]
    if size == "print":
        width = NARROWER.get(kind, width)
    assert figure.get_figwidth() == pytest.approx(width * MM)
    assert height is None or figure.get_figheight() == pytest.approx(height * MM)
    words, picture = drawn_words(figure)
    assert len(words) > 8
    across, up = figure.bbox.size
    outside = [
        text.get_text()
        for text, box in words
        if min(box.x0, box.y0) < -0.5 or box.x1 > across + 0.5 or box.y1 > up + 0.5
    ]
    assert outside == []
    assert overlapping(words) == []
    edge = np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])
    assert edge.min() == 255, "something reaches over the edge"
    labels = [text.get_fontsize() for text, _ in words if text.get_text() in ("x (mm)", "time (s)", "pitch (deg)")]
    assert labels == [pytest.approx(WORDS[size])] * len(labels)


def test_another_size_is_refused(trajectory):
    with pytest.raises(hm.InputError, match="size must be one of small, print, slide; got 'large'"):
        plots.draw_run(trajectory, size="large")


def test_words_that_overlap_are_seen():
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2.0, 1.0))
    figure.text(0.1, 0.5, "one word")
    figure.text(0.15, 0.52, "another")
    figure.text(0.1, 0.1, "far away")
    words, _ = drawn_words(figure)
    assert overlapping(words) == [("one word", "another")]


def test_the_command_line_passes_the_size_on(trajectory, tmp_path, monkeypatch):
    from PIL import Image

    monkeypatch.chdir(tmp_path)
    trajectory.save(tmp_path / "run.nc")
    for size, (width, height) in SIZES.items():
        assert typed("plot", "run.nc", "-o", f"{size}.png", "--size", size).status == 0
        with Image.open(f"{size}.png") as picture:
            assert picture.width == pytest.approx(width * MM * 300, abs=1)
            assert height is None or picture.height == pytest.approx(height * MM * 300, abs=1)
    said = typed("plot", "run.nc", "-o", "run.mp4", "--size", "slide")
    assert (said.status, said.out) == (2, "")
    assert said.err == (
        "helimag: --size is for figures: --output must name one, .png, .svg, .pdf (a figure); or leave --size out\n"
    )
