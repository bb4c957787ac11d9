"""From a plan to a fit: sampled in steps, each of which is kept, so that a stop at any time loses one step at most."""

import hashlib
import io
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from helimag.calibration import sampling
from helimag.calibration.fit import SHARES, Posterior, whole
from helimag.calibration.plan import CalibrationPlan
from helimag.calibration.problem import PreparedPlan, prepared
from helimag.errors import FileError
from helimag.files import discard_left, replacing

Floats = NDArray[np.float64]

SCATTER = 3.0  # of the evidence over seeds, over what independent weights would have: benchmarks/calibration.py
BEHIND = ".partial"  # what a file of a calibration under way ends in


def calibrate(
    plan: CalibrationPlan | str | Path,
    *,
    output: str | Path | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Posterior:
    """Find which values of the free inputs agree with what was observed.

    Parameters
    ----------
    plan
        A plan, or the path of its file.
    output
        Where the fit is written (netCDF). Beside it, under the same name and ``.partial``, lies what has been computed
        so far; a calibration that was stopped goes on from there, to the same numbers.
    threads
        CPU threads; default one a core.
    progress
        Called with the fraction done after each step.

    Returns
    -------
    Posterior
        Samples with equal weights, and what the runs of each say of the observations.

    Raises
    ------
    FileError
        Where a file cannot be read or written.
    InputError
        Where the plan does not fit together, or its priors hold hardly a device that can be run.
    """
    problem = prepared(plan)
    kept = None if output is None else Path(f"{output}{BEHIND}")

    def likelihood(points: Floats) -> Floats:
        return problem.evaluate(problem.from_unit(points), threads=threads)[0]

    mark = _mark(problem)
    if kept is not None and output is not None:
        for each in (output, kept):
            discard_left(each)
    stand = None if kept is None or not kept.exists() else _resumed(kept, mark)
    if stand is None:
        stand = sampling.begin(likelihood, len(problem.names), problem.plan.particles, problem.plan.seed)
    while not stand.done:
        stand = sampling.advanced(stand, likelihood)
        if kept is not None:
            _keep(kept, stand, mark)
        if progress is not None:
            progress(stand.fraction)
    fit = _fit(problem, stand, threads)
    if output is not None and kept is not None:
        fit.save(output)
        kept.unlink(missing_ok=True)
    return fit


def _fit(problem: PreparedPlan, stand: sampling.Stand, threads: int | None) -> Posterior:
    samples = problem.from_unit(stand.points)
    _, predictions = problem.evaluate(samples, threads=threads)
    expected = problem.flat
    sizes = [each.observed.size for each in expected]
    count = len(problem.names)
    return Posterior(
        plan=whole(problem.plan, problem.bases),
        names=problem.names,
        units=problem.units,
        samples=samples,
        loglikelihood=stand.loglikelihood,
        logprior=problem.logprior(samples),
        prior=problem.from_unit(np.repeat(np.array(SHARES)[:, None], count, axis=1)),
        labels=tuple(each.label for each, size in zip(expected, sizes, strict=True) for _ in range(size)),
        data_units=tuple(each.unit for each, size in zip(expected, sizes, strict=True) for _ in range(size)),
        observed=np.concatenate([each.observed for each in expected]),
        sd=np.concatenate([each.sd for each in expected]),
        side=np.repeat([float(each.side) for each in expected], sizes),
        predicted=np.array([np.concatenate(row) for row in predictions if row is not None]),
        evidence=stand.evidence,
        evidence_sd=SCATTER * float(np.sqrt(stand.variance)),
        evaluations=stand.evaluations,
    )


def _mark(problem: PreparedPlan) -> str:
    """Tells a plan with its scenarios and data from any other."""
    told = hashlib.sha256(whole(problem.plan, problem.bases).to_toml().encode())
    for each in problem.flat:
        told.update(each.observed.tobytes() + each.sd.tobytes())
    return told.hexdigest()


def _keep(path: Path, stand: sampling.Stand, mark: str) -> None:
    """Write all that is needed to go on."""
    fields = asdict(stand)
    arrays = {name: fields.pop(name) for name in ("points", "loglikelihood")}
    content = io.BytesIO()
    np.savez(content, about=np.array(json.dumps(fields | {"mark": mark})), **arrays)
    with replacing(path) as beside:
        beside.write_bytes(content.getbuffer())


def _resumed(path: Path, mark: str) -> sampling.Stand:
    """Where a calibration was stopped.

    Raises
    ------
    FileError
        Where the file is damaged, or of another plan.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            fields = json.loads(str(file["about"]))
            found = fields.pop("mark")
            stand = sampling.Stand(points=file["points"], loglikelihood=file["loglikelihood"], **fields)
    except Exception as error:  # noqa: BLE001  a damaged file makes the libraries raise whatever they raise
        raise FileError(f"{path}, a calibration under way, cannot be read ({error}); remove it to begin anew") from None
    if found != mark:
        raise FileError(f"{path} is of another plan, which was stopped; remove it, or name another output")
    return stand
