"""Plans: which runs a sweep makes, as frozen models that read and write TOML."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from helimag.engine import method_named
from helimag.ensembles import RUNS
from helimag.errors import InputError
from helimag.files import text_of, toml_tables
from helimag.outcomes import Verdict
from helimag.scenario import Part, Scenario, Size, Time, model_of, preset_names


class Axis(Part):
    """One field of the scenario and the values that it takes; every physical value is text with a unit.

    A list (``values``), a range (``start``, ``stop``, ``step``), a grid (``start``, ``stop``, ``count``), or, where the
    plan samples, bounds only (``start``, ``stop``). Axes with the same ``zip`` name move together; all others are
    crossed. Fields are the paths of :class:`helimag.scenario.Input`, or of a choice, whose words are given as a list.
    """

    field: str
    values: tuple[float | str, ...] | None = None
    start: float | str | None = None
    stop: float | str | None = None
    step: float | str | None = None
    count: int | None = Field(default=None, ge=2)
    zip: str | None = Field(default=None, pattern="^[A-Za-z][A-Za-z0-9_]*$")

    @property
    def form(self) -> str:
        """``list``, ``range``, ``grid`` or ``bounds``."""
        if self.values is not None:
            return "list"
        return "range" if self.step is not None else "grid" if self.count is not None else "bounds"

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        given = {name for name in ("values", "start", "stop", "step", "count") if getattr(self, name) is not None}
        forms = ({"values"}, {"start", "stop", "step"}, {"start", "stop", "count"}, {"start", "stop"})
        if given not in forms:
            got = ", ".join(sorted(given)) or "nothing"
            raise InputError(
                f"'{self.field}' must have values, or start and stop with a step, with a count, or alone where the "
                f"plan samples; got {got}"
            )
        if self.values == ():
            raise InputError(f"'{self.field}' must have at least one value; got an empty list")
        return self


class Sampling(Part):
    """Points spread over the axes' bounds instead of a grid."""

    method: Literal["sobol", "latin-hypercube"]
    count: int = Field(ge=1)
    seed: int = Field(default=0, ge=0)


def _judged(word: str) -> str:
    """The word of a verdict that runs can be judged to have."""
    words = [verdict for verdict in Verdict if verdict.judged]
    if word not in words:
        raise InputError(f"must be one of {', '.join(words)}; got {word!r}")
    return word


def _known_method(name: str) -> str:
    """The name of a method that takes steps."""
    method_named(name)
    return name


class Boundary(Part):
    """Spend runs where the verdict changes, over two axes that give a coarse grid to begin with.

    ``resolution`` is the distance between two runs of different verdict at which refining ends, as a fraction of the
    axes' ranges.
    """

    budget: int = Field(ge=16)
    verdict: Annotated[str, AfterValidator(_judged)] = "bounded"
    resolution: float = Field(default=0.01, gt=0.0, lt=1.0)


class EnsembleTable(Part):
    """Devices of a calibration, ``draws`` of them, that every point is run with, and errors of each run on top.

    ``noise`` names inputs with the standard deviation of their errors, as text with a unit; ``displacement`` is that of
    where the device is released, along each axis.
    """

    fit: str
    draws: int = Field(default=RUNS, ge=1, le=100_000)
    seed: int = Field(default=0, ge=0)
    noise: dict[str, str] = {}
    displacement: Size | None = None


class Plan(Part):
    """What a sweep runs and keeps.

    ``method`` is that of :func:`helimag.simulate`; left out, a new store takes its default, and one that was begun goes
    on with its own.
    """

    name: str = "sweep"
    base: str | Scenario
    changes: dict[str, Any] = {}
    duration: Time | None = None
    method: Annotated[str, AfterValidator(_known_method)] | None = None
    samples: int = Field(default=100, ge=20, le=100_000)
    axis: tuple[Axis, ...] = Field(min_length=1)
    sample: Sampling | None = None
    boundary: Boundary | None = None
    ensemble: EnsembleTable | None = None
    trajectory: Time | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.sample is not None and self.boundary is not None:
            raise InputError("a plan has either [sample] or [boundary]; got both")
        if self.ensemble is not None and self.boundary is not None:
            raise InputError("with [ensemble] a verdict has no [boundary], only a probability; give the axes a grid")
        wanted = {"bounds"} if self.sample else {"grid"} if self.boundary else {"list", "range", "grid"}
        kind = "[sample]" if self.sample else "[boundary]" if self.boundary else "neither [sample] nor [boundary]"
        for axis in self.axis:
            if axis.form not in wanted:
                raise InputError(f"with {kind}, axis '{axis.field}' must be a {' or '.join(sorted(wanted))}")
            if axis.zip and (self.sample or self.boundary):
                raise InputError(f"with {kind}, axis '{axis.field}' cannot be zipped")
        if self.boundary is not None and len(self.axis) != 2:
            raise InputError(f"[boundary] needs two axes; got {len(self.axis)}")
        fields = [axis.field for axis in self.axis]
        for field in fields:
            if fields.count(field) > 1:
                raise InputError(f"axis '{field}' is there twice")
        return self

    def to_toml(self) -> str:
        """The plan as a file's text.

        Returns
        -------
        str
            Which :func:`parse_plan` reads.
        """
        import tomli_w

        data = self.model_dump(mode="json", exclude_none=True)
        return tomli_w.dumps({key: value for key, value in data.items() if value != {}})


def with_ensemble(plan: Plan, given: Mapping[str, object]) -> Plan:
    """A plan with entries of its ``[ensemble]`` set, whether or not it has one; values as a file would have them.

    Returns
    -------
    Plan
        A copy.

    Raises
    ------
    InputError
        Where they do not fit, or no fit is named.
    """
    data = plan.model_dump(mode="json", exclude_none=True)
    return model_of(Plan, data | {"ensemble": {**data.get("ensemble", {}), **given}}, "plan")


def parse_plan(text: str, source: str = "plan") -> Plan:
    """Read a plan from TOML text; ``source`` names it in messages.

    Returns
    -------
    Plan
        Checked.

    Raises
    ------
    InputError
        Where the text is not TOML or not a plan.
    """
    data = toml_tables(text, source)
    if "device" in data:
        raise InputError(
            f"{source} is a scenario, not a plan: a plan has a base, such as that file, and [[axis]] tables"
        )
    return model_of(Plan, data, source)


def load_plan(path: str | Path) -> Plan:
    """Read a plan file; the paths of a base scenario and of a fit in it are relative to the file.

    Returns
    -------
    Plan
        Checked.

    Raises
    ------
    FileError
        Where there is no such file, or it cannot be read.
    InputError
        Where it is not a plan.
    """
    plan, folder = parse_plan(text_of(path), str(path)), Path(path).parent
    placed: dict[str, object] = {}
    if isinstance(plan.base, str) and plan.base not in preset_names():
        placed["base"] = str(folder / plan.base)
    if plan.ensemble is not None:
        placed["ensemble"] = plan.ensemble.model_copy(update={"fit": str(folder / plan.ensemble.fit)})
    return plan.model_copy(update=placed)
