"""Design, simulate, certify and check open-loop runs of magnetic helical devices under a rotating permanent magnet."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from helimag.engine import simulate, simulate_many
    from helimag.ensembles import Perturbation, ensemble
    from helimag.errors import FileError, HelimagError, InputError, MissingExtra, NotFeasible, RunError
    from helimag.hydrodynamics import resistance
    from helimag.orbits import Orbit, find_orbit
    from helimag.outcomes import Verdict
    from helimag.proof import Proof, prove
    from helimag.runs import Trajectory
    from helimag.scenario import Scenario, load, preset_names
    from helimag.sweeps import Plan, load_sweep, sweep

# public name -> module; imported on first use, so that "helimag --help" and "import helimag" stay instant
_HOMES = {
    "FileError": "errors",
    "HelimagError": "errors",
    "InputError": "errors",
    "MissingExtra": "errors",
    "NotFeasible": "errors",
    "Orbit": "orbits",
    "Perturbation": "ensembles",
    "Plan": "sweeps",
    "Proof": "proof",
    "RunError": "errors",
    "Scenario": "scenario",
    "Trajectory": "runs",
    "Verdict": "outcomes",
    "ensemble": "ensembles",
    "find_orbit": "orbits",
    "load": "scenario",
    "load_sweep": "sweeps",
    "preset_names": "scenario",
    "prove": "proof",
    "resistance": "hydrodynamics",
    "simulate": "engine",
    "simulate_many": "engine",
    "sweep": "sweeps",
}

__all__ = list(_HOMES)

# the rooms that have more to offer, for those who look around: helimag.plots, helimag.orbits, ...
_ROOMS = (
    *("calibration", "checks", "cite", "diagnosis", "ensembles", "errors", "geometry", "hydrodynamics", "orbits"),
    *("outcomes", "plots", "proof", "quantities", "reproduce", "robot", "runs", "scenario", "sweeps", "vision"),
)


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name in _ROOMS:
        return import_module(f"helimag.{name}")
    if name == "__version__":
        from importlib.metadata import version

        return version("helimag")
    if name not in _HOMES:
        raise AttributeError(f"module 'helimag' has no attribute {name!r}")
    value = getattr(import_module(f"helimag.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, *_ROOMS, "__version__"])
