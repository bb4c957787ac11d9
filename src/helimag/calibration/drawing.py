"""Devices drawn from a posterior, for whatever runs a scenario with them: predictions, sweeps, designs."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.calibration.fit import Posterior
from helimag.calibration.plan import Free
from helimag.calibration.problem import base_of, changed
from helimag.ensembles import Devices, Noise
from helimag.errors import InputError
from helimag.scenario import Input, Scenario

Floats = NDArray[np.float64]


def drawn(fit: Posterior, scenario: Scenario, *, draws: int, noise: Noise | None = None, seed: int = 0) -> Devices:
    """Devices from a posterior for a scenario.

    Parameters
    ----------
    fit
        As :func:`calibrate` gives it. Its free inputs take the place of the scenario's own; a factor multiplies the
        scenario's own; an input that belongs to some runs of the plan only (their starts, say) is left as it is.
    scenario
        Whose own values factors multiply.
    draws
        How many.
    noise
        Errors of each run on top; none where left out.
    seed
        Of samples and errors: the same seed draws the same.

    Returns
    -------
    Devices
        Each of them a sample of the posterior.

    Raises
    ------
    InputError
        Where there is not one draw, or the scenario's device is not the fit's or cannot have its inputs.
    """
    if draws < 1:
        raise InputError(f"an ensemble must have at least one draw; got {draws}")
    check_device(fit, scenario)
    own = [i for i, free in enumerate(fit.plan.free) if free.runs is None]
    frees = [fit.plan.free[i] for i in own]
    scale = np.array([Input(free.input).value(scenario) if free.factor else 1.0 for free in frees])
    values = fit.draws(draws, np.random.default_rng(seed))[:, own] * scale
    return Devices(tuple(free.input for free in frees), fit.best[own] * scale, values, noise or Noise(), seed)


def check_device(fit: Posterior, scenario: Scenario) -> None:
    """See whether a scenario's device, but for what is free, is that of one of a fit's runs.

    Raises
    ------
    InputError
        Where it is another one, which the message says in what; or it cannot have the fit's inputs.
    """
    here = _device(scenario, fit.plan.free, fit.best)
    first = ""
    for run in fit.plan.run:
        there = _device(base_of(run), fit.plan.free, fit.best)
        differ = [key for key in sorted({*here, *there}) if here.get(key) != there.get(key)]
        if not differ:
            return
        ours, theirs = (each.get(differ[0], "not given") for each in (here, there))
        first = first or f"device.{differ[0]} is {theirs} in its run '{run.name}' and {ours} here"
    raise InputError(f"the calibration is of another device: {first}")


def _device(scenario: Scenario, frees: Sequence[Free], best: Floats) -> dict[str, Any]:
    """What a device is, flat, with the free inputs of all runs at their best."""
    return dict(_flat(changed(scenario, frees, best, None).device.model_dump(mode="json", exclude_none=True)))


def _flat(value: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    for key, item in value.items():
        if isinstance(item, Mapping):
            yield from _flat(item, f"{path}{key}.")
        else:
            yield f"{path}{key}", item
