"""Second-order terms of a tube's coordinates, guessed in floats: what swings within a turn is taken out of the motion.

In the frame's coordinates the motion is y' = B y + F_ab y_a y_b / 2 + ..., F_ab periodic in time. Terms K = Q k with

    k_ab' = F_ab + B k_ab - k_cb B_ca - k_ca B_cb - N_ab

leave N_ab of F_ab, which is chosen zero wherever the divisor is not small: harmonics within a turn go, and means where
no rate nearly equals the sum of two others (the first step to a normal form; J. Guckenheimer and P. Holmes, Nonlinear
Oscillations, Dynamical Systems, and Bifurcations of Vector Fields, sec. 3.3). Nothing here needs to be right.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.proof.field import Dynamics
from helimag.proof.guess import Guess
from helimag.proof.jets import Jet
from helimag.proof.tube import NONE, N, pairs
from helimag.proof.waves import Floats, Waves

Complexes = NDArray[np.complex128]

COUNT = 256  # times in two turns
BENT_DIGITS = 8  # decimals of second-order terms
NEGLIGIBLE = 1e-7  # of their coefficients
DIVISORS = (0.5, 0.02)  # below which a term is left, tried one after another
TOLERANCE_DIVISOR = 2e-3  # the same where one of the two is an input
TIMES = 2.0 * np.arange(COUNT) / COUNT


@dataclass(frozen=True)
class Moving:
    """Derivatives of the motion in a tube's coordinates, in floats at ``TIMES``: F_a, F_ab and F_abc, time last."""

    first: Floats
    second: Floats
    third: Floats


@dataclass(frozen=True)
class Sampled:
    """Curve, frame and how the curve leans with inputs, with their rates, at ``TIMES``."""

    curve: Floats
    slope: Floats
    frame: Floats
    turning: Floats
    lean: Floats
    leaning: Floats

    @property
    def side(self) -> int:
        """How many coordinates and inputs."""
        return N + len(self.lean)


def sampled(waves: Waves, components: int, lean: Waves = NONE) -> Sampled:
    """A tube's functions at ``TIMES``."""
    values, slopes = waves.values(TIMES), waves.slopes(TIMES)
    frame, turning = (each[components:].reshape(N, N, -1).transpose(1, 0, 2) for each in (values, slopes))
    leans = [each.reshape(-1, components, COUNT) for each in (lean.values(TIMES), lean.slopes(TIMES))]
    return Sampled(values[:components], slopes[:components], frame, turning, *leans)


def moving(dynamics: Dynamics, at: Sampled, bent: Floats, bending: Floats) -> Moving:
    """The derivatives on the curve, with second-order terms (6, side, side, times) and their rates."""
    side, alone = at.side, range(at.side)
    zero = np.zeros(COUNT)
    deviation = [
        Jet(zero, dict(enumerate(at.frame[i])), {(a, b): bent[i, a, b] for a, b in pairs(side)}, {}) for i in range(N)
    ]
    clock = np.cos(2.0 * np.pi * TIMES), np.sin(2.0 * np.pi * TIMES)
    rates = dynamics.rates(clock, _leaning(at.curve, at.lean), _leaning(at.slope, at.leaning), deviation)
    inverse = np.linalg.inv(at.frame.transpose(2, 0, 1)).transpose(1, 2, 0)
    first = np.array([[rate.g.get(a, zero) + zero for a in alone] for rate in rates])
    first[:, :N] -= at.turning
    linear = np.einsum("ilt,lat->iat", inverse, first)
    second = np.array([_full(rate.h, 2, side) for rate in rates]) - bending
    turned = np.einsum("icat,cbt->iabt", bent[:, :N], linear)
    second = np.einsum("ilt,labt->iabt", inverse, second - turned - turned.swapaxes(1, 2))
    third = np.array([_full(rate.t, 3, side) for rate in rates])
    turned = np.einsum("idat,dbct->iabct", bent[:, :N], second)
    third = third - turned - turned.transpose(0, 2, 1, 3, 4) - turned.transpose(0, 3, 2, 1, 4)
    return Moving(linear, second, np.einsum("ilt,labct->iabct", inverse, third))


def _leaning(values: Floats, lean: Floats) -> Sequence[Any]:
    if not len(lean):
        return list(values)
    return [Jet(value, {N + j: each[i] for j, each in enumerate(lean)}, {}, {}) for i, value in enumerate(values)]


