"""Quantities with units: ``"150 mm"`` to 0.15 and back. The only place that knows pint.

Angles are a dimension of their own here, unlike in SI, so that "60 rpm" is refused as a frequency in Hz and not taken
for 6.28 Hz, and "1.8 Hz" is refused as an angular rate.
"""

import math
import re
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from helimag.errors import InputError

if TYPE_CHECKING:
    import pint


class Kind(NamedTuple):
    """A physical kind: its name in messages, SI unit, the unit it is shown in, and an example."""

    name: str
    si: str
    shown: str
    example: str


LENGTH = Kind("a length", "m", "mm", "150 mm")
ANGLE = Kind("an angle", "rad", "deg", "12.7 deg")
ANGULAR_RATE = Kind("an angular rate", "rad/s", "deg/s", "1.8 deg/s")
FREQUENCY = Kind("a frequency", "Hz", "Hz", "3.3 Hz")
VELOCITY = Kind("a velocity", "m/s", "mm/s", "0.825 mm/s")
ACCELERATION = Kind("an acceleration", "m/s^2", "m/s^2", "1 m/s^2")
TIME = Kind("a time", "s", "s", "1800 s")
FORCE = Kind("a force", "N", "uN", "28.28 uN")
MOMENT = Kind("a magnetic moment", "A m^2", "A m^2", "18.89 A m^2")
REMANENCE = Kind("a flux density", "T", "T", "1.35 T")
VISCOSITY = Kind("a dynamic viscosity", "Pa s", "Pa s", "1 Pa s")
DENSITY = Kind("a density", "kg/m^3", "kg/m^3", "971 kg/m^3")

# The units understood, in pint's language. A list of our own: it loads in milliseconds, and gives angle a dimension.
_DEFINITIONS = """
milli- = 1e-3 = m-
micro- = 1e-6 = µ- = μ- = u-
nano- = 1e-9 = n-
kilo- = 1e3 = k-
centi- = 1e-2 = c-
meter = [length] = m = metre
second = [time] = s = sec
minute = 60 * second = min
hour = 3600 * second = h
gram = [mass] = g
ampere = [current] = A
radian = [angle] = rad
degree = 0.017453292519943295 * radian = deg = °
turn = 6.283185307179586 * radian = _ = revolution = rev
rpm = turn / minute
hertz = 1 / second = Hz
newton = 1000 * gram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
poise = 0.1 * pascal * second = P
tesla = newton / ampere / meter = T
"""
_QUANTITY = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf))\s*([^\W\d][\w\s/*^·²³°.-]{0,40}|°[\w/]*)?\s*"
)


@cache
def _registry() -> "pint.UnitRegistry":
    import pint

    registry: pint.UnitRegistry = pint.UnitRegistry(None)
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


def _spelled(unit: str) -> str:
    """The unit as pint reads it: products by space or dot, powers by ^ or superscript."""
    plain = unit.strip().replace("·", " ").replace("²", "^2").replace("³", "^3").replace("^", "**")
    return re.sub(r"(?<=[\w])\s+(?=[A-Za-zµμ°])", " * ", plain)


@cache
def _factor(unit: str, kind: Kind) -> float | str:
    """What one ``unit`` is in the kind's SI unit, or why it is none."""
    import pint

    if re.search(r"\*\*\s*\d{2,}|\*\*\s*\d\s*\*\*", _spelled(unit)):
        return "whose unit has an absurd power"
    try:
        return float(_registry().Quantity(1.0, _spelled(unit)).to(_spelled(kind.si)).magnitude)
    except pint.DimensionalityError:
        hint = "; count turns per second in Hz" if kind is FREQUENCY and _is_rotation(unit) else ""
        return f"which is not in a unit of {kind.name.partition(' ')[2]}{hint}"
    except pint.UndefinedUnitError:
        return f"whose unit '{unit}' is not known"
    except Exception:  # noqa: BLE001  pint's parser leaks whatever its tokenizer raises; every case is the same bad unit
        return f"whose unit '{unit}' cannot be read"


def _is_rotation(unit: str) -> bool:
    return isinstance(_factor(unit, ANGULAR_RATE), float)


def _scaled(number: float, factor: float) -> float:
    """``number * factor``, dividing where the factor is one over a whole number: 5 / 1e6 is exact, 5 * 1e-6 is not."""
    inverse = round(1.0 / factor)
    return number / inverse if inverse > 1 and abs(inverse * factor - 1.0) < 1e-12 else number * factor


def parse(text: str, kind: Kind) -> float:
    """Read a quantity such as ``"150 mm"`` and return it in SI (angles in radians).

    Raises
    ------
    InputError
        Where the text is not a number with a unit of this kind, or not finite.

    Examples
    --------
    >>> parse("150 mm", LENGTH)
    0.15
    >>> parse("150", LENGTH)
    Traceback (most recent call last):
    helimag.errors.InputError: must be a length such as '150 mm'; got '150', which has no unit
    """
    expected = f"must be {kind.name} such as '{kind.example}'; got '{text}'"
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise InputError(expected)
    number, unit = match.groups()
    if unit is None:
        raise InputError(f"{expected}, which has no unit")
    factor = _factor(unit.strip(), kind)
    if isinstance(factor, str):
        raise InputError(f"{expected}, {factor}")
    value = _scaled(float(number), factor)
    if not math.isfinite(value):
        raise InputError(f"{expected}, which is not finite")
    return value


def show(value: float, kind: Kind) -> str:
    """Write an SI value as text that :func:`parse` turns back into exactly the same number.

    Examples
    --------
    >>> show(0.15, LENGTH)
    '150 mm'
    >>> parse(show(0.1 + 0.2, LENGTH), LENGTH) == 0.1 + 0.2
    True
    """
    for unit in (kind.shown, kind.si):
        factor = _factor(unit, kind)
        scaled = _scaled(value, 1.0 / float(factor))
        for digits in (6, 9, 12, 15, 17):
            number = f"{scaled:.{digits}g}"
            if _scaled(float(number), float(factor)) == value:
                return f"{number} {unit}"
    return f"{value!r} {kind.si}"
