"""Calibrate two cameras and the walls that they look through, from pictures of a board in air and in the tank."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from helimag.errors import InputError
from helimag.vision.calibration.accuracy import cost_of_ignoring, held_out, remarks
from helimag.vision.calibration.checks import check_accuracy, check_fit, check_index, check_lenses, check_walls
from helimag.vision.calibration.in_air import board_pose, intrinsics, misfit, stereo
from helimag.vision.calibration.joint import INDEX, WALLS, Fitted, Joint
from helimag.vision.calibration.lenses import read_lens
from helimag.vision.calibration.pictures import Found, find_boards
from helimag.vision.calibration.placements import Pose
from helimag.vision.calibration.session import Session
from helimag.vision.calibration.starts import starting_values
from helimag.vision.calibration.variants import variants
from helimag.vision.cameras import Camera, Rig

HELD_OUT = 2  # pictures in the tank that the fit does not see
LEAST_OIL = 5


@dataclass(frozen=True)
class Calibration:
    """A calibrated rig and how good it is; ``report`` has pixels and millimetres, ``warnings`` what to mind."""

    rig: Rig
    report: dict[str, Any]
    warnings: list[str]


def calibrate(
    session: Session, *, refraction: bool = True, progress: Callable[[float], None] | None = None
) -> Calibration:
    """Intrinsics from pictures in air, then extrinsics, walls and lab frame from pictures in air and in the tank.

    Intrinsics and first extrinsics are OpenCV's. Then one least-squares fit of all pictures that both cameras share, in
    air and in oil, gives the extrinsics, each wall's direction and distance, where asked for the oil's index, and every
    board's pose. Two pictures in the tank are held out, and the errors in millimetres are theirs.

    Parameters
    ----------
    refraction
        False: take light to go straight, each camera posed by the datum alone, as one would without a model of the
        wall.

    Returns
    -------
    Calibration
        The rig, and how well it fits.

    Raises
    ------
    InputError
        Where there are too few usable pictures.
    """
    watch = progress or (lambda _: None)
    board, found, sizes = find_boards(session, watch)
    session = replace(session, board=board)
    cameras = []
    errors = {}
    for number, (view, seen, size) in enumerate(zip(session.views, found, sizes, strict=True), 1):
        if view.lens is None:
            matrix, distortion, errors[view.name] = intrinsics(session, seen["air"], size)
        else:
            matrix, distortion = read_lens(view.lens, number)
            errors[view.name] = misfit(session, seen["air"], matrix, distortion)
        cameras.append(Camera(view.name, matrix, distortion, np.eye(3), np.zeros(3), size))
    check_lenses(errors)
    fitted, kept = _divided(session, found)
    watch(0.65)
    report: dict[str, Any] = {
        "intrinsics_rms_px": errors,
        "pictures": {kind: len(names) for kind, names in fitted.items()},
    }
    pair = (cameras[0], cameras[1])
    if refraction:
        problem = Joint(session, found, pair, fitted)
        rig = _refracted(session, problem, found, fitted["air"], report)
    else:
        rig = _straight(session, found, pair, Pose(session.rotation, session.position))
    watch(0.95)
    report |= held_out(session, rig, found, kept)
    if refraction:
        check_accuracy(session, report)
        report |= cost_of_ignoring(rig)
    else:
        rig = replace(rig, accuracy=report["held_out_rms_mm"] * 1e-3)
    warnings = remarks(session, rig, report)
    rig = replace(rig, notes={"report": report, "warnings": warnings})
    watch(1.0)
    return Calibration(rig, report, warnings)


def _refracted(session: Session, problem: Joint, found: Found, in_air: list[str], report: dict[str, Any]) -> Rig:
    """The rig that explains all pictures best, once it has passed every check; adds to the report."""
    second = stereo(session, found, list(problem.cameras), in_air)
    start = starting_values(problem, session, found, second)
    fitted = problem.fit(start)
    clean = fitted.clean()
    fitted = problem.fit(fitted.values, counted=clean, noise=float(np.std(fitted.residuals[clean])))
    check_fit(problem, fitted)
    if not session.estimate_oil:
        check_index(session, fitted)
        fitted = problem.fit(fitted.values, counted=fitted.counted, oil_known=True, noise=fitted.noise)
    fitted, widened = problem.widened(fitted)
    lab = Pose(session.rotation, session.position)
    rig = problem.rig(fitted.values, lab)
    check_walls(session, rig, fitted)
    others, sd = variants(problem, fitted, rig, lab)
    report |= _described(problem, fitted)
    report["position_sd_mm"] = 1e3 * sd
    report["variance_by_pictures"] = widened
    return replace(rig, accuracy=sd / np.sqrt(3.0), variants=tuple(other.cameras for other in others))


def _described(problem: Joint, fitted: Fitted) -> dict[str, Any]:
    """Errors of the fit in pixels, and the walls and the index with their standard deviations."""
    walls = {}
    for view, camera in enumerate(problem.cameras):
        at = WALLS + 3 * view
        lean = np.hypot(fitted.values[at], fitted.values[at + 1])
        walls[camera.name] = {
            "distance_mm": 1e3 * float(fitted.values[at + 2]),
            "distance_sd_mm": 1e3 * fitted.spread(at + 2),
            "tilt_to_camera_deg": float(np.degrees(np.arctan(lean))),
            "tilt_sd_deg": float(np.degrees(max(fitted.spread(at), fitted.spread(at + 1)))),
        }
    return {
        "joint_rms_px": {c.name: problem.rms(fitted, view) for view, c in enumerate(problem.cameras)},
        "walls": walls,
        "oil_index": float(fitted.values[INDEX]),
        "oil_index_sd": fitted.spread(INDEX),
    }


def _divided(session: Session, found: Found) -> tuple[dict[str, list[str]], list[str]]:
    """Names of the shared pictures that are fitted, by kind, and of those in the tank that are held out."""
    shared = {kind: sorted(set(found[0][kind]) & set(found[1][kind])) for kind in ("air", "oil")}
    if session.datum not in shared["oil"]:
        raise InputError(f"datum.picture must show the board in the tank to both cameras; '{session.datum}' does not")
    if len(shared["oil"]) < LEAST_OIL or not shared["air"]:
        raise InputError(
            f"the cameras must share at least one picture in air and {LEAST_OIL} in the tank in which both find the "
            f"board; they share {len(shared['air'])} and {len(shared['oil'])} (same file name in both folders)"
        )
    kept = [name for name in shared["oil"] if name != session.datum][-HELD_OUT:]
    return {"air": shared["air"], "oil": [name for name in shared["oil"] if name not in kept]}, kept


def _straight(session: Session, found: Found, cameras: tuple[Camera, Camera], lab: Pose) -> Rig:
    posed = []
    for seen, camera in zip(found, cameras, strict=True):
        pose = board_pose(session, camera, seen["oil"][session.datum]).after(lab.inverse)
        posed.append(replace(camera, rotation=pose.rotation, translation=pose.translation))
    return Rig((posed[0], posed[1]), session.tank)
