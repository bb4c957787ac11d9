"""Quantities as people paste them: every form has its right SI value, and what is refused lists what is accepted."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helimag import InputError
from helimag import quantities as q

KINDS = [kind for kind in vars(q).values() if isinstance(kind, q.Kind)]

# text, kind, SI value: by hand
PASTED = [
    ("\u22125 mm", q.LENGTH, -0.005),
    ("\u20135 mm", q.LENGTH, -0.005),
    ("5\u00a0mm", q.LENGTH, 0.005),
    ("5\u2009\u00b5m", q.LENGTH, 5e-6),
    ("5 \u03bcm", q.LENGTH, 5e-6),
    ("5 um", q.LENGTH, 5e-6),
    ("2 inch", q.LENGTH, 0.0508),
    ("2 inches", q.LENGTH, 0.0508),
    ("2 in", q.LENGTH, 0.0508),
    ("1.5e\u22123 m", q.LENGTH, 0.0015),
    ("1.5\u00d710\u207b\u00b3 m", q.LENGTH, 0.0015),
    ("1.5 x 10^-3 m", q.LENGTH, 0.0015),
    ("12\u00b0", q.ANGLE, math.pi / 15),
    ("12 \u00ba", q.ANGLE, math.pi / 15),
    ("0.5 turn", q.ANGLE, math.pi),
    ("18 \u00b0/s", q.ANGULAR_RATE, math.pi / 10),
    ("18 deg s\u207b\u00b9", q.ANGULAR_RATE, math.pi / 10),
    ("1 rev/s", q.ANGULAR_RATE, 2 * math.pi),
    ("30 rpm", q.ANGULAR_RATE, math.pi),
    ("3.3 s\u207b\u00b9", q.FREQUENCY, 3.3),
    ("3.3 s^-1", q.FREQUENCY, 3.3),
    ("3.3 s-1", q.FREQUENCY, 3.3),
    ("3.3 1/s", q.FREQUENCY, 3.3),
    ("3.3 rev/s", q.FREQUENCY, 3.3),
    ("198 rpm", q.FREQUENCY, 3.3),
    ("198 turn/min", q.FREQUENCY, 3.3),
    ("1 mm s\u22121", q.VELOCITY, 0.001),
    ("60 mm/min", q.VELOCITY, 0.001),
    ("1 m/s2", q.ACCELERATION, 1.0),
    ("1 m\u22c5s\u207b\u00b2", q.ACCELERATION, 1.0),
    ("18.89 A m2", q.MOMENT, 18.89),
    ("18.89 Am^2", q.MOMENT, 18.89),
    ("18.89 Am2", q.MOMENT, 18.89),
    ("18.89 Am\u00b2", q.MOMENT, 18.89),
    ("18.89 A\u00b7m\u00b2", q.MOMENT, 18.89),
    ("18.89 A\u22c5m\u00b2", q.MOMENT, 18.89),
    ("18.89 A.m^2", q.MOMENT, 18.89),
    ("18.89 A*m**2", q.MOMENT, 18.89),
    ("2 mAm\u00b2", q.MOMENT, 0.002),
    ("18.89 J/T", q.MOMENT, 18.89),
    ("18.89 J T\u207b\u00b9", q.MOMENT, 18.89),
    ("13.5 kG", q.REMANENCE, 1.35),
    ("971 kg/m3", q.DENSITY, 971.0),
    ("971 kg/m\u00b3", q.DENSITY, 971.0),
    ("971 kg m-3", q.DENSITY, 971.0),
    ("971 kg\u00b7m\u207b\u00b3", q.DENSITY, 971.0),
    ("0.97 g/mL", q.DENSITY, 970.0),
    ("0.97 g/ml", q.DENSITY, 970.0),
    ("0.97 g cm^-3", q.DENSITY, 970.0),
    ("0.97 kg/L", q.DENSITY, 970.0),
    ("1 Pa\u00b7s", q.VISCOSITY, 1.0),
    ("1000 mPas", q.VISCOSITY, 1.0),
    ("1 kg/(m s)", q.VISCOSITY, 1.0),
    ("1000 cP", q.VISCOSITY, 1.0),
    ("28.28 \u00b5N", q.FORCE, 28.28e-6),
    ("3.5 rps", q.FREQUENCY, 3.5),
    ("0.5 rps", q.ANGULAR_RATE, math.pi),
    ("210 RPM", q.FREQUENCY, 3.5),
    ("210 r/min", q.FREQUENCY, 3.5),
    ("210 U/min", q.FREQUENCY, 3.5),
    ("210 min\u207b\u00b9", q.FREQUENCY, 3.5),
    ("3.3 /s", q.FREQUENCY, 3.3),
    ("3.3 s^{-1}", q.FREQUENCY, 3.3),
    ("3.3 rev per s", q.FREQUENCY, 3.3),
    ("3.3 hz", q.FREQUENCY, 3.3),
    ("0.97 g/cc", q.DENSITY, 970.0),
    ("0.97 kg/dm\u00b3", q.DENSITY, 970.0),
    ("971 kg/m^{3}", q.DENSITY, 971.0),
    ("0.002 kgm\u00b2", q.INERTIA, 0.002),
    ("20 gcm2", q.INERTIA, 2e-6),
    ("1000 mPa-s", q.VISCOSITY, 1.0),
    ("1 N\u00b7s\u00b7m\u207b\u00b2", q.VISCOSITY, 1.0),
    ("10 dyn s/cm2", q.VISCOSITY, 1.0),
    ("13.5 kGauss", q.REMANENCE, 1.35),
    ("1.35 Tesla", q.REMANENCE, 1.35),
    ("1.35 V s/m\u00b2", q.REMANENCE, 1.35),
    ("18890 emu", q.MOMENT, 18.89),
    ("18.89 Nm/T", q.MOMENT, 18.89),
    ("18 \u00b0 s\u207b\u00b9", q.ANGULAR_RATE, math.pi / 10),
    ("18 degrees per second", q.ANGULAR_RATE, math.pi / 10),
    ("1.5\u00b710\u207b\u00b3 m", q.LENGTH, 0.0015),
    ("5 \u212b", q.LENGTH, 5e-10),
    ("5 \u339b", q.LENGTH, 5e-6),
    ("\uff15\u202fmm", q.LENGTH, 0.005),
    ("5\u200bmm", q.LENGTH, 0.005),
    ("5 microns", q.LENGTH, 5e-6),
    ("0.5 hr", q.TIME, 1800.0),
]


@pytest.mark.parametrize(("text", "kind", "value"), PASTED, ids=[text for text, *_ in PASTED])
def test_every_form_has_its_value(text, kind, value):
    assert q.parse(text, kind) == pytest.approx(value, rel=4e-16)


@pytest.mark.parametrize("kind", KINDS, ids=[kind.name for kind in KINDS])
def test_units_that_a_refusal_lists_are_accepted(kind):
    for unit in (kind.si, kind.shown, *dict(kind.units)):
        assert q.parse(f"1 {unit}", kind) > 0.0
    for text in ("1 parsec", "1 A/m", "1 )("):
        with pytest.raises(InputError) as caught:
            q.parse(text, kind)
        assert str(caught.value).startswith(f"must be {kind.name} such as '{kind.example}'; got '{text}'")
        if text != "1 )(":
            assert str(caught.value).endswith(f"; it may be {kind.known}")


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_units_in_use_are_to_the_bit_what_pint_says(kind):
    """Hashes of scenarios rest on these numbers, whichever way they were read."""
    rng = np.random.default_rng(5)
    numbers = rng.normal(size=1000) * 10.0 ** rng.integers(-9, 9, size=1000)
    for unit, factor in kind.units:
        by_pint = q._factor_by_pint(unit, kind)
        assert factor == pytest.approx(by_pint, rel=4e-16)
        assert [q._scaled(x, factor) for x in numbers] == [q._scaled(x, by_pint) for x in numbers]


@pytest.mark.parametrize(
    "text",
    [
        "6 rad/s",
        "6 deg/s",
        "2 rev",
        "3 Hz Hz",
        "5 m 3",
        "5 1/",
        "5 1",
        "5 \u00b0C",
        "1,5 Hz",
        "5 r",
        "3 cps",
        "1 500 Hz",
    ],
)
def test_what_is_no_frequency_is_refused(text):
    with pytest.raises(InputError, match="must be a frequency such as"):
        q.parse(text, q.FREQUENCY)


@given(value=st.floats(allow_nan=False, allow_infinity=False), kind=st.sampled_from(KINDS))
@settings(max_examples=300, deadline=None)
def test_what_is_shown_is_read_back_exactly(value, kind):
    assert q.parse(q.show(value, kind), kind) == value


@given(st.sampled_from(PASTED), st.sampled_from("-+*/^.()\u00b0\u207b\u00b2 \u2212x1_m"), st.integers(0, 20))
@settings(max_examples=300, deadline=None)
def test_a_stray_character_is_read_or_refused_in_a_line(case, stray, place):
    text, kind, _ = case
    try:
        assert math.isfinite(q.parse(text[:place] + stray + text[place:], kind))
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
