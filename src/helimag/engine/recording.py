"""What is recorded of steps: the sample at the end of one, and those that are due within it."""

from functools import cache

import warp as wp

from helimag.engine.columns import build_columns
from helimag.engine.dense import state_at
from helimag.engine.methods import Method
from helimag.engine.progress import Progress
from helimag.engine.samples import Record, Schedule, gone_from, record_of, sample_time, stepped_with
from helimag.engine.synchrony import lag_vector, synchrony_with
from helimag.engine.system import System, build_balance, build_load
from helimag.engine.touches import touches_with
from helimag.outcomes import End
from helimag.physics.balance import SHEETS, Sheet, moment_of
from helimag.physics.kinematics import State, head_position, rotation_matrix

RUNNING, HORIZON = (wp.constant(end.flag) for end in (End.RUNNING, End.HORIZON))


@wp.func
def recorded(p: wp.ref[Progress], schedule: Schedule, run: int, records: wp.array2d(dtype=Record)):
    """Record the sample that is due, or the run's end."""
    records[run, p.sample] = record_of(p.statistics, p.time, p.state, p.synchrony.slips, p.touches.lately)
    p.statistics = gone_from(p.statistics, p.time)
    p.touches.lately = wp.int32(0)
    p.sample = p.sample + 1
    if p.status == RUNNING and p.time >= schedule.duration:
        p.status = HORIZON


@cache
def build_within(system: System, method: Method) -> wp.Function:
    """Make the function that records the samples due within a step of ``h`` (s) up to ``end``, before that.

    Each is seen as a step's end would be: slips, statistics, contacts; not so events, and whether to leap. Where the
    last of them leaves the run is put down in ``runs``. It returns the climb (m/s) there, the time from there to the
    step's end (s), and their number.
    """
    load, balance, pose_model = build_load(system.magnet), build_balance(system.medium.response), system.pose
    local, touched, columns_type = system.medium.local, system.medium.touched, build_columns(system)
    course_of = method.course(system) if method.course is not None else None

    @wp.func
    def within(runs: columns_type, run: int, h: wp.float64, end: wp.float64, kept: wp.array(dtype=State)):
        p = runs.progress[run]
        body, drive, rpm, schedule = runs.bodies[run], runs.drives[run], runs.magnets[run], runs.schedules[run]
        sheets = wp.zeros(shape=SHEETS, dtype=Sheet)
        here = local(runs.surroundings[run], head_position(p.middle), rotation_matrix(p.middle), sheets)
        course = course_of(body, here, drive, rpm, p.time, h, p.state, kept)  # a copy: time and state move on below
        climb = kept[0][2]
        samples = int(0)
        due = sample_time(schedule, p.sample)
        while due < end:
            p.state = state_at(course, due)
            field, force = load(rpm, pose_model(drive, due), head_position(p.state), moment_of(body, p.state))
            rates = balance(body, here, p.state, force, field)
            since = due - p.time
            p.synchrony = synchrony_with(p.synchrony, lag_vector(field, p.state))
            p.statistics = stepped_with(p.statistics, since, climb, p.state, rates[2])
            if wp.static(touched is not None):
                p.touches = touches_with(p.touches, touched(here, p.state, rates), due, since)
            climb = rates[2]
            samples += 1
            p.time = due
            recorded(p, schedule, run, runs.records)
            due = sample_time(schedule, p.sample)
        runs.progress[run] = p
        return climb, end - p.time, samples

    return within
