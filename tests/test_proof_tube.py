"""Tubes around curves whose fate is known: linear systems with a known flow, equations with a closed form."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

flint = pytest.importorskip("flint")

from helimag.proof.balls import arithmetic, exact  # noqa: E402
from helimag.proof.bounds import spans_of, straights_of  # noqa: E402
from helimag.proof.field import views_of  # noqa: E402
from helimag.proof.theorem import _time_in, allows, enters, shrinks, theorem_of  # noqa: E402
from helimag.proof.tube import N, Tube  # noqa: E402
from helimag.proof.waves import Waves  # noqa: E402

DECAY, SWING = (-0.3, -0.8, -1.5, -6.0), (0.7, 0.0, 0.0, 2.0)
BLOCKS = (0, 2, 3, 4)


@dataclass(frozen=True)
class Known:
    """z' = (Q B + Q') W z - cubic z^3 + drive sin(2 pi s) in each component of z, beside a curve of no meaning.

    With the frame Q the linear part is B: exp(B) is the map of a turn, whatever Q is.
    """

    wobble: float = 0.3
    cubic: float = 0.0
    drive: float = 0.0
    cross: float = 0.0  # times z2 z3, in the first component
    decay: tuple[float, ...] = DECAY
    components: int = 1
    plain: bool = True

    def waves(self) -> Waves:
        """A curve that is zero, and Q: ones and waves that do not commute."""
        cos, sin = np.zeros((1 + N * N, 3)), np.zeros((1 + N * N, 3))
        for j in range(N):
            cos[1 + N * j + j, 0] = 1.0
            cos[1 + N * j + (j + 1) % N, 2] = self.wobble
            sin[1 + N * j + (j + 2) % N, 2] = self.wobble
        return Waves(cos, sin)

    def constant(self) -> np.ndarray:
        matrix = np.zeros((N, N))
        for first, last, a, b in zip(BLOCKS, (*BLOCKS[1:], N), self.decay, SWING, strict=True):
            matrix[first:last, first:last] = [[a, b], [-b, a]] if last - first == 2 else a
        return matrix

    def rates(self, clock, curve, slope, deviation):  # noqa: ARG002
        cosine, sine = clock
        one = 0 * cosine + exact(1)
        zero = 0 * cosine
        wobble, turn = exact(self.wobble), 2 * flint.arb.pi()
        frame = [[one if i == j else zero for j in range(N)] for i in range(N)]
        speed = [[zero] * N for _ in range(N)]
        for j in range(N):
            frame[(j + 1) % N][j], frame[(j + 2) % N][j] = wobble * cosine, wobble * sine
            speed[(j + 1) % N][j], speed[(j + 2) % N][j] = -turn * wobble * sine, turn * wobble * cosine
        constant = self.constant()
        inner = self._solved(frame, deviation)
        result = []
        for i in range(N):
            total = deviation[i] * zero + self.drive * sine
            for j in range(N):
                weight = sum((frame[i][k] * exact(float(constant[k, j])) for k in range(N)), speed[i][j])
                total = total + weight * inner[j]
            result.append(total - exact(self.cubic) * (deviation[i] * deviation[i] * deviation[i]))
        result[0] = result[0] + exact(self.cross) * (deviation[2] * deviation[3])
        return result

    def _solved(self, frame, right):
        """Q x = right by elimination, in whatever arithmetic."""
        rows = [list(row) for row in frame]
        values = list(right)
        for i in range(N):
            pivot = 1 / rows[i][i]
            for k in range(i + 1, N):
                factor = rows[k][i] * pivot
                rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i], strict=True)]
                values[k] = values[k] - factor * values[i]
        for i in reversed(range(N)):
            for j in range(i + 1, N):
                values[i] = values[i] - rows[i][j] * values[j]
            values[i] = values[i] * (1 / rows[i][i])
        return values


def tube_of(known: Known, radius: float, **changes) -> Tube:
    fields = dict.fromkeys(("radii", "entry"), (radius,) * 4)
    grid = {"spans": 32, "order": 8, "fine": 10, "coarse": 3, "rough": 2} | changes
    return Tube(waves=known.waves(), blocks=BLOCKS, decay=known.decay, swing=SWING, odd=(False,) * 4, **(fields | grid))


def proved(known: Known, tube: Tube):
    with arithmetic():
        spans = spans_of(views_of(known), tube, straights_of(views_of(known), tube))
        return theorem_of(tube, [span.near for span in spans]), [span.near for span in spans]


def test_linear_system_with_known_flow() -> None:
    """The map of a turn is exp(B): the discs hold its eigenvalues, and the bound is that of the slowest block."""
    known = Known()
    theorem, _ = proved(known, tube_of(known, 1.0))
    assert theorem.existence
    assert theorem.stability
    assert not theorem.instability
    assert math.exp(-0.3) <= theorem.bound < math.exp(-0.3) + 1e-4
    for disc, a, b in zip(theorem.tube_multipliers, DECAY, SWING, strict=True):
        true = np.exp(a + 1j * b)
        assert abs(complex(disc.real, disc.imag) - true) <= disc.radius < 1e-4
    assert theorem.share < 1e-9


def test_repelling_system_is_proved_to_repel() -> None:
    known = Known(decay=(0.3, -0.8, -1.5, -6.0))
    theorem, _ = proved(known, tube_of(known, 1.0))
    assert theorem.existence
    assert theorem.instability
    assert not theorem.stability
    assert theorem.bound >= math.exp(0.3)


@pytest.mark.parametrize("decay", [0.0, 1e-9, -1e-9])
def test_what_neither_attracts_nor_repels_is_not_decided(decay: float) -> None:
    known = Known(decay=(decay, -0.8, -1.5, -6.0))
    theorem, _ = proved(known, tube_of(known, 1.0, spans=12, order=4))
    assert (theorem.existence, theorem.stability, theorem.instability) == (False,) * 3


@pytest.mark.parametrize(("radius", "attracts"), [(0.2, True), (0.4, True), (1.03, False), (2.0, False)])
def test_cubic_repulsion_limits_the_tube(radius: float, attracts: bool) -> None:
    """z' = a z + z^3 in each component draws together where a + 3 z^2 < 0: no tube beyond that may be accepted.

    Second derivatives alone make this fail, so that leaving them out is seen.
    """
    limit = math.sqrt(0.3 / 3.0)
    known = Known(wobble=0.0, cubic=-1.0)
    theorem, _ = proved(known, tube_of(known, radius * limit))
    assert theorem.stability is attracts


def test_periodic_drive_with_closed_form() -> None:
    """z' = a z + e sin(2 pi s) has the orbit e (-a sin - 2 pi cos) / (a^2 + 4 pi^2): it is where the share says."""
    known = Known(wobble=0.0, drive=1e-3)
    tube = tube_of(known, 0.05)
    theorem, _ = proved(known, tube)
    assert theorem.stability
    single = 1e-3 / math.hypot(0.8, 2.0 * math.pi)  # of the second block
    assert single <= theorem.share * 0.05
    assert theorem.share < 1.0
    # a drive that the tube cannot hold
    strong = Known(wobble=0.0, drive=0.05)
    assert not proved(strong, tube_of(strong, 0.05))[0].existence


