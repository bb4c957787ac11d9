"""Synthetic rigs at several angles to the walls, each calibrated from its own pictures, and runs filmed with each.

Run: python benchmarks/vision_seeds.py [SEEDS] [SECONDS] [ANGLES] [MINUTES]. Every seed draws its own camera poses,
lenses, walls, light, noise, lost frames (5 %) and clock offset, and a run: held, wobbling or falling in turn. Walls'
thicknesses and the indices of wall and oil are drawn by as much as a session takes them to be uncertain. At every
angle every fifth session is spoilt in ten ways, and each should be refused. SEEDS is a number, or first:last such as
10:20; after MINUTES (default: no limit) no further rig is begun. A table a rig angle: errors against the truth,
chi-square a point (3 is due) and on each axis (1 is due), of the attack angle and of the clocks' offset (1 is due), of
places that a perfect detector would see through the calibrated rig (3 is due) and their errors, error of the wobble
where it exceeds 0.3 deg, and refusals. Twenty seconds of one core a rig, and as long again for the spoilt ones of every
fifth.
"""

import itertools
import shutil
import sys
import tempfile
import time
import tomllib
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from helimag.errors import HelimagError, InputError
from helimag.runs.measurement import attack_windows, output
from helimag.runs.trajectory import Trajectory
from helimag.vision import Effects, Rig, Session, calibrate, paper_rig, render_run, render_session, score, staged, track

CROSSING = 10.0  # in which the device crosses the tank (s); a piece of this is filmed
KINDS = ("held", "wobbling", "falling")
LIMITS = {"rms_mm": 0.15, "attack_deg": 1.0, "wobble_percent": 20.0}
LEAST_WOBBLE = np.radians(0.3)
CHI_SQUARE = (2.5, 3.6)
CONFIRMED = 0.9  # share of the intervals of |y| that must hold the truth

Row = dict[str, float]


def chi_squares(run: Trajectory, truth: Trajectory) -> np.ndarray:
    """Of every sample: all three axes together, then x, y and z alone, (4,) means; errors over claimed covariance."""
    times = truth.dataset["time"].values
    place = np.abs(times[None] - run.dataset["time"].values[:, None]).argmin(axis=1)
    off = run.dataset["position"].values - truth.dataset["position"].values[place]
    covariance = run.dataset["position_covariance"].values
    joint = np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariance), off)
    alone = off**2 / np.einsum("nii->ni", covariance)
    return np.array([joint.mean(), *alone.mean(axis=0)])


def attack_chi_square(run: Trajectory, truth: Trajectory) -> float:
    """Mean of the squared errors of the attack angle over their claimed variances."""
    times = truth.dataset["time"].values
    place = np.abs(times[None] - run.dataset["time"].values[:, None]).argmin(axis=1)
    off = run.dataset["attack_angle"].values - truth.dataset["attack_angle"].values[place]
    return float(np.mean((off / run.dataset["attack_angle_sd"].values) ** 2))


def calibration_alone(true: Rig, rig: Rig) -> tuple[float, float]:
    """How far off the calibrated rig puts places in the tank that are seen without error (root mean square, m), and
    chi-square a place."""
    axes = (np.linspace(0.01, 0.15, 5), np.linspace(-0.02, 0.02, 3), np.linspace(-0.035, 0.0, 3))
    places = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    off = rig.triangulate(*(camera.project(places) for camera in true.cameras))[0] - places
    shifts = rig.shifts(places)
    covariance = np.einsum("kni,knj->nij", shifts, shifts)
    chi = np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariance), off)
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1)))), float(chi.mean())


def wobble_error(run: Trajectory, truth: Trajectory) -> float:
    """Of the wobble over the run (percent), NaN where the truth is 0.3 deg or less."""
    times = truth.dataset["time"].values
    place = np.abs(times[None] - run.dataset["time"].values[:, None]).argmin(axis=1)
    true = float(truth.dataset["attack_angle"].values[place].std())
    found = float(attack_windows(run, count=1).wobble[0])
    return 100.0 * (found / true - 1.0) if true > LEAST_WOBBLE else float("nan")


