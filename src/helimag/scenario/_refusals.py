"""What a frozen model finds wrong with data, as one clear line."""

from collections.abc import Iterator, Mapping
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from helimag.errors import InputError

Model = TypeVar("Model", bound=BaseModel)

LONGEST = 60  # characters of a refused value that a message shows
FORMS = {"sphere", "spheroid", "cylinder", "end", "angles"}  # of a head and of a heading: no keys of a file


def messages(error: ValidationError) -> Iterator[str]:
    """One line a problem, naming field, expectation and value."""
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
                yield f"{where} is not a known key; got {_short(problem['input'])}"
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
        raise InputError(f"{source}: {'; '.join(messages(error))}") from None
