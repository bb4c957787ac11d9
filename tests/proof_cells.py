"""Certificates of cells that nobody proved, for what is decided of a row without enclosing anything."""

from dataclasses import replace

import numpy as np

import oracles
from helimag.proof import Certificate, Claims, Disc
from helimag.proof.motion import Swimming
from helimag.proof.tube import N, Tube, pairs
from helimag.proof.waves import Waves

SCENARIO = oracles.scenario_of(oracles.case()).replaced({"drive.frequency": "2.5 Hz", "drive.pitch": "12.7 deg"})
WITHIN = {"drive.frequency": "5.0e-04", "drive.pitch": "4.0e-03"}


def tube(inputs: int) -> Tube:
    """A curve that stands still, the frame of its axes, and neither leaning nor bending with inputs."""
    cos = np.zeros((Swimming.components + N * N, 1))
    cos[3] = 1.0
    for j in range(N):
        cos[Swimming.components + N * j + j] = 1.0
    lean = np.zeros((Swimming.components * inputs, 1))
    bent = np.full((N * len(pairs(N + inputs)), 1), 1e-3)
    radii = (1e-5,) * 4
    return Tube(
        Waves(cos, 0 * cos), (0, 2, 3, 4), radii, radii, (-1.0,) * 4, (0.5, 0.0, 0.0, 2.0), (False,) * 4, 1, 2, 3, 4, 5,
        lean=Waves(lean, 0 * lean), bent=Waves(bent, 0 * bent),
    )  # fmt: skip


CLAIMS = Claims(
    existence=True, stability=True, instability=False, bound=0.9999, box=(1e-6, 2e-6, 3e-6), turned=1e-4,
    tube=(1e-4, 2e-4, 3e-4), basin=0.0, basin_turned=0.0, clearance=0.14, multipliers=(Disc(0.9, 0.1, 1e-3),),
    tube_multipliers=(Disc(0.8, 0.1, 1e-2),),
)  # fmt: skip


def cell(pitch: str, within: dict[str, str] = WITHIN, **claims: object) -> Certificate:
    """A cell around a pitch (deg)."""
    about = SCENARIO.replaced({"drive.pitch": f"{pitch} deg"})
    return Certificate(about, within, tube(len(within)), replace(CLAIMS, **claims))
