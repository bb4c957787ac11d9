"""Figures of a plan: what they show, and that they reach their files."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from helimag.plots.robot import draw_cell, draw_joints, save_plan
from helimag.robot import load_cell, plan
from helimag.scenario import load

FOUND = plan(load("nose-first/fig3c").replaced({"run.duration": "500 s"}), load_cell("wide"))


def test_joint_figure_shows_angles_limits_and_the_offence():
    figure = draw_joints(FOUND)
    assert len(figure.axes) == 12
    sixth = figure.axes[10]
    angle = sixth.lines[0].get_ydata()
    assert angle == pytest.approx(np.degrees(FOUND.joints[:, 5]))
    low, high = sixth.get_ylim()
    assert low < -350.0
    assert high > angle.max()
    assert sixth.lines[-1].get_xdata()[0] == pytest.approx(FOUND.offence.time)
    assert "A6 would pass" in figure.get_suptitle()


def test_cell_figure_shows_the_path(tmp_path):
    figure = draw_cell(FOUND)
    close = figure.axes[1]
    path = max(close.lines, key=lambda line: len(line.get_data_3d()[0]))
    assert pytest.approx(1e3 * FOUND.path.at(FOUND.times).position) == np.array(path.get_data_3d()).T
    written = save_plan(FOUND, tmp_path / "lap.png")
    assert [path.name for path in written] == ["lap.png", "lap-cell.png"]
    assert all(path.stat().st_size > 20_000 for path in written)
