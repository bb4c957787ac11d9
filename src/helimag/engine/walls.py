"""The medium of devices near floor and surface: tables of drag packed for the kernels."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import warp as wp

from helimag.engine.medium import Alike, Medium
from helimag.engine.patience import announced
from helimag.hydrodynamics import resistance
from helimag.hydrodynamics.boundary import mobility_changes, spline_coefficients, wall_table
from helimag.physics.walls import EVEN, LEANING, Change, FloorAndSurface, WallGrid, near_walls, seen_walls
from helimag.scenario import Device, Fluid, Scenario

# tables hold a wall below the device: one above is seen after half a turn about x, which turns y and z round
OVERHEAD = np.outer(*[np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])] * 2)


def pack_walls(scenarios: Sequence[Scenario], device: str) -> wp.array:
    """Floor and surface of each scenario with the tables of its device, on the device that computes."""
    packed, kept = [], []
    for scenario in scenarios:
        walls, grids = FloorAndSurface(), _grids(scenario, device)
        walls.grids = wp.array(grids, dtype=WallGrid, device=device)
        packed.append(walls)
        kept.append((grids, walls.grids))
    around = wp.array(packed, dtype=FloorAndSurface, device=device)
    around.kept = packed, kept  # arrays only point to these; they must live as long as it does
    return around


def _grids(scenario: Scenario, device: str) -> list[Any]:
    """The walls that change the drag, with their tables."""
    grids, workspace, body = [], scenario.workspace, scenario.device
    if not body.hydrodynamics.near_walls:
        return []
    for kind, place, sense in (("floor", workspace.floor, 1.0), ("surface", workspace.surface, -1.0)):
        if place is not None:
            grid = WallGrid()
            grid.place, grid.sense = place, sense
            for name, value in _table(body, scenario.fluid, kind, device).items():
                setattr(grid, name, value)
            grids.append(grid)
    return grids


@lru_cache(maxsize=64)
def _table(body: Device, fluid: Fluid, kind: Any, device: str) -> dict[str, Any]:
    """One table as the kernels take it, wherever the wall is."""
    waiting = f"making the table of drag near the {kind} for this device, once (some minutes) ..."
    with announced(waiting, log=f"table of drag near the {kind}"):
        table = wall_table(body, kind)
    free = resistance(body, fluid)
    turn = OVERHEAD if kind == "surface" else 1.0
    parts = zip(mobility_changes(table, free, fluid.viscosity), (EVEN, LEANING), strict=True)
    changes = np.concatenate([(part * turn)[..., *np.transpose(entries)] for part, entries in parts], axis=-1)
    changes = np.concatenate([changes, np.zeros((*changes.shape[:-1], 3))], axis=-1)
    return {
        "middle": table.middle,
        "least": table.gaps[0],
        "low": np.log(table.gaps[0]),
        "per_gap": (table.gaps.size - 1) / np.log(table.gaps[-1] / table.gaps[0]),
        "least_tilt": table.tilts[0, 0],
        "turning": table.tilts[1, 0],
        "per_tilt": wp.vec2d(*(table.tilts.shape[1] - 1) / np.ptp(table.tilts, axis=1)),
        "reach": wp.array(spline_coefficients(table.reach[:, 1:-1], 1), dtype=wp.float64, device=device),
        "changes": wp.array(np.ascontiguousarray(changes), dtype=Change, device=device),
    }


NEAR_WALLS = Medium(near_walls, seen_walls, pack_walls, alike=Alike.SIDEWAYS)
