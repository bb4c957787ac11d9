"""Whether the plan and the scenario that a sweep's file keeps are those that its runs were made of."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from helimag.errors import InputError
from helimag.scenario import parse, same_version
from helimag.sweeps.plan import parse_plan
from helimag.sweeps.resolved import ResolvedPlan


def check_kept_plan(attributes: Mapping[str, Any]) -> None:
    """Hold the texts of plan and scenario in a sweep's attributes against all that decided its runs, and that against
    its hash.

    A file of another version of helimag, or without such an identity, is let pass.

    Raises
    ------
    InputError
        Naming the first that does not agree.
    """
    if not isinstance(attributes.get("identity"), str) or not same_version(attributes):
        return
    stored = json.loads(attributes["identity"])
    if attributes.get("plan_hash") != identity_hash(stored):
        raise InputError("its identity is not the one that it was written with: plan_hash does not agree; run it anew")
    plan, base = parse_plan(attributes["plan"]), parse(attributes["scenario"], "its scenario")
    told = ResolvedPlan(plan, base, (), {}, method=str(attributes.get("method", "direct"))).identity
    there, here = ({k: v for k, v in each.items() if k.partition(".")[0] != "ensemble"} for each in (stored, told))
    there, here = {"method": "direct", **there}, json.loads(json.dumps(here))
    changed = [key for key in sorted({*there, *here}) if there.get(key) != here.get(key)]
    if changed:
        key = changed[0]
        raise InputError(
            f"its plan or scenario is not the one that was run: {key} is {here.get(key)!r} in its text, and its runs "
            f"have {there.get(key)!r}; run it anew"
        )


def identity_hash(identity: Mapping[str, Any]) -> str:
    """SHA-256 of all that decides the runs."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()
