"""Coefficients of DOP853: SciPy's own file, read by itself.

E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993, sec. II.10. Importing
``scipy.integrate`` for them would be a fifth of a short command (``benchmarks/start_up.py``); the file needs NumPy
alone.
"""

import importlib.util
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def _file() -> ModuleType:
    scipy: ModuleSpec | None = importlib.util.find_spec("scipy")
    if scipy is None or scipy.origin is None:
        raise ImportError("scipy is not installed")
    place = Path(scipy.origin).parent / "integrate" / "_ivp" / "dop853_coefficients.py"
    spec = importlib.util.spec_from_file_location("helimag.engine._dop853_coefficients", place)
    if spec is None or spec.loader is None:
        raise ImportError(f"{place} is no Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_found = _file()
STAGES: int = _found.N_STAGES
A: Floats = _found.A[:STAGES, :STAGES]
B: Floats = _found.B
C: Floats = _found.C[:STAGES]
E3: Floats = _found.E3
E5: Floats = _found.E5
# dense output: the step's end as a stage and three more, and what makes a polynomial of all
EXTENDED: int = _found.N_STAGES_EXTENDED
A_MORE: Floats = _found.A[STAGES:]
C_MORE: Floats = _found.C[STAGES:]
D: Floats = _found.D
