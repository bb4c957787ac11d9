"""Several inputs of a scenario as a vector: bounds, units, priors; from a scenario to numbers and back."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from helimag.errors import InputError
from helimag.scenario._scenario import Scenario
from helimag.scenario.inputs import Input, check_apart, varied
from helimag.scenario.priors import Prior, Uniform

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Parameters:
    """Inputs of a scenario that vary together, in order; everything else stays as the scenario has it.

    Attributes
    ----------
    scenario
        What they are inputs of.
    priors
        Each input's path with its prior (SI).
    """

    scenario: Scenario
    priors: tuple[tuple[str, Prior], ...]

    def __post_init__(self) -> None:
        if not self.priors:
            raise InputError("parameters must name at least one input; got none")
        paths = [path for path, _ in self.priors]
        for path in paths:
            Input(path).check(self.scenario)
            if paths.count(path) > 1:
                raise InputError(f"parameters name '{path}' twice")
        check_apart(dict(self.priors))

    @classmethod
    def of(cls, scenario: Scenario, priors: Mapping[str, Prior]) -> "Parameters":
        """Inputs with a prior each.

        Returns
        -------
        Parameters
            In the order given.

        Raises
        ------
        InputError
            Where a path is not a number that may be varied.
        """
        return cls(scenario, tuple(priors.items()))

    @classmethod
    def within(cls, scenario: Scenario, limits: Mapping[str, tuple[float, float]]) -> "Parameters":
        """Inputs between a lowest and a highest value each (SI), all values as likely.

        Returns
        -------
        Parameters
            In the order given.

        Raises
        ------
        InputError
            Where a path is not a number that may be varied, or limits are not a lower and a higher number.
        """
        priors: dict[str, Prior] = {}
        for path, (low, high) in limits.items():
            Input(path).check(scenario)
            try:
                priors[path] = Uniform(low, high)
            except InputError:
                got = f"{low:g}, {high:g}"
                raise InputError(f"limits of {path} must be a lower and a higher value; got {got}") from None
        return cls.of(scenario, priors)

    @cached_property
    def inputs(self) -> tuple[Input, ...]:
        """The inputs."""
        return tuple(Input(path) for path, _ in self.priors)

    @property
    def paths(self) -> tuple[str, ...]:
        """Their paths."""
        return tuple(path for path, _ in self.priors)

    @property
    def names(self) -> tuple[str, ...]:
        """Their names as coordinates, such as ``pitch``."""
        return tuple(each.label for each in self.inputs)

    @property
    def units(self) -> tuple[str, ...]:
        """Their SI units, ``"1"`` of a plain number."""
        kinds = (each.kind(self.scenario) for each in self.inputs)
        return tuple("1" if kind is None else kind.si for kind in kinds)

    @cached_property
    def low(self) -> Floats:
        """Least values (k,), SI."""
        return np.array([prior.low for _, prior in self.priors])

    @cached_property
    def high(self) -> Floats:
        """Largest values (k,), SI."""
        return np.array([prior.high for _, prior in self.priors])

    def vector(self, scenario: Scenario) -> Floats:
        """Values (k,) in a scenario, SI.

        Returns
        -------
        ndarray
            (k,).

        Raises
        ------
        InputError
            Where the scenario does not give one of them.
        """
        return np.array([each.value(scenario) for each in self.inputs])

    def nearest(self, scenario: Scenario) -> Floats:
        """Values (k,) of a scenario brought within the bounds; the median of the prior where it gives none."""
        found = [each.found(scenario) for each in self.inputs]
        middle = self.from_unit(np.full(len(found), 0.5))
        return self.clip([m if value is None else value for value, m in zip(found, middle, strict=True)])

    def scenario_at(self, values: ArrayLike) -> Scenario:
        """The scenario with the inputs at values (k,), SI.

        Returns
        -------
        Scenario
            A copy.

        Raises
        ------
        InputError
            Where they do not make a scenario.
        """
        return varied(self.scenario, dict(zip(self.paths, self._shaped(values, 1).tolist(), strict=True)))

    def scenarios(self, values: ArrayLike) -> list[Scenario]:
        """One scenario for each row of values (n, k), SI.

        Returns
        -------
        list of Scenario
            As many as rows.

        Raises
        ------
        InputError
            Where a row does not make a scenario.
        """
        return [self.scenario_at(row) for row in self._shaped(values, 2)]

    def from_unit(self, shares: ArrayLike) -> Floats:
        """Values (..., k), SI, of points (..., k) of the unit cube: what spreads evenly there follows the priors here.

        Returns
        -------
        ndarray
            (..., k), SI.

        Raises
        ------
        InputError
            Where a point is not in the unit cube.
        """
        points = self._shaped(shares)
        if not np.all((points >= 0.0) & (points <= 1.0)):
            raise InputError("points must lie in the unit cube: every coordinate from 0 to 1")
        columns = [prior.quantile(points[..., i]) for i, (_, prior) in enumerate(self.priors)]
        return np.stack(columns, axis=-1)

    def inside(self, values: ArrayLike) -> NDArray[np.bool_]:
        """Whether values (..., k) lie within all bounds (...); NaN does not."""
        given = self._shaped(values)
        return np.asarray(np.all((given >= self.low) & (given <= self.high), axis=-1))

    def clip(self, values: ArrayLike) -> Floats:
        """Values (..., k) brought within the bounds."""
        return np.clip(self._shaped(values), self.low, self.high)

    def show(self, values: ArrayLike, digits: int = 5) -> dict[str, str]:
        """Values (k,) by path, as text with units."""
        given = zip(self.inputs, self._shaped(values, 1), strict=True)
        return {each.path: each.show(self.scenario, float(value), digits) for each, value in given}

    def _shaped(self, values: ArrayLike, dimensions: int | None = None) -> Floats:
        given = np.asarray(values, dtype=np.float64)
        count = len(self.priors)
        if given.ndim < 1 or given.shape[-1] != count or dimensions not in {None, given.ndim}:
            raise InputError(f"values must have one for each of {count} inputs along the last axis; got {given.shape}")
        return given
