"""How much the choice of a model matters: Fig. 3 and Table I under both magnets, both kinds of drag, and near walls.

Run: python benchmarks/model_choices.py. Every row is a preset, every column a choice; a cell says how the run ends and,
where it stays, its range of heights. The first run makes tables of drag near floor and surface, which takes minutes.
The last line is the time of a run near walls beside the same run in open water, and with --steps the only one.
"""

import math
import sys
import time

from helimag.engine import History, advance
from helimag.outcomes import End
from helimag.scenario import Scenario, load

FIGURE_3 = [f"nose-first/fig3{letter}" for letter in "abc"]
TABLE_1 = [f"nose-first/table1-row{row}" for row in range(1, 8)]
DRAGS = {
    "resistive force": {"model": "lighthill"},
    "boundary": {"model": "boundary"},
    "boundary, near walls": {"model": "boundary", "near_walls": True},
}
REPEATS = 15


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
        print(step_costs())
        return
    choices = [(field, drag) for drag in DRAGS for field in ("dipole", "cylinder")]
    print("| preset | " + " | ".join(f"{field}, {drag}" for field, drag in choices) + " |")
    print("|---" * (len(choices) + 1) + "|")
    for name in FIGURE_3 + TABLE_1:
        wanted = [choice for choice in choices if "walls" not in choice[1] or name in TABLE_1]
        histories = advance([chosen(name, field, DRAGS[drag]) for field, drag in wanted])
        cells = [outcome(history) for history in histories] + ["no walls"] * (len(choices) - len(wanted))
        print(f"| `{name}` | " + " | ".join(cells) + " |", flush=True)
    print(step_costs())


def step_costs() -> str:
    """Time of a step near floor and surface beside one in open water: least of interleaved repeats, process time."""
    runs, seconds = {}, {}
    for drag in ("boundary", "boundary, near walls"):
        # far from the magnet's pull, level in the middle of a tank so deep that the run ends nowhere
        runs[drag] = chosen("nose-first/fig3c", "dipole", DRAGS[drag]).replaced(
            {"workspace.floor": -0.5, "workspace.surface": 0.5, "run.duration": 600.0, "device.weight.net_weight": 1e-5}
        )
        advance([runs[drag].replaced({"run.duration": 1.0})])
        seconds[drag] = math.inf
    for _ in range(REPEATS):
        for drag, run in runs.items():
            begun = time.process_time()
            (history,) = advance([run], threads=1)
            took = (time.process_time() - begun) / (history.steps + history.rejected)
            seconds[drag] = min(seconds[drag], took)
    near, free = seconds["boundary, near walls"], seconds["boundary"]
    return f"a step near walls takes {near / free:.2f} times as long as in open water ({1e6 * free:.2f} us)"


if __name__ == "__main__":
    main()
