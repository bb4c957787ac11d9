"""Tracking: from two films to a measured trajectory, and a clip to check it by eye."""

from helimag.vision.tracking.assembly import track
from helimag.vision.tracking.clip import review

__all__ = ["review", "track"]
