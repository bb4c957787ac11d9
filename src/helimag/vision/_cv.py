"""OpenCV, or the name of the extra that brings it."""

from helimag.errors import MissingExtra

try:
    import cv2
except ImportError:
    raise MissingExtra.of("tracking", "opencv-python-headless", "vision") from None

# what fails is raised in a line of our own
if hasattr(cv2, "setLogLevel"):  # OpenCV 4
    cv2.setLogLevel(0)
else:
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
cv2.setNumThreads(1)  # pictures are small; two views are two threads already

__all__ = ["cv2"]
