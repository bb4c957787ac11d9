"""Figures of sweeps: what is drawn is what was computed; interactive pages stand alone."""

import re

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import helimag
from helimag import Plan
from helimag.outcomes import Verdict
from helimag.plots import draw_sweep, interactive_sweep, save_html
from helimag.plots.sweeps import COLOURS, border_of, heading
from helimag.sweeps import Axis, Sampling

PITCH = Axis(field="drive.pitch", start="4 deg", stop="16 deg", count=5)
FREQUENCY = Axis(field="drive.frequency", values=("2 Hz", "3 Hz"))


def made(folder, *axes, **more):
    plan = Plan(base="nose-first/fig3c", duration="30 s", samples=20, axis=axes, **more)
    return helimag.sweep(plan, out=folder / "s.zarr")


MODELS = Axis(field="device.hydrodynamics.model", values=("lighthill", "gray-hancock"))


def test_curves_show_the_gains_by_a_word_in_degrees(tmp_path):
    data = made(tmp_path, MODELS, PITCH)
    (axes,) = draw_sweep(data).axes
    curves = [line for line in axes.lines if not line.get_label().startswith("_")]
    assert [line.get_label() for line in curves] == ["lighthill", "gray-hancock"]
    for line, row in zip(curves, data["gain"].values, strict=True):
        np.testing.assert_allclose(line.get_xdata(), np.linspace(4.0, 16.0, 5), rtol=1e-12)
        np.testing.assert_array_equal(line.get_ydata(), row)
    assert axes.get_xlabel() == "pitch (deg)"
    assert any(np.all(np.asarray(line.get_ydata()) == 1.0) for line in axes.lines)


def test_runs_of_different_verdicts_are_not_joined(tmp_path):
    data = made(tmp_path, PITCH).load()
    data["verdict"].values[:] = [Verdict.FELL.flag] * 2 + [Verdict.BOUNDED.flag] * 3
    (axes,) = draw_sweep(data).axes
    pitch = np.linspace(4.0, 16.0, 5)
    joined = [line.get_xdata() for line in axes.lines if np.isin(line.get_xdata(), pitch).all()]
    assert [len(part) for part in joined] == [2, 3]
    page = [trace for trace in interactive_sweep(data).data if trace.mode == "lines"]
    assert [len(trace.x) for trace in page] == [2, 3]


def test_two_values_of_the_first_axis_are_a_map_with_its_lines_named(tmp_path):
    data = made(tmp_path, FREQUENCY, PITCH).load()
    data["verdict"].values[:] = Verdict.FELL.flag
    data["verdict"].values[1, 2:4] = Verdict.BOUNDED.flag
    data["gain"].values[:] = np.where(data["verdict"].values == Verdict.BOUNDED.flag, 0.5, 1.5)
    figure = draw_sweep(data)
    (axes,) = figure.axes
    assert axes.collections[0].get_array().shape[:2] == (5, 2)
    (legend,) = figure.legends
    named = [text.get_text() for text in legend.get_texts()]
    assert named == ["bounded", "fell", "edge of bounded runs", "gain 1"]
    title = figure.get_suptitle()
    assert "nose-first/fig3c" in title
    assert "distance 150 mm" in title
    assert "pitch" not in title.splitlines()[1]


def test_a_plan_called_as_its_scenario_is_named_once(tmp_path):
    data = made(tmp_path, PITCH).load()
    base = helimag.load("nose-first/fig3c").replaced({"run.duration": "30 s"})
    assert heading(data).splitlines()[0] == f"sweep: {base.title}"
    assert heading(data.assign_attrs(title=base.title)).splitlines()[0] == base.title


def test_the_border_runs_along_the_sides_of_cells():
    inside = np.zeros((4, 3), dtype=bool)
    inside[1:3, 1] = True
    edges = border_of(np.array([0.0, 1.0, 2.0]), np.array([0.0, 2.0, 4.0, 6.0]), inside)
    assert np.all((edges[:, 0] == edges[:, 1]).any(axis=1)), "no slope"
    assert np.abs(edges[:, 1] - edges[:, 0]).sum() == 2 * (1.0 + 4.0), "once around a cell of 1 by two of 2"
    assert edges.reshape(-1, 2).min(axis=0).tolist() == [0.5, 1.0]
    assert edges.reshape(-1, 2).max(axis=0).tolist() == [1.5, 5.0]


def test_a_page_shows_the_map_as_the_figure_does_with_gain_and_border_on_hovering(tmp_path):
    data = made(tmp_path, FREQUENCY, PITCH).load()
    data["verdict"].values[:] = Verdict.FELL.flag
    data["verdict"].values[1, 2:4] = Verdict.BOUNDED.flag
    figure = interactive_sweep(data)
    (cells,) = (trace for trace in figure.data if trace.type == "heatmap")
    assert np.array_equal(np.array(cells.z), data["verdict"].values.T)
    for flag in (Verdict.FELL.flag, Verdict.BOUNDED.flag):
        at = (flag + 0.5) / (cells.zmax + 0.5)
        below = [colour for level, colour in cells.colorscale if level < at][-1]
        assert below == COLOURS[Verdict.of(flag)]
    assert "pitch (deg): 10" in cells.text[2][1]
    assert "gain " in cells.text[2][1]
    (border,) = (trace for trace in figure.data if trace.name == "edge of bounded runs")
    assert border.hovertemplate.startswith("edge of bounded runs<br>frequency (Hz): %{x")


