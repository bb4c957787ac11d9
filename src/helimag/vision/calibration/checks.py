"""What a calibration must show before it may be used: each failure is refused with its number."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.vision.calibration.joint import INDEX, WALLS, Fitted, Joint
from helimag.vision.calibration.session import FACES, Session
from helimag.vision.cameras import Camera, Rig

Floats = NDArray[np.float64]

LENS_RMS = 1.0  # px: a sharp board and the right squares fit to a tenth of that
IN_OIL = 2.0  # times the misfit in air that the misfit in the tank may reach, and
IN_OIL_MORE = 0.1  # px that it may lie above that
LOST = 0.1  # share of the corners that may lie far off: blur, glare, a finger
CERTAIN = 4.0  # standard deviations
OFF_FACE = 2e-3  # by which a fitted wall may lie beside the tank's face (m): tanks are measured with a ruler
OFF_FACE_ANGLE = np.radians(3.0)


def check_lenses(errors: dict[str, float]) -> None:
    """Refuse lenses that do not explain the pictures in air.

    Raises
    ------
    InputError
        Where one fits to more than a pixel.
    """
    for name, rms in errors.items():
        if not rms <= LENS_RMS:
            raise InputError(
                f"the pictures in air of camera {name} must fit a lens to {LENS_RMS:g} px; they fit to {rms:.2f} px: "
                f"check that they are this camera's, that [board] is the printed one, and that it is flat"
            )


def check_index(session: Session, fitted: Fitted) -> None:
    """Refuse an oil index that the pictures contradict; ``fitted`` has it free.

    Raises
    ------
    InputError
        With both numbers.
    """
    found, declared = float(fitted.values[INDEX]), session.indices[2]
    sd = float(np.hypot(fitted.spread(INDEX), session.index_sds[1]))
    if not abs(found - declared) <= CERTAIN * sd:
        raise InputError(
            f"tank.indices must fit the pictures: they show an oil of index {found:.4f} ± {sd:.4f}, and "
            f"{declared:g} is given; measure it, check wall and board, or set estimate_oil = true"
        )


def check_fit(problem: Joint, fitted: Fitted) -> None:
    """Refuse a model of lenses and walls that explains the pictures in the tank worse than those in air.

    Raises
    ------
    InputError
        With both misfits (px).
    """
    lost = 1.0 - float(fitted.counted.mean())
    if lost > LOST:
        raise InputError(
            f"the board's corners must lie where one model puts them; {100.0 * lost:.0f} % are far off: check that "
            f"pictures of the same name belong together, that nothing moved, and that the board is flat"
        )
    for view, camera in enumerate(problem.cameras):
        air, oil = (problem.rms(fitted, view, medium) for medium in ("air", "oil"))
        if not air <= LENS_RMS:
            raise InputError(
                f"the cameras' pictures in air must fit one pair of cameras to {LENS_RMS:g} px; those of {camera.name} "
                f"fit to {air:.2f} px: check that pictures of the same name belong together, and that nothing moved"
            )
        if not oil <= IN_OIL * air + IN_OIL_MORE:
            raise InputError(
                f"the pictures in the tank must fit as well as those in air: those of camera {camera.name} fit to "
                f"{oil:.2f} px, and {air:.2f} px in air: check indices, wall and folders, and that neither tank nor "
                f"cameras moved"
            )


def check_walls(session: Session, rig: Rig, fitted: Fitted) -> None:
    """Refuse walls that are not where the tank's faces are said to be.

    Raises
    ------
    InputError
        With the distance between them, or the angle.
    """
    middle = session.tank.mean(axis=0)
    for view, (camera, given) in enumerate(zip(rig.cameras, session.views, strict=True)):
        face, inward, flat = face_of(session, camera)
        if given.wall is not None and given.wall != face:
            raise InputError(
                f"camera {camera.name} must look through the wall '{given.wall}'; its pictures show that it looks "
                f"through '{face}': check which folder is whose"
            )
        wall = camera.wall
        if wall is None:
            continue
        lean = float(np.arccos(np.clip(wall.normal @ inward, -1.0, 1.0)))
        inner = wall.point + wall.thickness * wall.normal
        across = middle - ((middle - flat) @ inward) * inward  # the middle of the face
        off = float((across - inner) @ wall.normal)
        sd = fitted.spread(WALLS + 3 * view + 2)
        if lean > OFF_FACE_ANGLE + CERTAIN * fitted.spread(WALLS + 3 * view) or abs(off) > OFF_FACE + CERTAIN * sd:
            raise InputError(
                f"the wall before camera {camera.name} must be the tank's face '{face}'; the pictures show it "
                f"{1e3 * abs(off):.1f} mm and {np.degrees(lean):.1f} deg from there: check [tank], [datum] and the "
                f"board's sizes, and that the tank has not moved"
            )


def face_of(session: Session, camera: Camera) -> tuple[str, Floats, Floats]:
    """Name of the tank's face that a camera looks through, its inward normal, and a corner on it."""
    wall = camera.wall
    direction = camera.rotation[2] if wall is None else wall.normal
    axis = int(np.argmax(np.abs(direction)))
    inward = np.zeros(3)
    inward[axis] = np.sign(direction[axis])
    return FACES[axis + (0 if inward[axis] > 0.0 else 3)], inward, session.tank[0 if inward[axis] > 0.0 else 1]


def check_accuracy(session: Session, report: dict[str, Any]) -> None:
    """Refuse a rig that cannot give what the session claims.

    Raises
    ------
    InputError
        Where held-out boards, or the covariance of the fit, say more than ``accuracy``.
    """
    claimed = 1e3 * session.accuracy
    for key, what in (
        ("position_sd_mm", "the fit leaves points in the tank uncertain by"),
        ("held_out_rms_mm", "boards that the fit has not seen are off by"),
    ):
        if not report.get(key, 0.0) <= claimed:
            raise InputError(
                f"accuracy must be what the pictures can give: {what} {report[key]:.3f} mm, and {claimed:.3f} mm is "
                f"claimed; take more pictures, nearer and tilted more, or claim less"
            )
