"""Random runs of all kinds, with leaps and directly, beside direct steps so fine that two tolerances agree.

    python benchmarks/random_runs.py --from 0 --to 300
    python benchmarks/random_runs.py --from 0 --to 100 --walls

With --walls they are runs above a floor, below a surface or between both: with true drag that walls raise, with that of
resistive-force theory that they do not, and with walls that hold. The first of them makes two tables of drag, which
takes minutes.

Run number n is the same whatever the slice. It counts where direct steps at tolerances of 1e-10 and 1e-11 agree: end,
and verdict the same, places within 1e-7 m, and times of the end within 0.1 ms. Slips of a device that turns against the
field at every turn are counted at steps, so that they differ where places do not. "leaps" and "direct" are the runs
that `helimag simulate` gives, "not refined" those that it gives with `--no-refine`, and sweeps.
"""

import argparse
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from helimag.engine import DOP853, MULTIREVOLUTION, Accuracy, History, accuracy_of, advance, refined
from helimag.engine.accuracy import SURE
from helimag.scenario import Scenario, load, parse

SLICE = 20  # runs at a time
METHODS = {"leaps": MULTIREVOLUTION, "direct": DOP853}
WALLS = {"workspace.floor": -0.05, "workspace.surface": 0.03}
TWO_MAGNETS = """
[[magnet]]
moment = "{moment} A m^2"
radius = "17.5 mm"
height = "20 mm"
offset = ["-20 mm", "0 mm", "0 mm"]
[[magnet]]
moment = "{moment} A m^2"
radius = "17.5 mm"
height = "20 mm"
offset = ["20 mm", "0 mm", "0 mm"]
phase = "{phase} deg"
"""
Changes = dict[str, object]


def mirrored(run: Scenario) -> Scenario:
    """The other handedness, so that the device swims and is carried the other way along x."""
    drive = run.drive
    return run.replaced(
        {"device.helix.handedness": "right", "drive.yaw_rate": -drive.yaw_rate, "drive.pitch": -drive.pitch}
    )


def frequency(rng: np.random.Generator) -> float:
    """Of the magnet (Hz)."""
    return float(np.exp(rng.uniform(math.log(0.5), math.log(8.0))))


def circle(rng: np.random.Generator) -> Changes:
    """A drive in circles, near to those of Fig. 3."""
    return {
        "drive.pitch": math.radians(rng.uniform(8.0, 17.0)),
        "drive.distance": rng.uniform(0.12, 0.17),
        "drive.yaw_rate": math.radians(rng.uniform(0.5, 3.0)),
        "drive.frequency": rng.uniform(2.0, 4.5),
    }


def in_circles(rng: np.random.Generator) -> Scenario:
    """Helix first, Fig. 3."""
    return load("paper/fig3c").replaced(circle(rng))


def losing_step(rng: np.random.Generator) -> Scenario:
    """Head first, some of which lose step on the way, and of two drags."""
    model = rng.choice(["lighthill", "gray-hancock"])
    return load("nose-first/fig3c").replaced(circle(rng) | {"device.hydrodynamics.model": str(model)})


def any_frequency(rng: np.random.Generator) -> Scenario:
    """All frequencies at distances where a device keeps in step, or slips."""
    preset = str(rng.choice(["paper/fig3a", "nose-first/fig3b"]))
    reach = {"drive.frequency": frequency(rng), "drive.distance": rng.uniform(0.1, 0.25)}
    return load(preset).replaced(circle(rng) | reach)


def attracted(rng: np.random.Generator) -> Scenario:
    """Near the magnet."""
    return load("paper/fig3c").replaced(circle(rng) | {"drive.distance": rng.uniform(0.085, 0.12)})


def falling(rng: np.random.Generator) -> Scenario:
    """Heavy devices in thick or thin fluid, some between floor and surface."""
    heavy = {"device.weight.net_weight": rng.uniform(50e-6, 300e-6), "fluid.viscosity": rng.uniform(0.3, 4.0)}
    walls = WALLS if rng.random() < 0.5 else {}
    return load("paper/fig3c").replaced(circle(rng) | heavy | walls)


