"""Scalar inputs of a scenario: named by a dotted path, read, shown with their unit, changed. The only place for it."""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario._device import Weight
from helimag.scenario._fields import Quantity
from helimag.scenario._leaves import Leaf, leaf, numbers
from helimag.scenario._scenario import Scenario

MOST_NAMED = 8  # paths in a message


@dataclass(frozen=True)
class Derived:
    """An input that is no field: its kind, its value, and the field that it sets to what.

    Attributes
    ----------
    kind
        Physical kind.
    value
        SI value in a scenario.
    sets
        Path of the field that it changes.
    written
        That field's value where the input has an SI value, the rest of the scenario as given.
    """

    kind: q.Kind
    value: Callable[[Scenario], float]
    sets: str
    written: Callable[[Scenario, float], object]


def _speed(scenario: Scenario) -> float:
    return math.hypot(*scenario.drive.velocity)


def _velocity(scenario: Scenario, speed: float) -> tuple[float, float, float]:
    x, y, z = scenario.drive.velocity
    length = _speed(scenario)
    return (speed, 0.0, 0.0) if length == 0.0 else (x / length * speed, y / length * speed, z / length * speed)


DERIVED = {"drive.speed": Derived(q.VELOCITY, _speed, "drive.velocity", _velocity)}


@dataclass(frozen=True)
class Input:
    """A scalar input of a scenario.
    A path is dotted: ``drive.pitch``; a vector's component ``drive.start.y``, a range's end ``workspace.walls.x.low``;
    ``magnet.moment`` of a single magnet, ``magnet.1.moment`` of the second of several. ``drive.speed`` is the length of
    ``drive.velocity``: changing it keeps the direction, from rest it is along x, and a negative one goes the other way.
    Any number may be varied, also one that the scenario leaves out (``workspace.floor``): :meth:`changed` gives it
    then. Words (``device.helix.handedness``) have no numbers in between; only a sweep takes a list of them, see
    :meth:`choices`.

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
        """The last part of the path, in words; a component with what it is of."""
        steps = self.path.split(".")
        component = steps[-1] in {"x", "y", "z", "low", "high"} and len(steps) > 1
        return " ".join(steps[-2:] if component else steps[-1:]).replace("_", " ")

    @property
    def label(self) -> str:
        """Name of a coordinate: the drive's own (``pitch``), others with their part (``helix_pitch``)."""
        rest = self.path.partition(".")[2]
        return (rest if rest[:1].isalpha() else self.path).replace(".", "_")

    def value(self, scenario: Scenario) -> float:
        """SI value in a scenario.

        Returns
        -------
        float
            SI.

        Raises
        ------
        InputError
            Where the path is not a single number, or the scenario does not give it.
        """
        found = self.found(scenario)
        if found is None:
            raise InputError(f"'{self.path}' is not given in this scenario; give it a value first")
        return found

    def found(self, scenario: Scenario) -> float | None:
        """SI value in a scenario; None of a number that it does not give.

        Returns
        -------
        float or None
            SI.

        Raises
        ------
        InputError
            Where the path is not a single number.
        """
        if self.path in DERIVED:
            return DERIVED[self.path].value(scenario)
        value = self._number(scenario).value
        return None if value is None else float(value)

    def within(self, scenario: Scenario, low: float, high: float) -> bool:
        """Whether the scenario gives it a value in a range (SI)."""
        found = self.found(scenario)
        return found is not None and low <= found <= high

    def changed(self, scenario: Scenario, value: float) -> Scenario:
        """The scenario with this input at an SI value.

        Returns
        -------
        Scenario
            A copy.

        Raises
        ------
        InputError
            Where the path is not a single number, or the value does not fit.
        """
        self.check(scenario)
        return varied(scenario, {self.path: value})

    def check(self, scenario: Scenario) -> None:
        """Raise InputError where the path is not a single number that may be varied, naming what may be instead."""
        if self.path not in DERIVED:
            self._number(scenario)

    def choices(self, scenario: Scenario) -> tuple[str, ...]:
        """The words among which a field is chosen; none of a number.

        Returns
        -------
        tuple of str
            As files have them.

        Raises
        ------
        InputError
            Where the path is neither.
        """
        if self.path in DERIVED:
            return ()
        words = leaf(scenario, self.path).choices
        if not words:
            self._number(scenario)
        return words

    def kind(self, scenario: Scenario) -> q.Kind | None:
        """Physical kind, with its units; None of a number without a unit.

        Returns
        -------
        Kind or None
            As :mod:`helimag.quantities` has them.

        Raises
        ------
        InputError
            Where the path is not a single number.
        """
        return DERIVED[self.path].kind if self.path in DERIVED else self._number(scenario).kind

    def parsed(self, scenario: Scenario, text: str) -> float:
        """SI value of text with a unit, such as ``"12.7 deg"``, whether or not the scenario can have it.

        Returns
        -------
        float
            SI.

        Raises
        ------
        InputError
            Where it is not such text.
        """
        kind = self.kind(scenario)
        if kind is not None:
            return q.parse(text, kind)
        try:
            return float(text)
        except ValueError:
            raise InputError(f"must be a number; got '{text}'") from None

    def read(self, scenario: Scenario, text: str) -> float:
        """SI value of text with a unit, which the scenario can have.

        Returns
        -------
        float
            SI.

        Raises
        ------
        InputError
            Where it is not such text, or the value does not fit.
        """
        try:
            value = self.parsed(scenario, text)
        except InputError as error:
            raise error if str(error).startswith("'") else InputError(f"{self.path} {error}") from None
        self.changed(scenario, value)
        return value

    def show(self, scenario: Scenario, value: float, digits: int = 5) -> str:
        """An SI value as text with the unit that the scenario's file would use."""
        number, unit = self.shown(scenario, value)
        return f"{number:.{digits}g} {unit}".strip()

    def shown(self, scenario: Scenario, value: float) -> tuple[float, str]:
        """Number and unit in which a file would write an SI value."""
        kind = self.kind(scenario)
        return (value, "") if kind is None else (value / q.parse(f"1 {kind.shown}", kind), kind.shown)

    def _number(self, scenario: Scenario) -> Leaf:
        found = leaf(scenario, self.path)
        if not found.number:
            raise InputError(f"'{self.path}' must be a single number to be varied; {_instead(found, self.path)}")
        if isinstance(found.part, Weight) and found.value is None:
            given = [name for name in Weight.model_fields if getattr(found.part, name) is not None]
            where = self.path.rpartition(".")[0]
            raise InputError(
                f"'{self.path}' is not given in this scenario, which has an alternative to it; "
                f"vary one of {', '.join(f'{where}.{name}' for name in sorted(given))}"
            )
        return found


