"""A basin by the averaged model held against full runs from some of its starts."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.orbits.averaged.attraction import Basin, ends_of_runs
from helimag.orbits.strobe import Watch
from helimag.outcomes import BasinEnd
from helimag.runs.shares import in_percent, wilson


@dataclass(frozen=True)
class Agreement:
    """A basin by the averaged model beside full runs from some of its starts.

    Attributes
    ----------
    starts
        (m,): numbers of the starts that were run.
    averaged, full
        (m,): how each ended by either model.
    """

    starts: NDArray[np.int64]
    averaged: NDArray[np.str_]
    full: NDArray[np.str_]

    @property
    def counts(self) -> dict[str, int]:
        """Starts that both models say come to the orbit, only one of them says so, or neither."""
        averaged, full = self.averaged == BasinEnd.CAPTURED, self.full == BasinEnd.CAPTURED
        masks = {
            "both": averaged & full,
            "only_averaged": averaged & ~full,
            "only_full": full & ~averaged,
            "neither": ~averaged & ~full,
        }
        return {name: int(mask.sum()) for name, mask in masks.items()}

    @property
    def share(self) -> float:
        """Of these starts on which the models agree."""
        return (self.counts["both"] + self.counts["neither"]) / self.starts.size

    @property
    def interval(self) -> tuple[float, float]:
        """Where the share of all starts lies, with 95 per cent."""
        return wilson(self.share, self.starts.size)

    @property
    def text(self) -> str:
        """The comparison in a sentence."""
        low, high = map(in_percent, self.interval)
        counts = self.counts
        return (
            f"of {self.starts.size} starts that full runs judged too, the models agree on {in_percent(self.share)} % "
            f"(of all starts: {low} to {high} %, with 95 % confidence): {counts['both']} captured by both, "
            f"{counts['only_averaged']} by the averaged model only, {counts['only_full']} by full runs only, "
            f"{counts['neither']} by neither"
        )


def agreement(
    caught: Basin, *, starts: int = 60, seed: int = 0, progress: Callable[[float], None] | None = None
) -> Agreement:
    """Judge some starts of a basin by full runs too.

    Parameters
    ----------
    caught
        A basin by the averaged model.
    starts
        How many, drawn without order from all of them.
    seed
        Of the draw.
    progress
        Called with the fraction done.

    Returns
    -------
    Agreement
        How each of the starts ended by either model.

    Raises
    ------
    InputError
        Where the basin is one by full runs, or there is no start to compare.
    """
    if caught.engine != "averaged" or starts < 1:
        raise InputError("only a basin by the averaged model, and at least one start of it, can be held against runs")
    every = caught.ends.size
    drawn = np.sort(np.random.default_rng(seed).choice(every, size=min(starts, every), replace=False))
    watch = Watch(progress)
    full = ends_of_runs(caught.orbit, caught.places[drawn], caught.duration, watch)
    watch(1.0)
    return Agreement(drawn, caught.ends[drawn], full)
