"""The command that makes many runs: sweep."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from helimag.cli._shared import Json, check_target, print_json, print_warnings, validity_warnings
from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.sweeps import SweepProgress


def sweep(
    plan: Path,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    scheduler: str | None = None,
    threads: int | None = None,
    dry_run: Annotated[bool, Parameter(negative="")] = False,
    export: Annotated[list[Path] | None, Parameter(negative="", consume_multiple=False)] = None,
    json: Json = False,
) -> None:
    """Run a plan into a store; the same command again goes on where it stopped.

    Parameters
    ----------
    plan
        The plan: a TOML file with a base scenario and axes.
    output
        The store: a zarr directory, such as OUT.zarr.
    scheduler
        Address of a running dask scheduler, such as tcp://127.0.0.1:8786. Default: threads on this machine.
    threads
        How many threads on this machine. Default: one a core.
    dry_run
        Run a short trial only, and print the number of runs and an estimate of time and disk.
    export
        Also write the result to this .nc or .csv file. May be repeated.
    """
    from helimag import sweeps

    if threads is not None and threads < 1:
        raise InputError(f"--threads must be at least 1; got {threads}")
    if dry_run:
        _print_estimate(sweeps.estimate(plan, threads=threads), json)
        return
    if output is None:
        raise InputError("--output must name the store, such as -o OUT.zarr; got none")
    for target in export or []:
        if target.suffix not in (".nc", ".csv"):
            raise InputError(f"--export must end in .nc or .csv; got '{target}'")
        check_target(target)
    try:
        with sweep_progress(plan.stem) as progress:
            dataset = sweeps.sweep(plan, out=output, scheduler=scheduler, threads=threads, progress=progress)
    except KeyboardInterrupt:
        print(f"helimag: interrupted; run the same command again to go on from what is in {output}", file=sys.stderr)
        sys.exit(130)
    for target in export or []:
        sweeps.export(dataset, target)
    _print_result(dataset, output, export or [], json)


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


def _print_result(dataset: Any, output: Path, exported: list[Path], json: bool) -> None:
    from helimag import sweeps

    counts = sweeps.counts(dataset)
    warnings = validity_warnings(dataset.attrs)
    print_warnings(warnings)
    lines = [f"{output}: " + ", ".join(f"{count} {name}" for name, count in counts.items())]
    report: dict[str, Any] = {"store": str(output), "runs": int(dataset["verdict"].size), "counts": counts}
    boundary = sweeps.parse_plan(dataset.attrs["plan"]).boundary
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
        print_json(report)
    else:
        print("\n".join([*lines, *(f"written to {target}" for target in exported)]))


def plot_sweep(store: Path, output: Path | None) -> None:
    """Draw a sweep's store as a figure, or as an interactive page where the output ends in .html."""
    from helimag import plots
    from helimag.sweeps import load_sweep

    dataset = load_sweep(store)
    target = output or store.resolve().with_suffix(".png")
    check_target(target)
    if target.suffix == ".html":
        plots.save_html(plots.interactive_sweep(dataset), target)
    else:
        plots.save(plots.draw_sweep(dataset), target)
    print(target)


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
