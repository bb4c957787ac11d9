"""Runs laid over the live one: pinned, stored or measured."""

from dataclasses import dataclass

from nicegui import ui

from helimag.engine import initial_gap
from helimag.errors import HelimagError
from helimag.runs import Trajectory, interval_text
from helimag.runs import compare as beside
from helimag.studio.intake import MOST_RUN, run_from_bytes
from helimag.studio.live import News
from helimag.studio.panels.controls import button, chooser
from helimag.studio.picture import overlaid
from helimag.studio.pictures import Shelf
from helimag.studio.tab import Tab

MOST = 3  # runs at once: as many as colours that can be told apart


@dataclass(frozen=True)
class Laid:
    """A run laid over the live one, and what it is called."""

    name: str
    run: Trajectory


class ComparePanel:
    """A list of runs, and how each differs from the live one."""

    def __init__(self, tab: Tab, shelf: Shelf) -> None:
        self.tab, self.shelf = tab, shelf
        self.laid: list[Laid] = []
        opened = chooser(".nc,.csv", MOST_RUN, "upload-run", self.given, tab.complain)
        with ui.element("div").classes("hs-row"):
            button("Pin this run", "push_pin", self.pin, "pin", "solid")
            button("Add a run", "upload_file", opened, "add-run")
            button("Remove all", None, self.clear, "remove-runs", "flat")
        ui.label(
            "Stored runs (.nc, from helimag simulate -o or vision track) or measured tracks (.csv: time [s], x [mm], "
            "y [mm], z [mm]). They are drawn dashed in charts and scene."
        ).classes("hs-small")
        self.table = ui.element("div").classes("hs-cards").props('data-testid="compared"')
        tab.news_listeners.append(self.heard)

    def pin(self) -> None:
        """Keep the live run as it is now."""
        latest = self.tab.latest
        if latest is not None and latest.run is not None:
            self.add(Laid(str(latest.run.dataset.attrs["name"]), latest.run))

    def given(self, name: str, content: bytes) -> None:
        """A file that someone chose."""
        suffix = ".nc" if name.lower().endswith(".nc") else ".csv" if name.lower().endswith(".csv") else ""
        try:
            run = run_from_bytes(content, suffix, initial_gap(self.tab.scenario))
            overlaid(run)
        except HelimagError as error:
            self.tab.complain(str(error))
            return
        self.add(Laid(name[:80], run))

    def add(self, laid: Laid) -> None:
        """One more; the oldest goes where there are too many."""
        self.laid = [*self.laid, laid][-MOST:]
        self.changed()

    def clear(self) -> None:
        """None."""
        self.laid = []
        self.changed()

    def changed(self) -> None:
        """Send the pictures, and compare."""
        self.shelf.others = [overlaid(each.run).packet for each in self.laid]
        urls = [self.shelf.address(str(i)) for i in range(len(self.laid))]
        ui.run_javascript(f"import('helimag-studio').then(m => m.runs.lay_over({urls!r}))")
        self.compare()

    def heard(self, news: News) -> None:
        """The live run is another one."""
        if self.laid and news.run is not None and news is self.tab.latest:
            self.compare()

    def compare(self) -> None:
        """One card a run."""
        latest = self.tab.latest
        self.table.clear()
        if latest is None or latest.run is None:
            return
        with self.table:
            for number, each in enumerate(self.laid):
                _card(number, each, latest.run)


def _card(number: int, laid: Laid, live: Trajectory) -> None:
    gains = ("gain", f"{laid.run.gain:.4f}", f"{live.gain:.4f}")
    verdicts = ("verdict", str(laid.run.verdict), str(live.verdict))
    with ui.element("div").classes("hs-card"):
        with ui.element("div").classes("hs-headline"):
            ui.element("span").classes(f"hs-swatch hs-swatch{number}")
            ui.label(laid.name).classes("hs-title")
        with ui.element("div").classes("hs-grid3"):
            for text in ("", "this run", "live run", *gains, *verdicts):
                ui.label(text)
        ui.label(_difference(laid.run, live)).classes("hs-small")


def _difference(run: Trajectory, live: Trajectory) -> str:
    """How far apart they are."""
    simulated = run.dataset.attrs.get("source") == "simulated"
    try:
        numbers = beside(run, live, align="none" if simulated else "fit").numbers
    except HelimagError as error:
        return str(error)
    doubts = "".join(f"; {doubt}" for doubt in numbers["doubts"])
    if simulated:
        return (
            f"apart {1e3 * numbers['difference_rms_m']:.2f} mm rms, {1e3 * numbers['difference_worst_m']:.2f} mm at "
            f"most, from {numbers['from_s']:.0f} s to {numbers['until_s']:.0f} s{doubts}"
        )
    within = interval_text(numbers["measured"]["gain_95"], 3)
    return (
        f"apart {1e3 * numbers['difference_rms_m']:.2f} mm rms after the best fit, "
        f"{1e3 * numbers['difference_worst_m']:.2f} mm at most; measured gain {within}{doubts}"
    )
