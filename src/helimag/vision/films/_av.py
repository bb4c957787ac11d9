"""PyAV, or the name of the extra that brings it."""

from helimag.errors import MissingExtra

try:
    import av
except ImportError:
    raise MissingExtra.of("reading films", "av", "vision") from None

__all__ = ["av"]
