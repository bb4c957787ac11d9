"""A studio served by a process of its own, and a real Chromium to look at it with."""

import os
import re
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

import pytest

CHROMIUM = shutil.which("chromium") or "/usr/bin/chromium"
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def lacking() -> str | None:
    """What this machine lacks for tests in a browser, in one line; None where nothing."""
    try:
        import nicegui  # noqa: F401
        import playwright  # noqa: F401
    except ImportError as error:
        return f"tests in a browser need {error.name}: pip install helimag[studio] playwright"
    if not Path(CHROMIUM).is_file():
        return "tests in a browser need Chromium at /usr/bin/chromium: apt-get install chromium"
    return None


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def served(*options: str, folder: Path | None = None, port: int | None = None) -> Iterator[str]:
    """A studio on a free port, or a given one: its address, as it printed it."""
    port = port or free_port()
    command = [sys.executable, "-m", "helimag", "studio", "--no-browser", "--port", str(port), *options]
    place = None if folder is None else str(folder)
    # NiceGUI behaves otherwise in a process that it takes for a test
    world = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=place, env=world) as process:
        try:
            yield answering(process, port)
        finally:
            process.terminate()
            process.communicate(timeout=20)


def answering(process: subprocess.Popen, port: int) -> str:
    """The address that the server prints, when it answers there."""
    line = process.stderr.readline()
    match = re.search(r"(http://\S+)", line)
    if match is None:
        pytest.fail(f"the studio did not start: {line}{process.stderr.read()}")
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        try:
            urlopen(f"http://127.0.0.1:{port}/studio/picture/none/live", timeout=2.0).close()
        except OSError as error:
            if getattr(error, "code", None) is not None:
                return match[1]
            time.sleep(0.1)
    pytest.fail("the studio did not answer within a minute")


@contextmanager
def chromium() -> Iterator[object]:
    """A browser."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as tool:
        browser = tool.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()
