"""Some spans of a turn tried before all are: a tube that one of them speaks against need not be enclosed as a whole."""

from collections.abc import Mapping

from helimag.proof.bounds import Straight, spans_of
from helimag.proof.field import Views
from helimag.proof.theorem import allows, enters
from helimag.proof.tube import Tube

SAMPLE = 8  # every so many-th span is tried


def speaks_against(views: Views, tube: Tube, straights: Mapping[int, Straight], attracting: bool) -> int | None:
    """The first of some spans, by number, that a tube fails at; None where none does. This proves nothing.

    Within :func:`helimag.proof.balls.arithmetic`.
    """
    far = []
    for k, straight in straights.items():
        try:
            (span,) = spans_of(views, tube, {k: straight})
        except (ZeroDivisionError, ValueError):  # too wide for what is divided by in it
            return k
        if not allows(tube, [span.near], attracting=attracting):
            return k
        far += [span.far] * SAMPLE
    inputs = tube.lean.count > 0  # where these have a tolerance, no ball of starts is claimed
    return None if inputs or not attracting or enters(tube, far, tube.entry) else next(iter(straights))
