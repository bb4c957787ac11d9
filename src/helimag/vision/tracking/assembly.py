"""From two films and a calibration to a measured trajectory."""

import itertools
import json
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.outcomes import End
from helimag.runs.smoothing import DEGREE, POINTS, sharpened, smooth
from helimag.runs.trajectory import Trajectory, versions
from helimag.vision.cameras import Rig
from helimag.vision.films import Film
from helimag.vision.shape import Shape
from helimag.vision.tracking.alignment import CERTAIN, at, find_offset, frame_interval
from helimag.vision.tracking.clock import Clock, by_meeting, by_rolls, clock_rates, combined, told
from helimag.vision.tracking.detection import HALF, along_and_across
from helimag.vision.tracking.pose import DevicePoses, Fit, darker_end, lengths, oriented, solve
from helimag.vision.tracking.search import Sighting, search
from helimag.vision.tracking.uncertainty import Deviations, covariances, noise_variances, taken_away
from helimag.vision.tracking.views import PreparedView, parted, prepared

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

MEDIAN = 0.79  # of chi-square with three degrees of freedom, over its mean
ROUGHLY_APART = 2.0  # px by which the views may disagree before clocks and detector are known better, and
APART = 0.5  # px after: noise and calibration make a tenth
MISFIT = 16.0  # of the typical misfit: views that disagree more do not show the same thing
STRAY = 6.0  # standard deviations off its neighbours' polynomial at which a point is left out
OVERLAP = 0.5  # share of the longer film that both films must cover
TOUCH = 0.6e-3  # distance from a wall at which a device counts as touching it (m)


