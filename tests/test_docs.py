"""The documentation is true: pages run as written, commands exist, every public name has its entry."""

import contextlib
import io
import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from cyclopts import CycloptsError

import command_line
import helimag
from helimag.cli import app

ROOT = Path(__file__).parent.parent
PAGES = sorted(
    page.relative_to(ROOT)
    for page in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
    if not {"_build", "generated"} & set(page.parts)
)
NEEDS_A_CLUSTER = Path("docs/howto/sweep-on-a-cluster.md")  # test_sweep_pages runs its recipe
# run with -m nightly: minutes each
LONG = {
    Path(f"docs/howto/{name}.md")
    for name in ("design", "plot", "prove", "reproduce", "robot-programme", "track-two-cameras")
}
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
CLOSE = 0.02  # relative; the runs shown are sensitive to rounding, which differs between machines


class Block(NamedTuple):
    """A fenced block of a page; ``saved_as`` is the file's name where the line before says "Save as"."""

    language: str
    text: str
    line: int
    saved_as: str | None


def blocks(page: Path) -> Iterator[Block]:
    text = (ROOT / page).read_text(encoding="utf-8")
    fence = r"(?:^Save as `([^`]+)`:\n\n)?^( *)```([\w-]+)\n(.*?)^\2```"
    for match in re.finditer(fence, text, flags=re.MULTILINE | re.DOTALL):
        yield Block(match[3], match[4], text.count("\n", 0, match.start()) + 1, match[1])


def commands(block: Block) -> Iterator[tuple[str, str]]:
    """Command lines of a console block, each with the output that is shown below it; helimag's only."""
    for part in re.split(r"^\$ ", block.text, flags=re.MULTILINE)[1:]:
        command, _, output = part.replace("\\\n", " ").partition("\n")
        command = command.removeprefix(".venv/bin/")
        if command.startswith("helimag "):
            yield command, output


def helimag_commands(page: Path) -> list[str]:
    return [command for block in blocks(page) if block.language == "console" for command, _ in commands(block)]


def differs(shown: str, printed: str) -> str | None:
    """How printed text differs from what a page shows: ``...`` stands for anything, numbers must be close."""
    pieces = re.split(rf"(\.\.\.|{NUMBER})", shown.strip())
    wanted = [piece for piece in pieces[1::2] if piece != "..."]
    pattern = "".join(
        ".*?" if piece == "..." else rf"\s*({NUMBER})" if i % 2 else re.sub(r"(?:\\?\s)+", r"\\s*", re.escape(piece))
        for i, piece in enumerate(pieces)
    )
    match = re.fullmatch(pattern, printed.strip(), flags=re.DOTALL)
    if match is None:
        return f"the page shows\n{shown}\nbut it prints\n{printed}"
    for want, got in zip(wanted, match.groups(), strict=True):
        digits = len(want.partition(".")[2])
        if abs(float(got) - float(want)) > max(CLOSE * abs(float(want)), 2.0 * 10.0**-digits if digits else 0.0):
            return f"the page shows {want} where it prints {got}:\n{printed}"
    return None


def run_command(line: str) -> tuple[int, str]:
    """Run a helimag command line, perhaps with its output into a file; exit status and what it printed."""
    words = shlex.split(line)[1:]
    target = words[words.index(">") + 1] if ">" in words else None
    said = command_line.run(*(words[: words.index(">")] if target else words))
    if target:
        Path(target).write_text(said.out, encoding="utf-8")
        return said.status, ""
    return said.status, said.err if said.status else said.out


def run_page(page: Path) -> None:
    """Run a page in the current folder: files are saved, code and commands run, and what they print is compared.

    A text block shows what the Python block before it prints; other text blocks, and TOML without *Save as*, only show
    a form.
    """
    space: dict[str, object] = {"__name__": "page"}
    printed: str | None = None
    for block in blocks(page):
        where = f"{page}:{block.line}"
        before, printed = printed, None
        if block.saved_as is not None:
            Path(block.saved_as).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile(block.text, where, "exec"), space)
            printed = out.getvalue()
        elif block.language == "text" and before is not None:
            assert (difference := differs(block.text, before)) is None, f"{where}: {difference}"
        elif block.language == "console":
            for command, shown in commands(block):
                status, output = run_command(command)
                assert status == (2 if shown.startswith("helimag: ") else 0), f"{where}: {command}: {output}"
                if shown.strip():
                    assert (difference := differs(shown, output)) is None, f"{where}: {command}: {difference}"


