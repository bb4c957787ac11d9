"""Verdicts of half-hour runs against orbits, over a grid of frequency and pitch; every disagreement explained.

    python benchmarks/orbit_against_sweep.py [NODES]

A sweep starts every run at the same place, which for some inputs lies outside the basin of their stable orbit. So two
comparisons are made: runs from the scenario's own start, whose every difference is explained by taking the run to
20,000 s; and, where there is a stable orbit, runs that start 5 mm beside it. Nodes beside the stability boundary are
counted apart. Exits with status 1 where fewer than 95 % of the second kind agree away from the boundary, or where a
difference finds no explanation.
"""

import sys
import time

import numpy as np

import helimag as hm
from helimag.gain import Verdict
from helimag.orbits import stability_map
from helimag.simulation import advance

LONG = 20_000.0  # s
BESIDE = 0.005  # m
INSIDE = (Verdict.BOUNDED, Verdict.DRIFTING)


def beside_boundary(stable: np.ndarray) -> np.ndarray:
    """Nodes with a neighbour (of eight) of the other kind."""
    padded = np.pad(stable, 1, mode="edge")
    n, m = stable.shape
    views = [padded[1 + i : 1 + i + n, 1 + j : 1 + j + m] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return np.any([view != stable for view in views], axis=0)


def explanation(stable: bool, short: Verdict, later: Verdict) -> str | None:
    """Why a run of 1800 s and the orbit disagree, from how the long run ended."""
    if stable and short not in INSIDE and later in INSIDE:
        return "judged too soon: it sank far but came back"
    if stable and later not in INSIDE:
        return "starts outside the basin of the stable orbit"
    if stable and short is Verdict.DRIFTING:
        return "slow drift: the orbit is stable, the run had not settled"
    if not stable and later not in INSIDE:
        return "horizon too short: it leaves later"
    if not stable:
        return "other attractor: it stays, on no orbit that was found"
    return None


def main() -> int:
    nodes = int(sys.argv[1]) if len(sys.argv) > 1 else 14
    base = hm.load("paper/fig3c").replaced({"drive.frequency": "2.5 Hz"})
    pitches, frequencies = np.radians(np.linspace(6.0, 18.0, nodes)), np.linspace(1.8, 3.8, nodes)
    begun = time.perf_counter()
    result = stability_map(base, ("drive.pitch", pitches), ("drive.frequency", frequencies))
    mapped = time.perf_counter() - begun
    where = [(i, j) for i in range(nodes) for j in range(nodes)]
    scenarios = [result.scenario_at(i, j) for i, j in where]
    verdicts = [history.judge().verdict for history in advance(scenarios)]
    ran = time.perf_counter() - begun - mapped
    stable = np.array([result.stable[node] for node in where])
    bounded = np.array([verdict is Verdict.BOUNDED for verdict in verdicts])
    away = np.array([not beside_boundary(result.stable)[node] for node in where])
    differs = stable != bounded
    differ = np.flatnonzero(differs)
    long_runs = advance([scenarios[k].replaced({"run.duration": LONG}) for k in differ]) if differ.size else []
    unexplained = 0
    explained_by: dict[str, int] = {}
    for k, history in zip(differ, long_runs, strict=True):
        later = history.judge().verdict
        reason = explanation(bool(stable[k]), verdicts[k], later)
        unexplained += reason is None
        explained_by[str(reason)] = explained_by.get(str(reason), 0) + 1
        i, j = where[k]
        print(
            f"{frequencies[j]:.2f} Hz {np.degrees(pitches[i]):5.2f} deg{'' if away[k] else ' (beside the boundary)'}: "
            f"run {verdicts[k]}, orbit {'stable' if stable[k] else 'not stable'}; after {LONG:.0f} s {later}: "
            f"{reason or 'NO EXPLANATION'}"
        )
    starts = [result.states[where[k]] + BESIDE * np.eye(7)[0] for k in np.flatnonzero(stable)]
    beside = advance([scenarios[k] for k in np.flatnonzero(stable)], initial_states=np.array(starts))
    stays = ~stable
    stays[stable] = [history.judge().verdict in INSIDE for history in beside]
    agree = np.where(stable, stays, ~bounded)
    share = float(agree[away].mean())
    print(
        f"{nodes**2} nodes, {away.sum()} away from the boundary. From the start {100 * (~differs)[away].mean():.1f} "
        f"% agree there, {100 * (~differs).mean():.1f} % of all; the rest: {explained_by}. From beside the orbit "
        f"where it is stable: {100 * share:.1f} % agree there, {100 * agree.mean():.1f} % of all; "
        f"map {mapped:.0f} s, runs {ran:.0f} s"
    )
    return 1 if share < 0.95 or unexplained else 0


if __name__ == "__main__":
    sys.exit(main())
