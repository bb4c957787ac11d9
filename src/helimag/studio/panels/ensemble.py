"""Outcome probabilities: from a calibration, from errors of the lab, or both."""

from nicegui import ui

from helimag.calibration import Posterior, check_device
from helimag.ensembles import Ensemble
from helimag.errors import HelimagError, InputError
from helimag.runs.shares import in_percent
from helimag.scenario import Scenario
from helimag.studio.intake import MOST_RUN, fit_from_bytes
from helimag.studio.jobs import Job
from helimag.studio.knobs import DIRECTION, KNOBS, unit_text
from helimag.studio.panels.controls import button, chooser
from helimag.studio.panels.verdict import SIGNS
from helimag.studio.predicting import RUNS, lab_errors, outcomes
from helimag.studio.tab import Tab

LONGEST_SAID = 200  # characters of why a calibration cannot be used: its plan may hold any text
NONE = "No calibration is loaded: the device is as the inputs say."
ERRORS = [knob for knob in KNOBS if knob.path not in {DIRECTION, "run.duration"}]


class EnsemblePanel:
    """Load a calibration, give errors, run copies, show shares of verdicts."""

    def __init__(self, tab: Tab) -> None:
        self.tab, self.job = tab, Job(tab.live)
        self.fit: Posterior | None = None
        self.run_of = ""
        opened = chooser(".nc", MOST_RUN, "upload-calibration", self.given, tab.complain)
        ui.label(
            "How sure is the outcome? Copies of the run, each with a device that the calibration holds for possible "
            "(fit.nc, from helimag calibrate) and with errors of its own."
        ).classes("hs-small")
        with ui.element("div").classes("hs-row"):
            self.start_button = button(f"Run {RUNS} copies", "casino", self.start, "ensemble-start", "solid")
            button("Load a calibration", "upload_file", opened, "ensemble-load")
            self.forget_button = button("Forget it", None, self.forget, "ensemble-forget", "flat")
        self.forget_button.set_visibility(False)
        self.loaded = ui.label(NONE).props('data-testid="ensemble-inputs"')
        self.other = ui.label("").classes("hs-small hs-caution").props('data-testid="ensemble-other"')
        self.status = ui.label("").classes("hs-small").props('data-testid="ensemble-status"')
        self.table = ui.element("div").classes("hs-cards")
        self._errors()
        tab.scenario_listeners.append(self.changed)

    def _errors(self) -> None:
        """Fields for the errors from run to run."""
        title = "Errors from run to run (standard deviations)"
        expansion = ui.expansion(title, value=True).classes("hs-group").props("dense")
        with expansion, ui.element("div").classes("hs-errors"):
            self.displacement = _field("Place where it is released", "mm", "displacement", 0.5)
            self.fields = {knob.path: _field(knob.label, unit_text(knob.unit), knob.path, 0.0) for knob in ERRORS}

    def given(self, _: str, content: bytes) -> None:
        """A file that someone chose."""
        try:
            fit = fit_from_bytes(content)
        except HelimagError as error:
            self.tab.complain(str(error))
            return
        self.take(fit)

    def forget(self) -> None:
        """Go back to the device as the inputs say."""
        self.take(None)

    def take(self, fit: Posterior | None) -> None:
        """Use a calibration, or none."""
        self.fit = fit
        self.forget_button.set_visibility(fit is not None)
        if fit is None:
            self.loaded.set_text(NONE)
        else:
            names = ", ".join(fit.names)[:200]
            self.loaded.set_text(f"Calibration '{fit.plan.name[:80]}': {len(fit.samples)} samples of {names}")
        self.changed(self.tab.scenario)

    def start(self) -> None:
        """Run the copies."""
        fit, scenario = self.fit, self.tab.scenario
        try:
            errors = lab_errors(
                {path: _value(field) for path, field in self.fields.items() if field.visible}, _value(self.displacement)
            )
        except InputError as error:
            self.tab.complain(str(error))
            return
        self.run_of = scenario.hash
        self.status.set_text("running copies ...")
        self.job.start(
            lambda progress: outcomes(scenario, fit, errors, progress),
            self.tab.in_page(self.done),
            self.tab.in_page(self.status.set_text),
            self.tab.in_page(lambda share: self.status.set_text(f"running copies ... {share:.0%}")),
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
                    ui.label(f"{in_percent(share)} %")

    def changed(self, scenario: Scenario) -> None:
        """Say where shares or calibration are of something else."""
        for knob in ERRORS:
            self.fields[knob.path].set_visibility(knob.value(scenario) is not None)
        if self.run_of and scenario.hash != self.run_of:
            self.status.set_text("the inputs have changed since; run the copies again")
        self.other.set_text("" if self.fit is None else _said(self.fit, scenario))


def _said(fit: Posterior, scenario: Scenario) -> str:
    """Why a scenario cannot be run with a calibration; nothing where it can."""
    try:
        check_device(fit, scenario)
    except HelimagError as error:
        return str(error)[:LONGEST_SAID]
    return ""


def _field(label: str, unit: str, name: str, value: float) -> ui.number:
    """A number with its unit."""
    field = ui.number(label, value=value, min=0.0, suffix=unit, format="%.6g")
    return field.props(f'dense data-testid="error-{name.replace(".", "-")}"')


def _value(field: ui.number) -> float:
    """What a field holds; nothing is no error."""
    return 0.0 if field.value is None else float(field.value)
