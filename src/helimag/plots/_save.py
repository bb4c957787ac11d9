"""Figures to files."""

from pathlib import Path

from matplotlib.figure import Figure

from helimag.errors import InputError
from helimag.files import replacing
from helimag.plots._style import styled

# what a format may say about when it was made is left out, so that the same run gives the same file
METADATA: dict[str, dict[str, None]] = {".png": {}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure.

    Parameters
    ----------
    figure
        Such as :func:`helimag.plots.draw_run` gives.
    path
        Ends in .png (300 dots an inch), .svg or .pdf.

    Raises
    ------
    InputError
        Where the suffix is another.
    FileError
        Where the file cannot be written; nothing is left behind.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in METADATA:
        raise InputError(f"a figure's file must end in {', '.join(METADATA)}; got '{path}'")
    with replacing(path) as beside, styled():
        figure.savefig(beside, format=suffix[1:], metadata=METADATA[suffix])
