"""Which device is it? A known one is observed with errors in two runs, found again, and a third run is predicted."""

import numpy as np

import helimag as hm
from helimag import calibration as cal

base = hm.load("paper/table1-row1").replaced(
    {"device.hydrodynamics.model": "lighthill", "workspace": {}, "run.duration": "8 s", "run.interval": "0.2 s"}
)
second = base.replaced({"drive.pitch": "-9.6 deg", "drive.velocity": ["1.2 mm/s", "0 mm/s", "0 mm/s"]})
truth = {"fluid.viscosity": 1.08, "device.weight.net_weight": 53e-6}  # Pa s, N; what nobody knows

# what a lab measures: each number with its own error
errors = np.random.default_rng(7)
measured = {"rise": 1e-4, "attack_angle": np.radians(0.5)}  # standard deviations: m, rad


def observed(scenario: hm.Scenario) -> list[dict[str, object]]:
    run = hm.simulate(scenario.replaced(truth)).dataset
    numbers = {
        "rise": float(run["position"][-1, 2] - run["position"][0, 2]),
        "attack_angle": float(run["attack_mean"][run["time"] >= 4.0].mean()),
    }
    return [
        {"what": what, "value": numbers[what] + sd * errors.standard_normal(), "sd": sd, "source": "two cameras"}
        for what, sd in measured.items()
    ]


plan = cal.CalibrationPlan.model_validate(
    {
        "name": "a known device",
        "particles": 64,
        "run": [
            {"name": "one", "base": base, "observed": observed(base)},
            {"name": "two", "base": second, "observed": observed(second)},
        ],
        "free": [
            {"input": "fluid.viscosity", "prior": "normal", "mean": "1 Pa s", "sd": "0.1 Pa s", "low": "0.5 Pa s"},
            {"input": "device.weight.net_weight", "prior": "uniform", "low": "40 uN", "high": "60 uN"},
        ],
    }
)
fit = cal.calibrate(plan, output="fit.nc")
for name, low, middle, high in zip(fit.names, *fit.quantiles, strict=True):
    print(f"{name}: {middle:.4g} (90 % from {low:.4g} to {high:.4g}), true {truth[name]:.4g}")
for sentence in cal.findings(fit).sentences:
    print(sentence)
print(f"next: {cal.worths(fit, draws=8)[0].text}")

# another run of the same device: what will it do, with errors of pitch and of the place where it is released?
third = base.replaced({"drive.distance": "106 mm", "run.duration": "20 s"})
noise = cal.Noise({"drive.pitch": np.radians(0.1)}, displacement=2e-5)
predicted = cal.predict(third, cal.Posterior.load("fit.nc"), noise=noise, draws=40)
print(predicted.text)

# the weight is known far better than before, and both values lie where they should: within four deviations
assert np.all(np.abs(fit.samples.mean(axis=0) - list(truth.values())) < 4.0 * fit.samples.std(axis=0))
assert cal.findings(fit).widths[1] < 0.5
# what the true device then does lies within the bands
end = float(hm.simulate(third.replaced(truth)).dataset["position"][-1, 2])
low, _, high = predicted.heights[:, -1]
assert low - (high - low) < end < high + (high - low), (low, end, high)
