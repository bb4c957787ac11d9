"""The command that serves the studio."""

import sys
from typing import Annotated

from cyclopts import Parameter

from helimag.cli._common import PLAIN, Common
from helimag.cli._shared import ScenarioName, print_json, whole


def studio(
    scenario: ScenarioName = "paper/fig3c",
    *,
    port: Annotated[int, whole(0, 65_535)] = 8137,
    host: str = "127.0.0.1",
    browser: bool = True,
    demo: Annotated[bool, Parameter(negative="")] = False,
    common: Common = PLAIN,
) -> None:
    """Serve a page on which inputs are turned by hand and runs, scene, charts and maps follow.

    The address is said on stderr, with --json also as an object on stdout, as soon as the page is served.

    Parameters
    ----------
    scenario
        Name of a preset, or path of a TOML file.
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

    def tell(address: str) -> None:
        if common.json:
            print_json({"address": address})
            sys.stdout.flush()

    serve(scenario, host=host, port=port, browser=browser, demo=demo, tell=tell)
