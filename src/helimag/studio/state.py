"""What a tab of the studio holds: a scenario as text, and what it was before and after. A change makes a new one."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from helimag.scenario import Scenario, load, parse

DEPTH = 200  # changes that can be undone


@dataclass(frozen=True)
class TabState:
    """A tab's scenario and its history, all as TOML text, so that it can be stored as it is.

    Attributes
    ----------
    toml
        The scenario now.
    past, future
        What undo and redo lead to, the nearest last.
    """

    toml: str
    past: tuple[str, ...] = ()
    future: tuple[str, ...] = ()

    @classmethod
    def of(cls, scenario: Scenario) -> "TabState":
        """A beginning."""
        return cls(scenario.to_toml())

    @classmethod
    def stored(cls, data: Mapping[str, Any]) -> "TabState":
        """What :attr:`data` gave."""
        return cls(str(data["toml"]), tuple(data["past"]), tuple(data["future"]))

    @property
    def data(self) -> dict[str, Any]:
        """As plain data."""
        return {"toml": self.toml, "past": list(self.past), "future": list(self.future)}

    @property
    def scenario(self) -> Scenario:
        """The scenario now."""
        return parse(self.toml)

    def shown(self, scenario: Scenario) -> "TabState":
        """On the way: another scenario, nothing to undo yet."""
        return replace(self, toml=scenario.to_toml())

    def committed(self, before: str) -> "TabState":
        """The way is at its end: undo leads to ``before``."""
        if before == self.toml:
            return self
        return TabState(self.toml, (*self.past, before)[-DEPTH:], ())

    def undone(self) -> "TabState":
        """One step back; itself where there is none."""
        if not self.past:
            return self
        return TabState(self.past[-1], self.past[:-1], (*self.future, self.toml))

    def redone(self) -> "TabState":
        """One step on; itself where there is none."""
        if not self.future:
            return self
        return TabState(self.future[-1], (*self.past, self.toml), self.future[:-1])


def beginning(name: str) -> TabState:
    """The state that a new tab begins with: a preset's or a file's."""
    return TabState.of(load(name))
