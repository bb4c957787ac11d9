"""Files: written so that nobody ever finds half of one, and TOML read with one clear refusal."""

import csv
import io
import os
import stat
import tempfile
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from helimag.errors import FileError, InputError

MOST_PIPED = 2**28  # bytes that a pipe may give: it says of itself neither how many there are nor whether it ends
PART = ".part"  # what a file that is being written ends in
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "\uff1d", "\uff0b", "\uff0d", "\uff20")  # how one begins


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a new file beside ``path`` to write to, and rename it to ``path`` when the block has succeeded.

    Parameters
    ----------
    path
        Where the file shall be; its folder must exist.

    Yields
    ------
    Path
        An empty file in the same folder; gone again if the block fails.

    Raises
    ------
    FileError
        Where the file cannot be written; nothing is left behind, and what was at ``path`` before is still there.
    """
    target = Path(path)
    if target.is_dir():
        raise FileError(f"{path} is a directory; name a file in it")
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=PART)
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror}") from None
    os.close(handle)
    beside = Path(name)
    try:
        yield beside
        mask = os.umask(0)
        os.umask(mask)
        beside.chmod(0o666 & ~mask)
        beside.replace(target)
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        beside.unlink(missing_ok=True)


def discard_left(path: str | Path) -> None:
    """Remove what killed processes that were replacing ``path`` left beside it; only where no other does so now."""
    target = Path(path)
    if target.parent.is_dir():
        for left in target.parent.iterdir():
            middle = left.name.removeprefix(f".{target.name}.").removesuffix(PART)
            if left.name == f".{target.name}.{middle}{PART}" and "." not in middle:  # else it is of another's file
                left.unlink(missing_ok=True)


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Rows of cells as CSV. Text that a spreadsheet would carry out as a formula gets an apostrophe in front.

    None is an empty cell; numbers are written so that they read back as the same.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for row in rows:
        writer.writerow([_harmless(cell) if isinstance(cell, str) else cell for cell in row])
    return text.getvalue()


def _harmless(cell: str) -> str:
    plain = cell.replace("\r", " ")
    return f"'{plain}" if cell.startswith(FORMULA) else plain


def toml_tables(text: str, source: str) -> dict[str, Any]:
    """Read TOML text; ``source`` names it in messages.

    Returns
    -------
    dict
        Tables and values by key, as :mod:`tomllib` gives them.

    Raises
    ------
    InputError
        Where the text is not TOML, or holds what Python cannot (an integer of thousands of digits, arrays as deep).
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{source} is not valid TOML: {error}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source} cannot be read as TOML: {error}") from None


def text_of(path: str | Path, *, missing: str | None = None) -> str:
    """The text of a UTF-8 file; ``missing`` is what to say where there is none, if more than that.

    Returns
    -------
    str
        All of it.

    Raises
    ------
    FileError
        Where there is no such file, or it cannot be read.
    InputError
        Where it is not text.
    """
    try:
        return bytes_of(path, missing=missing).decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path} is not a text file") from None


def bytes_of(path: str | Path, *, missing: str | None = None) -> bytes:
    """The content of a file, or of a pipe with an end; ``missing`` is what to say where there is none.

    Returns
    -------
    bytes
        All of it.

    Raises
    ------
    FileError
        Where there is no such file, it cannot be read, is a device, which may never end, or a pipe that does not.
    """
    try:
        with Path(path).open("rb") as file:
            kind = os.fstat(file.fileno()).st_mode
            if stat.S_ISREG(kind):
                return file.read()
            if (stat.S_ISCHR(kind) or stat.S_ISBLK(kind)) and not file.isatty():
                raise FileError(f"{path} cannot be read: it is a device, and no file")
            content = file.read(MOST_PIPED + 1)
    except FileError:
        raise
    except FileNotFoundError:
        raise FileError(missing or f"there is no file '{path}'") from None
    except (OSError, ValueError) as error:
        raise FileError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > MOST_PIPED:
        raise FileError(f"{path} cannot be read: it is a pipe that gives more than {MOST_PIPED // 2**20} MB")
    return content
