"""How things end, and why: the one vocabulary of verdicts, reasons, ends of runs, orbits and basins.

Each member of these classes is a value that carries all that is said about it: the whole number that kernels and files
hold, the word that is written everywhere, a sentence with places for numbers, and what can be done about it. Whatever
needs to know what an outcome implies asks the member; nothing reads words in a sentence. A new outcome is a new line
here: its number is the next one, since files that were written before must keep their meaning.
"""

from collections.abc import Iterable
from enum import StrEnum, unique
from typing import Any, Self

from helimag.errors import InputError


class Term(StrEnum):
    """A member of the vocabulary: a word that also has a number, a sentence and, where something can be done, a remedy.

    :meth:`of` finds it by its word or its number, and it is equal to both: text is compared as text, and arrays of
    stored numbers as numbers, ``dataset["verdict"] == Verdict.FELL``.
    """

    flag: int
    sentence: str
    remedy: str

    __array_ufunc__ = None  # NumPy leaves comparisons of its arrays to __eq__ below, instead of finding all unequal

    def __new__(cls, _flag: int, word: str, *_about: object) -> Self:
        """The word is the value."""
        member = str.__new__(cls, word)
        member._value_ = word
        return member

    def __init__(self, flag: int, _word: str, sentence: str = "", remedy: str = "") -> None:
        self.flag, self.sentence, self.remedy = flag, sentence, remedy

    @classmethod
    def _missing_(cls, value: object) -> Self | None:
        return next((member for member in cls if member == value), None)

    @classmethod
    def of(cls, value: object) -> Self:
        """The member of this word or number.

        Returns
        -------
        Self
            What equals it.

        Raises
        ------
        InputError
            Where there is none.
        """
        found = cls._missing_(value)
        if found is None:
            raise InputError(f"{cls.__name__.lower()} must be one of {', '.join(cls)}; got {value!r}")
        return found

    def __eq__(self, other: object) -> Any:
        """As a word with text, as a number with numbers; arrays one by one."""
        return self._beside(other) == other

    def __ne__(self, other: object) -> Any:
        """The opposite."""
        return self._beside(other) != other

    __hash__ = str.__hash__

    def _beside(self, other: object) -> int | str:
        number = not isinstance(other, str) and getattr(getattr(other, "dtype", None), "kind", "i") in "iuf"
        return self.flag if number else str(self)

    def text(self, **numbers: object) -> str:
        """The sentence with its numbers and, after a colon, the remedy."""
        return ": ".join(part.format(**numbers) for part in (self.sentence, self.remedy) if part)


def cf_masks(terms: Iterable[Term]) -> dict[str, object]:
    """CF attributes of a variable whose bits, at the terms' numbers, say which of them hold."""
    known = list(terms)
    return {
        "flag_masks": [1 << term.flag for term in known],
        "flag_meanings": " ".join(str(term).replace(" ", "_") for term in known),
    }


def cf_flags(terms: Iterable[Term], *, zero: str = "") -> dict[str, object]:
    """CF attributes of a variable that holds the terms' numbers; ``zero`` is the word for 0 where no term has it."""
    words = ({0: zero} if zero else {}) | {term.flag: str(term) for term in terms}
    return {"flag_values": list(words), "flag_meanings": " ".join(w.replace(" ", "_") for w in words.values())}


@unique
class Verdict(Term):
    """How a run is judged. Two members are not judged: a run that was not computed, and one that failed.

    ``inside`` says whether the device had not left the magnet, nor come to floor, surface or walls, when the run ended.
    """

    judged: bool
    inside: bool

    def __init__(self, flag: int, word: str, judged: bool, inside: bool, sentence: str) -> None:
        super().__init__(flag, word, sentence)
        self.judged, self.inside = judged, inside

    NOT_COMPUTED = (0, "not-computed", False, False, "the run has not been computed")
    BOUNDED = (1, "bounded", True, True, "the device stays: its mean height has settled")
    DRIFTING = (2, "drifting", True, True, "the device is inside, and its height has not settled")
    ATTRACTED = (3, "attracted", True, False, "the magnet pulls the device in")
    FELL = (4, "fell", True, False, "the device falls away from the magnet")
    WALL_LIMITED = (5, "wall-limited", True, False, "the device comes to floor, surface or a wall")
    FAILED = (6, "failed", False, False, "there is no run to judge")
    UNDECIDED = (7, "undecided", True, True, "the device is inside, and the run does not show whether it stays")

    @property
    def open(self) -> bool:
        """Whether the device is inside at the end of the run, and nothing is told of what it does then."""
        return self.inside and self is not Verdict.BOUNDED


