"""Commands that draw: plot, reproduce."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from helimag.cli._common import PLAIN, Common
from helimag.cli._outputs import (
    FIGURE,
    FILM,
    OUTPUT,
    PAGE,
    Drawing,
    FigureSize,
    Format,
    Outputs,
    Writer,
    check_folder,
    check_outputs,
    files_report,
    print_files,
    write_outputs,
)
from helimag.cli._shared import print_json, progress_bar
from helimag.cli.runs import run_writers
from helimag.cli.sweeps import sweep_writers
from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.plots import Size
    from helimag.reproduce import Fig4, Reproduction

MAKERS = "simulate, robot replay, vision, orbit, sweep, calibrate or robot program"


def plot(
    file: Path,
    *,
    output: Annotated[Outputs, Parameter(name=[*OUTPUT, "--animate"])] = None,
    size: FigureSize = None,
    common: Common = PLAIN,
) -> None:
    """Draw what another command wrote: a run, a sweep, orbits, a map, a flow, a basin, a calibration, a robot's path.

    Parameters
    ----------
    file
        What simulate, robot replay, vision, orbit, calibrate or sweep wrote with -o; or the timed path (.csv) that
        robot program wrote.
    output
        Write a figure (.png, .svg, .pdf) to this file; of a sweep also an interactive page (.html), of a run a film
        (.mp4). May be repeated. Left out: a .png beside the file, with its name.
    """
    named = file if file.name else file.resolve()
    if not output and not named.name:
        raise InputError(f"{file} is no file, and has no name that its figure could have; name one with --output")
    output = output or [named.with_suffix(".png")]
    check_outputs(output, FIGURE, PAGE, FILM, size=size)
    what, writers = _opened(file)
    for path in output:
        if not any(format.fits(path) for format in writers):
            known = " or ".join(str(format) for format in writers if format in (FIGURE, PAGE, FILM))
            raise InputError(f"--output must end in {known} for {what}; got '{path}'")
    with progress_bar(f"drawing {file.name}"):
        write_outputs(output, writers, size=size)
    if common.json:
        print_json({"drawn": str(file), "as": what} | files_report(output))
        return
    print(f"{file}: {what}")
    print_files(output)


def _opened(path: Path) -> tuple[str, dict[Format, Writer]]:
    """What a file holds, in words, and what can be drawn of it."""
    if path.suffix == ".zarr" or path.is_dir():
        from helimag.sweeps import load_sweep

        return "a sweep", sweep_writers(load_sweep(path))
    if path.suffix.lower() == ".csv":
        from helimag.robot import read_timed

        table = read_timed(path)
        return "a robot's path", {FIGURE: Drawing(lambda plots, size: plots.draw_timed(table, path.stem, size=size))}
    if path.suffix.lower() in (".json", ".toml", ".mp4", ".src"):
        raise InputError(f"{path} holds nothing to draw: plot draws what {MAKERS} wrote")
    return _opened_netcdf(path)


def _opened_netcdf(path: Path) -> tuple[str, dict[Format, Writer]]:
    from helimag.calibration import Posterior, is_fit
    from helimag.orbits import content_of
    from helimag.runs import read_netcdf
    from helimag.runs.trajectory import Trajectory

    if is_fit(path):
        fit = Posterior.load(path)
        return "a calibration", {FIGURE: Drawing(lambda plots, size: plots.draw_fit(fit, size=size))}
    dataset = read_netcdf(path)
    if "plan" in dataset.attrs:
        from helimag.sweeps import swept_in

        return "a sweep", sweep_writers(swept_in(dataset))
    content = content_of(dataset)
    if content is not None:
        return content.value, {FIGURE: _known(path, dataset)}
    try:
        run = Trajectory.load(path)
    except InputError as error:
        raise InputError(f"{error}; plot draws what {MAKERS} wrote") from None
    return "a run", run_writers(run)


def _known(path: Path, dataset: Any) -> Writer:
    """A writer of figures of a dataset about orbits, which is looked at before the figure is made."""
    from helimag.orbits import known_in

    try:
        known = known_in(dataset)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None

    return Drawing(lambda plots, size: plots.draw_known(known, size=size))


def reproduce(
    what: Literal["fig3", "fig4", "fig5", "table1"],
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    size: FigureSize = None,
    common: Common = PLAIN,
) -> None:
    """Compute a figure or table of the paper and print it beside the published values.

    Parameters
    ----------
    what
        Which figure or table.
    output
        Folder for the figure, the table and the runs, made where there is none; without one, nothing is kept.
    """
    if what == "fig4" and output is None:
        raise InputError("--output must name a folder for fig4: its sweeps take minutes and go on there if interrupted")
    if output is not None:
        check_folder(output)
    elif size is not None:
        raise InputError("--size is for figures: --output must name a folder for them; or leave --size out")
    from helimag.reproduce import Fig4

    with tempfile.TemporaryDirectory() as idle:
        made = _reproduced(what, Path(idle) if output is None else output, size or "print")
    files = [] if output is None else made.files
    if common.json:
        told = {"trends": made.trends} if isinstance(made, Fig4) else {"comparison": made.comparison}
        print_json({"rows": made.rows, **told} | files_report(files))
        return
    print(made.text)
    print_files(files)


def _reproduced(what: str, folder: Path, size: "Size") -> "Reproduction | Fig4":
    from helimag import reproduce as book

    with progress_bar(f"reproducing {what}") as progress:
        if what == "fig4":
            return book.fig4(folder, size=size, progress=progress)
        return {"fig3": book.fig3, "fig5": book.fig5, "table1": book.table1}[what](folder, size=size, progress=progress)
