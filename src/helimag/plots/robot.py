"""Figures of a plan for the arm: joints with their limits over time, and the cell in 3-D."""

import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from helimag.plots._save import save
from helimag.plots._style import BLUE, GREY, MM, ORANGE, PALE, SKY, VERMILLION, Size, head, styled
from helimag.robot import ArmPlan, TimedPath, capsules, joint_rates, timed_table
from helimag.scenario import drive_inputs

Floats = NDArray[np.float64]

PARTS = {
    "column": GREY,
    "upper arm": GREY,
    "forearm": GREY,
    "wrist": GREY,
    "bracket": ORANGE,
    "motor": ORANGE,
    "magnet": VERMILLION,
}
CLOSE = 0.16  # m; half the width of the view around the magnet


def save_plan(plan: ArmPlan, path: str | Path, *, size: Size = "print") -> list[Path]:
    """Write both figures: joints to ``path``, the cell beside it with ``-cell`` in its name.

    Returns
    -------
    list of Path
        Both.

    Raises
    ------
    InputError
        Where the suffix is not .png, .svg or .pdf.
    FileError
        Where a file cannot be written.
    """
    joints = Path(path)
    cell = joints.with_stem(f"{joints.stem}-cell")
    save(draw_joints(plan, size=size), joints)
    save(draw_cell(plan, size=size), cell)
    return [joints, cell]


def draw_joints(plan: ArmPlan, *, size: Size = "print") -> Figure:
    """Angle and speed of each joint over programme time, with what the cell allows; the first offence is marked.

    Returns
    -------
    matplotlib.figure.Figure
        88, 180 or 160 mm wide, as ``size`` is "small", "print" or "slide".
    """
    table, arm = timed_table(plan), plan.cell.arm
    low, high = np.degrees(arm.limits)
    allowed = plan.cell.speed_share * np.degrees(arm.joint_speed)
    offence = "" if plan.offence is None else f": {plan.offence}"
    title = f"{plan.scenario.title}, {arm.name}{offence}\n{drive_inputs(plan.scenario)}"
    figure = _joint_figure(table.time, table.joints, title, limits=(low, high, allowed), size=size)
    for axes in figure.axes:
        if plan.offence is not None:
            axes.axvline(plan.offence.time, color=VERMILLION, linewidth=0.8)
    return figure


def draw_timed(path: TimedPath, title: str, *, size: Size = "print") -> Figure:
    """Angle and speed of each joint over programme time, of a timed path that was written; limits are the cell's.

    Returns
    -------
    matplotlib.figure.Figure
        88, 180 or 160 mm wide, as ``size`` is "small", "print" or "slide".
    """
    return _joint_figure(path.time, path.joints, title, limits=None, size=size)


def _joint_figure(
    time: Floats, joints: Floats, title: str, *, limits: tuple[Floats, Floats, Floats] | None, size: Size
) -> Figure:
    """A row a joint; ``limits`` are lowest and highest angles (deg) and speeds that are allowed (deg/s)."""
    angles = np.degrees(joints)
    speeds = np.degrees(joint_rates(time, joints)) if time.size > 2 else np.zeros_like(angles)
    with styled(size) as sheet:
        figure = sheet.figure(189.0 * MM)
        panels: Any = figure.subplots(3, 4, sharex=True) if sheet.wide else figure.subplots(6, 2, sharex=True)
        bottom = panels[-1]
        if sheet.wide:  # joints 4 to 6 beside 1 to 3
            panels = np.concatenate([panels[:, :2], panels[:, 2:]])
        for i in range(6):
            _draw_angle(panels[i, 0], time, angles[:, i], None if limits is None else (limits[0][i], limits[1][i]))
            _draw_speed(panels[i, 1], time, speeds[:, i], None if limits is None else limits[2][i])
            panels[i, 0].set_ylabel(f"A{i + 1} (deg)")
        beyond = ("", "") if limits is None else ("beyond the arm's limits", "more than the cell allows")
        in_titles = limits is not None and size == "print"
        for top in (0, 3) if sheet.wide else (0,):
            for axes, what, over in zip(panels[top], ("angle", "speed"), beyond, strict=True):
                axes.set_title(f"{what}; shaded: {over}" if in_titles else what)
        if limits is not None and not in_titles:
            title += f"\nshaded: {beyond[0]}; {beyond[1]}"
        for axes in bottom:
            axes.set_xlabel("time (s)")
        head(figure, title, fontsize=sheet.points(8.0))
    return figure