def straight(rng: np.random.Generator) -> Scenario:
    """The rows of Table I in the paper's tank, a little different, at all frequencies."""
    row, group = rng.integers(1, 8), rng.choice(["paper", "nose-first"])
    run = load(f"{group}/table1-row{row}")
    changes: Changes = {
        "drive.distance": run.drive.distance * rng.uniform(0.95, 1.1),
        "drive.pitch": run.drive.pitch + math.radians(rng.uniform(-3.0, 3.0)),
    }
    if rng.random() < 0.5:
        changes["drive.frequency"] = frequency(rng)
    return run.replaced(changes)


def held(rng: np.random.Generator) -> Scenario:
    """The same with walls that hold what touches them."""
    return straight(rng).replaced({"workspace.contact": "hold", "run.duration": 100.0})


def other_magnets(rng: np.random.Generator) -> Scenario:
    """A cylinder, or two magnets."""
    run = load("paper/fig3c").replaced(circle(rng))
    if rng.random() < 0.5:
        return run.replaced({"magnet.field": "cylinder"})
    pair = TWO_MAGNETS.format(moment=rng.uniform(6.0, 11.0), phase=rng.uniform(-20.0, 20.0))
    text = run.to_toml()
    begin, end = text.index("[magnet]"), text.index("[drive]")
    return parse(text[:begin] + pair + text[end:])


def other_devices(rng: np.random.Generator) -> Scenario:
    """Other helices, heads and fluids; one in four with true drag."""
    run = load("nose-first/fig3c").replaced(circle(rng))
    if rng.random() < 0.25:
        return run.replaced({"device.hydrodynamics.model": "boundary"})
    return run.replaced(
        {
            "device.helix.length": rng.uniform(7e-3, 16e-3),
            "device.helix.pitch": rng.uniform(1.5e-3, 4e-3),
            "device.head.radius": rng.uniform(0.4e-3, 1.2e-3),
            "device.magnetic_moment": rng.uniform(3e-4, 12e-4),
            "fluid.viscosity": rng.uniform(0.5, 3.0),
            "drive.frequency": frequency(rng),
        }
    )


def sampled(rng: np.random.Generator) -> Scenario:
    """A path through samples: an arc that stops half way."""
    run = load("paper/fig3c").replaced(circle(rng) | {"run.duration": 120.0})
    times = np.linspace(0.0, 120.0, 40)
    yaw = run.drive.yaw_rate * 60.0 * np.tanh(times / 60.0)
    gap = run.drive.distance
    tilt = run.drive.pitch
    arm = np.array([math.sin(tilt) * gap, 0.0, math.cos(tilt) * gap])
    rows = [f'["{-math.cos(a) * arm[0]} m", "{-math.sin(a) * arm[0]} m", "{arm[2]} m"]' for a in yaw]
    path = f"""
[drive.path]
time = {[f"{t} s" for t in times]}
position = [{", ".join(rows)}]
yaw = {[f"{a} rad" for a in yaw]}
""".replace("'", '"')
    text = "\n".join(line for line in run.to_toml().splitlines() if not line.startswith("yaw_rate"))
    begin = text.index("velocity = [")
    text = text[:begin] + text[text.index("]", begin) + 1 :]
    begin = text.index("[run]")
    return parse(text[:begin] + path + text[begin:])


FAMILIES = (
    in_circles,
    losing_step,
    any_frequency,
    attracted,
    falling,
    straight,
    straight,
    other_magnets,
    other_devices,
    any_frequency,
    in_circles,
    losing_step,
    attracted,
    falling,
    held,
    sampled,
)


def tank(rng: np.random.Generator) -> Changes:
    """Floor, surface or both, near enough to be met."""
    floor, surface = rng.uniform(-0.04, -0.012), rng.uniform(0.005, 0.03)
    kinds: list[Changes] = [{"floor": floor}, {"surface": surface}, {"floor": floor, "surface": surface}]
    return {"workspace": kinds[rng.integers(3)]}


def drag(rng: np.random.Generator) -> Changes:
    """True drag near walls, or in one of four that of resistive-force theory."""
    near = {"model": "boundary", "near_walls": True}
    return {"device.hydrodynamics": near if rng.random() < 0.75 else {"model": "lighthill"}, "provenance": {}}


def straight_in_tank(rng: np.random.Generator) -> Scenario:
    """The rows of Table I, a little different, at frequencies where they keep in step."""
    run = load(f"nose-first/table1-row{rng.integers(1, 8)}")
    changes: Changes = {
        "drive.distance": run.drive.distance * rng.uniform(0.95, 1.1),
        "drive.frequency": rng.uniform(1.5, 4.0),
        "run.duration": 100.0,
    }
    return run.replaced(changes | tank(rng) | drag(rng))


