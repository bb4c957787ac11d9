"""A guess of the curve, the frame and the radii, in floats. Nothing here needs to be right: the enclosures decide.

The curve is the orbit, sharpened by Newton's method on its harmonics; the frame's columns are Floquet's, from Hill's
method: eigenvectors of the linearised motion among periodic functions (G. W. Hill, Acta Math. 8 (1886) 1; B. Deconinck
and J. N. Kutz, J. Comput. Phys. 219 (2006) 296). No product over a turn is formed, so that fast decay does no harm.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from helimag.proof.field import Dynamics
from helimag.proof.jets import variables
from helimag.proof.motion import LENGTH, Swimming, product
from helimag.proof.tube import N
from helimag.proof.waves import Floats, Waves

Complexes = NDArray[np.complex128]
Displaced = Callable[[Floats, Floats], Floats]  # points of a curve (n, times) moved by deviations (6, times)

SHARP = 1e-9  # rate left on the curve, in lengths and radians a turn
NEGLIGIBLE = 1e-13  # of a coefficient
FRAME_DIGITS = 10  # decimals of the frame's coefficients, which need not be exact
HARMONICS = (28, 44, 64)  # of the curve, tried one after another
NEWTON_STEPS = 8


@dataclass(frozen=True)
class Guess:
    """A closed curve with its frame: waves for a :class:`helimag.proof.tube.Tube`, blocks and rates in a turn."""

    waves: Waves
    blocks: tuple[int, ...]
    decay: tuple[float, ...]
    swing: tuple[float, ...]
    odd: tuple[bool, ...]


def linearized(motion: Dynamics, waves: Waves, times: Floats) -> tuple[Floats, Floats]:
    """Rates (6, times) on a curve, and their derivatives (6, 6, times)."""
    clock = (np.cos(2.0 * np.pi * times), np.sin(2.0 * np.pi * times))
    deviation = variables([np.zeros_like(times)] * N, one=np.ones_like(times))
    rates = motion.rates(clock, list(waves.values(times)), list(waves.slopes(times)), deviation)
    zero = np.zeros_like(times)
    value = np.array([rate.v + zero for rate in rates])
    return value, np.array([[rate.g.get(j, zero) + zero for j in range(N)] for rate in rates])


def waves_through(values: Floats, odd: Sequence[bool]) -> Waves:
    """Waves through values (n, times) at even times of a turn; ``odd`` ones come back with the other sign."""
    count = values.shape[1]
    most = (count - 1) // 2
    cos, sin = np.zeros((len(values), 2 * most + 2)), np.zeros((len(values), 2 * most + 2))
    times = np.arange(count) / count
    for i, (row, changes) in enumerate(zip(values, odd, strict=True)):
        # times a half wave, an odd function repeats after a turn, and its harmonics are shifted by a half
        complex_row = row * np.exp(-1j * np.pi * times) if changes else row.astype(complex)
        spectrum = np.fft.fft(complex_row) / count
        for k in range(-most, most + 1):
            j = 2 * k + int(changes)
            if abs(j) < cos.shape[1]:
                cos[i, abs(j)] += spectrum[k].real
                sin[i, abs(j)] -= np.sign(j) * spectrum[k].imag
    return Waves(cos, sin)


def trimmed(curve: Waves, frame: Waves) -> Waves:
    """Curve and frame together, coefficients rounded to what counts, without harmonics that no function needs."""
    cos = np.vstack([np.round(curve.cos, 15), np.round(frame.cos, FRAME_DIGITS)]) + 0.0
    sin = np.vstack([np.round(curve.sin, 15), np.round(frame.sin, FRAME_DIGITS)]) + 0.0
    needed = np.flatnonzero((np.abs(cos) > NEGLIGIBLE).any(axis=0) | (np.abs(sin) > NEGLIGIBLE).any(axis=0))
    last = int(needed[-1]) + 1 if needed.size else 1
    return Waves(cos[:, :last], sin[:, :last])


def _fourier(values: Floats, most: int) -> Complexes:
    """Coefficients (..., 4 most + 1) of exp(2 pi i k s), k from -2 most to 2 most, of values (..., times)."""
    spectrum = np.fft.fft(values, axis=-1) / values.shape[-1]
    return np.asarray(spectrum[..., np.arange(-2 * most, 2 * most + 1)])


def hill_matrix(first: Floats, most: int) -> Complexes:
    """Hill's matrix of the linearised motion (6, 6, times) less d/ds, for harmonics from -most to most."""
    spectrum = _fourier(first, most)
    count = 2 * most + 1
    matrix = np.zeros((count, N, count, N), dtype=complex)
    for a in range(count):
        for b in range(count):
            matrix[a, :, b, :] = spectrum[:, :, a - b + 2 * most]
        matrix[a, np.arange(N), a, np.arange(N)] -= 2j * np.pi * (a - most)
    return matrix.reshape(count * N, count * N)


