"""How far a measured run is from the truth beside a rendered film."""

from typing import NamedTuple

import numpy as np

from helimag.errors import InputError
from helimag.runs.trajectory import Trajectory


class Score(NamedTuple):
    """Errors of a measured run: m and rad."""

    position_rms: float
    position_worst: float
    attack_rms: float
    samples: int
    frames: int


def score(measured: Trajectory, truth: Trajectory) -> Score:
    """Compare sample by sample; ``truth`` is what rendering wrote beside the films, at the first film's frames.

    Returns
    -------
    Score
        Errors in m and rad.

    Raises
    ------
    InputError
        Where the measured samples are not at frames of the truth.
    """
    times = np.asarray(truth.dataset["time"].values)
    found = np.asarray(measured.dataset["time"].values)
    place = np.clip(np.searchsorted(times, found - 1e-3), 0, times.size - 1)
    if np.abs(times[place] - found).max() > 1e-3:
        raise InputError("the truth must be at the frames of the measured run; these two are not of the same film")
    off = measured.dataset["position"].values - truth.dataset["position"].values[place]
    distance = np.linalg.norm(off, axis=1)
    lean = measured.dataset["attack_angle"].values - truth.dataset["attack_angle"].values[place]
    return Score(
        float(np.sqrt(np.mean(distance**2))),
        float(distance.max()),
        float(np.sqrt(np.mean(lean**2))),
        int(found.size),
        int(times.size),
    )
