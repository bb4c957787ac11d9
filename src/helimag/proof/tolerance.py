"""How far inputs may be off together, so that the same tube still holds an orbit that attracts: a box of inputs."""

from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np

from helimag.errors import InputError
from helimag.proof.balls import arithmetic
from helimag.proof.certificate import Certificate, claims_of
from helimag.proof.exact import Inputs, ball_of, parts, written
from helimag.proof.guess import linearized
from helimag.proof.motion import Swimming
from helimag.proof.proving import in_floats
from helimag.proof.tube import N, Tube
from helimag.proof.waves import Floats, Waves
from helimag.scenario import Scenario

PATHS = ("drive.frequency", "drive.pitch", "drive.distance", "device.weight.net_weight")
PARTS = (0.9, 0.6, 0.4, 0.25, 0.1, 0.01)  # of the widths that floats suggest
PROBE = 1e-6  # relative, of an input, for differences


def tolerated(certificate: Certificate, paths: Sequence[str] = PATHS) -> Certificate | None:
    """The certificate of a box of inputs: for all values in it at once, an orbit in the tube that attracts all of it.

    Parameters
    ----------
    certificate
        Of an orbit that is proved at the decimals.
    paths
        Inputs that may be off, each either way, independently.

    Returns
    -------
    Certificate
        With the half widths, in the unit of the scenario's file, as ``within``; None where no width was proved.

    Raises
    ------
    InputError
        Where the certificate is not of an orbit that attracts, or an input is not given in the scenario.
    """
    if not certificate.claims.proved:
        raise InputError("a tolerance needs a certificate of an orbit that is proved to attract")
    for widths in _suggested(certificate.scenario, certificate.tube, paths):
        claims = claims_of(certificate.scenario, widths, certificate.tube)
        if claims is not None and claims.proved:
            return Certificate(certificate.scenario, widths, certificate.tube, claims)
    return None


def _suggested(scenario: Scenario, tube: Tube, paths: Sequence[str]) -> Iterator[dict[str, str]]:
    """Half widths to try, wide ones first: each input may push the tube's blocks by an equal part of what they bear."""
    bear = np.abs(tube.decay) * np.array(tube.radii)
    still = _pushes(scenario, tube, {})
    whole = {}
    for path in paths:
        number, unit = parts(written(scenario, path))
        probe = Fraction(PROBE) * abs(number) or Fraction(PROBE)
        with arithmetic():
            changed = _pushes(scenario, tube, {path: float(ball_of(number + probe, unit))})
        slope = np.abs(changed - still) / float(probe)
        whole[path] = float((bear / np.maximum(slope, 1e-300)).min()) / len(paths)
    for part in PARTS:
        yield {path: f"{part * width:.2e}" for path, width in whole.items()}


def _pushes(scenario: Scenario, tube: Tube, changes: dict[str, float]) -> Floats:
    """Largest components by block of the rate on the curve, at changed inputs (SI), in floats."""
    moved = scenario.replaced(changes) if changes else scenario
    with arithmetic():
        dynamics = Swimming(in_floats(Inputs(moved).constants()))
    times = np.arange(64) / 64
    count = dynamics.components
    value, _, _ = linearized(dynamics, Waves(tube.waves.cos[:count], tube.waves.sin[:count]), times)
    frame = tube.waves.values(times)[count:].reshape(N, N, -1).transpose(2, 1, 0)
    pushed = np.linalg.solve(frame, value.T[:, :, None])[:, :, 0]
    return np.array([np.linalg.norm(pushed[:, list(rows)], axis=1).max() for rows in tube.columns])