def sharpened(motion: Dynamics, values: Floats, odd: Sequence[bool], displaced: Displaced) -> tuple[Waves, float]:
    """The closed curve through values (n, times), corrected until it solves the equations; and what rate is left."""
    count = values.shape[1]
    most, times = (count - 1) // 4, np.arange(count) / count
    best, left = waves_through(values, odd), np.inf
    phases = np.exp(2j * np.pi * np.outer(np.arange(-most, most + 1), times))
    for _ in range(NEWTON_STEPS):
        waves = waves_through(values, odd).lowest(2 * most)
        value, first = linearized(motion, waves, times)
        if not np.isfinite(value).all() or np.abs(value).max() >= left:
            break
        best, left = waves, float(np.abs(value).max())
        right = np.fft.fft(value, axis=-1)[:, np.arange(-most, most + 1)] / count
        solved = np.linalg.solve(hill_matrix(first, most), -right.T.reshape(-1)).reshape(2 * most + 1, N)
        values = displaced(waves.values(times), np.asarray((solved.T @ phases).real))
    return best, left


def floquet_frame(first: Floats, most: int) -> tuple[Floats, list[bool], list[tuple[int, complex]]]:
    """Columns (6, 6, times) of a frame in which the linearised motion (6, 6, times) is nearly constant.

    Returns
    -------
    columns, odd, blocks
        The columns (component, column, time), which of them change sign in a turn, and (columns, rate) by block.
    """
    count = first.shape[-1]
    values, vectors = np.linalg.eig(hill_matrix(first, most))
    strip = [i for i in range(len(values)) if -np.pi + 1e-6 < values[i].imag <= np.pi + 1e-6 and values[i].imag > -1e-9]
    weight = np.abs(np.arange(-most, most + 1))[:, None]
    spread = [float((weight * np.abs(vectors[:, i].reshape(-1, N)) ** 2).sum()) for i in strip]
    times = np.arange(count) / count
    phases = np.exp(2j * np.pi * np.outer(np.arange(-most, most + 1), times))
    columns: list[Floats] = []
    odd: list[bool] = []
    blocks: list[tuple[int, complex]] = []
    for i in [strip[n] for n in np.argsort(spread, kind="stable")]:
        if len(columns) >= N:
            break
        rate = complex(values[i])
        mode = vectors[:, i].reshape(-1, N).T @ phases
        half = abs(rate.imag - np.pi) < 1e-7
        if half:
            mode = mode * np.exp(1j * np.pi * times)
        mode = mode * np.exp(-0.5j * np.angle((mode * mode).sum()))
        real = abs(rate.imag) < 1e-9 or half
        if not real and len(columns) > N - 2:
            continue
        parts = [mode.real] if real else [mode.real, mode.imag]
        length = np.sqrt(np.mean(np.abs(mode) ** 2))
        columns += [part / length for part in parts]
        odd += [half] * len(parts)
        blocks.append((len(parts), complex(rate.real, 0.0 if real else rate.imag)))
    return np.stack(columns, axis=1), odd, blocks


def guess_around(motion: Swimming, state: Floats) -> "Guess | str":
    """Curve and frame around an orbit that passes a state (7,) at the start of a turn; or why there is none."""
    for most in HARMONICS:
        count = 4 * most + 1
        values = _passage(motion, state, count)
        if not np.isfinite(values).all():
            return "the orbit could not be followed through a turn"
        flips = float(values[3:, 0] @ values[3:, -1]) < 0.0
        closed = values[:, :-1]
        odd = [False] * 3 + [flips] * 4
        waves, left = sharpened(motion, closed, odd, displaced)
        if left < SHARP:
            break
    else:
        return f"the orbit's harmonics do not settle (a rate of {left:.1g} is left)"
    times = np.arange(count) / count
    _, first = linearized(motion, waves, times)
    columns, changes, blocks = floquet_frame(first, 3 * most // 5)
    frame = waves_through(columns.transpose(1, 0, 2).reshape(N * N, -1), [c for c in changes for _ in range(N)])
    frame = frame.lowest(waves.cos.shape[1] - 1)
    sizes = [size for size, _ in blocks]
    begins = tuple(int(n) for n in np.cumsum([0, *sizes[:-1]]))
    return Guess(
        trimmed(waves, frame),
        begins,
        tuple(rate.real for _, rate in blocks),
        tuple(rate.imag for _, rate in blocks),
        tuple(changes[n] for n in begins),
    )


def _passage(motion: Swimming, state: Floats, count: int) -> Floats:
    """States (7, count + 1) at even times of a turn, from one (7,) in SI; by SciPy, for a start only."""
    from scipy.integrate import solve_ivp

    begin = np.concatenate([state[:3] / float(LENGTH), state[3:]])
    times = np.arange(count + 1) / count
    solved = solve_ivp(motion.plain_rates, (0.0, 1.0), begin, method="DOP853", t_eval=times, rtol=1e-8, atol=1e-9)
    return np.asarray(solved.y) if solved.success else np.full((len(begin), count + 1), np.nan)


def displaced(curve: Floats, by: Floats) -> Floats:
    """Points of a curve (7, times) moved by deviations (6, times), quaternions of unit length."""
    sigma = by[3:] / 4.0
    turned = np.array(product(list(curve[3:]), [1.0 - (sigma**2).sum(axis=0), *(2.0 * sigma)]))
    return np.concatenate([curve[:3] + by[:3], turned / np.linalg.norm(turned, axis=0)])
