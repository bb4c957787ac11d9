"""Plans of a calibration: runs, what was observed of them, and what is free; frozen models that read TOML."""

import math
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, ValidationInfo, model_validator

from helimag import quantities as q
from helimag.calibration.numbers import NUMBERS
from helimag.errors import FileError, InputError
from helimag.files import text_of, toml_tables
from helimag.scenario import Part, Scenario, Size, Time, messages, model_of, preset_names

Value = float | str

LEAST_SD = 1e-12  # SI; no run is computed as well, and squares of what is missed by far more have no number


def si(given: Value, kind: q.Kind | None, what: str) -> float:
    """SI value of text with a unit, or of a number; ``what`` names it in messages.

    Raises
    ------
    InputError
        Where it is not such text, or not finite.
    """
    try:
        value = q.parse(given, kind) if kind is not None and isinstance(given, str) else float(given)
    except InputError as error:
        raise InputError(f"{what} {error}") from None
    except ValueError:
        raise InputError(f"{what} must be a number; got {given!r}") from None
    if not math.isfinite(value):
        raise InputError(f"{what} must be finite; got {given!r}")
    return value


class ObservedNumber(Part):
    """A number of a run up to ``until`` (the run's end where left out), such as ``what = "output"``, with its sd."""

    what: Literal["output", "gain", "attack_angle", "speed", "rise", "depth"]
    value: Value
    sd: Value
    until: Time | None = None
    source: str

    @property
    def label(self) -> str:
        """What it is, in words."""
        return NUMBERS[self.what].words

    @property
    def numbers(self) -> tuple[float, float]:
        """Value and standard deviation, SI."""
        kind = NUMBERS[self.what].kind
        return si(self.value, kind, f"{self.what}.value"), si(self.sd, kind, f"{self.what}.sd")

    @model_validator(mode="after")
    def _sensible(self, info: ValidationInfo) -> Self:
        if NUMBERS[self.what].kind is not None and info.context and info.context.get("file"):
            for name, given in (("value", self.value), ("sd", self.sd)):
                if not isinstance(given, str):
                    raise InputError(f".{name} must be text with a unit, such as '1 mm'; got {given!r}")
        if not self.numbers[1] >= LEAST_SD:
            raise InputError(f".sd must be above zero, by {LEAST_SD:g} in SI units at least; got {self.sd!r}")
        return self


class Ending(Part):
    """How a run ended and when: ``fell`` at ``time``, give or take the factor 1 + ``spread``.

    ``stays`` is for at least ``time``; another end without ``time`` is at some time of the run.
    """

    what: Literal["attracted", "fell", "floor", "surface", "wall", "stays"]
    time: Time | None = None
    spread: float = Field(default=0.1, gt=0.0, le=10.0)
    source: str

    @property
    def label(self) -> str:
        """What it is, in words."""
        return self.what if self.time is None else f"{self.what} {self.time:g} s"


class Track(Part):
    """A whole measured run, a file of ``vision`` or ``runs``: positions at up to ``samples`` of its times.

    ``sd`` is what the model may be off by along each axis; the file's own uncertainty is added. With
    ``align = "start"`` both begin at the same place and time, as of a camera whose frame is its own.
    """

    what: Literal["track"]
    file: str
    sd: Size
    samples: int = Field(default=20, ge=2, le=10_000)
    align: Literal["none", "start"] = "none"
    source: str

    @property
    def label(self) -> str:
        """What it is, in words."""
        return f"track {Path(self.file).name}"


Observation = ObservedNumber | Ending | Track
KINDS: dict[str, type[Observation]] = {**dict.fromkeys(NUMBERS, ObservedNumber), "track": Track}


class Experiment(Part):
    """A run that was made: a scenario with its own drive, and what was observed of it."""

    name: str = Field(pattern="^[A-Za-z0-9_./ -]+$", max_length=100)
    base: str | Scenario
    changes: dict[str, Any] = {}
    observed: tuple[Observation, ...] = Field(min_length=1)

    @model_validator(mode="before")
    @classmethod
    def _by_kind(cls, data: Any, info: ValidationInfo) -> Any:
        """Each observation as the model that its ``what`` says, so that a mistake in it is named as its own."""
        if not isinstance(data, dict) or not isinstance(data.get("observed"), (list, tuple)):
            return data
        return data | {"observed": tuple(_observation(entry, info.context) for entry in data["observed"])}


