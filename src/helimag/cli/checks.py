"""Commands that check: doctor."""

from helimag.cli._shared import Json, print_json
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