RUNNABLE = [
    pytest.param(page, id=str(page), marks=[pytest.mark.nightly] if page in LONG else [])
    for page in PAGES
    if page != NEEDS_A_CLUSTER and any(block.language in ("console", "python") for block in blocks(page))
]


@pytest.mark.parametrize("page", RUNNABLE)
def test_page_runs_as_written(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run_page(page)


def test_every_how_to_is_run() -> None:
    pages = {param.values[0] for param in RUNNABLE}
    how_tos = {page for page in PAGES if page.parent == Path("docs/howto")}
    assert how_tos - {NEEDS_A_CLUSTER} <= pages
    assert pages >= LONG, "a page in the list is gone"


@pytest.mark.parametrize(("page", "runs"), [("README.md", 3), ("docs/model.md", 11)])
def test_tables_of_runs_are_true(page: str, runs: int) -> None:
    """A row that ends in a command claims a **verdict**, and perhaps a wall, a time and a gain."""
    text = (ROOT / page).read_text("utf-8")
    rows = re.findall(r"^\|.*\|(.*)\| `(helimag simulate .*)` \|$", text, re.MULTILINE)
    assert len(rows) == runs
    for claim, command in rows:
        status, output = run_command(f"{command} --json")
        assert status == 0, output
        result = json.loads(output)
        verdict, time, gain = claimed(claim)
        assert verdict == result["verdict"], command
        assert time or gain, f"{command}: a claim has a time or a gain"
        assert time is None or float(time) == pytest.approx(result["escape_time_s"] or result["end_time_s"], rel=CLOSE)
        assert gain is None or float(gain) == pytest.approx(result["gain"], rel=CLOSE)
        for wall in ("surface", "floor"):
            assert (wall in claim) == (wall in result["reason"]), command


def claimed(claim: str) -> tuple[str, str | None, str | None]:
    """Verdict, time and gain in a table's cell."""
    verdict = re.search(r"\*\*(.*?)\*\*", claim)
    time = re.search(rf" at ({NUMBER}) s", claim)
    gain = re.search(rf"\u03b3(?:\(700 s\))? = ({NUMBER})", claim)
    assert verdict is not None, claim
    return verdict[1], time and time[1], gain and gain[1]


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_commands_on_pages_exist(page: Path) -> None:
    for command in helimag_commands(page):
        words = shlex.split(re.split(r" [>|] ", command)[0])[1:]
        if any(word in ("--help", "--version") for word in words):
            continue
        try:
            app.parse_args(words, exit_on_error=False, print_error=False)
        except CycloptsError as error:
            pytest.fail(f"{page}: {command}: {error}")


def test_pages_have_commands() -> None:
    assert sum(len(helimag_commands(page)) for page in PAGES) > 10


def test_every_public_name_is_in_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")
    import generated

    entries = generated.public_names()
    for name in helimag.__all__:
        thing = getattr(helimag, name)
        assert f"### `helimag.{name}`" in entries
        assert thing.__doc__, f"helimag.{name} has no docstring"
    assert "{include} generated/api.md" in (ROOT / "docs/reference/api.md").read_text(encoding="utf-8")


def test_every_scenario_key_is_in_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")
    import generated

    text = generated.scenario_keys()
    for path in helimag.load("paper/fig3c").provenance:
        table, _, key = path.rpartition(".")
        section = text.partition(f"## `[{table}]`")[2].partition("\n## ")[0]
        assert f"| `{key}` |" in section, path


@pytest.mark.parametrize(
    ("shown", "printed"),
    [("gain 0.408", "gain 0.5"), ("3 runs", "4 runs"), ("a ... c", "a b"), ("bounded", "drifting"), ("x 1", "x 1 2")],
)
def test_a_page_that_lies_is_caught(shown: str, printed: str) -> None:
    assert differs(shown, printed) is not None


def test_a_page_that_is_true_passes() -> None:
    assert differs("gain  0.408 (y ... mm)\n  slips ...\n", "gain 0.407 (y 5.1 mm)\n  slips 12\n") is None
