"""The inputs that the page has a slider for: name, unit, range, and how a scenario gives and takes their values."""

import math
from dataclasses import dataclass

from helimag.errors import InputError
from helimag.scenario import Input, Scenario, varied

DIRECTION = "drive.direction"  # of the velocity: the studio's own, two components of one field


@dataclass(frozen=True)
class Knob:
    """An input with a slider, in the unit that it is shown in.

    Attributes
    ----------
    path
        Of the input.
    label
        In the field's words.
    unit
        That numbers here are in.
    scale
        SI value of one such unit.
    low, high, step
        Of the slider; a typed value may lie beyond.
    group
        Heading that it stands under.
    """

    path: str
    label: str
    unit: str
    scale: float
    low: float
    high: float
    step: float
    group: str

    def value(self, scenario: Scenario) -> float | None:
        """Value in the shown unit; None where the scenario has none."""
        if self.path == DIRECTION:
            x, y, _ = scenario.drive.velocity
            return math.degrees(math.atan2(y, x)) if x or y else None
        try:
            found = Input(self.path).found(scenario)
        except InputError:
            return None
        return None if found is None else found / self.scale

    def changed(self, scenario: Scenario, value: float) -> Scenario:
        """The scenario with this input at a value in the shown unit.

        Raises
        ------
        InputError
            Where it does not fit.
        """
        if not math.isfinite(value):
            raise InputError(f"{self.label} must be a number; got {value}")
        if self.path == DIRECTION:
            x, y, z = scenario.drive.velocity
            level, angle = math.hypot(x, y), math.radians(value)
            return scenario.replaced({"drive.velocity": (level * math.cos(angle), level * math.sin(angle), z)})
        return varied(scenario, {self.path: self.exact(value)})

    def exact(self, value: float) -> float | str:
        """What a file would hold: text with the unit where a file has one, so that 12.7 deg is 12.7 deg everywhere."""
        return f"{value!r} {self.unit}" if self.unit else value

    def within(self, value: float) -> float:
        """The value, or the nearest that the slider reaches."""
        return min(self.high, max(self.low, value))


@dataclass(frozen=True)
class WordChoice:
    """An input that is one of some words, each with what it means."""

    path: str
    label: str
    words: dict[str, str]
    group: str
    optional: bool = False

    def value(self, scenario: Scenario) -> str | None:
        """The word that a scenario has; None where it has none of these."""
        part: object = scenario
        for step in self.path.split("."):
            part = part[0] if isinstance(part, tuple) else part
            part = getattr(part, step, None)
        return part if isinstance(part, str) and part in self.words else None

    def changed(self, scenario: Scenario, word: str) -> Scenario:
        """The scenario with another word.

        Raises
        ------
        InputError
            Where it does not fit.
        """
        if word not in self.words:
            raise InputError(f"{self.label} must be one of {', '.join(self.words)}; got {word!r}")
        return varied(scenario, {self.path: word})


CHOICES = (
    WordChoice(
        "drive.heading", "End that leads at the start", {"helix": "helix", "head": "head"}, "Drive", optional=True
    ),
    WordChoice(
        "drive.pitch_about",
        "Pitch swings the magnet",
        {"origin": "about the lab's origin", "magnet": "about its own centre"},
        "Drive",
    ),
    WordChoice("device.helix.handedness", "Handedness", {"left": "left-handed", "right": "right-handed"}, "Device"),
    WordChoice(
        "device.hydrodynamics.model",
        "Drag",
        {
            "lighthill": "resistive force, Lighthill",
            "gray-hancock": "resistive force, Gray-Hancock",
            "boundary": "true drag, boundary integral",
        },
        "Fluid",
    ),
    WordChoice("magnet.field", "Magnet's field", {"dipole": "point dipole", "cylinder": "cylinder"}, "Magnet"),
)

DEGREE = math.pi / 180.0
KNOBS = (
    Knob("drive.frequency", "Rotation frequency", "Hz", 1.0, 0.5, 6.0, 0.01, "Drive"),
    Knob("drive.pitch", "Pitch of the rotation axis", "deg", DEGREE, -30.0, 30.0, 0.1, "Drive"),
    Knob("drive.distance", "Distance to the magnet", "mm", 1e-3, 80.0, 220.0, 0.5, "Drive"),
    Knob("drive.yaw_rate", "Yaw rate", "deg/s", DEGREE, -6.0, 6.0, 0.05, "Drive"),
    Knob("drive.speed", "Speed of the magnet", "mm/s", 1e-3, 0.0, 2.0, 0.005, "Drive"),
    Knob(DIRECTION, "Direction of travel", "deg", DEGREE, -180.0, 180.0, 1.0, "Drive"),
    Knob("device.magnetic_moment", "Magnetic moment", "mA m^2", 1e-3, 0.1, 3.0, 0.001, "Device"),
    Knob("device.weight.net_weight", "Weight less buoyancy", "uN", 1e-6, 0.0, 60.0, 0.05, "Device"),
    Knob("device.weight.gravity_center", "Centre of gravity from head", "mm", 1e-3, -8.0, 2.0, 0.01, "Device"),
    Knob("device.helix.length", "Helix length", "mm", 1e-3, 3.0, 25.0, 0.05, "Device"),
    Knob("device.helix.pitch", "Helix pitch", "mm", 1e-3, 0.8, 6.0, 0.01, "Device"),
    Knob("magnet.moment", "Magnet's moment", "A m^2", 1.0, 5.0, 40.0, 0.01, "Magnet"),
    Knob("fluid.viscosity", "Viscosity", "Pa s", 1.0, 0.1, 5.0, 0.005, "Fluid"),
    Knob("fluid.density", "Density", "kg/m^3", 1.0, 800.0, 1300.0, 1.0, "Fluid"),
    Knob("run.duration", "Duration", "s", 1.0, 60.0, 3600.0, 10.0, "Run"),
)
BY_PATH = {knob.path: knob for knob in KNOBS}


GROUPS = ("Drive", "Device", "Fluid", "Magnet", "Run")


def unit_text(unit: str) -> str:
    """A unit as it is printed."""
    return unit.replace("^2", "\u00b2").replace("^3", "\u00b3").replace("uN", "\u00b5N")


def present(scenario: Scenario) -> list[Knob]:
    """Those that a scenario gives a value."""
    return [knob for knob in KNOBS if knob.value(scenario) is not None]
