"""What -o means in every command: files whose suffix decides what they hold, looked at before the work begins."""

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import BoundArguments
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from helimag.errors import FileError, InputError

if TYPE_CHECKING:
    from types import ModuleType

    import xarray
    from matplotlib.figure import Figure

    from helimag.plots import Size

OUTPUT = ("--output", "-o")
Outputs = Annotated[list[Path] | None, Parameter(name=OUTPUT, negative="", consume_multiple=False)]
Folder = Annotated[Path, Parameter(name=OUTPUT)]
FigureSize = Annotated[
    Literal["small", "print", "slide"] | None,
    Parameter(
        name="--size",
        help="Of figures: small (a paper's column, 88 mm), print (its page, 180 mm; if left out) or slide (16:9, with "
        "large words).",
    ),
]


@dataclass(frozen=True)
class Format:
    """What a file holds, by its suffix; ``also`` are older names of it, taken but not told."""

    suffixes: tuple[str, ...]
    what: str
    also: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{', '.join(self.suffixes)} ({self.what})"

    def fits(self, path: Path) -> bool:
        """Whether a path has one of the suffixes."""
        return path.suffix.lower() in (*self.suffixes, *self.also)


FIGURE = Format((".png", ".svg", ".pdf"), "a figure")
PAGE = Format((".html",), "an interactive page")
FILM = Format((".mp4",), "a film")
CLIP = Format((".mp4", ".avi"), "a clip")
DATA = Format((".nc",), "the data", also=(".nc4", ".h5"))
TABLE = Format((".csv",), "a table")
STORE = Format((".zarr",), "the store", also=("",))
SCENARIO = Format((".toml",), "the scenario")
RIG = Format((".json",), "the rig")

Writer = Callable[[Path], object]


def check_outputs(
    paths: Sequence[Path] | None, *formats: Format, size: FigureSize = None, option: str = "--output"
) -> None:
    """Refuse, before any work, what is none of ``formats`` or cannot be written, figures without matplotlib, and films
    without PyAV; ``option`` is what named the paths.

    Raises
    ------
    InputError
        Where a suffix is none of those, a file is named twice, or a size is asked for and no figure.
    FileError
        Where a file could not be written.
    MissingExtra
        Where what draws is not installed.
    """
    for path in paths or ():
        if not any(format.fits(path) for format in formats):
            raise InputError(f"{option} must end in {' or '.join(map(str, formats))}; got '{path}'")
        if STORE.fits(path):
            check_folder(path)
        else:
            check_target(path)
    if len(set(paths or ())) < len(paths or ()):
        raise InputError(f"{option} names '{_repeated(paths or ())}' twice")
    if size is not None and not any(FIGURE.fits(path) for path in paths or ()):
        raise InputError(f"--size is for figures: --output must name one, {FIGURE}; or leave --size out")
    if any(FIGURE.fits(path) or FILM.fits(path) or PAGE.fits(path) for path in paths or ()):
        from helimag import plots

        if any(FILM.fits(path) for path in paths or ()):
            plots.check_filming()


def check_not_read(bound: BoundArguments) -> None:
    """Refuse an output that is one of the files which a command was given to read: it would be gone.

    Raises
    ------
    InputError
        Naming it.
    """
    given = dict(bound.arguments)
    named = given.pop("output", None) or []
    read = [path for value in given.values() for path in _paths(value)]
    for output in named if isinstance(named, list) else [named]:
        if any(_same(output, path) for path in read):
            raise InputError(f"--output names '{output}', which this command reads; name another file")


def _paths(value: object) -> Iterator[str | Path]:
    """What may be a file's name in the value of an argument."""
    if isinstance(value, (str, Path)):
        yield value
    elif isinstance(value, (list, tuple)):
        for each in value:
            yield from _paths(each)


def _same(one: str | Path, other: str | Path) -> bool:
    try:
        return Path(one).samefile(other)
    except (OSError, ValueError):  # not there, or no name of a file
        return False


def _repeated(paths: Iterable[Path]) -> Path:
    seen: set[Path] = set()
    return next(path for path in paths if path in seen or seen.add(path))  # type: ignore[func-returns-value]


def the_one(paths: Sequence[Path] | None, format: Format) -> Path:
    """The only path of a format, without which there is nothing to do.

    Raises
    ------
    InputError
        Where there is none, or more than one.
    """
    found = [path for path in paths or () if format.fits(path)]
    if len(found) != 1:
        got = ", ".join(f"'{path}'" for path in found) or "none"
        raise InputError(f"--output must name one file that ends in {format}; got {got}")
    return found[0]


def check_target(path: Path) -> None:
    """Refuse a file that cannot be written.

    Raises
    ------
    FileError
        Where it is a folder, or no file can be made beside it.
    """
    if path.is_dir():
        raise FileError(f"{path} is a directory; name a file in it")
    _check_parent(path)


def check_folder(path: Path) -> None:
    """Refuse a folder that cannot be made or takes no files.

    Raises
    ------
    FileError
        Where it is a file, the folder that it is to be made in is not there, or no file can be made in it.
    """
    if path.is_dir():
        _check_takes_files(path, path)
    elif path.exists():
        raise FileError(f"{path} is a file; name a folder")
    else:
        _check_parent(path)


def _check_parent(path: Path) -> None:
    if not path.parent.is_dir():
        raise FileError(f"{path} cannot be written: there is no folder '{path.parent}'")
    _check_takes_files(path.parent, path)


def _check_takes_files(folder: Path, path: Path) -> None:
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror}") from None


def write_outputs(paths: Sequence[Path] | None, writers: Mapping[Format, Writer], *, size: FigureSize = None) -> None:
    """Write each path with the writer of its format, figures in a size."""
    for path in paths or ():
        write = next(write for format, write in writers.items() if format.fits(path))
        if isinstance(write, Drawing):
            write(path, size or "print")
        else:
            write(path)


@dataclass(frozen=True)
class Drawing:
    """A writer of figures, which draws once with :mod:`helimag.plots`, however many files there are."""

    draw: "Callable[[ModuleType, Size], Figure]"
    made: "list[Figure]" = field(default_factory=list)

    def __call__(self, path: Path, size: "Size" = "print") -> None:
        from helimag import plots

        if not self.made:
            self.made.append(self.draw(plots, size))
        plots.save(self.made[0], path)
        self.made[0].set_layout_engine("none")  # laid out once: every file shows the same


def stored(dataset: "Callable[[], xarray.Dataset]") -> Writer:
    """A writer of datasets about orbits."""

    def write(path: Path) -> None:
        from helimag.orbits import save_dataset

        save_dataset(dataset(), path)

    return write


def files_report(paths: Iterable[Path] | None) -> dict[str, Any]:
    """What was written, for a JSON object."""
    return {"files": [str(path) for path in paths or ()]}


def print_files(paths: Iterable[Path] | None) -> None:
    """What was written, a line each: the same words in every command."""
    for path in paths or ():
        print(f"  written to    {path}")
