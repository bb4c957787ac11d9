"""Which walls a run has touched: how often, from when to when, and for how long."""

import warp as wp

from helimag.outcomes import Limit

HALF = wp.constant(wp.float64(0.5))
WALLS = len(Limit)

WallCounts = wp.types.vector(length=WALLS, dtype=wp.int32)
WallTimes = wp.types.vector(length=WALLS, dtype=wp.float64)


@wp.struct
class Touches:
    """A run's contacts so far, each wall at its number in ``outcomes.Limit``, as are bits of ``now`` and ``lately``."""

    now: wp.int32  # walls that push
    lately: wp.int32  # and those that have since the last sample
    count: WallCounts  # how often each began to
    first: WallTimes  # when it first did, s
    last: WallTimes  # and last
    total: WallTimes  # for how long in all, s


@wp.func
def touches_with(before: Touches, touched: int, t: wp.float64, dt: wp.float64) -> Touches:
    """The contacts with one more step of ``dt`` (s) in them, at whose end ``t`` (s) these walls push."""
    after = before
    if touched == 0 and before.now == 0:
        return after
    walls = wp.int32(WALLS)  # a loop over a variable is not unrolled
    for wall in range(walls):
        was = (before.now >> wall) & 1
        has = (touched >> wall) & 1
        after.total[wall] = before.total[wall] + HALF * dt * wp.float64(was + has)
        if has == 1:
            after.last[wall] = t
            if was == 0:
                if before.count[wall] == 0:
                    after.first[wall] = t
                after.count[wall] = before.count[wall] + 1
    after.now = touched
    after.lately = before.lately | touched
    return after
