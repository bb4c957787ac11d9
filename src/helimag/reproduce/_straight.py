"""Table I and Fig. 5 of the paper: straight runs of the experiment, perturbed ones, and what was measured."""

import json
import textwrap
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from helimag.engine import History, trajectory_of
from helimag.ensembles import Ensemble, Perturbation, ensembles
from helimag.outcomes import End
from helimag.reproduce._fig3 import Reproduction, made
from helimag.reproduce._table import Row, published, write_csv, write_json
from helimag.scenario import Input, Normal, load

if TYPE_CHECKING:
    from helimag.plots import Size, StraightRun

WEIGHT = "device.weight.net_weight"
WEIGHT_SPREAD = 1e-3  # of the net weight: what no balance tells apart
DISPLACEMENT = 50e-6  # m, standard deviation along each axis
PERTURBED = 16
SEED = 5
USED = (1, 2, 3)  # rows that the presets' fit has seen
SIMULATED = 0.9  # share of the time that the runs take; the rest is drawing

OUTCOMES = {End.HORIZON: "held", End.FLOOR: "floor", End.SURFACE: "surface"}
NOTES = (
    "Three values of the presets are fitted, to rows 1-3 and Fig. 5 alone: net weight, gravity centre and the height "
    "of the surface. Rows 4-7 were held out (python benchmarks/table1_fit.py).",
    f"Perturbed runs: their net weight is off by {100.0 * WEIGHT_SPREAD:g} % and their start by "
    f"{1e3 * DISPLACEMENT:g} mm (standard deviations). Row 1 stays only by tuning: it lies on an unstable balance.",
    "|y| ends where a run touches floor or surface; the attack angle is the mean over the run.",
)


def table1(
    folder: str | Path, *, size: "Size" = "print", progress: Callable[[float], None] | None = None
) -> Reproduction:
    """Compute the paper's Table I and write figure, table and runs into a folder.

    Parameters
    ----------
    folder
        For table1.png, .svg, .pdf, .csv, .json and the runs as netCDF; made where it does not exist.
    size
        Of the figure: "small", "print" or "slide".
    progress
        Called with the fraction done.

    Returns
    -------
    Reproduction
        Its rows have row, outcome, y_m, attack_angle_deg, measured_y_m, used_in_fit and more.

    Raises
    ------
    MissingExtra
        Where matplotlib is not installed.
    FileError
        Where the folder or a file cannot be written.
    """
    return _reproduced(folder, "table1", published("table1"), size, progress)


def fig5(
    folder: str | Path, *, size: "Size" = "print", progress: Callable[[float], None] | None = None
) -> Reproduction:
    """Compute the paper's Fig. 5, rows 3, 1 and 2 of Table I, with attack angles; write figure, table and runs.

    Parameters
    ----------
    folder
        For fig5.png, .svg, .pdf, .csv, .json and the runs as netCDF; made where it does not exist.
    size
        Of the figure: "small", "print" or "slide".
    progress
        Called with the fraction done.

    Returns
    -------
    Reproduction
        With rows as those of :func:`table1`.

    Raises
    ------
    MissingExtra
        Where matplotlib is not installed.
    FileError
        Where the folder or a file cannot be written.
    """
    shown = sorted((entry for entry in published("table1") if "fig5" in entry), key=lambda entry: str(entry["fig5"]))
    return _reproduced(folder, "fig5", shown, size, progress)


def _reproduced(
    folder: str | Path, name: str, entries: Sequence[Row], size: "Size", progress: Callable[[float], None] | None
) -> Reproduction:
    from helimag import plots  # first: the work must not end in a missing package

    report = progress or (lambda _: None)
    target = made(folder)
    found = _runs(entries, lambda done: report(SIMULATED * done))
    rows = [_row(entry, ensemble) for entry, ensemble in zip(entries, found, strict=True)]
    comparison = [line for entry, row in zip(entries, rows, strict=True) for line in _comparison(entry, row)]
    files = [target / f"{name}.{suffix}" for suffix in ("png", "svg", "pdf", "csv", "json")]
    panels = [_panel(entry, ensemble, row) for entry, ensemble, row in zip(entries, found, rows, strict=True)]
    figure = plots.draw_straight_runs(panels, size=size)
    for path in files[:3]:
        plots.save(figure, path)
    write_csv([{key: _flat(value) for key, value in row.items()} for row in rows], files[3])
    write_json({"rows": rows, "comparison": comparison}, files[4])
    for ensemble in found:
        files.append(target / f"{Path(ensemble.scenario.name).name}.nc")
        trajectory_of(ensemble.nominal).save(files[-1])
    report(1.0)
    return Reproduction(rows=rows, comparison=comparison, text=_text(rows), files=tuple(files))


def _runs(entries: Sequence[Row], progress: Callable[[float], None]) -> list[Ensemble]:
    scenarios = [load(f"paper/table1-row{entry['row']}") for entry in entries]
    weight = Input(WEIGHT).value(scenarios[0])
    spread = Perturbation(priors={WEIGHT: Normal(weight, WEIGHT_SPREAD * weight)}, displacement=DISPLACEMENT)
    return ensembles(scenarios, spread, runs=PERTURBED, seed=SEED, progress=progress)


