"""Fig. 4 of the paper: gain over pitch, distance and yaw rate, frequency by frequency, wide and then fine.

Section II-C: at each frequency the three inputs are swept in turn; the values of least gain are the inputs of the next
frequency. Bounded is what the paper calls so there: a run that stays inside for its half hour with a gain below one,
whether or not its height has settled by then. The ranges the paper leaves open; here they are wide enough for both ends
of the bounded sets but the least distances.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from helimag import quantities as q
from helimag.errors import FileError
from helimag.files import replacing
from helimag.outcomes import Verdict
from helimag.reproduce._table import write_csv
from helimag.scenario import Input
from helimag.sweeps import Axis, Plan, SweepProgress, sweep

if TYPE_CHECKING:
    import xarray

    from helimag.plots import Size

BASE = "paper/fig3c"
FREQUENCIES = (2.0, 2.25, 2.5, 2.75, 3.0, 3.3)  # Hz
FINE_RUNS = 81
# of ranks: with six frequencies, chance exceeds it once in twenty. Each number is a noisy sample of a boundary, so that
# no step by itself must have the published sense
CLEAR_TREND = 0.8


@dataclass(frozen=True)
class Fig4Input:
    """One of the three inputs: its field, kind, and the wide pass in the unit that it is shown in."""

    field: str
    kind: q.Kind
    start: float
    stop: float
    step: float

    @property
    def name(self) -> str:
        """Name of its coordinate."""
        return Input(self.field).label


INPUTS = (
    Fig4Input("drive.pitch", q.ANGLE, 0.0, 30.0, 1.0),
    Fig4Input("drive.distance", q.LENGTH, 110.0, 170.0, 2.0),
    Fig4Input("drive.yaw_rate", q.ANGULAR_RATE, 0.2, 2.0, 0.1),
)


def stays(gain: Any, flags: Any) -> Any:
    """Which runs are bounded in the paper's sense: inside to the end, with a gain below one."""
    return np.isin(flags, [verdict.flag for verdict in Verdict if verdict.inside]) & (gain < 1.0)


@dataclass(frozen=True)
class Panel:
    """The two passes over one input at one frequency, what the others were, and what came of it (SI)."""

    frequency: float
    input: Fig4Input
    others: Mapping[str, float]
    wide: "xarray.Dataset"
    fine: "xarray.Dataset"

    @property
    def best(self) -> float:
        """Value of least gain, among bounded runs where there are any."""
        values, gain, flags = self._joined()
        kept = stays(gain, flags)
        allowed = kept if kept.any() else ~np.isnan(gain)
        return float(values[allowed][np.argmin(gain[allowed])])

    @property
    def row(self) -> dict[str, Any]:
        """One line of the table: the bounded set and the least gain."""
        values, gain, flags = self._joined()
        fine = stays(self.fine["gain"].values, self.fine["verdict"].values)
        inside = values[stays(gain, flags)]
        at = int(np.argmin(np.abs(values - self.best)))
        step = float(np.diff(self.fine[self.input.name].values).mean())
        return {
            "frequency_hz": self.frequency,
            "input": self.input.name,
            "unit": self.input.kind.si,
            "bounded_from": float(inside.min()) if inside.size else None,
            "bounded_to": float(inside.max()) if inside.size else None,
            "bounded_extent": float(fine.sum()) * step,
            "gain_below_one": int(np.sum(gain < 1.0)),
            "runs": int(gain.size),
            "best": self.best,
            "least_gain": float(gain[at]),
            "best_is_bounded": bool(stays(gain, flags)[at]),
            **{f"at_{name.removeprefix('drive.')}": value for name, value in self.others.items()},
        }

    def _joined(self) -> tuple[Any, Any, Any]:
        parts = [
            np.concatenate([data[name].values for data in (self.wide, self.fine)])
            for name in (self.input.name, "gain", "verdict")
        ]
        return parts[0], parts[1], parts[2]


@dataclass(frozen=True, kw_only=True)
class Fig4:
    """The paper's Fig. 4: rows for machines, the same as a table for people, and the files written."""

    rows: list[dict[str, Any]]
    trends: list[dict[str, Any]]
    text: str
    files: tuple[Path, ...]


