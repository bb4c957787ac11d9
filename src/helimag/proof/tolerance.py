"""How far inputs may be off together, so that an orbit that attracts is still proved for each value: a box of inputs.

With the inputs the orbit moves: the tube's curve leans with them to first order, its coordinates to second order, and
what is left for the enclosures is of third order.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np

from helimag.errors import InputError
from helimag.orbits import Watch
from helimag.proof.balls import arithmetic
from helimag.proof.bending import COUNT, DIVISORS, bent_terms, bent_waves, moving, sampled
from helimag.proof.bounds import Report, silent
from helimag.proof.certificate import Certificate, claims_of, dynamics_of
from helimag.proof.exact import TOLERATED, Inputs, parts, written
from helimag.proof.extent import WIDER, length
from helimag.proof.guess import Guess, hill_matrix, linearized, waves_through
from helimag.proof.motion import Swimming, product
from helimag.proof.proving import in_floats
from helimag.proof.sampling import far_apart, spans_unless_against
from helimag.proof.tube import N, Tube
from helimag.proof.waves import Floats, Waves
from helimag.scenario import Scenario

PATHS = TOLERATED
SIZES = (1.0, 0.7, 0.5, 0.4, 0.32, 0.25, 0.2, 0.16, 0.1, 0.03)  # of the widths that floats suggest
MOST = 24  # harmonics of the leaning
TIMES = np.arange(4 * MOST + 1) / (4 * MOST + 1)
STEPS, BISECTIONS = 300, 40
FINER = 1.5  # parts of a span for third derivatives, which count for more where inputs may be off
GUESSED = 0.1  # of the time, about


def tolerated(
    certificate: Certificate, paths: Sequence[str] = PATHS, *, progress: Report = silent
) -> Certificate | None:
    """The certificate of a box of inputs: for each value in it, an orbit that attracts all of a tube of its own.

    Parameters
    ----------
    certificate
        Of an orbit that is proved at the decimals.
    paths
        Inputs that may be off, each either way, independently; of the drive, or weight and moment of the device.
    progress
        Told which part of the work is done, from 0 to 1; what it raises stops it.

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
    watch = Watch(progress)
    for widths, tube in _suggested(certificate.scenario, certificate.tube, paths):
        found = proved_within(certificate.scenario, widths, tube, watch.part(GUESSED, 1.0))
        if found is not None:
            return found
    return None


def proved_within(scenario: Scenario, widths: Mapping[str, str], tube: Tube, progress: Report) -> Certificate | None:
    """The certificate of a tube for a box of inputs; None where it does not hold, as a first span may tell."""
    with arithmetic():
        dynamics = dynamics_of(scenario, widths)
        order = far_apart(tube.spans)
        spans = spans_unless_against(dynamics, tube, {}, order, attracting=True, progress=progress)
    claims = None if spans is None else claims_of(scenario, widths, tube, spans)
    return Certificate(scenario, widths, tube, claims) if claims is not None and claims.proved else None


def _suggested(scenario: Scenario, tube: Tube, paths: Sequence[str]) -> Iterator[tuple[dict[str, str], Tube]]:
    """Half widths and leaning tubes to try, wide ones first."""
    best: tuple[float, Any] = (0.0, None)
    given = _leaning_to_first_order(scenario, tube, paths)
    for room, bent, signs in rooms(tube, given):
        found = room.widest()
        if found.product > best[0]:
            best = found.product, (found, bent, signs)
    if best[1] is None:
        return
    found, bent, signs = best[1]
    for part in SIZES:
        widths = {
            path: f"{part * share * unit:.2e}"
            for path, share, unit in zip(paths, found.shares, given.units, strict=True)
        }
        # by how much each input's variable now stands for more than it did in floats
        scale = np.array([1.0] * N + [float(w) / u for w, u in zip(widths.values(), given.units, strict=True)])
        rows = np.repeat(scale[N:], Swimming.components)[:, None]
        radii = tuple(float(f"{radius:.4g}") for radius in found.radii)
        yield (
            widths,
            replace(
                tube,
                lean=rounded(Waves(given.lean.cos * rows, given.lean.sin * rows)),
                bent=bent_waves(bent * (scale[:, None] * scale)[None, :, :, None], signs),
                radii=radii,
                entry=radii,
                rough=round(FINER * tube.rough),
            ),
        )


