"""Field types of a scenario: numbers that are SI inside and text with a unit in a file."""

import json
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    Tag,
    TypeAdapter,
    ValidationInfo,
)
from pydantic_core import CoreSchema, core_schema

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario._limits import check_size, sizes

TEXT, TEXTS, HASH = "_canonical", "_texts", "_hash"  # beside the fields, and none of them: what is kept of a part
UNDECIDING = {"moment_uncertainty"}  # field of a part that decides no run


class Part(BaseModel):
    """A part of a scenario, or of another file: frozen, and without keys it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @property
    def canonical(self) -> str:
        """All that decides a run, as JSON with sorted keys; kept, as runs of a sweep share all parts but one or two."""
        kept: str | None = self.__dict__.get(TEXT)
        if kept is None:
            told = sorted(self._texts.items())
            decisive = [f'"{name}": {text}' for name, text in told if text and name not in UNDECIDING]
            kept = self.__dict__[TEXT] = "{" + ", ".join(decisive) + "}"
        return kept

    @property
    def _texts(self) -> dict[str, str]:
        """What each field is there; nothing where it is not given."""
        kept: dict[str, str] | None = self.__dict__.get(TEXTS)
        if kept is None:
            told = self.model_dump(mode="python", exclude_none=True)
            kept = self.__dict__[TEXTS] = {name: json.dumps(value, sort_keys=True) for name, value in told.items()}
        return kept

    def changed(self, changes: Mapping[str, object]) -> Self:
        """A copy with fields changed, here or in parts below, by dotted path; what stays as it is is not checked again.

        Returns
        -------
        Self
            The same as if all had been checked.

        Raises
        ------
        ValueError
            Where a value is refused, or a path leads to anything else than the field of a part.
        """
        values = self.checked(changes)
        copied = self.with_values(values)
        copied.__dict__[TEXTS] = self._texts | {name: _text(value) for name, value in values.items()}
        return type(self).model_validate(copied)  # its rules, which are no field's

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """A copy with values that are checked: :meth:`model_copy` in a third of its time, which counts in sweeps."""
        copied = type(self).__new__(type(self))
        now = {**self.__dict__, **values}
        object.__setattr__(copied, "__dict__", {name: now[name] for name in type(self).__pydantic_fields__})
        object.__setattr__(copied, "__pydantic_fields_set__", self.__pydantic_fields_set__)
        object.__setattr__(copied, "__pydantic_extra__", None)
        object.__setattr__(copied, "__pydantic_private__", None)
        return copied

    def checked(self, changes: Mapping[str, object]) -> dict[str, Any]:
        """Values of the fields that :meth:`changed` changes."""
        values: dict[str, Any] = {}
        below: dict[str, dict[str, object]] = {}
        for path, value in changes.items():
            name, _, rest = path.partition(".")
            if rest:
                below.setdefault(name, {})[rest] = value
            else:
                values[name] = _check_of(type(self), name)(value)
        for name, inner in below.items():
            part = self.__dict__.get(name)
            if not isinstance(part, Part):
                raise InputError(f"{name} is no part")
            values[name] = part.changed(inner)
        return values

    def __hash__(self) -> int:
        """Of its fields; kept, as what is worked out for a part is looked up by it for each run."""
        kept: int | None = self.__dict__.get(HASH)
        if kept is None:
            kept = hash(tuple(self.__dict__[name] for name in type(self).model_fields))
            self.__dict__[HASH] = kept
        return kept

    def __getstate__(self) -> dict[Any, Any]:
        """Pydantic's, without the hash, which another process has another of."""
        state = super().__getstate__()
        return state | {"__dict__": {name: value for name, value in state["__dict__"].items() if name != HASH}}

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Pydantic's copy, without what was kept of the values before."""
        copied = super().model_copy(update=update, deep=deep)
        for name in (TEXT, TEXTS, HASH):
            copied.__dict__.pop(name, None)
        return copied


def _text(value: object) -> str:
    """What a checked value of a field is in :attr:`Part.canonical`."""
    if type(value) is float:
        return repr(value)  # as JSON has it, and sooner: nearly all that differs between runs of a sweep
    if value is None:
        return ""
    return value.canonical if isinstance(value, Part) else json.dumps(value)


