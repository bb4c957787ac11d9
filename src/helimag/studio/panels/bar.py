"""The bar: presets, files, links, undo and redo, export, dark or light."""

from collections.abc import Callable
from functools import cache

from nicegui import ui

from helimag.errors import HelimagError
from helimag.runs import Trajectory
from helimag.scenario import Scenario, load, preset_names
from helimag.studio.downloads import FORMATS, file_name, written
from helimag.studio.intake import MOST_TEXT, link_of, scenario_from_bytes
from helimag.studio.jobs import Job
from helimag.studio.panels.controls import button, chooser
from helimag.studio.tab import Tab

THEMES = {"auto": None, "light": False, "dark": True}


def bar(tab: Tab) -> None:
    """Build the bar."""
    with ui.element("header").classes("hs-bar"):
        with ui.element("div").classes("hs-brand"):
            ui.html("<b>helimag</b> studio", sanitize=False)  # our own words
        _presets(tab)
        _icon("undo", "Undo (Ctrl+Z)", tab.undo, "undo")
        _icon("redo", "Redo (Ctrl+Y)", tab.redo, "redo")
        _open(tab)
        _button("Save", "save_alt", "Save this scenario as a TOML file", lambda: _save(tab), "save")
        _button("Share", "link", "Copy a link to this scenario", lambda: _share(tab), "share")
        _export(tab)
        ui.element("div").classes("hs-space")
        ui.label("").classes("hs-small").props('id="hs-connection" role="status"')
        _theme(tab)
    ui.keyboard(on_key=lambda event: _key(tab, event), ignore=["input", "select", "textarea"], repeating=False)


def _icon(icon: str, words: str, action: Callable[[], object], name: str) -> None:
    with ui.button(icon=icon, on_click=action).props(f'flat round dense aria-label="{words}" data-testid="{name}"'):
        ui.tooltip(words)


def _button(label: str, icon: str, words: str, action: Callable[[], object], name: str) -> None:
    with button(label, icon, action, name, "flat"):
        ui.tooltip(words)


def _presets(tab: Tab) -> None:
    names = preset_names()
    chosen = ui.select(names, label="Preset", with_input=False).classes("hs-preset")
    chosen.props('dense options-dense data-testid="preset"')
    shown = [""]

    def pick(name: str | None) -> None:
        if name in names and name != shown[0]:
            shown[0] = name
            tab.change(lambda _: load(name))

    def show(scenario: Scenario) -> None:
        name = scenario.name if scenario.name in names else None
        changed = name is not None and _hash_of(name) != scenario.hash
        shown[0] = "" if name is None or changed else name
        chosen.set_value(shown[0] or None)
        label = f"{name}, changed" if changed else "Preset"
        if chosen.props.get("label") != label:
            chosen.props(f'label="{label}"')

    chosen.on_value_change(lambda event: pick(event.value))
    tab.scenario_listeners.append(show)


@cache
def _hash_of(preset: str) -> str:
    return load(preset).hash


def _open(tab: Tab) -> None:
    def given(_: str, content: bytes) -> None:
        try:
            scenario = scenario_from_bytes(content)
        except HelimagError as error:
            tab.complain(str(error))
            return
        tab.change(lambda _: scenario)

    opened = chooser(".toml", MOST_TEXT, "upload-scenario", given, tab.complain)
    _button("Open", "folder_open", "Open a scenario (TOML)", opened, "open")


def _save(tab: Tab) -> None:
    ui.download.content(tab.scenario.to_toml().encode(), f"{file_name(tab.scenario.title)}.toml", "application/toml")


def _share(tab: Tab) -> None:
    link = link_of(tab.scenario)
    ui.run_javascript(
        f"const link = location.origin + location.pathname + '?s={link}';"
        "document.body.dataset.link = link;"
        "navigator.clipboard && navigator.clipboard.writeText(link).catch(() => prompt('Link', link));"
    )
    ui.notify("Link copied", type="positive", position="top", timeout=2000)


def _export(tab: Tab) -> None:
    job = Job(tab.live)
    failed = tab.in_page(tab.complain)

    def start(kind: str) -> None:
        run = tab.latest.run if tab.latest is not None else None
        if run is None:
            tab.complain("there is no run to export yet")
            return
        ui.notify("Preparing the file", position="top", timeout=1500)
        hand_over = tab.in_page(lambda made: give(run, kind, made))
        job.start(lambda progress: written(run, kind, progress), hand_over, failed)

    def give(run: Trajectory, kind: str, made: bytes) -> None:
        ui.download.content(made, f"{file_name(str(run.dataset.attrs['name']))}.{kind}")

    with button("Export", "download", lambda: None, "export", "flat"), ui.menu().props("auto-close"):
        for kind, label in FORMATS.items():
            ui.menu_item(label, lambda kind=kind: start(kind)).props(f'data-testid="export-{kind}"')


def _theme(tab: Tab) -> None:
    dark = ui.dark_mode(THEMES.get(str(tab.store.get("theme", "auto"))))

    def turn() -> None:
        names = list(THEMES)
        here = str(tab.store.get("theme", "auto"))
        name = names[(names.index(here) + 1) % len(names)] if here in names else "auto"
        tab.store["theme"] = name
        dark.set_value(THEMES[name])
        button.props(f'icon="{ICONS[name]}" aria-label="Colours: {name}"')
        words.set_text(f"Colours: {name}")

    name = str(tab.store.get("theme", "auto"))
    with ui.button(on_click=turn).props('flat round dense data-testid="theme"') as button:
        words = ui.tooltip(f"Colours: {name}")
    button.props(f'icon="{ICONS.get(name, "contrast")}" aria-label="Colours: {name}"')


ICONS = {"auto": "contrast", "light": "light_mode", "dark": "dark_mode"}


def _key(tab: Tab, event: object) -> None:
    """Ctrl+Z and Ctrl+Y; the keys of time are the page's own (``static/clock.js``)."""
    action = getattr(event, "action", None)
    key = getattr(event, "key", None)
    modifiers = getattr(event, "modifiers", None)
    if action is None or not action.keydown or modifiers is None or not (modifiers.ctrl or modifiers.meta):
        return
    if str(key).lower() == "z":
        (tab.redo if modifiers.shift else tab.undo)()
    elif str(key).lower() == "y":
        tab.redo()
