"""Design a drive: inputs whose orbit has the wanted speed or circle and lies farthest from every loss of stability."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from helimag.engine import advance, start_state
from helimag.ensembles import Copies, tally
from helimag.errors import InputError, RunError
from helimag.orbits.curves.intervals import Interval, stable_interval
from helimag.orbits.strobe import chart
from helimag.orbits.strobe.find import find_orbit, find_orbits
from helimag.orbits.strobe.orbit import Orbit
from helimag.orbits.strobe.problem import Floats
from helimag.outcomes import Verdict
from helimag.scenario import Input, Parameters, Scenario

SAMPLES = 256  # places of the inputs' box that are looked at first
ROUNDS = 5  # of spreading from the stable ones among them
CANDIDATES = 4
POLISHES = 3  # moves of a candidate to the middle of its intervals
WITHIN = 1e-6  # of the wanted value
SHARES = tuple(0.9 * 0.85**i for i in range(12))  # of the margins, tried as tolerances that hold together
RUNS = 200
FIRST_LOOK = 1800.0  # s, of runs that tell whether devices settle from the scenario's start
FIRST_RUNS = 8  # made before more are, twice as many each time: most tolerances that are too wide show in these
TOGETHER = 64  # inputs perturbed at once for which a stable orbit is asked before the full runs
LONGEST_RUN, SHORTEST_RUN = 6000.0, 1800.0  # s
CIRCULAR = {
    "drive.frequency": (1.0, 4.5),
    "drive.pitch": (0.0, math.radians(25.0)),
    "drive.distance": (0.1, 0.2),
    "drive.yaw_rate": (math.radians(0.3), math.radians(6.0)),
}
STRAIGHT = {key: value for key, value in CIRCULAR.items() if key != "drive.yaw_rate"}


@dataclass(frozen=True)
class Design:
    """A drive with tolerances.

    Attributes
    ----------
    orbit
        Stable.
    scenario
        The designed one, as long as the runs that check it.
    intervals
        Where it stays stable as one input varies.
    tolerances
        Half width (SI) for each input such that all may be off at once.
    verdicts
        How many of the perturbed full runs ended how.
    on_orbit
        Whether those runs began on the orbit (the scenario's own start does not lead to it) instead of at the start.
    """

    orbit: Orbit
    scenario: Scenario
    intervals: dict[str, Interval]
    tolerances: dict[str, float]
    verdicts: dict[Verdict, int]
    on_orbit: bool

    @property
    def duration(self) -> float:
        """Of the runs, s."""
        return self.scenario.run.duration

    @property
    def bounded(self) -> int:
        """How many of the perturbed runs stayed bounded."""
        return self.verdicts.get(Verdict.BOUNDED, 0)

    @property
    def text(self) -> str:
        """Inputs with tolerances, intervals, and the check."""
        lines = []
        for path, half in self.tolerances.items():
            given = Input(path)
            here = given.show(self.scenario, given.value(self.scenario), 4)
            off = given.show(self.scenario, half, 2)
            lines.append(f"{path:18s} {here} ± {off}; alone {self.intervals[path].text}")
        total = sum(self.verdicts.values())
        tally = ", ".join(f"{count} {verdict}" for verdict, count in self.verdicts.items())
        place = "the orbit" if self.on_orbit else "the scenario's start"
        lines.append(
            f"speed {1e3 * self.orbit.speed:.4g} mm/s, radius {1e3 * self.orbit.radius:.4g} mm; "
            f"{total} full runs of {self.duration:.0f} s from {place}, all inputs off at once: {tally}"
        )
        return "\n".join(lines)


def design(
    scenario: Scenario,
    *,
    speed: float | None = None,
    radius: float | None = None,
    limits: Mapping[str, tuple[float, float]] | None = None,
    runs: int = RUNS,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Design:
    """Find inputs whose orbit is stable with the largest margin, and tolerances that full runs confirm.

    Parameters
    ----------
    scenario
        Device, fluid, magnet and kind of run; what is not in ``limits`` stays as it is.
    speed, radius
        Wanted of the device on its orbit (m/s, m); None leaves it free.
    limits
        Lowest and highest value (SI) of each input to choose. Default: frequency, pitch, distance and yaw rate for a
        circular run, without the yaw rate for a straight one.
    runs
        Perturbed full runs for the check.

    Raises
    ------
    InputError
        Where the limits do not fit.
    RunError
        Where no stable orbit with the wanted values was found within the limits.
    """
    task = _Task(scenario, limits, {"speed": speed, "radius": radius}, seed)
    report = progress or (lambda _: None)
    samples, unstable = task.stable_samples()
    report(0.15)
    settling, unsettled = task.settling(samples, unstable)
    report(0.3)
    tried: list[Orbit] = []
    # from the scenario's own start, where devices settle from there far and wide; else from the orbit
    for on_orbit, chosen, avoided in ((False, settling, unsettled), (True, samples, unstable)):
        begin = 0.65 if on_orbit else 0.3
        found = []
        for count, orbit in enumerate(task.candidates(chosen, avoided)):
            polished = task.polished(orbit, POLISHES if on_orbit else 0)
            found += [] if polished is None else [polished]
            report(begin + 0.2 * (count + 1) / CANDIDATES)
        for count, (_, orbit, intervals) in enumerate(sorted(found, key=lambda each: -each[0])):
            report(begin + 0.2 + 0.15 * count / len(found))
            checked = task.checked(orbit, intervals, runs, on_orbit)
            if checked is not None:
                return checked
            tried.append(orbit)
    if not tried:
        raise RunError(
            f"no stable orbit {task.wish} was found within the limits: widen them, or ask for another speed or radius"
        )
    raise RunError(
        f"no tolerances keep all of {runs} perturbed runs bounded, down to {SHARES[-1]:.2f} of the margins, around any "
        f"of {len(tried)} orbits; the last is {tried[-1].text}"
    )


class _Task:
    """What a design needs to know: inputs with limits, wanted values, random numbers."""

    def __init__(
        self,
        scenario: Scenario,
        limits: Mapping[str, tuple[float, float]] | None,
        wanted: Mapping[str, float | None],
        seed: int,
    ) -> None:
        default = CIRCULAR if scenario.drive.yaw_rate != 0.0 else STRAIGHT
        limits = default if limits is None else limits
        self.scenario = scenario
        self.parameters = Parameters.within(scenario, limits)
        self.low = self.parameters.low
        self.span = self.parameters.high - self.low
        self.wanted = {name: value for name, value in wanted.items() if value is not None}
        if "radius" in self.wanted and scenario.drive.yaw_rate == 0.0:
            raise InputError("radius needs a circular run: drive.yaw_rate must not be zero")
        for name, value in self.wanted.items():
            if not value > 0.0:
                raise InputError(f"{name} must be greater than zero; got {value}")
        if len(self.wanted) >= len(self.span):
            raise InputError("design needs more inputs to choose than wanted values: name more limits")
        self.random = np.random.default_rng(seed)

    @property
    def wish(self) -> str:
        """The wanted values in words."""
        units = {"speed": "mm/s", "radius": "mm"}
        return " and ".join(f"with {name} {1e3 * value:.4g} {units[name]}" for name, value in self.wanted.items())

    def at(self, shares: Floats) -> Scenario:
        """The scenario at shares (k,) of the limits."""
        return self.parameters.scenario_at(self.low + np.asarray(shares) * self.span)

    def shares(self, scenario: Scenario) -> Floats:
        return np.asarray((self.parameters.vector(scenario) - self.low) / self.span)

    def stable_samples(self) -> tuple[list[tuple[Floats, Orbit]], Floats]:
        """Stable orbits over the box of inputs, and places without: each sought from the nearest that is known."""
        from scipy.stats import qmc

        points = qmc.Sobol(len(self.span), seed=self.random).random(SAMPLES)
        scenarios = [self.at(point) for point in points]
        known: list[tuple[Floats, Orbit]] = []
        here = (self.parameters.nearest(self.scenario) - self.low) / self.span
        first = sorted(range(SAMPLES), key=lambda i: float(np.linalg.norm(points[i] - here)))
        for scenario in [self.at(here), *(scenarios[i] for i in first[:12])]:
            orbit = find_orbit(scenario, thorough=False)
            if orbit.stable:
                known.append((self.shares(scenario), orbit))
            if len(known) >= 3:
                break
        open_ = list(range(SAMPLES))
        for _ in range(ROUNDS if known else 0):
            places = np.array([place for place, _ in known])
            nearest = [int(np.argmin(np.linalg.norm(places - points[i], axis=1))) for i in open_]
            found = find_orbits([scenarios[i] for i in open_], np.array([known[j][1].state for j in nearest]))
            known += [(points[i], orbit) for i, orbit in zip(open_, found, strict=True) if orbit.stable]
            left = [i for i, orbit in zip(open_, found, strict=True) if not orbit.stable]
            if len(left) == len(open_) or not left:
                break
            open_ = left
        return known, points[open_]

    def settling(
        self, samples: list[tuple[Floats, Orbit]], unstable: Floats
    ) -> tuple[list[tuple[Floats, Orbit]], Floats]:
        """Those of the samples whose runs from the scenario's start are bounded, and all other places."""
        if not samples:
            return [], unstable
        runs = [orbit.scenario.replaced({"run.duration": FIRST_LOOK, "run.interval": None}) for _, orbit in samples]
        bounded = [history.judge().verdict is Verdict.BOUNDED for history in advance(runs)]
        others = [place for (place, _), fine in zip(samples, bounded, strict=True) if not fine]
        return [each for each, fine in zip(samples, bounded, strict=True) if fine], np.array([*unstable, *others])

    def candidates(self, samples: list[tuple[Floats, Orbit]], avoided: Floats) -> list[Orbit]:
        """Orbits with the wanted values, those first that lie far from all places to be avoided."""
        solved = []
        near = sorted(samples, key=lambda sample: self._miss(sample[1]))[: 6 * CANDIDATES]
        for _, orbit in near:
            fitted = self.fitted(orbit)
            if fitted is not None:
                solved.append(fitted)
        return sorted(solved, key=lambda orbit: -self._room(orbit, avoided))[:CANDIDATES]

    def _room(self, orbit: Orbit, avoided: Floats) -> float:
        """Distance to the nearest place to be avoided, or to the limits, in shares."""
        place = self.shares(orbit.scenario)
        edge = float(np.minimum(place, 1.0 - place).min())
        if len(avoided) == 0:
            return edge
        return min(float(np.linalg.norm(avoided - place, axis=1).min()), 2.0 * edge)

    def _miss(self, orbit: Orbit) -> float:
        return max((abs(math.log(getattr(orbit, name) / value)) for name, value in self.wanted.items()), default=0.0)

    def fitted(self, orbit: Orbit) -> Orbit | None:
        """The nearest orbit with exactly the wanted values: Gauss and Newton's method, least change of the inputs."""
        for _ in range(12):
            if self._miss(orbit) < WITHIN:
                return orbit if orbit.stable else None
            place = self.shares(orbit.scenario)
            stride = 1e-3
            tried = [place + stride * unit for unit in np.eye(len(place))]
            beside = find_orbits(
                [self.at(shares) for shares in tried], np.repeat(orbit.state[None], len(tried), axis=0)
            )
            if not all(other.found for other in beside):
                return None
            logs = np.array([[math.log(getattr(o, name)) for o in (orbit, *beside)] for name in self.wanted])
            slope = (logs[:, 1:] - logs[:, :1]) / stride
            lack = np.log(list(self.wanted.values())) - logs[:, 0]
            step = np.linalg.lstsq(slope, lack, rcond=None)[0]
            step *= min(1.0, 0.1 / max(float(np.linalg.norm(step)), 1e-12))
            target = np.clip(place + step, 0.0, 1.0)
            if np.linalg.norm(target - place) < 1e-9:
                return None
            (orbit,) = find_orbits([self.at(target)], self._carried(orbit, beside, target - place, stride)[None])
            if not orbit.found:
                return None
        return None

    def _carried(self, orbit: Orbit, beside: Sequence[Orbit], step: Floats, stride: float) -> Floats:
        """The orbit's state after a step of the inputs, by its slope."""
        length = np.full(len(beside), orbit.scenario.drive.distance)
        around = np.repeat(orbit.state[None], len(beside), axis=0)
        slope = chart.coordinates(np.array([other.state for other in beside]), around, length) / stride
        return np.asarray(chart.moved(orbit.state[None], (step @ slope)[None], length[:1])[0])

    def intervals(self, orbit: Orbit) -> dict[str, Interval]:
        """Where the orbit stays stable as each input varies alone, within the limits."""
        return {
            path: stable_interval(orbit, path, low, low + span)
            for path, low, span in zip(self.parameters.paths, self.low, self.span, strict=True)
        }

    def margin(self, intervals: Mapping[str, Interval]) -> float:
        """The least share of an input's range between the orbit and an end of its stable interval."""
        return min(float(interval.margin / span) for interval, span in zip(intervals.values(), self.span, strict=True))

    def polished(self, orbit: Orbit, moves: int) -> tuple[float, Orbit, dict[str, Interval]] | None:
        """Least margin, orbit and intervals, moved to their middle while that margin grows; None where it has none."""
        try:
            intervals = self.intervals(orbit)
        except InputError:
            return None
        margin, share = self.margin(intervals), 0.7
        for _ in range(moves):
            place = self.shares(orbit.scenario)
            middle = (np.array([(i.low + i.high) / 2.0 for i in intervals.values()]) - self.low) / self.span
            target = place + share * (middle - place)
            moved = self._walk(orbit, target)
            if moved is None:
                share *= 0.5
                continue
            try:
                new = self.intervals(moved)
            except InputError:
                share *= 0.5
                continue
            if self.margin(new) > margin:
                orbit, intervals, margin = moved, new, self.margin(new)
            else:
                share *= 0.5
        return margin, orbit, intervals

    def _walk(self, orbit: Orbit, target: Floats, steps: int = 6) -> Orbit | None:
        """The orbit taken to other inputs in small steps, then to the wanted values."""
        place = self.shares(orbit.scenario)
        for i in range(1, steps + 1):
            (orbit,) = find_orbits([self.at(place + i / steps * (target - place))], orbit.state[None])
            if not orbit.stable:
                return None
        return self.fitted(orbit)

    def checked(
        self,
        orbit: Orbit,
        intervals: dict[str, Interval],
        runs: int,
        on_orbit: bool,
    ) -> Design | None:
        """The design with the largest tolerances, as a common share of the margins, that keep all runs bounded."""
        scenario = _long_run(orbit)
        margins = np.array([interval.margin for interval in intervals.values()])
        here = self.parameters.vector(scenario)
        for share in SHARES:
            if not self._stable_together(orbit, here, share * margins):
                continue
            verdicts = self._perturbed_runs(orbit, scenario, here, share * margins, runs, on_orbit)
            if verdicts.get(Verdict.BOUNDED, 0) == runs:
                tolerances = dict(zip(intervals, (share * margins).tolist(), strict=True))
                return Design(
                    find_orbit(orbit.scenario, near=orbit), scenario, intervals, tolerances, verdicts, on_orbit
                )
        return None

    def _stable_together(self, orbit: Orbit, here: Floats, half: Floats) -> bool:
        """Whether the orbit stays stable at the corners of the tolerances and at random places between."""
        corners = np.array(list(product((-1.0, 1.0), repeat=len(here))))
        signs = np.concatenate([corners, self.random.uniform(-1.0, 1.0, (TOGETHER, len(here)))])
        state = np.repeat(orbit.state[None], len(signs), axis=0)
        for share in (0.34, 0.67, 1.0):
            found = find_orbits(self.parameters.scenarios(here + signs * (share * half)), state)
            if not all(other.stable for other in found):
                return False
            state = np.array([other.state for other in found])
        return True

    def _perturbed_runs(
        self, orbit: Orbit, scenario: Scenario, here: Floats, half: Floats, runs: int, on_orbit: bool
    ) -> dict[Verdict, int]:
        """Verdicts of full runs with all inputs off at once, evenly over the tolerances; stops after one that fails."""
        time = {"run.duration": scenario.run.duration, "run.interval": scenario.run.interval}
        signs = self.random.uniform(-1.0, 1.0, (runs, len(here)))
        scenarios = [changed.replaced(time) for changed in self.parameters.scenarios(here + signs * half)]
        starts = [orbit.state if on_orbit else start_state(changed) for changed in scenarios]
        copies = Copies(scenarios, np.array(starts))
        verdicts: Counter[Verdict] = Counter()
        begin, many = 0, FIRST_RUNS
        while begin < runs and set(verdicts) <= {Verdict.BOUNDED}:
            verdicts += tally(copies.part(begin, begin + many))
            begin, many = begin + many, 2 * many
        return dict(verdicts)


def _long_run(orbit: Orbit) -> Scenario:
    """The orbit's scenario, as long as the device takes to settle on it."""
    duration = float(np.clip(-4.0 / orbit.growth, SHORTEST_RUN, LONGEST_RUN))
    return orbit.scenario.replaced({"run.duration": duration, "run.interval": None})