def _observation(entry: Any, context: Any) -> Any:
    if not isinstance(entry, dict):
        return entry
    what = entry.get("what")
    known = [*NUMBERS, "attracted", "fell", "floor", "surface", "wall", "stays", "track"]
    if what not in known:
        raise InputError(f".observed.what must be one of {', '.join(known)}; got {what!r}")
    kind = KINDS.get(str(what), Ending)
    try:
        return kind.model_validate(entry, context=context)
    except ValidationError as error:
        problems = "; ".join(messages(error, kind))
        raise InputError(f".observed '{what}': {problems}") from None


class Candidate(Part):
    """A run that could be made next."""

    name: str = Field(max_length=100)
    base: str | Scenario
    changes: dict[str, Any] = {}


class Free(Part):
    """An input that is not known, with what is known of it beforehand.

    ``input`` is a path of :class:`helimag.scenario.Input`. With ``factor`` the value multiplies each run's own;
    ``runs`` names the runs that it belongs to, all where left out.
    """

    input: str
    name: str | None = None
    prior: Literal["uniform", "log-uniform", "normal"]
    low: Value | None = None
    high: Value | None = None
    mean: Value | None = None
    sd: Value | None = None
    factor: bool = False
    runs: tuple[str, ...] | None = None

    @property
    def title(self) -> str:
        """The name, or the input's path."""
        return self.name or self.input

    @model_validator(mode="after")
    def _fits_prior(self) -> Self:
        given = {key for key in ("low", "high", "mean", "sd") if getattr(self, key) is not None}
        needed = {"mean", "sd"} if self.prior == "normal" else {"low", "high"}
        allowed = needed | {"low", "high"}
        if not needed <= given <= allowed:
            got = ", ".join(sorted(given)) or "nothing"
            raise InputError(f"a {self.prior} prior needs {' and '.join(sorted(needed))}; got {got}")
        return self


class CalibrationPlan(Part):
    """What is calibrated, against what."""

    name: str = "calibration"
    run: tuple[Experiment, ...] = Field(min_length=1)
    free: tuple[Free, ...] = Field(min_length=1)
    candidate: tuple[Candidate, ...] = ()
    particles: Annotated[int, Field(ge=32, le=100_000)] = 256
    seed: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [run.name for run in self.run]
        _check_once("run", names)
        _check_once("free", [free.title for free in self.free])
        _check_once("candidate", [candidate.name for candidate in self.candidate])
        for free in self.free:
            for name in free.runs or ():
                if name not in names:
                    raise InputError(f"free '{free.title}' names the run '{name}'; there are {', '.join(names)}")
        return self

    def to_toml(self) -> str:
        """The plan as a file's text.

        Returns
        -------
        str
            Which :func:`parse_plan` reads.
        """
        import tomli_w

        return tomli_w.dumps(self.model_dump(mode="json", exclude_none=True))


def _check_once(what: str, names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{what} '{name}' is there twice; give each its own name")


def parse_plan(text: str, source: str = "plan") -> CalibrationPlan:
    """Read a plan from TOML text; ``source`` names it in messages.

    Returns
    -------
    CalibrationPlan
        Checked.

    Raises
    ------
    InputError
        Where the text is not TOML or not a plan.
    """
    data = toml_tables(text, source)
    if "device" in data or "axis" in data:
        what = "a scenario" if "device" in data else "a sweep's plan"
        raise InputError(f"{source} is {what}, not a calibration's plan, which has [[run]] and [[free]] tables")
    return model_of(CalibrationPlan, data, source)


def load_plan(path: str | Path) -> CalibrationPlan:
    """Read a plan file; paths of scenarios and tracks in it are relative to the file.

    Returns
    -------
    CalibrationPlan
        Checked, with paths made relative to where the caller is.

    Raises
    ------
    FileError
        Where the file cannot be read.
    InputError
        Where it is not a plan.
    """
    plan, folder = parse_plan(text_of(path), str(path)), Path(path).parent
    runs = tuple(_placed(run, folder, observed=tuple(_track(o, folder) for o in run.observed)) for run in plan.run)
    candidates = tuple(_placed(candidate, folder) for candidate in plan.candidate)
    return plan.model_copy(update={"run": runs, "candidate": candidates})


def _placed(part: Any, folder: Path, **more: object) -> Any:
    here = isinstance(part.base, str) and part.base not in preset_names()
    return part.model_copy(update={"base": str(folder / part.base) if here else part.base} | more)


def _track(observation: Observation, folder: Path) -> Observation:
    if not isinstance(observation, Track):
        return observation
    place = folder / observation.file
    if not place.is_file():
        raise FileError(f"there is no track '{place}'")
    return observation.model_copy(update={"file": str(place)})
