"""Calibrations of devices that are known, and the sampler beside nested sampling.

Run: python benchmarks/calibration.py [devices | six | samplers]. ``devices``: thirty random devices of three free
inputs are observed with errors; how often the 90 % region holds the truth (24 to 30 are due). ``six``: a posterior over
six inputs from three runs of Table I, with the processor's time. ``samplers``: likelihoods and errors on posteriors
that are known, beside ultranest where that is installed.
"""

import math
import sys
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import helimag as hm
from helimag import calibration as cal
from helimag.calibration import sampling
from helimag.engine import advance
from helimag.scenario import Scenario, varied

Floats = NDArray[np.float64]

SDS = {"rise": 1e-4, "attack_angle": math.radians(1.0), "speed": 3e-5}
DEVICES, LEVEL = 30, 0.9
FREE = [
    {"input": "fluid.viscosity", "prior": "normal", "mean": "1 Pa s", "sd": "0.1 Pa s", "low": "0.5 Pa s"},
    {"input": "device.weight.net_weight", "prior": "uniform", "low": "40 uN", "high": "60 uN"},
    {"input": "device.weight.gravity_center", "prior": "uniform", "low": "-1 mm", "high": "1 mm"},
]
MORE = [
    {"input": "magnet.moment", "prior": "normal", "mean": "18.89 A m^2", "sd": "0.6 A m^2"},
    {"input": "device.magnetic_moment", "prior": "normal", "mean": "0.623 mA m^2", "sd": "0.03 mA m^2"},
    {"input": "drive.start.z", "prior": "normal", "mean": "0 mm", "sd": "0.3 mm", "low": "-2 mm", "high": "2 mm"},
]


def base_of(row: int, duration: float) -> Scenario:
    """A row of Table I in open water, by resistive-force theory, which is quick."""
    changes = {
        "device.hydrodynamics.model": "lighthill",
        "workspace": {},
        "run.duration": duration,
        "run.interval": duration / 40.0,
        "provenance": {},
    }
    return hm.load(f"paper/table1-row{row}").replaced(changes)


def observed(scenario: Scenario, random: np.random.Generator) -> list[dict[str, object]]:
    """What a lab would measure of a run, each number with an error drawn from its sd."""
    (history,) = advance([scenario])
    numbers = {what: cal.NUMBERS[what].value(history, scenario.run.duration) for what in SDS}
    return [
        {"what": what, "value": numbers[what] + sd * random.standard_normal(), "sd": sd, "source": "drawn"}
        for what, sd in SDS.items()
    ]


def plan(
    bases: list[Scenario], free: list[dict[str, object]], values: Floats, random: np.random.Generator, **more: object
) -> cal.CalibrationPlan:
    """A plan whose data are drawn from the runs of a device with the free inputs at values."""
    changes = {str(each["input"]): value for each, value in zip(free, values.tolist(), strict=True)}
    runs = [
        {"name": f"run {i}", "base": base, "observed": observed(varied(base, changes), random)}
        for i, base in enumerate(bases, 1)
    ]
    return cal.CalibrationPlan.model_validate({"run": runs, "free": free} | more)


def drawn(bases: list[Scenario], free: list[dict[str, object]], random: np.random.Generator) -> Floats:
    """Values of a device, from the priors."""
    empty = [{"what": "stays", "source": "none"}]
    problem = cal.prepared(
        cal.CalibrationPlan.model_validate(
            {"run": [{"name": "any", "base": bases[0], "observed": empty}], "free": free}
        )
    )
    return problem.from_unit(random.random(len(free)))


def devices() -> None:
    """How often the region holds the truth."""
    random = np.random.default_rng(2026)
    bases = [base_of(1, 5.0), base_of(2, 5.0)]
    held, begun = 0, time.process_time()
    for seed in range(DEVICES):
        truth = drawn(bases, FREE, random)
        asked = plan(bases, FREE, truth, random, seed=seed, particles=100)
        (at_truth,), _ = cal.prepared(asked).evaluate(truth[None])
        fit = cal.calibrate(asked)
        inside = fit.likely(float(at_truth), level=LEVEL)
        held += inside
        print(f"device {seed}: {'in' if inside else 'out'}, {fit.evaluations} likelihoods", flush=True)
    took = time.process_time() - begun
    print(f"{held} of {DEVICES} regions of {LEVEL:.0%} hold the truth, {took:.0f} s of processor time")


