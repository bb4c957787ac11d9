"""Two cameras on a tank: calibrate them, track a device in their films, and try both on rendered ones."""

from helimag.vision.calibration import Board, Calibration, Session, calibrate
from helimag.vision.cameras import Camera, Rig
from helimag.vision.films import Film, FilmWriter
from helimag.vision.refraction import Wall
from helimag.vision.shape import Shape
from helimag.vision.synthetic import Effects, paper_rig, render_run, render_session, score, staged
from helimag.vision.tracking import review, track

__all__ = [
    "Board",
    "Calibration",
    "Camera",
    "Effects",
    "Film",
    "FilmWriter",
    "Rig",
    "Session",
    "Shape",
    "Wall",
    "calibrate",
    "paper_rig",
    "render_run",
    "render_session",
    "review",
    "score",
    "staged",
    "track",
]
