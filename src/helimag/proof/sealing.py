"""Certificates as text that nobody changes unseen: JSON closed by its hash, read without a second meaning."""

import hashlib
import json
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from helimag.errors import InputError
from helimag.files import replacing


class Sealed(ABC):
    """What is written as JSON that is closed by the hash of its content."""

    @abstractmethod
    def content(self) -> dict[str, Any]:
        """All but the hash, as JSON has it.

        Returns
        -------
        dict
            Plain numbers, text and lists.
        """

    @property
    def hash(self) -> str:
        """SHA-256 of the content."""
        return digest(self.content())

    def text(self) -> str:
        """The certificate as JSON, closed by the hash of all before it.

        Returns
        -------
        str
            One object, as :func:`helimag.proof.read_any` reads it.
        """
        return sealed(self.content())

    def save(self, path: str | Path) -> None:
        """Write the certificate.

        Raises
        ------
        FileError
            Where the file cannot be written.
        """
        with replacing(path) as beside:
            beside.write_text(self.text(), encoding="utf-8")


def sealed(content: Mapping[str, Any]) -> str:
    """Content as JSON, a line for each of its parts, closed by the hash of all of it."""
    parts = (
        f"{json.dumps(key)}: {json.dumps(value, separators=(',', ':'), allow_nan=False)}"
        for key, value in {**content, "sha256": digest(content)}.items()
    )
    return "{" + ",\n".join(parts) + "}\n"


def digest(content: Mapping[str, Any]) -> str:
    """SHA-256 of a certificate's content."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode()).hexdigest()


@contextmanager
def reading() -> Iterator[None]:
    """Say in one line that something is no certificate, whatever it is that cannot be read of it."""
    try:
        yield
    except InputError:
        raise
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        raise InputError(f"this is no certificate of a proof: {error}") from None


def opened(text: str, of: str) -> tuple[dict[str, Any], str]:
    """The content of a certificate of a format, and the hash that it is closed by; within :func:`reading`."""
    content = json.loads(text, object_pairs_hook=_once)
    recorded = content.pop("sha256")
    if content["format"] != of:
        raise InputError(f"a certificate must be of the format '{of}'; got '{content['format']}'")
    if digest(content) != recorded:
        raise InputError("the certificate's content is not what its sha256 was made of: it was changed")
    return content, recorded


def format_of(text: str) -> object:
    """What a certificate says that it is; within :func:`reading`."""
    return json.loads(text, object_pairs_hook=_once)["format"]


def require_same(content: Mapping[str, Any], recorded: str) -> None:
    """Refuse what was read where this version would write it otherwise: it may say more than is understood of it."""
    if digest(content) != recorded:
        raise InputError("the certificate says what this version does not: it was made by another, or changed")


def _once(given: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON, in which no key may stand twice: a reader might take the other one."""
    content = dict(given)
    if len(content) != len(given):
        raise InputError("the certificate has a key twice: it was changed")
    return content
