"""Frozen models read from TOML."""

from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from helimag.errors import InputError
from helimag.files import text_of, toml_tables
from helimag.scenario import Part, messages

Model = TypeVar("Model", bound=Part)


def named_tables(path: Path, what: str) -> dict[str, Any]:
    """TOML of a file that might have been a name instead.

    Raises
    ------
    FileError
        Where there is no such file, or it cannot be read.
    InputError
        Where it is not TOML.
    """
    neither = f"{what} must be a TOML file or a name that helimag knows; '{path}' is neither"
    return toml_tables(text_of(path, missing=neither), str(path))


def packaged(name: str) -> Traversable | None:
    """The file of this name that comes with helimag, None where there is none."""
    folder = resources.files("helimag.robot") / "data"
    return next((file for file in folder.iterdir() if file.name == name), None)


def model_of(kind: type[Model], data: dict[str, Any], source: str) -> Model:
    """A model of tables that a file holds; ``source`` names it in messages.

    Raises
    ------
    InputError
        Where the tables are no such model.
    """
    try:
        return kind.model_validate(data, context={"file": True})
    except ValidationError as error:
        raise InputError(f"{source}: {'; '.join(messages(error))}") from None
