"""Verdicts of a grid of runs beside orbits, over inputs of any kind."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from helimag.orbits.beside_runs import OrbitComparison
from helimag.orbits.datasets.variables import PLACE, Content, Variable, dataset_of, flags, number, stability, terms
from helimag.outcomes import Verdict, Why
from helimag.scenario import Scenario

if TYPE_CHECKING:
    import xarray


class Along(NamedTuple):
    """Values of an input, SI or text, with its unit, along a dimension of a grid."""

    dimension: str
    unit: str
    values: Sequence[float | str]


def comparison_dataset(
    result: OrbitComparison, scenario: Scenario, inputs: Mapping[str, Along], dimensions: Sequence[str]
) -> "xarray.Dataset":
    """Verdicts of a grid of runs beside orbits.

    Parameters
    ----------
    scenario
        What the runs have in common.
    inputs
        By dotted path; text is numbered.
    dimensions
        Of the grid, in order. One that a single input runs along gets that input's name.

    Returns
    -------
    xarray.Dataset
        SI, over the grid.
    """
    paths = {dim: [path for path, given in inputs.items() if given.dimension == dim] for dim in dimensions}
    names = {dim: on[0].replace(".", "_") if len(on) == 1 else dim for dim, on in paths.items()}
    dims = tuple(names.values())
    named: dict[str, Variable] = {}
    for path, (along, unit, values) in inputs.items():
        dim = (names[along],)
        if any(isinstance(value, str) for value in values):
            words = list(dict.fromkeys(str(value) for value in values))
            variable = flags(dim, [words.index(str(value)) for value in values], words, path)
        else:
            variable = number(dim, values, unit, path)
        named[path.replace(".", "_")] = variable
    judged = [verdict for verdict in Verdict if verdict.judged]
    verdicts = np.array([Verdict.of(word).flag if word else 0 for word in result.verdicts.flat])
    codes = np.zeros(result.verdicts.shape, dtype=int)
    for case in result.cases:
        codes[case.node] = case.why.flag
    data = {
        "verdict": terms(dims, verdicts.reshape(result.verdicts.shape), judged, "run", zero="none"),
        "stability": stability(dims, result.growth, "whether an orbit is known, and a stable one"),
        "why": terms(
            dims, codes, Why, "why run and orbit differ, or the outlook of an undecided run", zero="nothing to explain"
        ),
        "growth": number(dims, result.growth, "1/s", "real part of the leading rate; stable where negative"),
        "position": number((*dims, "axis"), result.states[..., :3], "m", PLACE),
        "away": flags(dims, result.away.astype(int), ("no", "yes"), "whether no neighbour differs in stability"),
    }
    shares: dict[str, object] = {"agreement": result.share(), "agreement_beside_orbit": result.share(beside=True)}
    return dataset_of(data, named, scenario, Content.COMPARISON, shares)
