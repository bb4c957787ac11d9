"""What follows from the bounds of a tube: an orbit in it, alone, attracting or not, and where its multipliers lie.

Let the radii be ``d_I``, and let over every span of a turn ``push_I`` bound the length of block I of g, and ``rate_I``
the logarithmic norm, as :mod:`helimag.proof.tube` says.

**Attraction.** If ``rate_I < 0`` and ``push_I + rate_I d_I < 0`` for all blocks and spans, then max |y_I| / d_I cannot
reach 1 from below, so nothing leaves the tube; two motions in it approach each other by ``exp(rate)`` a turn, rate the
greatest of all ``rate_I`` (G. Soederlind, BIT 46 (2006) 631). The map of one turn takes the tube's section into itself
and contracts: it has one fixed point there (Banach), an orbit to which all that starts in the tube tends. It lies
where max |y_I| / d_I <= ``share``, the greatest push_I / (-rate_I d_I).

**Existence without attraction.** If ``push_I + change_I d_I < |a_I| d_I`` with bounds over the whole turn, a_I the
constant block's rate, then y -> the bounded solution of y_I' = B_I y_I + (F - B y)_I contracts the closed curves in
the tube: there is one orbit that stays in it (Banach again, in the space of curves).

**Multipliers.** Y' = (B + E) Y gives Y(1) = exp(B) + D with row bounds ``change_I (e^r - e^a_I) / (r - a_I)``, r the
logarithmic norm; as exp(B) is block by block a turn and a scaling, every eigenvalue of Y(1) lies in one of the discs
of these radii around exp(a_I +- i b_I) (Gershgorin, by blocks: D. G. Feingold and R. S. Varga, Pacific J. Math. 12
(1962) 1241).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from helimag.proof.balls import exact, flint, largest, lower, size, upper
from helimag.proof.tube import Span, Tube

if TYPE_CHECKING:
    from flint import arb


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


def theorem_of(tube: Tube, spans: Sequence[Span]) -> Theorem:
    """What the bounds of all spans of a turn prove.

    Where an enclosure knows nothing its bounds are infinite, and nothing is proved.
    """
    radii = [exact(radius) for radius in tube.radii]
    blocks = range(len(radii))
    rate = [largest(span.rate[b] for span in spans) for b in blocks]
    push = [largest(span.push[b] for span in spans) for b in blocks]
    complete = len(spans) == tube.spans
    stability = complete and all(rate[b] < 0 and push[b] + rate[b] * radii[b] < 0 for b in blocks)
    change = [largest(span.change[b] for span in spans) for b in blocks]
    apart = [abs(exact(a)) for a in tube.decay]
    held = complete and all(push[b] + change[b] * radii[b] < apart[b] * radii[b] for b in blocks)
    share = largest(_share(tube, push[b], rate[b], change[b], b, stability) for b in blocks)
    existence = stability or held
    spot = size(share) if existence else exact(1)
    inner = _discs(tube, spans, spot)
    return Theorem(
        existence=existence,
        stability=stability,
        instability=existence and any(_outside(disc) for disc in _apart(inner)),
        bound=upper(largest(rate).exp()),
        share=upper(share) if existence else 1.0,
        multipliers=tuple(inner),
        tube_multipliers=tuple(_discs(tube, spans, exact(1))),
    )


def _share(tube: Tube, push: "arb", rate: "arb", change: "arb", block: int, stable: bool) -> "arb":
    """Of the radii, beyond which a block cannot be on the orbit."""
    radius = exact(tube.radii[block])
    return push / ((-rate if stable else abs(exact(tube.decay[block])) - change) * radius)


def _discs(tube: Tube, spans: Sequence[Span], share: "arb") -> list[Disc]:
    """Discs for all linearisations within a share of the tube: norms are convex, between curve and whole tube."""
    blocks = range(len(tube.radii))

    def between(still: "arb", moved: "arb") -> "arb":
        return (still + share * (moved - still)).upper()

    rate = largest(between(span.still_rate[b], span.rate[b]) for span in spans for b in blocks)
    discs = []
    for b in blocks:
        change = largest(between(span.still_change[b], span.change[b]) for span in spans)
        decay, swing = exact(tube.decay[b]), exact(tube.swing[b])
        growth = largest([rate, decay]).exp()
        radius = change * growth
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
    return lower((x * x + y * y).sqrt() - exact(a.radius) - exact(b.radius))


def _outside(disc: Disc) -> bool:
    """Whether a disc lies outside the unit circle as a whole."""
    x, y = exact(disc.real), exact(disc.imag)
    return lower((x * x + y * y).sqrt() - exact(disc.radius)) > 1.0
