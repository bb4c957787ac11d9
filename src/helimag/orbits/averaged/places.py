"""Which places around an orbit are looked at."""

from helimag.errors import InputError
from helimag.orbits.strobe import Floats, Orbit

REACH = 0.36  # of the distance: how far a box goes from the orbit on each side


def box_around(orbit: Orbit, *, reach: float | None = None) -> tuple[Floats, Floats]:
    """Corners (3,) of a box with the orbit in its middle, moving frame, m.

    Parameters
    ----------
    orbit
        One that was found.
    reach
        How far the box goes on each side, m. Default: 0.36 of ``drive.distance``.

    Returns
    -------
    tuple of ndarray
        Lowest and highest corner.

    Raises
    ------
    InputError
        Where the orbit was not found, or the box reaches no farther than nothing.
    """
    if not orbit.found:
        raise InputError(f"{orbit.scenario.title} has no orbit that this could be around: {orbit.text}")
    half = REACH * orbit.scenario.drive.distance if reach is None else reach
    if not half > 0.0:
        raise InputError(f"reach must be greater than zero; got {half:g} m")
    return orbit.position - half, orbit.position + half
