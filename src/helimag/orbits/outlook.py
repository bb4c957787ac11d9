"""What an orbit says about a run: the verdict of a finite horizon beside the one for all time."""

import numpy as np

from helimag.errors import InputError
from helimag.gain import Verdict
from helimag.orbits import _chart as chart
from helimag.orbits._problem import Problem, require_periodic
from helimag.orbits._starts import to_moving
from helimag.orbits.find import find_orbit
from helimag.orbits.orbit import Orbit, describe_rates
from helimag.scenario import parse
from helimag.trajectory import Trajectory

ON_ORBIT = 0.05  # of the distance and radians: a run that ends this near its orbit is on it
INSIDE = (Verdict.BOUNDED, Verdict.DRIFTING)


def explain(trajectory: Trajectory) -> tuple[Orbit | None, str]:
    """The orbit that a run's end leads to, and what that means for the run.

    Parameters
    ----------
    trajectory
        A simulated run; it knows its scenario.

    Returns
    -------
    orbit, text
        None, with the reason, where the run left, or where the drive has no frame in which it repeats.

    Raises
    ------
    InputError
        Where the trajectory does not hold its scenario: a measured one.
    """
    text = trajectory.scenario_toml
    if text is None:
        raise InputError("explaining a run by its orbit needs a simulated run, which knows its scenario")
    scenario = parse(text)
    if trajectory.verdict not in INSIDE:
        return None, "the run left; no orbit is sought from its end"
    try:
        require_periodic(scenario)
    except InputError as error:
        return None, str(error)
    time = float(trajectory.dataset["time"].values[-1])
    problem = Problem([scenario])
    one = np.zeros(1, dtype=np.int64)
    # the map begins where the magnet's turn begins: what is left of the last turn is run through
    phase = np.array([(time * abs(scenario.drive.frequency)) % 1.0])
    state = to_moving(scenario, np.array([time]), trajectory.final_state[None])
    if 1e-9 < phase[0] < 1.0 - 1e-9:
        state, _ = problem.advance(one, state, problem.steps(one, state), phase, np.ones(1))
    orbit = find_orbit(scenario, near=state[0])
    if not orbit.stable:
        orbit = find_orbit(scenario)
    horizon = f"inside for {time:.0f} s"
    if not orbit.stable:
        kind = f"only an unstable one ({describe_rates(orbit.rates, 1)})" if orbit.found else f"none ({orbit.status})"
        return orbit, f"{horizon}, but no stable orbit was found, {kind}: expected to leave"
    away = float(np.linalg.norm(chart.coordinates(state[0], orbit.state, problem.length[0])))
    place = "on a stable orbit" if away < ON_ORBIT else f"not yet on the stable orbit at {_place(orbit)}"
    return orbit, f"{horizon}, {place}: {describe_rates(orbit.rates)}"


def _place(orbit: Orbit) -> str:
    x, y, z = 1e3 * orbit.position
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm in the moving frame"
