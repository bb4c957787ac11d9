"""Why a device stays when its helix leads and not when its head does: the numbers and the figure of the theory page.

Run: python benchmarks/why_it_stays.py [FIGURE.png]. Three parts: how the field's axis tilts with lead and pitch, beside
1.5 lead - 0.5 pitch; what a micronewton more of weight does to the height, by full runs with either end first, beside
the closed form; and for which net weights a circular run stays, with either end first.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag.diagnosis import diagnose
from helimag.engine import advance
from helimag.hydrodynamics import mobility, resistance
from helimag.hydrodynamics.motion import advance_per_turn
from helimag.physics import evaluate
from helimag.physics.magnetics import field_axis_for
from helimag.runs import Judgement
from helimag.scenario import Scenario, load

Floats = NDArray[np.float64]

HEADINGS = ("helix", "head")
MORE = 0.5e-6  # N
TIME = 40.0  # s
SIMULATION, EXPERIMENT = "paper/fig3c", "paper/table1-row1"


def tilt(lead: Floats, pitch: float) -> Floats:
    """Elevation (rad), towards where the device is going, of the field's axis at a device ahead by angles ``lead``."""
    place = np.stack([np.sin(lead), 0.0 * lead, -np.cos(lead)], axis=1)
    axis = evaluate(field_axis_for, np.array([np.cos(pitch), 0.0, np.sin(pitch)]), place)
    return np.arctan(axis[:, 2] / axis[:, 0])


@dataclass(frozen=True)
class Response:
    """Straight below the magnet: kappa, drag across the axis (N s/m), swimming speed (m/s), relaxation of tilt (s)."""

    kappa: float
    across: float
    speed: float
    relaxation: float


def response(scenario: Scenario, distance: float) -> Response:
    """From the device's 6x6 and the field at a distance (m)."""
    matrix = resistance(scenario.device, scenario.fluid)
    across = (matrix[1, 1] + matrix[2, 2]) / 2.0
    behind = (abs(matrix[1, 5]) + abs(matrix[2, 4])) / 2.0 / across
    speed = abs(advance_per_turn(mobility(matrix))) * scenario.drive.frequency
    stiffness = scenario.device.magnetic_moment * 1e-7 * scenario.magnet[0].dipole_moment / distance**3
    turning = (matrix[4, 4] + matrix[5, 5]) / 2.0 - across * behind**2
    return Response(across * behind * speed / stiffness, across, speed, turning / stiffness)


def rises(scenario: Scenario, distance: float, heading: str) -> tuple[Floats, Floats]:
    """Times (s), and rise (m) by a micronewton more of net weight, in a straight drive as fast as the device swims."""
    speed = response(scenario, distance).speed
    drive = {
        "frequency": scenario.drive.frequency,
        "pitch": 0.0,
        "distance": distance,
        "velocity": (speed, 0.0, 0.0),
        "pitch_about": "magnet",
        "heading": heading,
    }
    run = {"duration": TIME, "interval": TIME / 400.0}
    straight = scenario.replaced({"drive": drive, "run": run, "workspace": {}, "device.weight.gravity_center": 0.0})
    carried = float(diagnose(straight).pull[2])
    weights = (carried - MORE, carried + MORE)
    lighter, heavier = advance([straight.replaced({"device.weight.net_weight": w}) for w in weights])
    return lighter.time, (heavier.states[:, 2] - lighter.states[:, 2]) * 1e-6 / (2.0 * MORE)


def forgiving(heading: str, weights: Floats) -> list[Judgement]:
    """Circular runs of the simulation's device under a magnet that stays above and dips ahead, over net weights (N)."""
    base = load(SIMULATION).replaced(
        {"drive.pitch_about": "magnet", "drive.pitch": "-12.7 deg", "drive.heading": heading}
    )
    runs = [base.replaced({"device.weight.net_weight": weight}) for weight in weights]
    return [history.judge() for history in advance(runs)]


