"""The runs of a batch as kernels take them: what each is, and where it stands, column by column."""

from functools import cache
from typing import Any

import warp as wp

from helimag.engine.control import Control
from helimag.engine.events import Bounds
from helimag.engine.progress import Progress
from helimag.engine.samples import Record, Schedule
from helimag.engine.system import System
from helimag.engine.turn_memory import Memory
from helimag.physics.balance import Swimmer
from helimag.physics.magnetics import FieldSource


@cache
def build_columns(system: System) -> Any:
    """Make the structure of runs with these formulas: a row a run, and of ``records`` one a sample in it."""

    @wp.struct
    class RunColumns:
        bodies: wp.array(dtype=Swimmer)
        surroundings: wp.array(dtype=system.medium.surroundings_type)
        drives: wp.array(dtype=system.drive_type)
        magnets: wp.array2d(dtype=FieldSource)
        controls: wp.array(dtype=Control)
        bounds: wp.array(dtype=Bounds)
        schedules: wp.array(dtype=Schedule)
        progress: wp.array(dtype=Progress)
        records: wp.array2d(dtype=Record)
        memory: Memory

    return RunColumns
