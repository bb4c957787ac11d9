"""A proof on file: the decimals of the scenario, the tube, and what is claimed of it; and the check of all three.

The check takes nothing on trust: it reads the scenario's decimals, encloses the bounds of the tube once more and draws
the conclusions again. The search for the tube has no part in it.
"""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from helimag.errors import InputError
from helimag.files import text_of
from helimag.hydrodynamics import resistance
from helimag.proof.balls import (
    PRECISION,
    arithmetic,
    around_zero,
    exact,
    flint,
    largest,
    lower,
    root_of_squares,
    size,
    upper,
)
from helimag.proof.bounds import Report, Span, silent, spans_of, straights_of
from helimag.proof.clearance import clearance
from helimag.proof.exact import TOLERATED, WIRE_MODELS, Inputs
from helimag.proof.field import Views, lean_series, views_of
from helimag.proof.motion import LENGTH, TURN_PER_LENGTH, Swimming
from helimag.proof.sealing import Sealed, opened, reading, require_same
from helimag.proof.theorem import Disc, enters, theorem_of
from helimag.proof.tube import NONE, Chart, N, Tube, chart_at, pairs, reached, second_order, side_of
from helimag.proof.waves import Waves, basis
from helimag.scenario import Input, Scenario, parse

if TYPE_CHECKING:
    from flint import arb, arb_mat

FORMAT = "helimag proof 4"
WIDTH = re.compile(r"\d{1,20}(\.\d{1,20})?(e[-+]\d{1,2})?")  # no number that it takes long to read
OUTWARD = 1.0 + 1e-12  # what the rounding of a few floats cannot undo
ON_CURVE = 0.3  # of the time of a check, about: what holds on the curve


@dataclass(frozen=True)
class Claims:
    """What a certificate says is proved. SI; lengths of a box are half widths.

    Attributes
    ----------
    existence, stability, instability, bound, multipliers, tube_multipliers
        As in :class:`helimag.proof.theorem.Theorem`.
    box
        (3,): around the curve's place at the start of a turn, within which the orbit's head is then, m.
    turned
        How far the orbit's attitude may then be from the curve's, rad.
    tube
        (3,): half widths of the tube there, m.
    basin, basin_turned
        A start as a turn begins whose head is no further than this from the curve's place (m), and turned no further
        (rad), is in the tube or, of an orbit that attracts, comes into it.
    clearance
        All these motions keep this distance from walls, floor, surface, magnets and where a run has fallen, m.
    """

    existence: bool
    stability: bool
    instability: bool
    bound: float
    box: tuple[float, float, float]
    turned: float
    tube: tuple[float, float, float]
    basin: float
    basin_turned: float
    clearance: float
    multipliers: tuple[Disc, ...]
    tube_multipliers: tuple[Disc, ...]

    @property
    def proved(self) -> bool:
        """Whether an orbit exists, attracts and keeps clear of everything."""
        return self.existence and self.stability and self.clearance > 0.0


@dataclass(frozen=True)
class Certificate(Sealed):
    """A tube for a scenario, inputs with a tolerance, and the claims."""

    scenario: Scenario
    within: Mapping[str, str]
    tube: Tube
    claims: Claims

    def covers(self, scenario: Scenario) -> bool:
        """Whether this is about a scenario: the same but for how long it is run and what it is called.

        Returns
        -------
        bool
            False where anything that decides an orbit differs.
        """
        return _matter(settled(scenario)) == _matter(self.scenario)

    def content(self) -> dict[str, Any]:
        """All but the hash, as JSON has it.

        Returns
        -------
        dict
            Plain numbers, text and lists.
        """
        tube = self.tube
        return {
            "format": FORMAT,
            "scenario": self.scenario.to_toml(),
            "within": dict(self.within),
            "arithmetic": {"library": "python-flint", "precision_bits": PRECISION, "unit_length_m": str(LENGTH)},
            "tube": {
                "cos": tube.waves.cos.tolist(),
                "sin": tube.waves.sin.tolist(),
                "lean_cos": tube.lean.cos.tolist(),
                "lean_sin": tube.lean.sin.tolist(),
                "bent_cos": tube.bent.cos.tolist(),
                "bent_sin": tube.bent.sin.tolist(),
                **{name: list(getattr(tube, name)) for name in ("blocks", "radii", "entry", "decay", "swing", "odd")},
                **{name: getattr(tube, name) for name in ("spans", "order", "fine", "coarse", "rough")},
            },
            "claims": json.loads(json.dumps(asdict(self.claims))),
        }


