"""What the commands share: options, scenario with changes, progress, JSON."""

import json
import logging
import math
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter, Token

from helimag.errors import InputError

if TYPE_CHECKING:
    from rich.progress import Progress

    from helimag.quantities import Kind
    from helimag.scenario import Scenario

ScenarioName = Annotated[str, Parameter(help="Name of a preset, or path of a TOML file.")]
Changes = Annotated[
    list[str] | None,
    Parameter(
        name="--set",
        negative="",
        consume_multiple=False,
        help='Change a field, such as --set drive.pitch="15 deg". May be repeated.',
    ),
]
LOG = logging.getLogger(__name__)
WHOLE = re.compile("[0-9]{1,18}")
LARGEST_SEED = 10**18 - 1
MOST_THREADS = 4096


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None]]:
    """A progress bar with an estimate on stderr, which appears when the work has taken a second."""
    begun = time.monotonic()
    LOG.info("%s ...", what)
    bar: Progress | None = None

    def report(done: float) -> None:
        nonlocal bar
        if bar is None:
            if time.monotonic() - begun <= 1.0:
                return
            bar = _bar(what, begun)
            if bar.console.is_terminal:
                bar.start()
        bar.update(bar.task_ids[0], completed=done)

    try:
        yield report
    finally:
        if bar is not None and bar.live.is_started:
            bar.stop()
        LOG.info("%s: %.2f s", what, time.monotonic() - begun)


def _bar(what: str, begun: float) -> "Progress":
    """A bar of work that began a while ago; what draws it is imported here, as short commands need none."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=Console(stderr=True), transient=True, get_time=time.monotonic)
    bar.add_task(what, total=1.0)
    bar.tasks[0].start_time = begun
    return bar


def input_range(option: str, scenario: "Scenario", text: str) -> tuple[str, tuple[float, float]]:
    """An input and its range (SI) from text such as ``drive.pitch=5 deg..15 deg``; ``option`` names it in messages."""
    from helimag.scenario import Input

    path, equals, span = text.partition("=")
    low, dots, high = span.strip().strip("\"'").partition("..")
    if not (equals and dots):
        raise InputError(f'{option} must be an input and a range such as drive.pitch="5 deg..15 deg"; got {text!r}')
    given = Input(path.strip())
    return given.path, (given.read(scenario, low.strip()), given.read(scenario, high.strip()))


def whole(least: int, most: int, **more: Any) -> Parameter:
    """Of an option that takes a whole number from ``least`` to ``most``, written in digits and no other way."""

    def read(_: object, tokens: Sequence[Token]) -> int:
        text = tokens[0].value
        if not WHOLE.fullmatch(text) or not least <= int(text) <= most:
            raise InputError(f"{tokens[0].keyword} must be a whole number from {least} to {most}; got {text[:40]!r}")
        return int(text)

    return Parameter(converter=read, **more)


def quantity(option: str, text: str, kind: "Kind") -> float:
    """An option's value in SI; ``option`` names it in messages."""
    from helimag import quantities

    try:
        return quantities.parse(text, kind)
    except InputError as error:
        raise InputError(f"{option} {error}") from None


def print_json(data: object) -> None:
    print(json.dumps(data, indent=2, allow_nan=False))


def validity_warnings(attributes: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What a result's attributes say of assumptions that do not hold; none where it has no such attribute."""
    return list(json.loads(attributes.get("validity_warnings", "[]")))


def accuracy_told(attributes: Mapping[str, Any]) -> dict[str, Any] | None:
    """What a result's attributes say of how far to trust its places; None where nothing."""
    told: dict[str, Any] | None = json.loads(attributes.get("accuracy", "null"))
    return told


def print_warnings(warnings: Sequence[Mapping[str, Any]]) -> None:
    """One line a kind on stderr."""
    for warning in warnings:
        print(f"helimag: warning: {warning['text']}", file=sys.stderr)


def scenario_from(name: str, changes: list[str] | None, extra: Mapping[str, object] | None = None) -> "Scenario":
    from helimag.scenario import load, varied

    fields: dict[str, object] = {}
    for change in changes or []:
        path, equals, value = change.partition("=")
        if not equals:
            raise InputError(f'--set must be a field and a value such as drive.pitch="15 deg"; got {change!r}')
        fields[path.strip()] = _value(value.strip())
    fields |= {path: value for path, value in (extra or {}).items() if value is not None}
    scenario = load(name)
    return varied(scenario, fields) if fields else scenario


def _value(text: str) -> object:
    """The value of --set: TOML where it is an array or table, plain text otherwise."""
    if text[:1] in "[{":
        import tomllib

        try:
            return tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError as error:
            raise InputError(f"--set has a value that is not TOML: {text} ({error})") from None
    return text.strip("\"'")


def leading_words(end: str, cosine: float) -> str:
    """Which end leads, with the number behind it."""
    if math.isnan(cosine):
        return "neither end: it stays in its place"
    return f"{end} (mean cosine of nose and velocity {cosine:+.2f})"


def degrees(angle: float) -> float:
    return angle * 57.29577951308232