def rooms(tube: Tube, given: "Leaning") -> "Iterator[tuple[Room, Floats, list[bool]]]":
    """What limits widths and radii with second-order terms of each kind, these terms, and which columns change sign."""
    guess = Guess(tube.waves, tube.blocks, tube.decay, tube.swing, tube.odd)
    at = sampled(tube.waves, Swimming.components, given.lean)
    none = np.zeros((N, at.side, at.side, COUNT))
    straight = moving(given.dynamics, at, none, none)
    for divisor in DIVISORS:
        bent, bending, signs = bent_terms(guess, at, straight.second, divisor)
        yield Room.of(tube, moving(given.dynamics, at, bent, bending), len(given.units)), bent, signs


@dataclass(frozen=True)
class Leaning:
    """How the orbit moves with inputs: half widths in the file's units, lean over them, equations with jets in them."""

    units: tuple[float, ...]
    lean: Waves
    dynamics: Swimming


def _leaning_to_first_order(scenario: Scenario, tube: Tube, paths: Sequence[str]) -> Leaning:
    """Each input's half width such that it moves the orbit by as much as a slow block of the tube is wide."""
    frame = tube.waves.values(TIMES)[Swimming.components :].reshape(N, N, -1).transpose(2, 1, 0)
    per_unit = {path: _written_part(scenario, path) for path in paths}
    widths = {}
    for path, shift in _shifts(scenario, tube, per_unit).items():
        inside = np.linalg.solve(frame, shift.T[:, :, None])[:, :, 0]
        slowest = np.linalg.norm(inside[:, list(tube.columns[0])], axis=1).max()
        widths[path] = Fraction(tube.radii[0] / float(slowest)) * per_unit[path]
    return leaning_over(scenario, tube, widths)


def leaning_over(scenario: Scenario, tube: Tube, widths: Mapping[str, Fraction]) -> Leaning:
    """How the orbit on a tube's curve moves with inputs over half widths in the file's units."""
    curve = _curve(tube)
    leans = [_leaning(curve, TIMES, shift) for shift in _shifts(scenario, tube, widths).values()]
    lean = Waves(np.vstack([each.cos for each in leans]), np.vstack([each.sin for each in leans]))
    return Leaning(tuple(map(float, widths.values())), lean, _dynamics(scenario, widths))


def _shifts(scenario: Scenario, tube: Tube, widths: Mapping[str, Fraction]) -> dict[str, Floats]:
    """By input: by how much it moves the orbit (6, times) over a half width, to first order."""
    pushed = _pushes(_dynamics(scenario, widths), _curve(tube), TIMES)
    return {path: _shift(scenario, _curve(tube), TIMES, pushed[:, j]) for j, path in enumerate(widths)}


def _curve(tube: Tube) -> Waves:
    return Waves(*(each[: Swimming.components] for each in (tube.waves.cos, tube.waves.sin)))


def _written_part(scenario: Scenario, path: str) -> Fraction:
    """A thousandth of an input as it is written, to count changes in."""
    return (abs(parts(written(scenario, path))[0]) or Fraction(1)) / 1000


def _dynamics(scenario: Scenario, widths: Mapping[str, Fraction]) -> Swimming:
    """The equations in floats, with three derivatives by inputs' variables, each from -1 to 1 over a half width."""
    with arithmetic():
        return Swimming(in_floats(Inputs(scenario, widths, "middle", 3).constants()), plain=False)


def _pushes(dynamics: Swimming, curve: Waves, times: Floats) -> Floats:
    """Derivatives of the rates on a curve that stays where it is (6, inputs, times) by the inputs' variables."""
    clock = np.cos(2.0 * np.pi * times), np.sin(2.0 * np.pi * times)
    rates, zero = dynamics.still_rates(clock, curve.values(times), curve.slopes(times)), np.zeros_like(times)
    count = 1 + max(key for rate in rates for key in rate.g) - N
    return np.array([[rate.g.get(N + j, zero) + zero for j in range(count)] for rate in rates])


def _shift(scenario: Scenario, curve: Waves, times: Floats, pushed: Floats) -> Floats:
    """How the orbit moves (6, times) where its rates change by so much."""
    with arithmetic():
        dynamics = Swimming(in_floats(Inputs(scenario).constants()))
    _, first = linearized(dynamics, curve, times)
    right = np.fft.fft(pushed, axis=-1)[:, np.arange(-MOST, MOST + 1)] / len(times)
    solved = np.linalg.solve(hill_matrix(first, MOST), -right.T.reshape(-1)).reshape(2 * MOST + 1, N)
    return np.asarray((solved.T @ np.exp(2j * np.pi * np.outer(np.arange(-MOST, MOST + 1), times))).real)


