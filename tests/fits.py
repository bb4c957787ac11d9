"""Posteriors made by hand: what tests need of a calibration, without one."""

import numpy as np

from helimag import calibration as cal


def posterior(base, samples, *, factors=(), name="run"):
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
        plan=cal.CalibrationPlan.model_validate({"run": [run], "free": free}),
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
