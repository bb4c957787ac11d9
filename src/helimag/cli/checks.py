"""Commands about helimag itself: doctor, cite."""

from helimag.cli._common import PLAIN, Common
from helimag.cli._shared import Changes, ScenarioName, print_json, scenario_from
from helimag.errors import InputError, RunError


def doctor(scenario: ScenarioName | None = None, *, changes: Changes = None, common: Common = PLAIN) -> None:
    """Explain a scenario before it is run; without one, check this installation.

    A scenario: forces at the start, the distance of balance, step-out, swimming and sinking, which end leads, where its
    values come from, and which of the model's assumptions hold. The installation: versions, devices, and a short run
    against states from an independent code.
    """
    if scenario is None:
        if changes:
            raise InputError("--set needs a scenario, such as helimag doctor paper/fig3c --set drive.pitch='15 deg'")
        _installation(common.json)
        return
    from helimag.diagnosis import as_json, as_text, diagnose

    found = diagnose(scenario_from(scenario, changes))
    if common.json:
        print_json(as_json(found))
    else:
        print(as_text(found))


def _installation(json: bool) -> None:
    from helimag.doctor import examine

    report = examine()
    if json:
        print_json(report.findings)
    else:
        print(report.text)
    if not report.healthy:
        raise RunError("the check run does not match the reference states: see 'helimag doctor'")


def cite(scenario: ScenarioName, *, changes: Changes = None, common: Common = PLAIN) -> None:
    """Print a methods paragraph for runs of a scenario, and what to cite."""
    from importlib.metadata import version

    from helimag.cite import citations, methods

    chosen = scenario_from(scenario, changes)
    paragraph, references = methods(chosen, version("helimag")), citations(chosen)
    if common.json:
        print_json({"scenario": chosen.title, "methods": paragraph, "references": list(references)})
        return
    print(paragraph)
    print()
    for reference in references:
        print(f"- {reference}")
