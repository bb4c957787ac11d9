"""The tour: the page shows itself in two minutes, and stops when someone takes over."""

import asyncio
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from nicegui import background_tasks, ui

from helimag.studio.knobs import BY_PATH, Knob
from helimag.studio.panels.controls import button
from helimag.studio.tab import Tab

BEAT = 0.12  # s between moves of a slider


@dataclass(frozen=True)
class Side:
    """What the tour does at the side of the page."""

    show: Callable[[str], object]
    start_map: Callable[[], None]
    stop_map: Callable[[], None]
    pin: Callable[[], None]
    clear: Callable[[], None]
    check_robot: Callable[[], None]
    explain: Callable[[], None]


@dataclass(frozen=True)
class Stop:
    """A stop of the tour.

    Attributes
    ----------
    words
        That stand there meanwhile.
    seconds
        That it takes.
    begin
        Done first.
    knob
        Path of an input that then moves.
    to
        Where it moves to, in its shown unit.
    """

    words: str
    seconds: float
    begin: Callable[[], object] | None = None
    knob: str = ""
    to: float = 0.0


def stops(side: Side) -> list[Stop]:
    """What is shown, in order."""
    play = "import('helimag-studio').then(m => {{ m.clock.seek(0); m.clock.speed = 120; m.clock.playing = {} }})"
    return [
        Stop(
            "Half an hour of a helical device under a rotating magnet, computed in a moment.",
            9.0,
            lambda: _run(play.format("true")),
        ),
        Stop(
            "Turn a knob, and run, verdict and picture follow: the pitch of the rotation axis.",
            11.0,
            None,
            "drive.pitch",
            18.0,
        ),
        Stop(
            "With another pitch the outcome is another. And back.",
            9.0,
            None,
            "drive.pitch",
            12.7,
        ),
        Stop(
            "The charts share the scene's time: drag in them to scrub.",
            7.0,
            lambda: _run(play.format("false")),
        ),
        Stop(
            "A map of the gain around this point, coarse first, with the exact boundary of stability.",
            24.0,
            lambda: _both(side.show, "Map", side.start_map),
        ),
        Stop(
            "A click on the map takes the sliders there; so does a hand on the sliders.",
            8.0,
            None,
            "drive.frequency",
            2.6,
        ),
        *_later(side),
    ]


def _later(side: Side) -> list[Stop]:
    """Those that look at the other tabs."""
    return [
        Stop(
            "Pin a run, and lay the next one over it.",
            4.0,
            lambda: _both(side.show, "Compare", side.stop_map, side.pin),
        ),
        Stop(
            "Dashed: the pinned run. Whole: the live one.",
            7.0,
            lambda: side.show("Charts"),
            "drive.distance",
            158.0,
        ),
        Stop(
            "Further away, the magnet does not carry it. And back.",
            5.0,
            None,
            "drive.distance",
            150.0,
        ),
        Stop(
            "A programme for the arm, checked, rehearsed, and read back.",
            12.0,
            lambda: _both(side.show, "Robot", side.clear, side.check_robot),
        ),
        Stop(
            "Each input explained: the paper's equation, today's numbers, and what a little more of it does.",
            14.0,
            lambda: _both(side.show, "Explain", side.explain),
        ),
        Stop(
            "Undo goes back, a link shares this point, files open elsewhere. Your turn.",
            6.0,
            lambda: side.show("Charts"),
        ),
    ]


def tour(tab: Tab, side: Side) -> None:
    """Begin the tour."""
    client = ui.context.client

    def ended() -> None:
        task.cancel()
        banner.delete()

    with ui.element("div").classes("hs-tour").props('data-testid="tour"') as banner:
        words = ui.label("").classes("hs-tour-words")
        button("Stop the tour", None, ended, "tour-stop", "flat").props(remove="color")

    async def go() -> None:
        for stop in stops(side):
            if client.is_deleted:
                return
            with client.layout:
                words.set_text(stop.words)
                if stop.begin is not None:
                    stop.begin()
            for value in _way(tab, stop):
                if value is not None and not client.is_deleted:
                    with client.layout:
                        _turn(tab, BY_PATH[stop.knob], value)
                await asyncio.sleep(BEAT)
        if not client.is_deleted:
            with client.layout:
                banner.delete()

    task = background_tasks.create(go(), name="helimag tour")


def _turn(tab: Tab, knob: Knob, value: float) -> None:
    tab.turn(lambda scenario: knob.changed(scenario, value))


def _way(tab: Tab, stop: Stop) -> Iterator[float | None]:
    """One value a beat: where the knob is then, or None where it does not move."""
    beats = round(stop.seconds / BEAT)
    knob = BY_PATH.get(stop.knob)
    begin = None if knob is None else knob.value(tab.scenario)
    moving = beats // 2
    for beat in range(beats):
        if knob is None or begin is None or beat > moving:
            yield None
        else:
            yield round(begin + (stop.to - begin) * beat / moving, 3)


def _run(script: str) -> None:
    ui.run_javascript(script)


def _both(show: Callable[[str], object], name: str, *actions: Callable[[], None]) -> None:
    """Show a panel, and do something there."""
    show(name)
    for action in actions:
        action()
