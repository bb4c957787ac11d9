"""Full runs with all inputs off at once."""

import numpy as np

from helimag.design.task import DesignTask
from helimag.engine.simulation import advance
from helimag.orbits import Floats, Orbit, Watch
from helimag.runs.gain import Verdict
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
    scenarios = [changed.replaced(time) for changed in task.perturbed(here, half, signs, watch)]
    verdicts: dict[Verdict, int] = {}
    begin, many = 0, FIRST_RUNS
    while begin < runs and set(verdicts) <= {Verdict.BOUNDED}:
        part = scenarios[begin : begin + many]
        starts = np.repeat(orbit.state[None], len(part), axis=0) if on_orbit else None
        share = watch.part(begin / runs, min(begin + many, runs) / runs)
        for history in advance(part, initial_states=starts, progress=share):
            verdict = history.judge().verdict
            verdicts[verdict] = verdicts.get(verdict, 0) + 1
        begin, many = begin + many, 2 * many
    return verdicts


def long_run(orbit: Orbit) -> Scenario:
    """The orbit's scenario, as long as the device takes to settle on it."""
    duration = float(np.clip(-4.0 / orbit.growth, SHORTEST_RUN, LONGEST_RUN))
    return orbit.scenario.replaced({"run.duration": duration, "run.interval": None})
