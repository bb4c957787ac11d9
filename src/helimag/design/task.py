"""What is asked of a design: inputs to choose with their limits, and values that the device is to have."""

import math
from collections.abc import Mapping

import numpy as np

from helimag.errors import InputError
from helimag.orbits import Floats, Orbit, Watch
from helimag.scenario import Parameters, Scenario

CIRCULAR = {
    "drive.frequency": (1.0, 4.5),
    "drive.pitch": (0.0, math.radians(25.0)),
    "drive.distance": (0.1, 0.2),
    "drive.yaw_rate": (math.radians(0.3), math.radians(6.0)),
}
STRAIGHT = {key: value for key, value in CIRCULAR.items() if key != "drive.yaw_rate"}


class DesignTask:
    """Inputs with limits, wanted values, and random numbers; places (k,) among the inputs are shares of the limits."""

    def __init__(
        self,
        scenario: Scenario,
        limits: Mapping[str, tuple[float, float]] | None,
        wanted: Mapping[str, float | None],
        seed: int,
    ) -> None:
        default = CIRCULAR if scenario.drive.yaw_rate != 0.0 else STRAIGHT
        self.scenario = scenario
        self.parameters = Parameters.within(scenario, default if limits is None else limits)
        self.low = self.parameters.low
        self.span = self.parameters.high - self.low
        self.wanted = {name: value for name, value in wanted.items() if value is not None}
        if "radius" in self.wanted and scenario.drive.yaw_rate == 0.0:
            raise InputError("radius needs a circular run: drive.yaw_rate must not be zero")
        for name, value in self.wanted.items():
            if not value > 0.0:
                raise InputError(f"{name} must be greater than zero; got {value}")
        if len(self.wanted) >= len(self.span):
            raise InputError("design needs more inputs to choose than wanted values: name more limits")
        self.random = np.random.default_rng(seed)

    @property
    def wish(self) -> str:
        """The wanted values in words."""
        units = {"speed": "mm/s", "radius": "mm"}
        return " and ".join(f"with {name} {1e3 * value:.4g} {units[name]}" for name, value in self.wanted.items())

    def at(self, shares: Floats) -> Scenario:
        """The scenario at shares (k,) of the limits."""
        return self.parameters.scenario_at(self.low + np.asarray(shares) * self.span)

    def scenarios(self, values: Floats, watch: Watch) -> list[Scenario]:
        """The scenarios with the inputs at each row of values (n, k), SI."""
        result = []
        for row in values:
            result.append(self.parameters.scenario_at(row))
            watch.pulse()
        return result

    def shares(self, scenario: Scenario) -> Floats:
        """Where a scenario lies (k,)."""
        return np.asarray((self.parameters.vector(scenario) - self.low) / self.span)

    def miss(self, orbit: Orbit) -> float:
        """By what factor, as a logarithm, an orbit misses a wanted value at most."""
        return max((abs(math.log(getattr(orbit, name) / value)) for name, value in self.wanted.items()), default=0.0)