@unique
class Reason(Term):
    """Why a run has its verdict."""

    verdict: Verdict

    def __init__(self, flag: int, word: str, verdict: Verdict, sentence: str, remedy: str = "") -> None:
        super().__init__(flag, word, sentence, remedy)
        self.verdict = verdict

    NOT_COMPUTED = (0, "not-computed", Verdict.NOT_COMPUTED, "the run has not been computed")
    SETTLED = (
        1,
        "settled",
        Verdict.BOUNDED,
        "inside for {time:.0f} s; the mean height has settled: {change:+.2f} mm in the last quarter",
    )
    STILL_RISES = (
        2,
        "still-rises",
        Verdict.DRIFTING,
        "inside for {time:.0f} s, but the mean height still rises: {change:+.2f} mm in the last quarter{left}",
    )
    STILL_SINKS = (
        3,
        "still-sinks",
        Verdict.DRIFTING,
        "inside for {time:.0f} s, but the mean height still sinks: {change:+.2f} mm in the last quarter{left}",
    )
    SWINGS_EVER_MORE = (
        4,
        "swings-ever-more",
        Verdict.DRIFTING,
        "inside for {time:.0f} s, but the height swings ever more: {growth:+.2f} mm in the last quarter",
    )
    PULLED_INTO_MAGNET = (5, "pulled-into-magnet", Verdict.ATTRACTED, "pulled into the magnet at {time:.1f} s")
    FELL_BEHIND = (
        6,
        "fell-behind",
        Verdict.FELL,
        "fell behind at {since:.1f} s; at the end {drop:.0f} mm down, {share:.2f} of the initial gap",
    )
    REACHED_FLOOR = (7, "reached-floor", Verdict.WALL_LIMITED, "reached the floor at {time:.1f} s")
    REACHED_SURFACE = (8, "reached-surface", Verdict.WALL_LIMITED, "reached the surface at {time:.1f} s")
    REACHED_WALL = (9, "reached-wall", Verdict.WALL_LIMITED, "reached the wall at {time:.1f} s")
    NUMBERS_BROKE_DOWN = (
        10,
        "numbers-broke-down",
        Verdict.FAILED,
        "broke down at {time:.6g} s, where no step is small enough",
        "check the scenario for extreme values (a viscosity near zero, a magnet that the device starts very close to)",
    )
    SCENARIO_REFUSED = (11, "scenario-refused", Verdict.FAILED, "the values make no scenario that can be run")
    TOO_FEW_SAMPLES = (
        12,
        "too-few-samples",
        Verdict.UNDECIDED,
        "inside for {time:.6g} s, but {samples} samples are too few, or too uneven, to tell whether it has settled",
        "take {needed} or more (run.interval)",
    )
    TOO_SHORT = (
        13,
        "too-short",
        Verdict.UNDECIDED,
        "inside for {time:.6g} s, which is too short to tell whether it stays: {slow}",
        "run {needed:.0f} s or more (run.duration)",
    )
    NOTHING_MOVES = (
        14,
        "nothing-moves",
        Verdict.UNDECIDED,
        "inside for {time:.6g} s, in which neither weight nor magnet moves the device: that would take {needed:.1e} s",
        "check fluid.viscosity, drive.distance and the moments of magnet and device",
    )
    SLOWNESS_UNKNOWN = (
        15,
        "slowness-unknown",
        Verdict.UNDECIDED,
        "inside for {time:.6g} s, and its heights alone do not show whether that is long enough to tell where it goes",
        "compare it with a simulated run, whose scenario does",
    )
    MOVES_ON = (
        16,
        "moves-on",
        Verdict.UNDECIDED,
        "inside for {time:.0f} s; the mean height moves little, but not less and less: {last:+.3g} mm in the last "
        "quarter, {before:+.3g} mm in the one before",
        "run longer (run.duration)",
    )
    SWINGS_ON = (
        17,
        "swings-on",
        Verdict.UNDECIDED,
        "inside for {time:.0f} s; the mean height has settled, but its swings do not die out: {last:.3g} mm rms in the "
        "last quarter, {before:.3g} mm in the one before",
        "run longer (run.duration)",
    )
    HELD_BY_FLOOR = (
        18,
        "held-by-floor",
        Verdict.WALL_LIMITED,
        "held by the floor: {count} from {first:.1f} s to {last:.1f} s, {total:.1f} s in all",
    )
    HELD_BY_SURFACE = (
        19,
        "held-by-surface",
        Verdict.WALL_LIMITED,
        "held by the surface: {count} from {first:.1f} s to {last:.1f} s, {total:.1f} s in all",
    )
    HELD_BY_WALL = (
        20,
        "held-by-wall",
        Verdict.WALL_LIMITED,
        "held by the wall at {side}: {count} from {first:.1f} s to {last:.1f} s, {total:.1f} s in all",
    )


