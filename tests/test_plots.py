"""Figures and films: they show what the run holds, are whole or absent, and refuse what they cannot write."""

import subprocess
import sys

import av
import matplotlib as mpl
import numpy as np
import pytest

import helimag as hm
from helimag import plots
from helimag.errors import FileError, InputError
from helimag.plots import _film, _quantities, _shapes
from helimag.runs.trajectory import Trajectory

MAGIC = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


@pytest.fixture(scope="module")
def run():
    return hm.simulate(hm.load("nose-first/fig3c"), duration=60.0, interval=0.5)


@pytest.fixture(scope="module")
def measured():
    """A run as cameras see it: positions and attack angles, nothing about the magnet, a frame without the device."""
    time = np.linspace(0.0, 20.0, 201)
    position = np.stack([1e-3 * time, np.zeros_like(time), 1e-3 * np.sin(time)], axis=1)
    position[50] = np.nan
    attack = np.full_like(time, -0.1)
    return Trajectory.from_arrays(
        time, {"position": position, "attack_angle": attack}, {"name": "measured", "initial_gap": 0.1, "end": "horizon"}
    )


@pytest.fixture(scope="module")
def falling():
    """A run whose box is much taller than wide."""
    time = np.linspace(0.0, 1000.0, 101)
    zero = np.zeros_like(time)
    rpm = 0.06 * np.stack([np.cos(time / 30.0), np.sin(time / 30.0), zero + 2.5], axis=1)
    values = {"position": np.stack([zero, zero, -3e-4 * time], axis=1), "rpm_position": rpm}
    return Trajectory.from_arrays(time, values, {"name": "falling", "initial_gap": 0.15, "end": "fall"})


def panels(figure):
    """Axes over time, by the first line of their label."""
    return {
        axes.get_ylabel().replace("\n", " "): axes
        for axes in figure.findobj(mpl.axes.Axes)
        if axes.name == "rectilinear" and axes.get_ylabel()
    }


def test_run_shows_every_series_in_the_units_of_its_labels(run):
    shown = panels(plots.draw_run(run))
    data = run.dataset
    assert list(shown) == ["height z (mm)", "gap (mm)", "attack angle (deg)", "phase lag (deg)"]
    drawn = {name: np.asarray(axes.lines[0].get_ydata()) for name, axes in shown.items()}
    np.testing.assert_allclose(drawn["height z (mm)"], 1e3 * data.position.values[:, 2])
    np.testing.assert_allclose(drawn["gap (mm)"], 1e3 * data.gap.values)
    np.testing.assert_allclose(drawn["attack angle (deg)"], np.degrees(data.attack_mean.values))
    np.testing.assert_allclose(drawn["phase lag (deg)"], np.degrees(data.phase_lag.values))


def test_title_has_verdict_and_gain_in_words(run):
    words = " ".join(" ".join(text.get_text() for text in plots.draw_run(run).findobj(mpl.text.Text)).split())
    assert run.judgement.reason in words
    assert f"= {run.gain:.3f}" in words


@pytest.mark.parametrize("kind", ["run", "measured", "falling"])
def test_no_words_reach_over_the_edge_or_the_colour_bar(request, kind):
    figure = plots.draw_run(request.getfixturevalue(kind))
    figure.draw_without_rendering()
    width, height = figure.bbox.size
    parts = [*figure.findobj(mpl.axes.Axes), *figure.findobj(mpl.legend.Legend), *figure.texts]
    assert len(parts) > 5
    for part in parts:
        box = part.get_tightbbox()
        assert min(box.x0, box.y0) > -1.0, part
        assert box.x1 < width + 1.0, part
        assert box.y1 < height + 1.0, part
    (path,) = (axes for axes in parts if getattr(axes, "name", "") == "3d")
    (bar,) = (axes for axes in parts if getattr(axes, "get_xlabel", str)() == "time (s)" and not axes.get_ylabel())
    for label in (path.xaxis.label, path.yaxis.label):
        assert label.get_window_extent().y0 > bar.get_window_extent().y1, label


