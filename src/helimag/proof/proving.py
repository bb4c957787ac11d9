"""Prove an orbit: guess a tube around it in floats, and let the enclosures decide."""

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.notebook import summary
from helimag.orbits import Orbit, Watch
from helimag.proof.balls import arithmetic
from helimag.proof.bending import COUNT, DIVISORS, bent_terms, bent_waves, moving, sampled
from helimag.proof.bounds import Report, Span, Straight
from helimag.proof.certificate import Certificate, Claims, claims_of, dynamics_of, settled
from helimag.proof.exact import Inputs, parts, require_provable, written
from helimag.proof.extent import Extent, extent_of, norms_of
from helimag.proof.guess import Guess, guess_around
from helimag.proof.jets import Jet
from helimag.proof.motion import LENGTH, Constants, Source, Swimming
from helimag.proof.row import Row, decimal
from helimag.proof.sampling import far_apart, spans_unless_against
from helimag.proof.tube import NONE, OUTER, N, Tube
from helimag.proof.waves import Waves
from helimag.scenario import Scenario

GRIDS: tuple[dict[str, int], ...] = (
    {"spans": 96, "order": 10, "fine": 14, "coarse": 6, "rough": 4},
    {"spans": 192, "order": 12, "fine": 14, "coarse": 6, "rough": 3},
    {"spans": 384, "order": 12, "fine": 14, "coarse": 6, "rough": 2},
)  # how time is cut; finer where coarser does not decide
SAME_PLACE, SAME_ATTITUDE = 1e-6, 1e-3  # m and rad, between the orbit given and the curve that its proof is about
SIZES = (1.0, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.03, 0.01, 0.003)  # of the box that floats suggest
GUESSED = 0.1  # of the time of a proof, about
SHARE = 0.85  # of the starts that such a tube suggests


@dataclass(frozen=True, kw_only=True)
class Proof:
    """What was proved of an orbit, or why nothing was.

    Attributes
    ----------
    existence
        An orbit exists near the one found, and there is no other in the tube around it.
    stability
        It attracts every start in the tube, for all time.
    bound
        Of the norm of the linearised map of one turn of the magnet, over the whole tube, in suitable coordinates; below
        one where stable, nan where nothing is proved.
    box
        Half width of the box, about ``certificate``'s curve, that holds the orbit's head at the start of a turn, m.
    reason
        What is proved in a sentence, or why it is not.
    seconds
        Time that it took.
    certificate
        What a checker needs; None where not even existence is proved.
    """

    orbit: Orbit
    existence: bool = False
    stability: bool = False
    bound: float = math.nan
    box: float = math.nan
    reason: str
    seconds: float
    certificate: Certificate | None = None

    @property
    def proved(self) -> bool:
        """Whether an orbit is proved to exist, to attract and to keep clear of everything."""
        return self.certificate is not None and self.certificate.claims.proved

    def __repr__(self) -> str:
        return f"<Proof of {self.orbit.scenario.title}: {self.reason}>"

    def _repr_html_(self) -> str:
        """For notebooks: what is proved."""
        told = {
            "proved": self.reason,
            "box of the orbit": f"{1e9 * self.box:.3g} nm" if math.isfinite(self.box) else "none",
            "bound": f"{self.bound:.6g}" if math.isfinite(self.bound) else "none",
            "certificate": "none" if self.certificate is None else self.certificate.hash[:12],
        }
        return summary(f"proof of the orbit of {self.orbit.scenario.title}", told)