def main() -> None:
    """Print the numbers, and draw the figure where a name is given."""
    leads = np.radians(np.linspace(-8.0, 8.0, 33))
    for pitch in (0.0, 13.0):
        exact = np.degrees(tilt(leads, np.radians(pitch)))
        rule = 1.5 * np.degrees(leads) - 0.5 * pitch
        print(f"pitch {pitch:g} deg: 1.5 lead - 0.5 pitch is within {np.abs(exact - rule).max():.2f} deg of the axis")
    curves = {}
    for name, distance in ((SIMULATION, 0.150), (EXPERIMENT, 0.102)):
        scenario = load(name)
        found = response(scenario, distance)
        print(
            f"{name} at {1e3 * distance:g} mm: kappa {found.kappa:.2f}, swims {1e3 * found.speed:.2f} mm/s, "
            f"tilt relaxes in {found.relaxation:.1f} s"
        )
        weight = float(scenario.device.weight.net_weight or 0.0)
        for heading, sign in zip(HEADINGS, (-1.0, 1.0), strict=True):
            time, risen = rises(scenario, distance, heading)
            formula = -(1.0 + sign * found.kappa) * 1e-6 / found.across
            curves[name, heading] = time, risen, formula
            early = (time >= 2.0 * found.relaxation) & (time <= 5.0 * found.relaxation)
            slope = float(np.polyfit(time[early], risen[early], 1)[0])
            growth = 4.0 * weight / (distance * found.across) * (1.0 + sign * found.kappa)
            print(
                f"  {heading:5s} first: 1 uN more moves it by {1e3 * slope:+.4f} mm/s (formula {1e3 * formula:+.4f}); "
                f"height alone grows at {growth:+.4f} per s"
            )
    weights = np.arange(4e-6, 61e-6, 2e-6)
    kept = {heading: forgiving(heading, weights) for heading in HEADINGS}
    for heading, judgements in kept.items():
        inside = [(1e6 * w, each.gain) for w, each in zip(weights, judgements, strict=True) if each.verdict.inside]
        said = (
            f"{inside[0][0]:.0f} to {inside[-1][0]:.0f} uN, gain "
            f"{min(g for _, g in inside):.2f} to {max(g for _, g in inside):.2f}"
            if inside
            else "none"
        )
        print(f"{heading} first: {len(inside)} of {len(weights)} net weights stay for half an hour ({said})")
    if len(sys.argv) > 1:
        _draw(Path(sys.argv[1]), leads, curves, weights, kept)


def _draw(path: Path, leads: Floats, curves: dict, weights: Floats, kept: dict[str, list[Judgement]]) -> None:
    from matplotlib.figure import Figure

    from helimag.plots import save

    figure = Figure(figsize=(7.1, 2.6), layout="constrained")
    first, second, third = figure.subplots(1, 3, width_ratios=(1.0, 1.25, 1.0))
    for pitch, colour in ((0.0, "#0072B2"), (13.0, "#D55E00")):
        exact = np.degrees(tilt(leads, np.radians(pitch)))
        first.plot(np.degrees(leads), exact, color=colour, label=f"pitch {pitch:g}°")
        first.plot(np.degrees(leads), 1.5 * np.degrees(leads) - 0.5 * pitch, color="black", lw=0.6, ls=":")
    first.plot([], [], color="black", lw=0.6, ls=":", label="1.5 lead - ½ pitch")
    first.set(xlabel="lead angle (deg)", ylabel="tilt of the field's axis (deg)", title="What lead and pitch do")
    for heading, colour in zip(HEADINGS, ("#009E73", "#CC79A7"), strict=True):
        time, risen, formula = curves[SIMULATION, heading]
        second.plot(time, 1e3 * risen, color=colour, label=f"{heading} first")
        later = time[time >= 10.0]
        at = float(np.interp(10.0, time, risen))
        second.plot(later, 1e3 * (at + formula * (later - 10.0)), color="black", lw=0.6, ls=":")
    second.plot([], [], color="black", lw=0.6, ls=":", label="(1 ∓ κ)/c")
    second.axhline(0.0, color="#7F7F7F", lw=0.5)
    second.set(xlabel="time (s)", ylabel="rise by 1 µN more weight (mm)", title="Helix first, a heavier device rises")
    for heading, colour in zip(("head", "helix"), ("#CC79A7", "#009E73"), strict=True):
        inside = np.array([each.verdict.inside for each in kept[heading]])
        gains = np.array([each.gain for each in kept[heading]])
        third.scatter(1e6 * weights[inside], gains[inside], s=12, color=colour, label=f"{heading} first, stays")
        third.scatter(
            1e6 * weights[~inside], gains[~inside], s=12, marker="x", color=colour, label=f"{heading} first, leaves"
        )
    third.set(xlabel="net weight (µN)", ylabel="gain in half an hour", title="How forgiving: a circular run")
    for axes in (first, second, third):
        axes.legend(fontsize=6, frameon=False, loc="upper left" if axes is first else "best")
        axes.title.set_fontsize(8)
        axes.tick_params(labelsize=7)
        axes.xaxis.label.set_fontsize(7)
        axes.yaxis.label.set_fontsize(7)
    save(figure, path)


if __name__ == "__main__":
    main()
