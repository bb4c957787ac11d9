"""What surrounds the device and acts on it: fluid, magnets, drive, workspace, run."""

import math
from typing import Literal, Self

from pydantic import model_validator

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario._device import Part
from helimag.scenario._fields import (
    Angle,
    AngularRate,
    Density,
    Frequency,
    Heading,
    Length,
    LengthRange,
    Moment,
    Pull,
    Remanence,
    Size,
    Time,
    Velocity,
    Viscosity,
)
from helimag.scenario._limits import LEAST_FREQUENCY
from helimag.scenario._path import Path
from helimag.scenario._remanence import REMANENCE, cylinder_moment


class Fluid(Part):
    """A Newtonian fluid."""

    viscosity: Viscosity
    """Dynamic viscosity of the fluid at the temperature of the run; drag is proportional to it."""
    density: Density
    """Density of the fluid: for the buoyancy of parts that are given by their densities, and for the Reynolds number.
    """


class Magnet(Part):
    """One magnet on the arm; its size sets where the device touches it, and its field if that is the cylinder's.

    Its strength is given as a moment, or as a grade of NdFeB or a remanence: the moment follows with its size.
    All magnets turn as one about parallel axes; ``phase`` is what a magnet's moment is ahead of the spin.
    """

    moment: Moment | None = None
    """Size of the dipole moment. It points across the axis about which the magnet turns: along the arm frame's y at t =
    0.
    """
    grade: Literal["N35", "N38", "N40", "N42", "N45", "N48", "N50", "N52"] | None = None
    """Grade of sintered NdFeB as bought, in place of ``moment``: the moment follows from the middle of its range of
    remanence and the size.
    """
    remanence: Remanence | None = None
    """Remanence of the material, in place of ``moment``: the moment follows with the size."""
    moment_uncertainty: Moment | None = None
    """Half the range in which the moment lies, for reports and ensembles; that of a grade follows from it. It changes
    no run.
    """
    radius: Size
    """Radius of the cylinder, which is magnetised along its own axis."""
    height: Size
    """Height of the cylinder along its own axis, which is the moment's."""
    field: Literal["dipole", "cylinder"] = "dipole"
    """Whose field acts: of a point dipole at the magnet's centre, or of a uniformly magnetised cylinder. The same for
    all magnets.
    """
    offset: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """Place of this magnet's centre from the arm's point, in the arm frame (x along the axis of rotation)."""
    phase: Angle | None = None
    """Angle by which this magnet's moment is ahead of the spin, in the sense of rotation; 0 if left out."""

    @model_validator(mode="after")
    def _one_strength(self) -> Self:
        given = [name for name in ("moment", "grade", "remanence") if getattr(self, name) is not None]
        if len(given) != 1:
            raise InputError(f"needs one of moment, grade and remanence; got {' and '.join(given) or 'none of them'}")
        if self.grade is not None and self.moment_uncertainty is not None:
            raise InputError(".moment_uncertainty follows from the grade; leave it out")
        return self

    @property
    def dipole_moment(self) -> float:
        """Moment (A m^2): as given, or of the middle of the grade's range of remanence."""
        if self.moment is not None:
            return self.moment
        low, high = self._remanences
        return cylinder_moment((low + high) / 2.0, self.radius, self.height)

    @property
    def dipole_moment_uncertainty(self) -> float | None:
        """Half the range in which the moment lies (A m^2); None where nothing is said of it."""
        if self.grade is None:
            return self.moment_uncertainty
        low, high = self._remanences
        return cylinder_moment((high - low) / 2.0, self.radius, self.height)

    @property
    def _remanences(self) -> tuple[float, float]:
        if self.grade is not None:
            return REMANENCE[self.grade]
        return (self.remanence or 0.0,) * 2

    @property
    def reach(self) -> float:
        """Radius of the sphere around the magnet (m)."""
        return math.hypot(self.radius, self.height / 2.0)


