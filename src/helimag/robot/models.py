"""TOML that comes with helimag under a name, or lies in a file."""

from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from helimag.files import text_of, toml_tables


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
