"""How far the detector is off on this device: measured on drawings of it at poses of the run, and taken away."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from helimag.vision._cv import cv2
from helimag.vision.cameras import Camera
from helimag.vision.shape import Shape
from helimag.vision.silhouette import outline, silhouette
from helimag.vision.tracking.detection import COIL, HALF, MIDDLE, RISE, blobs, measure

Floats = NDArray[np.float64]

DRAWN = 32  # poses drawn for each view
BLURS = (0.6, 1.2)  # of the drawings (px); the film's is found between and beyond them
DARK = 0.4  # of full darkness: threshold of a drawn blob
LEAST = 16  # drawings from which errors are fitted


class Errors(NamedTuple):
    """Of the detector in one view (px).

    ``terms`` (k, 4) are coefficients of :func:`_terms`, along and across the device, of its middle and of its half
    length; ``left`` (4,) how well the drawings tell them, as standard deviations of the numbers that are fitted. What
    the terms do not explain differs from frame to frame, and is counted with the film's own noise.
    The device's roll about its axis is ``sense`` times the coil's phase plus terms with coefficients ``roll_terms``
    (k,), to ``roll_sd`` (rad), which is how well the drawings tell the terms.
    """

    terms: Floats
    left: Floats
    sense: float
    roll_terms: Floats
    roll_sd: float

    def rolls(self, rows: Floats, tilt: Floats) -> Floats:
        """The device's roll (n,) in rows of detections, at their tilts (n,)."""
        phase = phases(rows)
        return np.asarray(self.sense * phase + _terms(phase, tilt) @ self.roll_terms)


def axis_frame(axis: Floats) -> Floats:
    """Rotation (..., 3, 3) whose first column is an axis, and its third as far up as that allows: roll zero."""
    up = np.where(np.abs(axis[..., 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    side = np.cross(up, axis)
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    return np.stack([axis, side, np.cross(axis, side)], axis=-1)


def tilts(camera: Camera, head: Floats, axis: Floats) -> Floats:
    """Sine of the angle at which the axis points away from a camera (n,), along the light in the oil."""
    return np.asarray(np.sum(camera.rays(camera.project(head))[1] * axis, axis=-1))


def _terms(phase: Floats, tilt: Floats) -> Floats:
    """What the errors depend on (n, k): the coil's phase, since coils end somewhere, and the tilt, since a tilted helix
    looks heavier on one side."""
    one = np.ones_like(phase)
    waves = [one, np.cos(phase), np.sin(phase), np.cos(2 * phase), np.sin(2 * phase)]
    return np.stack([*waves, tilt, tilt * np.cos(phase), tilt * np.sin(phase)], axis=1)


def detector_errors(camera: Camera, head: Floats, axis: Floats, shape: Shape, rise: float) -> Errors | None:
    """Draw the device at poses of the run, each at another roll, detect it, and compare with where its ends are.

    Parameters
    ----------
    head, axis
        (n, 3) in m, and unit vectors: poses found in the run.
    rise
        Over which darkness rises at the ends in the film (px, median): tells its blur.

    Returns
    -------
    Errors or None
        None where the device is not slender in this view, so nothing is taken away.
    """
    chosen = np.linspace(0, head.shape[0] - 1, DRAWN).round().astype(int)
    rolls = 2.0 * np.pi * ((np.arange(DRAWN) * 0.618034) % 1.0)
    drawn: list[list[Floats]] = [[], []]
    for place, roll in zip(chosen, rolls, strict=True):
        rows = _drawn(camera, head[place], axis[place], float(roll), shape)
        if rows is not None:
            for kept, row in zip(drawn, rows, strict=True):
                kept.append(row)
    if len(drawn[0]) < LEAST:
        return None
    tables = [np.stack(rows) for rows in drawn]
    rises = [float(np.median(table[:, 2])) for table in tables]
    share = float(np.clip((rise**2 - rises[0] ** 2) / (rises[1] ** 2 - rises[0] ** 2), -0.3, 3.0))
    fits = []
    for table in tables:
        terms = _terms(table[:, 1], table[:, 3])
        fits.append(np.linalg.lstsq(terms, table[:, 4:], rcond=None)[0])
    terms = (1.0 - share) * fits[0] + share * fits[1]
    rest = tables[0][:, 4:] - _terms(tables[0][:, 1], tables[0][:, 3]) @ fits[0]
    ends = np.stack([rest[:, 0] + rest[:, 2], rest[:, 1], rest[:, 0] - rest[:, 2], rest[:, 3]], axis=1)
    left = np.sqrt(np.mean(ends**2, axis=0) * _share_of_terms(rest.shape[0], terms.shape[0]))
    return Errors(terms, left, *_roll(tables, share))


def _share_of_terms(drawings: int, terms: int) -> float:
    """Variance of fitted values over that of what the fit leaves: both grow with the drawings' scatter."""
    return terms / max(1, drawings - terms)


def _roll(tables: list[Floats], share: float) -> tuple[float, Floats, float]:
    """How the coil's phase tells the roll: sense and terms at the film's blur, and their standard error (rad)."""
    coefficients, spreads = [], []
    phase = tables[0][:, 1]
    turns = {sense: np.exp(1j * (tables[0][:, 0] - sense * phase)) for sense in (1.0, -1.0)}
    sense = max(turns, key=lambda each: abs(turns[each].mean()))
    zero = float(np.angle(turns[sense].mean()))
    for table in tables:
        terms = _terms(table[:, 1], table[:, 3])
        off = np.angle(np.exp(1j * (table[:, 0] - sense * table[:, 1] - zero)))
        fitted = np.linalg.lstsq(terms, off, rcond=None)[0]
        rest = off - terms @ fitted
        coefficients.append(fitted)
        spreads.append(float(np.sqrt(np.mean(rest**2) * _share_of_terms(rest.size, fitted.size))))
    roll_terms = (1.0 - share) * coefficients[0] + share * coefficients[1]
    roll_terms[0] += zero
    return sense, roll_terms, max(spreads)


def _drawn(camera: Camera, head: Floats, axis: Floats, roll: float, shape: Shape) -> tuple[Floats, Floats] | None:
    """What the detector makes of a drawing, at each blur: roll, phase, rise, tilt, and four errors (px)."""
    turn = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(roll), -np.sin(roll)], [0.0, np.sin(roll), np.cos(roll)]])
    rotation = axis_frame(axis) @ turn
    box = outline(camera, head[None], rotation[None], shape)
    if box is None:
        return None
    cover = silhouette(camera, head, rotation, shape, box)
    nose, tail = camera.project(np.stack([head + shape.nose * axis, head + shape.tail * axis]))
    length = 2.0 * shape.head_reach * float(camera.scale(head[None])[0])
    tilt = float(tilts(camera, head[None], axis[None])[0])
    rows = []
    for blur in BLURS:
        dark = cv2.GaussianBlur(cover, (0, 0), blur).astype(np.float32)
        found = blobs(dark, DARK, 4.0)
        seen = measure(dark, *found[0], head_length=length, turns=shape.turns) if found else None
        if seen is None or not np.isfinite(seen.rise):
            return None
        forward = (nose - tail)[None]
        row = from_nose(turned(seen.shifted(box[0], box[1]).row[None], forward), forward, shape.turns)[0]
        along = (nose - tail) / np.linalg.norm(nose - tail)
        frame = np.stack([along, [-along[1], along[0]]])
        off = [*(frame @ (row[MIDDLE] - (nose + tail) / 2.0)), *(frame @ (row[HALF] - (nose - tail) / 2.0))]
        rows.append(np.array([roll, float(phases(row[None])[0]), row[RISE], tilt, *off]))
    return rows[0], rows[1]


