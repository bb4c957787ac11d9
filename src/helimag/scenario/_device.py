"""The device and what it is made of."""

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario._body import Body
from helimag.scenario._fields import Density, Force, Length, Moment, Size
from helimag.scenario._fields import Part as Part


class Helix(Part):
    """The coiled wire behind the head."""

    length: Size
    """Length of the helix along its axis, from the head backwards."""
    outer_diameter: Size
    """Diameter over the coil, wire included."""
    pitch: Size
    """Length along the axis of one full coil; not an angle."""
    wire_radius: Size
    """Radius of the wire (half its thickness)."""
    handedness: Literal["left", "right"] = "left"
    """Sense of the coil. Below a magnet that turns with positive frequency a left-handed helix swims along +x."""

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
    """Which shape the other keys are of."""
    radius: Size
    """Radius of the ball."""

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
    """Which shape the other keys are of."""
    length: Size
    """Along the device's axis, tip to tip."""
    diameter: Size
    """Across the device's axis."""

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
    """Which shape the other keys are of."""
    length: Size
    """Along the device's axis."""
    diameter: Size
    """Across the device's axis."""

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

    net_weight: Force | None = None
    """Weight less buoyancy of the whole device; positive pulls down."""
    gravity_center: Length | None = None
    """Where the net weight acts, along the device's axis from its origin (the head's centre): negative is towards the
    helix.
    """
    helix_density: Density | None = None
    """Density of the helix' material; with ``head_density``, in place of the two above."""
    head_density: Density | None = None
    """Density of the head as a whole, its magnet included."""

    @property
    def given(self) -> tuple[float, float] | None:
        """Net weight (N) and the place along x where it acts (m), or None where densities are given instead."""
        if self.net_weight is None or self.gravity_center is None:
            return None
        return self.net_weight, self.gravity_center

    def check(self, parts: set[str]) -> None:
        """Refuse where this is neither the net weight with its place, nor a density for each of the named parts."""
        present = {name for name in type(self).model_fields if getattr(self, name) is not None}
        densities = {f"{part}_density" for part in parts}
        if present != {"net_weight", "gravity_center"} and (present != densities or not parts):
            either = "either " if parts else ""
            choice = f", or {' and '.join(sorted(densities, reverse=True))}" if parts else ""
            got = ", ".join(sorted(present)) or "nothing"
            raise InputError(f".weight needs {either}net_weight and gravity_center{choice}; got {got}")


class Hydrodynamics(Part):
    """Which 6x6 resistance the device has."""

    model: Literal["lighthill", "gray-hancock", "boundary", "matrix"] = "lighthill"
    """How the drag is found: resistive-force theory by Lighthill's or Gray and Hancock's coefficients, the boundary
    solver, or a matrix of your own.
    """
    resistance: tuple[tuple[float, ...], ...] | None = None
    """With ``matrix``: 6 rows of force and torque per velocity and angular velocity, about the head's centre in the
    body frame; SI, with the run's viscosity in it.
    """
    tolerance: float | None = None
    """With ``boundary``: relative error of the 6x6 at which refining ends; 0.01 if left out."""
    near_walls: bool | None = None
    """With ``boundary``: whether floor and surface raise the drag of a device near them; not if left out."""

    @model_validator(mode="after")
    def _tolerance_fits(self) -> Self:
        if self.tolerance is None:
            return self
        if self.model != "boundary":
            raise InputError('.tolerance goes with model = "boundary" only')
        if not 0.0 < self.tolerance < 1.0:
            raise InputError(f".tolerance must be between 0 and 1; got {self.tolerance}")
        return self

    @model_validator(mode="after")
    def _walls_fit(self) -> Self:
        if self.near_walls and self.model != "boundary":
            raise InputError('.near_walls goes with model = "boundary" only')
        return self

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
    """The untethered helical magnetic device: a helix, a head or both, or a body of any shape instead.

    The origin of its frame is the head's centre; without head the front end of the helix, with a body as the body says.
    """

    magnetic_moment: Moment
    """Size of the moment of the device's magnet, which points across its long axis: along body y."""
    helix: Helix | None = None
    """The coiled wire behind the head: a table ``[device.helix]``; none if left out."""
    head: Head | None = None
    """The head, which carries the magnet: a table ``[device.head]``; none if left out."""
    body: Body | None = None
    """A closed mesh in place of helix and head: a table ``[device.body]``."""
    weight: Weight
    """What the fluid does not carry: a table ``[device.weight]``."""
    hydrodynamics: Hydrodynamics = Hydrodynamics()
    """How drag is found: a table ``[device.hydrodynamics]``."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        parts = {name for name in ("helix", "head") if getattr(self, name) is not None}
        if bool(parts) == (self.body is not None):
            raise InputError("needs either a body, or a helix, a head or both")
        if self.hydrodynamics.model in {"lighthill", "gray-hancock"} and self.helix is None:
            raise InputError(
                f'.hydrodynamics.model = "{self.hydrodynamics.model}" needs a helix; use "boundary" or "matrix"'
            )
        self.weight.check(parts)
        return self

    @property
    def helix_start(self) -> float:
        """How far behind the origin the helix begins (m)."""
        return 0.0 if self.head is None else self.head.reach

    @property
    def front(self) -> float:
        """Place of the front end along x (m)."""
        return self.helix_start if self.body is None else self.body.front

    @property
    def tail_length(self) -> float:
        """From the origin back to the rear end (m)."""
        if self.body is not None:
            return -self.body.rear
        return self.helix_start + (0.0 if self.helix is None else self.helix.length)

    @property
    def length(self) -> float:
        """From end to end (m)."""
        return self.front + self.tail_length

    @property
    def tail_radius(self) -> float:
        """Radius about the long axis at the rear end (m)."""
        if self.helix is not None:
            return self.helix.outer_diameter / 2.0
        return self.head_radius

    @property
    def head_radius(self) -> float:
        """Radius about the long axis at the origin (m)."""
        if self.head is not None:
            return self.head.radius
        return self.tail_radius if self.body is None else self.body.radius
