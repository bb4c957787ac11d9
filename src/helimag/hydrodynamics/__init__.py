"""From a device's geometry to its 6x6 resistance."""

import math

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.hydrodynamics import boundary
from helimag.hydrodynamics.heads import head_resistance
from helimag.hydrodynamics.inversion import mobility
from helimag.hydrodynamics.resistive_force import gray_hancock, helix_resistance, lighthill
from helimag.scenario import Device, Fluid

__all__ = ["error_estimate", "mobility", "net_weight", "resistance"]

STANDARD_GRAVITY = 9.80665  # m/s^2


def resistance(device: Device, fluid: Fluid) -> NDArray[np.float64]:
    """6x6 resistance of the device (SI), translation first, about the device's origin.

    Resistive-force theory adds helix and head (eq. 7); the boundary model solves for both together.

    Parameters
    ----------
    device
        ``scenario.device``.
    fluid
        ``scenario.fluid``.

    Returns
    -------
    numpy.ndarray
        (6, 6): force (N) and torque (N m) per velocity (m/s) and angular velocity (rad/s).

    Raises
    ------
    InputError
        Where the chosen model does not apply to the geometry or does not reach its tolerance, or a given matrix is not
        symmetric positive definite.

    Examples
    --------
    A force along the axis of a helix turns it too: translation and rotation are coupled.

    >>> import helimag as hm
    >>> scenario = hm.load("paper/fig3c")
    >>> matrix = hm.resistance(scenario.device, scenario.fluid)
    >>> matrix.shape, bool(abs(matrix[0, 3]) > 0.0)
    ((6, 6), True)
    """
    choice = device.hydrodynamics
    if choice.resistance is not None:
        return _positive_definite(np.array(choice.resistance))
    if choice.model == "boundary" or device.helix is None:
        return fluid.viscosity * boundary.solution(device).resistance
    coefficients = {"lighthill": lighthill, "gray-hancock": gray_hancock}[choice.model]
    along, across = coefficients(device.helix, fluid.viscosity)
    wire = helix_resistance(device.helix, device.helix_start, along, across)
    return wire if device.head is None else wire + head_resistance(device.head, fluid.viscosity)


def error_estimate(device: Device) -> float | None:
    """Relative error that the boundary model states for its resistance; None for the models that state none."""
    return boundary.solution(device).error_estimate if device.hydrodynamics.model == "boundary" else None


def net_weight(device: Device, fluid: Fluid) -> tuple[float, float]:
    """Weight less buoyancy (N), and its moment about the head's centre: force times place along x (N m).

    From parts, each part weighs (rho - rho_fluid) V g at its own centre: the statics behind eq. (8).
    """
    if device.weight.given is not None:
        force, place = device.weight.given
        return force, force * place
    parts = []
    if device.helix is not None and device.weight.helix_density is not None:
        place = -device.helix_start - device.helix.length / 2.0
        parts.append((device.weight.helix_density, device.helix.volume, place))
    if device.head is not None and device.weight.head_density is not None:
        parts.append((device.weight.head_density, device.head.volume, 0.0))
    forces = [STANDARD_GRAVITY * (density - fluid.density) * volume for density, volume, _ in parts]
    return math.fsum(forces), math.fsum(force * place for force, (_, _, place) in zip(forces, parts, strict=True))


def _positive_definite(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    diagonal = np.diag(matrix)
    if not np.all(diagonal > 0.0):
        raise InputError("device.hydrodynamics.resistance must have a positive diagonal")
    scaled = matrix / np.sqrt(np.outer(diagonal, diagonal))
    if not np.allclose(scaled, scaled.T, atol=1e-6):
        raise InputError("device.hydrodynamics.resistance must be symmetric")
    if not np.linalg.eigvalsh(scaled + scaled.T).min() > 0.0:
        raise InputError("device.hydrodynamics.resistance must be positive definite: it must dissipate in every motion")
    return matrix
