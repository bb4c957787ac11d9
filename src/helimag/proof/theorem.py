"""What follows from the bounds of a tube: an orbit in it, alone, attracting or not, and where its multipliers lie.

Let the radii be ``d_I``, and for a span ``m_IJ`` the bounds of D F over the tube by block: the logarithmic norm on the
diagonal, norms elsewhere. ``rate_I = m_II + sum over J of m_IJ d_J / d_I`` then bounds the logarithmic norm of D F in
the norm max |y_I| / d_I.

**Attraction.** If ``rate_I < 0`` and ``push_I + rate_I d_I < 0`` for all blocks and spans, then max |y_I| / d_I cannot
reach 1 from below, so nothing leaves the tube; two motions in it approach each other by ``exp(rate)`` a turn, rate the
greatest of all ``rate_I`` (G. Soederlind, BIT 46 (2006) 631). The map of one turn takes the tube's section into itself
and contracts: it has one fixed point there (Banach), an orbit to which all that starts in the tube tends. It lies where
max |y_I| / d_I <= ``share``, the greatest push_I / (-rate_I d_I) of all spans: further out that falls all the time, and
what comes back after a turn does not.

**Existence without attraction.** If ``push_I + change_I d_I < |a_I| d_I`` with bounds over the whole turn, a_I the
constant block's rate and change_I the row sum of norms of D F - B, then y -> the bounded solution of
y_I' = B_I y_I + (F - B y)_I contracts the closed curves in the tube: there is one orbit that stays in it (Banach again,
in the space of curves).

**Multipliers.** Y' = (B + E) Y gives Y(1) = exp(B) + D with row bounds ``change_I (e^r - e^a_I) / (r - a_I)``, r the
logarithmic norm; as exp(B) is block by block a turn and a scaling, every eigenvalue of Y(1) lies in one of the discs of
these radii around exp(a_I +- i b_I) (Gershgorin, by blocks: D. G. Feingold and R. S. Varga, Pacific J. Math. 12 (1962)
1241).

**Entry.** Further off the lengths R_I of the blocks obey R_I' <= n_II R_I + sum n_IJ R_J + push_I, n_IJ bounds of the
mean of D F on the straight way from the curve, which takes F on it to F where the motion is. So near the tube n differs
from what holds on the curve by half of what m does, or by a third in third order: motions come nearer to the orbit
where two of them need not come nearer to each other. If in all spans the right-hand side is negative for R_I = d_I and
for R_I = c d_I, it is for all multiples between, as in a multiple it is convex: max |y_I| / d_I falls from c to 1, and
all of the outer box comes into the tube. Fast blocks may begin still further off. The right-hand side grows with the
other blocks' lengths, so what solves the inequality from above stays above (M. Mueller, Math. Z. 26 (1927) 619), with
bounds over the region that it must not leave; it is in the outer box soon.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from helimag.proof.balls import exact, flint, largest, lower, size, upper
from helimag.proof.bounds import Inward, SpanBounds
from helimag.proof.tube import Tube

if TYPE_CHECKING:
    from flint import arb


MOST_TURNS, FIRST_TURNS = 2000, 2  # to come into the outer box; of which in steps of a span
NARROWINGS = 2  # of where the orbit lies: what holds nearer to the curve places it nearer
LEAST_SHARE = 2.0**-60  # of the tube: not to divide by nothing
TRIES = 6  # to find what lengths a span needs


@dataclass(frozen=True)
class Disc:
    """Where one of the multipliers lies, with its complex conjugate where ``imag`` is not zero; and of how many."""

    real: float
    imag: float
    radius: float


@dataclass(frozen=True)
class Theorem:
    """What is proved of a tube.

    Attributes
    ----------
    existence
        An orbit stays in the tube, and no other.
    stability
        It attracts all that starts in the tube, and none of that leaves it.
    instability
        It repels: a multiplier is outside the unit circle.
    bound
        Of the norm of the linearised map of a turn, everywhere in the tube: below one where stable.
    share
        Of the tube's radii, within which the orbit lies.
    multipliers, tube_multipliers
        Discs that hold the orbit's multipliers, and those of the linearised map along any motion in the tube.
    """

    existence: bool
    stability: bool
    instability: bool
    bound: float
    share: float
    multipliers: tuple[Disc, ...]
    tube_multipliers: tuple[Disc, ...]


def theorem_of(tube: Tube, spans: Sequence[SpanBounds]) -> Theorem:
    """What the bounds of all spans of a turn, in the tube, prove.

    Where an enclosure knows nothing its bounds are infinite, and nothing is proved.
    """
    radii = [exact(radius) for radius in tube.radii]
    blocks = range(len(radii))
    rate = [largest(rate_in(span, b, radii) for span in spans) for b in blocks]
    stability, held = _decided(tube, spans) if len(spans) == tube.spans else (False, False)
    existence = stability or held
    share = exact(1)
    for _ in range(NARROWINGS if existence else 0):
        inside = [share * radius for radius in radii]
        parts = [[span] for span in spans] if stability else [spans]
        share = largest(
            [exact(LEAST_SHARE), *(_share(tube, part, b, inside, stability) for part in parts for b in blocks)]
        )
    inner = _discs(tube, spans, [share * radius for radius in radii])
    return Theorem(
        existence=existence,
        stability=stability,
        instability=existence and any(_outside(disc) for disc in _apart(inner)),
        bound=upper(largest(rate).exp()),
        share=upper(share),
        multipliers=tuple(inner),
        tube_multipliers=tuple(_discs(tube, spans, radii)),
    )


def _decided(tube: Tube, spans: Sequence[SpanBounds]) -> tuple[bool, bool]:
    """Whether these spans allow attraction, and existence alone."""
    radii = [exact(radius) for radius in tube.radii]
    blocks = range(len(radii))
    rates = [[rate_in(span, b, radii) for b in blocks] for span in spans]
    push = [largest(span.push[b] for span in spans) for b in blocks]
    change = [largest(_change_in(span, b, radii) for span in spans) for b in blocks]
    stability = all(
        rate[b] < 0 and span.push[b] + rate[b] * radii[b] < 0
        for rate, span in zip(rates, spans, strict=True)
        for b in blocks
    )
    held = all(push[b] + change[b] * radii[b] < abs(exact(tube.decay[b])) * radii[b] for b in blocks)
    return stability, held


def allows(tube: Tube, spans: Sequence[SpanBounds], *, attracting: bool) -> bool:
    """Whether these spans, perhaps some of a turn, allow attraction, or existence alone: for a search."""
    return _decided(tube, spans)[0 if attracting else 1]


def _share(tube: Tube, spans: Sequence[SpanBounds], block: int, inside: "list[arb]", stable: bool) -> "arb":
    """Of the tube's radius, beyond which a block is not on an orbit that is known to lie within some radii."""
    push, radius = largest(span.push[block] for span in spans), exact(tube.radii[block])
    if stable:
        pull = -largest(rate_in(span, block, inside) for span in spans)
    else:
        pull = abs(exact(tube.decay[block])) - largest(_change_in(span, block, inside) for span in spans)
    return push / (pull * radius)


