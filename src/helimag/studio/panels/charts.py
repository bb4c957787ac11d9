"""Charts over time."""

from nicegui import ui

from helimag.studio.elements import Charts


def charts() -> None:
    """Build the charts; they draw what the scene draws."""
    Charts().classes("hs-fill")
    ui.label("Drag in the charts to scrub; arrow keys step, the space bar plays.").classes("hs-small")
