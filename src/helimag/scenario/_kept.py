"""Whether the scenario that a result's file keeps is the one that its runs were made of."""

import json
from collections.abc import Mapping
from typing import Any

from helimag.errors import InputError
from helimag.scenario._files import parse


def check_kept(attributes: Mapping[str, Any]) -> None:
    """Hold the scenario in a file's attributes against the hash beside it, where both are there.

    A file of another version of helimag is let pass: that may read the same text as another scenario.

    Raises
    ------
    InputError
        Where the two do not agree.
    """
    text, digest = attributes.get("scenario"), attributes.get("scenario_hash")
    if not isinstance(text, str) or not isinstance(digest, str) or not same_version(attributes):
        return
    found = parse(text, "its scenario").hash
    if found != digest:
        raise InputError(
            f"its scenario is not the one that was run: the text has the hash {found[:12]}, and scenario_hash is "
            f"{digest[:12]}; run it anew"
        )


def same_version(attributes: Mapping[str, Any]) -> bool:
    """Whether a file's attributes say that this version of helimag wrote it."""
    from importlib.metadata import version

    try:
        told = json.loads(attributes.get("versions", ""))
    except (TypeError, ValueError):
        return False
    return isinstance(told, dict) and told.get("helimag") == version("helimag")
