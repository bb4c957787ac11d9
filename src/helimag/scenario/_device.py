"""The device and what it is made of."""

import math
from typing import Annotated, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario._fields import Density, Force, Length, Moment, Size


class Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Helix(Part):
    """The coiled wire behind the head."""

    length: Size
    outer_diameter: Size
    pitch: Size
    wire_radius: Size
    handedness: Literal["left", "right"] = "left"

    @property
    def radius(self) -> float:
        """Radius of the centreline (m)."""
        return self.outer_diameter / 2.0 - self.wire_radius

    @property
    def contour_per_length(self) -> float:
        """Length of wire per length of axis."""
        return math.hypot(1.0, 2.0 * math.pi * self.radius / self.pitch)

    @property
    def volume(self) -> float:
        """Volume of the wire (m^3)."""
        return math.pi * self.wire_radius**2 * self.length * self.contour_per_length

    @model_validator(mode="after")
    def _wire_fits(self) -> Self:
        if not self.radius > 0.0:
            wire = q.show(self.wire_radius, q.LENGTH)
            coil = q.show(self.outer_diameter / 2.0, q.LENGTH)
            raise InputError(f".wire_radius must be less than half the outer_diameter ({coil}); got '{wire}'")
        return self


class SphereHead(Part):
    """A ball."""

    shape: Literal["sphere"] = "sphere"
    radius: Size

    @property
    def reach(self) -> float:
        """Half the length along the device's axis (m)."""
        return self.radius

    @property
    def volume(self) -> float:
        """Volume (m^3)."""
        return 4.0 / 3.0 * math.pi * self.radius**3


class SpheroidHead(Part):
    """An ellipsoid of revolution about the device's axis."""

    shape: Literal["spheroid"] = "spheroid"
    length: Size
    diameter: Size

    @property
    def reach(self) -> float:
        """Half the length along the device's axis (m)."""
        return self.length / 2.0

    @property
    def radius(self) -> float:
        """Radius across the device's axis (m)."""
        return self.diameter / 2.0

    @property
    def volume(self) -> float:
        """Volume (m^3)."""
        return math.pi / 6.0 * self.length * self.diameter**2


class CylinderHead(Part):
    """A circular cylinder about the device's axis."""

    shape: Literal["cylinder"] = "cylinder"
    length: Size
    diameter: Size

    @property
    def reach(self) -> float:
        """Half the length along the device's axis (m)."""
        return self.length / 2.0

    @property
    def radius(self) -> float:
        """Radius across the device's axis (m)."""
        return self.diameter / 2.0

    @property
    def volume(self) -> float:
        """Volume (m^3)."""
        return math.pi / 4.0 * self.length * self.diameter**2


Head = Annotated[SphereHead | SpheroidHead | CylinderHead, Field(discriminator="shape")]


class Weight(Part):
    """Weight less buoyancy: either given, or from the densities of the parts."""

    ALTERNATIVES: ClassVar = ({"net_weight", "gravity_center"}, {"helix_density", "head_density"})

    net_weight: Force | None = None
    gravity_center: Length | None = None
    helix_density: Density | None = None
    head_density: Density | None = None

    @property
    def given(self) -> tuple[float, float] | None:
        """Net weight (N) and the place along x where it acts (m), or None where densities are given instead."""
        if self.net_weight is None or self.gravity_center is None:
            return None
        return self.net_weight, self.gravity_center

    @property
    def densities(self) -> tuple[float, float] | None:
        """Densities of helix and head (kg/m^3), or None where the net weight is given instead."""
        if self.helix_density is None or self.head_density is None:
            return None
        return self.helix_density, self.head_density

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        present = {name for name in type(self).model_fields if getattr(self, name) is not None}
        if present not in self.ALTERNATIVES:
            got = ", ".join(sorted(present)) or "nothing"
            raise InputError(
                f"needs either net_weight and gravity_center, or helix_density and head_density; got {got}"
            )
        return self


class Hydrodynamics(Part):
    """Which 6x6 resistance the device has."""

    model: Literal["lighthill", "gray-hancock", "matrix"] = "lighthill"
    resistance: tuple[tuple[float, ...], ...] | None = None

    @model_validator(mode="after")
    def _matrix_given(self) -> Self:
        if (self.model == "matrix") != (self.resistance is not None):
            raise InputError('.resistance must be given with model = "matrix", and only with it')
        if self.resistance is not None:
            if len(self.resistance) != 6 or any(len(row) != 6 for row in self.resistance):
                raise InputError(".resistance must be 6 rows of 6 numbers (SI, about the head's centre)")
            if not all(math.isfinite(entry) for row in self.resistance for entry in row):
                raise InputError(".resistance must hold finite numbers only")
        return self


class Device(Part):
    """The untethered helical magnetic device."""

    magnetic_moment: Moment
    helix: Helix
    head: Head
    weight: Weight
    hydrodynamics: Hydrodynamics = Hydrodynamics()
