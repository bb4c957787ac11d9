"""The documentation as a reader sees it: built, opened in a browser, on a phone's screen and a desk's."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import browser

DOCS = Path(__file__).parent.parent / "docs"
SCREENS = {"phone": (390, 844), "desk": (1280, 900)}
# with equations, with wide tables, with long command lines, with pictures
SHOWN = ("index", "gallery", "glossary", "model", "tutorial", "reference/scenario-file", "howto/orbit", "theory/table1")
UNSEEN = """
() => ({
  overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  equations: document.querySelectorAll('.math').length,
  unset: document.querySelectorAll('.math:not(:has(mjx-container)), mjx-merror').length,
  cut: [...document.querySelectorAll('.highlight-console pre')].filter((e) => e.scrollWidth > e.clientWidth).length,
  missing: [...document.images].filter((e) => e.complete && e.naturalWidth === 0).length,
})
"""


@pytest.fixture(scope="module")
def built() -> Path:
    pytest.importorskip("sphinx", reason="the documentation is built with Sphinx: make venv installs it")
    out = DOCS / "_build" / "html"  # as make docs does, which then has less to do
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", str(DOCS), str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    if (reason := browser.lacking()) is not None:
        pytest.skip(reason)
    with browser.chromium() as found:
        yield found


@pytest.mark.parametrize("screen", SCREENS)
def test_pages_fit_the_screen_and_ask_no_other_host(screen: str, built: Path, chromium: Any) -> None:
    width, height = SCREENS[screen]
    page = chromium.new_page(viewport={"width": width, "height": height})
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    equations = 0
    for name in SHOWN:
        page.goto((built / f"{name}.html").as_uri())
        page.wait_for_function("() => !document.querySelector('.math') || document.querySelector('mjx-container')")
        page.wait_for_timeout(300)
        seen = page.evaluate(UNSEEN)
        equations += seen.pop("equations")
        assert seen == {"overflow": 0, "unset": 0, "cut": 0, "missing": 0}, name
    assert equations > 50
    assert asked
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []
    page.close()


def test_gallery_shows_what_was_typed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS / "_ext")
    import gallery

    from helimag.cli import app

    page = gallery.page()
    for shown in gallery.SHOWN:
        assert (DOCS / "_static" / "gallery" / f"{shown.name}.png").is_file()
        assert (DOCS / shown.page).is_file()
        assert f"_static/gallery/{shown.name}.png" in page
        for command in shown.commands:
            app.parse_args(command.removeprefix("helimag "), exit_on_error=False, print_error=False)
