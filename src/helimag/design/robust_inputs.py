"""Design a drive: inputs whose orbit has the wanted speed or circle and forgives errors of them, or of the device."""

from collections.abc import Callable, Mapping, Sequence

from helimag.design.candidates import candidates, settling_samples, stable_samples
from helimag.design.likely import likeliest
from helimag.design.margins import polished
from helimag.design.result import Design
from helimag.design.task import DesignTask
from helimag.design.tolerances import SHARES, checked
from helimag.ensembles import Devices
from helimag.errors import RunError
from helimag.orbits import Orbit, Watch
from helimag.scenario import Scenario

RUNS = 200
CANDIDATES = 4  # whose tolerances are looked for
POLISHES = 3  # moves of a candidate to the middle of its intervals, where runs begin on the orbit


def design(
    scenario: Scenario,
    *,
    speed: float | None = None,
    radius: float | None = None,
    limits: Mapping[str, tuple[float, float]] | None = None,
    devices: Devices | None = None,
    runs: int = RUNS,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Design:
    """Find inputs whose orbit is stable with the largest margin, and tolerances that full runs confirm.

    With ``devices`` the spread of the device takes the place of tolerances: inputs with the highest probability that a
    device stays, whichever of them it is.

    Parameters
    ----------
    scenario
        Device, fluid, magnet and kind of run; what is not in ``limits`` stays as it is.
    speed, radius
        Wanted of the device on its orbit (m/s, m); None leaves it free.
    limits
        Lowest and highest value (SI) of each input to choose. Default: frequency, pitch, distance and yaw rate for a
        circular run, without the yaw rate for a straight one.
    devices
        What the device may be, as :func:`helimag.calibration.drawn` gives it for this scenario; with errors of each run
        where they have noise.
    runs
        Perturbed full runs for the check; with devices there are as many as these.
    seed
        Of the places that are looked at and of the perturbations.
    progress
        Called with a rough fraction done, some times a second. What it raises stops the search.

    Returns
    -------
    Design
        The inputs, their orbit with its margin, tolerances or probabilities, and how the full runs ended.

    Raises
    ------
    InputError
        Where the limits do not fit, or the devices decide an input to choose.
    RunError
        Where no stable orbit with the wanted values was found within the limits.
    """
    base = scenario if devices is None else devices.nominal(scenario)
    task = DesignTask(base, limits, {"speed": speed, "radius": radius}, seed)
    if devices is not None:
        devices.check_apart_from(task.parameters.paths, "an input to choose")
    watch = Watch(progress)
    samples, unstable = stable_samples(task, watch.part(0.0, 0.15))
    settling, unsettled = settling_samples(samples, unstable, watch.part(0.15, 0.3))
    tried: list[Orbit] = []
    # from the scenario's own start, where devices settle from there far and wide; else from the orbit
    for on_orbit, chosen, avoided in ((False, settling, unsettled), (True, samples, unstable)):
        half = watch.part(0.65, 1.0) if on_orbit else watch.part(0.3, 0.65)
        fits, rest = candidates(task, chosen, avoided, half.part(0.0, 0.3)), half.part(0.3, 1.0)
        if devices is None:
            result = _forgiving(task, fits[:CANDIDATES], runs, on_orbit, rest, tried)
        else:
            result = likeliest(task, devices, fits, on_orbit, rest, tried)
        if result is not None:
            watch(1.0)
            return result
    raise _nothing(task, tried, runs if devices is None else len(devices), of_devices=devices is not None)


def _forgiving(
    task: DesignTask, fits: Sequence[Orbit], runs: int, on_orbit: bool, watch: Watch, tried: list[Orbit]
) -> Design | None:
    """The design of the largest margin whose tolerances full runs confirm; what was ``tried`` in vain is added."""
    moves = POLISHES if on_orbit else 0
    polishing, checking = watch.part(0.0, 0.43), watch.part(0.43, 1.0)
    polishings = [polished(task, orbit, moves, polishing.turn(i, len(fits))) for i, orbit in enumerate(fits)]
    found = sorted((each for each in polishings if each is not None), key=lambda each: -each[0])
    for count, (_, orbit, intervals) in enumerate(found):
        result = checked(task, orbit, intervals, runs, on_orbit, checking.turn(count, len(found)))
        if result is not None:
            return result
        tried.append(orbit)
    return None


def _nothing(task: DesignTask, tried: Sequence[Orbit], runs: int, *, of_devices: bool) -> RunError:
    if not tried:
        return RunError(
            f"no stable orbit {task.wish} was found within the limits: widen them, or ask for another speed or radius"
        )
    if of_devices:
        return RunError(f"none of {runs} devices stays on any of {len(tried)} orbits; the last is {tried[-1].text}")
    return RunError(
        f"no tolerances keep all of {runs} perturbed runs bounded, down to {SHARES[-1]:.2f} of the margins, around any "
        f"of {len(tried)} orbits; the last is {tried[-1].text}"
    )
