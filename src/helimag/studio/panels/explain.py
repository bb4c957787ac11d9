"""Each input's effect, with the paper's equation and today's numbers."""

from collections.abc import Callable

from nicegui import ui

from helimag.scenario import Scenario
from helimag.studio.explaining import Effect, effects
from helimag.studio.jobs import Job
from helimag.studio.panels.controls import button
from helimag.studio.tab import Tab


def explain_panel(tab: Tab) -> Callable[[], None]:
    """Build the panel; gives what starts the explanation."""
    job = Job(tab.live)
    explained = [""]

    def start() -> None:
        scenario = tab.scenario
        explained[0] = scenario.hash
        status.set_text("running each input a little off ...")
        job.start(
            lambda progress: effects(scenario, progress),
            tab.in_page(done),
            tab.in_page(status.set_text),
            tab.in_page(lambda share: status.set_text(f"running each input a little off ... {share:.0%}")),
        )

    def done(found: list[Effect]) -> None:
        status.set_text("each input 5 % less and 5 % more, all else as it is")
        table.clear()
        with table:
            for effect in found:
                _card(effect)

    def outdated(scenario: Scenario) -> None:
        if explained[0] and scenario.hash != explained[0]:
            status.set_text("the inputs have changed since; explain again")

    with ui.element("div").classes("hs-row"):
        button("Explain the present point", "lightbulb", start, "explain-start", "solid")
        status = ui.label("").classes("hs-small").props('data-testid="explain-status"')
    table = ui.element("div").classes("hs-cards").props('data-testid="effects"')
    tab.scenario_listeners.append(outdated)
    return start


def _card(effect: Effect) -> None:
    with ui.element("div").classes("hs-card"):
        ui.label(effect.label).classes("hs-title")
        ui.label(effect.equation).classes("hs-equation")
        ui.label(effect.today)
        with ui.element("div").classes("hs-pair hs-small"):
            ui.label(f"\u2193 {effect.less}")
            ui.label(f"\u2191 {effect.more}")
