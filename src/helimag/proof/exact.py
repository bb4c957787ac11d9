"""A scenario's inputs as the numbers that its file states: decimals with a unit, not the floats nearest to them."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from helimag import quantities as q
from helimag.errors import InputError
from helimag.hydrodynamics import STANDARD_GRAVITY, resistance
from helimag.orbits import require_periodic
from helimag.proof import drag
from helimag.proof.balls import exact, flint
from helimag.proof.jets import VARIABLES, Jet
from helimag.proof.motion import LENGTH, Constants, Source
from helimag.scenario import REMANENCE, Device, Input, Scenario

if TYPE_CHECKING:
    from flint import arb, arb_mat

_UNITS = {"mm": Fraction(1, 1000), "mm/s": Fraction(1, 1000), "uN": Fraction(1, 10**6)}
_ANGLES = {"deg", "deg/s"}  # a half turn is 180 of them
_WRITTEN = re.compile(r"([-+.\deE]+)(?: (.+))?")
WIRE_MODELS = {"lighthill", "gray-hancock"}
# what may have a tolerance: everything that acts through one of these is enclosed over all its values
TOLERATED = ("drive.frequency", "drive.pitch", "drive.distance", "device.weight.net_weight")


def written(scenario: Scenario, path: str) -> str:
    """An input as a scenario's file states it, such as ``12.7 deg``; a number without unit as Python writes it."""
    given = Input(path)
    kind = given.kind(scenario)
    return repr(given.value(scenario)) if kind is None else q.show(given.value(scenario), kind)


def parts(text: str) -> tuple[Fraction, str]:
    """Number and unit of an input as it is written."""
    match = _WRITTEN.fullmatch(text)
    if match is None:
        raise InputError(f"an input must be a decimal number with a unit; got '{text}'")
    return Fraction(match[1]), match[2] or ""


def ball_of(number: Fraction, unit: str) -> "arb":
    """The SI value of so many units."""
    if unit in _ANGLES:
        return exact(number / 180) * flint().arb.pi()
    return exact(number * _UNITS.get(unit, Fraction(1)))


@dataclass(frozen=True)
class Inputs:
    """The exact inputs of a scenario, some of them with a tolerance.

    Attributes
    ----------
    within
        By path: how far the input may be off either way, in the unit that it is written in. Empty: the decimals hold.
    view
        What is read of an input with a tolerance: the ball of all its values; or a jet in a variable from -1 to 1 for
        each such input, at the middle or over all values.
    order
        How many derivatives jets have.
    """

    scenario: Scenario
    within: Mapping[str, Fraction] = field(default_factory=dict)
    view: Literal["balls", "middle", "over"] = "balls"
    order: int = 1

    def read(self, path: str) -> Any:
        """The SI value of an input: its decimals as a ball; where it has a tolerance, what the view says."""
        number, unit = parts(written(self.scenario, path))
        value = ball_of(number, unit)
        if path not in self.within:
            return value
        width = ball_of(self.within[path], unit)
        all_of_it = value + flint().arb(0, width.abs_upper())
        if self.view == "balls":
            return all_of_it
        variable = {VARIABLES + list(self.within).index(path): width}
        more: list[dict[Any, Any] | None] = [{} if self.order >= n else None for n in (2, 3)]
        return Jet(value if self.view == "middle" else all_of_it, variable, *more)

    def constants(self) -> Constants:
        """All that the equations of motion need, enclosed.

        Raises
        ------
        InputError
            Where the scenario is one of which nothing can be proved.
        """
        require_provable(self.scenario)
        drive = self.scenario.drive
        frequency = self.read("drive.frequency")
        period = 1 / abs(frequency)
        unit = exact(LENGTH)
        pitch = self.read("drive.pitch")
        cos, sin = pitch.cos(), pitch.sin()
        moment = self.read("device.magnetic_moment")
        weight, weight_moment = self._weight()
        lift = [period / unit] * 3 + [period] * 3
        mobility = mobility_ball(self.resistance())
        return Constants(
            sources=tuple(self._source(i, cos, sin) for i in range(len(self.scenario.magnet))),
            spin_sign=1 if drive.frequency > 0.0 else -1,
            cos_pitch=cos,
            sin_pitch=sin,
            yaw=self.read("drive.yaw_rate") * period,
            drift=[self.read(f"drive.velocity.{axis}") * period / unit for axis in "xyz"],
            moment=moment,
            pull=3 * moment / unit,
            weight=weight,
            weight_moment=weight_moment,
            mobility=[[lift[i] * mobility[i, j] for j in range(6)] for i in range(6)],
        )

    def arm(self, cos: Any, sin: Any) -> list[Any]:
        """The centre of the arm's tool at t = 0 (m): eq. (1) with either reading of pitch."""
        x, y, z = (self.read(f"drive.start.{axis}") for axis in "xyz")
        z = z + self.read("drive.distance")
        if self.scenario.drive.pitch_about == "magnet":
            return [x, y, z]
        return [cos * x - sin * z, y, sin * x + cos * z]

    def _source(self, i: int, cos: Any, sin: Any) -> Source:
        name = "magnet" if len(self.scenario.magnet) == 1 else f"magnet.{i}"
        magnet, unit = self.scenario.magnet[i], exact(LENGTH)
        x, y, z = (self.read(f"{name}.offset.{axis}") for axis in "xyz")
        offset = [cos * x - sin * z, y, sin * x + cos * z]
        phase = self.read(f"{name}.phase") if magnet.phase is not None else exact(0)
        return Source(
            place=[(a + b) / unit for a, b in zip(self.arm(cos, sin), offset, strict=True)],
            strength=self._magnet_moment(i, name) / 10**7 / unit**3,
            cos_phase=phase.cos(),
            sin_phase=phase.sin(),
        )

    def _magnet_moment(self, i: int, name: str) -> "arb":
        """Dipole moment (A m^2): as given, or remanence times volume over mu0 = 4 pi 1e-7, where pi cancels."""
        magnet = self.scenario.magnet[i]
        if magnet.moment is not None:
            return self.read(f"{name}.moment")
        if magnet.grade is not None:
            remanence = exact(sum(Fraction(str(end)) for end in REMANENCE[magnet.grade]) / 2)
        else:
            remanence = self.read(f"{name}.remanence")
        radius, height = self.read(f"{name}.radius"), self.read(f"{name}.height")
        return remanence * radius * radius * height * 10**7 / 4

    def _weight(self) -> "tuple[arb, arb]":
        """Weight less buoyancy (N), and its moment about the origin (N m)."""
        device = self.scenario.device
        if device.weight.given is not None:
            force = self.read("device.weight.net_weight")
            return force, force * self.read("device.weight.gravity_center")
        gravity, fluid, pi = exact(Fraction(str(STANDARD_GRAVITY))), self.read("fluid.density"), flint().arb.pi()
        force, moment = exact(0), exact(0)
        if device.helix is not None:
            length, pitch, wire = (self.read(f"device.helix.{name}") for name in ("length", "pitch", "wire_radius"))
            radius = self.read("device.helix.outer_diameter") / 2 - wire
            volume = pi * wire**2 * length * (1 + (2 * pi * radius / pitch) ** 2).sqrt()
            part = gravity * (self.read("device.weight.helix_density") - fluid) * volume
            force, moment = force + part, moment - part * (self.helix_start() + length / 2)
        if device.head is not None:
            force += gravity * (self.read("device.weight.head_density") - fluid) * self._head_volume()
        return force, moment

    def helix_start(self) -> "arb":
        """How far behind the origin the helix begins (m)."""
        head = self.scenario.device.head
        if head is None:
            return exact(0)
        return self.read("device.head.radius") if head.shape == "sphere" else self.read("device.head.length") / 2

    def _head_volume(self) -> "arb":
        pi, head = flint().arb.pi(), self.scenario.device.head
        if head is not None and head.shape == "sphere":
            return 4 * pi / 3 * self.read("device.head.radius") ** 3
        size = self.read("device.head.length") * self.read("device.head.diameter") ** 2
        return pi / (6 if head is not None and head.shape == "spheroid" else 4) * size

    def resistance(self) -> "arb_mat":
        """6x6 resistance (SI): that of resistive-force theory enclosed; one that was given, as its floats are."""
        device = self.scenario.device
        model = device.hydrodynamics.model
        if device.helix is None or model not in WIRE_MODELS:
            return float_matrix(resistance(device, self.scenario.fluid))
        matrix = drag.wire_resistance(self.read, model, device.helix.handedness, self.helix_start())
        if device.head is not None:
            for i, value in enumerate(drag.head_resistance(device.head, self.read)):
                matrix[i, i] = matrix[i, i] + value
        return matrix