def varied(scenario: Scenario, values: Mapping[str, object]) -> Scenario:
    """The scenario with inputs changed, all at once: as :meth:`Scenario.replaced`, and derived inputs too.

    Parameters
    ----------
    values
        By path: SI values, text with a unit, words of a choice, or what a field as a whole may be.

    Returns
    -------
    Scenario
        A copy.

    Raises
    ------
    InputError
        Where a value does not fit, or two inputs change the same field.
    """
    check_apart(values)
    changes: dict[str, object] = {}
    for path, value in values.items():
        derived = DERIVED.get(path)
        if derived is None:
            changes[path] = value
        else:
            changes[derived.sets] = derived.written(scenario, _si(path, value, derived.kind))
    return scenario.replaced(changes)


def _si(path: str, value: object, kind: q.Kind) -> float:
    """SI value of a derived input, by the rules of a field."""
    try:
        return Quantity(kind).checked(value)
    except InputError as error:
        raise InputError(f"{path} {error}") from None


def check_apart(paths: Mapping[str, object]) -> None:
    """Raise InputError where a derived input and another one change the same field."""
    for path in DERIVED.keys() & paths.keys():
        field = DERIVED[path].sets
        for other in paths:
            if f"{other}.".startswith(f"{field}.") or field.startswith(f"{other}."):
                raise InputError(f"'{path}' and '{other}' change the same field; vary one of them")


def scalar_inputs(scenario: Scenario) -> Iterator[Input]:
    """Every input of a scenario that has a value."""
    for path, found in numbers(Leaf(scenario, Scenario)):
        if found.value is not None:
            yield Input(path)
    for path in DERIVED:
        yield Input(path)


def _instead(found: Leaf, path: str) -> str:
    """What a path is that is no number, and which numbers are there."""
    if found.choices:
        return f"it is a choice of {', '.join(found.choices)}"
    below = [each for each, _ in numbers(found, path)]
    if not below:
        return "it is text" if isinstance(found.value, str) else "there is no single number in it"
    return f"vary one of {', '.join(below[:MOST_NAMED])}" + (" ..." if len(below) > MOST_NAMED else "")


def drive_inputs(scenario: Scenario, *, without: Collection[str] = ()) -> str:
    """What the drive does, as a line: frequency, pitch, distance, and how the magnet moves; but for some inputs."""
    drive = scenario.drive
    if drive.path is not None:
        names = ["frequency"]
    else:
        names = ["frequency", "pitch", "distance", "yaw_rate", *(["speed"] if any(drive.velocity) else [])]
    inputs = [Input(f"drive.{name}") for name in names if f"drive.{name}" not in without]
    told = [f"{given.name} {given.show(scenario, given.value(scenario))}" for given in inputs]
    return ", ".join([*told, *(["magnet along a path of samples"] if drive.path is not None else [])])