def _draw_angle(axes: Any, time: Floats, angle: Floats, limits: tuple[float, float] | None) -> None:
    axes.plot(time, angle, color=BLUE)
    axes.margins(x=0.0)
    if limits is None:
        return
    low, high = limits
    margin = 0.08 * (high - low)
    axes.axhspan(high, max(high, float(np.nanmax(angle))) + margin, color=PALE, linewidth=0.0)
    axes.axhspan(min(low, float(np.nanmin(angle))) - margin, low, color=PALE, linewidth=0.0)
    axes.margins(y=0.0)


def _draw_speed(axes: Any, time: Floats, speed: Floats, allowed: float | None) -> None:
    """Speed on a scale of its own where it is far below the limit, which is then stated instead of drawn."""
    largest = float(np.nanmax(np.abs(speed)))
    axes.plot(time, speed, color=BLUE)
    if allowed is None:
        pass
    elif largest > 0.3 * allowed:
        for sign in (-1.0, 1.0):
            axes.axhspan(sign * allowed, sign * 1.15 * max(allowed, largest), color=PALE, linewidth=0.0)
        axes.set_ylim(-1.15 * max(allowed, largest), 1.15 * max(allowed, largest))
    else:
        span = max(1.7 * largest, 1e-3)
        axes.set_ylim(-span, span)
        axes.text(0.99, 0.93, f"allowed {allowed:.0f}", transform=axes.transAxes, ha="right", va="top", color=GREY)
    axes.set_ylabel("deg/s")
    axes.margins(x=0.0)


