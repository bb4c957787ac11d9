"""Devices that a scenario may really have, each as likely, and the errors of a lab on top."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from helimag.engine import start_state
from helimag.ensembles.perturbed import Copies, Perturbation
from helimag.errors import InputError
from helimag.scenario import Input, Normal, Scenario, check_apart, varied

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Noise:
    """Errors of a lab: standard deviations of inputs about what a scenario says (SI), of the start (m, an axis)."""

    inputs: dict[str, float] = field(default_factory=dict)
    displacement: float = 0.0

    def drawn(self, scenario: Scenario, random: np.random.Generator) -> tuple[Scenario, Floats]:
        """A scenario with errors, and the state (7,) that its run begins in."""
        priors = {path: Normal(Input(path).value(scenario), sd) for path, sd in self.inputs.items()}
        if not priors and self.displacement == 0.0:
            return scenario, start_state(scenario)
        copies = Perturbation(priors, self.displacement).copies(scenario, 1, random)
        return copies.scenarios[0], copies.states[0]


NO_NOISE = Noise()


def noise_of(scenario: Scenario, inputs: Mapping[str, str], displacement: float, where: str) -> Noise:
    """Errors given as text with units, such as ``{"drive.pitch": "0.2 deg"}``; ``where`` names them in messages.

    Returns
    -------
    Noise
        Standard deviations by path, SI.

    Raises
    ------
    InputError
        Where an input cannot be varied, or its standard deviation is not above zero.
    """
    found: dict[str, float] = {}
    for path, sd in inputs.items():
        try:
            found[path] = Input(path).parsed(scenario, sd)
        except InputError as error:
            raise InputError(f"{where} {path}: {error}") from None
        if not found[path] > 0.0:
            raise InputError(f"{where} {path} must be above zero; got {sd!r}")
    return Noise(found, displacement)


@dataclass(frozen=True)
class Devices:
    """Devices drawn from what is known of one: values of inputs that are uncertain together, and errors of each run.

    The same devices with the same errors come out for whatever scenario they are put into, so that two scenarios differ
    by what they are and not by what was drawn.

    Attributes
    ----------
    inputs
        Paths of the uncertain inputs (k).
    best
        (k,): the likeliest device, SI.
    values
        (n, k): the devices drawn, SI.
    noise
        Errors of each run on top.
    seed
        Of the errors.
    """

    inputs: tuple[str, ...]
    best: Floats
    values: Floats
    noise: Noise = NO_NOISE
    seed: int = 0

    def __len__(self) -> int:
        """How many were drawn."""
        return len(self.values)

    @property
    def digest(self) -> str:
        """SHA-256 of all that decides the runs."""
        told = hashlib.sha256(repr((self.inputs, self.seed, self.noise)).encode())
        told.update(self.best.tobytes() + self.values.tobytes())
        return told.hexdigest()

    def check_apart_from(self, paths: Sequence[str], what: str) -> None:
        """Raise InputError where an uncertain input, or another one of the device, is varied; ``what`` says as what."""
        for path in paths:
            if path in self.inputs:
                raise InputError(f"'{path}' is {what}, but the calibration decides it: leave it out of one of them")
            if path.startswith("device."):
                raise InputError(
                    f"'{path}' is {what}, but the calibration is of one device and says nothing of others: leave it out"
                )
        check_apart(dict.fromkeys((*self.inputs, *paths)))

    def nominal(self, scenario: Scenario) -> Scenario:
        """A scenario with the likeliest device, without errors.

        Returns
        -------
        Scenario
            A copy.
        """
        return self._with(scenario, self.best)

    def copy(self, scenario: Scenario, place: int) -> tuple[Scenario, Floats]:
        """A scenario with one of the devices and the errors of its run, and the state (7,) that it begins in.

        Returns
        -------
        tuple of Scenario and ndarray
            What to run, and the state (7,) to begin in.

        Raises
        ------
        InputError
            Where the scenario cannot have these values.
        """
        random = np.random.default_rng([self.seed, place + 1])
        return self.noise.drawn(self._with(scenario, self.values[place]), random)

    def copies(self, scenario: Scenario) -> Copies:
        """A scenario with each of the devices, as :meth:`copy`.

        Returns
        -------
        Copies
            As many as devices.
        """
        scenarios, states = zip(*(self.copy(scenario, place) for place in range(len(self))), strict=True)
        return Copies(scenarios, np.array(states))

    def _with(self, scenario: Scenario, values: Floats) -> Scenario:
        return varied(scenario, dict(zip(self.inputs, values.tolist(), strict=True))) if self.inputs else scenario
