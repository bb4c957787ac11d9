"""What the device looks like: points on its body, and where its ends are."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.geometry import CHIRALITY, helix_line
from helimag.scenario import Device

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """Sizes of the device (m); body frame as everywhere: origin at the head's centre, x towards the nose."""

    head_reach: float = 0.36e-3
    head_radius: float = 0.36e-3
    helix_length: float = 11.7e-3
    helix_radius: float = 0.2572e-3
    pitch: float = 2.59e-3
    wire_radius: float = 0.2128e-3
    chirality: float = 1.0

    @classmethod
    def of(cls, device: Device) -> "Shape":
        """The shape of a scenario's device.

        Returns
        -------
        Shape
            In m.

        Raises
        ------
        InputError
            Where the device has no helix or no head: the tracking finds the one by the other.
        """
        if device.helix is None or device.head is None:
            raise InputError("device must have a helix and a head to be drawn or tracked in films")
        return cls(
            head_reach=device.head.reach,
            head_radius=device.head.radius,
            helix_length=device.helix.length,
            helix_radius=device.helix.radius,
            pitch=device.helix.pitch,
            wire_radius=device.helix.wire_radius,
            chirality=CHIRALITY[device.helix.handedness],
        )

    @property
    def nose(self) -> float:
        """Front end on the long axis (m)."""
        return self.head_reach

    @property
    def tail(self) -> float:
        """Rear end on the long axis (m)."""
        return -(self.head_reach + self.helix_length)

    @property
    def length(self) -> float:
        """From end to end (m)."""
        return self.nose - self.tail

    @property
    def turns(self) -> float:
        """Of the helix over the length from end to end, as if it went on over the head."""
        return self.length / self.pitch

    @property
    def width(self) -> float:
        """Outer diameter of the helix (m)."""
        return 2.0 * (self.helix_radius + self.wire_radius)

    @property
    def brightness_length(self) -> float:
        """Width of the dark band that the wire casts on average over the helix (m): its projected area over its
        length."""
        angle = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
        slope = 2.0 * np.pi * self.helix_radius / self.pitch * np.cos(angle)
        return float(2.0 * self.wire_radius * np.mean(np.hypot(1.0, slope)))

    def wire(self, count: int = 73) -> Floats:
        """Points (count, 3) on the helix' centreline in the body frame (m), see the conventions of the model."""
        u = np.linspace(0.0, self.helix_length, count)
        return helix_line(
            u, radius=self.helix_radius, pitch=self.pitch, chirality=self.chirality, behind=self.head_reach
        )