@unique
class Limit(Term):
    """What a device can touch in its workspace, and why a run that it holds has its verdict."""

    cause: Reason

    def __init__(self, flag: int, word: str, sentence: str, cause: Reason) -> None:
        super().__init__(flag, word, sentence)
        self.cause = cause

    FLOOR = (0, "floor", "the floor", Reason.HELD_BY_FLOOR)
    SURFACE = (1, "surface", "the surface", Reason.HELD_BY_SURFACE)
    LOW_X = (2, "low x", "the wall at low x", Reason.HELD_BY_WALL)
    HIGH_X = (3, "high x", "the wall at high x", Reason.HELD_BY_WALL)
    LOW_Y = (4, "low y", "the wall at low y", Reason.HELD_BY_WALL)
    HIGH_Y = (5, "high y", "the wall at high y", Reason.HELD_BY_WALL)


HOLDING = frozenset(wall.cause for wall in Limit)  # reasons of runs that end held, not stopped, by a wall


@unique
class OrbitStatus(Term):
    """How a search for an orbit ended."""

    FOUND = (0, "found", "the run that repeats itself every turn of the magnet")
    NO_ORBIT = (
        1,
        "no orbit found",
        "no search ended on an orbit",
        "begin nearer (near=...), list all orbits in a box, or follow one from inputs that have it until it ends",
    )
    LOST_STEP = (
        2,
        "lost step",
        "the device does not keep in step with the field",
        "lower drive.frequency or bring the magnet nearer",
    )
    ATTRACTED = (3, "attracted", "the search ran into the magnet", "increase drive.distance or lower drive.pitch")
    LEFT_BOX = (
        4,
        "left the box",
        "the search left the region around the magnet",
        "decrease drive.distance, raise drive.pitch or begin nearer",
    )
    WALL_LIMITED = (
        5,
        "wall-limited",
        "the orbit passes through floor, surface or walls",
        "change the workspace or the inputs",
    )
    BROKE_DOWN = (6, "broke down", "the numbers are not finite", "check the scenario for extreme values")


@unique
class BasinEnd(Term):
    """How a device ends that is released at a place around a stable orbit."""

    CAPTURED = (0, "captured", "comes to the orbit")
    STAYED = (1, "stayed", "stays inside, and comes no nearer to the orbit")
    ATTRACTED = (2, "attracted", "is pulled into the magnet")
    FELL = (3, "fell", "falls away from the magnet")
    WALL_LIMITED = (4, "wall-limited", "comes to floor, surface or a wall")
    OUT_OF_STEP = (5, "out of step", "has no attitude there that keeps in step with the field")
    LEFT = (6, "left", "leaves the grid of the averaged model")
    BROKE_DOWN = (7, "broke down", "its numbers break down")
    NOT_RUN = (8, "not_run", "was not released there")


