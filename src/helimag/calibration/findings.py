"""What the data can tell and what not: widths beside the prior's, and pairs that trade off; in numbers and in words."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.calibration.fit import Posterior

Floats = NDArray[np.float64]

OPEN = 0.8  # share of the prior's width (5 to 95 %) from which on the data are said to tell nothing
TIED = 0.8  # rank correlation from which on two inputs are said to trade off
MISFIT = 3.0  # standard deviations that the best sample may be off


@dataclass(frozen=True)
class Findings:
    """What a posterior says of its free inputs.

    Attributes
    ----------
    widths
        (k,): width of the posterior (5 to 95 %) over the prior's.
    correlations
        (k, k): rank correlations.
    names
        Of the inputs.
    missed
        Observations that the best sample misses by more than ``MISFIT`` standard deviations, and by how many.
    """

    names: tuple[str, ...]
    widths: Floats
    correlations: Floats
    missed: tuple[tuple[str, float], ...]

    @property
    def open(self) -> tuple[str, ...]:
        """Inputs of which the data tell nothing that the prior did not."""
        return tuple(name for name, width in zip(self.names, self.widths, strict=True) if width > OPEN)

    @property
    def tied(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs that trade off, with their rank correlation: the data tell a combination of them only."""
        rows, columns = np.triu_indices(len(self.names), 1)
        return tuple(
            (self.names[i], self.names[j], float(self.correlations[i, j]))
            for i, j in zip(rows, columns, strict=True)
            if abs(self.correlations[i, j]) > TIED
        )

    @property
    def sentences(self) -> list[str]:
        """All of it in words."""
        said = [
            f"{name}: the data tell nothing beyond the prior ({width:.0%} of its width is left)"
            for name, width in zip(self.names, self.widths, strict=True)
            if width > OPEN
        ]
        for one, two, r in self.tied:
            way = "rise together" if r > 0.0 else "trade off against each other"
            said.append(f"{one} and {two} {way} (rank correlation {r:+.2f}): the data tell only a combination of them")
        said += [f"{label}: missed by {off:.1f} standard deviations even at best" for label, off in self.missed]
        return said or ["every free input is narrower than its prior, and no pair trades off"]

    def as_json(self) -> dict[str, object]:
        """As plain numbers and sentences.

        Returns
        -------
        dict
            Plain numbers by name of input, and sentences.
        """
        return {
            "width_share": dict(zip(self.names, self.widths.tolist(), strict=True)),
            "not_told": list(self.open),
            "tied_pairs": [{"inputs": [a, b], "rank_correlation": r} for a, b, r in self.tied],
            "missed": [{"observation": label, "standard_deviations": off} for label, off in self.missed],
            "sentences": self.sentences,
        }


def findings(fit: Posterior) -> Findings:
    """What a fit says of its inputs."""
    widths = (fit.quantiles[2] - fit.quantiles[0]) / (fit.prior[2] - fit.prior[0])
    off = np.abs(fit.off[fit.place])
    missed: dict[str, float] = {}
    for label, each in zip(fit.labels, off.tolist(), strict=True):
        if each > max(MISFIT, missed.get(label, 0.0)):
            missed[label] = each
    return Findings(fit.names, widths, rank_correlations(fit.samples), tuple(missed.items()))


def rank_correlations(samples: Floats) -> Floats:
    """Spearman's rank correlations (k, k) of samples (n, k)."""
    from scipy.stats import rankdata

    ranks = rankdata(samples, axis=0)
    if samples.shape[1] == 1:
        return np.ones((1, 1))
    return np.asarray(np.corrcoef(ranks, rowvar=False))