def circling_in_tank(rng: np.random.Generator) -> Scenario:
    """Circles; heavy devices fall and light ones are attracted."""
    changes: Changes = {"device.weight.net_weight": rng.uniform(1e-5, 8e-5), "run.duration": 150.0}
    return load("nose-first/fig3c").replaced(circle(rng) | changes | tank(rng) | drag(rng))


def hovering(rng: np.random.Generator) -> Scenario:
    """Weak forces far from the magnet: the device stays where it is for long."""
    return load("nose-first/fig3c").replaced(hovering_changes(rng.uniform(-12.0, -5.0)) | tank(rng) | drag(rng))


def hovering_changes(pitch: float) -> Changes:
    """A magnet so far away, and tilted by ``pitch`` (deg), that its pull is about the weight of a light device."""
    return {
        "device.weight": {"net_weight": 9.038e-7, "gravity_center": 0.0},
        "fluid.viscosity": 0.2,
        "drive.distance": 0.25,
        "drive.frequency": 3.0,
        "drive.pitch": math.radians(pitch),
        "provenance": {},
    }


def held_in_tank(rng: np.random.Generator) -> Scenario:
    """Straight runs among walls that hold, some of which the surface pulls."""
    pull = {"workspace.surface_pull": 2e-5} if rng.random() < 0.3 else {}
    return straight_in_tank(rng).replaced({"workspace.contact": "hold"} | pull)


def climbing(rng: np.random.Generator) -> Scenario:
    """A drive that rises or sinks, so that no frame moves with it in which the walls stand still."""
    changes: Changes = {"drive.velocity": (0.0, 0.0, rng.uniform(-2e-4, 2e-4)), "run.duration": 60.0}
    return circling_in_tank(rng).replaced(changes)


WALL_FAMILIES = (
    straight_in_tank,
    circling_in_tank,
    hovering,
    straight_in_tank,
    held_in_tank,
    circling_in_tank,
    hovering,
    climbing,
)


def wall_run(number: int) -> tuple[str, Scenario]:
    """Run number ``number`` near walls, and its family."""
    rng = np.random.default_rng([12, number])
    family = WALL_FAMILIES[number % len(WALL_FAMILIES)]
    run = family(rng)
    if rng.random() < 0.25:
        run = run.replaced({"magnet.field": "cylinder"})
    duration = min(run.run.duration, 400.0)
    return family.__name__, run.replaced({"run.duration": duration, "run.interval": duration / 400.0})


def random_run(number: int) -> tuple[str, Scenario]:
    """Run number ``number``, and its family."""
    rng = np.random.default_rng([14, number])
    family = FAMILIES[number % len(FAMILIES)]
    run = family(rng)
    if family in {in_circles, losing_step, any_frequency, attracted} and rng.random() < 0.4:
        run = mirrored(run)
    duration = min(run.run.duration, 400.0)
    return family.__name__, run.replaced({"run.duration": duration, "run.interval": duration / 400.0})


@dataclass(frozen=True)
class Comparison:
    """A run beside the exact one."""

    family: str
    number: int
    method: str
    verdict: bool  # the same
    end: bool  # the same
    time: float  # by how much the ends are apart, s
    gain: float
    extremes: float  # m
    place: float  # largest distance at samples, m
    bounded: bool  # whether the printed error bounds the true one
    leapt: float
    cost: float = 1.0  # time with the run that was made again, where it was, over that of the one before

    @property
    def good(self) -> bool:
        """Within what is promised."""
        return self.verdict and self.end and self.time <= 1e-3 and self.gain <= 1e-5 and self.extremes <= 1e-6


def distances(one: History, other: History) -> np.ndarray:
    """Distances (m) between two runs at the samples that both came to."""
    count = min(one.time.size, other.time.size)
    same = one.time[:count] == other.time[:count]
    return np.asarray(np.linalg.norm(one.states[:count, :3] - other.states[:count, :3], axis=1)[same])


def known(one: History, other: History) -> bool:
    """Whether two runs at close tolerances are the same run."""
    near = distances(one, other).max() < 1e-7 and abs(one.time[-1] - other.time[-1]) < 1e-4
    return bool(one.status is other.status and near and one.judge().verdict is other.judge().verdict)


