"""Sliders and number fields for the inputs."""

import math
from collections.abc import Callable

from nicegui import ui

from helimag.scenario import Scenario
from helimag.studio.knobs import CHOICES, GROUPS, KNOBS, Choice, Knob, unit_text
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
    slow = _Echo()
    name = knob.path.replace(".", "-")
    with ui.element("div").classes("hs-knob") as row:
        ui.label(knob.label).classes("hs-knob-label")
        number = ui.number(suffix=unit_text(knob.unit)).props(
            f'dense borderless input-class="hs-number" data-testid="number-{name}" aria-label="{knob.label}"'
        )
        slider = ui.slider(min=knob.low, max=knob.high, step=knob.step).props(
            f'dense data-testid="slider-{name}" aria-label="{knob.label}"'
        )

    def moved(value: float | None) -> None:
        if value is not None and not slow.is_echo(value):
            tab.turn(lambda scenario: knob.changed(scenario, round(value, 9)))

    def typed() -> None:
        value = number.value
        here = knob.value(tab.scenario)
        same = value is None or (here is not None and math.isclose(value, here, rel_tol=1e-9))
        if same or not tab.change(lambda scenario: knob.changed(scenario, value)):
            show(tab.scenario)

    def show(scenario: Scenario) -> None:
        value = knob.value(scenario)
        row.set_visibility(value is not None)
        if value is not None:
            neat = float(f"{value:.10g}")
            number.set_value(neat)
            slow.shown = knob.within(neat)
            slider.set_value(slow.shown)

    slider.on_value_change(lambda event: moved(event.value))
    number.on("blur", typed).on("keydown.enter", typed)
    tab.scenario_listeners.append(show)
    show(tab.scenario)


class _Echo:
    """Tells a slider's move by hand from the one that follows when the page sets it."""

    shown: float | None = None

    def is_echo(self, value: float) -> bool:
        """Whether the slider says what it was told."""
        return self.shown is not None and math.isclose(value, self.shown, rel_tol=1e-9, abs_tol=1e-12)


def _choice(tab: Tab, choice: Choice) -> None:
    chosen = ui.select(choice.words, label=choice.label).props(
        f'dense options-dense data-testid="choice-{choice.path.replace(".", "-")}"'
    )
    chosen.classes("hs-choice")

    def picked(word: str | None) -> None:
        if word is not None and word != choice.value(tab.scenario) and not tab.change(_to(choice, word)):
            show(tab.scenario)

    def show(scenario: Scenario) -> None:
        word = choice.value(scenario)
        chosen.set_visibility(word is not None)
        if word is not None:
            chosen.set_value(word)

    chosen.on_value_change(lambda event: picked(event.value))
    tab.scenario_listeners.append(show)
    show(tab.scenario)


def _to(choice: Choice, word: str) -> Callable[[Scenario], Scenario]:
    return lambda scenario: choice.changed(scenario, word)
