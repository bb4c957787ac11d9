"""Commands that draw: plot, reproduce."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from helimag.cli._shared import Json, check_target, print_json, progress_bar


def plot(
    run: Path,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    animate: Path | None = None,
) -> None:
    """Draw a run's path and time series or an animation, or a sweep's gains and verdicts.

    Parameters
    ----------
    run
        A trajectory file, such as simulate wrote with -o, or a sweep's store (.zarr).
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
    from helimag.runs.trajectory import Trajectory

    trajectory = Trajectory.load(run)
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
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path(),
    json: Json = False,
) -> None:
    """Compute a figure or table of the paper and print it beside the published values.

    Parameters
    ----------
    what
        Which figure or table.
    output
        Folder for the figure, the table and the runs.
    """
    from helimag import reproduce as book

    with progress_bar(f"reproducing {what}") as progress:
        if what == "fig4":
            characterized = book.fig4(output, progress=progress)
            text, report = characterized.text, {"rows": characterized.rows, "trends": characterized.trends}
        else:
            made = {"fig3": book.fig3, "fig5": book.fig5, "table1": book.table1}[what](output, progress=progress)
            text, report = made.text, {"rows": made.rows, "comparison": made.comparison}
    if json:
        print_json(report)
    else:
        print(text)
