"""The two files of a KRL programme."""

from pathlib import Path

from helimag.files import text_of


def krl_texts(source: str | Path) -> tuple[str, str]:
    """Texts of a .src file and of the .dat file beside it, which may be missing.

    Raises
    ------
    FileError
        Where a file cannot be read.
    InputError
        Where a file is not text.
    """
    path = Path(source)
    beside = path.with_suffix(".dat")
    return text_of(path), text_of(beside) if beside.exists() else ""
