"""Copies of a scenario that differ as its inputs are uncertain: perturbed, or with devices that a calibration found."""

from helimag.ensembles.devices import Devices, Noise, noise_of
from helimag.ensembles.perturbed import RUNS, Copies, Ensemble, Perturbation, ensemble, ensembles, finished, tally

__all__ = [
    "RUNS",
    "Copies",
    "Devices",
    "Ensemble",
    "Noise",
    "Perturbation",
    "ensemble",
    "ensembles",
    "finished",
    "noise_of",
    "tally",
]
