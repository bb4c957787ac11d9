"""Which run to make next: the one whose outcome the posterior leaves most open, beside what can be measured."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.calibration.fit import Posterior
from helimag.calibration.numbers import NUMBERS
from helimag.calibration.plan import Candidate, ObservedNumber
from helimag.calibration.problem import base_of, changed
from helimag.engine import advance
from helimag.errors import InputError
from helimag.outcomes import End
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

DRAWS = 24
USUAL = {"output": 0.5e-3, "attack_angle": np.radians(1.0), "speed": 0.05e-3, "rise": 0.5e-3}  # sd where none is known
PITCH = np.radians(2.0)
FACTORS = {"drive.frequency": 1.25, "drive.distance": 1.08}


@dataclass(frozen=True)
class Worth:
    """What a run would tell.

    Attributes
    ----------
    name
        Of the candidate.
    spread
        Of each observable: its standard deviation over the posterior, SI.
    told
        Of each: ln(1 + spread^2 / sd^2) / 2, with the sd of a measurement; what a normal one tells (nats).
    """

    name: str
    spread: dict[str, float]
    told: dict[str, float]

    @property
    def most(self) -> str:
        """The observable that tells most."""
        return max(self.told, key=lambda what: self.told[what])

    @property
    def text(self) -> str:
        """In words."""
        what = self.most
        kind, number, unit = NUMBERS[what].kind, self.spread[what], ""
        if kind is not None:
            number, unit = number / q.parse(f"1 {kind.shown}", kind), f" {kind.shown}"
        spread = f"{number:.2g}{unit}"
        return f"{self.name}: {NUMBERS[what].words} still spreads by {spread} ({self.told[what]:.1f} nats)"


def worths(
    fit: Posterior,
    *,
    draws: int = DRAWS,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Worth]:
    """What each candidate would tell, the most telling first.

    The plan's own candidates; without any, its first run with pitch, frequency or distance somewhat changed. Each is
    run with the same samples of the posterior. An observable counts with the standard deviation that the plan measures
    it with, or a usual one. That is simple and honest, and no more: it takes one number at a time as normal.
    """
    random = np.random.default_rng(seed)
    values = fit.draws(draws, random)
    runs = {run.name: scenario for run, scenario in _candidates(fit)}
    batch = [changed(base, fit.plan.free, row, None) for base in runs.values() for row in values]
    histories = advance(batch, threads=threads, progress=progress)
    deviations = _deviations(fit)
    found = []
    for i, (name, base) in enumerate(runs.items()):
        own = [h for h in histories[i * draws : (i + 1) * draws] if h.status is not End.NOT_FINITE]
        if not own:
            raise InputError(f"no run of candidate '{name}' could be computed")
        spread = {
            what: float(np.std([NUMBERS[what].value(history, base.run.duration) for history in own]))
            for what in deviations
        }
        told = {what: float(0.5 * np.log1p((spread[what] / sd) ** 2)) for what, sd in deviations.items()}
        found.append(Worth(name, spread, told))
    return sorted(found, key=lambda worth: -worth.told[worth.most])


def _candidates(fit: Posterior) -> list[tuple[Candidate, Scenario]]:
    if fit.plan.candidate:
        return [(candidate, base_of(candidate)) for candidate in fit.plan.candidate]
    run = fit.plan.run[0]
    base = base_of(run)
    pitch = base.drive.pitch
    changes: dict[str, dict[str, float]] = {f"{run.name} again": {}} | {
        f"{run.name}, drive.pitch {np.degrees(pitch + step):.3g} deg": {"drive.pitch": pitch + step}
        for step in (-PITCH, PITCH)
    }
    for path, factor in FACTORS.items():
        field = path.partition(".")[2]
        for share in (1.0 / factor, factor):
            changes[f"{run.name}, {path} times {share:.3g}"] = {path: share * getattr(base.drive, field)}
    return [(Candidate(name=name, base=base), base.replaced(each) if each else base) for name, each in changes.items()]


def _deviations(fit: Posterior) -> dict[str, float]:
    """Standard deviation with which each observable is measured: the plan's smallest, or a usual one."""
    measured: dict[str, float] = {}
    for run in fit.plan.run:
        for each in run.observed:
            if isinstance(each, ObservedNumber):
                measured[each.what] = min(each.numbers[1], measured.get(each.what, np.inf))
    return USUAL | measured