def filmed(true: Rig, rig: Rig, kind: Any, seed: int, duration: float, folder: Path) -> Row:
    random = np.random.default_rng(100 * seed + KINDS.index(kind))
    effects = Effects(seed=seed, dropped=0.05, clock_offset=float(random.uniform(-0.5, 0.5)))
    start = float(random.uniform(0.0, CROSSING - duration))
    run = staged(kind, duration=CROSSING, seed=seed)
    films = render_run(run, true, folder, effects=effects, start=start, duration=duration)
    truth = Trajectory.load(films["truth"])
    measured = track(films["front"], films["below"], rig, initial_gap=0.102)
    errors, size, chi = score(measured, truth), output(measured), chi_squares(measured, truth)
    late = float(measured.dataset.attrs["clock_offset"]) - effects.clock_offset
    alone = calibration_alone(true, rig)
    return {
        "rms_mm": 1e3 * errors.position_rms,
        "worst_mm": 1e3 * errors.position_worst,
        "attack_deg": float(np.degrees(errors.attack_rms)),
        "wobble_percent": wobble_error(measured, truth),
        "chi2": float(chi[0]),
        "chi2_x": float(chi[1]),
        "chi2_y": float(chi[2]),
        "chi2_z": float(chi[3]),
        "y_inside": float(size.low <= truth.judgement.output <= size.high),
        "used": errors.samples / errors.frames,
        "chi2_attack": attack_chi_square(measured, truth),
        "clock_error_ms": 1e3 * late,
        "chi2_clock": (late / float(measured.dataset.attrs["clock_offset_sd"])) ** 2,
        "calibration_um": 1e6 * alone[0],
        "chi2_calibration": alone[1],
    }


def edited(change: Callable[[dict[str, Any]], None]) -> Callable[[Path], None]:
    """Spoil a session by changing its file."""

    def spoil(folder: Path) -> None:
        file = folder / "calibration.toml"
        data = tomllib.loads(file.read_text(encoding="utf-8"))
        change(data)
        file.write_text(tomli_w.dumps(data), encoding="utf-8")

    return spoil


def exchanged(*media: str) -> Callable[[Path], None]:
    """Spoil a session by swapping the cameras' pictures."""

    def spoil(folder: Path) -> None:
        for medium in media:
            (folder / medium / "front").rename(folder / medium / "other")
            (folder / medium / "below").rename(folder / medium / "front")
            (folder / medium / "other").rename(folder / medium / "below")

    return spoil


def moved(axis: int, length: float) -> Callable[[dict[str, Any]], None]:
    def change(data: dict[str, Any]) -> None:
        for end in ("low", "high"):
            data["tank"][end][axis] = f"{float(data['tank'][end][axis].split()[0]) + length} mm"

    return change


def thinned(medium: str, kept: int) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        for view in ("front", "below"):
            for file in sorted((folder / medium / view).glob("*.png"))[kept:]:
                file.unlink()

    return spoil


SPOILT: dict[str, Callable[[Path], None]] = {
    "oil of 1.47": edited(lambda data: data["tank"].update(indices=[1.0, 1.49, 1.47])),
    "oil of 1.33": edited(lambda data: data["tank"].update(indices=[1.0, 1.49, 1.33])),
    "squares of 10 mm": edited(lambda data: data["board"].update(square="10 mm")),
    "six columns": edited(lambda data: data["board"].update(columns=6)),
    "cameras swapped in air": exchanged("air"),
    "cameras swapped in oil": exchanged("oil"),
    "cameras swapped": exchanged("air", "oil"),
    "tank 5 mm aside": edited(moved(1, 5.0)),
    "4 pictures in the tank": thinned("oil", 4),
    "4 pictures in air": thinned("air", 4),
}


def refusals(session: Path) -> int:
    refused = 0
    for name, spoil in SPOILT.items():
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "session"
            shutil.copytree(session, folder)
            spoil(folder)
            try:
                calibrate(Session.load(folder / "calibration.toml"))
                print(f"     accepted: {name}", flush=True)
            except InputError:
                refused += 1
    return refused


