"""The codes that are measured: each makes a run of a scenario to an end time at a tolerance, and gives the last place.

What a code compiles it compiles before :attr:`Code.run` is called a second time; :attr:`Code.rates` is the right-hand
side as that code evaluates it, to be held against the engine's before anything is timed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import version

import numpy as np
from equations import rates_of, unit_of
from numpy.typing import NDArray

from helimag.engine import DOP853, MULTIREVOLUTION, Method, advance, start_state
from helimag.scenario import Scenario

Floats = NDArray[np.float64]
BATCH = 64  # runs of helimag's batch
MOST_STEPS = 10**9
LEAPING = "helimag, multirevolution"


@dataclass(frozen=True)
class Code:
    """One code, ready to run.

    Attributes
    ----------
    name
        With its version.
    run
        (end time in s, tolerance) -> where the head is then (m): (3,).
    rates
        (time, state in the equations' units) -> rates (7,); None for helimag itself.
    runs
        How many runs one call makes.
    same_as
        The code that takes the same steps, one run at a time: a tolerance is sought for that one alone.
    share
        Of the run that is timed and scaled up, where a whole one would take long; its cost a turn is even.
    """

    name: str
    run: Callable[[float, float], Floats]
    rates: Callable[[float, Floats], Floats] | None = None
    runs: int = 1
    same_as: str | None = None
    share: float = 1.0


def start_of(scenario: Scenario) -> Floats:
    """The start in the equations' units: (7,)."""
    start = np.array(start_state(scenario), dtype=float)
    start[:3] /= unit_of(scenario)
    return start


def helimag_run(scenario: Scenario, method: Method, runs: int = 1) -> Callable[[float, float], Floats]:
    """helimag as a caller of ``advance`` has it: packing, samples, statistics, slips and events included."""

    def run(end: float, tolerance: float) -> Floats:
        copies = [scenario.replaced({"run.duration": end})] * runs
        histories = advance(copies, method=method, tolerance=tolerance, threads=1)
        return np.asarray(histories[0].states[-1, :3])

    return run


def helimag_codes(scenario: Scenario) -> list[Code]:
    """One run by each method, and many; the first is what all ratios are to."""
    return [
        Code(LEAPING, helimag_run(scenario, MULTIREVOLUTION)),
        Code(f"{LEAPING}, {BATCH} runs", helimag_run(scenario, MULTIREVOLUTION, BATCH), runs=BATCH, same_as=LEAPING),
        Code("helimag, direct", helimag_run(scenario, DOP853)),
    ]


def heyoka_code(scenario: Scenario) -> Code:
    """Adaptive Taylor series, compiled from symbols."""
    import heyoka as hy

    system, unit = _heyoka_system(scenario), unit_of(scenario)
    compiled = hy.cfunc([rate for _, rate in system], vars=[name for name, _ in system])

    @cache
    def integrator(tolerance: float) -> "hy.taylor_adaptive_dbl":
        return hy.taylor_adaptive(system, start_of(scenario), tol=tolerance, fast_math=True)

    def run(end: float, tolerance: float) -> Floats:
        solver = integrator(tolerance)
        solver.time, solver.state[:] = 0.0, start_of(scenario)
        solver.propagate_until(end)
        return np.array(solver.state[:3]) * unit

    return Code(f"heyoka {version('heyoka')}", run, lambda t, y: np.asarray(compiled(y, time=t)))


def heyoka_batch(scenario: Scenario, lanes: int) -> Code:
    """The same with several runs in each vector register."""
    import heyoka as hy

    system, unit = _heyoka_system(scenario), unit_of(scenario)
    start = np.repeat(start_of(scenario)[:, None], lanes, axis=1)
    compiled = hy.cfunc([rate for _, rate in system], vars=[name for name, _ in system])

    @cache
    def integrator(tolerance: float) -> "hy.taylor_adaptive_batch_dbl":
        return hy.taylor_adaptive_batch(system, start, tol=tolerance, fast_math=True)

    def run(end: float, tolerance: float) -> Floats:
        solver = integrator(tolerance)
        solver.set_time(0.0)
        solver.state[:] = start
        solver.propagate_until(end)
        return np.array(solver.state[:3, 0]) * unit

    name = f"heyoka {version('heyoka')}"
    return Code(f"{name}, batch of {lanes}", run, lambda t, y: np.asarray(compiled(y, time=t)), lanes, same_as=name)


def _heyoka_system(scenario: Scenario) -> list:
    import heyoka as hy

    names = hy.make_vars("x", "y", "z", "w", "a", "b", "c")
    rates = rates_of(scenario, sin=hy.sin, cos=hy.cos, sqrt=hy.sqrt)(hy.time, *names)
    return list(zip(names, rates, strict=True))


def _compiled(scenario: Scenario) -> Callable:
    """The equations through numba, free to reorder arithmetic and to fuse it."""
    import numba

    return numba.njit(rates_of(scenario), error_model="numpy", fastmath=True)


def _rates_by_numba(compiled: Callable) -> Callable[[float, Floats], Floats]:
    return lambda t, y: np.array(compiled(t, *y))


def numbalsoda_code(scenario: Scenario, method: str) -> Code:
    """LSODA or DOP853 in compiled code that calls compiled equations."""
    import numba
    import numbalsoda

    compiled, unit, start = _compiled(scenario), unit_of(scenario), start_of(scenario)

    @numba.cfunc(numbalsoda.lsoda_sig)
    def callback(t, y, dy, _):
        dy[0], dy[1], dy[2], dy[3], dy[4], dy[5], dy[6] = compiled(t, y[0], y[1], y[2], y[3], y[4], y[5], y[6])

    solve = {"DOP853": numbalsoda.dop853, "LSODA": numbalsoda.lsoda}[method]

    def run(end: float, tolerance: float) -> Floats:
        states, success = solve(
            callback.address, start, np.array([0.0, end]), rtol=tolerance, atol=tolerance, mxstep=MOST_STEPS
        )
        return np.asarray(states[-1, :3]) * unit if success else np.full(3, np.nan)

    return Code(f"numbalsoda {version('numbalsoda')}, {method}", run, _rates_by_numba(compiled))


def cyrk_code(scenario: Scenario) -> Code:
    """DOP853 in compiled code that calls compiled equations."""
    from CyRK import cyjit, nbsolve2_ivp

    compiled, unit, start = _compiled(scenario), unit_of(scenario), start_of(scenario)

    @cyjit
    def callback(dy, t, y, _):
        dy[0], dy[1], dy[2], dy[3], dy[4], dy[5], dy[6] = compiled(t, y[0], y[1], y[2], y[3], y[4], y[5], y[6])

    def run(end: float, tolerance: float) -> Floats:
        found = nbsolve2_ivp(
            callback.address, (0.0, end), start, method="DOP853", t_eval=np.array([end]), rtol=tolerance, atol=tolerance
        )
        place = np.array(found.y[:3, -1]) * unit if found.success else np.full(3, np.nan)
        found.free()
        return place

    return Code(f"CyRK {version('CyRK')}, DOP853", run, _rates_by_numba(compiled))


def diffrax_code(scenario: Scenario) -> Code:
    """Dopri8 through JAX's compiler, in double precision on the CPU."""
    import jax

    jax.config.update("jax_platforms", "cpu")
    jax.config.update("jax_enable_x64", True)
    import diffrax
    import jax.numpy as jnp

    rates, unit = rates_of(scenario, sin=jnp.sin, cos=jnp.cos, sqrt=jnp.sqrt), unit_of(scenario)
    field = jax.jit(lambda t, y, _: jnp.stack(rates(t, *y)))
    start = jnp.asarray(start_of(scenario))

    @jax.jit
    def solve(end: float, tolerance: float) -> jax.Array:
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(field),
            diffrax.Dopri8(),
            t0=0.0,
            t1=end,
            dt0=1e-3,
            y0=start,
            saveat=diffrax.SaveAt(t1=True),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            max_steps=None,
        )
        return found.ys[0, :3]

    return Code(
        f"diffrax {version('diffrax')}, Dopri8",
        lambda end, tolerance: np.asarray(solve(end, tolerance)) * unit,
        lambda t, y: np.asarray(field(t, jnp.asarray(y), None)),
        share=0.25,
    )


def scipy_code(scenario: Scenario) -> Code:
    """SciPy's DOP853, a loop in Python, with compiled equations."""
    from scipy.integrate import solve_ivp

    compiled, unit, start = _compiled(scenario), unit_of(scenario), start_of(scenario)

    def run(end: float, tolerance: float) -> Floats:
        found = solve_ivp(
            lambda t, y: compiled(t, *y), (0.0, end), start, method="DOP853", rtol=tolerance, atol=tolerance,
            t_eval=[end],
        )  # fmt: skip
        return np.asarray(found.y[:3, -1]) * unit

    return Code(f"SciPy {version('scipy')}, DOP853 with numba", run, _rates_by_numba(compiled), share=0.1)


# what makes each peer, by the package that it needs
PEERS: list[tuple[str, Callable[[Scenario], Code]]] = [
    ("heyoka", heyoka_code),
    *(("heyoka", partial(heyoka_batch, lanes=lanes)) for lanes in (4, 8)),
    *(("numbalsoda", partial(numbalsoda_code, method=method)) for method in ("DOP853", "LSODA")),
    ("CyRK", cyrk_code),
    ("diffrax", diffrax_code),
    ("numba", scipy_code),
]
