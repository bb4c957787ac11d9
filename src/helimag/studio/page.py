"""The page: its bar, inputs, verdict, scene, and the side with charts, map and the rest."""

from dataclasses import dataclass
from pathlib import Path

from nicegui import app, ui

from helimag.errors import HelimagError
from helimag.studio.intake import scenario_from_link
from helimag.studio.panels.bar import bar
from helimag.studio.panels.charts import charts
from helimag.studio.panels.compare import ComparePanel
from helimag.studio.panels.ensemble import EnsemblePanel
from helimag.studio.panels.explain import explain_panel
from helimag.studio.panels.inputs import inputs
from helimag.studio.panels.map import MapPanel
from helimag.studio.panels.robot import robot_panel
from helimag.studio.panels.stage import stage
from helimag.studio.panels.tour import Side, tour
from helimag.studio.panels.verdict import verdict
from helimag.studio.pictures import Shelf, drop_shelf, new_shelf
from helimag.studio.state import TabState
from helimag.studio.tab import Tab, kept_in_browser

TABS = {
    "Charts": "show_chart",
    "Map": "map",
    "Compare": "compare",
    "Robot": "precision_manufacturing",
    "Explain": "lightbulb",
    "Ensemble": "casino",
}
PATIENCE = 120.0  # s in which a page's scripts must come to life; a machine may have other things to do
STYLE = (Path(__file__).parent / "static" / "studio.css").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Setting:
    """What new tabs begin with."""

    state: TabState
    demo: bool = False


async def page(setting: Setting, link: str | None) -> None:
    """Build the page for one browser tab."""
    ui.add_css(STYLE)
    ui.query("body").classes("hs-body")
    waiting = ui.label("helimag studio").classes("hs-waiting")
    await ui.context.client.connected(timeout=PATIENCE)
    if ui.context.client.is_deleted:  # a browser that went away, or lost the line and asks for a page of its own
        return
    waiting.delete()
    store = app.storage.tab
    problem = None
    state = setting.state
    if "state" in store:
        state = TabState.stored(store["state"])
    elif link is None:
        try:
            kept = await kept_in_browser()
            state = state if kept is None else TabState.of(kept)
        except HelimagError as error:
            problem = f"what was set before this server began cannot be set again: {error}"
    if link is not None:
        try:
            linked = TabState.of(scenario_from_link(link))
            state = linked if linked.toml != state.toml else state
        except HelimagError as error:
            problem = str(error)
        ui.run_javascript("history.replaceState(null, '', location.pathname)")
    tab = Tab(store, state)
    shelf = new_shelf()
    ui.context.client.on_delete(lambda: drop_shelf(shelf))
    bar(tab)
    with ui.element("main").classes("hs-main"):
        inputs(tab)
        with ui.element("div").classes("hs-middle"):
            verdict(tab)
            stage(tab, shelf)
        with ui.element("section").classes("hs-side hs-panel"):
            side = _side(tab, shelf)
    if problem is not None:
        tab.complain(problem)
    tab.begin()
    if setting.demo and not store.get("toured"):
        store["toured"] = True
        tour(tab, side)


def _side(tab: Tab, shelf: Shelf) -> Side:
    """The tabs at the side."""
    with ui.tabs().props("dense no-caps outside-arrows mobile-arrows align=justify") as tabs:
        for name, icon in TABS.items():
            ui.tab(name, icon=icon).props(f'data-testid="tab-{name.lower()}"')
    with ui.tab_panels(tabs, value="Charts", animated=False):
        with ui.tab_panel("Charts"):
            charts()
        with ui.tab_panel("Map"):
            map_panel = MapPanel(tab)
        with ui.tab_panel("Compare"):
            compare_panel = ComparePanel(tab, shelf)
        with ui.tab_panel("Robot"):
            check = robot_panel(tab)
        with ui.tab_panel("Explain"):
            explain = explain_panel(tab)
        with ui.tab_panel("Ensemble"):
            EnsemblePanel(tab)
    return Side(
        tabs.set_value,
        map_panel.start,
        map_panel.stop,
        compare_panel.pin,
        compare_panel.clear,
        check,
        explain,
    )