def rate_in(span: SpanBounds, block: int, radii: "Sequence[arb]") -> "arb":
    """Bound of the logarithmic norm's row of a block, over a tube of these radii."""
    total = _own_rate(span, block, radii)
    for other, radius in enumerate(radii):
        if other != block:
            total += _mixed(span, block, other, radii) * radius / radii[block]
    return total.upper()


def _own_rate(span: SpanBounds, block: int, radii: "Sequence[arb]") -> "arb":
    return span.rate[block] + sum((t * r for t, r in zip(span.twist[block], radii, strict=True)), exact(0))


def _mixed(span: SpanBounds, block: int, other: int, radii: "Sequence[arb]") -> "arb":
    bent = sum((b * r for b, r in zip(span.bend[block][other], radii, strict=True)), exact(0))
    return span.mixed[block][other] + bent


def _change_in(span: SpanBounds, block: int, radii: "Sequence[arb]") -> "arb":
    """Bound of the row sum of what the linearisation differs from the constant one, over a tube of these radii."""
    total = span.change[block]
    for other, radius in enumerate(radii):
        total += _mixed(span, block, other, radii) * radius / radii[block]
    return size(total)


def enters(tube: Tube, spans: Sequence[Inward], entry: Sequence[float]) -> bool:
    """Whether all that starts a turn within these radii comes into the tube, and on the way never leaves the region."""
    return shrinks(tube, [span.outer for span in spans]) and _settles(tube, [span.far for span in spans], entry)


def shrinks(tube: Tube, spans: Sequence[SpanBounds]) -> bool:
    """Whether all of the outer box comes into the tube, with bounds that hold in that box in these spans."""
    return all(
        rate_in(span, b, radii) * radii[b] + span.push[b] < 0
        for radii in ([exact(radius) for radius in box] for box in (tube.radii, tube.outer))
        for span in spans
        for b in range(len(radii))
    )


