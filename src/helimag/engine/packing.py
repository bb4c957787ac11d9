"""From scenarios to the arrays of structures that the kernels take."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.patience import announced
from helimag.engine.structures import alike, structs
from helimag.geometry import magnet_place
from helimag.hydrodynamics import mobility, net_weight, resistance
from helimag.physics import magnetics
from helimag.physics.balance import Swimmer
from helimag.physics.kinematics import ArmMotion, Knot, SampledMotion
from helimag.scenario import Device, Fluid, Magnet, Path, Scenario

Floats = NDArray[np.float64]


def initial_gap(scenario: Scenario) -> float:
    """Input u of the gain: height difference of RPM and device at the start (m), eq. (5)."""
    return abs(magnet_place(scenario.drive)[2] - scenario.drive.start[2])


def pack_bodies(scenarios: Sequence[Scenario]) -> NDArray[np.void]:
    """Devices as the kernels take them."""
    firsts, which = alike([(scenario.device, scenario.fluid) for scenario in scenarios])
    return structs(Swimmer, [_body(scenarios[run].device, scenarios[run].fluid) for run in firsts])[which]


@lru_cache(maxsize=64)  # batches that differ in their drives alone are packed again and again
def _body(device: Device, fluid: Fluid) -> dict[str, object]:
    force, moment = net_weight(device, fluid)
    with announced("solving for the drag of this device, once (some ten seconds) ...", log="drag of the device"):
        matrix = resistance(device, fluid)
    return {
        "magnetic_moment": device.magnetic_moment,
        "net_weight": force,
        "weight_moment": moment,
        "mobility": mobility(matrix),
    }


def pack_drives(scenarios: Sequence[Scenario], device: str) -> wp.array:
    """Drives as the kernels take them, on the device: all in closed form, or all sampled."""
    paths = [scenario.drive.path for scenario in scenarios]
    if paths[0] is not None:
        sampled = [_sampled(s, path, device) for s, path in zip(scenarios, paths, strict=True) if path is not None]
        drives = wp.array(sampled, dtype=SampledMotion, device=device)
        drives.samples = sampled  # the array only points to these; they must live as long as it does
        return drives
    packed = structs(
        ArmMotion,
        [
            {
                "arm": magnet_place(scenario.drive),
                "velocity": scenario.drive.velocity,
                "yaw_rate": scenario.drive.yaw_rate,
                "spin_rate": 2.0 * math.pi * scenario.drive.frequency,
                "cos_pitch": math.cos(scenario.drive.pitch),
                "sin_pitch": math.sin(scenario.drive.pitch),
            }
            for scenario in scenarios
        ],
    )
    return wp.array(packed, dtype=ArmMotion, device=device)


def _sampled(scenario: Scenario, path: Path, device: str) -> SampledMotion:
    spline = path.spline(scenario.drive.pitch)
    sampled = SampledMotion()
    sampled.times = wp.array(spline.x, dtype=wp.float64, device=device)
    sampled.pieces = wp.array(np.ascontiguousarray(spline.c.transpose(1, 0, 2)), dtype=Knot, device=device)
    sampled.spin_rate = 2.0 * math.pi * scenario.drive.frequency
    return sampled


def pack_magnets(scenarios: Sequence[Scenario]) -> NDArray[np.void]:
    """Magnets as the kernels take them: (runs, magnets); null moments fill up scenarios that have fewer."""
    most = max(len(scenario.magnet) for scenario in scenarios)
    firsts, which = alike([scenario.magnet for scenario in scenarios])
    rows: list[dict[str, object]] = []
    for magnets in [scenarios[run].magnet for run in firsts]:
        rows += [_magnet(magnet) for magnet in magnets]
        # where a magnet is already: elsewhere, a device could touch what is not there
        rows += [_nothing(magnets[0]) for _ in range(most - len(magnets))]
    return structs(magnetics.FieldSource, rows).reshape(len(firsts), most)[which]


def _nothing(magnet: Magnet) -> dict[str, object]:
    """A magnet without a moment, in the place of one."""
    return {name: np.zeros_like(value) for name, value in _magnet(magnet).items()} | {"offset": magnet.offset}


@lru_cache(maxsize=64)
def _magnet(magnet: Magnet) -> dict[str, object]:
    slices = magnetics.slices_of(magnet.radius, magnet.height)
    phase = magnet.phase or 0.0
    return {
        "offset": magnet.offset,
        "moment": magnet.dipole_moment,
        "cos_phase": math.cos(phase),
        "sin_phase": math.sin(phase),
        "slices": slices,
        "thickness": magnet.height / slices,
        "multipoles": multipoles(magnet.dipole_moment / slices, magnet.radius, magnet.height / slices),
    }


def multipoles(moment: float, radius: float, height: float) -> Floats:
    """Axial multipole moments of a cylinder magnetised along its axis: orders 1, 3, 5 ... (A m^(order + 1)).

    Its ends are discs of opposite charge: order n is the moment, over half the height, times the mean of r^n P_n on a
    disc.
    """
    orders = int(magnetics.HIGHEST_ORDER) + 1
    half = height / 2.0
    nodes, weights = np.polynomial.legendre.leggauss(orders)
    distance = np.hypot(half, radius * np.sqrt((1.0 + nodes) / 2.0))
    legendre = np.polynomial.legendre.legvander(half / distance, orders - 1)
    powers = distance[:, None] ** np.arange(orders)
    return np.asarray(moment / half * (weights / 2.0) @ (powers * legendre))[1::2]
