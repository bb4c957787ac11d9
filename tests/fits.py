"""Posteriors made by hand: what tests need of a calibration, without one."""

import numpy as np

from helimag import calibration as cal

FREE = {"device.weight.net_weight": (51.6e-6, 1e-6), "fluid.viscosity": (1.0, 0.05)}


def fit_of(scenario, *, free=FREE, samples=20, title="a fit"):
    """A fit of one run of a scenario, with normal samples of the free inputs (mean and deviation, SI)."""
    means, deviations = np.array(list(free.values())).T
    drawn = means + deviations * np.random.default_rng(3).standard_normal((samples, len(free)))
    drawn[0] = means
    return posterior(scenario, dict(zip(free, drawn.T, strict=True)), title=title)


def posterior(base, samples, *, factors=(), name="run", title="calibration"):
    """A fit of free inputs (by path) to samples (n,) of each, SI; the first sample is the likeliest."""
    free = [
        {"input": path, "prior": "uniform", "low": min(values), "high": max(values) + 1.0, "factor": path in factors}
        if path in factors
        else {
            "input": path,
            "prior": "normal",
            "mean": f"{values[0]} {unit(base, path)}",
            "sd": f"1 {unit(base, path)}",
        }
        for path, values in samples.items()
    ]
    run = {"name": name, "base": base, "observed": [{"what": "stays", "source": "made by hand"}]}
    table = np.array(list(samples.values())).T
    count = len(table)
    return cal.Posterior(
        plan=cal.CalibrationPlan.model_validate({"name": title, "run": [run], "free": free}),
        names=tuple(samples),
        units=tuple("1" for _ in samples),
        samples=table,
        loglikelihood=-np.arange(float(count)),
        logprior=np.zeros(count),
        prior=np.quantile(table, [0.05, 0.5, 0.95], axis=0),
        labels=(f"{name}: stays",),
        data_units=("ln s",),
        observed=np.zeros(1),
        sd=np.ones(1),
        side=np.ones(1),
        predicted=np.zeros((count, 1)),
        evidence=0.0,
        evidence_sd=0.1,
        evaluations=count,
    )


def unit(base, path):
    from helimag.scenario import Input

    kind = Input(path).kind(base)
    return "" if kind is None else kind.si