def _full(derivatives: dict[Any, Any] | None, order: int, side: int) -> Floats:
    """Derivatives by pair or triple as a symmetric array."""
    zero = np.zeros(COUNT)
    result = np.empty((side,) * order + (COUNT,))
    for index in np.ndindex(*(side,) * order):
        result[index] = (derivatives or {}).get(tuple(sorted(index)), zero)
    return result


def bent_terms(guess: Guess, at: Sampled, second: Floats, divisor: float) -> tuple[Floats, Floats, list[bool]]:
    """Second-order terms (6, side, side, times) that take out F_ab, their rates, and which columns change sign."""
    side = at.side
    rates, real = _diagonal(guess, side)
    back = np.linalg.inv(real)
    inside = real[:N, :N]
    spectrum = np.fft.fft(np.einsum("im,mjkt,ja,kb->iabt", back[:N, :N], second, real, real), axis=-1)
    swing = 1j * np.pi * np.fft.fftfreq(COUNT, 1.0 / COUNT)
    divisors = (rates[None, :, None] + rates[None, None, :] - rates[:N, None, None])[..., None] + swing
    least = np.full((side, side), divisor)
    least[N:, :] = least[:, N:] = TOLERANCE_DIVISOR
    least[N:, N:] = 0.0  # the curve bends to where the orbit is
    left = np.abs(divisors) <= least[None, :, :, None]
    terms = np.where(left, 0.0, spectrum / np.where(left, 1.0, divisors))

    def placed(spectra: Complexes) -> Floats:
        return np.asarray(np.einsum("im,mjkt,ja,kb->iabt", inside, np.fft.ifft(spectra, axis=-1), back, back).real)

    inner, slope = placed(terms), placed(terms * swing)
    bent = np.einsum("ijt,jabt->iabt", at.frame, inner)
    bending = np.einsum("ijt,jabt->iabt", at.turning, inner) + np.einsum("ijt,jabt->iabt", at.frame, slope)
    return bent, bending, _signs(guess, side)


def _signs(guess: Guess, side: int) -> list[bool]:
    parts = list(pairwise((*guess.blocks, N)))
    return [any(odd and a <= c < b for odd, (a, b) in zip(guess.odd, parts, strict=True)) for c in range(side)]


def _diagonal(guess: Guess, side: int) -> tuple[Complexes, Complexes]:
    """Rates of all columns, and inputs that do not change; and the matrix that takes a block of two apart."""
    rates, matrix = np.zeros(side, dtype=complex), np.eye(side, dtype=complex)
    for (a, b), decay, swing in zip(pairwise((*guess.blocks, N)), guess.decay, guess.swing, strict=True):
        rates[a:b] = decay
        if b - a == 2:
            rates[a:b] += [1j * swing, -1j * swing]
            matrix[a:b, a:b] = np.array([[1.0, 1.0], [1j, -1j]]) / np.sqrt(2.0)
    return rates, matrix


def bent_waves(bent: Floats, signs: Sequence[bool]) -> Waves:
    """Second-order terms as functions of time, rounded, without what does not count."""
    side = bent.shape[1]
    spectrum = np.fft.fft(bent, axis=-1) / COUNT
    most = COUNT // 2 - 1
    cos, sin = np.zeros((N * len(pairs(side)), most + 1)), np.zeros((N * len(pairs(side)), most + 1))
    for n, (a, b) in enumerate(pairs(side)):
        each = spectrum[:, a, b]
        kept = np.arange(most + 1) % 2 == int(signs[a] != signs[b])
        cos[N * n : N * n + N] = np.where(kept, 2.0 * each[:, : most + 1].real, 0.0)
        sin[N * n : N * n + N] = np.where(kept, -2.0 * each[:, : most + 1].imag, 0.0)
        cos[N * n : N * n + N, 0] /= 2.0
    cos, sin = np.round(cos, BENT_DIGITS) + 0.0, np.round(sin, BENT_DIGITS) + 0.0
    needed = np.flatnonzero((np.abs(cos) > NEGLIGIBLE).any(axis=0) | (np.abs(sin) > NEGLIGIBLE).any(axis=0))
    last = int(needed[-1]) + 1 if needed.size else 1
    return Waves(cos[:, :last], sin[:, :last])
