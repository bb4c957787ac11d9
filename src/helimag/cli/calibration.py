"""The command calibrate, and what simulate says with --ensemble."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from helimag.cli._common import PLAIN, Common
from helimag.cli._drawing import DrawOptions
from helimag.cli._outputs import (
    DATA,
    FIGURE,
    Drawing,
    FigureSize,
    Outputs,
    check_outputs,
    files_report,
    print_files,
    the_one,
    write_outputs,
)
from helimag.cli._shared import MOST_THREADS, print_json, progress_bar, whole

if TYPE_CHECKING:
    from helimag.calibration import Posterior
    from helimag.cli._outputs import Format, Writer
    from helimag.scenario import Scenario


def calibrate(
    plan: Path,
    *,
    output: Outputs = None,
    size: FigureSize = None,
    threads: Annotated[int | None, whole(1, MOST_THREADS)] = None,
    next_runs: bool = True,
    common: Common = PLAIN,
) -> None:
    """Find which devices agree with what was observed of runs.

    Parameters
    ----------
    plan
        TOML: runs with what was observed of them, and the inputs that are free, with their priors.
    output
        Write the posterior (.nc; must be named) and a figure of it (.png, .svg, .pdf) to this file. May be repeated. A
        calibration that was stopped goes on when the same command is given again.
    threads
        CPU threads; default one a core.
    next_runs
        Whether to say which run would tell most next.
    """
    check_outputs(output, DATA, FIGURE, size=size)
    target = the_one(output, DATA)
    from helimag import calibration

    try:
        with progress_bar(f"calibrating {plan.name}") as progress:
            fit = calibration.calibrate(plan, output=target, threads=threads, progress=progress)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"run the same command again to go on from what is kept beside {target}") from None
    writers: dict[Format, Writer] = {
        DATA: lambda _: None,
        FIGURE: Drawing(lambda plots, size: plots.draw_fit(fit, size=size)),
    }
    write_outputs(output, writers, size=size)
    found = calibration.findings(fit)
    worths = calibration.worths(fit, threads=threads) if next_runs else []
    if common.json:
        told = [{"run": each.name, "spread": each.spread, "told_nats": each.told} for each in worths]
        report = calibration.as_json(fit) | {"findings": found.as_json(), "next_runs": told}
        print_json(report | files_report(output))
        return
    print(f"{fit.plan.name}: {len(fit.samples)} samples from {fit.evaluations} likelihoods")
    print(_table(fit))
    for sentence in found.sentences:
        print(f"  {sentence}")
    if worths:
        print("next, most telling first:")
        for each in worths[:3]:
            print(f"  {each.text}")
    print(f"log evidence {fit.evidence:.1f} ± {fit.evidence_sd:.1f}")
    print_files(output)


def _table(fit: "Posterior") -> str:
    """One line for each input: 5, 50, 95 % and the best, in the unit that files use; and the prior's 5 to 95 %."""
    from helimag import calibration

    width = max(len(name) for name in fit.names)
    lines = [f"  {'input':{width}s}  {'5 %':>10s} {'50 %':>10s} {'95 %':>10s} {'best':>10s}  prior 5 to 95 %"]
    for i, name in enumerate(fit.names):
        scale, unit = calibration.shown_unit(fit, i)
        five, half, most = fit.quantiles[:, i] / scale
        low, _, high = fit.prior[:, i] / scale
        numbers = " ".join(f"{value:10.5g}" for value in (five, half, most, fit.best[i] / scale))
        lines.append(f"  {name:{width}s}  {numbers}  {low:.4g} to {high:.4g} {unit}".rstrip())
    return "\n".join(lines)


def predict(scenario: "Scenario", fit: Path, options: DrawOptions, *, method: str, device: str, json: bool) -> None:
    """What simulate prints with --ensemble."""
    from helimag import calibration

    known = calibration.Posterior.load(fit)
    draws = calibration.DRAWS if options.draws is None else options.draws
    seed = options.seed or 0
    with progress_bar(f"predicting {scenario.title}") as progress:
        found = calibration.predict(
            scenario,
            known,
            noise=options.noise_in(scenario),
            draws=draws,
            seed=seed,
            method=method,
            device=device,
            progress=progress,
        )
    if json:
        report: dict[str, Any] = {"scenario": scenario.title, "ensemble": str(fit), "seed": seed}
        print_json(report | found.numbers)
        return
    print(f"{scenario.title} with {draws} devices of {fit}")
    for line in found.text.splitlines():
        print(f"  {line}")
