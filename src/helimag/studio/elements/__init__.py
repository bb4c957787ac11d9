"""The page's own elements: each a Vue component beside this file."""

from typing import Any

from nicegui import ui

SHARED = {"helimag-studio": "../static"}


class SceneView(ui.element, component="scene.js", esm=SHARED):
    """The tank in three dimensions, with the controls of time."""


class Charts(ui.element, component="charts.js", esm=SHARED):
    """Time series of the run, linked to the scene's time."""


class KnobRow(ui.element, component="knob.js", esm=SHARED):
    """An input with its number and its slider; events ``turn`` (on the way) and ``typed``, each with the value."""

    def show(self, value: float) -> None:
        """Set the value, where the hand is not on it."""
        if self._props.get("value") != value:
            self._props["value"] = value
            self.update()


class Map(ui.element, component="map.js", esm=SHARED):
    """A map over two inputs.

    Its properties are ``first``, ``second`` (label, unit, low, high), ``cells``, ``curves``, ``point``, ``box``,
    ``what`` and ``stale``; a click is the event ``pick``.
    """

    def show(self, **given: Any) -> None:
        """Set properties, all at once."""
        for name, value in given.items():
            self._props[name] = value
        self.update()
