"""Calibrate two cameras and the walls that they look through, from pictures of a board in air and in the tank."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from helimag.errors import InputError
from helimag.vision.calibration.accuracy import held_out, remarks
from helimag.vision.calibration.in_air import board_pose, intrinsics, stereo
from helimag.vision.calibration.joint import Joint
from helimag.vision.calibration.pictures import Found, find_boards
from helimag.vision.calibration.placements import Pose
from helimag.vision.calibration.session import Session
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

    Raises
    ------
    InputError
        Where there are too few usable pictures.
    """
    watch = progress or (lambda _: None)
    found, sizes = find_boards(session, watch)
    cameras = []
    errors = {}
    for view, seen, size in zip(session.views, found, sizes, strict=True):
        matrix, distortion, errors[view.name] = intrinsics(session, seen["air"], size)
        cameras.append(Camera(view.name, matrix, distortion, np.eye(3), np.zeros(3), size))
    fitted, kept = _divided(session, found)
    watch(0.65)
    lab = Pose(session.rotation, session.position)
    report: dict[str, Any] = {
        "intrinsics_rms_px": errors,
        "pictures": {kind: len(names) for kind, names in fitted.items()},
    }
    if refraction:
        second = stereo(session, found, cameras, fitted["air"])
        problem = Joint(session, found, (cameras[0], cameras[1]), fitted)
        result = problem.solve(second)
        watch(0.95)
        rig = problem.rig(result.x, lab)
        report |= problem.describe(result)
    else:
        rig = _straight(session, found, (cameras[0], cameras[1]), lab)
    report |= held_out(session, rig, found, kept)
    rig = replace(rig, accuracy=report["held_out_rms_mm"] * 1e-3)
    warnings = remarks(session, rig, report)
    rig = replace(rig, notes={"report": report, "warnings": warnings})
    watch(1.0)
    return Calibration(rig, report, warnings)


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
