"""Commands about helimag itself: doctor, cite."""

from helimag.cli._shared import Changes, Json, ScenarioName, print_json, scenario_from
from helimag.errors import RunError


def doctor(*, json: Json = False) -> None:
    """Check this installation: versions, devices, and a short run against states from an independent code."""
    from helimag.doctor import examine

    report = examine()
    if json:
        print_json(report.findings)
    else:
        print(report.text)
    if not report.healthy:
        raise RunError("the check run does not match the reference states: see 'helimag doctor'")


def cite(scenario: ScenarioName, *, changes: Changes = None) -> None:
    """Print a methods paragraph for runs of a scenario, and what to cite."""
    from importlib.metadata import version

    from helimag.cite import citations, methods

    chosen = scenario_from(scenario, changes)
    print(methods(chosen, version("helimag")))
    print()
    for reference in citations(chosen):
        print(f"- {reference}")