def characterize(
    folder: Path,
    *,
    frequencies: Sequence[float] = FREQUENCIES,
    inputs: Sequence[Fig4Input] = INPUTS,
    fine_runs: int = FINE_RUNS,
    duration: str = "1800 s",
    progress: Callable[[float], None] | None = None,
) -> list[Panel]:
    """Section II-C's procedure; each pass is a sweep with a store of its own in the folder, so that it can be resumed.

    Parameters
    ----------
    frequencies
        In the order in which each hands its values of least gain to the next (Hz).
    fine_runs
        Runs of each fine pass.
    progress
        Called with the fraction done.
    """
    from helimag.scenario import load

    drive = load(BASE).drive
    held = {each.field: float(getattr(drive, each.name)) for each in inputs}
    total = len(frequencies) * sum(fine_runs + round((each.stop - each.start) / each.step) + 1 for each in inputs)
    done = 0

    def report(state: SweepProgress) -> None:
        if progress is not None:
            progress((done + state.worked) / total)

    panels: list[Panel] = []
    for frequency in frequencies:
        for each in inputs:
            others = {field: value for field, value in held.items() if field != each.field}
            wide_axis = Axis(field=each.field, **_texts(each, start=each.start, stop=each.stop, step=each.step))
            wide = _pass(folder, frequency, others, wide_axis, "wide", duration, report)
            done += wide["verdict"].size
            low, high = _around(each, wide)
            fine_axis = Axis(field=each.field, count=fine_runs, **_texts(each, start=low, stop=high))
            fine = _pass(folder, frequency, others, fine_axis, "fine", duration, report)
            done += fine["verdict"].size
            panels.append(Panel(frequency, each, others, wide, fine))
            held[each.field] = panels[-1].best
    return panels


def _pass(
    folder: Path,
    frequency: float,
    others: Mapping[str, float],
    axis: Axis,
    resolution: str,
    duration: str,
    progress: Callable[[SweepProgress], None],
) -> "xarray.Dataset":
    """One sweep over one input."""
    name = f"{frequency:g}Hz-{axis.field.removeprefix('drive.')}-{resolution}"
    plan = Plan(
        name=name,
        base=BASE,
        duration=duration,
        changes={"drive.frequency": frequency, **others},
        axis=(axis,),
    )
    return sweep(plan, out=folder / f"{name}.zarr", progress=progress).load()


def _texts(each: Fig4Input, **values: float) -> dict[str, str]:
    return {name: f"{value:.12g} {each.kind.shown}" for name, value in values.items()}


def _around(each: Fig4Input, wide: "xarray.Dataset") -> tuple[float, float]:
    """The bounded set and a step to each side, or two about the least gain where nothing is bounded (shown unit)."""
    values = wide[each.name].values / q.parse(f"1 {each.kind.shown}", each.kind)
    inside = values[stays(wide["gain"].values, wide["verdict"].values)]
    margin = each.step
    if inside.size == 0:
        gain = wide["gain"].values
        inside, margin = values[[int(np.nanargmin(gain))]], 2.0 * each.step
    return max(float(inside.min()) - margin, each.start), min(float(inside.max()) + margin, each.stop)


def fig4(
    folder: str | Path,
    *,
    frequencies: Sequence[float] = FREQUENCIES,
    inputs: Sequence[Fig4Input] = INPUTS,
    fine_runs: int = FINE_RUNS,
    duration: str = "1800 s",
    size: "Size" = "print",
    progress: Callable[[float], None] | None = None,
) -> Fig4:
    """Compute the paper's Fig. 4 and write figure, table and stores into a folder; interrupted, it goes on there.

    Parameters
    ----------
    folder
        For fig4.png, .svg, .pdf, .csv, .json and the sweeps' stores; made where it does not exist.
    frequencies, inputs, fine_runs, duration, progress
        As for :func:`characterize`.
    size
        Of the figure: "small", "print" or "slide".

    Returns
    -------
    Fig4
        Rows with frequency_hz, input, bounded_from, bounded_to and more; trends; both as text; and the files.

    Raises
    ------
    MissingExtra
        Where matplotlib or zarr is not installed.
    FileError
        Where the folder or a file cannot be written.
    """
    from helimag import plots
    from helimag.plots import Passes, draw_passes

    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{folder} cannot be made: {error.strerror}") from None
    panels = characterize(
        target / "fig4-sweeps",
        frequencies=frequencies,
        inputs=inputs,
        fine_runs=fine_runs,
        duration=duration,
        progress=progress,
    )
    rows = [panel.row for panel in panels]
    found = trends(rows)
    figure = draw_passes([Passes(each.frequency, each.input.name, each.wide, each.fine) for each in panels], size=size)
    files = [target / f"fig4.{suffix}" for suffix in ("png", "svg", "pdf", "csv", "json")]
    for path in files[:3]:
        plots.save(figure, path)
    write_csv(rows, files[3])
    with replacing(files[4]) as beside:
        beside.write_text(json.dumps({"panels": rows, "trends": found}, indent=2) + "\n", encoding="utf-8")
    return Fig4(rows=rows, trends=found, text=_table(panels) + "\n\n" + _trend_table(found), files=tuple(files))


