"""The scene, and the pictures that scene and charts are drawn from."""

from nicegui import ui

from helimag.studio.elements import SceneView
from helimag.studio.live import News
from helimag.studio.pictures import Shelf
from helimag.studio.tab import Tab


def stage(tab: Tab, shelf: Shelf) -> None:
    """Build the scene, and send it the newest picture."""
    with ui.element("section").classes("hs-stage hs-panel").props('aria-label="Scene"'):
        SceneView()

    def heard(news: News) -> None:
        if news.picture is not None:
            shelf.live = news.picture.packet
            # the page asks for it when it can, and gets the newest
            ui.run_javascript(
                f"import('helimag-studio').then(m => m.runs.show('{shelf.address('live')}', {news.number}))"
            )

    tab.news_listeners.append(heard)