@pytest.mark.parametrize(("spans", "fine"), [(1, 1), (2, 1), (3, 2), (16, 6)])
def test_push_bounds_the_drive_however_time_is_cut(spans: int, fine: int) -> None:
    """Few spans and one coefficient: the bound comes from Taylor's remainder, and without it is too small."""
    known = Known(wobble=0.0, drive=1e-3)
    with arithmetic():
        straights = straights_of(views_of(known), tube_of(known, 0.05, spans=spans, fine=fine))
    for k, straight in straights.items():
        greatest = 1e-3 * np.abs(np.sin(2.0 * np.pi * np.linspace(k / spans, (k + 1) / spans, 101))).max()
        for row in straight.push:  # the drive acts on every component alike
            assert float(row[0].abs_upper()) >= greatest * (1.0 - 1e-12)


def test_rates_bound_the_logarithmic_norm_at_random_points() -> None:
    """Of the linearisation at points of the tube, worked out in floats from the equation as it is written above."""
    known = Known(wobble=0.0, cubic=0.4)
    radius = 0.2
    tube = tube_of(known, radius)
    theorem, spans = proved(known, tube)
    rng = np.random.default_rng(0)
    for _ in range(200):
        z = rng.uniform(-1.0, 1.0, N) * radius / math.sqrt(2.0)
        jacobian = known.constant() - 3.0 * 0.4 * np.diag(z**2)
        for b, rows in enumerate(tube.columns):
            block = jacobian[np.ix_(rows, rows)]
            own = np.linalg.eigvalsh((block + block.T) / 2.0).max()
            from helimag.proof.theorem import rate_in

            with arithmetic():
                assert own <= float(rate_in(spans[0], b, [exact(radius)] * 4)) + 1e-15
    assert theorem.stability


def test_products_of_two_blocks_count_in_a_third() -> None:
    """Of z2 z3 in z0': the derivative by z2 changes along z3 by as much, and the other way round."""
    known = Known(wobble=0.0, cross=2.0)
    theorem, spans = proved(known, tube_of(known, 0.05))
    for span in spans:
        assert 2.0 <= float(span.bend[0][1][2]) < 2.0 + 1e-9
        assert 2.0 <= float(span.bend[0][2][1]) < 2.0 + 1e-9
        assert float(span.bend[1][0][2]) == 0.0
    assert theorem.stability
    assert not proved(known, tube_of(known, 0.2))[0].stability


