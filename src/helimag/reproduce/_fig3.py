"""Fig. 3 of the paper: three half-hour runs, each with perturbed ones, beside the published values."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from helimag.engine import trajectory_of
from helimag.ensembles import Ensemble, Perturbation, ensembles
from helimag.errors import FileError
from helimag.orbits import explain
from helimag.reproduce._table import DISPLACEMENT, as_text, case_rows, fig3_rows, write_csv, write_json
from helimag.runs.trajectory import Trajectory
from helimag.scenario import load

if TYPE_CHECKING:
    from helimag.plots import Size

Floats = NDArray[np.float64]

RUNS = ("paper/fig3a", "paper/fig3b", "paper/fig3c")
PERTURBED = 32
SEED = 3
SIMULATED = 0.85  # share of the time that the runs take; the rest is drawing


@dataclass(frozen=True, kw_only=True)
class Reproduction:
    """Computed beside published: rows for machines, the same as a table for people, and the files written.

    ``rows`` has one entry for each run, ``comparison`` one for each published value.
    """

    rows: list[dict[str, Any]]
    comparison: list[dict[str, Any]]
    text: str
    files: tuple[Path, ...]


def fig3(
    folder: str | Path, *, size: "Size" = "print", progress: Callable[[float], None] | None = None
) -> Reproduction:
    """Compute the paper's Fig. 3 and write figure, table and runs into a folder.

    Parameters
    ----------
    folder
        For fig3.png, .svg, .pdf, .csv, .json and the three runs as netCDF; made where it does not exist.
    size
        Of the figure: "small", "print" or "slide".
    progress
        Called with the fraction done.

    Returns
    -------
    Reproduction
        Its rows have case, verdict, escape_time_s, gain_700_s, gain, orbit_stable and more; its comparison has run,
        quantity, unit, published, computed, difference, perturbed, perturbed_q05, perturbed_q50, perturbed_q95, remark
        and source.

    Raises
    ------
    MissingExtra
        Where matplotlib is not installed.
    FileError
        Where the folder or a file cannot be written.
    """
    from helimag import plots  # first: half a minute of work must not end in a missing package

    report = progress or (lambda _: None)
    target = made(folder)
    displaced = Perturbation(displacement=DISPLACEMENT)
    found = ensembles(
        [load(name) for name in RUNS],
        displaced,
        runs=PERTURBED,
        seed=SEED,
        progress=lambda done: report(SIMULATED * done),
    )
    trajectories = [trajectory_of(each.nominal) for each in found]
    outlooks = [explain(trajectory) for trajectory in trajectories]
    rows = case_rows(found, outlooks, [trajectory.leading_end for trajectory in trajectories])
    comparison = fig3_rows(found)
    text = as_text(comparison)
    report(SIMULATED)
    figure = plots.draw_side_by_side(_cases(found, trajectories, comparison), size=size)
    files = [target / f"fig3.{suffix}" for suffix in ("png", "svg", "pdf")]
    for path in files:
        plots.save(figure, path)
    files += [target / "fig3.csv", target / "fig3.json"]
    write_csv(comparison, files[3])
    write_json({"rows": rows, "comparison": comparison}, files[4])
    for trajectory, name in zip(trajectories, RUNS, strict=True):
        files.append(target / f"{Path(name).name}.nc")
        trajectory.save(files[-1])
    report(1.0)
    return Reproduction(rows=rows, comparison=comparison, text=text, files=tuple(files))


def made(folder: str | Path) -> Path:
    """The folder, made where it does not exist."""
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise FileError(f"{folder} is a file; name a folder to write to") from None
    except OSError as error:
        raise FileError(f"the folder {folder} cannot be made: {error.strerror}") from None
    return target


def _cases(found: Sequence[Ensemble], trajectories: Sequence[Trajectory], rows: list[dict[str, Any]]) -> list[Any]:
    """What the figure shows of each run."""
    from helimag.plots import Case

    cases = []
    for letter, ensemble, trajectory in zip("ABC", found, trajectories, strict=True):
        own = {row["quantity"].partition(" ")[0]: row for row in rows if row["run"] == ensemble.scenario.name}
        gain = own["gain"]
        drive = ensemble.scenario.drive
        counts = ", ".join(f"{count} {name}" for name, count in ensemble.verdicts.most_common())
        remark = (
            f"{gain['quantity']}: {gain['computed']:.3f}; paper {gain['published']:.3f}\n"
            f"perturbed: {counts}; gain {gain['perturbed_q05']:.2f} to {gain['perturbed_q95']:.2f}"
        )
        cases.append(
            Case(
                trajectory=trajectory,
                title=f"{letter}   {1e3 * drive.distance:g} mm, {np.degrees(drive.pitch):g}°",
                remark=remark,
                perturbed=[(copy.time, copy.states[:, 2]) for copy in ensemble.copies],
                published_time=own["escape"]["published"] if "escape" in own else None,
            )
        )
    return cases