def track(
    first: str | Path,
    second: str | Path,
    rig: Rig,
    *,
    initial_gap: float,
    shape: Shape | None = None,
    clock_offset: float | None = None,
    rate: float | None = None,
    scenario: str | None = None,
    name: str = "measured run",
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Track the device through both films.

    Parameters
    ----------
    first, second
        Films (.mp4, .avi, ... or folders of pictures) of the rig's first and second camera.
    initial_gap
        Height of the magnet above the device at the start (m): the input u of the gain.
    shape
        Of the device; default the paper's.
    clock_offset
        How far the second clock is ahead (s); default: found from the films.
    rate
        Frames a second, where the films do not say.
    scenario
        TOML of the scenario that the run was meant to be, kept with it.

    Returns
    -------
    Trajectory
        With samples at those frames of the first film at which both views show the device. What is missing is listed in
        the attribute ``gaps`` (JSON: from, until, reason) and is never filled in.

    Raises
    ------
    FileError
        Where a film cannot be read.
    InputError
        Where the films do not fit each other, the calibration or the device.
    """
    if not (np.isfinite(initial_gap) and initial_gap > 0.0):
        raise InputError(f"initial_gap must be a length greater than zero; got {initial_gap} m")
    shape = shape or Shape()
    films = (Film(first, rate=rate), Film(second, rate=rate))
    sightings = search(films, rig, shape, progress=progress)
    _check_overlap(films, sightings, clock_offset)
    return assemble(
        sightings, rig, shape, clock_offset=clock_offset, initial_gap=initial_gap, scenario=scenario, name=name
    )


def _check_overlap(films: tuple[Film, Film], sightings: tuple[Sighting, Sighting], clock_offset: float | None) -> None:
    shift = clock_offset or 0.0
    one, two = sightings[0].time, sightings[1].time - shift
    longer = max(one[-1] - one[0], two[-1] - two[0])
    common = min(one[-1], two[-1]) - max(one[0], two[0])
    if min(one.size, two.size) < 4 or common < OVERLAP * longer:
        raise InputError(
            f"films must show the same run: {films[0].path.name} has {one.size} frames from {one[0]:.2f} s to "
            f"{one[-1]:.2f} s, "
            f"{films[1].path.name} has {two.size} from {two[0]:.2f} s to {two[-1]:.2f} s; they share "
            f"{max(common, 0.0):.2f} s"
        )


class _Joined(NamedTuple):
    """Frames of the first film that both views show: their numbers, both views' rows, and the fit; and of all frames
    why one is not used."""

    frames: NDArray[np.int64]
    rows: tuple[Floats, Floats]
    fit: Fit
    length: float
    typical: float
    reason: NDArray[np.int64]


def assemble(
    sightings: tuple[Sighting, Sighting],
    rig: Rig,
    shape: Shape,
    *,
    initial_gap: float,
    clock_offset: float | None = None,
    scenario: str | None = None,
    name: str = "measured run",
) -> Trajectory:
    """Join the sightings of two views into a trajectory; parameters as for :func:`track`.

    A first fit finds poses; drawings of the device at them tell what the detector makes of it, and the device's roll
    tells the clocks apart; a second fit uses both.
    """
    first, second = sightings
    interval = frame_interval(first.time)
    rough_offset = find_offset(first, second, rig).value if clock_offset is None else clock_offset
    rough = _joined(sightings, rough_offset, rig, ROUGHLY_APART)
    poses = _poses(rough, rig, shape)
    time = first.time[rough.frames]
    one, two = (
        prepared(sighting, camera, shape, time, poses, ahead, interval)
        for sighting, camera, ahead in zip(sightings, rig.cameras, (0.0, rough_offset), strict=True)
    )
    views = (one, two)
    clock = _clock(views, rig) if clock_offset is None else told(clock_offset, 0.0, rig)
    modelled = all(camera.wall is not None for camera in rig.cameras)  # else the views differ by what is left out
    limit = APART if modelled else ROUGHLY_APART
    joined = _joined((views[0].sighting, views[1].sighting), clock.value, rig, limit)
    poses = _poses(joined, rig, shape)
    spread = _spread(joined, views, clock.value)
    fresh = covariances(rig, shape, poses, spread, clock, np.ones(joined.frames.size))
    strays = _strays(first.time[joined.frames], poses.head, fresh.head_noise * joined.typical, interval)
    poses = DevicePoses(*(values[~strays] for values in poses))
    spread = Deviations(*(values[~strays] for values in spread))
    reason = joined.reason.copy()
    reason[joined.frames[strays]] = 3
    attributes = _attributes(first, reason, rig, shape, clock, joined.length, interval)
    if scenario is not None:
        attributes["scenario"] = scenario
    attributes |= {"name": name, "initial_gap": initial_gap, "end": str(_end(poses.head[-1], rig))}
    return _trajectory(first.time[joined.frames[~strays]], poses, spread, clock, joined.typical, rig, shape, attributes)


def _joined(sightings: tuple[Sighting, Sighting], ahead: float, rig: Rig, limit: float) -> _Joined:
    """Fit a pose to every frame of the first film that the second shows too, and leave out where they disagree."""
    first, second = sightings
    other = at(second, first.time + ahead)
    reason = np.zeros(first.time.size, dtype=np.int64)
    reason[~np.isfinite(other[:, 0])] = 2
    reason[~np.isfinite(first.rows[:, 0])] = 1
    used = np.flatnonzero(reason == 0)
    if used.size < 4:
        raise InputError(
            f"the device is in both views in {used.size} of {first.time.size} frames only; check clock_offset "
            f"and the calibration"
        )
    rows = (first.rows[used], other[used])
    length = float(np.nanmedian(lengths(rig, *rows)))
    fit = solve(rig, *rows, length)
    finite = np.isfinite(fit.misfit)
    typical = max(1.0, float(np.median(fit.misfit[finite])) / MEDIAN) if finite.any() else 1.0
    good = finite & (fit.misfit <= MISFIT * typical) & rig.inside(fit.middle, 1.5e-3)
    if good.sum() < 4:
        raise InputError("the two views never agree on the device; check the calibration and which film is which")
    apart = float(np.median(fit.apart[good]))
    if not apart <= limit:
        raise InputError(
            f"the two views must agree on the device to {limit:g} px; they are {apart:.1f} px apart: check that the "
            f"calibration is of these cameras, which film is which, and clock_offset"
        )
    reason[used[~good]] = 3
    return _Joined(
        used[good], (rows[0][good], rows[1][good]), Fit(*(values[good] for values in fit)), length, typical, reason
    )


def _poses(joined: _Joined, rig: Rig, shape: Shape) -> DevicePoses:
    darker = darker_end(rig, joined.fit, joined.rows)
    return oriented(joined.fit, darker, joined.length / 2.0 - shape.nose)


def _clock(views: tuple[PreparedView, PreparedView], rig: Rig) -> Clock:
    """The clock offset from lines of sight that meet and from the roll that both views show, as far as each tells.

    Lines of sight tell a clock from a shift of one view along the way only as far as calibration and detection go; the
    roll tells it at any speed.
    """
    sightings = (views[0].sighting, views[1].sighting)
    met = find_offset(*sightings, rig)
    rolled, meeting = by_rolls(views, rig, met), None
    if rolled is not None or met.found:
        start = met.value if rolled is None else rolled.value
        joined = _joined(sightings, start, rig, ROUGHLY_APART)
        meeting = by_meeting(views, joined.frames, joined.length, rig, start)
    certain = CERTAIN * frame_interval(sightings[0].time)
    known = [clock for clock in (meeting, rolled) if clock is not None and clock.sd < certain]
    if not known:
        return told(0.0, met.sd if np.isfinite(met.sd) else 0.0, rig, found=False)
    return known[0] if len(known) == 1 else combined(known[0], known[1])


def _spread(joined: _Joined, views: tuple[PreparedView, PreparedView], ahead: float) -> Deviations:
    """Standard deviations of the measured numbers of each used frame; the clock moves the second view's."""
    parts = [parted(rows, view) for rows, view in zip(joined.rows, views, strict=True)]
    fresh, lasting = (np.concatenate(pair, axis=1) for pair in zip(*parts, strict=True))
    rates = np.nan_to_num(clock_rates(views[1].sighting, views[0].sighting.time[joined.frames], ahead))
    moved = along_and_across(rates, joined.rows[1][:, HALF])
    return Deviations(fresh, lasting, np.concatenate([np.zeros_like(moved), moved], axis=1))


def _strays(time: Floats, head: Floats, covariance: Floats, interval: float) -> Flags:
    """Points that do not lie on their neighbours' polynomial, judged without themselves."""
    smoothed, weights = smooth(time, head, interval)
    own = weights[:, weights.shape[1] // 2]
    rest = (head - smoothed) / np.maximum(1.0 - own, 1e-9)[:, None]
    rest[own > 0.99] = 0.0
    spread = np.sqrt(np.maximum(np.einsum("nii->ni", covariance), (0.02e-3) ** 2))
    return np.asarray(np.any(np.abs(rest) > STRAY * 2.0 * spread, axis=1))


def _end(head: Floats, rig: Rig) -> End:
    """Why the film's last sample is the last: at a wall of the tank, or just the film's end."""
    low, high = head - rig.tank[0], rig.tank[1] - head
    if low[2] < TOUCH:
        return End.FLOOR
    if high[2] < TOUCH:
        return End.SURFACE
    return End.WALL if min(low[:2].min(), high[:2].min()) < TOUCH else End.HORIZON


REASONS = ("", "not seen by the first camera", "not seen by the second camera", "the views disagree")


def gaps_of(time: Floats, reason: NDArray[np.int64], interval: float) -> list[list[object]]:
    """Stretches without a sample: [from, until, reason], the times those of the last sample before and the first
    after."""
    gaps: list[list[object]] = []
    good = np.flatnonzero(reason == 0)
    for before, after in itertools.pairwise(good):
        if after > before + 1:
            worst = int(np.bincount(reason[before + 1 : after]).argmax())
            gaps.append([float(time[before]), float(time[after]), REASONS[worst]])
        elif time[after] - time[before] > 1.6 * interval:
            gaps.append([float(time[before]), float(time[after]), "frames lost"])
    return gaps


def _attributes(
    first: Sighting,
    reason: NDArray[np.int64],
    rig: Rig,
    shape: Shape,
    clock: Clock,
    length: float,
    interval: float,
) -> dict[str, object]:
    gaps = gaps_of(first.time, reason, interval)
    warnings = list(rig.notes.get("warnings", []))
    if not clock.found:
        warnings.append("the films show too little motion to align the clocks; they are taken to agree")
    expected = shape.length
    if abs(length / expected - 1.0) > 0.06:
        warnings.append(
            f"the device looks {1e3 * length:.2f} mm long, and {1e3 * expected:.2f} mm is expected: check "
            f"shape and calibration"
        )
    report = rig.notes.get("report", {})
    return {
        "source": "measured",
        "frames": "lab: z up; gaps are left out, see the attribute gaps",
        "gaps": json.dumps(gaps),
        "frames_first": int(first.time.size),
        "frames_used": int((reason == 0).sum()),
        "frame_interval": interval,
        "film_begin": float(first.time[0]),
        "film_end": float(first.time[-1]),
        "smoothed": f"local polynomial of degree {DEGREE} over {POINTS} frames, sharpened once",
        "clock_offset": clock.value,
        "clock_offset_sd": clock.sd if np.isfinite(clock.sd) else -1.0,
        "apparent_length": length,
        "position_accuracy": rig.accuracy,
        "scale_sd": float(report.get("held_out_scale_error", 0.0)),
        "warnings": json.dumps(warnings),
        "versions": versions(),
    }


def _trajectory(
    time: Floats,
    poses: DevicePoses,
    spread: Deviations,
    clock: Clock,
    typical: float,
    rig: Rig,
    shape: Shape,
    attributes: dict[str, object],
) -> Trajectory:
    interval = float(attributes["frame_interval"])  # type: ignore[arg-type]
    both, weights = sharpened(time, np.concatenate([poses.head, poses.axis], axis=1), interval)
    axis = both[:, 3:] / np.linalg.norm(both[:, 3:], axis=1, keepdims=True)
    level = np.sqrt(np.maximum(1.0 - axis[:, 2] ** 2, 1e-12))
    known = covariances(rig, shape, poses, spread, clock, np.sum(weights * weights, axis=1))
    raw = np.concatenate([poses.head, poses.axis], axis=1)
    own = 1.0 - 2.0 * weights[:, weights.shape[1] // 2] + np.sum(weights * weights, axis=1)
    lost = taken_away(raw - both, np.concatenate(noise_variances(poses, spread.fresh, own), axis=1))
    covariance = known.head + lost[:, :3, None] * np.eye(3)
    lean = known.axis[:, 2, 2] + lost[:, 5]
    return Trajectory.from_arrays(
        time,
        {
            "position": both[:, :3],
            "position_covariance": covariance,
            "position_noise": np.sqrt(np.einsum("nii->ni", known.head_noise)),
            "long_axis": axis,
            "attack_angle": np.arcsin(np.clip(axis[:, 2], -1.0, 1.0)),
            "attack_angle_sd": np.sqrt(lean) / level,
            "misfit": poses.misfit / typical,
            "segment": np.concatenate([[0.0], np.cumsum(np.diff(time) > 1.6 * interval)]),
        },
        attributes,
    )
