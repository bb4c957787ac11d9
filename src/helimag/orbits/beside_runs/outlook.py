"""The outlook of a run: the orbit that its end leads to, or how it ends when it is continued."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from helimag.errors import InputError
from helimag.orbits.averaged import comes_to
from helimag.orbits.beside_runs.closed_curve import swinging
from helimag.orbits.strobe import (
    Floats,
    Orbit,
    Problem,
    Watch,
    chart,
    describe_rates,
    find_orbit,
    open_water,
    require_periodic,
    strobed,
    to_moving,
)
from helimag.outcomes import HOLDING, End, Future
from helimag.runs.trajectory import Trajectory
from helimag.scenario import Scenario, parse

ON_ORBIT = 0.05  # of the distance and radians: a run that is this near the orbit that it comes to is on it
SHORTEST, LONGEST = 1800.0, 20_000.0  # s, that a run is continued
SAMPLES = 2000  # at whole turns, of a run continued
MOST_STEPS = 2e6  # of the integrator, that this may take; a stiff run is continued for less


@dataclass(frozen=True)
class Outlook:
    """The outlook of a run, and the orbit (stable or not) that its end leads to, if any."""

    future: Future
    text: str
    orbit: Orbit | None = None


def explain(trajectory: Trajectory, *, progress: Callable[[float], None] | None = None) -> Outlook:
    """Say what happens to a simulated run after its horizon.

    It is continued for a decay time of the stable orbit that its end leads to, at least 1800 s, to see whether it comes
    to it. Without one it goes on until it leaves or has stayed for 20,000 s more: then it may be on a closed curve.
    Where that would take the integrator very many steps, it is continued for less.

    Parameters
    ----------
    trajectory
        A simulated run; it knows its scenario.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    Outlook
        Its future as a word of :mod:`helimag.outcomes` and as a sentence, and the orbit where one was found.

    Raises
    ------
    InputError
        Where the trajectory does not hold its scenario: a measured one.
    """
    if trajectory.scenario_toml is None:
        raise InputError("explaining a run by its orbit needs a simulated run, which knows its scenario")
    scenario = open_water(parse(trajectory.scenario_toml))
    if trajectory.judgement.cause in HOLDING:
        return Outlook(Future.HELD, Future.HELD.text())
    if not trajectory.verdict.inside:
        return Outlook(Future.GONE, Future.GONE.text())
    try:
        require_periodic(scenario)
    except InputError as error:
        return Outlook(Future.UNKNOWN, Future.UNKNOWN.text(problem=error))
    watch = Watch(progress)
    time = float(trajectory.dataset["time"].values[-1])
    state = _at_whole_turn(scenario, time, trajectory.final_state)
    orbit = find_orbit(scenario, near=state, progress=watch.part(0.0, 0.05))
    begin = f"inside for {time:.0f} s" if time >= 1.0 else f"inside for {time:.2g} s"
    needed = float(trajectory.dataset.attrs["steps"]) - trajectory.dataset.sizes["time"]  # less those cut by samples
    longest = min(LONGEST, MOST_STEPS * time / max(1.0, needed))
    longer = min(longest, max(SHORTEST, -1.0 / orbit.growth)) if orbit.stable else longest
    (later,) = strobed(scenario, longer, samples=SAMPLES, states=state[None], progress=watch.part(0.05, 0.95))
    if later.status is not End.HORIZON:
        watch(1.0)
        found, how = _what_there_is(orbit), later.status.text()
        return Outlook(Future.LEAVES, Future.LEAVES.text(begin=begin, found=found, end=how, longer=later.end), orbit)
    reached = find_orbit(scenario, near=later.states[-1], progress=watch.part(0.95, 1.0))
    if reached.stable and comes_to(reached, later.states[:, :3]):
        future = Future.ON_ORBIT if _away(reached, state) < ON_ORBIT else Future.COMING
        text = future.text(begin=begin, place=_place(reached), rates=describe_rates(reached.rates))
        return Outlook(future, text, reached)
    motion = swinging(later.times, later.states[:, 2])
    future = Future.SWINGS if motion.closed else Future.STAYS
    text = future.text(begin=begin, longer=later.end, motion=motion.text, found=_what_there_is(reached))
    return Outlook(future, text, reached)


def _at_whole_turn(scenario: Scenario, time: float, state: Floats) -> Floats:
    """The state (7,) of the lab frame at ``time`` when the magnet next begins a turn, moving frame."""
    problem, one = Problem([scenario]), np.zeros(1, dtype=np.int64)
    moving = to_moving(scenario, np.array([time]), state[None])
    phase = np.array([(time * abs(scenario.drive.frequency)) % 1.0])
    if 1e-9 < phase[0] < 1.0 - 1e-9:
        moving, _ = problem.advance(one, moving, problem.steps(one, moving), phase, np.ones(1))
    return np.asarray(moving[0])


def _away(orbit: Orbit, state: Floats) -> float:
    length = np.array([orbit.scenario.drive.distance])
    return float(np.linalg.norm(chart.coordinates(state[None], orbit.state[None], length)))


def _what_there_is(orbit: Orbit) -> str:
    if orbit.stable:
        return f"not within reach of the stable orbit at {_place(orbit)}"
    if orbit.found:
        return f"the orbit found from its end is unstable ({describe_rates(orbit.rates, 1)})"
    return "no orbit was found from its end"


def _place(orbit: Orbit) -> str:
    x, y, z = 1e3 * orbit.position
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm in the moving frame"
