"""PyAV, or the name of the extra that brings it."""

from helimag.errors import MissingExtra

try:
    import av
except ImportError:
    raise MissingExtra("films need PyAV; install it with: pip install 'helimag[vision]'") from None

__all__ = ["av"]