def test_maps_colour_each_run_by_its_verdict_and_draw_the_boundary(tmp_path):
    fast = Axis(field="drive.frequency", start="2 Hz", stop="3 Hz", count=9)
    data = made(tmp_path, fast, PITCH).load()
    flags = np.full((9, 5), Verdict.FELL.flag, np.int8)
    flags[2:5, 1:4] = Verdict.BOUNDED.flag
    data["verdict"].values[:] = flags
    (axes,) = draw_sweep(data).axes
    mesh, *contours = axes.collections
    cells = np.asarray(mesh.get_array())
    assert mesh.get_alpha() is None
    for outcome in (Verdict.FELL, Verdict.BOUNDED):
        colour = [int(COLOURS[outcome][i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
        painted = np.all(np.isclose(cells[..., :3], colour), axis=-1)
        assert np.array_equal(painted, outcome == flags.T)
    border = np.concatenate([path.vertices for path in contours[1].get_paths()])
    low, high = border.min(axis=0), border.max(axis=0)
    np.testing.assert_allclose(
        low, [2.0 + 1.5 / 8, 5.5], atol=1e-9
    )  # halfway from the last outside to the first inside
    np.testing.assert_allclose(high, [2.0 + 4.5 / 8, 14.5], atol=1e-9)


def test_a_map_has_the_colours_of_its_legend(tmp_path):
    """On the pixels: what the legend calls bounded is the colour of the bounded half, and so for the half that fell."""
    fast = Axis(field="drive.frequency", start="2 Hz", stop="3 Hz", count=9)
    data = made(tmp_path, fast, PITCH).load()
    flags = np.full((9, 5), Verdict.FELL.flag, np.int8)
    flags[:4] = Verdict.BOUNDED.flag
    data["verdict"].values[:] = flags
    figure = draw_sweep(data)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[::-1, :, :3]
    (axes,) = figure.axes
    (legend,) = figure.legends
    shown = {text.get_text(): patch for text, patch in zip(legend.get_texts(), legend.get_patches(), strict=False)}
    for verdict, frequency in ((Verdict.BOUNDED, 2.1), (Verdict.FELL, 2.9)):
        x, y = axes.transData.transform((frequency, 10.0)).astype(int)
        box = shown[str(verdict)].get_window_extent()
        key = pixels[round((box.y0 + box.y1) / 2), round((box.x0 + box.x1) / 2)]
        assert tuple(pixels[y, x]) == tuple(key)
        assert tuple(key) == tuple(int(COLOURS[verdict][i : i + 2], 16) for i in (1, 3, 5))


def test_three_axes_make_small_multiples(tmp_path):
    data = made(tmp_path, Axis(field="drive.distance", values=("140 mm", "150 mm")), FREQUENCY, PITCH)
    assert [axes.get_title() for axes in draw_sweep(data).axes] == ["distance 140 mm", "distance 150 mm"]


def test_interactive_pages_hold_every_run_and_need_nothing_from_elsewhere(tmp_path):
    spread = [
        Axis(field="drive.frequency", start="2 Hz", stop="3 Hz"),
        Axis(field="drive.pitch", start="4 deg", stop="16 deg"),
    ]
    data = made(tmp_path, *spread, sample=Sampling(method="sobol", count=16))
    figure = interactive_sweep(data)
    points = np.concatenate([np.stack([trace.x, trace.y], axis=1) for trace in figure.data if trace.text is not None])
    wanted = np.stack([data["frequency"].values, np.degrees(data["pitch"].values)], axis=1)
    np.testing.assert_allclose(points[np.argsort(points[:, 0])], wanted[np.argsort(wanted[:, 0])], rtol=1e-12)
    save_html(figure, tmp_path / "s.html")
    text = (tmp_path / "s.html").read_text(encoding="utf-8")
    assert not re.search(r"<(script|link)[^>]+(src|href)=", text)
    assert "undecided" in text
    curves = interactive_sweep(made(tmp_path / "2", MODELS, PITCH))
    assert sum(len(trace.x) for trace in curves.data if trace.text is not None) == 10


def test_interactive_page_of_three_axes_has_a_panel_for_each_value_of_the_first(tmp_path):
    distance = Axis(field="drive.distance", values=("148 mm", "150 mm"))
    data = made(tmp_path, distance, FREQUENCY, PITCH)
    figure = interactive_sweep(data)
    titles = [note.text for note in figure.layout.annotations]
    assert [title for title in titles if "148" in title or "150" in title] == titles[:2]
    drawn = {}
    for trace in figure.data:
        if trace.type == "heatmap":
            drawn[trace.xaxis] = np.size(trace.z)
    assert list(drawn.values()) == [10, 10]
    named = [trace.name for trace in figure.data if trace.showlegend]
    assert len(named) == len(set(named))


def test_nothing_to_draw_is_said(tmp_path):
    data = made(tmp_path, PITCH).load()
    data["verdict"].values[:] = Verdict.NOT_COMPUTED.flag
    for draw in (draw_sweep, interactive_sweep):
        with pytest.raises(ValueError, match="nothing to draw"):
            draw(data)
