"""The command that makes many runs: sweep."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from helimag.cli._common import PLAIN, Common
from helimag.cli._drawing import NO_DRAWING, DrawOptions
from helimag.cli._outputs import (
    DATA,
    FIGURE,
    OUTPUT,
    PAGE,
    STORE,
    TABLE,
    Drawing,
    FigureSize,
    Outputs,
    check_outputs,
    files_report,
    print_files,
    the_one,
    write_outputs,
)
from helimag.cli._shared import MOST_THREADS, print_json, print_warnings, validity_warnings, whole

if TYPE_CHECKING:
    from helimag.cli._outputs import Format, Writer
    from helimag.sweeps import Plan, SweepProgress


def sweep(
    plan: Path,
    *,
    output: Annotated[Outputs, Parameter(name=[*OUTPUT, "--export"])] = None,
    size: FigureSize = None,
    scheduler: str | None = None,
    threads: Annotated[int | None, whole(1, MOST_THREADS)] = None,
    dry_run: Annotated[bool, Parameter(negative="")] = False,
    ensemble: Path | None = None,
    drawing: DrawOptions = NO_DRAWING,
    common: Common = PLAIN,
) -> None:
    """Run a plan into a store; the same command again goes on where it stopped.

    Parameters
    ----------
    plan
        The plan: a TOML file with a base scenario and axes.
    output
        The store (.zarr, a folder; must be named but with --dry-run). Also write the result (.nc, .csv), a figure
        (.png, .svg, .pdf) or an interactive page (.html) to this file. May be repeated.
    scheduler
        Address of a running dask scheduler, such as tcp://127.0.0.1:8786. Default: threads on this machine.
    threads
        How many threads on this machine. Default: one a core.
    dry_run
        Run a short trial only, and print the number of runs and an estimate of time and disk.
    ensemble
        What calibrate wrote: run every point with devices from it, and keep how likely each outcome is there. This and
        the following go over the plan's own [ensemble].
    """
    check_outputs(output, STORE, DATA, TABLE, FIGURE, PAGE, size=size)
    from helimag import sweeps

    store = None if dry_run else the_one(output, STORE)
    asked = _asked(plan, ensemble, drawing)
    if store is None:
        _print_estimate(sweeps.estimate(asked, threads=threads), common.json)
        return
    try:
        with sweep_progress(plan.stem) as progress:
            dataset = sweeps.sweep(asked, out=store, scheduler=scheduler, threads=threads, progress=progress)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"run the same command again to go on from what is in {store}") from None
    write_outputs(output, {STORE: lambda _: None, **sweep_writers(dataset)}, size=size)
    _print_result(dataset, store, output, common.json)


def sweep_writers(dataset: Any) -> "dict[Format, Writer]":
    """What can be made of a sweep: its data, a table, a figure, a page."""
    from helimag.sweeps import export

    return {
        DATA: lambda path: export(dataset, path),
        TABLE: lambda path: export(dataset, path),
        FIGURE: Drawing(lambda plots, size: plots.draw_sweep(dataset, size=size)),
        PAGE: lambda path: _write_page(dataset, path),
    }


def _write_page(dataset: Any, path: Path) -> None:
    from helimag import plots

    plots.save_html(plots.interactive_sweep(dataset), path)


def _asked(path: Path, ensemble: Path | None, drawing: DrawOptions) -> "Plan":
    """The plan of a file, with what is given of an ensemble."""
    from helimag import sweeps

    plan = sweeps.load_plan(path)
    if ensemble is None and plan.ensemble is None:
        drawing.check_unused()
        return plan
    given = drawing.table | ({} if ensemble is None else {"fit": str(ensemble)})
    return sweeps.with_ensemble(plan, given) if given else plan


def _print_estimate(estimate: Any, json: bool) -> None:
    if json:
        print_json({"runs": estimate.runs, "seconds": estimate.seconds, "bytes": estimate.bytes})
        return
    tried = f"{estimate.trial_runs} of them" if estimate.whole else f"{estimate.trial_runs} short runs"
    print(
        f"{estimate.runs} runs; about {_clock(estimate.seconds)} on this machine and {estimate.bytes / 1e6:.1f} MB on "
        f"disk, from a trial of {tried} ({estimate.trial_seconds:.2f} s)"
        + ("" if estimate.whole else "; runs that end early take less")
    )


def _print_result(dataset: Any, store: Path, output: list[Path] | None, json: bool) -> None:
    from helimag import sweeps

    counts = sweeps.counts(dataset)
    warnings = validity_warnings(dataset.attrs)
    print_warnings(warnings)
    lines = [f"{store}: " + ", ".join(f"{count} {name}" for name, count in counts.items())]
    report: dict[str, Any] = {"store": str(store), "runs": int(dataset["verdict"].size), "counts": counts}
    plan = sweeps.parse_plan(dataset.attrs["plan"])
    boundary = plan.boundary
    if plan.ensemble is not None:
        told = _devices_told(plan.ensemble.draws, dataset)
        report |= {"runs": report["runs"] * (1 + plan.ensemble.draws), "ensemble": told}  # as --dry-run counts them
        lines.append(
            f"  with the likeliest device; of {told['draws']} drawn ones, the same at each point, {_staying(told)}"
        )
    if boundary is not None:
        line = sweeps.boundary_line(dataset, boundary.verdict)
        report["boundary"] = {
            "axes": list(line.names),
            "points": len(line.points),
            **(
                {"median_error": line.median_error.tolist(), "largest_error": line.largest_error.tolist()}
                if len(line.points)
                else {}
            ),
            "gap": line.gap.tolist(),
        }
        lines.append(describe(line, dataset))
    report["warnings"] = warnings
    if json:
        print_json(report | files_report(output))
    else:
        print("\n".join(lines))
        print_files(output)


def _devices_told(draws: int, dataset: Any) -> dict[str, Any]:
    """How many devices each point was run with, and the least and the largest share of them that stay.

    With each goes where the share of all such devices lies at that point, with 95 per cent. None where none was run.
    """
    import numpy as np

    from helimag.runs.shares import wilson

    staying = dataset["probability_inside"].values
    known = staying[np.isfinite(staying)]
    told: dict[str, Any] = {"draws": draws}
    for name, pick in (("least_inside", np.min), ("most_inside", np.max)):
        share = float(pick(known)) if known.size else None
        told |= {name: share, f"{name}_95": None if share is None else list(wilson(share, draws))}
    return told


def _staying(told: dict[str, Any]) -> str:
    """How many of the devices stay, in words."""
    from helimag.runs.shares import in_percent

    if told["least_inside"] is None:
        return "none has been run"
    ends = []
    for name in ("least_inside", "most_inside"):
        share, low, high = map(in_percent, (told[name], *told[f"{name}_95"]))
        ends.append(f"{share}% ({low}% to {high}%)")
    return f"{' to '.join(ends)} stay to the end, with 95 % confidence at each point"


def describe(line: Any, dataset: Any) -> str:
    """A boundary's error bar in the units that its axes are shown in."""
    from helimag import quantities as q

    kinds = {kind.shown: kind for kind in vars(q).values() if isinstance(kind, q.Kind)}

    def shown(values: Any) -> str:
        texts = []
        for name, value in zip(line.names, values, strict=True):
            kind = kinds.get(dataset[name].attrs["shown_in"])
            scale = q.parse(f"1 {kind.shown}", kind) if kind else 1.0
            texts.append(f"{value / scale:.3g} {kind.shown if kind else ''} {name}".replace("  ", " "))
        return ", ".join(texts)

    if len(line.points) == 0:
        return f"  no boundary found; patches smaller than {shown(line.gap)} may have been missed"
    return (
        f"  boundary at {len(line.points)} places, each known to +-({shown(line.median_error)}) in the median, "
        f"+-({shown(line.largest_error)}) at worst; patches smaller than {shown(line.gap)} elsewhere may be missed"
    )


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return (
        f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d} min" if minutes else f"{seconds:.1f} s"
    )


@contextmanager
def sweep_progress(what: str) -> Iterator[Callable[["SweepProgress"], None]]:
    """A bar on stderr with rate, estimate and counts by verdict, which appears when the work has taken a second."""
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    form = "{task.completed:.0f}/{task.total:.0f} runs  {task.fields[rate]}  {task.fields[counts]}"
    bar = Bar(TextColumn(what), BarColumn(), TextColumn(form), console=Console(stderr=True), transient=True)
    task = bar.add_task(what, total=1.0, rate="", counts="")

    def report(progress: "SweepProgress") -> None:
        rate = progress.rate
        left = _clock((progress.total - progress.worked) / rate) if rate > 0.0 else "?"
        counts = ", ".join(f"{count} {name}" for name, count in progress.counts.most_common())
        bar.update(
            task, total=progress.total, completed=progress.worked, rate=f"{rate:.1f}/s, {left} left", counts=counts
        )
        if bar.console.is_terminal and not bar.live.is_started and progress.seconds > 1.0:
            bar.start()

    try:
        yield report
    finally:
        if bar.live.is_started:
            bar.stop()
