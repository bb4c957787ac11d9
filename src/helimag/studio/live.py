"""The live run of a tab: a worker that always computes what was asked last, and never blocks the page.

Asking is instant. Whatever was on its way for an older question is given up, and nothing is replayed; the last question
is always answered. A run is first shown for its beginning, then as a whole, then with what becomes of the device after
it. The kernels run outside of Python's lock, so a thread is enough.
"""

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from helimag.engine import simulate
from helimag.errors import HelimagError
from helimag.orbits import explain
from helimag.runs import Trajectory
from helimag.scenario import Scenario
from helimag.studio.answer import Answer, Stage, answered
from helimag.studio.picture import Picture, pictured

SHARE = 6.0  # the first answer is of a run this much shorter
QUICK = 600.0  # s; a run this short is shown as a whole at once


class Superseded(Exception):
    """Something newer was asked."""


@dataclass(frozen=True)
class Question:
    """What was asked: a number that rises, and the scenario."""

    number: int
    scenario: Scenario


@dataclass(frozen=True)
class News:
    """What has become of a question; ``problem`` says why there is no answer."""

    number: int
    stage: Stage
    answer: Answer | None = None
    run: Trajectory | None = None
    picture: Picture | None = None
    problem: str | None = None


class Live:
    """Answers the newest question of a tab.

    Parameters
    ----------
    tell
        Called in the worker's thread with each piece of news.
    """

    def __init__(self, tell: Callable[[News], None]) -> None:
        self._tell = tell
        self._changed = threading.Condition()
        self._asked: Question | None = None
        self._number = 0
        self._closed = False
        self.idle = threading.Event()  # others may use the cores
        self.idle.set()
        threading.Thread(target=self._work, name="helimag-live", daemon=True).start()

    def ask(self, scenario: Scenario) -> int:
        """Ask for a scenario's run, in place of whatever was asked before; returns the question's number."""
        with self._changed:
            self._number += 1
            self._asked = Question(self._number, scenario)
            self.idle.clear()
            self._changed.notify()
            return self._number

    def close(self) -> None:
        """Let the worker end."""
        with self._changed:
            self._closed = True
            self._number += 1
            self._changed.notify()

    def _work(self) -> None:
        while True:
            with self._changed:
                while self._asked is None and not self._closed:
                    self.idle.set()
                    self._changed.wait()
                if self._closed or self._asked is None:
                    self.idle.set()
                    return
                question, self._asked = self._asked, None
            stage = Stage.FIRST
            try:
                for news in self._news(question):
                    stage = news.stage
                    self._tell(news)
            except Superseded:
                continue  # the newer question is waiting
            except HelimagError as error:
                self._tell(News(question.number, stage, problem=str(error)))

    def _news(self, question: Question) -> Iterator[News]:
        scenario, number = question.scenario, question.number

        def go_on(_: float) -> None:
            if number != self._number:
                raise Superseded

        whole = scenario.run.duration
        if whole > QUICK:
            first = simulate(scenario, duration=whole / SHARE, progress=go_on)
            go_on(0.0)
            yield News(number, Stage.FIRST, answered(first), first, pictured(first))
        run = simulate(scenario, progress=go_on)
        go_on(0.0)
        yield News(number, Stage.WHOLE, answered(run), run, pictured(run))
        outlook = explain(run, progress=go_on)
        go_on(0.0)
        yield News(number, Stage.AFTERWARDS, answered(run, outlook.text), run)
