"""What a calibrated device will do: runs of a scenario at samples of the posterior, their verdicts and their bands."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.calibration.drawing import drawn
from helimag.calibration.fit import SHARES, Posterior
from helimag.engine import DEFAULT, TOLERANCE, History, advance, method_named, start_state
from helimag.ensembles import Ensemble, Noise, finished
from helimag.runs.shares import in_percent
from helimag.scenario import Scenario

Floats = NDArray[np.float64]

DRAWS = 100
TIMES = 201  # of the bands


@dataclass(frozen=True)
class Prediction:
    """Runs of a scenario, each with a device from the posterior and errors of its own.

    Attributes
    ----------
    runs
        As an ensemble: verdicts with their shares and intervals, gains, rows; nominal is the run of the best sample.
    time
        (t,) s, of the bands.
    heights
        (3, t) m: 5, 50 and 95 % of the head's height; a run that has ended keeps its last one.
    """

    runs: Ensemble
    time: Floats
    heights: Floats

    @cached_property
    def numbers(self) -> dict[str, Any]:
        """Everything as plain numbers, SI, angles in degrees."""
        judgements = self.runs.judgements
        escapes = [judgement.escape_time for judgement in judgements if judgement.escape_time is not None]
        return {
            "draws": len(judgements),
            "outcomes": [
                {"verdict": str(verdict), "probability": share, "low_95": low, "high_95": high}
                for verdict, (share, low, high) in self.runs.shares.items()
            ],
            "best": {"verdict": str(self.runs.judgement.verdict), "gain": self.runs.judgement.gain},
            "gain": _band([judgement.gain for judgement in judgements]),
            "output_y_m": _band([judgement.output for judgement in judgements]),
            "attack_angle_deg": _band([float(np.degrees(judgement.attack_angle)) for judgement in judgements]),
            "escape_time_s": _band(escapes) if escapes else None,
            "time_s": self.time.tolist(),
            "height_m": {name: band.tolist() for name, band in zip(("p05", "p50", "p95"), self.heights, strict=True)},
        }

    @property
    def text(self) -> str:
        """Probabilities and bands in a few lines."""
        found = self.numbers
        last = 1e3 * self.heights[:, -1]
        lines = [
            "{}: {}% ({}% to {}%)".format(
                each["verdict"], *(in_percent(each[name]) for name in ("probability", "low_95", "high_95"))
            )
            for each in found["outcomes"]
        ]
        bands = (
            ("gain", "gain", 1.0, ""),
            ("output_y_m", "|y|", 1e3, " mm"),
            ("attack_angle_deg", "attack angle", 1.0, " deg"),
        )
        for key, word, scale, unit in bands:
            low, middle, high = (scale * found[key][name] for name in ("p05", "p50", "p95"))
            lines.append(f"{word}: {middle:.3g}{unit} (90 % from {low:.3g} to {high:.3g})")
        lines.append(f"height at the end: {last[1]:.2f} mm (90 % from {last[0]:.2f} to {last[2]:.2f})")
        return "\n".join(lines)


def _band(values: Sequence[float]) -> dict[str, float]:
    return dict(zip(("p05", "p50", "p95"), np.quantile(values, SHARES).tolist(), strict=True))


def predict(
    scenario: Scenario,
    fit: Posterior,
    *,
    noise: Noise | None = None,
    draws: int = DRAWS,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    method: str = DEFAULT,
    device: str = "cpu",
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Prediction:
    """Run a scenario with devices from a posterior, and say how they end.

    Parameters
    ----------
    scenario
        What to run. The fit's free inputs take the place of its own; a factor multiplies its own; an input that belongs
        to some runs of the plan only (their starts, say) stays as the scenario has it.
    fit
        As :func:`calibrate` gives it.
    noise
        Errors of each run on top.
    draws
        Number of runs.
    seed
        Of samples and errors: the same seed draws the same.
    tolerance, device, threads, progress
        As for :func:`helimag.engine.advance`.
    method
        As for :func:`helimag.simulate`.

    Returns
    -------
    Prediction
        Outcomes with their probabilities, and bands of height.

    Raises
    ------
    InputError
        Where the scenario's device is not the fit's, cannot have its inputs, or a drawn value does not fit.
    RunError
        Where the numbers of a run broke down.
    """
    devices = drawn(fit, scenario, draws=draws, noise=noise, seed=seed)
    best, copies = devices.nominal(scenario), devices.copies(scenario)
    histories = finished(
        advance(
            [best, *copies.scenarios],
            initial_states=np.concatenate([start_state(best)[None], copies.states]),
            tolerance=tolerance,
            method=method_named(method),
            device=device,
            threads=threads,
            progress=progress,
        )
    )
    inputs = tuple(dict.fromkeys([*devices.inputs, *devices.noise.inputs]))
    time = np.linspace(0.0, scenario.run.duration, TIMES)
    return Prediction(Ensemble(histories[0], histories[1:], inputs), time, height_bands(histories[1:], time))


def height_bands(histories: Sequence[History], time: Floats) -> Floats:
    """5, 50 and 95 % of the heights (3, t) of runs at times (t,); a run that has ended keeps its last height."""
    heights = [np.interp(time, history.time, history.states[:, 2]) for history in histories]
    return np.asarray(np.quantile(heights, SHARES, axis=0))
