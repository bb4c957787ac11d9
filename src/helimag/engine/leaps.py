"""Multi-revolution steps: many turns of the magnet for two that are followed.

One turn is a map y -> y + D(y) in the frame that moves with the drive. Its Jacobian A changes little, so that
D(y) - A y, known at turns that were followed, changes slowly and smoothly from turn to turn; a polynomial through it
and A make a map that costs next to nothing. A leap predicts where that leads in many turns, follows one turn there,
goes the way again with that turn in the polynomial, and follows a turn where that led: an exponential Adams method
for maps, in PECE mode. What decays fast, as the roll does, is in A and limits no leap; the roll is what the map gave.

Multi-revolution methods: L. R. Petzold, SIAM J. Numer. Anal. 18 (1981) 455; M. P. Calvo, L. O. Jay, J. I. Montijano,
L. Randez, Numer. Math. 97 (2004) 635. Exponential Adams methods: M. Hochbruck, A. Ostermann, BIT 51 (2011) 889.
"""

from functools import cache

import warp as wp

from helimag.engine.charts import Place
from helimag.engine.control import Control
from helimag.engine.progress import Leap
from helimag.engine.system import System
from helimag.engine.turn_memory import SLOTS, Memory, Square, Weights, chart_turn, slot_of, store_shape
from helimag.engine.turns import Shape, build_turn
from helimag.physics.balance import Sheet, Swimmer
from helimag.physics.kinematics import ArmMotion, State, normalized
from helimag.physics.magnetics import FieldSource

ORDER = 8  # turns that a polynomial goes through before a leap; benchmarks/leaps.py
DIFFERENCE = wp.constant(wp.float64(1e-5))  # rad, and share of the length: steps of the Jacobian's differences
BEGINNING, COLUMNS, GUESSING, CORRECTING = (wp.constant(i) for i in range(4))  # what the next turn is followed for
ONE = wp.constant(wp.float64(1.0))
ZERO = wp.constant(wp.float64(0.0))

Residuals = wp.types.matrix(shape=(6, SLOTS), dtype=wp.float64)


@wp.struct
class Curve:
    """A polynomial through D(y) - A y at some turns, in Lagrange's form, by the slots they are kept in; in a chart."""

    oldest: wp.int32  # slot of the first of them
    used: Weights  # 1 where it goes through the turn of a slot, 0 where not
    numbers: Weights
    divisors: Weights  # inverse product of the distances to all others
    residuals: Residuals  # one column a slot; zero, as the divisors, where it does not


@wp.func
def curve_through(memory: Memory, run: int, first: int, count: int) -> Curve:
    """The polynomial through ``count`` turns from push number ``first`` on."""
    curve = Curve()
    curve.oldest = slot_of(first)
    for slot in range(SLOTS):
        if slot_of(slot + SLOTS - curve.oldest) < count:
            curve.used[slot] = ONE
            curve.numbers[slot] = memory.numbers[run, slot]
            residual = memory.residuals[run, slot]
            for c in range(6):
                curve.residuals[c, slot] = residual[c]
    for slot in range(SLOTS):
        product = ONE
        for other in range(SLOTS):
            if slot != other:
                product *= wp.where(curve.used[other] > ZERO, curve.numbers[slot] - curve.numbers[other], ONE)
        curve.divisors[slot] = wp.where(curve.used[slot] > ZERO, ONE / product, ZERO)
    return curve


@wp.func
def weights_at(curve: Curve, number: wp.float64) -> Weights:
    """What each slot's turn counts at turn ``number``: Lagrange's polynomials.

    Loops of one length for curves of any, so that a compiler writes them out; where there is no turn they multiply by
    one.
    """
    weights = Weights()
    before = wp.float64(1.0)
    for i in range(SLOTS):
        weights[i] = before * curve.divisors[i]
        before *= wp.where(curve.used[i] > ZERO, number - curve.numbers[i], ONE)
    after = wp.float64(1.0)
    for k in range(SLOTS):
        i = SLOTS - 1 - k
        weights[i] *= after
        after *= wp.where(curve.used[i] > ZERO, number - curve.numbers[i], ONE)
    return weights


@wp.func
def next_turn(jacobian: Square, curve: Curve, weights: Weights, y: Place) -> Place:
    """Where the cheap map takes ``y`` in one turn."""
    return y + jacobian * y + curve.residuals * weights


@wp.func
def ahead(jacobian: Square, curve: Curve, number: wp.float64, turns: int, y: Place) -> Place:
    """Where the cheap map takes ``y`` in some turns, the first of which is ``number``."""
    at = y
    for j in range(turns):
        at = next_turn(jacobian, curve, weights_at(curve, number + wp.float64(j)), at)
    return at


@wp.func
def top_of(curve: Curve) -> Place:
    """The curve's highest divided difference, for a weight of one of its oldest turn."""
    return (curve.residuals * curve.divisors) / curve.divisors[curve.oldest]


@wp.func
def doubted(jacobian: Square, top: Place, weight: wp.float64, error: Place) -> Place:
    """What the oldest turn in the curve changes in where the cheap map leads, one turn on: the error's estimate."""
    return error + jacobian * error + weight * top


@wp.func
def largest(error: Place, control: Control) -> wp.float64:
    """Largest component of an error: angles, and positions over the length."""
    most = ZERO
    for i in range(6):
        unit = ONE
        if i < 3:
            unit = control.length
        most = wp.max(most, wp.abs(error[i]) / unit)
    return most


@wp.func
def difference(control: Control, column: int) -> wp.float64:
    """Step of the Jacobian's differences in one component."""
    if column < 3:
        return DIFFERENCE * control.length
    return DIFFERENCE


@wp.func
def spin_at(drive: ArmMotion, t: wp.float64) -> wp.vec2d:
    """Cosine and sine of the magnet's spin at ``t`` (s)."""
    angle = drive.spin_rate * t
    return wp.vec2d(wp.cos(angle), wp.sin(angle))


@cache
def build_follow(system: System) -> wp.Function:
    """Make the function that follows the turn that a leap aims at."""
    turn, around_type = build_turn(system), system.medium.surroundings_type

    @wp.func
    def follow(
        body: Swimmer,
        around: around_type,
        drive: ArmMotion,
        magnets: wp.array(dtype=FieldSource),
        tail: wp.float64,
        looks: wp.array2d(dtype=Sheet),
        leap: Leap,
        fine: int,
    ):
        known = wp.int32(0)
        if fine == 1 and (leap.stage == COLUMNS or leap.stage == CORRECTING):
            known = 1  # begun beside the turn before, with as many steps
        return turn(body, around, looks, known, drive, magnets, tail, spin_at(drive, leap.origin), fine, leap.aim)

    return follow


@wp.func
def remembered(memory: Memory, run: int, leap: Leap, end: State, shape: Shape):
    """Keep the turn that a leap aimed at as the newest; none whose numbers broke down, which no leap takes.

    Turns that a polynomial does not go through are summed with a weight of zero, and zero times those is not zero.
    """
    if not wp.isfinite(end):
        return
    slot = slot_of(leap.pushes)
    memory.numbers[run, slot] = leap.aim_number
    memory.places[run, slot] = leap.aim
    memory.ends[run, slot] = end
    store_shape(memory, run, slot, shape, normalized(leap.aim), end)
    chart_turn(memory, run, slot, leap.reference, leap.miss)  # of no use before there is a Jacobian
