"""Buttons and file choosers, all alike."""

import math
from collections.abc import Callable

from nicegui import ui
from nicegui.events import UploadEventArguments


def number(given: object) -> float | None:
    """What a page sent, if it is a number."""
    return float(given) if isinstance(given, (int, float)) and math.isfinite(given) else None


LOOKS = {"solid": "unelevated", "outline": "outline", "flat": "flat"}


def button(label: str, icon: str | None, action: Callable[[], object], name: str, look: str = "outline") -> ui.button:
    """A button; ``name`` is what tests find it by."""
    return ui.button(label, icon=icon, on_click=action).props(f'{LOOKS[look]} dense no-caps data-testid="{name}"')


def chooser(
    suffixes: str,
    limit: int,
    name: str,
    given: Callable[[str, bytes], None],
    complain: Callable[[str], None],
) -> Callable[[], None]:
    """Something that lets a file be chosen; gives what opens it.

    Parameters
    ----------
    suffixes
        As ``.nc,.csv``.
    limit
        Bytes of the file.
    name
        That tests find it by.
    given
        Called with the file's name and its content.
    complain
        Called with a sentence where a file is too large.
    """

    async def uploaded(event: UploadEventArguments) -> None:
        content = await event.file.read()
        upload.reset()
        given(event.file.name, content)

    upload = ui.upload(on_upload=uploaded, auto_upload=True, max_file_size=limit, max_files=1)
    upload.on("rejected", lambda: complain(f"such a file must end in {suffixes} and have {limit // 1024} kB at most"))
    upload.classes("hs-hidden").props(f'accept="{suffixes}" data-testid="{name}"')

    def opened() -> None:
        upload.run_method("pickFiles")

    return opened
