"""Commands that draw: plot, reproduce."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from helimag.cli._shared import Json, check_target, print_json, progress_bar
from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.reproduce import Fig4, Reproduction


def plot(
    run: Path,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    animate: Path | None = None,
) -> None:
    """Draw a run's path and time series or an animation, a sweep's gains and verdicts, or a calibration.

    Parameters
    ----------
    run
        A trajectory file, such as simulate wrote with -o, or a sweep's store (.zarr), or what
        calibrate wrote.
    output
        Figure to write: .png, .svg or .pdf, of a sweep also .html. Default: the run's name with .png.
    animate
        Film to write instead: .mp4.
    """
    if run.suffix == ".zarr" or run.is_dir():
        from helimag.cli.sweeps import plot_sweep

        plot_sweep(run, output)
        return
    target = output or (run.with_suffix(".png") if animate is None else None)
    for path in (target, animate):
        if path is not None:
            check_target(path)
    from helimag import plots
    from helimag.calibration import Posterior, is_fit
    from helimag.runs.trajectory import Trajectory

    if is_fit(run):
        if animate is not None or target is None:
            raise InputError("--animate films a run; a calibration is drawn as a figure")
        plots.save(plots.draw_fit(Posterior.load(run)), target)
        print(target)
        return
    try:
        trajectory = Trajectory.load(run)
    except InputError as error:
        raise InputError(
            f"{error}; plot draws what simulate, robot replay, vision or calibrate wrote, and sweeps"
        ) from None
    if animate is not None:
        with progress_bar(f"filming {run.name}") as progress:
            plots.animate(trajectory, animate, progress=progress)
        print(animate)
    if target is not None:
        plots.save(plots.draw_run(trajectory), target)
        print(target)


def reproduce(
    what: Literal["fig3", "fig4", "fig5", "table1"],
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    json: Json = False,
) -> None:
    """Compute a figure or table of the paper and print it beside the published values.

    Parameters
    ----------
    what
        Which figure or table.
    output
        Folder for the figure, the table and the runs; without one, nothing is kept.
    """
    if what == "fig4" and output is None:
        raise InputError("--output must name a folder for fig4: its sweeps take minutes and go on there if interrupted")
    from helimag.reproduce import Fig4

    with tempfile.TemporaryDirectory() as idle:
        made = _reproduced(what, Path(idle) if output is None else output)
    files = [] if output is None else [str(path) for path in made.files]
    if json:
        told = {"trends": made.trends} if isinstance(made, Fig4) else {"comparison": made.comparison}
        print_json({"rows": made.rows, **told, "files": files})
        return
    print(made.text)
    if files:
        print(f"written to {', '.join(files)}")


def _reproduced(what: str, folder: Path) -> "Reproduction | Fig4":
    from helimag import reproduce as book

    with progress_bar(f"reproducing {what}") as progress:
        if what == "fig4":
            return book.fig4(folder, progress=progress)
        return {"fig3": book.fig3, "fig5": book.fig5, "table1": book.table1}[what](folder, progress=progress)