def test_no_words_of_runs_side_by_side_reach_over_the_edge(run, falling):
    figure = plots.draw_side_by_side([plots.Case(trajectory=each, title="a run") for each in (run, falling, run)])
    figure.draw_without_rendering()
    width, height = figure.bbox.size
    paths = [axes for axes in figure.axes if axes.name == "3d"]
    assert len(paths) == 3
    labels = [axis.label for axes in paths for axis in (axes.xaxis, axes.yaxis, axes.zaxis)]
    for part in [*labels, *figure.texts, *figure.legends, *(axes for axes in figure.axes if axes.name != "3d")]:
        box = part.get_tightbbox()
        assert min(box.x0, box.y0) > -1.0, part
        assert box.x1 < width + 1.0, part
        assert box.y1 < height + 1.0, part


def test_measured_run_is_drawn_without_a_magnet(measured, tmp_path):
    figure = plots.draw_run(measured)
    assert list(panels(figure)) == ["height z (mm)", "attack angle (deg)"]
    words = " ".join(text.get_text() for text in figure.findobj(mpl.text.Text))
    assert "no verdict" in words
    assert "slips" not in words
    assert "magnet" not in words
    plots.save(figure, tmp_path / "measured.png")


def test_run_without_a_position_is_refused(measured):
    blind = Trajectory(measured.dataset.assign(position=measured.dataset.position * np.nan))
    for few in (blind, Trajectory(measured.dataset.isel(time=[0]))):
        with pytest.raises(InputError, match="at least two samples with a finite position"):
            plots.draw_run(few)


def test_lag_is_left_out_while_the_device_slips(run):
    count = run.dataset.sizes["time"]
    slips = np.zeros(count)
    slips[40:] += 1.0
    slips[42:] += 1.0
    slips[100:] += 1.0
    shown = _quantities.shown(Trajectory(run.dataset.assign(slips=("time", slips))))
    assert _quantities.slipping_spans(shown) == [(19.5, 21.0), (49.5, 50.0)]
    hidden = np.flatnonzero(np.isnan(_quantities.lag_in_step(shown)))
    np.testing.assert_array_equal(hidden, [40, 41, 42, 100])