def prove(orbit: Orbit, *, progress: Report | None = None) -> Proof:
    """Prove that an orbit exists, alone, and attracts: a theorem about the model at the scenario's decimals.

    Parameters
    ----------
    orbit
        As :func:`helimag.find_orbit` gives it.
    progress
        Told which part of the work is done, from 0 to 1; what it raises stops it.

    Returns
    -------
    Proof
        With a certificate that :func:`helimag.proof.check` proves again; or with the reason why there is none.

    Raises
    ------
    InputError
        Where the scenario is one of which nothing can be proved: a cylinder's field, drag that depends on the place.
    MissingExtra
        Where python-flint is not installed.
    """
    begun, watch = time.perf_counter(), Watch(progress)

    def ended(reason: str, certificate: Certificate | None = None) -> Proof:
        seconds = time.perf_counter() - begun
        if certificate is None:
            return Proof(orbit=orbit, reason=reason, seconds=seconds)
        claims = certificate.claims
        return Proof(
            orbit=orbit,
            existence=claims.existence,
            stability=claims.stability,
            bound=claims.bound,
            box=max(claims.box),
            reason=reason,
            seconds=seconds,
            certificate=certificate,
        )

    require_provable(orbit.scenario)
    scenario = settled(orbit.scenario)
    with arithmetic():
        constants = Inputs(scenario).constants()
    if not orbit.found:
        return ended(f"no orbit was found to prove anything of ({orbit.status})")
    floats = Swimming(in_floats(constants))
    guess = guess_around(floats, orbit.state)
    if isinstance(guess, str):
        return ended(f"not proved: {guess}")
    if not _same(guess, orbit):
        return ended("not proved: what is given is no orbit, as Newton's method leads from it to another one")
    best: Claims | None = None
    for tubes in tubes_to_try(*bent_guess(guess, floats), attracting=orbit.stable):
        for tube, spans in _promising(scenario, tubes, orbit.stable, watch.part(GUESSED, 1.0)):
            claims = claims_of(scenario, {}, tube, spans)
            if claims is not None and (claims.stability or not orbit.stable):
                return ended(sentence(claims), Certificate(scenario, {}, tube, claims))
            best = best or claims
    return ended(_why_not(guess, best))


def _same(guess: Guess, orbit: Orbit) -> bool:
    """Whether a curve is the orbit that it was guessed from: Newton's method may have gone to another one."""
    state = guess.waves.values(np.zeros(1))[:7, 0]
    away = np.linalg.norm(state[:3] * float(LENGTH) - orbit.position)
    turned = 2.0 * min(float(np.linalg.norm(state[3:] - sign * orbit.state[3:])) for sign in (1.0, -1.0))
    return bool(away <= SAME_PLACE + 10.0 * orbit.position_error and turned <= SAME_ATTITUDE)


def bent_guess(guess: Guess, dynamics: Swimming) -> tuple[Guess, Extent, Waves]:
    """A guess with second-order terms of the coordinates: those that allow the widest tube."""
    at = sampled(guess.waves, dynamics.components)
    none = np.zeros((N, N, N, COUNT))
    straight = moving(dynamics, at, none, none)
    best, terms = extent_of(norms_of(guess, at, straight)), NONE
    for divisor in DIVISORS:
        bent, bending, signs = bent_terms(guess, at, straight.second, divisor)
        extent = extent_of(norms_of(guess, at, moving(dynamics, at, bent, bending)))
        if extent.ball > best.ball:
            best, terms = extent, bent_waves(bent, signs)
    return guess, best, terms


def _promising(
    scenario: Scenario, tubes: Sequence[Tube], attracting: bool, watch: Watch
) -> Iterator[tuple[Tube, list[Span]]]:
    """Those of several tubes around one curve that all spans speak for, with the spans' bounds."""
    with arithmetic():
        dynamics = dynamics_of(scenario, {})
    known: dict[int, Straight] = {}
    order = far_apart(tubes[0].spans)
    for tube in tubes:
        with arithmetic():
            spans = spans_unless_against(dynamics, tube, known, order, attracting=attracting, progress=watch)
        if spans is not None:
            yield tube, spans


def in_floats(constants: Constants) -> Constants:
    """The same constants as floats, for the search."""
    values = {name: _float(value) for name, value in vars(constants).items() if name not in {"sources", "spin_sign"}}
    sources = tuple(Source(**{name: _float(value) for name, value in vars(s).items()}) for s in constants.sources)
    return replace(constants, sources=sources, **values)


def _float(value: Any) -> Any:
    if isinstance(value, Jet):
        return Jet(
            float(value.v), *({key: float(each) for key, each in (of or {}).items()} for of in value.derivatives)
        )
    return [_float(each) for each in value] if isinstance(value, (list, tuple)) else float(value)


