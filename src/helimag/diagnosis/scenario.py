"""What can be said of a scenario without running it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.checks import Check, examine, field_axis, step_out_frequency, weakest_and_strongest
from helimag.diagnosis.turn import over_a_turn
from helimag.engine import announced, carrying_velocity, start_attitude
from helimag.geometry import long_axes, magnet_start
from helimag.hydrodynamics import mobility, net_weight, resistance
from helimag.hydrodynamics.motion import advance_per_turn, roll_resistance, sinking_speeds
from helimag.scenario import MARKS, Scenario

Floats = NDArray[np.float64]

FARTHEST = 10.0  # m; a balance farther away than this is none
TRIED = 400  # distances between which it is looked for


@dataclass(frozen=True)
class Travel:
    """How a device goes with its long axis along ``nose`` (unit vector to the head, lab frame).

    ``leads`` is the end in front as the drive carries it along, ``swims`` the end towards which its own turning drives
    it: ``"head"`` or ``"helix"``, and ``leads`` None where the drive stands still. ``thrust`` is the direction of its
    swimming.
    """

    nose: Floats
    leads: str | None
    swims: str
    thrust: Floats


@dataclass(frozen=True)
class Diagnosis:
    """A scenario explained; SI, radians, lab frame.

    ``pull`` is the magnetic force at the start, mean over a turn, on a device in step, and ``field`` the weakest and
    strongest flux density of that turn. ``balance_distance`` is where, straight below the magnet, that pull carries the
    net weight: None where it does nowhere. ``advance`` is swum in a turn by rolling alone, towards the nose where
    positive for a right-handed roll. ``sinking`` is level and upright. ``roll_rates`` are those at which an error of
    roll relaxes in the weakest and the strongest field of a turn, in step.
    """

    scenario: Scenario
    pull: Floats
    net_weight: float
    field: tuple[float, float]
    start_distance: float
    balance_distance: float | None
    step_out_frequency: float
    advance: float
    sinking: tuple[float, float]
    roll_rates: tuple[float, float]
    at_start: Travel
    settled: Travel
    sources: dict[str, list[str]]
    checks: list[Check]

    @property
    def net_force(self) -> Floats:
        """Pull and net weight together (N)."""
        net: Floats = self.pull - np.array([0.0, 0.0, self.net_weight])
        return net

    @property
    def moment(self) -> tuple[float, float | None]:
        """Sum of the magnets' moments (A m^2), and half its range: None where that of one is not known."""
        magnets = self.scenario.magnet
        ranges = [magnet.dipole_moment_uncertainty for magnet in magnets]
        known = [half for half in ranges if half is not None]
        total = math.fsum(magnet.dipole_moment for magnet in magnets)
        return total, math.fsum(known) if len(known) == len(magnets) else None

    @property
    def margin(self) -> float:
        """Step-out frequency over the drive's."""
        return self.step_out_frequency / abs(self.scenario.drive.frequency)

    @property
    def swimming_speed(self) -> float:
        """Along the long axis at the drive's frequency (m/s)."""
        return abs(self.advance * self.scenario.drive.frequency)


def diagnose(scenario: Scenario) -> Diagnosis:
    """Explain a scenario from its start, without running it.

    Returns
    -------
    Diagnosis
        SI; for people by ``as_text``, for machines by ``as_json``.

    Raises
    ------
    InputError
        Where drag or weight cannot be computed.
    """
    with announced("solving for the drag of this device, once (some ten seconds) ...", log="drag of the device"):
        matrix = resistance(scenario.device, scenario.fluid)
        checks = examine(scenario, thorough=True)
    inverse = mobility(matrix)
    weight, _ = net_weight(scenario.device, scenario.fluid)
    away = np.array(scenario.drive.start) - magnet_start(scenario.drive)
    fields, forces = over_a_turn(scenario, away[None])
    field = weakest_and_strongest(fields[0])
    stiffness = scenario.device.magnetic_moment / roll_resistance(inverse)
    advance = advance_per_turn(inverse)
    axis = field_axis(scenario) * math.copysign(1.0, scenario.drive.frequency)
    nose = long_axes(start_attitude(scenario))
    return Diagnosis(
        scenario=scenario,
        pull=forces[0].mean(axis=0),
        net_weight=weight,
        field=field,
        start_distance=float(np.linalg.norm(away)),
        balance_distance=balance_distance(scenario, weight),
        step_out_frequency=step_out_frequency(scenario),
        advance=advance,
        sinking=sinking_speeds(matrix, weight),
        roll_rates=(stiffness * field[0], stiffness * field[1]),
        at_start=travel(scenario, nose, axis, advance),
        settled=travel(scenario, math.copysign(1.0, float(axis @ nose)) * axis, axis, advance),
        sources=sources(scenario),
        checks=checks,
    )


def balance_distance(scenario: Scenario, weight: float) -> float | None:
    """Distance (m) straight below the magnet at which the mean pull in step carries ``weight`` (N); None if nowhere.

    Where the pull falls short of the weight farther away; of several such places, as below long magnets or between two,
    the nearest to the start.
    """
    from scipy.optimize import brentq

    def surplus(distance: Floats) -> Floats:
        places = np.zeros((distance.size, 3))
        places[:, 2] = -distance
        _, forces = over_a_turn(scenario, places)
        above: Floats = forces[:, :, 2].mean(axis=1) - weight
        return above

    nearest = scenario.contact_distance
    if weight <= 0.0 or nearest >= FARTHEST:
        return None
    places = np.geomspace(nearest, FARTHEST, TRIED)
    found = surplus(places)
    begins = np.flatnonzero((found[:-1] >= 0.0) & (found[1:] < 0.0))
    if not begins.size:
        return None
    start = magnet_start(scenario.drive)[2] - scenario.drive.start[2]
    begin = begins[np.argmin(np.abs(np.log(places[begins] / max(start, nearest))))]
    low, high = float(places[begin]), float(places[begin + 1])
    return float(brentq(lambda at: float(surplus(np.array([at]))[0]), low, high, xtol=1e-9, rtol=1e-12))


def travel(scenario: Scenario, nose: Floats, axis: Floats, advance: float) -> Travel:
    """Which end leads, and which way it swims, with the long axis along ``nose`` and the field turning about ``axis``.

    The device rolls with the field, so its roll is right-handed about the nose where the two agree. A settled device
    lies along the axis of the field, on the side that is nearer to its start.
    """
    carried = carrying_velocity(scenario) @ nose
    towards_nose = advance * float(nose @ axis) > 0.0
    return Travel(
        nose=nose,
        leads=None if carried == 0.0 else "head" if carried > 0.0 else "helix",
        swims="head" if towards_nose else "helix",
        thrust=nose if towards_nose else -nose,
    )


def sources(scenario: Scenario) -> dict[str, list[str]]:
    """Fields by the mark of their provenance."""
    found: dict[str, list[str]] = {mark: [] for mark in MARKS}
    for path, mark in scenario.provenance.items():
        found[mark.partition(":")[0]].append(path)
    return found