@cache
def _check_of(kind: type[Part], name: str) -> Callable[[object], Any]:
    """What checks a value of a field as files are checked."""
    if name not in kind.model_fields:
        raise InputError(f"{name} is no field")
    field = kind.model_fields[name]
    adapter: TypeAdapter[Any] = TypeAdapter(Annotated[field.annotation, field])  # type: ignore[arg-type]
    return adapter.validate_python


@dataclass(frozen=True)
class Quantity:
    """Marks a float field as a physical quantity: read from text with a unit, written as such into files.

    A bare number is taken as SI from Python and refused in a file.
    """

    kind: q.Kind
    sign: Literal["any", "positive", "not negative"] = "any"

    def read(self, value: object, info: ValidationInfo) -> float:
        """SI value of text with a unit, or of a number given from Python."""
        context = info.context
        in_file = bool(context and context.get("file"))
        least, most = self._sensible
        if type(value) is float and least <= value <= most and not in_file:
            return value  # what nearly every number of a sweep's runs is
        return self.checked(value, in_file=in_file)

    @cached_property
    def _sensible(self) -> tuple[float, float]:
        """Least and largest number (SI) that has the sign that is wanted, and a sensible size."""
        least, most = sizes(self.kind)
        low = {"any": -most, "positive": max(least, sys.float_info.min), "not negative": 0.0}
        return low[self.sign], most

    def checked(self, value: object, *, in_file: bool = False) -> float:
        """SI value, whose sign is as wanted and whose size is sensible."""
        number = self._number(value, in_file=in_file)
        if (self.sign == "positive" and number <= 0.0) or (self.sign == "not negative" and number < 0.0):
            raise InputError(f"must be {self.sign}; got '{q.show(number, self.kind)}'")
        check_size(number, self.kind, positive=self.sign == "positive")
        return number

    def _number(self, value: object, *, in_file: bool) -> float:
        if isinstance(value, str):
            return q.parse(value, self.kind)
        if in_file or isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(
                f"must be {self.kind.name} written with its unit, such as '{self.kind.example}'; got {value!r}"
            )
        if not math.isfinite(value):
            raise InputError(f"must be a finite number of {self.kind.si}; got {value}")
        return float(value)

    def write(self, value: float) -> str:
        """Text that reads back as exactly the same number."""
        return q.show(value, self.kind)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(
            self.read,
            serialization=core_schema.plain_serializer_function_ser_schema(self.write, when_used="json"),
        )

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"type": "string", "description": f"{self.kind.name} with its unit", "examples": [self.kind.example]}


Length = Annotated[float, Quantity(q.LENGTH)]
Size = Annotated[float, Quantity(q.LENGTH, "positive")]
Angle = Annotated[float, Quantity(q.ANGLE)]
AngularRate = Annotated[float, Quantity(q.ANGULAR_RATE)]
Frequency = Annotated[float, Quantity(q.FREQUENCY)]
Velocity = Annotated[float, Quantity(q.VELOCITY)]
Acceleration = Annotated[float, Quantity(q.ACCELERATION, "positive")]
Instant = Annotated[float, Quantity(q.TIME)]
Speed = Annotated[float, Quantity(q.VELOCITY, "positive")]
Time = Annotated[float, Quantity(q.TIME, "positive")]
Force = Annotated[float, Quantity(q.FORCE)]
Pull = Annotated[float, Quantity(q.FORCE, "not negative")]
Moment = Annotated[float, Quantity(q.MOMENT, "positive")]
Remanence = Annotated[float, Quantity(q.REMANENCE, "positive")]
Viscosity = Annotated[float, Quantity(q.VISCOSITY, "positive")]
Density = Annotated[float, Quantity(q.DENSITY, "not negative")]
Mass = Annotated[float, Quantity(q.MASS, "positive")]
Inertia = Annotated[float, Quantity(q.INERTIA, "not negative")]
LengthRange = tuple[Length, Length]


def _form(value: object) -> str:
    """Which form a heading is given in."""
    return "end" if isinstance(value, str) else "angles"


Heading = Annotated[
    Annotated[Literal["helix", "head"], Tag("end")] | Annotated[tuple[Angle, Angle, Angle], Tag("angles")],
    Discriminator(_form),
]
