"""The two files of a KRL programme."""

from pathlib import Path

from helimag.errors import FileError, InputError
from helimag.files import bytes_of


def krl_texts(source: str | Path) -> tuple[str, str]:
    """Texts of a .src file and of the .dat file beside it, which may be missing; capitals in the names do not matter.

    The code itself is ASCII; comments are written in whatever encoding the editor had, and are not looked at.

    Returns
    -------
    tuple of str
        Of .src and .dat; the latter empty where there is none.

    Raises
    ------
    FileError
        Where a file cannot be read, or there are two .dat files to choose from.
    InputError
        Where a file is not text.
    """
    path = Path(source)
    src = _text(path)
    try:
        beside = [other for other in path.parent.iterdir() if other.name.lower() == f"{path.stem}.dat".lower()]
    except OSError as error:
        raise FileError(f"{path.parent} cannot be read: {error.strerror or error}") from None
    if len(beside) > 1:
        names = " and ".join(sorted(other.name for other in beside))
        raise FileError(f"there must be one .dat file beside '{path}'; there are {names}")
    return src, _text(beside[0]) if beside else ""


def _text(path: Path) -> str:
    data = bytes_of(path)
    if b"\0" in data:
        raise InputError(f"{path} is not a text file")
    return data.decode("utf-8-sig" if data.startswith(b"\xef\xbb\xbf") else "latin-1")
