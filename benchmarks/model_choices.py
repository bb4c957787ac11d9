"""How much the choice of a model matters: Fig. 3 and Table I under both magnets, both kinds of drag, and near walls.

Run: python benchmarks/model_choices.py. Every row is a preset, every column a choice; a cell says how the run ends and,
where it stays, its range of heights. The first run makes tables of drag near floor and surface, which takes minutes.
The last lines are the time of a step near walls beside one in open water, of looking up what one wall adds, and of half
an hour of swimming near a floor beside one in open water, by leaps and directly; with --steps the only ones.
"""

import math
import sys
import time

import numpy as np
import warp as wp
from random_runs import hovering_changes
from scipy.spatial.transform import Rotation

from helimag.engine import DOP853, MULTIREVOLUTION, History, advance
from helimag.engine.walls import NEAR_WALLS
from helimag.outcomes import End
from helimag.physics.balance import SHEETS, Sheet
from helimag.physics.walls import NOW, FloorAndSurface, seen_walls
from helimag.scenario import Scenario, load

FIGURE_3 = [f"nose-first/fig3{letter}" for letter in "abc"]
TABLE_1 = [f"nose-first/table1-row{row}" for row in range(1, 8)]
DRAGS = {
    "resistive force": {"model": "lighthill"},
    "boundary": {"model": "boundary"},
    "boundary, near walls": {"model": "boundary", "near_walls": True},
}
REPEATS = 15
PLACES = 200_000  # at which a table is looked up


def outcome(history: History) -> str:
    """How a run ended, in a few words."""
    heights = history.heights
    span = 1e3 * float(heights.high.max() - heights.low.min())
    end = "inside" if history.status is End.HORIZON else str(history.status)
    return f"{end} {history.time[-1]:.0f} s, {span:.1f} mm"


def chosen(name: str, field: str, drag: dict[str, object]) -> Scenario:
    """A preset under a choice of models; its marks speak of other values."""
    return load(name).replaced({"magnet.field": field, "device.hydrodynamics": drag, "provenance": {}})


def main() -> None:
    """Print the table."""
    if "--steps" in sys.argv[1:]:
        print(step_costs(), look_up_cost(), *run_costs(), sep="\n")
        return
    choices = [(field, drag) for drag in DRAGS for field in ("dipole", "cylinder")]
    print("| preset | " + " | ".join(f"{field}, {drag}" for field, drag in choices) + " |")
    print("|---" * (len(choices) + 1) + "|")
    for name in FIGURE_3 + TABLE_1:
        wanted = [choice for choice in choices if "walls" not in choice[1] or name in TABLE_1]
        histories = advance([chosen(name, field, DRAGS[drag]) for field, drag in wanted])
        cells = [outcome(history) for history in histories] + ["no walls"] * (len(choices) - len(wanted))
        print(f"| `{name}` | " + " | ".join(cells) + " |", flush=True)
    print(step_costs(), look_up_cost(), *run_costs(), sep="\n")


def run_costs() -> list[str]:
    """Time of half an hour of hovering 30 mm above a floor beside one in open water, process time: least of repeats.

    Each is tilted so that it stays where it is for as long; the same device in the same fluid under the same magnet.
    """
    open_water = load("nose-first/fig3c").replaced(
        {"device.hydrodynamics": DRAGS["boundary"]} | hovering_changes(-5.719)
    )
    above = {"device.hydrodynamics": DRAGS["boundary, near walls"], "workspace.floor": -0.03}
    runs = {"open water": open_water, "a floor": open_water.replaced(hovering_changes(-11.067) | above)}
    methods = {"leaps": MULTIREVOLUTION, "direct": DOP853}
    seconds = {(by, where): math.inf for by in methods for where in runs}
    kept = {}
    for _ in range(REPEATS):
        for by, where in seconds:
            begun = time.process_time()
            (kept[by, where],) = advance([runs[where]], threads=1, method=methods[by])
            seconds[by, where] = min(seconds[by, where], time.process_time() - begun)
    lines = []
    for by in methods:
        near, free = (seconds[by, where] for where in ("a floor", "open water"))
        followed = [int(kept[by, where].progress["leap"]["followed"]) for where in ("a floor", "open water")]
        ends = ", ".join(outcome(kept[by, where]) for where in ("a floor", "open water"))
        lines.append(
            f"half an hour near a floor, {by}: {1e3 * near:.1f} ms, {near / free:.2f} times as long as in open water; "
            f"turns followed {followed[0]} and {followed[1]}; {ends}"
        )
    return lines


def step_costs() -> str:
    """Time of a step near floor and surface beside one in open water: least of interleaved repeats, process time."""
    runs, seconds = {}, {}
    for drag in ("boundary", "boundary, near walls"):
        # far from the magnet's pull, level in the middle of a tank so deep that the run ends nowhere
        runs[drag] = chosen("nose-first/fig3c", "dipole", DRAGS[drag]).replaced(
            {"workspace.floor": -0.5, "workspace.surface": 0.5, "run.duration": 600.0, "device.weight.net_weight": 1e-5}
        )
        advance([runs[drag].replaced({"run.duration": 1.0})], method=DOP853)
        seconds[drag] = math.inf
    for _ in range(REPEATS):
        for drag, run in runs.items():
            begun = time.process_time()
            (history,) = advance([run], threads=1, method=DOP853)
            took = (time.process_time() - begun) / (history.steps + history.rejected)
            seconds[drag] = min(seconds[drag], took)
    near, free = seconds["boundary, near walls"], seconds["boundary"]
    return f"a step near walls takes {near / free:.2f} times as long as in open water ({1e6 * free:.2f} us)"


@wp.kernel(enable_backward=False)
def looked_up(
    surroundings: wp.array(dtype=FloorAndSurface),
    positions: wp.array(dtype=wp.vec3d),
    rotations: wp.array(dtype=wp.mat33d),
    some: wp.array(dtype=wp.float64),
):
    """One entry of what walls add, so that none of the work is left out."""
    i = wp.tid()
    sheets = wp.zeros(shape=SHEETS, dtype=Sheet)
    some[i] = seen_walls(surroundings[0], positions[i], rotations[i], sheets).changes[i % NOW][i % 6]


def look_up_cost() -> str:
    """Time of looking up what floor and surface add, at random places and attitudes of a tank: least of the repeats."""
    tank = {"workspace.floor": -0.03, "workspace.surface": 0.03}
    run = chosen("nose-first/fig3c", "dipole", DRAGS["boundary, near walls"]).replaced(tank)
    rng = np.random.default_rng(0)
    places = wp.array(rng.uniform(-0.025, 0.025, (PLACES, 3)), dtype=wp.vec3d, device="cpu")
    attitudes = wp.array(Rotation.random(PLACES, rng).as_matrix(), dtype=wp.mat33d, device="cpu")
    some = wp.zeros(PLACES, dtype=wp.float64, device="cpu")
    inputs = [NEAR_WALLS.pack([run], "cpu"), places, attitudes, some]
    wp.launch(looked_up, dim=PLACES, inputs=inputs, device="cpu")
    least = math.inf
    for _ in range(REPEATS):
        begun = time.process_time()
        wp.launch(looked_up, dim=PLACES, inputs=inputs, device="cpu")
        least = min(least, time.process_time() - begun)
    return f"looking up what one wall adds takes {1e9 * least / PLACES / 2:.0f} ns"


if __name__ == "__main__":
    main()
