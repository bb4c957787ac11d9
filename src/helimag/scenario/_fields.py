"""Field types of a scenario: numbers that are SI inside and text with a unit in a file."""

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, PlainSerializer, ValidationInfo, WithJsonSchema

from helimag import quantities as q
from helimag.errors import InputError


def _quantity(kind: q.Kind, sign: Literal["any", "positive", "not negative"] = "any") -> Any:
    """A float field that reads text with a unit of this kind, and writes it again when serialised for a file."""

    def read(value: object, info: ValidationInfo) -> float:
        if isinstance(value, str):
            return q.parse(value, kind)
        in_file = bool(info.context and info.context.get("file"))
        if isinstance(value, (int, float)) and not isinstance(value, bool) and not in_file:
            if math.isfinite(value):
                return float(value)
            raise InputError(f"must be a finite number of {kind.si}; got {value}")
        raise InputError(f"must be {kind.name} written with its unit, such as '{kind.example}'; got {value!r}")

    def check(value: float) -> float:
        if (sign == "positive" and value <= 0.0) or (sign == "not negative" and value < 0.0):
            raise InputError(f"must be {sign}; got '{q.show(value, kind)}'")
        return value

    def write(value: float) -> str:
        return q.show(value, kind)

    schema = {"type": "string", "description": f"{kind.name} with its unit", "examples": [kind.example]}
    serializer = PlainSerializer(write, when_used="json")
    return Annotated[float, BeforeValidator(read), AfterValidator(check), serializer, WithJsonSchema(schema)]


Length = _quantity(q.LENGTH)
Size = _quantity(q.LENGTH, "positive")
Angle = _quantity(q.ANGLE)
AngularRate = _quantity(q.ANGULAR_RATE)
Frequency = _quantity(q.FREQUENCY)
Velocity = _quantity(q.VELOCITY)
Time = _quantity(q.TIME, "positive")
Force = _quantity(q.FORCE)
Moment = _quantity(q.MOMENT, "positive")
Viscosity = _quantity(q.VISCOSITY, "positive")
Density = _quantity(q.DENSITY, "not negative")
LengthRange = tuple[Length, Length]
