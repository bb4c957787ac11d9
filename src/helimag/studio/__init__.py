"""The studio: a local web page with live run, scene, charts, map and the rest (the extra ``studio``)."""

from importlib.util import find_spec

from helimag.errors import MissingExtra

if find_spec("nicegui") is None:
    raise MissingExtra.of("the studio", "nicegui", "studio")

from helimag.studio.intake import link_of
from helimag.studio.server import serve

__all__ = ["link_of", "serve"]