def draw_cell(plan: ArmPlan, *, size: Size = "print") -> Figure:
    """Arm, motor, magnet, boxes and path: the whole cell, and the surroundings of the magnet. Lab frame, mm.

    Returns
    -------
    matplotlib.figure.Figure
        88, 180 or 160 mm wide, as ``size`` is "small", "print" or "slide".
    """
    with styled(size) as sheet:
        figure = sheet.figure((165.0 if sheet.narrow else 90.0) * MM, layout=None)
        if sheet.narrow:
            figure.subplots_adjust(left=0.02, right=0.9, bottom=0.04, top=0.88, hspace=0.15)
        else:
            figure.subplots_adjust(left=0.02, right=0.95, bottom=0.06, top=0.78 if sheet.wide else 0.84, wspace=0.1)
        grid = (2, 1) if sheet.narrow else (1, 2)
        whole, close = (figure.add_subplot(*grid, place, projection="3d") for place in (1, 2))
        poses = plan.path.at(plan.times)
        reach = max(math.hypot(*magnet.offset) + magnet.reach for magnet in plan.scenario.magnet)
        shown = [0] if plan.times.size < 3 else [0, plan.times.size // 2, plan.times.size - 1]
        shown = [i for i in shown if np.isfinite(plan.joints[i]).all()]
        parts = capsules(plan.cell, plan.joints[shown], reach)
        middle = poses.position.mean(axis=0)
        for axes in (whole, close):
            for obstacle in plan.cell.obstacle:
                if axes is whole or obstacle is plan.cell.tank:
                    _draw_box(axes, 1e3 * np.array(obstacle.low), 1e3 * np.array(obstacle.high))
            begin, end = (parts.begin, parts.end) if axes is whole else _within(parts.begin, parts.end, middle)
            _draw_arm(axes, begin, end, parts.names)
            axes.plot(*(1e3 * poses.position.T), color=VERMILLION, linewidth=1.0)
            axes.set(xlabel="x (mm)", ylabel="y (mm)", zlabel="z (mm)")
        _draw_axes_of_rotation(close, poses.position, poses.axis)
        _frame(whole, np.concatenate([parts.begin[0], parts.end[0], [np.array(o.high) for o in plan.cell.obstacle]]))
        close.set(**{f"{n}lim": 1e3 * np.array([c - CLOSE, c + CLOSE]) for n, c in zip("xyz", middle, strict=True)})
        close.locator_params(nbins=4)
        close.set_box_aspect((1, 1, 1), zoom=0.88)
        whole.locator_params(nbins=4)
        whole.set_title("cell; arm at start, middle and end")
        close.set_title("magnet: path and rotation axis")
        title = f"{plan.scenario.title}, {plan.cell.arm.name}\n{drive_inputs(plan.scenario)}"
        head(figure, title, fontsize=sheet.points(8.0))
    return figure


def _within(begin: Floats, end: Floats, middle: Floats) -> tuple[Floats, Floats]:
    """What of each part lies within the view around the magnet; nan where nothing does."""
    along = end - begin
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = np.stack([(middle - CLOSE - begin) / along, (middle + CLOSE - begin) / along])
    enters, leaves = np.nan_to_num(sides.min(axis=0), nan=-np.inf), np.nan_to_num(sides.max(axis=0), nan=np.inf)
    first = np.clip(enters.max(axis=-1, keepdims=True), 0.0, None)
    last = np.clip(leaves.min(axis=-1, keepdims=True), None, 1.0)
    seen = np.where(first <= last, 1.0, np.nan)
    return (begin + first * along) * seen, (begin + last * along) * seen


def _draw_arm(axes: Any, begin: Floats, end: Floats, names: tuple[str, ...]) -> None:
    """Every part as a thick line, the first pose dark, later ones pale."""
    for pose in range(begin.shape[0] - 1, -1, -1):
        for i, name in enumerate(names):
            ends = 1e3 * np.stack([begin[pose, i], end[pose, i]])
            alpha = 1.0 if pose == 0 else 0.25
            if name == "magnet":
                axes.plot(*ends[:1].T, "o", color=PARTS[name], markersize=4.0, alpha=alpha)
            else:
                axes.plot(*ends.T, color=PARTS[name], linewidth=2.5, alpha=alpha, solid_capstyle="round")


def _draw_box(axes: Any, low: Floats, high: Floats) -> None:
    corners = np.array(list(product(*zip(low, high, strict=True))))
    faces = [corners[[0, 1, 3, 2]], corners[[4, 5, 7, 6]], corners[[0, 1, 5, 4]]]
    faces += [corners[[2, 3, 7, 6]], corners[[0, 2, 6, 4]], corners[[1, 3, 7, 5]]]
    axes.add_collection3d(Poly3DCollection(faces, facecolor=SKY, edgecolor=BLUE, linewidth=0.4, alpha=0.15))


def _draw_axes_of_rotation(axes: Any, position: Floats, axis: Floats) -> None:
    """Arrows along the rotation axis at a few places of the path."""
    some = np.unique(np.linspace(0, len(position) - 1, 9).astype(int))
    axes.quiver(*(1e3 * position[some].T), *axis[some].T, length=45.0, color=GREY, linewidth=0.8)


def _frame(axes: Any, points: Floats) -> None:
    """Equal scales that hold all points."""
    low, high = 1e3 * points.min(axis=0), 1e3 * points.max(axis=0)
    half, middle = (high - low).max() / 2.0 * 1.05, (low + high) / 2.0
    axes.set(**{f"{n}lim": (c - half, c + half) for n, c in zip("xyz", middle, strict=True)})
    axes.set_box_aspect((1, 1, 1), zoom=0.88)
