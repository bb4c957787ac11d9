"""The live run of a tab: workers that always compute what was asked last, and never block the page.

Asking is instant. Whatever was on its way for an older question is given up, and nothing is replayed; the last question
is always answered. Two threads answer it, side by side: one at once, with the run where leaps over turns of the magnet
make it short and with the run's beginning where they do not; the other with the run where that is still to be made,
however long it takes, once the hand is slow enough, and then, when it rests, with the outlook. The kernels run outside
of Python's lock, so threads are enough.

While the hand moves, all runs have steps of the default tolerance. When it rests, those that multiply errors are made
again with finer steps, as ``simulate`` does it by itself: from then on the numbers are those of the command.
"""

import logging
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from helimag.engine import SURE, frame_moves, simulate, system_of
from helimag.errors import HelimagError
from helimag.orbits import explain
from helimag.runs import Trajectory
from helimag.scenario import Scenario
from helimag.studio.answer import Answer, Stage, answered
from helimag.studio.picture import Picture, pictured

SHARE = 6.0  # without leaps, the first answer is of a run this much shorter
QUICK = 600.0  # s; a run this short is shown as a whole at once
TEDIOUS = 0.15  # s in which leaps must come half way to be a first answer
STILL = 0.06  # s without another question, where answers are behind the hand, before a whole run is begun
REST = 0.3  # s without another question before its outlook is asked for


def unforeseen(error: Exception) -> str:
    """What the page says of an error that is none of ours; the terminal gets all of it."""
    logging.getLogger(__name__).error("an error that was not foreseen", exc_info=error)
    return f"an error that was not foreseen ({type(error).__name__}); the terminal of helimag studio says more"


class Superseded(Exception):
    """Something newer was asked."""


class _Tedious(Exception):
    """Leaps that take too long to be a first answer."""


@dataclass(frozen=True)
class Question:
    """What was asked: a number that rises, and the scenario."""

    number: int
    scenario: Scenario


