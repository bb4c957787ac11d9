"""Examine an installation: versions, devices, and a check run against states from an independent code."""

import json
import os
from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from typing import Any

import numpy as np
import warp as wp

from helimag.engine import simulate
from helimag.runs.trajectory import versions
from helimag.scenario import load

TOLERANCE = 1e-8  # m, after 10 s
EXTRAS = {
    "plots": ("matplotlib", "av"),
    "sweeps": ("zarr", "plotly"),
    "cluster": ("distributed", "dask_jobqueue"),
    "robot": ("lark",),
    "vision": ("cv2", "av"),
}


@dataclass(frozen=True)
class Examination:
    """What was found; ``findings`` can be printed as JSON."""

    findings: dict[str, Any]
    healthy: bool

    @property
    def text(self) -> str:
        """The findings as lines."""
        lines = [f"{name:14s} {value}" for name, value in self.findings["versions"].items()]
        lines.append(f"{'devices':14s} {', '.join(self.findings['devices'])} ({self.findings['cpu_cores']} cores)")
        lines.append(f"{'extras':14s} {', '.join(self.findings['extras']) or 'none'}")
        lines.append(f"{'kernel cache':14s} {self.findings['kernel_cache']}")
        error = self.findings["check"]["position_error_m"]
        verdict = "agrees with" if self.healthy else "DIFFERS from"
        lines.append(
            f"{'check run':14s} {verdict} an independent code: {error:.1e} m after 10 s, {TOLERANCE:.0e} m allowed"
        )
        return "\n".join(lines)


def examine() -> Examination:
    """Look at versions, devices and extras, and run Fig. 3(C) for 10 s against the stored reference state."""
    reference = json.loads(
        (resources.files("helimag") / "presets" / "reference_state.json").read_text(encoding="utf-8")
    )
    run = simulate(load(reference["preset"]), duration=reference["time_s"])
    error = float(np.linalg.norm(run.final_state[:3] - reference["state"][:3]))
    findings = {
        "versions": json.loads(versions()),
        "devices": [str(device) for device in wp.get_devices()],
        "cpu_cores": os.cpu_count(),
        "extras": [name for name, modules in EXTRAS.items() if all(find_spec(module) for module in modules)],
        "kernel_cache": wp.config.kernel_cache_dir,
        "check": {"preset": reference["preset"], "position_error_m": error, "allowed_m": TOLERANCE},
    }
    return Examination(findings, healthy=error <= TOLERANCE)