def built(rig: Rig, seed: int) -> Rig:
    """The rig with walls and oil off what is given of them; inner faces stay where they are."""
    random = np.random.default_rng([seed, 2])
    index_off = random.normal(0.0, Session.index_sds)
    cameras = []
    for camera in rig.cameras:
        if camera.wall is None:
            raise ValueError("a rig of this benchmark has walls")
        wall, thicker = camera.wall, float(random.normal(0.0, Session.thickness_sd))
        air, glass, oil = wall.indices
        indices = (air, glass + index_off[0], oil + index_off[1])
        point = wall.point - thicker * wall.normal
        moved = replace(wall, point=point, thickness=wall.thickness + thicker, indices=indices)
        cameras.append(replace(camera, wall=moved))
    return replace(rig, cameras=(cameras[0], cameras[1]))


def one(angle: float, seed: int, duration: float, folder: Path) -> Row:
    true = built(paper_rig(seed=seed, angle=np.radians(angle)), seed)
    session = render_session(true, folder / "calibration", seed=seed)
    edited(lambda data: data["tank"].update(wall_thickness="5 mm", indices=[1.0, 1.49, 1.40]))(session.parent)
    kind = KINDS[seed % 3]
    row = filmed(true, calibrate(Session.load(session)).rig, kind, seed, duration, folder / "films")
    row["refused"] = float(refusals(session.parent)) if seed % 5 == 0 else float("nan")
    print(
        f"{angle:4g} {seed:4d} {kind:9s} " + "  ".join(f"{key} {value:.3f}" for key, value in row.items()), flush=True
    )
    return row


def summary(angle: str, rows: list[Row]) -> bool:
    """Print an angle's line of the table; whether it is within the limits."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # means of nothing, where no session was spoilt, no run wobbled
        mean = {key: float(np.nanmean([row[key] for row in rows])) for key in rows[0]}
        worst = {key: float(np.nanmax(np.abs([row[key] for row in rows]))) for key in LIMITS}
    spoilt = f"{mean['refused']:.1f} of {len(SPOILT)}" if np.isfinite(mean["refused"]) else "none tried"
    print(
        f"| {angle} | {len(rows)} | {mean['rms_mm']:.4f} | {worst['rms_mm']:.4f} | {mean['chi2']:.2f} | "
        f"{mean['chi2_x']:.2f} {mean['chi2_y']:.2f} {mean['chi2_z']:.2f} | {mean['chi2_attack']:.2f} | "
        f"{mean['chi2_clock']:.2f} | {mean['calibration_um']:.1f} {mean['chi2_calibration']:.2f} | "
        f"{worst['wobble_percent']:.0f} % | "
        f"{mean['y_inside']:.2f} | {spoilt} |",
        flush=True,
    )
    within = all(value <= LIMITS[key] for key, value in worst.items() if np.isfinite(value))
    refused = all(row["refused"] == len(SPOILT) for row in rows if np.isfinite(row["refused"]))
    return within and refused and mean["y_inside"] >= CONFIRMED and CHI_SQUARE[0] <= mean["chi2"] <= CHI_SQUARE[1]


def main() -> None:
    given = dict(enumerate(sys.argv[1:]))
    first, _, last = given.get(0, "20").rpartition(":")
    duration, minutes = float(given.get(1, "3")), float(given.get(3, "inf"))
    angles = [float(angle) for angle in given.get(2, "0,10,20,30").split(",")]
    good, began = True, time.monotonic()
    table: dict[float, list[Row]] = {angle: [] for angle in angles}
    for seed, angle in itertools.product(range(int(first or 0), int(last)), angles):
        if time.monotonic() - began > 60.0 * minutes:
            break
        with tempfile.TemporaryDirectory() as folder:
            try:
                table[angle].append(one(angle, seed, duration, Path(folder)))
            except HelimagError as error:
                print(f"{angle:4g} {seed:4d} {error}", flush=True)
                good = False
    print(
        "\n| angle | rigs | rms mm | worst | chi2 a point | x y z | attack | clock | calibration alone: um, chi2 | "
        "worst wobble | y inside | spoilt refused |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for angle, rows in table.items():
        good = summary(f"{angle:g}", rows) and good
    summary("all", [row for rows in table.values() for row in rows])
    sys.exit(int(not good))


if __name__ == "__main__":
    main()