def outcome(history: History) -> str:
    """How a run ended: ``"held"`` to the end of its path, or in another end's word."""
    return OUTCOMES.get(history.status, str(history.status))


def mean_angle(history: History) -> float:
    """Mean attack angle over a run (rad): every interval counts by its length."""
    heights = history.heights
    spans = np.diff(heights.time, prepend=heights.time[0])
    return float(np.average(heights.attack, weights=spans))


def _row(entry: Row, ensemble: Ensemble) -> Row:
    nominal = ensemble.nominal
    judgement = ensemble.judgement
    low, high = np.quantile([each.output for each in ensemble.judgements], (0.05, 0.95)).tolist()
    angles = np.degrees(np.quantile([mean_angle(copy) for copy in ensemble.copies], (0.05, 0.95))).tolist()
    ends = Counter(outcome(copy) for copy in ensemble.copies)
    return {
        "row": entry["row"],
        "scenario": ensemble.scenario.name,
        "outcome": outcome(nominal),
        "measured_outcome": entry["outcome"],
        "y_m": judgement.output,
        "measured_y_m": entry["y"],
        "y_perturbed_m": [low, high],
        "attack_angle_deg": float(np.degrees(mean_angle(nominal))),
        "measured_attack_angle_deg": float(np.degrees(entry["angle"])) if "angle" in entry else None,
        "attack_angle_perturbed_deg": angles,
        "wobble_deg": float(np.degrees(judgement.wobble)),
        "end_time_s": judgement.end_time,
        "leads": trajectory_of(nominal).leading_end,
        "used_in_fit": entry["row"] in USED,
        "perturbed": len(ensemble.copies),
        "perturbed_by_outcome": dict(ends),
    }


def _comparison(entry: Row, row: Row) -> list[Row]:
    """Published beside computed, a line for each value that the paper states."""
    common = {"run": row["scenario"], "source": entry["source"]}
    lines = [
        {**common, "quantity": "outcome", "published": entry["outcome"], "computed": row["outcome"]},
        {**common, "quantity": "|y|", "unit": "m", "published": entry["y"], "computed": row["y_m"]},
    ]
    if "angle" in entry:
        angle = {"published": row["measured_attack_angle_deg"], "computed": row["attack_angle_deg"]}
        lines.append({**common, "quantity": "attack angle", "unit": "deg", **angle})
    return lines


def _panel(entry: Row, ensemble: Ensemble, row: Row) -> "StraightRun":
    from helimag.plots import StraightRun

    drive = ensemble.scenario.drive
    speed = 1e3 * float(np.linalg.norm(drive.velocity))
    same = row["perturbed_by_outcome"].get(row["outcome"], 0)
    return StraightRun(
        title=f"{row['row']}   {abs(np.degrees(drive.pitch)):g}°, {1e3 * drive.distance:g} mm, {speed:g} mm/s",
        remark=(
            f"{row['outcome']} ({entry['outcome']})\n{same} of {row['perturbed']} perturbed\n"
            f"|y| {1e3 * row['y_m']:.2f} mm ({1e3 * entry['y']:.2f})\n"
            f"angle {row['attack_angle_deg']:.1f}°"
            + (f" ({row['measured_attack_angle_deg']:.0f}°)" if "angle" in entry else "")
        ),
        time=ensemble.nominal.time,
        height=ensemble.nominal.states[:, 2],
        perturbed=[(copy.time, copy.states[:, 2]) for copy in ensemble.copies],
        measured=entry["y"] if entry["outcome"] != "surface" else -entry["y"],
        floor=ensemble.scenario.workspace.floor,
        surface=ensemble.scenario.workspace.surface,
    )


def _flat(value: object) -> object:
    return json.dumps(value) if isinstance(value, (list, dict)) else value


def _text(rows: Sequence[Row]) -> str:
    head = "row  outcome  measured   |y| mm (perturbed runs)   measured   angle deg (perturbed)    fitted  alike"
    lines = [head, "-" * len(head)]
    for row in rows:
        low, high = (1e3 * value for value in row["y_perturbed_m"])
        least, most = row["attack_angle_perturbed_deg"]
        alike = row["perturbed_by_outcome"].get(row["outcome"], 0)
        spread, angles = f"({low:.2f} to {high:.2f})", f"({least:.1f} to {most:.1f})"
        lines.append(
            f"{row['row']:<4d} {row['outcome']:8s} {row['measured_outcome']:9s} {1e3 * row['y_m']:6.2f} {spread:18s} "
            f"{1e3 * row['measured_y_m']:8.2f}   {row['attack_angle_deg']:6.1f} {angles:18s} "
            f"{'yes' if row['used_in_fit'] else 'no':6s}  {alike} of {row['perturbed']}"
        )
    agree = sum(row["outcome"] == row["measured_outcome"] for row in rows)
    lines += ["", f"{agree} of {len(rows)} outcomes as measured."]
    return "\n".join([*lines, *(textwrap.fill(note, 100) for note in NOTES)])
