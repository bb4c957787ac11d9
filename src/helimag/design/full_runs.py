"""Full runs with all inputs off at once."""

from collections import Counter

import numpy as np

from helimag.design.task import DesignTask
from helimag.engine import start_state
from helimag.ensembles import Copies, tally
from helimag.orbits import Floats, Orbit, Watch
from helimag.outcomes import Verdict
from helimag.scenario import Scenario

FIRST_RUNS = 8  # made before more are, twice as many each time: most tolerances that are too wide show in these
LONGEST_RUN, SHORTEST_RUN = 6000.0, 1800.0  # s


def perturbed_runs(
    task: DesignTask,
    orbit: Orbit,
    scenario: Scenario,
    here: Floats,
    half: Floats,
    runs: int,
    on_orbit: bool,
    watch: Watch,
) -> dict[Verdict, int]:
    """Verdicts of full runs with all inputs off at once, evenly over the tolerances; stops after one that fails."""
    time = {"run.duration": scenario.run.duration, "run.interval": scenario.run.interval}
    signs = task.random.uniform(-1.0, 1.0, (runs, len(here)))
    scenarios = [changed.replaced(time) for changed in task.scenarios(here + signs * half, watch)]
    starts = [orbit.state if on_orbit else start_state(changed) for changed in scenarios]
    copies = Copies(scenarios, np.array(starts))
    verdicts: Counter[Verdict] = Counter()
    begin, many = 0, FIRST_RUNS
    while begin < runs and set(verdicts) <= {Verdict.BOUNDED}:
        share = watch.part(begin / runs, min(begin + many, runs) / runs)
        verdicts += tally(copies.part(begin, begin + many), progress=share)
        begin, many = begin + many, 2 * many
    return dict(verdicts)


def long_run(orbit: Orbit) -> Scenario:
    """The orbit's scenario, as long as the device takes to settle on it."""
    duration = float(np.clip(-4.0 / orbit.growth, SHORTEST_RUN, LONGEST_RUN))
    return orbit.scenario.replaced({"run.duration": duration, "run.interval": None})
