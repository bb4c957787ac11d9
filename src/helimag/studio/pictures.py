"""Packets that pages fetch: of each tab its live picture, the newest only, and the runs laid over it."""

import secrets
from dataclasses import dataclass, field

from fastapi import HTTPException, Response
from nicegui import app

ADDRESS = "/studio/picture"
# numbers hardly shrink, and shrinking them would take longer than sending them
HEADERS = {"cache-control": "no-store", "content-encoding": "identity"}


@dataclass
class Shelf:
    """A tab's packets, under a name that nobody can guess."""

    key: str = field(default_factory=lambda: secrets.token_urlsafe(18))
    live: bytes = b""
    others: list[bytes] = field(default_factory=list)

    def address(self, which: str) -> str:
        """Where a packet is: ``live``, or the number of another."""
        return f"{ADDRESS}/{self.key}/{which}"


_SHELVES: dict[str, Shelf] = {}


def new_shelf() -> Shelf:
    """A place for a tab's packets."""
    shelf = Shelf()
    _SHELVES[shelf.key] = shelf
    return shelf


def drop_shelf(shelf: Shelf) -> None:
    """Forget a tab's packets."""
    _SHELVES.pop(shelf.key, None)


@app.get(ADDRESS + "/{key}/{which}")
async def _packet(key: str, which: str) -> Response:
    shelf = _SHELVES.get(key)
    if shelf is None:
        raise HTTPException(404, "no such picture")
    if which == "live":
        content = shelf.live
    elif which.isdecimal() and len(which) < 4 and int(which) < len(shelf.others):
        content = shelf.others[int(which)]
    else:
        raise HTTPException(404, "no such picture")
    return Response(content, media_type="application/octet-stream", headers=HEADERS)