@unique
class End(Term):
    """Why a run stopped: what the time loop writes into a run's state, and what is stored with it.

    ``cause`` is the reason for the verdict, where the end alone decides it; None where the heights do. ``search`` and
    ``basin`` are what such an end means to a search for an orbit, and to a basin; None where it says nothing.
    """

    cause: Reason | None
    search: OrbitStatus | None
    basin: BasinEnd | None

    def __init__(
        self,
        flag: int,
        word: str,
        sentence: str,
        cause: Reason | None,
        search: OrbitStatus | None,
        basin: BasinEnd | None,
    ) -> None:
        super().__init__(flag, word, sentence)
        self.cause, self.search, self.basin = cause, search, basin

    RUNNING = (0, "running", "goes on", None, None, None)
    HORIZON = (1, "horizon", "stays to its horizon", None, None, None)
    CONTACT = (
        2,
        "contact",
        "is pulled into the magnet",
        Reason.PULLED_INTO_MAGNET,
        OrbitStatus.ATTRACTED,
        BasinEnd.ATTRACTED,
    )
    FALL = (3, "fall", "falls", Reason.FELL_BEHIND, OrbitStatus.LEFT_BOX, BasinEnd.FELL)
    FLOOR = (4, "floor", "meets the floor", Reason.REACHED_FLOOR, OrbitStatus.WALL_LIMITED, BasinEnd.WALL_LIMITED)
    SURFACE = (
        5,
        "surface",
        "meets the surface",
        Reason.REACHED_SURFACE,
        OrbitStatus.WALL_LIMITED,
        BasinEnd.WALL_LIMITED,
    )
    WALL = (6, "wall", "meets a wall", Reason.REACHED_WALL, OrbitStatus.WALL_LIMITED, BasinEnd.WALL_LIMITED)
    NOT_FINITE = (
        7,
        "not-finite",
        "breaks down",
        Reason.NUMBERS_BROKE_DOWN,
        OrbitStatus.BROKE_DOWN,
        BasinEnd.BROKE_DOWN,
    )


@unique
class Future(Term):
    """The outlook of a run: what happens after its horizon."""

    ON_ORBIT = (0, "on a stable orbit", "{begin}, on a stable orbit: {rates}")
    COMING = (1, "coming to a stable orbit", "{begin}, coming to the stable orbit at {place}: {rates}")
    LEAVES = (2, "leaves later", "{begin}, but {found}: continued, it {end} after another {longer:.0f} s")
    SWINGS = (
        3,
        "swings for ever, on a closed curve",
        "{begin} and for another {longer:.0f} s, {motion}, though {found}",
    )
    STAYS = (4, "stays, on no stable orbit", "{begin} and for another {longer:.0f} s, {motion}, though {found}")
    GONE = (5, "has left", "the run left; no orbit is sought from its end")
    UNKNOWN = (6, "not known", "{problem}")
    HELD = (7, "held", "held by a wall at its end: a device that is held has no free orbit, and none is sought")

    @property
    def leaves(self) -> bool:
        """Whether the device is known to leave, has left, or is held by a wall."""
        return self in {Future.LEAVES, Future.GONE, Future.HELD}


@unique
class Why(Term):
    """Why a run and the orbit of its inputs do not say the same. Numbers begin at one: zero is nothing to explain."""

    BASIN = (
        1,
        "starts outside the basin",
        "the orbit is stable and a run beside it stays, but from the start the run leaves",
    )
    SLOW_DRIFT = (2, "slow drift", "the run had not settled at its horizon; continued, it does what the orbit says")
    SHORT = (3, "horizon too short", "no stable orbit, and the run leaves when it is continued")
    SOON = (4, "judged too soon", "judged to have left, but it comes back to the stable orbit when it is continued")
    OTHER = (5, "other attractor", "no stable orbit is known, and the run stays all the same")
    UNEXPLAINED = (6, "not explained", "the orbit is stable, but a run beside it leaves")
