"""Table I in a tank whose walls hold: what each row does then, and why row 6 does not stay at the surface as measured.

Run: python benchmarks/table1_held.py. First rows 1, 3, 4 and 6 for several heights of the surface. Then row 6 below a
surface at the 2 mm that Fig. 5(A) names, with one thing changed, and how far it gets ahead of its magnet, which goes
half as fast as the device swims.
"""

import numpy as np

from helimag.engine import History, advance
from helimag.scenario import Scenario, load

ROWS = {row: load(f"paper/table1-row{row}") for row in (1, 3, 4, 6)}
MEASURED_Y = {1: 0.98, 3: 1.12, 4: 2.06, 6: 1.35}  # mm
SURFACES = ("1.4 mm", "1.8 mm", "2 mm", "2.3 mm", "2.55 mm", "3.5 mm")
PUBLISHED = "2 mm"  # Fig. 5(A)
WEIGHT, PULL = "device.weight.net_weight", "workspace.surface_pull"
TRIED: dict[str, dict[str, object]] = {
    "nothing": {},
    "weight 49 uN": {WEIGHT: "49 uN"},
    "weight 47 uN": {WEIGHT: "47 uN"},
    "gravity centre -0.26 mm": {"device.weight.gravity_center": "-0.26 mm"},
    "gravity centre 1 mm": {"device.weight.gravity_center": "1 mm"},
    "viscosity 0.9 Pa s": {"fluid.viscosity": "0.9 Pa s"},
    "viscosity 1.1 Pa s": {"fluid.viscosity": "1.1 Pa s"},
    "a head that is a cylinder": {"device.head": {"shape": "cylinder", "length": "1 mm", "diameter": "1 mm"}},
    "the magnet's true field": {"magnet.field": "cylinder"},
    "a surface that pulls 5 uN": {PULL: "5 uN"},
    "a surface that pulls 20 uN": {PULL: "20 uN"},
    "a surface that pulls 40 uN": {PULL: "40 uN"},
}


def held(row: Scenario, surface: str, changes: dict[str, object] | None = None) -> Scenario:
    """A row below a surface that holds."""
    return row.replaced({"workspace.contact": "hold", "workspace.surface": surface, **(changes or {})})


def told(history: History) -> str:
    """Range of heights, attack angle, walls with the times of their first and last contact."""
    judgement = history.judge()
    walls = "; ".join(f"{touch.wall} {touch.first:.0f}-{touch.last:.0f} s" for touch in judgement.touches) or "no wall"
    return f"|y| {1e3 * judgement.output:5.2f} mm, {np.degrees(judgement.attack_angle):5.1f} deg, {walls}"


def ahead(history: History, time: float) -> float:
    """How far the head is ahead of the magnet at a time, along the drive (mm)."""
    place = float(np.interp(time, history.time, history.states[:, 0]))
    return 1e3 * (place - history.scenario.drive.velocity[0] * time)


def main() -> None:
    """Print both."""
    for surface in SURFACES:
        print(f"surface {surface} above the start")
        for row, history in zip(ROWS, advance([held(each, surface) for each in ROWS.values()]), strict=True):
            print(f"  row {row} (measured {MEASURED_Y[row]:.2f} mm): {told(history)}")
    print(f"row 6 below a surface at {PUBLISHED}")
    for name, history in zip(TRIED, advance([held(ROWS[6], PUBLISHED, each) for each in TRIED.values()]), strict=True):
        lead = ", ".join(f"{ahead(history, time):.0f}" for time in (50.0, 100.0, 150.0))
        print(f"  {name:27s} {told(history)}; ahead {lead} mm at 50, 100, 150 s", flush=True)


if __name__ == "__main__":
    main()