def six() -> None:
    """A posterior over six inputs from rows 1 to 3."""
    random = np.random.default_rng(1)
    bases = [base_of(row, 20.0) for row in (1, 2, 3)]
    truth = drawn(bases, FREE + MORE, random)
    asked = plan(bases, FREE + MORE, truth, random)
    begun, clock = time.process_time(), time.perf_counter()
    fit = cal.calibrate(asked)
    took = time.process_time() - begun
    print(f"{fit.evaluations} likelihoods of three runs of 20 s, {took:.0f} s of processor time", end=", ")
    print(f"{time.perf_counter() - clock:.0f} s on the clock")
    (at_truth,), _ = cal.prepared(asked).evaluate(truth[None])
    print(f"the 90 % region {'holds' if fit.likely(float(at_truth)) else 'misses'} the truth")
    for sentence in cal.findings(fit).sentences:
        print(f"  {sentence}")


def targets() -> dict[str, tuple[Callable[[Floats], Floats], float]]:
    """Likelihoods in six dimensions, and the logarithm of their evidence (a number where it is known)."""
    turned, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(6, 6)))
    leaning = turned @ np.diag(np.geomspace(0.002, 0.08, 6) ** 2) @ turned.T
    inverse, norm = np.linalg.inv(leaning), -0.5 * np.linalg.slogdet(2.0 * np.pi * leaning)[1]

    def normal(x: Floats) -> Floats:
        return np.asarray(norm - 0.5 * np.einsum("ni,ij,nj->n", x - 0.5, inverse, x - 0.5))

    def modes(x: Floats) -> Floats:
        one, two = (-0.5 * (((x - at) / 0.03) ** 2).sum(axis=1) + np.log(at) for at in (0.25, 0.75))
        return np.asarray(np.logaddexp(one, two) - 6.0 * np.log(0.03 * np.sqrt(2.0 * np.pi)))

    def ridges(x: Floats) -> Floats:
        return -0.5 * ((x[:, 0] + x[:, 1] - 1.0) / 0.01) ** 2 - 0.5 * ((x[:, 2] - x[:, 3] ** 2) / 0.02) ** 2

    return {"leaning normal": (normal, 0.0), "two modes": (modes, 0.0), "two ridges": (ridges, math.nan)}


def samplers() -> None:
    """Likelihoods that each sampler takes, and what comes out."""
    for name, (likelihood, evidence) in targets().items():
        stands = []
        for seed in range(12):
            stand = sampling.begin(likelihood, 6, 256, seed)
            while not stand.done:
                stand = sampling.advanced(stand, likelihood)
            stands.append(stand)
        found = np.array([stand.evidence for stand in stands])
        share = np.array([(stand.points[:, 0] > 0.5).mean() for stand in stands])
        said = np.mean([math.sqrt(stand.variance) for stand in stands])
        print(
            f"{name}: {np.mean([stand.evaluations for stand in stands]):.0f} likelihoods, log evidence "
            f"{found.mean():.2f} +- {found.std():.2f} (known {evidence:.2f}, weights alone say +- {said:.2f}), "
            f"share beyond the middle {share.mean():.2f} +- {share.std():.2f}"
        )
    _nested()


def _nested() -> None:
    try:
        import ultranest
    except ImportError:
        print("ultranest is not installed")
        return
    for name, (likelihood, _) in targets().items():
        np.random.seed(1)
        sampler = ultranest.ReactiveNestedSampler([f"x{i}" for i in range(6)], likelihood, vectorized=True)
        found = sampler.run(min_num_live_points=400, viz_callback=False, show_status=False)
        print(f"ultranest, {name}: {found['ncall']} likelihoods, log evidence {found['logz']:.2f}")


if __name__ == "__main__":
    {"devices": devices, "six": six, "samplers": samplers}[sys.argv[1] if len(sys.argv) > 1 else "devices"]()