def settled(scenario: Scenario) -> Scenario:
    """The scenario with its resistance as a matrix where it is solved for in floats: that matrix is then an input.

    Drag that depends on the place is no matrix, and stays what it is: no certificate is about it.
    """
    device = scenario.device
    model = device.hydrodynamics.model
    if device.hydrodynamics.near_walls or model == "matrix" or (device.helix is not None and model in WIRE_MODELS):
        return scenario
    matrix = resistance(device, scenario.fluid)
    even = (matrix + matrix.T) / 2.0
    return scenario.replaced({"device.hydrodynamics": {"model": "matrix", "resistance": even.tolist()}})


def _matter(scenario: Scenario) -> dict[str, Any]:
    """What decides the motion and its clearance."""
    return {key: value for key, value in scenario.decisive.items() if key != "run"}


def dynamics_of(scenario: Scenario, within: Mapping[str, str]) -> Views:
    """The enclosed equations of motion of a scenario, some inputs with a tolerance."""
    widths = {path: Fraction(width) for path, width in within.items()}
    plain = Swimming(Inputs(scenario).constants())
    if not widths:
        return views_of(plain)
    kinds: tuple[tuple[Literal["middle", "over"], int], ...] = (("middle", 1), ("middle", 2), ("over", 3))
    leaning, bending, over = (Swimming(Inputs(scenario, widths, *kind).constants(), plain=False) for kind in kinds)
    return Views(plain, leaning, bending, over)


def claims_of(
    scenario: Scenario,
    within: Mapping[str, str],
    tube: Tube,
    spans: Sequence[Span] | None = None,
    *,
    progress: Report = silent,
) -> Claims | None:
    """All that the enclosures prove of a tube, None where they hold nothing; the only place where claims come from.

    A search that has enclosed the spans of this tube hands them over; a check never does.

    Raises
    ------
    InputError
        Where the scenario is one of which nothing can be proved.
    """
    with arithmetic():
        dynamics = dynamics_of(scenario, within)
        try:
            spans = _spans(dynamics, tube, progress) if spans is None else spans
            chart = chart_at(tube, Swimming.components, len(within), exact(0))
            across = flint().arb_mat(chart.frame).inv()
        # a ball of frames that holds a singular one, or a series that is divided by one with zero in its first ball
        except (ZeroDivisionError, ValueError):
            return None
        theorem = theorem_of(tube, [span.near for span in spans])
        widths = {path: Fraction(width) for path, width in within.items()}
        clear = clearance(Inputs(scenario, widths), tube, spans)
        narrow = reached(tube, chart, [exact(theorem.share) * exact(r) for r in tube.radii])
        lean = lean_series(tube, dynamics.middle, exact(0), 1)
        box, whole = (_leaning_too(tube, lean, each) for each in (narrow, reached(tube, chart, tube.radii)))
        inward = [span.inward for span in spans if span.inward is not None]
        entered = theorem.stability and len(inward) == tube.spans and enters(tube, inward, tube.entry)
        # where inputs have a tolerance, each value has a tube of its own, and no ball is in all of them for sure
        basin = 0.0 if within else ball_in(tube, chart, across, tube.entry if entered else tube.radii)
    if not (theorem.existence and math.isfinite(clear) and np.isfinite([theorem.bound, *box, *whole]).all()):
        return None
    return Claims(
        existence=theorem.existence,
        stability=theorem.stability,
        instability=theorem.instability,
        bound=theorem.bound,
        box=_metres(box[:3]),
        turned=float(np.linalg.norm(box[3:])) * OUTWARD,
        tube=_metres(whole[:3]),
        basin=basin,
        basin_turned=basin * TURN_PER_LENGTH,
        clearance=clear,
        multipliers=theorem.multipliers,
        tube_multipliers=theorem.tube_multipliers,
    )


def _spans(views: Views, tube: Tube, progress: Report) -> list[Span]:
    """All spans' bounds, what holds on the curve enclosed first."""
    straights = straights_of(views, tube, progress=lambda part: progress(ON_CURVE * part))
    return spans_of(views, tube, straights, lambda part: progress(ON_CURVE + (1.0 - ON_CURVE) * part))


def _leaning_too(tube: Tube, by_input: "list[list[list[arb]]]", reach: "list[arb]") -> list[float]:
    """Upper bounds of deviations (6,) from the curve as a turn begins, how far it leans with the inputs included."""
    count = Swimming.components
    lean = [sum((around_zero(each[i][0]) for each in by_input), exact(0)) for i in range(count)]
    # a quaternion that changes by e turns by at most 2 asin(e / length), each axis by no more; and by no more than pi
    waves = tube.waves.matrix * basis(tube.waves.cos.shape[1], exact(0), 1)
    length = sum((waves[i, 0] * waves[i, 0] for i in range(3, 7)), exact(0)).sqrt()
    turned = flint().arb.pi() * root_of_squares(lean[3:]) / length
    return [upper(size(r) + size(extra)) for r, extra in zip(reach, [*lean[:3], *[turned] * 3], strict=True)]


