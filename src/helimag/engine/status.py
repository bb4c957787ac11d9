"""How a run stands."""

from enum import IntEnum


class Status(IntEnum):
    """How a run stands."""

    RUNNING = 0
    HORIZON = 1
    CONTACT = 2
    FALL = 3
    FLOOR = 4
    SURFACE = 5
    WALL = 6
    NOT_FINITE = 7
