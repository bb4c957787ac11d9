"""The medium of devices near floor and surface: tables of drag packed for the kernels."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import warp as wp

from helimag.engine.medium import Medium
from helimag.engine.patience import announced
from helimag.hydrodynamics import resistance
from helimag.hydrodynamics.boundary import mobility_changes, wall_table
from helimag.physics.walls import FloorAndSurface, Symmetric, WallGrid, near_walls, seen_walls
from helimag.scenario import Device, Fluid, Scenario

UPPER = np.triu_indices(6)
# tables hold a wall below the device: one above is seen after half a turn about x, which turns y and z round
OVERHEAD = np.outer(*[np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])] * 2)


def pack_walls(scenarios: Sequence[Scenario], device: str) -> wp.array:
    """Floor and surface of each scenario with the tables of its device, on the device that computes."""
    packed = [_walls(scenario, device) for scenario in scenarios]
    walls = wp.array(packed, dtype=FloorAndSurface, device=device)
    walls.tables = packed  # the array only points to these; they must live as long as it does
    return walls


def _walls(scenario: Scenario, device: str) -> Any:
    walls, workspace = FloorAndSurface(), scenario.workspace
    wanted = scenario.device.hydrodynamics.near_walls
    if wanted and workspace.floor is not None:
        walls.floor = workspace.floor
        walls.near_floor = _grid(scenario.device, scenario.fluid, "floor", device)
    if wanted and workspace.surface is not None:
        walls.surface = workspace.surface
        walls.near_surface = _grid(scenario.device, scenario.fluid, "surface", device)
    return walls


@lru_cache(maxsize=64)
def _grid(body: Device, fluid: Fluid, kind: Any, device: str) -> Any:
    """One table as the kernels take it."""
    waiting = f"making the table of drag near the {kind} for this device, once (some minutes) ..."
    with announced(waiting, log=f"table of drag near the {kind}"):
        table = wall_table(body, kind)
    free = resistance(body, fluid)
    seen = mobility_changes(table, free, fluid.viscosity) * (OVERHEAD if kind == "surface" else 1.0)
    changes = np.ascontiguousarray(seen[..., UPPER[0], UPPER[1]])
    grid = WallGrid()
    grid.middle = table.middle
    grid.least = table.gaps[0]
    grid.low, grid.high = np.log(table.gaps[[0, -1]])
    grid.least_tilt, grid.turning, grid.most_tilt = table.tilts[0, 0], table.tilts[1, 0], table.tilts[1, -1]
    grid.reach = wp.array(table.reach, dtype=wp.float64, device=device)
    grid.changes = wp.array(changes, dtype=Symmetric, device=device)
    return grid


NEAR_WALLS = Medium(near_walls, seen_walls, pack_walls)