def phases(rows: Floats) -> Floats:
    """Phase of the coil (n,) in rad, as it is counted in the rows."""
    return np.asarray(np.arctan2(rows[:, COIL.stop - 1], rows[:, COIL.start]))


def turned(rows: Floats, ahead: Floats) -> Floats:
    """Rows whose half length points along the directions ``ahead`` (n, 2), as in :meth:`Detection.along`."""
    sense = np.where(np.sum(rows[:, HALF] * ahead, axis=1) < 0.0, -1.0, 1.0)
    result = rows.copy()
    result[:, HALF] *= sense[:, None]
    result[:, 9] *= sense
    result[:, COIL.start] *= sense
    return result


def from_nose(rows: Floats, forward: Floats, turns: float) -> Floats:
    """Rows whose coil's phase is counted from the nose, not by way of the faint end that compression moves.

    Parameters
    ----------
    forward
        (n, 2): from tail to nose, where a fit puts them (px).
    turns
        Of the helix over the device's length.
    """
    share = 2.0 * np.linalg.norm(rows[:, HALF], axis=1) / np.linalg.norm(forward, axis=1)
    coil = (rows[:, COIL.start] + 1j * rows[:, COIL.stop - 1]) * np.exp(1j * np.pi * turns * share)
    result = rows.copy()
    result[:, COIL.start], result[:, COIL.stop - 1] = coil.real, coil.imag
    return result


def corrected(rows: Floats, errors: Errors, tilt: Floats) -> Floats:
    """Rows less the detector's errors; those of a device that is not slender stay as they are."""
    slender = np.isfinite(rows[:, RISE])
    result = rows.copy()
    part = rows[slender]
    off = _terms(phases(part), tilt[slender]) @ errors.terms
    along = part[:, HALF] / np.linalg.norm(part[:, HALF], axis=1, keepdims=True)
    frame = np.stack([along, np.stack([-along[:, 1], along[:, 0]], axis=1)], axis=1)
    result[slender, MIDDLE] -= np.einsum("nk,nki->ni", off[:, :2], frame)
    result[slender, HALF] -= np.einsum("nk,nki->ni", off[:, 2:], frame)
    return result
