"""The spans of a turn enclosed one after another, far apart ones first, until one of them speaks against a tube."""

from helimag.proof.bounds import Report, Span, Straight, silent, spans_of, straights_of
from helimag.proof.field import Views
from helimag.proof.theorem import allows, enters, shrinks
from helimag.proof.tube import Tube

SAMPLE = 8  # every so many-th span comes first


def far_apart(spans: int) -> list[int]:
    """Numbers of all spans, every ``SAMPLE``-th first."""
    return [k for begin in range(SAMPLE) for k in range(begin, spans, SAMPLE)]


def spans_unless_against(
    views: Views,
    tube: Tube,
    known: dict[int, Straight],
    order: list[int],
    *,
    attracting: bool,
    progress: Report = silent,
) -> list[Span] | None:
    """All spans' bounds, None where one of them does not allow what is hoped for; nothing is proved by that.

    Within :func:`helimag.proof.balls.arithmetic`.

    Parameters
    ----------
    known
        What holds on the curve, by span: what is missing is enclosed and put in.
    order
        In which the spans are tried; the one that spoke against comes first afterwards, as it will again.
    attracting
        Whether attraction is hoped for, or existence alone.
    """
    found: dict[int, Span] = {}
    for n, k in enumerate(order):
        progress(n / len(order))
        span = _enclosed(views, tube, known, k)
        if span is None or not _speaks_for(tube, span, attracting):
            order.insert(0, order.pop(n))
            return None
        found[k] = span
        if attracting and (n + 1) % max(len(order) // SAMPLE, 1) == 0 and not _enters(tube, found):
            return None
    return [found[k] for k in sorted(found)]


def _enclosed(views: Views, tube: Tube, known: dict[int, Straight], k: int) -> Span | None:
    try:
        if k not in known:
            known |= straights_of(views, tube, [k])
        return spans_of(views, tube, {k: known[k]})[0]
    except (ZeroDivisionError, ValueError):  # too long, or too wide, for what is divided by in it
        return None


def _speaks_for(tube: Tube, span: Span, attracting: bool) -> bool:
    hoped = allows(tube, [span.near], attracting=attracting)
    return hoped and (not attracting or span.inward is None or shrinks(tube, [span.inward.outer]))


def _enters(tube: Tube, found: dict[int, Span]) -> bool:
    """Whether what starts beyond the tube comes in, as far as some spans tell, each of which stands for those between.

    True where nothing is to.
    """
    each = tube.spans // len(found)
    inward = [found[k].inward for k in sorted(found) for _ in range(each)]
    return not tube.reaches_out or enters(tube, [each for each in inward if each is not None], tube.entry)