def tubes_to_try(guess: Guess, extent: Extent, bent: Waves, *, attracting: bool) -> Iterator[list[Tube]]:
    """Tubes to try for each grid of time, wide ones first; those of an orbit that does not attract reach no further."""
    radii, entry = extent.radii / OUTER, SHARE * extent.entry
    for grid in GRIDS:
        yield [
            Tube(
                waves=guess.waves,
                bent=bent,
                blocks=guess.blocks,
                radii=_rounded(part * radii),
                entry=_rounded(part * (entry if attracting else radii)),
                decay=guess.decay,
                swing=guess.swing,
                odd=guess.odd,
                spans=grid["spans"],
                order=grid["order"],
                fine=grid["fine"],
                coarse=grid["coarse"],
                rough=grid["rough"],
            )
            for part in SIZES
        ]


def _rounded(radii: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(float(f"{radius:.4g}") for radius in radii)


def sentence(claims: Claims, inputs: str = "") -> str:
    """What is proved, in words; numbers are rounded to the side on which the sentence still holds.

    ``inputs`` names those that may be off, and by how much.
    """
    near = _length(math.hypot(*claims.box), ROUND_CEILING)
    place = f"an orbit exists within {near} of the curve given as a turn begins, alone in a tube around it"
    if inputs:
        place = f"with {inputs}, all at once and whatever their values, {place}"
    if not claims.stability:
        fate = "it is unstable" if claims.instability else "whether it attracts is not proved"
        return f"{place}; {fate}"
    turned = f"{_digits(Decimal(math.degrees(claims.basin_turned)), 2, ROUND_FLOOR)} deg"
    start = f"{_length(claims.basin, ROUND_FLOOR)} and {turned}"
    stays = f"every start within {start} of that curve as a turn begins stays near and tends to the orbit for ever"
    if inputs:
        stays = "every start in that tube tends to the orbit for ever"
    clear = f"at least {_length(claims.clearance, ROUND_FLOOR)} from all around it"
    if not claims.clearance > 0.0:
        clear = "that it keeps clear of what is around it is not proved"
    shrinks = f"in the tube a turn multiplies distances, in its own norm, by at most {_below_one(claims.bound)}"
    return f"{place}; {stays}; {shrinks}; {clear}"


def row_sentence(row: Row) -> str:
    """What is proved of a row of boxes, in words."""
    first = row.cells[0]
    units = {path: parts(written(first.scenario, path))[1] for path in first.within}
    box = ", ".join(
        f"{path} from {decimal(low)} to {decimal(high)} {units[path]}" for path, (low, high) in row.box.items()
    )
    return (
        f"with {box}, all at once and whatever their values, an orbit exists that attracts all of a tube around it, in "
        f"{len(row.cells)} cells along {row.along}; in each of these tubes a turn multiplies distances, in its own "
        f"norm, by at most {_below_one(row.bound)}; at least {_length(row.clearance, ROUND_FLOOR)} from all around them"
    )


def named_inputs(certificate: Certificate) -> str:
    """The inputs of a certificate that may be off, with what they may be off by either way."""
    units = {path: parts(written(certificate.scenario, path))[1] for path in certificate.within}
    return ", ".join(f"{path} off by up to {width} {units[path]}" for path, width in certificate.within.items())


def _below_one(bound: float) -> str:
    """A bound rounded up, so that it is never said smaller than it is."""
    return f"{Decimal(bound).quantize(Decimal('1e-6'), ROUND_CEILING)}" if bound < 0.999999 else repr(bound)


def _length(length: float, rounding: str) -> str:
    digits, name = next(((n, unit) for n, unit in ((3, "mm"), (6, "um")) if abs(length) >= 10.0**-n), (9, "nm"))
    return f"{_digits(Decimal(length).scaleb(digits), 3, rounding)} {name}"


def _digits(number: Decimal, digits: int, rounding: str) -> str:
    """A number to so many digits, rounded up or down."""
    if not number:
        return "0"
    return f"{number.quantize(Decimal(1).scaleb(number.adjusted() + 1 - digits), rounding):f}"


def _why_not(guess: Guess, claims: Claims | None) -> str:
    """Why the enclosures do not decide: what the slowest motion is, and what it would have to stand against."""
    slowest = min(guess.decay, key=abs)
    fold = "near a fold, where an orbit ends, " if guess.swing[guess.decay.index(slowest)] == 0.0 else ""
    if claims is not None:
        return f"not proved: an orbit exists, but in no tube tried does every motion approach it ({slowest:.2g} a turn)"
    return (
        f"not proved: {fold}the slowest motion changes by {abs(slowest):.2g} of itself a turn, and in no tube tried is "
        "the change of the linearised motion smaller than that"
    )
