"""The scenario as a whole: a frozen model with its rules, changed copies, a hash and its text."""

import hashlib
import unicodedata
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, Field, ValidationError, model_validator

from helimag import quantities as q
from helimag.errors import InputError
from helimag.notebook import summary
from helimag.scenario._device import Device, Part
from helimag.scenario._fields import UNDECIDING
from helimag.scenario._leaves import leaf, nowhere
from helimag.scenario._refusals import messages
from helimag.scenario._surroundings import Drive, Fluid, Magnet, Run, Workspace
from helimag.scenario._titles import titled

ORIGIN = "_origin"  # beside the fields, and none of them: what a scenario was changed from says nothing of what it is
UNWRITTEN = {"Cc", "Cs", "Zl", "Zp"}  # categories of characters that no name in a figure, file or terminal holds
MARKS = ("published", "fitted", "assumed", "measured")


def _as_list(value: object) -> object:
    return [value] if isinstance(value, Mapping) else value


def _writable(name: str) -> str:
    """The name, of characters that can be written everywhere."""
    if any(unicodedata.category(character) in UNWRITTEN for character in name):
        raise InputError(f"must be one line without control characters; got {name!a}")
    return name


def _marked(provenance: dict[str, str]) -> dict[str, str]:
    """Sources of values, each of which says of what kind it is."""
    for key, mark in provenance.items():
        if mark.partition(":")[0] not in MARKS:
            raise InputError(f".{key} must begin with one of {', '.join(MARKS)} and a colon; got '{mark}'")
    return provenance


