"""Calibration: cameras, walls and lab frame from pictures of a board."""

from helimag.vision.calibration.boards import Board
from helimag.vision.calibration.fit import Calibration, calibrate
from helimag.vision.calibration.session import FACES, Session

__all__ = ["FACES", "Board", "Calibration", "Session", "calibrate"]
