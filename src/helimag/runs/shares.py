"""Shares of runs, and how well a count of them tells the share of all."""

import math

SURE = 1.96  # standard deviations on either side of 95 per cent


def wilson(share: float, total: int) -> tuple[float, float]:
    """Where the share of all runs lies, with 95 per cent, of which ``total`` drawn at random have ``share``.

    Wilson's interval (Wilson, J. Am. Stat. Assoc. 22, 209, 1927): unlike mean and deviation it is right near 0 and 1.
    """
    middle = (share + SURE**2 / (2.0 * total)) / (1.0 + SURE**2 / total)
    half = SURE * math.sqrt(share * (1.0 - share) / total + SURE**2 / (4.0 * total**2)) / (1.0 + SURE**2 / total)
    return max(min(middle - half, share), 0.0), min(max(middle + half, share), 1.0)


def in_percent(share: float) -> str:
    """A share as a number of per cent: whole ones, but never 0 or 100 for what is not quite none or all.

    Examples
    --------
    >>> in_percent(0.974), in_percent(199 / 200), in_percent(1.0)
    ('97', '99.5', '100')
    """
    texts = [f"{100.0 * share:.{digits}f}" for digits in range(7)]
    return next((text for text in texts if 0.0 < float(text) < 100.0), texts[0])
