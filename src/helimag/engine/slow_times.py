"""How slow a scenario's own dynamics are: what a run must be long beside to show where the device goes."""

import math
from functools import lru_cache

import numpy as np

from helimag.geometry import magnet_place
from helimag.hydrodynamics import net_weight, resistance
from helimag.hydrodynamics.motion import sinking_speeds
from helimag.runs.heights import SlowTimes
from helimag.scenario import Device, Drive, Fluid, Magnet, Path, Scenario

PERMEABILITY_OVER_4_PI = 1e-7  # T m/A


def slow_times(scenario: Scenario) -> SlowTimes:
    """Slow times of a scenario.

    The magnet's pull falls with the fourth power of the distance d, so about the distance where it balances the weight
    W a level device of mobility b leaves at the rate 4 W b / d: the e-folding time is d / (4 W b), a quarter of the
    time in which it would sink by d. Where the pull at the start exceeds the weight, it takes the weight's place.

    Returns
    -------
    SlowTimes
        Time of a lap and e-folding time of the height (s).

    Raises
    ------
    InputError
        Where drag or weight cannot be computed.
    """
    speed, weight = _free_motion(scenario.device, scenario.fluid)
    apart = math.dist(scenario.drive.start, magnet_place(scenario.drive))
    distance = max(apart, scenario.contact_distance)
    force = max(abs(weight), _attraction(scenario.device, scenario.magnet) / distance**4)
    fold = distance / (4.0 * force * speed) if force > 0.0 else math.inf
    return SlowTimes(lap=lap_time(scenario.drive), fold=fold)


@lru_cache(maxsize=64)
def _attraction(device: Device, magnets: tuple[Magnet, ...]) -> float:
    """Attraction (N) between the moments M of all magnets and the device's m, times their distance d to the 4th (m^4).

    Side by side and antiparallel, as when a device in step is straight below: 3 mu0 m M / (4 pi d^4).
    """
    moment = math.fsum(magnet.dipole_moment for magnet in magnets)
    return 3.0 * PERMEABILITY_OVER_4_PI * abs(moment) * device.magnetic_moment


def lap_time(drive: Drive) -> float | None:
    """Time (s) in which the drive yaws by one turn; None where it does not yaw."""
    rate = abs(drive.yaw_rate) if drive.path is None else _usual_yaw_rate(drive.path)
    return 2.0 * math.pi / rate if rate > 0.0 else None


def _usual_yaw_rate(path: Path) -> float:
    """Yaw rate (rad/s) of a path, whichever way round: the median over its time, so that unwindings do not count."""
    if not path.yaw:
        return 0.0
    spans = np.diff(path.times)
    rates = np.abs(np.diff(path.yaw)) / spans
    order = np.argsort(rates)
    return float(rates[order][np.searchsorted(np.cumsum(spans[order]), path.duration / 2.0)])


@lru_cache(maxsize=64)  # sweeps change drives more often than devices
def _free_motion(device: Device, fluid: Fluid) -> tuple[float, float]:
    """Speed per force (m/s/N) of a level device, and its net weight (N)."""
    weight, _ = net_weight(device, fluid)
    return sinking_speeds(resistance(device, fluid), 1.0)[0], weight