def _metres(lengths: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (float(LENGTH) * OUTWARD * length for length in lengths)
    return x, y, z


def ball_in(tube: Tube, chart: Chart, across: "arb_mat", radii: Sequence[float]) -> float:
    """Radius (m) of a ball of places and, times ``TURN_PER_LENGTH``, of attitudes that lies within radii by block.

    Of z = Q y + K[y, y] / 2 there is a solution within the radii where those of Q^-1 (z - K[y, y] / 2) stay within them
    for all y that do (Brouwer). An angle is at least 0.99 times as long as four times its modified Rodrigues
    parameters, up to half a radian.
    """
    turn = exact(TURN_PER_LENGTH) * 100 / 99
    radius = exact(0.5) / exact(TURN_PER_LENGTH)
    bent = across * flint().arb_mat([[chart.bend(i, a, b) for a, b in pairs(N)] for i in range(N)])
    curved = [
        second_order({pair: bent[i, n] for n, pair in enumerate(pairs(N))}, tube.columns, radii) for i in range(N)
    ]
    for rows, width in zip(tube.columns, radii, strict=True):
        place = root_of_squares(across[i, j] for i in rows for j in range(3)) / exact(LENGTH)
        attitude = root_of_squares(across[i, j] for i in rows for j in range(3, N))
        left = exact(width) - root_of_squares(curved[i] for i in rows)
        radius = -largest([-radius, -left / (place + attitude * turn)])
    return max(lower(radius), 0.0)


def read_certificate(text: str) -> Certificate:
    """A certificate from its text, its hash compared.

    Returns
    -------
    Certificate
        Not proved again.

    Raises
    ------
    InputError
        Where it is none, or is not as it was written.
    """
    with reading():
        content, recorded = opened(text, FORMAT)
        certificate = certificate_from(content)
        require_same(certificate.content(), recorded)
    return certificate


def certificate_from(content: Mapping[str, Any]) -> Certificate:
    """A certificate from its content; within :func:`reading`."""
    tube = {name: value for name, value in content["tube"].items() if not name.endswith(("cos", "sin"))}
    lists = {name: tuple(value) for name, value in tube.items() if isinstance(value, list)}
    waves, lean, bent = (_waves_of(content["tube"], of) for of in ("", "lean_", "bent_"))
    claims = content["claims"]
    discs = {key: tuple(Disc(**disc) for disc in claims[key]) for key in ("multipliers", "tube_multipliers")}
    triples = {key: tuple(claims[key]) for key in ("box", "tube")}
    return Certificate(
        parse(content["scenario"], "the certificate's scenario"),
        content["within"],
        Tube(waves, lean=lean, bent=bent, **(tube | lists)),
        Claims(**(claims | discs | triples)),
    )


def _waves_of(tube: Mapping[str, Any], of: str) -> Waves:
    cos, sin = (np.array(tube[f"{of}{name}"], dtype=float) for name in ("cos", "sin"))
    return Waves(cos, sin) if len(cos) or len(sin) else NONE


def check(certificate: Certificate, *, progress: Report = silent) -> Claims:
    """Enclose everything once more and compare with what is claimed.

    Parameters
    ----------
    progress
        Told which part of the work is done, from 0 to 1; what it raises stops it.

    Returns
    -------
    Claims
        Those of the certificate, proved again.

    Raises
    ------
    InputError
        Where the enclosures do not prove exactly these claims.
    """
    require_tolerances(certificate)
    _require_whole(certificate.tube, len(certificate.within))
    found = claims_of(certificate.scenario, certificate.within, certificate.tube, progress=progress)
    if found is None:
        raise InputError("the certificate proves nothing: its tube is not shown to hold an orbit")
    if found != certificate.claims:
        wrong = [name for name, value in asdict(found).items() if value != asdict(certificate.claims)[name]]
        raise InputError(f"the certificate claims what its tube does not prove: {', '.join(wrong)}")
    return found


def certificate_in(path: str | Path) -> Certificate:
    """A certificate from its file, its hash compared.

    Returns
    -------
    Certificate
        Not proved again: that is what :func:`check_file` does.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where it is no certificate, or was changed.
    """
    return read_certificate(text_of(path))


def require_tolerances(certificate: Certificate) -> None:
    """Refuse a tolerance of an input that is not enclosed over all its values wherever it acts, or not given."""
    for path, width in certificate.within.items():
        if path not in TOLERATED:
            raise InputError(
                f"the certificate's inputs with a tolerance must be of {', '.join(TOLERATED)}; got '{path}'"
            )
        Input(path).value(certificate.scenario)
        if not (isinstance(width, str) and WIDTH.fullmatch(width) and Fraction(width) > 0):
            raise InputError(f"the certificate's tolerance of {path} must be a number above zero; got {width!r}")


def _require_whole(tube: Tube, inputs: int) -> None:
    """Refuse a tube whose parts do not fit together: the bounds are sums over them."""
    lists, whole = (tube.radii, tube.entry, tube.decay, tube.swing), tube.cuts
    numbers = (
        all(isinstance(each, tuple) for each in (*lists, tube.blocks, tube.odd))
        and all(type(value) is float for each in lists for value in each)
        and all(type(value) is int for value in (*whole, *tube.blocks))
        and all(type(value) is bool for value in tube.odd)
        and tube.waves.cos.ndim == tube.lean.cos.ndim == tube.bent.cos.ndim == 2
    )
    if not (numbers and _fits(tube, inputs)):
        raise InputError("the certificate's tube is not one: its blocks, columns and radii do not fit together")


def _fits(tube: Tube, inputs: int) -> bool:
    """Whether numbers, sizes and shapes of a tube are such that the bounds speak of all of it."""
    count, sizes = len(tube.radii), np.diff([*tube.blocks, N])
    return (
        tube.waves.cos.shape == tube.waves.sin.shape
        and tube.waves.count == Swimming.components + N * N
        and tube.lean.cos.shape == tube.lean.sin.shape
        and tube.lean.count == Swimming.components * inputs
        and tube.bent.cos.shape == tube.bent.sin.shape
        and tube.bent.count in (0, N * len(pairs(N + inputs)))
        and count == len(tube.blocks) == len(tube.entry) == len(tube.decay) == len(tube.swing) == len(tube.odd)
        and tube.blocks[:1] == (0,)
        and bool(np.isin(sizes, (1, 2)).all())
        and all(radius > 0.0 for radius in (*tube.radii, *tube.entry))
        # beyond the tube all is of the inputs' middle values
        and not (inputs and tube.reaches_out)
        and bool(np.isfinite(tube.lean.cos).all() and np.isfinite(tube.lean.sin).all())
        and bool(np.isfinite(tube.bent.cos).all() and np.isfinite(tube.bent.sin).all())
        and bool(np.isfinite(tube.waves.cos).all() and np.isfinite(tube.waves.sin).all())
        and all(math.isfinite(value) for value in (*tube.region, *tube.decay, *tube.swing))
        # a column by itself has a real multiplier: a disc that is turned away from it holds nothing
        and all(size == 2 or swing == 0.0 for size, swing in zip(sizes, tube.swing, strict=True))
        and min(tube.cuts) >= 1
        and tube_closes(tube)
    )


def tube_closes(tube: Tube) -> bool:
    """Whether curve and frame come back after a turn: the place as it was, quaternion and columns up to their sign."""
    count = Swimming.components
    turned = any(
        _returns(tube.waves, slice(count - 4, count), odd) and _lean_returns(tube, odd) for odd in (True, False)
    )
    closed = _returns(tube.waves, slice(0, 3), False) and turned
    for odd, columns in zip(tube.odd, tube.columns, strict=True):
        rows = slice(Swimming.components + N * columns.start, Swimming.components + N * columns.stop)
        closed &= _returns(tube.waves, rows, odd)
    return closed and _bent_returns(tube)


def _bent_returns(tube: Tube) -> bool:
    """Whether second-order terms come back after a turn: with the sign of the product of what they are of."""
    side = side_of(tube)
    signs = [any(odd and a in rows for odd, rows in zip(tube.odd, tube.columns, strict=True)) for a in range(side)]
    return not tube.bent.count or all(
        _returns(tube.bent, slice(N * n, N * n + N), signs[a] != signs[b]) for n, (a, b) in enumerate(pairs(side))
    )


def _lean_returns(tube: Tube, odd: bool) -> bool:
    """Whether the leaning comes back after a turn as the curve does, its quaternion with the other sign if ``odd``."""
    begins = range(0, tube.lean.count, Swimming.components)
    return all(
        _returns(tube.lean, slice(b, b + 3), False) and _returns(tube.lean, slice(b + 3, b + 7), odd) for b in begins
    )


def _returns(waves: Waves, rows: slice, odd: bool) -> bool:
    """Whether functions come back after a turn: with the other sign if ``odd``."""
    wrong = slice(0 if odd else 1, None, 2)
    return not (waves.cos[rows, wrong].any() or waves.sin[rows, wrong].any())
