"""What a frozen model finds wrong with data, as one clear line."""

import difflib
import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeVar, get_args

from pydantic import BaseModel, ValidationError

from helimag.errors import InputError

Model = TypeVar("Model", bound=BaseModel)

LIKE = 0.7  # a word that is meant for another has so much of it, by difflib's measure
LONGEST = 60  # characters of a refused value that a message shows
FORMS = {"sphere", "spheroid", "cylinder", "end", "angles"}  # of a head and of a heading: no keys of a file


def meant(word: str, known: Iterable[str]) -> str:
    """What was perhaps meant by a word that is not known, to end a message; nothing where none is alike."""
    by_small = {name.lower(): name for name in known}
    found = difflib.get_close_matches(word.lower(), by_small, n=1, cutoff=LIKE)
    return f"; did you mean {by_small[found[0]]}?" if found else ""


def models_in(annotation: object) -> Iterator[type[BaseModel]]:
    """The parts that a field's type names."""
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from models_in(inner)


def field_paths(kind: type[BaseModel], before: str = "") -> Iterator[str]:
    """Every field of a model and of its parts, as dotted paths; a list's entries without their index."""
    for key, field in kind.model_fields.items():
        yield f"{before}{key}"
        for inner in models_in(field.annotation):
            yield from field_paths(inner, f"{before}{key}.")


def _keys(kind: type[BaseModel], steps: Sequence[int | str]) -> set[str]:
    """Keys that a part of a model may have, the part by its place: keys, numbers in lists, words that choose a form."""
    parts = [kind]
    for step in steps:
        fields = [part.model_fields[str(step)] for part in parts if step in part.model_fields]
        below = [inner for field in fields for inner in models_in(field.annotation)]
        parts = below or [part for part in parts if _chosen_by(part, step)] or parts
    return {key for part in parts for key in part.model_fields}


def _chosen_by(part: type[BaseModel], word: int | str) -> bool:
    """Whether a part is the form of a union that a word chooses, such as ``shape = "sphere"``."""
    return any(word in get_args(field.annotation) for field in part.model_fields.values())


def messages(error: ValidationError, kind: type[BaseModel]) -> Iterator[str]:
    """One line a problem with a model of that kind, naming field, expectation and value."""
    problems = error.errors()
    for problem in problems:
        if problem["type"] == "too_short" and any(_within(other["loc"], problem["loc"]) for other in problems):
            continue  # an entry that is refused is not counted, and its own line says why
        steps = [str(step) for step in problem["loc"]]
        kept = [step for i, step in enumerate(steps) if not (step in FORMS and i == 2)]
        where = ".".join([*kept, ""]).replace("magnet.0.", "magnet.").removesuffix(".")
        text = problem["msg"].removeprefix("Value error, ")
        match problem["type"]:
            case "missing":
                yield f"{where} is missing"
            case "extra_forbidden":
                *place, key = problem["loc"]
                yield f"{where} is not a known key; got {_short(problem['input'])}{meant(str(key), _keys(kind, place))}"
            case "value_error":
                # rules of a whole part name the field at fault with a leading dot
                yield f"{where}{text}" if text.startswith(".") else f"{where} {text}".strip()
            case _:
                yield f"{where}: {text[0].lower()}{text[1:]}; got {_short(problem['input'])}"


def _within(inner: tuple[int | str, ...], outer: tuple[int | str, ...]) -> bool:
    return len(inner) > len(outer) and inner[: len(outer)] == outer


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def model_of(kind: type[Model], data: Mapping[str, object], source: str) -> Model:
    """A model of tables that a file holds; ``source`` names it in messages.

    Returns
    -------
    Model
        Checked.

    Raises
    ------
    InputError
        Where the tables are no such model.
    """
    try:
        return kind.model_validate(data, context={"file": True})
    except ValidationError as error:
        raise InputError(f"{source}: {'; '.join(messages(error, kind))}") from None
