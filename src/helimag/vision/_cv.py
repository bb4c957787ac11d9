"""OpenCV, or the name of the extra that brings it."""

from helimag.errors import MissingExtra

try:
    import cv2
except ImportError:
    raise MissingExtra.of("tracking", "opencv-python-headless", "vision") from None

cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # what fails is raised in a line of our own
cv2.setNumThreads(1)  # pictures are small; two views are two threads already

__all__ = ["cv2"]
