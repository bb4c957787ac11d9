"""Orbits one by one: the variables that say all of an orbit that a figure or a later search needs, and back."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from helimag.orbits.datasets.variables import ATTITUDE, PLACE, Variable, flags, number
from helimag.orbits.strobe import Orbit
from helimag.outcomes import OrbitStatus
from helimag.scenario import Scenario

if TYPE_CHECKING:
    import xarray


def orbit_variables(along: tuple[str, ...], orbits: Sequence[Orbit], *, prefix: str = "") -> dict[str, Variable]:
    """Orbits that were found, along a dimension; ``prefix`` begins every name."""
    states, multipliers = np.array([o.state for o in orbits]), np.array([o.multipliers for o in orbits])
    rates = np.array([o.rates for o in orbits])
    lead = rates[np.arange(len(orbits)), np.argmax(rates.real, axis=1)]
    each = (*along, "multiplier")
    data = {
        "stable": flags(along, [int(o.stable) for o in orbits], ("no", "yes"), "whether the orbit is stable"),
        "growth": number(along, lead.real, "1/s", "real part of the leading rate; stable where negative"),
        "swing": number(along, np.abs(lead.imag), "rad/s", "imaginary part of the leading rate"),
        "position": number((*along, "axis"), states[:, :3], "m", PLACE),
        "mean_position": number((*along, "axis"), [o.mean_position for o in orbits], "m", "mean over the period"),
        "quaternion": number((*along, "component"), states[:, 3:], "1", ATTITUDE),
        "multiplier_real": number(each, multipliers.real, "1", "Floquet multipliers, real part"),
        "multiplier_imaginary": number(each, multipliers.imag, "1", "Floquet multipliers, imaginary part"),
        "rate_real": number(each, rates.real, "1/s", "Floquet rates, real part; decay where negative"),
        "rate_imaginary": number(each, rates.imag, "rad/s", "Floquet rates, imaginary part"),
        "attack_angle": number(along, [o.attack_angle for o in orbits], "rad", "mean over the period"),
        "wobble": number(along, [o.wobble for o in orbits], "rad", "standard deviation of the attack angle"),
        "position_error": number(along, [o.position_error for o in orbits], "m", "of the place, by twice the steps"),
    }
    return {prefix + name: variable for name, variable in data.items()}


def orbits_in(dataset: "xarray.Dataset", scenarios: Sequence[Scenario], *, prefix: str = "") -> list[Orbit]:
    """The orbits that :func:`orbit_variables` wrote; their Jacobians and the range of heights are not kept.

    Parameters
    ----------
    scenarios
        One for each orbit.
    """

    def held(name: str) -> np.ndarray:
        return np.asarray(dataset[prefix + name].values, dtype=np.float64)

    states = np.concatenate([held("position"), held("quaternion")], axis=1)
    multipliers = held("multiplier_real") + 1j * held("multiplier_imaginary")
    rates = held("rate_real") + 1j * held("rate_imaginary")
    return [
        Orbit(
            scenario=scenario,
            status=OrbitStatus.FOUND,
            state=states[i],
            multipliers=multipliers[i],
            rates=rates[i],
            mean_position=held("mean_position")[i],
            attack_angle=float(held("attack_angle")[i]),
            wobble=float(held("wobble")[i]),
            position_error=float(held("position_error")[i]),
        )
        for i, scenario in enumerate(scenarios)
    ]
