"""Is row 1 of Table I bounded, or a well-tuned transient? Its orbit, and what could steady it, tried one by one.

Run: python benchmarks/row1_steadied.py [walls]. Each line is an orbit of the straight drive with one thing changed: how
fast its worst error grows, and how far the head is from below the magnet. With ``walls`` also the surface at three
heights, whose tables of drag take minutes each the first time. Last, how near row 1 must be to its balance to stay.
"""

import sys

import numpy as np

from helimag.engine import advance
from helimag.orbits import Orbit, find_orbit
from helimag.scenario import Scenario, load

ROW = load("paper/table1-row1")
OPEN = ROW.replaced({"workspace": {}})
CIRCLE = {"drive.velocity": (0.0, 0.0, 0.0), "drive.start": ("0 mm", "-45 mm", "0 mm")}
TRIED = {
    "nothing": {},
    "start 10 mm aside": {"drive.start.y": "10 mm"},
    "0.2 mm/s": {"drive.speed": "0.2 mm/s"},
    "0.412 mm/s": {"drive.speed": "0.412 mm/s"},
    "1.2 mm/s": {"drive.speed": "1.2 mm/s"},
    "axis level": {"drive.pitch": 0.0},
    "axis 30 deg down": {"drive.pitch": "-30 deg"},
    "gravity centre -2 mm": {"device.weight.gravity_center": "-2 mm"},
    "gravity centre +2 mm": {"device.weight.gravity_center": "2 mm"},
    "30 uN": {"device.weight.net_weight": "30 uN"},
    "10 uN": {"device.weight.net_weight": "10 uN"},
    "3 uN": {"device.weight.net_weight": "3 uN"},
    "2 uN": {"device.weight.net_weight": "2 uN"},
    "in a circle, 1.8 deg/s": {**CIRCLE, "drive.yaw_rate": "1.8 deg/s"},
}
SURFACES = ("2.55 mm", "3.5 mm", "8 mm")
LIGHTER = (0.001, 0.01, 0.02, 0.05)  # shares of the weight
OFFSETS = (0.0, 1e-5, 1e-4, 1e-3)  # of the weight


def said(orbit: Orbit) -> str:
    """Growth and place of an orbit in one line."""
    if not orbit.found:
        return orbit.text
    x, y, _ = 1e3 * orbit.mean_position
    fold = f"e-fold in {1.0 / orbit.growth:.1f} s" if orbit.growth > 0.0 else f"decays in {-1.0 / orbit.growth:.0f} s"
    stable = "stable" if orbit.stable else "unstable"
    return f"{stable}, {fold}; {orbit.leading_end} first, head at x {x:.1f}, y {y:.1f} mm"


def varied(changes: dict[str, object]) -> Scenario:
    """Row 1 in open water with one thing changed."""
    from helimag.scenario import varied as with_inputs

    return with_inputs(OPEN, changes) if changes else OPEN


def main() -> None:
    """Print all of it."""
    orbit = find_orbit(OPEN)
    for name, changes in TRIED.items():
        found = find_orbit(varied(changes), near=orbit)
        if not found.found:
            found = find_orbit(varied(changes))
        print(f"{name:24s} {said(found)}", flush=True)
    if "walls" in sys.argv[1:]:
        for surface in SURFACES:
            near = ROW.replaced({"workspace.surface": surface, "device.hydrodynamics.near_walls": True})
            print(f"drag near surface {surface:6s} {said(find_orbit(near, near=orbit))}", flush=True)
    weight = float(ROW.device.weight.net_weight or 0.0)
    for lighter in LIGHTER:
        held = {"workspace.contact": "hold", "device.weight.net_weight": weight * (1.0 - lighter)}
        judgement = advance([ROW.replaced(held)])[0].judge()
        print(
            f"a surface that holds, {100.0 * lighter:g} % lighter: {judgement.reason}; "
            f"|y| {1e3 * judgement.output:.2f} mm, attack angle {np.degrees(judgement.attack_angle):.1f} deg"
        )
    for offset in OFFSETS:
        both = [OPEN.replaced({"device.weight.net_weight": weight * (1.0 + sign * offset)}) for sign in (-1.0, 1.0)]
        ends = [1e3 * history.states[-1, 2] for history in advance(both)]
        print(f"weight off by {100.0 * offset:g} %: row 1 ends at {ends[0]:+.1f} and {ends[1]:+.1f} mm")
    longer = [OPEN.replaced({"run.duration": duration}) for duration in (193.9, 300.0, 400.0)]
    print("goes on:", ", ".join(f"{h.time[-1]:.0f} s {1e3 * h.states[-1, 2]:+.1f} mm" for h in advance(longer)))
    print(f"largest |height| until 193.9 s: {1e3 * float(np.abs(advance([OPEN])[0].states[:, 2]).max()):.2f} mm")


if __name__ == "__main__":
    main()
