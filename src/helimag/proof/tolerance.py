"""How far inputs may be off together, so that an orbit that attracts is still proved for each value: a box of inputs.

With the inputs the orbit moves; the tube's curve leans with them, to first order, and what is left is of second order.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from helimag.errors import InputError
from helimag.proof.balls import arithmetic
from helimag.proof.certificate import Certificate, claims_of
from helimag.proof.exact import TOLERATED, Inputs, ball_of, parts, written
from helimag.proof.guess import FAST, hill_matrix, linearized, waves_through
from helimag.proof.motion import Swimming, product
from helimag.proof.proving import in_floats
from helimag.proof.tube import N, Tube
from helimag.proof.waves import Floats, Waves
from helimag.scenario import Scenario

PATHS = TOLERATED
PARTS = (2.0, 1.5, 1.0, 0.5, 0.2)  # of the widths by which the orbit moves as far as the tube is wide
NARROWER = 0.5  # than the certificate's, a tube that has to bear the inputs too
PROBE = Fraction(1, 10**5)  # relative, of an input, for differences
MOST = 24  # harmonics of the leaning


def tolerated(certificate: Certificate, paths: Sequence[str] = PATHS) -> Certificate | None:
    """The certificate of a box of inputs: for each value in it, an orbit that attracts all of a tube of its own.

    Parameters
    ----------
    certificate
        Of an orbit that is proved at the decimals.
    paths
        Inputs that may be off, each either way, independently; of the drive, or weight and moment of the device.

    Returns
    -------
    Certificate
        With the half widths, in the unit of the scenario's file, as ``within``; None where no width was proved.

    Raises
    ------
    InputError
        Where the certificate is not of an orbit that attracts, or an input is not one of these.
    """
    if not certificate.claims.proved:
        raise InputError("a tolerance needs a certificate of an orbit that is proved to attract")
    for path in paths:
        if path not in PATHS:
            raise InputError(f"the inputs of a tolerance must be of {', '.join(PATHS)}; got '{path}'")
    for widths, tube in _suggested(certificate.scenario, certificate.tube, paths):
        claims = claims_of(certificate.scenario, widths, tube)
        if claims is not None and claims.proved:
            return Certificate(certificate.scenario, widths, tube, claims)
    return None


def _suggested(scenario: Scenario, tube: Tube, paths: Sequence[str]) -> Iterator[tuple[dict[str, str], Tube]]:
    """Half widths and leaning tubes to try, wide ones first: each input moves the orbit by an equal part."""
    times = np.arange(4 * MOST + 1) / (4 * MOST + 1)
    count = Swimming.components
    curve = Waves(tube.waves.cos[:count], tube.waves.sin[:count])
    frame = tube.waves.values(times)[count:].reshape(N, N, -1).transpose(2, 1, 0)
    slow = np.abs(tube.decay) < FAST * np.abs(tube.decay).min()
    narrow = replace(
        tube,
        radii=tuple(NARROWER * radius for radius in tube.radii),
        entry=tuple(NARROWER * radius for radius in tube.entry),
    )
    moved, shares = [], []
    for path in paths:
        shift = _shift(scenario, curve, times, path)
        inside = np.linalg.solve(frame, shift.T[:, :, None])[:, :, 0]
        sizes = np.array([np.linalg.norm(inside[:, list(rows)], axis=1).max() for rows in tube.columns])
        moved.append(shift)
        shares.append(float((np.array(narrow.radii) / sizes)[slow].min()) / len(paths))
    for part in PARTS:
        widths = {path: f"{part * share:.2e}" for path, share in zip(paths, shares, strict=True)}
        leans = [
            _leaning(curve, times, float(width) * shift) for width, shift in zip(widths.values(), moved, strict=True)
        ]
        lean = Waves(np.vstack([each.cos for each in leans]), np.vstack([each.sin for each in leans]))
        yield widths, replace(narrow, lean=lean)


def _shift(scenario: Scenario, curve: Waves, times: Floats, path: str) -> Floats:
    """How the orbit moves (6, times) for a unit of an input, as the scenario's file counts it."""
    number, unit = parts(written(scenario, path))
    step = PROBE * abs(number) or PROBE
    ahead, behind = (_rates_at(scenario, curve, times, path, number + sign * step, unit) for sign in (1, -1))
    pushed = (ahead - behind) / float(2 * step)
    with arithmetic():
        dynamics = Swimming(in_floats(Inputs(scenario).constants()))
    _, first, _ = linearized(dynamics, curve, times)
    right = np.fft.fft(pushed, axis=-1)[:, np.arange(-MOST, MOST + 1)] / len(times)
    solved = np.linalg.solve(hill_matrix(first, MOST), -right.T.reshape(-1)).reshape(2 * MOST + 1, N)
    return np.asarray((solved.T @ np.exp(2j * np.pi * np.outer(np.arange(-MOST, MOST + 1), times))).real)


def _rates_at(scenario: Scenario, curve: Waves, times: Floats, path: str, number: Fraction, unit: str) -> Floats:
    with arithmetic():
        changed = scenario.replaced({path: float(ball_of(number, unit))})
        dynamics = Swimming(in_floats(Inputs(changed).constants()))
    return linearized(dynamics, curve, times)[0]


def _leaning(curve: Waves, times: Floats, shift: Floats) -> Waves:
    """The change of the curve's components (7,) that deviations (6, times) are, to first order."""
    attitude = curve.values(times)[3:]
    turned = np.array(product(list(attitude), [np.zeros_like(times), *(shift[3:] / 2.0)]))
    odd = bool(np.any(curve.cos[3:, 1::2]) or np.any(curve.sin[3:, 1::2]))
    waves = waves_through(np.concatenate([shift[:3], turned]), [False] * 3 + [odd] * 4)
    return Waves(np.round(waves.cos, 14) + 0.0, np.round(waves.sin, 14) + 0.0)
