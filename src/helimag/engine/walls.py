"""The medium of devices near floor and surface: tables of drag packed for the kernels."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from helimag.engine.medium import Alike, Medium
from helimag.engine.patience import announced
from helimag.hydrodynamics import mobility, resistance
from helimag.hydrodynamics.boundary import look_up, mobility_changes, wall_table
from helimag.physics.balance import Sheet
from helimag.physics.walls import (
    EVEN,
    LEANING,
    TWICE,
    Cubics,
    FloorAndSurface,
    WallGrid,
    near_walls,
    seen_walls,
    walls_again,
)
from helimag.scenario import Device, Fluid, Scenario

Floats = NDArray[np.float64]

# tables hold a wall below the device: one above is seen after half a turn about x, which turns y and z round
OVERHEAD = np.outer(*[np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])] * 2)


def pack_walls(scenarios: Sequence[Scenario], device: str) -> wp.array:
    """Floor and surface of each scenario with the tables of its device, on the device that computes."""
    packed, kept = [], []
    for scenario in scenarios:
        walls, grids = FloorAndSurface(), _grids(scenario, device)
        walls.grids = wp.array(grids, dtype=WallGrid, device=device)
        walls.alone = wp.array(_alone(scenario.device, scenario.fluid), dtype=Sheet, device=device)
        packed.append(walls)
        kept.append((grids, walls.grids, walls.alone))
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
    free, where = resistance(body, fluid), look_up(table)
    turn = OVERHEAD if kind == "surface" else 1.0
    even, leaning = (part * turn for part in mobility_changes(table, free, fluid.viscosity))
    parts = [
        _sheet(where.surface(even), EVEN),
        _sheet(where.surface(leaning), LEANING),
        _sheet(where.surface(leaning), TWICE),
    ]
    changes = np.stack(parts, axis=3)
    return {
        "middle": table.middle,
        "least": table.gaps[0],
        "near": where.near,
        "far": where.far,
        "per_gap": 1.0 / (where.rows[1] - where.rows[0]),
        "low": where.rows[0] / (where.rows[1] - where.rows[0]),
        "rows": where.rows.size,
        "turning": where.halves[1, 0],
        "first": wp.vec2d(*where.halves[:, 0]),
        "per_tilt": wp.vec2d(*1.0 / (where.halves[:, 1] - where.halves[:, 0])),
        "columns": where.halves.shape[1] - 1,
        "reach": wp.array(where.cubics(table.reach[:, 1:-1]).reshape(-1, 4), dtype=wp.vec4d, device=device),
        "changes": wp.array(changes.reshape(-1, *Cubics._shape_), dtype=Cubics, device=device),
    }


@lru_cache(maxsize=64)
def _alone(device: Device, fluid: Fluid) -> Floats:
    """Mobility in open water (3, 8) as the kernels add what walls change, see :func:`helimag.physics.walls.moved`."""
    free = mobility(resistance(device, fluid))
    beside = ((2, 2), (3, 3), (2, 5), (2, 4), (5, 5))
    sheets = np.stack([_sheet(free, EVEN), _sheet(free, beside), _sheet(free, LEANING)])
    sheets[:2, 1] += free[1, 2] * np.array([1.0, -1.0])
    sheets[1, 3] *= -1.0
    return sheets


def _sheet(matrices: Floats, entries: Sequence[tuple[int, int]]) -> Floats:
    """Some entries of 6x6 matrices, on a sheet."""
    found = matrices[..., *np.transpose(entries)]
    return np.pad(found, [(0, 0)] * (found.ndim - 1) + [(0, Sheet._length_ - found.shape[-1])])


NEAR_WALLS = Medium(near_walls, seen_walls, pack_walls, alike=Alike.SIDEWAYS, again=walls_again, lanes=True)
