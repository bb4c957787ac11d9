"""Sliders and number fields for the inputs."""

from collections.abc import Callable

from nicegui import ui
from nicegui.events import GenericEventArguments

from helimag.scenario import Scenario
from helimag.studio.elements import KnobRow
from helimag.studio.knobs import CHOICES, GROUPS, KNOBS, Knob, WordChoice, unit_text
from helimag.studio.panels.controls import number
from helimag.studio.tab import Tab

OPEN = ("Drive", "Device")  # groups that are open at first


def inputs(tab: Tab) -> None:
    """Build the column of inputs."""
    with ui.element("section").classes("hs-inputs hs-panel").props('aria-label="Inputs"'):
        for group in GROUPS:
            with ui.expansion(group, value=group in OPEN).classes("hs-group").props("dense dense-toggle"):
                for choice in CHOICES:
                    if choice.group == group:
                        _choice(tab, choice)
                for knob in KNOBS:
                    if knob.group == group:
                        _knob(tab, knob)


def _knob(tab: Tab, knob: Knob) -> None:
    """One input: its name and value above, its slider below."""
    row = KnobRow()
    row.props["name"] = knob.path.replace(".", "-")
    row.props["label"], row.props["unit"] = knob.label, unit_text(knob.unit)
    row.props["low"], row.props["high"], row.props["step"] = knob.low, knob.high, knob.step

    def turned(event: GenericEventArguments) -> None:
        value = number(event.args)
        if value is not None and value != knob.value(tab.scenario):
            tab.turn(lambda scenario: knob.changed(scenario, round(value, 9)))

    def typed(event: GenericEventArguments) -> None:
        value = number(event.args)
        if value is None or not tab.change(lambda scenario: knob.changed(scenario, value)):
            row.run_method("reset")

    def show(scenario: Scenario) -> None:
        value = knob.value(scenario)
        row.set_visibility(value is not None)
        if value is not None:
            row.show(float(f"{value:.10g}"))

    row.on("turn", turned)
    row.on("typed", typed)
    tab.scenario_listeners.append(show)
    show(tab.scenario)


def _choice(tab: Tab, choice: WordChoice) -> None:
    chosen = ui.select(choice.words, label=choice.label).props(
        f'dense options-dense data-testid="choice-{choice.path.replace(".", "-")}"'
    )
    chosen.classes("hs-choice")

    def picked(word: str | None) -> None:
        if word is not None and word != choice.value(tab.scenario) and not tab.change(_to(choice, word)):
            show(tab.scenario)

    def show(scenario: Scenario) -> None:
        word = choice.value(scenario)
        chosen.set_visibility(word is not None or choice.optional)
        chosen.set_value(word)

    chosen.on_value_change(lambda event: picked(event.value))
    tab.scenario_listeners.append(show)
    show(tab.scenario)


def _to(choice: WordChoice, word: str) -> Callable[[Scenario], Scenario]:
    return lambda scenario: choice.changed(scenario, word)