@dataclass(frozen=True)
class News:
    """The state of a question; ``problem`` says why there is no answer."""

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
        Called in the workers' threads with each piece of news, in one of them at a time.
    """

    def __init__(self, tell: Callable[[News], None]) -> None:
        self._tell = tell
        self._telling = threading.Lock()
        self._changed = threading.Condition()
        self._asked: Question | None = None
        self._number = 0  # of the newest question
        self._settled = 0  # of the newest that has had more than a first answer
        self._looked_at = 0  # of the newest of which it is known whether leaps give all of it at once
        self._leapt: Trajectory | None = None  # that run, where they do
        self._closed = False
        self.idle = threading.Event()  # others may use the cores
        self.idle.set()
        for work in (self._answer_first, self._answer_whole):
            threading.Thread(target=work, name="helimag-live", daemon=True).start()

    def ask(self, scenario: Scenario) -> int:
        """Ask for a scenario's run, in place of whatever was asked before; returns the question's number."""
        with self._changed:
            self._number += 1
            self._asked = Question(self._number, scenario)
            self.idle.clear()
            self._changed.notify_all()
            return self._number

    def close(self) -> None:
        """Let the workers end."""
        with self._changed:
            self._closed = True
            self._number += 1
            self._changed.notify_all()

    def _questions(self) -> Iterator[Question]:
        """What a worker is to answer: the newest question, whenever there is one that it has not had."""
        had = 0
        while True:
            with self._changed:
                while self._number == had and not self._closed:
                    self._changed.wait()
                if self._closed or self._asked is None:
                    return
                question = self._asked
            had = question.number
            yield question

    def _answer_first(self) -> None:
        for question in self._questions():
            try:
                self._first(question)
            except (Superseded, HelimagError):
                continue  # a newer question is waiting, or the other worker will say what is wrong
            except Exception as error:  # noqa: BLE001  the next question is to be answered all the same
                unforeseen(error)
            finally:
                self._hand_over(question, None)  # so that nobody waits where it failed

    def _first(self, question: Question) -> None:
        """Say all of a run, where leaps give it at once, and its beginning otherwise; nothing of one that is short."""
        scenario, go_on = question.scenario, self._go_on(question)
        if scenario.run.duration <= QUICK:
            return
        run = leapt(scenario, go_on)
        if run is not None:
            self._say(News(question.number, Stage.WHOLE, answered(run), run, pictured(run)))
        self._hand_over(question, run)
        if run is None:
            run = beginning(scenario, go_on)
            self._say(News(question.number, Stage.FIRST, answered(run), run, pictured(run)))

    def _hand_over(self, question: Question, run: Trajectory | None) -> None:
        """Let the other worker know of a run that was told as a whole, or that it is to make it."""
        with self._changed:
            if self._looked_at < question.number:
                self._looked_at, self._leapt = question.number, run
                self._changed.notify_all()

    def _handed_over(self, question: Question) -> Trajectory | None:
        """The run, where the other worker has told all of it."""
        with self._changed:
            self._changed.wait_for(lambda: max(self._looked_at, self._number - 1) >= question.number)
            if question.number != self._number:
                raise Superseded
            return self._leapt

    def _answer_whole(self) -> None:
        for question in self._questions():
            stage = Stage.WHOLE
            try:
                for news in self._news(question):
                    self._say(news)
                    stage = Stage.AFTERWARDS
            except Superseded:
                continue
            except HelimagError as error:
                self._say(News(question.number, stage, problem=str(error)))
            except Exception as error:  # noqa: BLE001  the page says so, and the next question is answered
                self._say(News(question.number, stage, problem=unforeseen(error)))
            with self._changed:
                if question.number == self._number:
                    self.idle.set()

    def _news(self, question: Question) -> Iterator[News]:
        go_on, behind = self._go_on(question), question.number != self._settled + 1
        run = self._handed_over(question)
        if run is None:
            if behind:
                self._wait(question, STILL)
            run = simulate(question.scenario, refine=False, progress=go_on)
            go_on(0.0)
            yield News(question.number, Stage.WHOLE, answered(run), run, pictured(run))
        self._wait(question, REST)
        if run.heights.multiply_errors:
            run = simulate(question.scenario, tolerance=SURE, refine=False, progress=go_on)  # not the rough one again
            go_on(0.0)
            yield News(question.number, Stage.WHOLE, answered(run), run, pictured(run))
        outlook = explain(run, progress=go_on)
        go_on(0.0)
        yield News(question.number, Stage.AFTERWARDS, answered(run, outlook.text), run)

    def _say(self, news: News) -> None:
        """Tell news; but not of an older question than was settled, nor a first answer after the whole one."""
        with self._telling:
            if self._settled > news.number or (news.stage is Stage.FIRST and self._settled == news.number):
                return
            if news.stage is not Stage.FIRST:
                self._settled = news.number
            self._tell(news)

    def _go_on(self, question: Question) -> Callable[[float], None]:
        """What runs call on their way: raises Superseded where nobody waits for them any more."""

        def go_on(_: float) -> None:
            if question.number != self._number:
                raise Superseded

        return go_on

    def _wait(self, question: Question, seconds: float) -> None:
        """Wait for a hand that moves on; raise Superseded where it does."""
        with self._changed:
            if self._changed.wait_for(lambda: question.number != self._number, seconds):
                raise Superseded


def beginning(scenario: Scenario, go_on: Callable[[float], None]) -> Trajectory:
    """The first part of a run."""
    return simulate(scenario, duration=scenario.run.duration / SHARE, refine=False, progress=go_on)


def leapt(scenario: Scenario, go_on: Callable[[float], None]) -> Trajectory | None:
    """The run by leaps; None where there are none, or they take long: where the device slips, say, they are steps."""
    if not frame_moves(system_of(scenario), scenario.drive):
        return None
    begun = time.monotonic()

    def soon(done: float) -> None:
        go_on(done)
        if done < 0.5 and time.monotonic() - begun > TEDIOUS:
            raise _Tedious

    try:
        return simulate(scenario, refine=False, progress=soon)
    except _Tedious:
        return None


def warmed(scenario: Scenario, patience: float = 300.0) -> None:
    """Run a scenario as a page will, so that all that is loaded or compiled for it is there; nobody is told of it."""
    live = Live(lambda _: None)
    live.ask(scenario)
    live.idle.wait(patience)
    live.close()
