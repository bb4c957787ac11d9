"""By how much one view's detections are off on films of different compression, and what of that is not fresh noise.

Run: python benchmarks/film_errors.py [SEEDS] [FACTORS]. Rendered films of two seconds, without loss and as H.264 at
each rate factor (default 20,28), by rigs at 0, 10, 20 and 30 deg in turn, of devices that go straight (held, falling)
and that wobble. Seeds begin at 100: benchmarks/vision_seeds.py judges by others. For the head's end along the device,
its middle across, the tail's end along and the half length across (px): the smoothed detections' error, what noise that
is fresh in every frame leaves of it after smoothing, what the drawings claim to leave, and the rest over the fresh
noise, which is what helimag.vision.tracking.views.RETURNING stands for where devices go straight.
"""

import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.runs.smoothing import sharpened
from helimag.runs.trajectory import Trajectory
from helimag.vision import Effects, Film, FilmWriter, Rig, Shape, paper_rig, render_run, staged
from helimag.vision.synthetic.rendering import FilmedMotion
from helimag.vision.tracking.alignment import frame_interval
from helimag.vision.tracking.detection import HALF, MIDDLE, RISE, along_and_across
from helimag.vision.tracking.pose import DevicePoses
from helimag.vision.tracking.search import Sighting, search
from helimag.vision.tracking.views import PreparedView, prepared

Floats = NDArray[np.float64]

KINDS = ("held", "wobbling", "falling")
FIRST_SEED = 100
CROSSING, SECONDS = 10.0, 2.0
SHAPE = Shape()


def compressed(folder: Path, target: Path, rate_factor: int) -> Path:
    with FilmWriter(target, Film(folder).size, quality=rate_factor) as film:
        for time, picture in Film(folder).frames():
            film.write(picture, time)
    return target


def true_poses(truth: Trajectory) -> tuple[Floats, DevicePoses]:
    """Times and poses of the truth; how they move with the numbers measured does not matter here."""
    data = truth.dataset
    none = np.zeros((data.sizes["time"], 3, 8))
    return data["time"].values, DevicePoses(
        data["position"].values, data["long_axis"].values, none, none, np.zeros(data.sizes["time"])
    )


class Filmed(NamedTuple):
    """What was filmed: the motion, its time at zero of the first clock, the truth beside it, and the clock offset."""

    motion: FilmedMotion
    zero: float
    truth: Trajectory
    ahead: float


def errors(view: PreparedView, rig: Rig, which: int, filmed: Filmed) -> tuple[Floats, Floats]:
    """Times (n,), and the four numbers' errors (n, 4) in px, at frames between the truth's first and last."""
    time = filmed.truth.dataset["time"].values
    sighting = view.sighting
    now = sighting.time - (filmed.ahead if which else 0.0)
    used = np.isfinite(sighting.rows[:, RISE]) & (now >= time[0]) & (now <= time[-1])
    head, turn = filmed.motion.pose(now[used] + filmed.zero)
    nose, tail = (rig.cameras[which].project(head + reach * turn[:, :, 0]) for reach in (SHAPE.nose, SHAPE.tail))
    rows = sighting.rows[used]
    off = np.concatenate([rows[:, MIDDLE] - (nose + tail) / 2.0, rows[:, HALF] - (nose - tail) / 2.0], axis=1)
    return sighting.time[used], along_and_across(off, nose - tail)


def squares(films: tuple[Path, Path], rig: Rig, filmed: Filmed) -> list[Floats]:
    """Of each view: squares (4, 4) of error, fresh noise after smoothing, what drawings leave, fresh noise."""
    result = []
    time, poses = true_poses(filmed.truth)
    for which, seen in enumerate(search((Film(films[0]), Film(films[1])), rig, SHAPE)):
        plain = Sighting(seen.time, seen.rows)  # as if nothing were lost
        late = filmed.ahead if which else 0.0
        view = prepared(plain, rig.cameras[which], SHAPE, time, poses, late, frame_interval(seen.time))
        times, off = errors(view, rig, which, filmed)
        smoothed, weights = sharpened(times, off, frame_interval(seen.time))
        calm = float(np.mean(np.sum(weights * weights, axis=1)))
        result.append(np.stack([np.mean(smoothed**2, axis=0), view.fresh**2 * calm, view.lasting**2, view.fresh**2]))
    return result


def main() -> None:
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    factors = [int(factor) for factor in sys.argv[2].split(",")] if len(sys.argv) > 2 else [20, 28]
    found: dict[str, list[Floats]] = {}
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        rig = paper_rig(seed=seed, angle=np.radians((0.0, 10.0, 20.0, 30.0)[seed % 4]))
        random = np.random.default_rng(seed)
        effects = Effects(seed=seed, dropped=0.05, clock_offset=float(random.uniform(-0.5, 0.5)))
        kind = KINDS[seed % 3]
        run = staged(kind, duration=CROSSING, seed=seed)
        start = float(random.uniform(0.0, CROSSING - SECONDS))
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            paths = render_run(run, rig, folder, effects=effects, kind=".png", start=start, duration=SECONDS)
            zero = start - max(0.0, -effects.clock_offset)
            filmed = Filmed(FilmedMotion(run), zero, Trajectory.load(paths["truth"]), effects.clock_offset)
            sets = {"no loss": (paths["front"], paths["below"])}
            for factor in factors:
                one, two = (
                    compressed(paths[name], folder / f"{name}-{factor}.mp4", factor) for name in ("front", "below")
                )
                sets[f"H.264 at {factor}"] = (one, two)
            for name, films in sets.items():
                way = "wobbling" if kind == "wobbling" else "straight"
                found.setdefault(f"{name}, {way}", []).extend(squares(films, rig, filmed))
        print(f"seed {seed}", file=sys.stderr, flush=True)
    print("px of: head's end along, middle across, tail's end along, half length across")
    for name, entries in found.items():
        error, smoothed, left, fresh = np.mean(entries, axis=0)
        rest = error - smoothed - left
        for what, values in (
            ("error", np.sqrt(error)),
            ("fresh, smoothed", np.sqrt(smoothed)),
            ("left by drawings", np.sqrt(left)),
            ("rest over fresh", np.sign(rest) * np.sqrt(np.abs(rest) / fresh)),
        ):
            print(f"{name:24s} {what:18s} " + "  ".join(f"{value:7.3f}" for value in values))


if __name__ == "__main__":
    main()
