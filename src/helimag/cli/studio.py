"""The command that serves the studio."""

from typing import Annotated

from cyclopts import Parameter

from helimag.cli._shared import ScenarioName


def studio(
    scenario: ScenarioName = "paper/fig3c",
    *,
    port: int = 8137,
    host: str = "127.0.0.1",
    browser: bool = True,
    demo: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Serve a page on which inputs are turned by hand and runs, scene, charts and maps follow.

    Parameters
    ----------
    port
        Port to listen at.
    host
        Address to listen at; where other machines can reach it, whoever comes needs the token that is printed.
    browser
        Open it in a browser.
    demo
        Let the page tour itself.
    """
    from helimag.studio import serve

    serve(scenario, host=host, port=port, browser=browser, demo=demo)