def test_blocks_that_drive_each_other_repel() -> None:
    """Two decays of 0.3 and 0.8 coupled by 0.7 both ways have an eigenvalue above zero: other blocks count.

    Coupled by 0.2 they attract, in the norm of equal radii.
    """
    known = Known(wobble=0.0)
    tube = tube_of(known, 1.0)
    with arithmetic():
        spans = [span.near for span in spans_of(views_of(known), tube, straights_of(views_of(known), tube))]
        for coupling, attracts in ((0.2, True), (0.7, False)):
            mixed = [[exact(coupling) if {b, c} == {0, 1} else exact(0) for c in range(4)] for b in range(4)]
            assert theorem_of(tube, [replace(span, mixed=mixed) for span in spans]).stability is attracts


def test_entry_from_far_off_in_fast_blocks() -> None:
    """Linear: all comes in, however far, as long as the region is as wide."""
    known = Known()
    tube = replace(tube_of(known, 0.01), entry=(0.009, 0.009, 0.5, 0.5))
    with arithmetic():
        spans = [span.inward for span in spans_of(views_of(known), tube, straights_of(views_of(known), tube))]
        assert enters(tube, spans, tube.entry)
        assert not enters(tube, spans, (0.6, 0.6, 0.6, 0.6)), "beyond the region nothing was enclosed"
        assert not enters(tube, spans, (0.03, 0.009, 0.5, 0.5))
        # what drives a slow block out while a fast one is still far off
        driven = [replace(each, far=replace(each.far, push=[exact(0.1), *each.far.push[1:]])) for each in spans]
        assert not enters(tube, driven, tube.entry)
        assert enters(tube, driven, tube.outer), "what is in the outer box needs no bounds beyond it"


@pytest.mark.parametrize(("share", "comes_in"), [(0.8, True), (1.03, False)])
def test_what_does_not_draw_together_may_still_come_in(share: float, comes_in: bool) -> None:
    """z' = a z + z^3 in each component comes in from where a + z^2 < 0, and draws together where a + 3 z^2 < 0 only."""
    limit = math.sqrt(0.3)
    known = Known(wobble=0.0, cubic=-1.0)
    tube = replace(tube_of(known, share * limit / 2.0), entry=(0.99 * share * limit,) * 4)
    with arithmetic():
        spans = spans_of(views_of(known), tube, straights_of(views_of(known), tube))
        assert enters(tube, [span.inward for span in spans], tube.entry) is comes_in
        assert not comes_in or allows(tube, [span.near for span in spans], attracting=True)
        wide = replace(tube, radii=tube.outer, entry=tube.outer)
        assert not wide.reaches_out
        assert not allows(wide, [spans_of(views_of(known), wide, straights_of(views_of(known), wide, [0]))[0].near],
                          attracting=True)  # fmt: skip


def test_what_comes_nearer_must_do_so_down_to_the_tube() -> None:
    """With a decay of 0.3 a push of 0.02 is overcome at 0.1, and not at 0.05: all hangs between."""
    known = Known(wobble=0.0)
    tube = replace(tube_of(known, 0.05), entry=(0.1,) * 4)
    with arithmetic():
        (span,) = spans_of(views_of(known), tube, straights_of(views_of(known), tube, [3]))
        for push, comes_in in ((0.01, True), (0.02, False), (0.04, False)):
            pushed = replace(span.inward.outer, push=[exact(push), *span.inward.outer.push[1:]])
            assert shrinks(tube, [pushed]) is comes_in
            assert shrinks(tube, [span.inward.outer, pushed]) is comes_in
            entering = [replace(span.inward, outer=pushed)] * tube.spans
            assert enters(tube, entering, tube.entry) is comes_in


def test_a_missing_span_proves_nothing() -> None:
    known = Known()
    tube = tube_of(known, 1.0)
    theorem, spans = proved(known, tube)
    assert theorem.existence
    with arithmetic():
        less = theorem_of(tube, spans[:-1])
    assert (less.existence, less.stability, less.instability) == (False,) * 3


@pytest.mark.parametrize("rate", [-700.0, -31.7, -1.01, -0.99, 0.0, 1e-9, 2.5])
def test_time_in_a_span_is_bounded_from_above(rate: float) -> None:
    """The integral of exp(rate t), to 300 bits: no bound may be below it, and where motion decays it is tight."""
    for parts in (1, 3, 7):
        with arithmetic(300):
            a, step = exact(rate), exact(1) / parts
            true = ((a * step).exp() - 1) / a if rate else step
        with arithmetic():
            bound = _time_in(exact(rate), exact(1) / parts)
        with arithmetic(300):
            assert bound.upper() >= true
        assert rate * float(step) > -1.0 or float(bound) == pytest.approx(float(true), rel=1e-15)
