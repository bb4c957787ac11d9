"""The right-hand side of every code beside the engine's own kernel, on random states."""

from collections.abc import Callable

import numpy as np
import warp as wp
from equations import unit_of
from numpy.typing import NDArray

from helimag.engine import build_rates, pack_bodies, pack_drives, pack_magnets, system_of
from helimag.physics.balance import OpenWater, Swimmer
from helimag.physics.kinematics import ArmMotion, State
from helimag.physics.magnetics import FieldSource
from helimag.scenario import Scenario

Floats = NDArray[np.float64]
STATES = 100
ROUNDING = 1e-12  # of the largest rate of its kind; sums of a dozen products in another order differ by some 1e-14


def kernel_rates(scenario: Scenario, times: Floats, states: Floats) -> Floats:
    """Rates (n, 7), SI, by the engine's kernel in open water, at times (n,) and states (n, 7) of the lab frame."""
    rates = build_rates(system_of(scenario))

    @wp.kernel(enable_backward=False, module="unique")
    def at(
        bodies: wp.array(dtype=Swimmer),
        drives: wp.array(dtype=ArmMotion),
        magnets: wp.array2d(dtype=FieldSource),
        when: wp.array(dtype=wp.float64),
        where: wp.array(dtype=State),
        found: wp.array(dtype=State),
    ):
        i = wp.tid()
        found[i] = rates(bodies[0], OpenWater(), drives[0], magnets[0], when[i], where[i])

    found = wp.zeros(len(times), dtype=State, device="cpu")
    given = [
        wp.array(pack_bodies([scenario]), dtype=Swimmer, device="cpu"),
        pack_drives([scenario], "cpu"),
        wp.array(pack_magnets([scenario]), dtype=FieldSource, device="cpu"),
        wp.array(times, dtype=wp.float64, device="cpu"),
        wp.array(states, dtype=State, device="cpu"),
    ]
    wp.launch(at, len(times), inputs=given, outputs=[found], device="cpu")
    return np.asarray(found.numpy())


def random_states(scenario: Scenario) -> tuple[Floats, Floats]:
    """Times over the run, places within two helix lengths of the start, any attitude."""
    generator = np.random.default_rng(14)
    turns = generator.normal(size=(STATES, 4))
    reach = 2.0 * unit_of(scenario)
    places = np.array(scenario.drive.start) + generator.uniform(-reach, reach, (STATES, 3))
    times = generator.uniform(0.0, scenario.run.duration, STATES)
    return times, np.hstack([places, turns / np.linalg.norm(turns, axis=1, keepdims=True)])


def difference(scenario: Scenario, rates: Callable[[float, Floats], Floats]) -> float:
    """Largest difference of a code's rates (in the equations' units) from the kernel's, as a share of the largest."""
    times, states = random_states(scenario)
    expected = kernel_rates(scenario, times, states)
    unit = unit_of(scenario)
    found = np.array([rates(t, np.concatenate([s[:3] / unit, s[3:]])) for t, s in zip(times, states, strict=True)])
    found[:, :3] *= unit
    return float((np.abs(found - expected) / np.abs(expected).max(axis=0)).max())
