"""A calibration's file without the half minute that a calibration takes: samples drawn, not found."""

import numpy as np

from helimag import calibration as cal

FREE = {"device.weight.net_weight": (51.6e-6, 1e-6), "fluid.viscosity": (1.0, 0.05)}


def fit_of(scenario, *, free=FREE, samples=20, name="a fit"):
    """A fit of one run of a scenario, with normal samples of the free inputs (mean and deviation, SI)."""
    run = {"name": "one", "base": scenario, "observed": [{"what": "gain", "value": 0.2, "sd": 0.1, "source": "made"}]}
    frees = [
        {"input": path, "prior": "normal", "mean": mean, "sd": sd, "low": 1e-9} for path, (mean, sd) in free.items()
    ]
    plan = cal.CalibrationPlan.model_validate({"name": name, "run": [run], "free": frees})
    means, deviations = np.array(list(free.values())).T
    drawn = means + deviations * np.random.default_rng(3).standard_normal((samples, len(free)))
    return cal.Posterior(
        plan=plan,
        names=tuple(free),
        units=("",) * len(free),
        samples=drawn,
        loglikelihood=-np.sum((drawn - means) ** 2 / deviations**2, axis=1),
        logprior=np.zeros(samples),
        prior=np.stack([means - deviations, means, means + deviations]),
        labels=("one gain",),
        data_units=("",),
        observed=np.array([0.2]),
        sd=np.array([0.1]),
        side=np.zeros(1),
        predicted=np.full((samples, 1), 0.2),
        evidence=0.0,
        evidence_sd=0.1,
        evaluations=1,
    )