def bounded(history: History, exact: History, told: Accuracy) -> bool:
    """Whether the error that is printed bounds the true one, before the first slip and after it."""
    away = distances(history, exact)
    times = history.time[: away.size]
    before = times < (math.inf if told.first_slip is None else told.first_slip)
    early = away[before].max(initial=0.0) <= told.in_step
    late = told.after_slip is None or away[~before].max(initial=0.0) <= told.after_slip
    return bool(early and late)


def gain_apart(one: float, other: float) -> float:
    """Distance between two gains, of which some runs have none."""
    return 0.0 if math.isnan(one) and math.isnan(other) else abs(one - other)


def compared(family: str, number: int, name: str, history: History, told: Accuracy, exact: History) -> Comparison:
    """A run beside the exact one."""
    ours, theirs = history.judge(), exact.judge()
    low = abs(float(history.records["low"].min() - exact.records["low"].min()))
    high = abs(float(history.records["high"].max() - exact.records["high"].max()))
    return Comparison(
        family=family,
        number=number,
        method=name,
        verdict=ours.verdict is theirs.verdict,
        end=history.status is exact.status,
        time=abs(float(history.time[-1] - exact.time[-1])),
        gain=gain_apart(ours.gain, theirs.gain),
        extremes=max(low, high),
        place=float(distances(history, exact).max()),
        bounded=bounded(history, exact, told),
        leapt=history.leapt,
    )


def comparisons(numbers: range, draw: Callable[[int], tuple[str, Scenario]]) -> Iterator[Comparison]:
    """Every run of a slice whose exact course is known, by each method."""
    kinds, runs = zip(*(draw(number) for number in numbers), strict=True)
    nearly, exact = (advance(runs, tolerance=tolerance, method=DOP853) for tolerance in (1e-10, 1e-11))
    rough = {name: advance(runs, method=method) for name, method in METHODS.items()}
    given = {name: refined(rough[name], method=method) for name, method in METHODS.items()}
    for i, number in enumerate(numbers):
        if known(nearly[i], exact[i]):
            for name, method in METHODS.items():
                ours, asked = given[name][i], rough[name][i]
                first = told = accuracy_of(asked, method=method)
                if ours is not asked:
                    told = accuracy_of(ours, tolerance=SURE, method=method, rough=asked)
                cost = 1.0 if ours is asked else 1.0 + ours.wall_time / asked.wall_time
                yield replace(compared(kinds[i], number, name, ours, told, exact[i]), cost=cost)
                yield compared(kinds[i], number, f"{name}, not refined", asked, first, exact[i])


def summary(name: str, found: list[Comparison], count: int) -> str:
    """What one method kept to, in a line."""
    ours = [c for c in found if c.method == name]
    share = np.mean([c.bounded for c in ours])
    kept = sum(c.good for c in ours)
    again = [c.cost for c in ours if c.cost > 1.0]
    made = f"; {len(again)} made again, {np.median(again):.1f} times the time in the median" if again else ""
    return (
        f"{name:19s} {len(ours)} of {count} runs known: {kept} within all bounds; at most "
        f"{1e3 * max(c.time for c in ours):.1e} ms at the end, {max(c.gain for c in ours):.1e} of gain, "
        f"{max(c.extremes for c in ours):.1e} m of extremes, {max(c.place for c in ours):.1e} m at samples; "
        f"the printed error bounds {100.0 * share:.1f} %; {100.0 * np.mean([c.leapt for c in ours]):.0f} % leapt over"
        f"{made}"
    )


def main() -> None:
    """Print what is out of bounds, and a summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--from", dest="first", type=int, default=0)
    parser.add_argument("--to", dest="last", type=int, default=300)
    parser.add_argument("--walls", action="store_true", help="runs near walls")
    options = parser.parse_args()
    draw = wall_run if options.walls else random_run
    found: list[Comparison] = []
    for begin in range(options.first, options.last, SLICE):
        for one in comparisons(range(begin, min(begin + SLICE, options.last)), draw):
            found.append(one)
            if not one.good or not one.bounded:
                print(one, flush=True)
        print(f"{begin + SLICE} ...", flush=True)
    for name in dict.fromkeys(one.method for one in found):
        print(summary(name, found, options.last - options.first))


if __name__ == "__main__":
    main()
