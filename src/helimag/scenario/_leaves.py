"""Where a dotted path leads in a scenario: through its parts, by index to one of several magnets, to a component."""

import types
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel

from helimag import quantities as q
from helimag.errors import InputError
from helimag.scenario._fields import Quantity
from helimag.scenario._refusals import field_paths, meant

COMPONENTS = {2: ("low", "high"), 3: ("x", "y", "z")}


@dataclass(frozen=True)
class Leaf:
    """What a path leads to: its value, the type it is declared with and its marks, and the part it is a field of."""

    value: Any
    declared: Any
    marks: tuple[Any, ...] = ()
    part: BaseModel | None = None

    @classmethod
    def of(cls, value: Any, declared: Any, marks: Sequence[Any] = (), part: BaseModel | None = None) -> "Leaf":
        """A leaf whose type is laid open: without the None of an optional one, its marks beside it."""
        if get_origin(declared) in {Union, types.UnionType}:
            present = [arg for arg in get_args(declared) if arg is not type(None)]
            declared = present[0] if len(present) == 1 else declared
        if get_origin(declared) is Annotated:
            declared, *more = get_args(declared)
            marks = (*marks, *more)
        return cls(value, declared, tuple(marks), part)

    @property
    def kind(self) -> q.Kind | None:
        """Physical kind; None of a plain number and of what is no number."""
        return next((mark.kind for mark in self.marks if isinstance(mark, Quantity)), None)

    @property
    def number(self) -> bool:
        """Whether it is a single number, present or not."""
        return self.kind is not None or self.declared in (float, int)

    @property
    def choices(self) -> tuple[str, ...]:
        """The words among which it is chosen; none where it is no such field."""
        forms = get_args(self.declared) if get_origin(self.declared) in {Union, types.UnionType} else (self.declared,)
        bare = [get_args(form)[0] if get_origin(form) is Annotated else form for form in forms]
        return tuple(word for form in bare if get_origin(form) is Literal for word in get_args(form))

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components of a vector or range; none of anything else."""
        args = get_args(self.declared)
        if get_origin(self.declared) is not tuple or not all(Leaf.of(None, arg).number for arg in args):
            return ()
        return COMPONENTS.get(len(args), ())

    @property
    def names(self) -> tuple[str, ...]:
        """What is one step further; nothing below what is not given."""
        value = self._inner
        if isinstance(value, BaseModel):
            return tuple(type(value).model_fields)
        if isinstance(value, tuple) and value and isinstance(value[0], BaseModel):
            return tuple(str(i) for i in range(len(value)))
        return () if value is None else self.components

    def step(self, name: str) -> "Leaf":
        """The place one step further, by one of :attr:`names`."""
        value = self._inner
        if isinstance(value, BaseModel):
            field = type(value).model_fields[name]
            return Leaf.of(getattr(value, name), field.annotation, field.metadata, value)
        if isinstance(value[0], BaseModel):
            return Leaf(value[int(name)], type(value[int(name)]))
        index = self.components.index(name)
        return Leaf.of(value[index], get_args(self.declared)[index])

    @property
    def _inner(self) -> Any:
        """The value; a single magnet, which needs no index, for its list."""
        single = isinstance(self.value, tuple) and len(self.value) == 1 and isinstance(self.value[0], BaseModel)
        return self.value[0] if single else self.value


def leaf(root: BaseModel, path: str) -> Leaf:
    """Where a path leads.

    Raises
    ------
    InputError
        Where there is nothing under that path.
    """
    found, steps = Leaf(root, type(root)), path.split(".")
    for depth, step in enumerate(steps):
        if step not in found.names:
            raise nowhere(path, depth, found.names, given=found.value is not None, kind=type(root))
        found = found.step(step)
    return found


def nowhere(path: str, depth: int, names: Sequence[str], *, given: bool = True, kind: type[BaseModel]) -> InputError:
    """The error for a path whose step at ``depth`` is none of the names that are there."""
    parent = ".".join(path.split(".")[:depth])
    if not given:
        return InputError(f"'{path}' needs {parent}, which is not given in this scenario; give it as a whole first")
    if names and names[0].isdigit():
        which = ", ".join(f"{parent}.{name}" for name in names)
        return InputError(f"'{path}' must name one of {len(names)} by its index: {which}")
    known = list(dict.fromkeys(field_paths(kind)))
    ending = [each for each in known if each.endswith(f".{path}")]
    hint = f"; did you mean {' or '.join(ending)}?" if ending else meant(path, known)
    return InputError(
        f"'{path}' is not a field of a scenario; {parent or 'it'} has {', '.join(names) or 'nothing below it'}{hint}"
    )


def numbers(found: Leaf, path: str = "") -> Iterator[tuple[str, Leaf]]:
    """Every single number at or below a place, given or not, with its path; samples of a magnet path are none."""
    if found.number:
        yield path, found
    for name in found.names:
        yield from numbers(found.step(name), f"{path}.{name}" if path else name)