def _settles(tube: Tube, spans: Sequence[SpanBounds], entry: Sequence[float]) -> bool:
    """Whether all that starts a turn within these radii comes into the outer box, and never leaves the region.

    With bounds that hold in the whole region: span by span at first, while fast blocks decay; then turn by turn with
    what holds in all spans.
    """
    region = [exact(radius) for radius in tube.region]
    tight = [exact(radius) for radius in tube.outer]
    lengths: list[arb] | None = [exact(radius) for radius in entry]
    whole = _everywhere(spans)
    for turn in range(MOST_TURNS):
        for span in spans if turn < FIRST_TURNS else [whole]:
            if lengths is None:
                return False
            if all(length <= radius for length, radius in zip(lengths, tight, strict=True)):
                return True
            step = exact(1) if span is whole else exact(1) / tube.spans
            lengths = _carried(span, lengths, step, region)
    return False


def _everywhere(spans: Sequence[SpanBounds]) -> SpanBounds:
    """Bounds that hold in all spans."""
    blocks = range(len(spans[0].push))
    return replace(
        spans[0],
        push=[largest(span.push[b] for span in spans) for b in blocks],
        rate=[largest(span.rate[b] for span in spans) for b in blocks],
        mixed=[[largest(span.mixed[b][c] for span in spans) for c in blocks] for b in blocks],
        bend=[[[largest(span.bend[b][c][d] for span in spans) for d in blocks] for c in blocks] for b in blocks],
        twist=[[largest(span.twist[b][d] for span in spans) for d in blocks] for b in blocks],
    )


def _carried(span: SpanBounds, lengths: "list[arb]", step: "arb", region: "list[arb]") -> "list[arb] | None":
    """Bounds of the blocks' lengths at the end of a span, from those at its beginning; None where they are not held.

    As long as the lengths are below those assumed, they are below what follows from them; so if that is less than was
    assumed, the assumption holds to the end.
    """
    blocks = range(len(lengths))
    hull = [length * exact(1.001) + exact(1e-12) for length in lengths]
    for _ in range(TRIES):
        rate = [_own_rate(span, b, hull).upper() for b in blocks]
        rise = [
            span.push[b] + sum((_mixed(span, b, c, hull) * hull[c] for c in blocks if c != b), exact(0)) for b in blocks
        ]
        added = [rise[b] * _time_in(rate[b], step) for b in blocks]
        need = [size(largest([exact(1), (rate[b] * step).exp()]) * lengths[b] + added[b]) for b in blocks]
        # strictly inside: what was enclosed holds in the region only
        if not all(n < r for n, r in zip(need, region, strict=True)):
            return None
        if all(n < h for n, h in zip(need, hull, strict=True)):
            return [size((rate[b] * step).exp() * lengths[b] + added[b]) for b in blocks]
        hull = [largest([n * exact(1.001), h]) for n, h in zip(need, hull, strict=True)]
    return None


def _time_in(rate: "arb", step: "arb") -> "arb":
    """Bound of the integral of exp(rate t) over a step."""
    if rate * step < -1:
        return size(((rate * step).exp() - 1) / rate)
    return size(step * largest([exact(1), (rate * step).exp()]))


def _discs(tube: Tube, spans: Sequence[SpanBounds], radii: "Sequence[arb]") -> list[Disc]:
    """Discs for all linearisations along motions in a tube of these radii."""
    blocks = range(len(radii))
    rate = largest(rate_in(span, b, radii) for span in spans for b in blocks)
    discs = []
    for b in blocks:
        decay, swing = exact(tube.decay[b]), exact(tube.swing[b])
        radius = largest(_change_in(span, b, radii) for span in spans) * largest([rate, decay]).exp()
        if rate - decay > 1:
            radius = radius / (rate - decay)
        centre = decay.exp() * flint().arb(-1 if tube.odd[b] else 1)
        real, imag = centre * swing.cos(), centre * swing.sin()
        middle = float(real.mid()), float(imag.mid())
        off = size(real - exact(middle[0])) + size(imag - exact(middle[1]))
        discs.append(Disc(*middle, upper(radius + off)))
    return discs


def _apart(discs: Sequence[Disc]) -> list[Disc]:
    """The discs that touch no other and so hold exactly one multiplier, or a pair of conjugate ones."""
    kept = []
    for disc in discs:
        rest = [other for other in discs if other is not disc]
        mirrored = [Disc(other.real, -other.imag, other.radius) for other in rest]
        if all(_gap(disc, other) > 0.0 for other in rest + mirrored):
            kept.append(disc)
    return kept


def _gap(a: Disc, b: Disc) -> float:
    x, y = exact(a.real) - exact(b.real), exact(a.imag) - exact(b.imag)
    return lower((x * x + y * y).sqrt() - flint().arb(a.radius) - flint().arb(b.radius))


def _outside(disc: Disc) -> bool:
    """Whether a disc lies outside the unit circle as a whole."""
    x, y = exact(disc.real), exact(disc.imag)
    return lower((x * x + y * y).sqrt() - flint().arb(disc.radius)) > 1.0