class Drive(Part):
    """What the arm and the motor do: the paper's inputs; and where the device begins, and which end first.

    ``heading`` is the end that leads at the start, ``"helix"`` or ``"head"``: the device is then level along the
    magnet's rotation axis, with that end where the drive carries it. In its place there may be a whole attitude: yaw,
    pitch and roll of R_z(yaw) R_y(-pitch) R_x(roll), where pitch is the attack angle of the head. Left out, the head
    points along x.
    """

    frequency: Frequency
    """Turns of the magnet per second about its axis, right-handed about the arm frame's x; negative turns it the other
    way.
    """
    pitch: Angle
    """Elevation of the axis about which the magnet turns: positive lifts its x end above the horizontal."""
    distance: Size
    """Height of the magnet's centre above the head's centre at the start, before ``pitch`` swings it where
    ``pitch_about`` is the origin.
    """
    yaw_rate: AngularRate = 0.0
    """Rate at which the arm turns about the lab's vertical z axis; positive is counter-clockwise seen from above."""
    velocity: tuple[Velocity, Velocity, Velocity] = (0.0, 0.0, 0.0)
    """Constant velocity of the magnet in the lab frame, added to the circle of ``yaw_rate``."""
    pitch_about: Literal["origin", "magnet"] = "origin"
    """What the pitch tilts: ``origin`` swings the magnet's place about the lab's origin as well, as eq. (1) says;
    ``magnet`` tilts its axis alone, straight above.
    """
    start: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    """Place of the head's centre at t = 0 in the lab frame; the circle of ``yaw_rate`` is about the lab's z axis."""
    heading: Heading | None = None
    """Which end leads at the start, ``helix`` or ``head``, level; or yaw, pitch and roll of the device in the lab. Left
    out, its nose points along lab x.
    """
    path: Path | None = None
    """The magnet's path at given times, in place of ``distance``, ``velocity`` and ``yaw_rate``: a table
    ``[drive.path]``.
    """

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        if self.frequency == 0.0:
            raise InputError(".frequency must not be zero; a negative one turns the magnet the other way")
        if abs(self.frequency) < LEAST_FREQUENCY:
            least, got = q.show(LEAST_FREQUENCY, q.FREQUENCY), q.show(self.frequency, q.FREQUENCY)
            raise InputError(f".frequency must be at least {least} either way (a turn in eleven days); got '{got}'")
        if self.path is not None and (self.yaw_rate != 0.0 or any(self.velocity)):
            raise InputError(".path takes the place of yaw_rate and velocity; leave these out")
        if not abs(self.pitch) < math.pi / 2.0:
            raise InputError(f".pitch must be between -90 deg and 90 deg; got '{q.show(self.pitch, q.ANGLE)}'")
        return self

    @property
    def angles(self) -> tuple[float, float]:
        """Yaw and pitch of the RPM's rotation axis at t = 0 (rad)."""
        if self.path is None:
            return 0.0, self.pitch
        return next(iter(self.path.yaw), 0.0), next(iter(self.path.pitch), self.pitch)


# The paper's tank of 200 x 80 x 80 mm, filled to its rim, in the lab frame of the straight runs: lowest and highest
# corner (m). Size: published, section III. Where the run starts in it: assumed, as in the presets of Table I.
PAPER_TANK = ((-0.020, -0.040, -0.0765), (0.180, 0.040, 0.0035))


class Walls(Part):
    """Upright walls of the tank, as ranges in lab x and y."""

    x: LengthRange | None = None
    """Lowest and highest lab x of the fluid; no walls there if left out."""
    y: LengthRange | None = None
    """Lowest and highest lab y of the fluid; no walls there if left out."""


class Workspace(Part):
    """What limits the device: lab heights of floor and surface, and walls.

    Where they are touched the run stops, or, with ``contact = "hold"``, goes on: they push, without friction. A surface
    may hold each end of the device that touches it with the force ``surface_pull``.
    """

    floor: Length | None = None
    """Lab height of the tank's floor; none if left out."""
    surface: Length | None = None
    """Lab height of the fluid's free surface; none if left out."""
    walls: Walls = Walls()
    """Upright walls: a table ``[workspace.walls]``."""
    contact: Literal["stop", "hold"] | None = None
    """What happens to a device that touches floor, surface or wall: the run stops, or goes on while they hold it. Stop
    if left out.
    """
    surface_pull: Pull | None = None
    """Force with which the surface holds each end of the device that touches it; none if left out."""

    @model_validator(mode="after")
    def _pull_fits(self) -> Self:
        if self.surface_pull is not None and (self.surface is None or self.contact != "hold"):
            raise InputError('.surface_pull goes with a surface and contact = "hold" only')
        return self

    @property
    def bounded(self) -> bool:
        """Whether there is a floor, a surface or a wall."""
        return any(math.isfinite(at) for corner in self.box for at in corner)

    @property
    def holds(self) -> bool:
        """Whether there are walls, and they hold what touches them."""
        return self.contact == "hold" and self.bounded

    @property
    def box(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Lowest and highest corner (m), infinite where nothing is there."""
        x = self.walls.x or (-math.inf, math.inf)
        y = self.walls.y or (-math.inf, math.inf)
        floor = -math.inf if self.floor is None else self.floor
        surface = math.inf if self.surface is None else self.surface
        return (x[0], y[0], floor), (x[1], y[1], surface)


MOST_SAMPLES = 5e6  # of one run; half a gigabyte of records


class Run(Part):
    """How long to simulate, and how often to write a sample (1800 samples where not given)."""

    duration: Time = 1800.0
    """How long to simulate."""
    interval: Time | None = None
    """Time between samples; 1800 samples if left out. Gain and verdict do not depend on it."""

    @model_validator(mode="after")
    def _memory_suffices(self) -> Self:
        samples = self.duration / self.sample_interval
        if samples > MOST_SAMPLES:
            least = q.show(self.duration / MOST_SAMPLES, q.TIME)
            got = q.show(self.sample_interval, q.TIME)
            raise InputError(f".interval must be at least {least}, for {MOST_SAMPLES:g} samples; got '{got}'")
        return self

    @property
    def sample_interval(self) -> float:
        """Time between samples (s)."""
        return self.duration / 1800.0 if self.interval is None else self.interval