@pytest.mark.parametrize("suffix", MAGIC)
def test_figure_is_written_whole(run, tmp_path, suffix):
    target = tmp_path / f"run{suffix}"
    plots.save(plots.draw_run(run), target)
    assert target.read_bytes().startswith(MAGIC[suffix])
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("name", ["run.jpg", "run", "run.png.txt"])
def test_other_suffix_is_refused(run, tmp_path, name):
    with pytest.raises(InputError, match=r"must end in \.png, \.svg, \.pdf; got"):
        plots.save(plots.draw_run(run), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_failed_save_leaves_the_old_file_and_no_other(tmp_path):
    class Broken:
        def savefig(self, path, **_):
            path.write_bytes(b"half")
            raise OSError(28, "No space left on device")

    old = tmp_path / "run.png"
    old.write_bytes(b"old")
    with pytest.raises(FileError, match="No space left"):
        plots.save(Broken(), old)
    assert old.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [old]
    with pytest.raises(FileError, match="cannot be written"):
        plots.save(Broken(), tmp_path / "absent" / "run.png")
    folder = tmp_path / "folder.png"
    folder.mkdir()
    with pytest.raises(FileError, match="is a directory"):
        plots.save(Broken(), folder)


def test_style_of_the_caller_is_left_alone(run):
    with mpl.rc_context({"font.size": 23.0}):
        plots.draw_run(run)
        assert mpl.rcParams["font.size"] == 23.0


def decoded(path):
    with av.open(str(path)) as film:
        assert film.streams.video[0].codec_context.name == "h264"
        return [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]


def test_film_has_its_frames_and_they_show_the_run(run, tmp_path, monkeypatch):
    monkeypatch.setattr(_film, "SECONDS", 0.8)
    done = []
    plots.animate(run, tmp_path / "run.mp4", progress=done.append)
    frames = decoded(tmp_path / "run.mp4")
    assert len(frames) == 20
    assert done[-1] == 1.0
    assert done == sorted(done)
    assert list(tmp_path.iterdir()) == [tmp_path / "run.mp4"]
    first, last = (frame.astype(float) for frame in (frames[0], frames[-1]))
    assert first.std() > 10.0
    changed = np.abs(first - last).max(axis=2) > 60.0
    assert changed[:, : _film.WIDTH // 2].sum() > 300  # magnet and device
    assert changed[_film.HEIGHT // 2 :, _film.WIDTH // 2 :].sum() > 30  # height


def test_film_of_a_measured_run(measured, tmp_path, monkeypatch):
    monkeypatch.setattr(_film, "SECONDS", 0.2)
    plots.animate(measured, tmp_path / "measured.mp4")
    assert len(decoded(tmp_path / "measured.mp4")) == 5


def test_film_with_another_suffix_is_refused(run, tmp_path):
    with pytest.raises(InputError, match=r"must end in \.mp4"):
        plots.animate(run, tmp_path / "run.gif")
    assert not list(tmp_path.iterdir())


def test_film_shows_the_magnet_as_under_a_stroboscope():
    fine = hm.simulate(hm.load("nose-first/fig3c"), duration=120.0, interval=0.04)
    shown = _quantities.shown(fine)
    chosen = _film.chosen_samples(shown, 300)
    assert _film.strobed(shown)
    assert "stroboscope" in _film.remark(shown)
    assert chosen.size == 300
    assert chosen[-1] == shown.time.size - 1
    assert np.all(np.diff(chosen) > 0)
    turns = 3.3 * shown.time[chosen[:-1]] - _film.SLOW_TURNS * np.arange(299) / _film.FRAMES_PER_SECOND
    off = np.abs(np.mod(turns + 0.5, 1.0) - 0.5)
    assert np.quantile(off, 0.95) < 0.07  # samples are 0.132 turns apart, chosen blindly they would be off by up to 0.5


def test_short_run_fills_the_film_by_holding_samples():
    brief = _quantities.shown(hm.simulate(hm.load("nose-first/fig3c"), duration=1.0, interval=0.1))
    chosen = _film.chosen_samples(brief, 300)
    assert chosen.size == 300
    assert set(chosen) == set(range(11))
    assert not _film.strobed(brief)


def test_shapes_have_the_sizes_and_turns_of_the_scenario():
    scenario = hm.load("nose-first/fig3c")
    line = _shapes.helix_line(scenario.device)
    helix = scenario.device.helix
    np.testing.assert_allclose(np.hypot(line[:, 1], line[:, 2]), helix.outer_diameter / 2.0 - helix.wire_radius)
    assert np.isclose(line[0, 0] - line[-1, 0], 11.7e-3)
    # left-handed: going along +x, the wire turns clockwise seen from behind, so its angle falls
    angle = np.unwrap(np.arctan2(line[::-1, 2], line[::-1, 1]))
    assert np.isclose(angle[-1] - angle[0], -2.0 * np.pi * 11.7 / 2.59)
    ball = np.concatenate(_shapes.head_faces(scenario.device))
    np.testing.assert_allclose(np.linalg.norm(ball, axis=1), scenario.device.head.radius)
    faces, north = _shapes.cylinder_faces(scenario.magnet[0])
    assert np.isclose(max(np.linalg.norm(face, axis=1).max() for face in faces), np.hypot(17.5e-3, 10e-3))
    assert all((face[:, 2].mean() > 0.0) == up for face, up in zip(faces, north, strict=True))


def test_a_magnet_is_turned_to_its_moment():
    for direction in (np.array([0.6, 0.0, -0.8]), np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])):
        turn = _shapes.axis_rotation(direction)
        np.testing.assert_allclose(turn[:, 2], direction, atol=1e-15)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)
        assert np.isclose(np.linalg.det(turn), 1.0)


def test_without_matplotlib_the_extra_is_named():
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from helimag.errors import MissingExtra\n"
        "try:\n    import helimag.plots\nexcept MissingExtra as error:\n    print(error)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert 'python -m pip install ".[plots]"' in said
