"""The server: one page, on this machine unless told otherwise."""

import secrets
import socket
import sys
import threading
from collections.abc import Callable

from nicegui import app, ui

from helimag.errors import InputError
from helimag.scenario import Scenario
from helimag.studio.guard import Guard, is_loopback, rules_for
from helimag.studio.live import warmed
from helimag.studio.page import Setting, page
from helimag.studio.state import beginning


def serve(
    scenario: str,
    *,
    host: str = "127.0.0.1",
    port: int = 8137,
    browser: bool = True,
    demo: bool = False,
    tell: Callable[[str], None] | None = None,
) -> None:
    """Serve the studio until interrupted.

    Parameters
    ----------
    scenario
        A preset or a file that new tabs begin with.
    host
        Address to listen at. Where other machines can reach it, a token is asked for, which the address printed has.
    port
        To listen at.
    browser
        Whether to open a browser.
    demo
        Whether the page tours itself.
    tell
        Called with the address, its token in it, before the page is served.

    Raises
    ------
    InputError
        Where the scenario does not fit or the port is taken.
    FileError
        Where there is no such scenario.
    """
    setting = Setting(beginning(scenario), demo)
    _check_free(host, port)
    token = None if is_loopback(host) else secrets.token_urlsafe(24)
    rules = rules_for(host, port, token)
    app.add_middleware(Guard, rules=rules)

    @ui.page("/", title="helimag studio", dark=None, reconnect_timeout=30.0)
    async def _index(s: str | None = None) -> None:
        await page(setting, s)

    address = f"http://{'localhost' if is_loopback(host) else _own_name(host)}:{port}/"
    if token is not None:
        address += f"?token={token}"
    app.on_startup(lambda: _warm(setting.state.scenario))
    print(f"helimag studio at {address}", file=sys.stderr, flush=True)
    if tell is not None:
        tell(address)
    ui.run(
        host=host,
        port=port,
        show=address if browser else False,
        reload=False,
        tailwind=False,
        show_welcome_message=False,
        binding_refresh_interval=None,
        message_history_length=200,
    )


def _warm(scenario: Scenario) -> None:
    """Load the kernels that the first page needs while a browser is still on its way here."""
    threading.Thread(target=warmed, args=(scenario,), name="helimag-warm", daemon=True).start()


def _check_free(host: str, port: int) -> None:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except (OSError, OverflowError) as error:
            raise InputError(f"--port {port} cannot be used at {host}: {error}; give another") from None


def _own_name(host: str) -> str:
    return socket.gethostname() if host in {"0.0.0.0", "::"} else host