def trends(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """What section II-C reads from the figure, checked on the rows from each frequency to the next higher one."""
    frequencies = sorted({row["frequency_hz"] for row in rows})

    def values(name: str, quantity: str) -> list[float | None]:
        found = {row["frequency_hz"]: row[quantity] for row in rows if row["input"] == name}
        return [found.get(frequency) for frequency in frequencies]

    least = [min(row["least_gain"] for row in rows if row["frequency_hz"] == frequency) for frequency in frequencies]
    claims = (
        ("the bounded pitch falls (highest, rad)", values("pitch", "bounded_to"), -1.0),
        ("the bounded range of pitch narrows (rad)", values("pitch", "bounded_extent"), -1.0),
        ("the bounded range of distance narrows (m)", values("distance", "bounded_extent"), -1.0),
        ("the least gain rises", least, 1.0),
        ("the least bounded yaw rate rises (rad/s)", values("yaw_rate", "bounded_from"), 1.0),
    )
    return [
        {
            "published": claim,
            "frequencies_hz": frequencies,
            "computed": numbers,
            "rank_correlation": (rank := _rank_correlation(frequencies, numbers)),
            "holds": rank is not None and sign * rank >= CLEAR_TREND,
            "at_every_step": _moves(numbers, sign),
        }
        for claim, numbers, sign in claims
        if any(number is not None for number in numbers)
    ]


def _rank_correlation(frequencies: Sequence[float], numbers: Sequence[float | None]) -> float | None:
    """Spearman's, of numbers with their frequencies; None where one is missing or all are the same."""
    from scipy.stats import rankdata

    known = np.array([np.nan if number is None else number for number in numbers])
    if not np.isfinite(known).all() or np.ptp(known) == 0.0:
        return None
    return float(np.corrcoef(rankdata(frequencies), rankdata(known))[0, 1])


def _moves(numbers: Sequence[float | None], sign: float) -> bool:
    """Whether each number is beyond the one before."""
    known = np.array([np.nan if number is None else number for number in numbers])
    return bool(np.all(sign * np.diff(known) > 0.0))


def _trend_table(found: Sequence[Mapping[str, Any]]) -> str:
    lines = [f"As frequency rises, by rank correlation ({CLEAR_TREND:g} or more in the published sense):"]
    for trend in found:
        numbers = ", ".join("-" if number is None else f"{number:.4g}" for number in trend["computed"])
        rank = "none" if trend["rank_correlation"] is None else f"{trend['rank_correlation']:+.2f}"
        steps = ", at every step" if trend["at_every_step"] else ""
        verdict = "holds" if trend["holds"] else "does NOT hold"
        lines.append(f"  {trend['published']}: {verdict}{steps}, rank correlation {rank}  ({numbers})")
    return "\n".join(lines)


def _table(panels: Sequence[Panel]) -> str:
    """One line a panel, in the units that people use."""
    lines = ["   Hz  input       bounded (fine pass: from .. to, extent)    least gain  at"]
    for panel in panels:
        row, kind = panel.row, panel.input.kind
        one = q.parse(f"1 {kind.shown}", kind)
        found = "none"
        if row["bounded_from"] is not None:
            low, high, extent = (row[key] / one for key in ("bounded_from", "bounded_to", "bounded_extent"))
            found = f"{low:.2f} .. {high:.2f} {kind.shown}, {extent:.2f}"
        mark = "" if row["best_is_bounded"] else "  (not bounded)"
        lines.append(
            f"{panel.frequency:5.2f}  {panel.input.name:10s}  {found:42s}  {row['least_gain']:9.3f}  "
            f"{row['best'] / one:.2f} {kind.shown}{mark}"
        )
    return "\n".join(lines)
