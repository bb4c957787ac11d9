"""What a changed scenario is called: the name of what it was, and what was changed."""

import unicodedata
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from helimag import quantities as q
from helimag.scenario._leaves import Leaf

if TYPE_CHECKING:
    from helimag.scenario._scenario import Scenario

MOST_TOLD = 2  # changes; of more, only their number


def titled(scenario: "Scenario", origin: "Scenario | None") -> str:
    """The scenario's name; where it differs from what had that name, with what was changed.

    Parameters
    ----------
    origin
        What it was changed from, unless it has the name of a preset, which says itself what it was; None if unchanged.
    """
    preset = _preset(scenario.name)
    was, name = (origin, scenario.name) if preset is None else (preset, preset.name)
    if was is None or was.name != name or was.hash == scenario.hash:
        return name
    found = [_told(path, scenario, was) for path in _changed(was.decisive, scenario.decisive)]
    what = ", ".join(found) if len(found) <= MOST_TOLD else f"{len(found)} changes"
    return f"{name}, {what}"


@lru_cache(maxsize=32)
def _preset(name: str) -> "Scenario | None":
    """The preset that a name calls up in who reads it: that name, however it is spelt, or a title made of it."""
    from helimag.scenario._files import load, preset_names

    seen = "".join(sign for sign in unicodedata.normalize("NFKC", name) if unicodedata.category(sign) != "Cf")
    read = "".join(seen.casefold().split(",")[0].split())
    return load(read) if read in preset_names() else None


def _changed(one: Any, other: Any, path: str = "") -> Iterator[str]:
    """Paths of the fields that differ in two scenarios' nested values; a vector is one field."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        for key in dict.fromkeys([*one, *other]):
            yield from _changed(one.get(key), other.get(key), f"{path}.{key}" if path else str(key))
    elif _parts(one) and _parts(other) and len(one) == len(other):
        for index, (mine, yours) in enumerate(zip(one, other, strict=True)):
            yield from _changed(mine, yours, path if len(one) == 1 else f"{path}.{index}")
    elif one != other:
        yield path


def _parts(value: Any) -> bool:
    """Whether a value is a list of parts, as magnets are."""
    return isinstance(value, (list, tuple)) and bool(value) and isinstance(value[0], Mapping)


def _told(path: str, scenario: "Scenario", was: "Scenario") -> str:
    """A field and its new value, as briefly as tells it from the old one."""
    new, old = _found(scenario, path), _found(was, path)
    texts = _text(new, 5), _text(old, 5)
    return f"{path} {texts[0] if texts[0] != texts[1] else _text(new, 17)}"


def _found(scenario: "Scenario", path: str) -> Leaf | None:
    """Where the path leads; None where the scenario does not have it."""
    at: Leaf = Leaf.of(scenario, type(scenario))
    for step in path.split("."):
        if step not in at.names:
            return None
        at = at.step(step)
    return at


def _text(found: Leaf | None, digits: int) -> str:
    if found is None or found.value is None:
        return "none"
    if found.number:
        return _number(found, digits)
    if found.components:
        numbers = [_number(found.step(name), digits) for name in found.components]
        return f"({', '.join(numbers)})"
    return str(found.value) if isinstance(found.value, str) else "given"


def _number(found: Leaf, digits: int) -> str:
    if found.kind is None:
        return f"{found.value:.{digits}g}"
    return f"{found.value / q.parse(f'1 {found.kind.shown}', found.kind):.{digits}g} {found.kind.shown}"
