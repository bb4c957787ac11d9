"""The widest tolerances that hold together: on orbits first, then in full runs."""

from itertools import product

import numpy as np

from helimag.design.full_runs import long_run, perturbed_runs
from helimag.design.result import Design
from helimag.design.task import DesignTask
from helimag.orbits import Floats, Orbit, StableInterval, Watch, find_orbit, find_orbits
from helimag.outcomes import Verdict

SHARES = tuple(0.9 * 0.85**i for i in range(12))  # of the margins, tried as tolerances that hold together
TOGETHER = 64  # inputs perturbed at once for which a stable orbit is asked before the full runs


def checked(
    task: DesignTask,
    orbit: Orbit,
    intervals: dict[str, StableInterval],
    runs: int,
    on_orbit: bool,
    watch: Watch,
) -> Design | None:
    """The design with the largest tolerances, as a common share of the margins, that keep all runs bounded."""
    scenario = long_run(orbit)
    margins = np.array([interval.margin for interval in intervals.values()])
    here = task.parameters.vector(scenario)
    for count, share in enumerate(SHARES):
        part = watch.turn(count, len(SHARES))
        if not _stable_together(task, orbit, here, share * margins, part.part(0.0, 0.1)):
            continue
        verdicts = perturbed_runs(task, orbit, scenario, here, share * margins, runs, on_orbit, part.part(0.1, 1.0))
        if verdicts.get(Verdict.BOUNDED, 0) == runs:
            tolerances = dict(zip(intervals, (share * margins).tolist(), strict=True))
            again = find_orbit(orbit.scenario, near=orbit, progress=watch.unmeasured())
            return Design(again, scenario, intervals, tolerances, verdicts, on_orbit)
    return None


def _stable_together(task: DesignTask, orbit: Orbit, here: Floats, half: Floats, watch: Watch) -> bool:
    """Whether the orbit stays stable at the corners of the tolerances and at random places between."""
    corners = np.array(list(product((-1.0, 1.0), repeat=len(here))))
    signs = np.concatenate([corners, task.random.uniform(-1.0, 1.0, (TOGETHER, len(here)))])
    state = np.repeat(orbit.state[None], len(signs), axis=0)
    for share in (0.34, 0.67, 1.0):
        scenarios = task.scenarios(here + signs * (share * half), watch)
        found = find_orbits(scenarios, state, progress=watch.unmeasured())
        if not all(other.stable for other in found):
            return False
        state = np.array([other.state for other in found])
    return True
