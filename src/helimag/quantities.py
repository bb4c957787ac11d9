"""Quantities with units: ``"150 mm"`` to 0.15 and back. The only place that knows pint.

Angles are a dimension of their own here, unlike in SI, so that "6.28 rad/s" is not taken for 6.28 Hz, and
"1.8 Hz" is refused as an angular rate. A frequency counts turns: "60 rpm" and "1 rev/s" are 1 Hz.
"""

import math
import re
import unicodedata
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from helimag.errors import InputError

if TYPE_CHECKING:
    import pint


DEGREE, TURN = math.pi / 180.0, 2.0 * math.pi


class Kind(NamedTuple):
    """A physical kind: its name in messages, SI unit, the unit it is shown in, an example, and units in use.

    Those come with what they are in the SI unit, so that reading them does not wait for pint, which is slow to import.
    """

    name: str
    si: str
    shown: str
    example: str
    units: tuple[tuple[str, float], ...]

    @property
    def known(self) -> str:
        """The units in use, for messages."""
        return ", ".join(unit for unit, _ in self.units)


LENGTH = Kind("a length", "m", "mm", "150 mm", (("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("inch", 0.0254)))
ANGLE = Kind("an angle", "rad", "deg", "12.7 deg", (("deg", DEGREE), ("°", DEGREE), ("rad", 1.0), ("turn", TURN)))
ANGULAR_RATE = Kind(
    "an angular rate",
    "rad/s",
    "deg/s",
    "1.8 deg/s",
    (("deg/s", DEGREE), ("rad/s", 1.0), ("rpm", TURN / 60.0), ("rev/s", TURN)),
)
FREQUENCY = Kind("a frequency", "Hz", "Hz", "3.3 Hz", (("Hz", 1.0), ("1/s", 1.0), ("rev/s", 1.0), ("rpm", 1.0 / 60.0)))
VELOCITY = Kind("a velocity", "m/s", "mm/s", "0.825 mm/s", (("m/s", 1.0), ("mm/s", 1e-3), ("mm/min", 1e-3 / 60.0)))
ACCELERATION = Kind("an acceleration", "m/s^2", "m/s^2", "1 m/s^2", (("m/s^2", 1.0), ("mm/s^2", 1e-3)))
TIME = Kind("a time", "s", "s", "1800 s", (("s", 1.0), ("ms", 1e-3), ("min", 60.0), ("h", 3600.0)))
FORCE = Kind("a force", "N", "uN", "28.28 uN", (("N", 1.0), ("mN", 1e-3), ("uN", 1e-6), ("nN", 1e-9)))
MOMENT = Kind("a magnetic moment", "A m^2", "A m^2", "18.89 A m^2", (("A m^2", 1.0), ("mA m^2", 1e-3), ("J/T", 1.0)))
REMANENCE = Kind("a flux density", "T", "T", "1.35 T", (("T", 1.0), ("mT", 1e-3), ("G", 1e-4)))
VISCOSITY = Kind(
    "a dynamic viscosity", "Pa s", "Pa s", "1 Pa s", (("Pa s", 1.0), ("mPa s", 1e-3), ("P", 0.1), ("cP", 1e-3))
)
DENSITY = Kind("a density", "kg/m^3", "kg/m^3", "971 kg/m^3", (("kg/m^3", 1.0), ("g/cm^3", 1e3), ("g/mL", 1e3)))
MASS = Kind("a mass", "kg", "kg", "1.2 kg", (("kg", 1.0), ("g", 1e-3)))
INERTIA = Kind("a moment of inertia", "kg m^2", "kg m^2", "0.002 kg m^2", (("kg m^2", 1.0), ("g cm^2", 1e-7)))

# The units understood, in pint's language. A list of our own: it loads in milliseconds, and gives angle a dimension.
_DEFINITIONS = """
deci- = 1e-1 = d-
milli- = 1e-3 = m-
micro- = 1e-6 = µ- = μ- = u-
nano- = 1e-9 = n-
pico- = 1e-12 = p-
kilo- = 1e3 = k-
centi- = 1e-2 = c-
meter = [length] = m = metre
inch = 0.0254 * meter = in = inches
micron = 1e-6 * meter
angstrom = 1e-10 * meter = Å
cc = 1e-6 * meter ** 3 = _ = ccm
liter = 0.001 * meter ** 3 = L = l = litre
second = [time] = s = sec
minute = 60 * second = min
hour = 3600 * second = h = hr
day = 86400 * second
gram = [mass] = g
ampere = [current] = A
radian = [angle] = rad
degree = 0.017453292519943295 * radian = deg = °
turn = 6.283185307179586 * radian = _ = revolution = rev
rpm = turn / minute = _ = RPM
rps = turn / second
hertz = 1 / second = Hz = hz = Hertz
newton = 1000 * gram * meter / second ** 2 = N = Newton
dyne = 1e-5 * newton = dyn
pascal = newton / meter ** 2 = Pa = Pascal
poise = 0.1 * pascal * second = P = Poise
stokes = 1e-4 * meter ** 2 / second = St
joule = newton * meter = J
erg = 1e-7 * joule
tesla = newton / ampere / meter = T = Tesla
gauss = 1e-4 * tesla = G = Gauss = Gs
weber = tesla * meter ** 2 = Wb
volt = weber / second = V
emu = 1e-3 * ampere * meter ** 2
"""
# Unicode that word processors, papers and web pages put in the place of what a keyboard writes.
_PLAIN = str.maketrans(
    {
        **dict.fromkeys("\u2212\u2010\u2011\u2013\ufe63\uff0d", "-"),
        **dict.fromkeys("\u00b7\u22c5\u2219\u2022\u2027", " "),  # dots that multiply
        **dict.fromkeys("\u00ba\u02da", "°"),
        **dict.fromkeys("\u2044\u2215", "/"),
        "\u00d7": "*",
        **dict.fromkeys("\u200b\u200e\u2060\ufeff\u00ad{}"),  # what cannot be seen, and braces about powers
    }
)
_SUPERSCRIPT = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻", "0123456789+-")
_RAISED = re.compile("[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_POWER_OF_TEN = re.compile(r"(?<=[\d.])\s*[*x ]\s*10\s*(?:\^|\*\*)\s*([-+]?\d+)")
_QUANTITY = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf))\s*((?:1?\s*/\s*)?(?:[^\W\d_]|°)[\w\s/*^°.()+-]{0,40})?\s*"
)
_POWER = re.compile(r"(?<=[^\W\d_])([-+]?\d)")  # m2, s-1
# Am^2, mPas, kgm^2, and a hyphen that multiplies: mPa-s
_JOINED = re.compile(
    r"\b(?:[mµμun]?A(?=m(?![a-z]))|[mcµμu]?Pa(?=s(?![a-z]))|[kmµμu]?g(?=[cm]?m(?![a-z]))|[mµμu]?N(?=m(?![a-z])))"
)
_HYPHEN = re.compile(r"(?<=[A-Za-z])-(?=[A-Za-z])")
_PER = re.compile(r"\s+per\s+")
_TURNING = re.compile(r"\b[rU](?=\s*/\s*(?:s|min)\b)")  # r/min, as on motors


_TURNS = {"turn", "rpm", "rps"}  # units in which a turn is one, as a frequency counts them


@cache
def _registry() -> "pint.UnitRegistry":
    import pint

    registry: pint.UnitRegistry = pint.UnitRegistry(None)
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


def _plain(text: str) -> str:
    """The text as a keyboard would write it: minus signs, superscripts as powers, powers of ten as exponents."""
    raised = _RAISED.sub(lambda match: "^" + match[0].translate(_SUPERSCRIPT), text)
    plain = unicodedata.normalize("NFKC", raised.translate(_PLAIN))  # units in one character, digits of full width
    return _POWER_OF_TEN.sub(r"e\1", plain)


def _spelled(unit: str) -> str:
    """The unit as pint reads it: products by space or dot, powers by ^ or a number behind a symbol."""
    plain = _TURNING.sub("turn", _PER.sub("/", unit.strip().replace(".", " ")))
    plain = f"1{plain}" if plain.startswith("/") else plain
    symbols = _POWER.sub(r"^\1", _JOINED.sub(lambda match: f"{match[0]} ", _HYPHEN.sub(" ", plain)))
    return re.sub(r"(?<=[\w)])\s+(?=[A-Za-zµμ°(])", " * ", symbols.replace("^", "**"))


@cache
def _factor(unit: str, kind: Kind) -> float | str:
    """What one ``unit`` is in the kind's SI unit, or why it is none."""
    in_use = dict(kind.units)
    if unit in in_use:
        return in_use[unit]
    return _factor_by_pint(unit, kind)


def _factor_by_pint(unit: str, kind: Kind) -> float | str:
    import pint

    if re.search(r"\*\*\s*[-+]?\d{2,}|\*\*\s*[-+]?\d\s*\*\*", _spelled(unit)):
        return "whose unit has an absurd power"
    try:
        given = _registry().Quantity(1.0, _spelled(unit))
        counts_turns = kind is FREQUENCY and not _TURNS.isdisjoint(dict(given.unit_items()))
        return float(given.to("turn / second" if counts_turns else _spelled(kind.si)).magnitude)
    except pint.DimensionalityError:
        hint = ", which counts turns" if kind is FREQUENCY and _is_rotation(unit) else ""
        return f"which is not in a unit of {kind.name.partition(' ')[2]}{hint}; it may be {kind.known}"
    except pint.UndefinedUnitError:
        return f"whose unit '{unit}' is not known; it may be {kind.known}"
    except Exception:  # noqa: BLE001  pint's parser leaks whatever its tokenizer raises; every case is the same bad unit
        return f"whose unit '{unit}' cannot be read; it may be {kind.known}"


def _is_rotation(unit: str) -> bool:
    return isinstance(_factor(unit, ANGULAR_RATE), float)


def _scaled(number: float, factor: float) -> float:
    """``number * factor``, dividing where the factor is one over a whole number: 5 / 1e6 is exact, 5 * 1e-6 is not."""
    whole, inverse = round(factor), round(1.0 / factor)
    if inverse > 1 and abs(inverse * factor - 1.0) < 1e-12:
        return number / inverse
    return number * (whole if whole >= 1 and abs(factor - whole) < 1e-12 * whole else factor)


def parse(text: str, kind: Kind) -> float:
    """Read a quantity such as ``"150 mm"`` and return it in SI (angles in radians).

    Returns
    -------
    float
        SI; radians of an angle.

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
    match = _QUANTITY.fullmatch(_plain(text))
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

    Returns
    -------
    str
        Number and unit.

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
