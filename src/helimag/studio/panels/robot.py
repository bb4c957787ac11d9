"""The robot programme of the present point: checked, with its report, as one file."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nicegui import ui

from helimag.scenario import Scenario
from helimag.studio.downloads import file_name, zipped
from helimag.studio.jobs import Job
from helimag.studio.panels.controls import button
from helimag.studio.tab import Tab


@dataclass(frozen=True)
class Programme:
    """What came of a plan: a report, and the files where there is a programme."""

    report: dict[str, Any]
    files: dict[str, bytes]
    objection: str | None


def programme(scenario: Scenario, *, unwind: bool, accept: bool, progress: Callable[[float], None]) -> Programme:
    """Plan the arm's path for a scenario, rehearse it, and write the programme, read back, where nothing objects.

    Raises
    ------
    InputError
        Where the plan cannot be made.
    """
    from helimag import robot
    from helimag.errors import InputError, NotFeasible

    cell = robot.load_cell("wide")  # holds the circles of Fig. 3 as well as the straight runs
    plan = robot.plan(scenario, cell, unwind=unwind)
    progress(0.3)
    report = robot.report(plan)
    try:
        robot.feasible_or_refused(plan)
        run = robot.rehearse(plan, progress=lambda share: progress(0.3 + 0.5 * share))
        report["verdict"] = str(run.verdict)
        texts = robot.programme_texts(plan, run=run, accept_unbounded=accept)
    except (InputError, NotFeasible) as error:
        return Programme(report, {}, str(error))
    progress(0.95)
    text = json.dumps(report, indent=2, allow_nan=False).encode()
    files = {
        name: content.replace("\n", "\r\n").encode() if name.endswith((".src", ".dat")) else content.encode()
        for name, content in texts.items()
    }
    return Programme(report, {**files, "report.json": text, "scenario.toml": scenario.to_toml().encode()}, None)


def robot_panel(tab: Tab) -> Callable[[], None]:
    """Build the panel; gives what starts the check."""
    job = Job(tab.live)
    made: list[Programme] = []

    def start() -> None:
        scenario, asked = tab.scenario, (bool(unwind.value), bool(accept.value))
        status.set_text("planning and rehearsing ...")
        get.set_visibility(False)
        table.clear()
        job.start(
            lambda progress: programme(scenario, unwind=asked[0], accept=asked[1], progress=progress),
            tab.in_page(done),
            tab.in_page(status.set_text),
            tab.in_page(lambda share: status.set_text(f"planning and rehearsing ... {share:.0%}")),
        )

    def done(result: Programme) -> None:
        made[:] = [result]
        get.set_visibility(bool(result.files))
        status.set_text(result.objection or "The programme is written and read back; it is the plan.")
        with table:
            _report(result.report)

    def give() -> None:
        if made:
            ui.download.content(zipped(made[0].files), f"{file_name(str(made[0].report['scenario']))}-programme.zip")

    ui.label(
        "Checked programme for the arm: joint limits and speeds, singularities, collisions, and a rehearsal of the run."
    ).classes("hs-small")
    unwind = ui.checkbox("Let axis 6 turn back between laps", value=True).props("dense")
    accept = ui.checkbox("Write it although nothing shows that the device stays", value=False)
    accept.props('dense data-testid="robot-accept"')
    with ui.element("div").classes("hs-row"):
        button("Check and write", "precision_manufacturing", start, "robot-start", "solid")
        get = button("Download", "download", give, "robot-download")
    get.set_visibility(False)
    status = ui.label("").props('data-testid="robot-status"')
    table = ui.element("div").classes("hs-cards")
    tab.scenario_listeners.append(lambda scenario: _outdated(made, scenario, get, status))
    return start


def _outdated(made: list[Programme], scenario: Scenario, get: ui.button, status: ui.label) -> None:
    """A programme of another scenario is not offered."""
    if made and made[0].report["scenario_hash"] != scenario.hash:
        made.clear()
        get.set_visibility(False)
        status.set_text("The inputs have changed since; check again.")


def _report(report: dict[str, Any]) -> None:
    rows = {
        "Arm": str(report["arm"]),
        "Feasible": "yes" if report["feasible"] else "no",
        "Duration": f"{report['duration_s']:.1f} s",
        "Laps": f"{report['laps']:.2f}",
        "Unwindings": str(len(report["unwindings"])),
        "Rehearsal": str(report.get("verdict", "-")),
    }
    with ui.element("div").classes("hs-card"):
        for name, value in rows.items():
            with ui.element("div").classes("hs-number-row"):
                ui.label(name).classes("hs-small")
                ui.label(value)
        for remedy in report["remedies"]:
            ui.label(str(remedy)).classes("hs-small")
