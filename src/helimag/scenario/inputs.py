"""One scalar input of a scenario, named by its dotted path: read it, change it, show it with its unit."""

import math
from dataclasses import dataclass
from typing import Any

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario import Scenario

_KINDS = [kind for kind in vars(q).values() if isinstance(kind, q.Kind)]
SPEED = "drive.speed"  # not a field: the length of drive.velocity, whose direction is kept


@dataclass(frozen=True)
class Input:
    """A scalar input such as ``drive.pitch``, or ``drive.speed`` for the length of ``drive.velocity``.

    Examples
    --------
    >>> import helimag as hm
    >>> scenario, pitch = hm.load("paper/fig3c"), Input("drive.pitch")
    >>> pitch.show(scenario, pitch.value(scenario))
    '12.7 deg'
    >>> pitch.changed(scenario, 0.25).drive.pitch
    0.25
    """

    path: str

    @property
    def name(self) -> str:
        """The last part of the path, in words."""
        return self.path.rpartition(".")[2].replace("_", " ")

    def value(self, scenario: Scenario) -> float:
        """SI value in a scenario.

        Raises
        ------
        InputError
            Where the path is not a single number.
        """
        if self.path == SPEED:
            return math.hypot(*scenario.drive.velocity)
        found = _at(scenario.model_dump(mode="python"), self.path)
        if isinstance(found, bool) or not isinstance(found, (int, float)):
            raise InputError(f"'{self.path}' must be a single number to be varied; it is {found!r}")
        return float(found)

    def changed(self, scenario: Scenario, value: float) -> Scenario:
        """The scenario with this input at an SI value."""
        if self.path == SPEED:
            return scenario.replaced({"drive.velocity": self._velocity(scenario, value)})
        return scenario.replaced({self.path: value})

    def _velocity(self, scenario: Scenario, speed: float) -> tuple[float, ...]:
        now = math.hypot(*scenario.drive.velocity)
        if not now > 0.0:
            raise InputError("drive.speed needs a drive.velocity that is not zero, whose direction it keeps")
        return tuple(speed / now * v for v in scenario.drive.velocity)

    def read(self, scenario: Scenario, text: str) -> float:
        """SI value of text with a unit, such as ``"12.7 deg"``."""
        if self.path == SPEED:
            return q.parse(text, q.VELOCITY)
        self.value(scenario)
        return self.value(scenario.replaced({self.path: text}))

    def show(self, scenario: Scenario, value: float, digits: int = 5) -> str:
        """An SI value as text with the unit that the scenario's file would use."""
        number, unit = self.shown(scenario, value)
        return f"{number:.{digits}g} {unit}".strip()

    def shown(self, scenario: Scenario, value: float) -> tuple[float, str]:
        """Number and unit in which a file would write an SI value."""
        kind = self.kind(scenario)
        return (value, "") if kind is None else (value / q.parse(f"1 {kind.shown}", kind), kind.shown)

    def kind(self, scenario: Scenario) -> q.Kind | None:
        """Physical kind, with its units; None for a plain number."""
        if self.path == SPEED:
            return q.VELOCITY
        text = _at(scenario.model_dump(mode="json"), self.path)
        if not isinstance(text, str):
            return None
        unit = text.partition(" ")[2]
        return next(kind for kind in _KINDS if unit in (kind.shown, kind.si))


def _at(data: Any, path: str) -> object:
    for step in path.split("."):
        if isinstance(data, (list, tuple)) and len(data) == 1:
            data = data[0]
        if not isinstance(data, dict) or step not in data:
            raise InputError(f"'{path}' is not a field of a scenario")
        data = data[step]
    return data
