"""How good a calibrated rig is: on boards that the fit has not seen, and beside one that ignores refraction."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.vision.calibration.pictures import Found, common
from helimag.vision.calibration.session import Session
from helimag.vision.calibration.variants import grid
from helimag.vision.cameras import Rig

Floats = NDArray[np.float64]

SHARP = 0.5  # px to which lenses fit with sharp pictures of a flat board


def held_out(session: Session, rig: Rig, found: Found, names: list[str]) -> dict[str, Any]:
    """Triangulated corners of boards that the fit has not seen, against the board: rigid fit, and with a scale."""
    errors, scales, misses = [], [], []
    for name in names:
        numbers, first, second = common(found[0]["oil"][name], found[1]["oil"][name])
        if numbers.size < 4:
            continue
        points, miss = rig.triangulate(first, second)
        fitted, scale = rigid(session.board.corners[numbers], points)
        errors.append(np.sum((points - fitted) ** 2, axis=1))
        scales.append(scale - 1.0)
        misses.append(miss)
    if not errors:
        raise InputError("the pictures held out in the tank must show the board to both cameras")
    return {
        "held_out": names,
        "held_out_rms_mm": 1e3 * float(np.sqrt(np.concatenate(errors).mean())),
        "held_out_scale_error": float(np.abs(scales).max()),
        "held_out_miss_mm": 1e3 * float(np.concatenate(misses).mean()),
    }


def rigid(points: Floats, seen: Floats) -> tuple[Floats, float]:
    """``points`` moved rigidly onto ``seen`` as well as possible, and the scale that would fit best (Umeyama 1991)."""
    one, two = points - points.mean(axis=0), seen - seen.mean(axis=0)
    left, stretch, right = np.linalg.svd(two.T @ one)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    scale = float((stretch * sign).sum() / np.sum(one * one))
    return one @ ((left * sign) @ right).T + seen.mean(axis=0), scale


def cost_of_ignoring(rig: Rig) -> dict[str, float]:
    """How far off points in the tank would be (mm) if light were taken to go straight; and after the best rigid
    shift."""
    points = grid(rig, 7)
    if points.shape[0] < 4:
        raise InputError("the cameras must both see the tank; the calibrated ones share less than four points of it")
    straight, _ = rig.without_refraction().triangulate(*(camera.project(points) for camera in rig.cameras))
    moved, _ = rigid(points, straight)
    return {
        "ignoring_refraction_rms_mm": 1e3 * float(np.sqrt(np.mean(np.sum((straight - points) ** 2, axis=1)))),
        "ignoring_refraction_after_shift_rms_mm": 1e3
        * float(np.sqrt(np.mean(np.sum((straight - moved) ** 2, axis=1)))),
    }


def remarks(session: Session, rig: Rig, report: dict[str, Any]) -> list[str]:
    """What to mind of a calibration that may be used."""
    claimed = 1e3 * session.accuracy
    warnings = []
    if rig.cameras[0].wall is None:
        warnings.append("refraction is ignored: lengths and depths in the tank are off")
        if report["held_out_rms_mm"] > claimed:
            warnings.append(
                f"held-out boards are off by {report['held_out_rms_mm']:.3f} mm rms, more than the {claimed:.2f} mm "
                f"claimed"
            )
    worst = max(report["intrinsics_rms_px"].values())
    if worst > SHARP:
        warnings.append(
            f"intrinsics fit to {worst:.2f} px only; {SHARP:g} px or less is usual: check for blur and a bent board"
        )
    return warnings
