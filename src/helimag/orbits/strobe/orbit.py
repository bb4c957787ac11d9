"""A periodic orbit in the frame that moves with the drive, with its stability; or the reason why there is none."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from helimag.geometry import long_axes, magnet_start
from helimag.notebook import summary
from helimag.outcomes import OrbitStatus
from helimag.runs import leading_end
from helimag.scenario import Scenario

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

Side = Literal["below", "beside", "above"]
STEADY = 1e-9  # 1/s; an imaginary part below this is rounding


@dataclass(frozen=True, kw_only=True)
class Orbit:
    """Result of a search for an orbit. SI, angles in radians; where none was found, arrays are nan or empty.

    Attributes
    ----------
    status
        How the search ended; :attr:`found` in short.
    state
        (7,): head position and quaternion w, x, y, z when the magnet's moment passes its first direction, in the frame
        that yaws and translates with the drive. That frame is the lab frame at t = 0.
    multipliers
        (6,) complex Floquet multipliers: what a small displacement is multiplied by in a turn of the magnet.
    rates
        (6,) complex, 1/s: their logarithms over the period; negative real parts decay.
    jacobian
        (6, 6) of the one-period map, in displacements over ``drive.distance`` and rotation vectors in body axes.
    mean_position
        (3,) mean over the period, moving frame, m.
    height_range
        Lowest and highest head over the period, m; moving frame.
    attack_angle, wobble
        Mean and standard deviation of the attack angle over the period.
    lag_cosine
        Least cosine of the phase lag over the period: the device is about to lose step as it nears zero.
    position_error
        How far the fixed point moves when the integration takes twice the steps, m.
    """

    scenario: Scenario
    status: OrbitStatus
    state: Floats = field(default_factory=lambda: np.full(7, np.nan))
    multipliers: Complexes = field(default_factory=lambda: np.empty(0, dtype=np.complex128))
    rates: Complexes = field(default_factory=lambda: np.empty(0, dtype=np.complex128))
    jacobian: Floats = field(default_factory=lambda: np.full((6, 6), np.nan), repr=False)
    mean_position: Floats = field(default_factory=lambda: np.full(3, np.nan))
    height_range: tuple[float, float] = (math.nan, math.nan)
    attack_angle: float = math.nan
    wobble: float = math.nan
    lag_cosine: float = math.nan
    position_error: float = math.nan
    iterations: int = 0

    @property
    def found(self) -> bool:
        """Whether there is an orbit."""
        return self.status is OrbitStatus.FOUND

    @property
    def stable(self) -> bool:
        """Whether every small displacement dies out."""
        return self.found and bool(np.all(np.abs(self.multipliers) < 1.0))

    @property
    def position(self) -> Floats:
        """Head (3,), m, in the moving frame at the start of the period."""
        return self.state[:3]

    @property
    def side(self) -> Side:
        """Where the device is from the magnet: within 45 deg of straight below or above it, or else beside it.

        The pull that holds a device against its weight comes from above; elsewhere an orbit is one of the equations,
        and seldom of a laboratory.
        """
        across_x, across_y, up = self.position - magnet_start(self.scenario.drive)
        if abs(up) < math.hypot(across_x, across_y):
            return "beside"
        return "above" if up > 0.0 else "below"

    @property
    def growth(self) -> float:
        """Real part of the leading rate (1/s): negative where stable."""
        return float(self.rates.real.max()) if self.found else math.nan

    @property
    def radius(self) -> float:
        """Of the circle that the head's mean position describes in the lab, m; nan for a straight run."""
        circular = self.scenario.drive.yaw_rate != 0.0
        return math.hypot(self.mean_position[0], self.mean_position[1]) if circular else math.nan

    @property
    def speed(self) -> float:
        """Of the head along its mean path in the lab, m/s."""
        drive = self.scenario.drive
        return math.hypot(*drive.velocity, drive.yaw_rate * self.radius if drive.yaw_rate else 0.0)

    @property
    def leading_cosine(self) -> float:
        """Cosine between nose and velocity in the lab: 1 head first, -1 helix first; nan where the drive stands."""
        drive = self.scenario.drive
        x, y, _ = self.mean_position
        velocity = np.array(drive.velocity) + drive.yaw_rate * np.array([-y, x, 0.0])
        speed = float(np.linalg.norm(velocity))
        return float(long_axes(self.state[3:]) @ velocity) / speed if speed > 0.0 else math.nan

    @property
    def leading_end(self) -> str:
        """The end in front: ``"head"``, ``"helix"``, or ``"neither"``."""
        return leading_end(self.leading_cosine)

    @property
    def text(self) -> str:
        """The orbit in a sentence or two."""
        if not self.found:
            return f"{self.status}: {self.status.text()}"
        x, y, z = 1e3 * self.position
        where = "" if self.side == "below" else f"{self.side.upper()} the magnet, not below it, "
        begin = f"orbit with the head at ({x:.2f}, {y:.2f}, {z:.2f}) mm in the moving frame, {where}"
        if self.stable:
            return f"{begin}stable: {describe_rates(self.rates)}"
        return f"{begin}unstable: {describe_rates(self.rates)}"

    def __repr__(self) -> str:
        return f"<Orbit {self.scenario.title}: {self.text}>"

    def _repr_html_(self) -> str:
        """For notebooks."""
        stable = {"stable": "yes" if self.stable else "no", "leads": self.leading_end} if self.found else {}
        return summary(f"Orbit of {self.scenario.title}", {"found": self.text, **stable})


def describe_rates(rates: Complexes, most: int = 2) -> str:
    """The slowest motions in words, leading first: how long they take to die out or to grow by e, and to swing once."""
    parts = []
    seen: list[complex] = []
    for rate in sorted(rates, key=lambda r: -r.real):
        if any(abs(rate - other.conjugate()) < STEADY for other in seen):
            continue
        seen.append(complex(rate))
        time = f"{1.0 / abs(rate.real):.4g} s" if rate.real else "no time at all"
        fate = f"grows e-fold in {time}" if rate.real > 0.0 else f"decays in {time}"
        if abs(rate.imag) > STEADY:
            parts.append(f"a swing of period {2.0 * math.pi / abs(rate.imag):.4g} s {fate}")
        else:
            parts.append(f"a displacement {fate}")
        if len(parts) == most:
            break
    return "; ".join(parts)
