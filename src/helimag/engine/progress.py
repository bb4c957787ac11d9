"""Where a run stands between launches: all that it needs to go on."""

import warp as wp

from helimag.engine.charts import Place
from helimag.engine.samples import Statistics
from helimag.engine.synchrony import Synchrony
from helimag.engine.touches import Touches
from helimag.physics.kinematics import State


@wp.struct
class Leap:
    """How a run leaps over turns; nothing of it is used where a method does not."""

    ready: wp.float64  # s: before this no leap is tried
    wait: wp.float64  # turns that it was put off by last; none where leaps have been worth while since
    stage: wp.int32  # what the next turn is followed for
    column: wp.int32  # of the Jacobian, where it is for that; and one more, for ``miss``
    origin: wp.float64  # s: turns are counted from here
    number: wp.float64  # of the turn that comes next
    roll: wp.float64  # which way the body rolls with the magnet, 1 or -1
    stride: wp.int32  # turns to try next
    turns_aimed: wp.int32  # turns of the leap that is tried
    aim_number: wp.float64  # number of the turn to be followed
    fine: wp.int32  # steps between two nodes of it; the same for all turns that a polynomial goes through
    miss: Place  # what twice as many steps change at the end of a turn
    aim: State  # where that begins, moving frame
    reference: State  # whose attitude the chart is about, see ``charts``
    error: wp.float64  # of the leap that is tried, in units of its tolerance
    pushes: wp.int32  # turns remembered so far
    known: wp.int32  # of them, those since leaping began
    age: wp.int32  # leaps since the Jacobian
    followed: wp.int64  # turns that were followed
    turns: wp.int64  # turns that the run was taken over by leaps


@wp.struct
class Progress:
    """Where one run stands between launches."""

    time: wp.float64
    step: wp.float64
    state: State
    middle: State  # about which surroundings were looked at last
    status: wp.int32
    sample: wp.int32  # the next to be recorded
    steps: wp.int64
    rejected: wp.int64
    synchrony: Synchrony
    statistics: Statistics
    touches: Touches
    leap: Leap
