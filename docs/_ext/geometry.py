"""The picture of the geometry: what pitch, distance, yaw rate, start and attack angle are counted from."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch, Rectangle

DISTANCE, PITCH, ATTACK = 4.4, 15.0, -9.0  # in units of the picture; deg, deg
MAGNET, DEVICE, DRIVE, QUIET = "#0b3c5d", "#b5651d", "#1b7f5c", "#6b7280"
Place = tuple[float, float]


def draw(file: Path) -> None:
    """Draw a run from the side and from above, and save it."""
    with mpl.rc_context({"font.size": 10.0, "svg.fonttype": "path", "svg.hashsalt": "helimag"}):
        figure = Figure(figsize=(11.0, 5.6), layout="constrained")
        side, above = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
        _side(side)
        _above(above)
        for axes, title in ((side, "from the side (along +y)"), (above, "from above (along -z)")):
            axes.set_title(title, loc="left")
            axes.set_aspect("equal")
            axes.set_axis_off()
        figure.savefig(file, metadata={"Date": None})


def _turned(x: float, y: float, angle: float) -> Place:
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return float(c * x - s * y), float(s * x + c * y)


def _arrow(axes: Axes, start: Place, end: Place, color: str, text: str = "", at: Place = (0.0, 0.0)) -> None:
    style = "-|>,head_length=6,head_width=3"
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle=style, shrinkA=0.0, shrinkB=0.0, color=color, lw=1.6))
    if text:
        axes.text(end[0] + at[0], end[1] + at[1], text, color=color, va="center", ha="center")


def _measure(axes: Axes, start: Place, end: Place, text: str, at: Place) -> None:
    axes.annotate("", start, end, arrowprops={"arrowstyle": "<->", "color": DRIVE, "lw": 1.2})
    axes.text(*at, text, color=DRIVE, va="center", ha="left")


def _device(axes: Axes, place: Place, angle: float) -> None:
    """Head at a place, helix behind it; the nose points along the angle (deg)."""
    along = np.linspace(0.0, 2.2, 300)
    coil = np.array([_turned(-0.22 - u, 0.17 * np.sin(2.0 * np.pi * u / 0.45), angle) for u in along])
    axes.plot(place[0] + coil[:, 0], place[1] + coil[:, 1], color=DEVICE, lw=2.0, solid_capstyle="round")
    axes.add_patch(Circle(place, 0.22, color=DEVICE))


def _side(axes: Axes) -> None:
    magnet, head = (0.0, DISTANCE), (0.0, 0.0)
    for height, text in ((1.25, "workspace.surface"), (-1.9, "workspace.floor")):
        axes.plot([-3.4, 3.9], [height, height], color=QUIET, lw=1.0, ls="--")
        axes.text(3.9, height + 0.16, text, color=QUIET, ha="right")
    corner = _turned(-0.42, -0.3, PITCH)
    axes.add_patch(Rectangle((corner[0], corner[1] + DISTANCE), 0.84, 0.6, angle=PITCH, color=MAGNET, alpha=0.85))
    axes.text(-0.75, DISTANCE + 0.45, "magnet", color=MAGNET, ha="right")
    axes.plot([0.4, 3.0], [DISTANCE, DISTANCE], color=QUIET, lw=0.8, ls=":")
    tip = _turned(2.6, 0.0, PITCH)
    _arrow(axes, magnet, (tip[0], tip[1] + DISTANCE), MAGNET, "axis of rotation\n(arm frame's x)", (0.3, 0.5))
    axes.add_patch(Arc(magnet, 4.0, 4.0, theta1=0.0, theta2=PITCH, color=DRIVE, lw=1.4))
    axes.text(2.12, DISTANCE + 0.24, "drive.pitch > 0", color=DRIVE)
    axes.add_patch(
        Arc((1.25, DISTANCE + 0.34), 0.3, 0.8, angle=PITCH, theta1=-150.0, theta2=150.0, color=DRIVE, lw=1.4)
    )
    axes.text(0.85, DISTANCE + 0.95, "drive.frequency", color=DRIVE, ha="center")
    _measure(axes, magnet, head, "drive.distance", (0.12, DISTANCE / 2.0))
    swung = (-float(np.sin(np.radians(PITCH))) * DISTANCE, float(np.cos(np.radians(PITCH))) * DISTANCE)
    axes.add_patch(Circle(swung, 0.28, fill=False, color=MAGNET, ls=":"))
    axes.plot([0.0, swung[0]], [0.0, swung[1]], color=MAGNET, lw=0.8, ls=":")
    told = 'here with\npitch_about = "origin"\nand start at the origin'
    axes.text(swung[0] - 0.35, swung[1] - 0.4, told, color=MAGNET, ha="right", va="top")
    _device(axes, head, ATTACK)
    nose = _turned(1.9, 0.0, ATTACK)
    _arrow(axes, head, nose, DEVICE, "nose (body x)", (0.85, -0.02))
    axes.plot([0.3, 1.9], [0.0, 0.0], color=QUIET, lw=0.8, ls=":")
    axes.add_patch(Arc(head, 2.9, 2.9, theta1=ATTACK, theta2=0.0, color=DEVICE, lw=1.4))
    axes.text(1.5, 0.22, "attack angle < 0", color=DEVICE)
    place = _turned(-1.3, 0.0, ATTACK)
    _arrow(axes, place, (place[0], place[1] - 1.35), DEVICE, "net_weight, at gravity_center < 0", (0.35, -0.2))
    for end, text, at in (((-2.5, -0.9), "x", (0.16, 0.0)), ((-3.2, -0.2), "z", (0.0, 0.16))):
        _arrow(axes, (-3.2, -0.9), end, QUIET, text, at)
    axes.text(-3.35, -1.15, "lab", color=QUIET)
    axes.set_xlim(-3.9, 4.1)
    axes.set_ylim(-2.3, DISTANCE + 1.6)


def _above(axes: Axes) -> None:
    radius = 2.1
    axes.add_patch(Circle((0.0, 0.0), radius, fill=False, color=MAGNET, lw=1.0, ls="--"))
    axes.add_patch(Arc((0.0, 0.0), 1.5, 1.5, theta1=-70.0, theta2=30.0, color=DRIVE, lw=1.4))
    tip = (0.75 * float(np.cos(np.radians(30.0))), 0.75 * float(np.sin(np.radians(30.0))))
    _arrow(axes, (tip[0] + 0.05, tip[1] - 0.09), (tip[0] - 0.05, tip[1] + 0.09), DRIVE)
    axes.text(0.3, 1.2, "drive.yaw_rate\n> 0, about z", color=DRIVE, va="center")
    _arrow(axes, (0.0, 0.0), (0.0, -radius + 0.26), DRIVE)
    axes.text(-0.12, -1.05, "drive.start", color=DRIVE, ha="right")
    _device(axes, (0.0, -radius), 180.0)
    told = 'head at drive.start, heading = "helix":\nthe helix goes first'
    axes.text(0.0, -radius - 0.4, told, color=DEVICE, ha="center", va="top")
    _arrow(axes, (2.5, -radius), (3.3, -radius), MAGNET)
    axes.text(2.5, -radius + 0.3, "the magnet goes", color=MAGNET)
    axes.text(-1.6, 1.65, "path of the magnet", color=MAGNET, ha="right")
    _arrow(axes, (0.0, 0.0), (1.0, 0.0), QUIET, "lab x", (0.4, 0.0))
    _arrow(axes, (0.0, 0.0), (0.0, 0.8), QUIET, "lab y", (-0.35, 0.0))
    axes.set_xlim(-3.5, 3.9)
    axes.set_ylim(-3.3, 2.5)
