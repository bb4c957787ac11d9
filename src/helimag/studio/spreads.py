"""What is known of the inputs, from a calibration or a data sheet: a TOML table of means and standard deviations.

[inputs]
"fluid.viscosity" = { mean = "0.97 Pa s", sd = "0.03 Pa s" }
"device.weight.net_weight" = { low = "27 uN", high = "30 uN" }

[start]
displacement = "1 mm"
"""

import tomllib
from typing import Any

from helimag import quantities as q
from helimag.ensembles import Perturbation
from helimag.errors import InputError
from helimag.scenario import Input, Normal, Prior, Scenario, Uniform

MOST_INPUTS = 20
MOST_BYTES = 64 * 2**10
FORMS = ({"mean", "sd"}, {"low", "high"})


def spread_from_bytes(content: bytes, scenario: Scenario) -> Perturbation:
    """Read such a table for a scenario.

    Raises
    ------
    InputError
        Where it is none, or an input is not one of the scenario's.
    """
    if len(content) > MOST_BYTES:
        raise InputError(f"a calibration's file must have {MOST_BYTES // 1024} kB at most")
    try:
        data = tomllib.loads(content.decode("utf-8-sig"))
    except (UnicodeDecodeError, ValueError, RecursionError) as error:
        raise InputError(f"the calibration is not valid TOML: {str(error)[:160]}") from None
    inputs, start = data.get("inputs", {}), data.get("start", {})
    if not isinstance(inputs, dict) or not isinstance(start, dict) or set(data) - {"inputs", "start"}:
        raise InputError("a calibration must have a table 'inputs', and may have a table 'start', nothing else")
    if len(inputs) > MOST_INPUTS:
        raise InputError(f"a calibration may name {MOST_INPUTS} inputs at most")
    priors = {path: _prior(path, given, scenario) for path, given in inputs.items()}
    return Perturbation(priors, _displacement(start))


def _prior(path: str, given: Any, scenario: Scenario) -> Prior:
    if not isinstance(given, dict) or set(given) not in FORMS or not all(isinstance(v, str) for v in given.values()):
        raise InputError(
            f"{path[:60]} must be {{ mean = ..., sd = ... }} or {{ low = ..., high = ... }}, texts with units"
        )
    values = {name: Input(path).parsed(scenario, text) for name, text in given.items()}
    if "mean" in values:
        return Normal(values["mean"], values["sd"])
    return Uniform(values["low"], values["high"])


def _displacement(start: dict[str, Any]) -> float:
    if set(start) - {"displacement"} or not isinstance(start.get("displacement", ""), str):
        raise InputError("start may have a displacement such as '1 mm', nothing else")
    return q.parse(start["displacement"], q.LENGTH) if start else 0.0
