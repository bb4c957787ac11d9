"""Outcome probabilities, where a calibration says how well the inputs are known."""

from nicegui import ui

from helimag.ensembles import Ensemble, Perturbation, ensemble
from helimag.errors import HelimagError
from helimag.scenario import Scenario
from helimag.studio.jobs import Job
from helimag.studio.mapping import THREADS
from helimag.studio.panels.controls import button, chooser
from helimag.studio.panels.verdict import SIGNS
from helimag.studio.spreads import MOST_BYTES, spread_from_bytes
from helimag.studio.tab import Tab

RUNS = 64
SHAPE = """[inputs]
"fluid.viscosity" = { mean = "1 Pa s", sd = "0.03 Pa s" }
"device.weight.net_weight" = { low = "27.5 uN", high = "29 uN" }

[start]
displacement = "1 mm"
"""


class EnsemblePanel:
    """Load what is known, run copies, show shares of verdicts."""

    def __init__(self, tab: Tab) -> None:
        self.tab, self.job = tab, Job(tab.live)
        self.known: Perturbation | None = None
        self.run_of = ""
        opened = chooser(".toml", MOST_BYTES, "upload-calibration", self.given, tab.complain)
        words = "How sure is the outcome? Copies of the run, with inputs drawn from what is known of them."
        ui.label(words).classes("hs-small")
        with ui.element("div").classes("hs-row"):
            button("Load a calibration", "upload_file", opened, "ensemble-load")
            button("Example", None, self.example, "ensemble-example", "flat")
            self.start_button = button(f"Run {RUNS} copies", "casino", self.start, "ensemble-start", "solid")
        self.start_button.set_enabled(False)
        self.inputs = ui.label("no calibration is loaded").props('data-testid="ensemble-inputs"')
        self.status = ui.label("").classes("hs-small").props('data-testid="ensemble-status"')
        self.table = ui.element("div").classes("hs-cards")
        tab.scenario_listeners.append(self.outdated)

    def given(self, _: str, content: bytes) -> None:
        """A file that someone chose."""
        self.take(content)

    def example(self) -> None:
        """One to begin with, to be saved and changed."""
        ui.download.content(SHAPE.encode(), "calibration.toml", "application/toml")
        self.take(SHAPE.encode())

    def take(self, content: bytes) -> None:
        """Read a calibration."""
        try:
            self.known = spread_from_bytes(content, self.tab.scenario)
        except HelimagError as error:
            self.tab.complain(str(error))
            return
        named = [*self.known.priors, *(["where it is let go"] if self.known.displacement else [])]
        self.inputs.set_text(f"not exactly known: {', '.join(named)}")
        self.start_button.set_enabled(True)

    def start(self) -> None:
        """Run the copies."""
        known, scenario = self.known, self.tab.scenario
        if known is None:
            return
        self.run_of = scenario.hash
        self.status.set_text("running copies ...")
        self.job.start(
            lambda progress: ensemble(scenario, known, runs=RUNS, threads=THREADS, progress=progress),
            self.tab.in_page(self.done),
            self.tab.in_page(self.status.set_text),
        )

    def done(self, found: Ensemble) -> None:
        """Show the shares, with their 95 % intervals."""
        self.status.set_text(found.text)
        self.table.clear()
        with self.table:
            for verdict, (share, low, high) in found.shares.items():
                icon, kind = SIGNS[verdict]
                with ui.element("div").classes("hs-share"):
                    ui.icon(icon).classes(f"hs-{kind}")
                    ui.label(str(verdict))
                    with ui.element("div").classes("hs-bar-track"):
                        ui.element("div").classes("hs-bar-fill").style(f"width: {100.0 * share:.1f}%")
                        ui.element("div").classes("hs-bar-range").style(
                            f"left: {100.0 * low:.1f}%; width: {100.0 * (high - low):.1f}%"
                        )
                    ui.label(f"{100.0 * share:.0f} %")

    def outdated(self, scenario: Scenario) -> None:
        """Say where the shares are of other inputs."""
        if self.run_of and scenario.hash != self.run_of:
            self.status.set_text("the inputs have changed since; run the copies again")
