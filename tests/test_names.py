"""Names follow content: what was changed is called by it, wherever a run is named; figures state the inputs."""

import pickle

import pytest

import helimag as hm
from helimag.outcomes import OrbitStatus
from helimag.plots import _quantities
from helimag.scenario import drive_inputs, parse

FIG3C = hm.load("nose-first/fig3c")


@pytest.mark.parametrize(
    ("changes", "title"),
    [
        ({}, "nose-first/fig3c"),
        ({"drive.pitch": "12.7 deg"}, "nose-first/fig3c"),
        ({"provenance": {}, "magnet.moment_uncertainty": "1 A m^2"}, "nose-first/fig3c"),
        ({"drive.pitch": "12 deg"}, "nose-first/fig3c, drive.pitch 12 deg"),
        ({"run.duration": 5.0}, "nose-first/fig3c, run.duration 5 s"),
        (
            {"drive.frequency": "2.5 Hz", "magnet.moment": "19 A m^2"},
            "nose-first/fig3c, magnet.moment 19 A m^2, drive.frequency 2.5 Hz",
        ),
        ({"drive.start": (1e-3, 0.0, 0.0)}, "nose-first/fig3c, drive.start (1 mm, 0 mm, 0 mm)"),
        ({"workspace.floor": "-50 mm"}, "nose-first/fig3c, workspace.floor -50 mm"),
        ({"device.helix.handedness": "right"}, "nose-first/fig3c, device.helix.handedness right"),
        ({"drive.pitch": "1 deg", "drive.frequency": "2 Hz", "run.duration": "3 s"}, "nose-first/fig3c, 3 changes"),
        ({"device.head": {"shape": "cylinder", "length": 1e-3, "diameter": 1e-3}}, "nose-first/fig3c, 4 changes"),
        ({"name": "mine", "drive.pitch": "1 deg"}, "mine"),
    ],
)
def test_a_changed_preset_says_what_was_changed(changes, title):
    changed = FIG3C.replaced(changes)
    assert changed.title == title
    assert changed.name == changes.get("name", "nose-first/fig3c")
    assert parse(changed.to_toml()) == changed  # what it was changed from is no part of it
    assert parse(changed.to_toml()).title == title
    assert pickle.loads(pickle.dumps(changed)).title == title
    assert (changed.hash == FIG3C.hash) == (title == "nose-first/fig3c")


@pytest.mark.parametrize(
    "name",
    [
        "Nose-First/Fig3c",
        " nose-first/fig3c ",
        "nose-first / fig3c",
        "nose-first/fig3c\u200b",
        "\uff4eose-first/fig3c",
        "nose-first/fig3c, run.duration 10 s",
    ],
)
def test_a_name_that_reads_like_a_preset_s_says_what_differs_from_that(name):
    """However it is spelt, and whatever it claims to have changed."""
    posing = FIG3C.replaced({"name": name, "drive.pitch": "15 deg"})
    assert posing.title == "nose-first/fig3c, drive.pitch 15 deg"
    assert parse(posing.to_toml()).title == posing.title
    assert FIG3C.replaced({"name": name}).title == "nose-first/fig3c"
    assert (
        FIG3C.replaced({"name": "nose-first/fig3c slower", "drive.pitch": "15 deg"}).title == "nose-first/fig3c slower"
    )


def test_changes_back_and_of_ones_own_scenario():
    assert FIG3C.replaced({"drive.pitch": "15 deg"}).replaced({"drive.pitch": "12.7 deg"}).title == "nose-first/fig3c"
    mine = parse(FIG3C.to_toml().replace('"nose-first/fig3c"', '"mine"'))
    assert mine.title == "mine"
    assert mine.replaced({"drive.pitch": "15 deg"}).title == "mine, drive.pitch 15 deg"
    edited = parse(FIG3C.to_toml().replace('"12.7 deg"', '"11 deg"'))
    assert edited.title == "nose-first/fig3c, drive.pitch 11 deg"
    assert edited.replaced({"run.duration": "9 s"}).title == "nose-first/fig3c, drive.pitch 11 deg, run.duration 9 s"


def test_a_change_too_small_to_see_is_told_in_full():
    tiny = FIG3C.replaced({"drive.pitch": FIG3C.drive.pitch * (1.0 + 1e-12)})
    assert tiny.title.startswith("nose-first/fig3c, drive.pitch 12.70000000001")


def test_runs_are_named_by_their_content_everywhere(helimag, tmp_path):
    words = ("nose-first/fig3c", "--set", "drive.pitch=12 deg", "--duration", "2 s", "--no-orbit")
    title = "nose-first/fig3c, drive.pitch 12 deg, run.duration 2 s"
    assert helimag("simulate", *words, "-o", tmp_path / "a.nc").out.startswith(f"{title}: ")
    run = hm.Trajectory.load(tmp_path / "a.nc")
    assert run.dataset.attrs["name"] == title
    assert repr(run).startswith(f"<Trajectory {title}: ")
    assert parse(run.scenario_toml).name == "nose-first/fig3c"
    shown = _quantities.shown(run)
    assert shown.name == title
    assert drive_inputs(shown.scenario) == "frequency 3.3 Hz, pitch 12 deg, distance 150 mm, yaw rate 1.8 deg/s"


def test_a_figure_states_the_inputs():
    from helimag.plots import draw_run

    straight = hm.load("nose-first/table1-row1")
    figure = draw_run(hm.simulate(straight, duration=1.0))
    texts = [text.get_text() for text in figure.texts]
    assert "nose-first/table1-row1, run.duration 1 s" in texts
    assert any("pitch 13 deg, distance 102 mm, yaw rate 0 deg/s, speed 0.825 mm/s" in text for text in texts)


@pytest.mark.parametrize("name", ["a\nb", "a\r", "\x1b[31mred", "a\u2028b", "tab\there", "\x00", "\ud800"])
def test_a_name_is_one_line(name):
    """It is printed, drawn, and written into programmes."""
    with pytest.raises(hm.InputError, match="name must be one line without control characters; got '") as caught:
        FIG3C.replaced({"name": name})
    assert str(caught.value).isprintable()


def test_objects_show_themselves_shortly_and_without_markup():
    """In a terminal a line, in a notebook a table; a name is text, whatever it holds."""
    scenario = hm.load("nose-first/fig3c").replaced({"name": "<script>alert(1)</script>", "drive.pitch": "12 deg"})
    assert repr(scenario).startswith("<Scenario <script>alert(1)</script>: frequency 3.3 Hz, pitch 12 deg")
    run = hm.simulate(scenario, duration=30.0)
    for thing in (scenario, run, hm.Orbit(scenario=scenario, status=OrbitStatus.NO_ORBIT)):
        page = thing._repr_html_()
        assert "<script>" not in page
        assert "&lt;script&gt;" in page
    assert f"{run.gain:.3f}" in run._repr_html_()
    assert "pitch 12 deg" in scenario._repr_html_()
