"""What is asked of a design: inputs to choose with their limits, and values that the device is to have."""

import math
from collections.abc import Mapping

import numpy as np

from helimag.errors import InputError
from helimag.orbits import Floats, Orbit, Watch
from helimag.scenario import Input, Scenario

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
        self.limits = dict(default if limits is None else limits)
        self.scenario = scenario
        self.inputs = [Input(path) for path in self.limits]
        self.low = np.array([low for low, _ in self.limits.values()])
        self.span = np.array([high for _, high in self.limits.values()]) - self.low
        for given, span in zip(self.inputs, self.span, strict=True):
            given.value(scenario)
            if not span > 0.0:
                raise InputError(f"limits of {given.path} must be a lower and a higher value")
        self.wanted = {name: value for name, value in wanted.items() if value is not None}
        if "radius" in self.wanted and scenario.drive.yaw_rate == 0.0:
            raise InputError("radius needs a circular run: drive.yaw_rate must not be zero")
        for name, value in self.wanted.items():
            if not value > 0.0:
                raise InputError(f"{name} must be greater than zero; got {value}")
        if len(self.wanted) >= len(self.inputs):
            raise InputError("design needs more inputs to choose than wanted values: name more limits")
        self.random = np.random.default_rng(seed)

    @property
    def wish(self) -> str:
        """The wanted values in words."""
        units = {"speed": "mm/s", "radius": "mm"}
        return " and ".join(f"with {name} {1e3 * value:.4g} {units[name]}" for name, value in self.wanted.items())

    def at(self, shares: Floats) -> Scenario:
        """The scenario at shares (k,) of the limits."""
        values = self.low + np.asarray(shares) * self.span
        scenario = self.scenario
        for given, value in zip(self.inputs, values, strict=True):
            scenario = given.changed(scenario, float(value))
        return scenario

    def all_at(self, places: Floats, watch: Watch) -> list[Scenario]:
        """The scenarios at places (n, k)."""
        scenarios = []
        for place in places:
            scenarios.append(self.at(place))
            watch.pulse()
        return scenarios

    def shares(self, scenario: Scenario) -> Floats:
        """Where a scenario lies (k,)."""
        return np.asarray((np.array([given.value(scenario) for given in self.inputs]) - self.low) / self.span)

    def miss(self, orbit: Orbit) -> float:
        """By what factor, as a logarithm, an orbit misses a wanted value at most."""
        return max((abs(math.log(getattr(orbit, name) / value)) for name, value in self.wanted.items()), default=0.0)

    def perturbed(self, here: Floats, half: Floats, signs: Floats, watch: Watch) -> list[Scenario]:
        """Scenarios with inputs off ``here`` (k,) by ``half`` (k,) times each row of ``signs`` (n, k), SI."""
        result = []
        for row in signs:
            scenario = self.scenario
            for given, value in zip(self.inputs, here + row * half, strict=True):
                scenario = given.changed(scenario, float(value))
            result.append(scenario)
            watch.pulse()
        return result
