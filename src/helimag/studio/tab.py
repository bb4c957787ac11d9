"""One tab of the studio: its state, its live run, and who is told of changes."""

import asyncio
from collections.abc import Callable, MutableMapping
from dataclasses import dataclass, field
from typing import Any

from nicegui import ui

from helimag.errors import HelimagError
from helimag.scenario import Scenario
from helimag.studio.answer import Stage
from helimag.studio.intake import bounded, link_of, scenario_from_link
from helimag.studio.live import Live, News
from helimag.studio.state import TabState

KEPT = "helimag-studio"  # name in the browser's store of a tab
PATIENCE = 10.0  # s in which a page must say what it kept
SETTLE = 0.6  # s without another turn after which a change is one that can be undone


@dataclass
class Tab:
    """A tab.

    Attributes
    ----------
    store
        Where the state is kept for this browser tab, over reloads.
    state
        Scenario and history.
    latest
        Last news of the newest question that came with a run.
    """

    store: MutableMapping[str, Any]
    state: TabState
    latest: News | None = None
    scenario_listeners: list[Callable[[Scenario], None]] = field(default_factory=list)
    news_listeners: list[Callable[[News], None]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._client = ui.context.client
        self._before = self.state.toml
        self._settling: asyncio.TimerHandle | None = None
        self._number = 0
        self.scenario = self.state.scenario
        self.live = Live(self.in_page(self._hear))
        self._client.on_delete(self.live.close)

    def begin(self) -> None:
        """Tell everyone of the state as it is, and run it."""
        self._spread()

    def in_page(self, function: Callable[..., object]) -> Callable[..., None]:
        """A function for other threads to call: it is run by the page's loop, if the page is still there."""

        def called(*given: Any) -> None:
            self._loop.call_soon_threadsafe(inside, given)

        def inside(given: tuple[Any, ...]) -> None:
            if not self._client.is_deleted:
                with self._client.layout:
                    function(*given)

        return called

    def turn(self, change: Callable[[Scenario], Scenario]) -> bool:
        """Change the scenario on the way to somewhere; tells whether it could be changed."""
        try:
            scenario = bounded(change(self.scenario))
        except HelimagError as error:
            self.complain(str(error))
            return False
        if scenario.hash != self.scenario.hash or scenario.name != self.scenario.name:
            self._keep(self.state.shown(scenario), scenario)
            if self._settling is not None:
                self._settling.cancel()
            self._settling = self._loop.call_later(SETTLE, self._settle)
        return True

    def change(self, change: Callable[[Scenario], Scenario]) -> bool:
        """Change the scenario in one step that can be undone."""
        self._settle()
        done = self.turn(change)
        self._settle()
        return done

    def undo(self) -> None:
        """One step back."""
        self._settle()
        self._to(self.state.undone())

    def redo(self) -> None:
        """One step on."""
        self._settle()
        self._to(self.state.redone())

    def complain(self, problem: str) -> None:
        """Say what is wrong, where everyone sees it."""
        ui.notify(problem[:400], type="warning", position="top", multi_line=True, close_button="Close", timeout=8000)

    def _settle(self) -> None:
        if self._settling is not None:
            self._settling.cancel()
            self._settling = None
        self.state = self.state.committed(self._before)
        self._before = self.state.toml
        self._store()
        if not self._client.is_deleted:
            with self._client.layout:
                keep_in_browser(self.scenario)
                for listener in self.scenario_listeners:
                    listener(self.scenario)

    def _to(self, state: TabState) -> None:
        self._before = state.toml
        self._keep(state, state.scenario)

    def _keep(self, state: TabState, scenario: Scenario) -> None:
        self.state, self.scenario = state, scenario
        self._store()
        self._spread()

    def _store(self) -> None:
        self.store["state"] = self.state.data

    def _spread(self) -> None:
        for listener in self.scenario_listeners:
            listener(self.scenario)
        self._number = self.live.ask(self.scenario)

    def _hear(self, news: News) -> None:
        if news.number != self._number:
            return
        if news.run is not None and news.stage is not Stage.FIRST:
            self.latest = news
        for listener in self.news_listeners:
            listener(news)


def keep_in_browser(scenario: Scenario) -> None:
    """Let the browser's tab keep a scenario, for when this server has ended and another answers."""
    ui.run_javascript(f"sessionStorage.setItem('{KEPT}', '{link_of(scenario)}')")


async def kept_in_browser() -> Scenario | None:
    """What the browser's tab kept, if anything; read as strictly as a link.

    Raises
    ------
    InputError
        Where it is no scenario that a page may ask for.
    """
    try:
        kept = await ui.run_javascript(f"sessionStorage.getItem('{KEPT}')", timeout=PATIENCE)
    except TimeoutError:
        return None
    return scenario_from_link(kept) if isinstance(kept, str) else None