def _leaning(curve: Waves, times: Floats, shift: Floats) -> Waves:
    """The change of the curve's components (7,) that deviations (6, times) are, to first order."""
    attitude = curve.values(times)[3:]
    turned = np.array(product(list(attitude), [np.zeros_like(times), *(shift[3:] / 2.0)]))
    odd = bool(np.any(curve.cos[3:, 1::2]) or np.any(curve.sin[3:, 1::2]))
    return waves_through(np.concatenate([shift[:3], turned]), [False] * 3 + [odd] * 4)


def rounded(waves: Waves) -> Waves:
    return Waves(np.round(waves.cos, 14) + 0.0, np.round(waves.sin, 14) + 0.0)


@dataclass(frozen=True)
class Found:
    """Parts of the inputs' half widths, and the radii of a tube that bears them."""

    shares: Floats
    radii: Floats

    @property
    def product(self) -> float:
        """Of the widths."""
        return float(np.prod(self.shares))


@dataclass(frozen=True)
class Room:
    """What limits widths and radii, in floats: norms of derivatives by block and input, in a tube's coordinates."""

    rate: Floats
    second: Floats
    third: Floats
    radii: Floats

    @classmethod
    def of(cls, tube: Tube, motion: Any, inputs: int) -> "Room":
        """Of the motion in a tube's coordinates and its inputs."""
        rows = [slice(a, b) for a, b in pairwise((*tube.blocks, N))]
        all_of = [*rows, *(slice(N + j, N + j + 1) for j in range(inputs))]
        second = [[[length(motion.second[i, j, k]) for k in all_of] for j in all_of] for i in rows]
        third = [[[[length(motion.third[i, j, k, n]) for n in all_of] for k in all_of] for j in all_of] for i in rows]
        return cls(np.abs(tube.decay), np.array(second), np.array(third), np.array(tube.radii))

    def scaled(self, shares: Floats, radii: Floats) -> float:
        """By what parts of the widths may be multiplied, at most, for a tube of these radii to bear them."""
        blocks = len(radii)
        radius, third = "ijk,j,k->i", "ijkl,j,k,l->i"
        # in powers of the multiple: rows of the linearised motion times radii, and what moves on the curve
        by = [
            np.einsum(radius, self.second[:, :blocks, :blocks], radii, radii)
            + WIDER * np.einsum(third, self.third[:, :blocks, :blocks, :blocks], radii, radii, radii) / 2.0,
            np.einsum(radius, self.second[:, :blocks, blocks:], radii, shares)
            + WIDER * np.einsum(third, self.third[:, :blocks, :blocks, blocks:], radii, radii, shares),
            WIDER * np.einsum(third, self.third[:, :blocks, blocks:, blocks:], radii, shares, shares) / 2.0
            + np.einsum(radius, self.second[:, blocks:, blocks:], shares, shares) / 2.0,
            WIDER * np.einsum(third, self.third[:, blocks:, blocks:, blocks:], shares, shares, shares) / 6.0,
        ]
        low, high = 0.0, 1e6
        for _ in range(BISECTIONS):
            middle = np.sqrt(max(low, 1e-6) * high)
            borne = by[0] + middle * (by[1] + middle * (by[2] + middle * by[3])) < self.rate * radii
            low, high = (middle, high) if borne.all() else (low, middle)
        return float(low)

    def widest(self) -> Found:
        """The widths of the greatest product, and the radii that go with them."""
        inputs, step = self.second.shape[-1] - len(self.radii), 2.0
        shares, radii = np.full(inputs, 0.1), 0.5 * self.radii
        shares = shares * self.scaled(shares, radii)
        for _ in range(STEPS):
            tried = []
            for n in range(inputs + len(radii)):
                for sign in (1, -1):
                    by = np.where(np.arange(inputs + len(radii)) == n, step**sign, 1.0)
                    one, two = shares * by[:inputs], radii * by[inputs:]
                    tried.append(Found(one * self.scaled(one, two), two))
            best = max(tried, key=lambda found: found.product)
            if best.product > 1.001 * float(np.prod(shares)):
                shares, radii = best.shares, best.radii
            elif step < 1.05:
                break
            else:
                step = float(np.sqrt(step))
        return Found(shares, radii)