class Scenario(Part):
    """Everything a run needs. Frozen; :meth:`replaced` gives a changed copy."""

    name: Annotated[str, AfterValidator(_writable)] = "unnamed"
    """What runs of it are called; what was changed since is added by itself."""
    device: Device
    """What swims: a table ``[device]``."""
    fluid: Fluid
    """What it swims in: a table ``[fluid]``."""
    magnet: Annotated[tuple[Magnet, ...], BeforeValidator(_as_list), Field(min_length=1)]
    """The rotating magnet: a table ``[magnet]``, or several ``[[magnet]]`` that turn as one."""
    drive: Drive
    """What arm and motor do, and where the device begins: a table ``[drive]``."""
    workspace: Workspace = Workspace()
    """What ends or holds it: a table ``[workspace]``."""
    run: Run = Run()
    """How long: a table ``[run]``."""
    provenance: Annotated[dict[str, str], AfterValidator(_marked)] = {}
    """Where values come from: a table ``[provenance]``."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if any(magnet.field != self.magnet[0].field for magnet in self.magnet[1:]):
            raise InputError("magnet: all magnets must have the same field model")
        if self.drive.distance <= self.contact_distance:
            got = q.show(self.drive.distance, q.LENGTH)
            least = q.show(round(self.contact_distance, 7), q.LENGTH)
            raise InputError(f"drive.distance must exceed {least}, where device and magnet touch; got '{got}'")
        for axis, low, here, high in zip(
            "xyz", self.workspace.box[0], self.drive.start, self.workspace.box[1], strict=True
        ):
            if not low < here < high:
                raise InputError(f"drive.start must be inside the workspace; its {axis} is {q.show(here, q.LENGTH)}")
        path = self.drive.path
        if path is not None and self.run.duration > path.duration:
            got, most = q.show(self.run.duration, q.TIME), q.show(path.duration, q.TIME)
            raise InputError(f"run.duration must not exceed the end of drive.path, {most}; got '{got}'")
        return self

    @property
    def contact_distance(self) -> float:
        """Distance between the centres of head and magnet at which the device is taken to touch (m)."""
        return max(magnet.reach for magnet in self.magnet) + self.device.head_radius

    @property
    def decisive(self) -> dict[str, Any]:
        """All that decides the run, nested, as Python values; names, provenance and uncertainties do not."""
        idle: Any = {"name": True, "provenance": True, "magnet": {"__all__": UNDECIDING}}
        return self.model_dump(mode="python", exclude=idle, exclude_none=True)

    @property
    def hash(self) -> str:
        """SHA-256 of all that decides the run, as JSON with sorted keys: put together from that of its parts."""
        magnets = ", ".join([magnet.canonical for magnet in self.magnet])
        whole = (
            f'{{"device": {self.device.canonical}, "drive": {self.drive.canonical}, "fluid": {self.fluid.canonical}, '
            f'"magnet": [{magnets}], "run": {self.run.canonical}, "workspace": {self.workspace.canonical}}}'
        )
        return hashlib.sha256(whole.encode()).hexdigest()

    @property
    def title(self) -> str:
        """The name, and what was changed since something had that name: what is run is called by it everywhere.

        Examples
        --------
        >>> import helimag as hm
        >>> hm.load("paper/fig3c").replaced({"drive.pitch": "15 deg"}).title
        'paper/fig3c, drive.pitch 15 deg'
        """
        return titled(self, self.__dict__.get(ORIGIN))

    def __repr__(self) -> str:
        from helimag.scenario.inputs import drive_inputs

        return f"<Scenario {self.title}: {drive_inputs(self)}>"

    def _repr_html_(self) -> str:
        """For notebooks: what is driven, how, and where its values come from."""
        from helimag.scenario.inputs import drive_inputs

        sources = {mark: ", ".join(k for k, v in self.provenance.items() if v.startswith(f"{mark}:")) for mark in MARKS}
        told = {"drive": drive_inputs(self), "hash": self.hash[:12]}
        return summary(self.title, told | {mark: paths for mark, paths in sources.items() if paths})

    def replaced(self, changes: Mapping[str, object]) -> "Scenario":
        """Copy with fields changed, each named by its dotted path, such as ``{"drive.pitch": "15 deg"}``.

        A component of a vector is named too (``drive.start.y``, ``workspace.walls.x.low``), and one of several magnets
        by its index (``magnet.1.moment``); a single magnet has none.

        Returns
        -------
        Scenario
            A new one, checked as a file is; this one stays as it is.

        Raises
        ------
        InputError
            Where a path does not exist or a value does not fit.

        Examples
        --------
        >>> import helimag as hm
        >>> slower = hm.load("paper/fig3c").replaced({"drive.pitch": "15 deg", "drive.frequency": 2.5})
        >>> round(slower.drive.pitch, 4)  # rad
        0.2618
        >>> hm.load("paper/fig3c").replaced({"drive.pitch": "15"})
        Traceback (most recent call last):
        helimag.errors.InputError: drive.pitch must be an angle such as '12.7 deg'; got '15', which has no unit
        """
        provenance = _apart(tuple(self.provenance.items()), tuple(changes))
        try:
            values = {"provenance": provenance, **self.checked(changes)}
            changed = Scenario.model_validate(self.with_values(values))
        except ValueError:  # or a place in a list; the whole is checked, which says all that is wrong and where
            changed = self._replaced_as_a_whole(provenance, changes)
        if changed.name == self.name:
            changed.__dict__[ORIGIN] = self.__dict__.get(ORIGIN, self)
        return changed

    def _replaced_as_a_whole(self, provenance: Mapping[str, str], changes: Mapping[str, object]) -> "Scenario":
        """The same with all values of the parts that change checked as a file's."""
        touched = {path.partition(".")[0] for path in changes} & Scenario.model_fields.keys()
        data = {name: getattr(self, name) for name in Scenario.model_fields} | {"provenance": provenance}
        data |= self.model_dump(mode="python", include=touched - {"provenance"})
        for path, value in changes.items():
            self._assign(data, path, value)
        return validated(data, in_file=False)

    def _assign(self, data: dict[str, Any], path: str, value: object) -> None:
        """Set the entry of the scenario's own nested data that a dotted path names."""
        at: Any = data
        steps = path.split(".")
        for depth, step in enumerate(steps):
            key = self._key(at, steps, depth)
            if depth == len(steps) - 1:
                at[key] = value
                return
            if isinstance(at[key], (list, tuple)):
                at[key] = list(at[key])
            at = at[key]
            if step == "magnet" and len(at) == 1:
                at = at[0]

    def _key(self, at: Any, steps: Sequence[str], depth: int) -> str | int:
        """Key or index of a step of a path within the data that it has led to."""
        path, step, parent = ".".join(steps), steps[depth], ".".join(steps[:depth])
        if isinstance(at, dict) and step in at:
            return step
        if isinstance(at, list):
            names = tuple(str(i) for i in range(len(at))) if parent == "magnet" else leaf(self, parent).components
            if step in names:
                return names.index(step)
            raise nowhere(path, depth, names, kind=Scenario)
        raise nowhere(path, depth, tuple(at) if isinstance(at, dict) else (), given=at is not None, kind=Scenario)

    def to_toml(self) -> str:
        """The scenario as a file's text, in which every value carries its unit.

        Returns
        -------
        str
            Which :func:`helimag.load` reads from a file as the same scenario.
        """
        import tomli_w

        data = _without_none(self.model_dump(mode="json"))
        if len(self.magnet) == 1:
            data["magnet"] = data["magnet"][0]
        return tomli_w.dumps(data)


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        kept = {key: _without_none(item) for key, item in value.items() if item is not None}
        return {key: item for key, item in kept.items() if item != {}}
    if isinstance(value, list):
        return [_without_none(item) for item in value]
    return value


@lru_cache(maxsize=64)  # the same marks and paths for every run of a sweep
def _apart(marks: Sequence[tuple[str, str]], paths: Sequence[str]) -> dict[str, str]:
    """The marks that speak of none of the paths."""
    return {key: mark for key, mark in marks if not any(_overlap(key, path) for path in paths)}


def _overlap(one: str, other: str) -> bool:
    """Whether one of two dotted paths lies within the other, so that a mark on the one speaks of the other.

    A mark on ``magnet.moment`` speaks of every magnet's.
    """
    one, other = (".".join(step for step in path.split(".") if not step.isdigit()) + "." for path in (one, other))
    return one.startswith(other) or other.startswith(one)


def validated(data: Mapping[str, object], *, in_file: bool) -> Scenario:
    try:
        return Scenario.model_validate(data, context={"file": in_file})
    except ValidationError as error:
        raise InputError("; ".join(messages(error, Scenario))) from None
    except UnicodeEncodeError as error:
        raise InputError(f"a scenario's text must be Unicode; got {ascii(error.object)[:60]}") from None