def float_matrix(matrix: np.ndarray) -> "arb_mat":
    """A matrix of floats as it is."""
    return flint().arb_mat([[exact(float(entry)) for entry in row] for row in matrix])


def mobility_ball(matrix: "arb_mat") -> "arb_mat":
    """Inverse of a resistance, scaled first so that metres and radians do not widen it."""
    library: Any = flint()
    scale = [exact(float(matrix[i, i].mid()) ** -0.5) for i in range(6)]
    scaled = library.arb_mat([[scale[i] * matrix[i, j] * scale[j] for j in range(6)] for i in range(6)])
    inverse = scaled.inv()
    return library.arb_mat([[scale[i] * inverse[i, j] * scale[j] for j in range(6)] for i in range(6)])


def require_provable(scenario: Scenario) -> None:
    """Refuse a scenario whose equations are not enclosed here.

    Raises
    ------
    InputError
        Naming what stands against a proof.
    """
    device: Device = scenario.device
    require_periodic(scenario)
    if scenario.workspace.holds:
        raise InputError(
            'workspace.contact must be "stop" for a proof: walls that hold push, and a surface pulls, before they are '
            "touched, and that is not enclosed"
        )
    _require_no_end(scenario)
    if scenario.magnet[0].field != "dipole":
        raise InputError('magnet.field must be "dipole" for a proof; the cylinder\'s multipoles are not enclosed')
    if device.hydrodynamics.near_walls:
        raise InputError(
            "device.hydrodynamics.near_walls must be left out for a proof: tables of drag are not enclosed"
        )


def _require_no_end(scenario: Scenario) -> None:
    """Refuse a drive that sooner or later carries everything to where a run ends."""
    ends = zip("xyz", scenario.drive.velocity, *scenario.workspace.box, strict=True)
    for axis, speed, low, high in ends:
        if math.isfinite(high if speed > 0.0 else low) and speed:
            raise InputError(
                f"drive.velocity must not lead to a wall for a proof, as no run that does stays for ever; got "
                f"{1e3 * speed:g} mm/s along {axis}: leave out the wall or the drift"
            )
    if scenario.drive.velocity[2] < 0.0:
        raise InputError(
            "drive.velocity must not sink for a proof, as a run ends far below its start; got "
            f"{1e3 * scenario.drive.velocity[2]:g} mm/s along z"
        )
