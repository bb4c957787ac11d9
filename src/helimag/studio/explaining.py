"""What each input does: the paper's equation, today's numbers, and two runs with the input a little off."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from helimag.diagnosis import Diagnosis, diagnose
from helimag.engine import advance
from helimag.errors import InputError
from helimag.outcomes import End
from helimag.scenario import Scenario
from helimag.studio.knobs import BY_PATH, Knob, unit_text
from helimag.studio.mapping import THREADS

OFF = 0.05  # of the value, or of the slider's range where the value is small


@dataclass(frozen=True)
class Effect:
    """An input explained.

    Attributes
    ----------
    label
        Of the input.
    equation
        As the paper has it, with its number.
    today
        What it says with today's numbers.
    less, more
        The runs with a little less and a little more of it.
    """

    label: str
    equation: str
    today: str
    less: str
    more: str


EQUATIONS = {
    "drive.frequency": "Ωₐ turns Mₐ at 2π fₐ; f_visc = −R·(v, ω)   (7)",
    "drive.pitch": "Rₐ = R_z(γ̇ₐ t) R_y(−βₐ),  pₐ = Rₐ pₐ(0) + vₐ t   (1), (3)",
    "drive.distance": "B = μ₀ / (4π r³) (3 r̂ r̂ᵀ − I) Mₐ   (9);  pull = ∇(m·B) ∝ 1/r⁴   (4)",
    "drive.yaw_rate": "Rₐ = R_z(γ̇ₐ t) R_y(−βₐ): the magnet circles   (1), (3)",
    "drive.speed": "pₐ = Rₐ pₐ(0) + vₐ t   (1)",
    "device.weight.net_weight": "f_g = V (ρ_r − ρ_f) g: weight less buoyancy   (8)",
    "device.weight.gravity_center": "τ_g = (r_CoV − r_CoM) × f_g   (8)",
    "device.magnetic_moment": "force (m·∇)B, torque m × B   (4)",
    "fluid.viscosity": "f_visc = −R·(v, ω), R ∝ μ   (7)",
}


def effects(scenario: Scenario, progress: Callable[[float], None]) -> list[Effect]:
    """Each input that has an equation, explained at this scenario.

    Raises
    ------
    InputError
        Where drag or weight cannot be computed.
    """
    found = diagnose(scenario)
    knobs = [BY_PATH[path] for path in EQUATIONS if BY_PATH[path].value(scenario) is not None]
    if not math.hypot(*scenario.drive.velocity):
        knobs = [knob for knob in knobs if knob.path != "drive.speed"]
    tried = [(knob, sign, _off(knob, scenario, sign)) for knob in knobs for sign in (-1.0, 1.0)]
    known = [(knob, sign, other) for knob, sign, other in tried if other is not None]
    histories = advance([other for _, _, other in known], threads=THREADS, progress=progress)
    words: dict[tuple[str, float], str] = {}
    for (knob, sign, other), history in zip(known, histories, strict=True):
        value = f"{knob.value(other) or 0.0:.4g} {unit_text(knob.unit)}"
        if history.status is End.NOT_FINITE:
            words[knob.path, sign] = f"{value}: no run"
        else:
            judged = history.judge()
            words[knob.path, sign] = f"{value}: {judged.verdict}, gain {judged.gain:.3f}"
    return [
        Effect(
            knob.label,
            EQUATIONS[knob.path],
            _today(knob.path, found),
            words.get((knob.path, -1.0), "cannot be less"),
            words.get((knob.path, 1.0), "cannot be more"),
        )
        for knob in knobs
    ]


def _off(knob: Knob, scenario: Scenario, sign: float) -> Scenario | None:
    """The scenario with one input a little off; None where that cannot be."""
    here = knob.value(scenario) or 0.0
    step = OFF * abs(here) if here else OFF * (knob.high - knob.low)
    try:
        return knob.changed(scenario, float(f"{here + sign * step:.6g}"))
    except InputError:
        return None


def _today(path: str, found: Diagnosis) -> str:
    """What the equation amounts to now."""
    drive = found.scenario.drive
    pull, weight = 1e6 * float(found.pull[2]), 1e6 * found.net_weight
    balance = "nowhere" if found.balance_distance is None else f"at {1e3 * found.balance_distance:.1f} mm"
    rise = math.degrees(math.asin(max(-1.0, min(1.0, float(found.settled.thrust[2])))))
    lap = f"a lap takes {2.0 * math.pi / abs(drive.yaw_rate):.0f} s" if drive.yaw_rate else "no circle"
    field, roll = found.field, found.roll_rates
    swum, way = f"{1e3 * found.swimming_speed:.3f} mm/s", "up" if rise > 0 else "down"
    return {
        "drive.frequency": f"swims {1e3 * abs(found.advance):.3f} mm a turn, {swum}; step is kept up to "
        f"{found.step_out_frequency:.1f} Hz at least, {found.margin:.1f} times the present",
        "drive.pitch": f"settled, it swims {found.settled.swims} first, its thrust {abs(rise):.1f} deg {way}",
        "drive.distance": f"pull {pull:.2f} µN at the start, {1e3 * found.start_distance:.1f} mm away; it carries the "
        f"weight {balance}",
        "drive.yaw_rate": f"{lap}; the start circles at "
        f"{1e3 * abs(drive.yaw_rate) * math.hypot(*drive.start[:2]):.2f} mm/s",
        "drive.speed": f"the magnet moves at {1e3 * math.hypot(*drive.velocity):.3f} mm/s, the device swims {swum}",
        "device.weight.net_weight": f"{weight:.2f} µN down against a pull of {pull:.2f} µN at the start",
        "device.weight.gravity_center": f"sinks {1e3 * found.sinking[0]:.3f} mm/s level, "
        f"{1e3 * found.sinking[1]:.3f} mm/s upright",
        "device.magnetic_moment": f"field {1e3 * field[0]:.2f} to {1e3 * field[1]:.2f} mT over a turn; roll follows "
        f"within {1e3 / roll[0]:.0f} ms",
        "fluid.viscosity": f"sinks {1e3 * found.sinking[0]:.3f} mm/s; swimming a turn does not depend on it, step-out "
        f"does: {found.step_out_frequency:.1f} Hz",
    }[path]
