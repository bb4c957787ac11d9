"""Outcome probabilities: copies of the present run with errors of the lab, and devices of a calibration where one is
loaded; the same draws as ``helimag simulate --ensemble`` and :func:`helimag.ensemble` make."""

from collections.abc import Callable, Mapping

import numpy as np

from helimag.calibration import Noise, Posterior, predict
from helimag.ensembles import Ensemble, Perturbation, ensemble
from helimag.errors import InputError
from helimag.scenario import Input, Normal, Scenario
from helimag.studio.knobs import BY_PATH
from helimag.studio.mapping import THREADS

RUNS = 64


def lab_errors(inputs: Mapping[str, float], displacement: float) -> Noise:
    """Errors from run to run, from numbers as the page shows them: each in its knob's unit, zero for none; mm.

    Raises
    ------
    InputError
        Where one is negative or no number.
    """
    for name, value in {**inputs, "the start": displacement}.items():
        if not 0.0 <= value < np.inf:
            label = BY_PATH[name].label if name in BY_PATH else name
            raise InputError(f"the error of {label} must be zero or more; got {value:g}")
    return Noise({path: value * BY_PATH[path].scale for path, value in inputs.items() if value}, 1e-3 * displacement)


def outcomes(scenario: Scenario, fit: Posterior | None, errors: Noise, progress: Callable[[float], None]) -> Ensemble:
    """Run copies, and judge them.

    Raises
    ------
    InputError
        Where nothing is uncertain, or the scenario cannot have what was drawn.
    RunError
        Where the numbers of a run broke down.
    """
    if fit is not None:
        return predict(scenario, fit, noise=errors, draws=RUNS, threads=THREADS, progress=progress).runs
    if not errors.inputs and not errors.displacement:
        raise InputError("nothing is uncertain: load a calibration, or give errors from run to run")
    priors = {path: Normal(Input(path).value(scenario), sd) for path, sd in errors.inputs.items()}
    perturbation = Perturbation(priors, errors.displacement)
    return ensemble(scenario, perturbation, runs=RUNS, threads=THREADS, progress=progress)
