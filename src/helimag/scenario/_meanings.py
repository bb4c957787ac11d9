"""What each key of a scenario file means: the texts below the fields of the models."""

import ast
import inspect
from itertools import pairwise
from typing import Any

from pydantic import BaseModel

from helimag.scenario._refusals import models_in
from helimag.scenario._scenario import Scenario


def meanings(model: type[BaseModel]) -> dict[str, str]:
    """What each key of a part means, in one line each.

    Read from the source when it is asked for: pydantic would read it whenever helimag starts.
    """
    body = ast.parse(inspect.getsource(model)).body[0].body  # type: ignore[attr-defined]
    return {
        field.target.id: " ".join(text.value.value.replace("``", "`").split())
        for field, text in pairwise(body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }


def schema() -> dict[str, Any]:
    """JSON schema of scenario files, with what each key means."""
    whole = Scenario.model_json_schema()
    for model in _parts(Scenario):
        keys = (whole if model is Scenario else whole["$defs"][model.__name__])["properties"]
        for key, meaning in meanings(model).items():
            form = keys[key].get("description")
            keys[key]["description"] = meaning if form is None else f"{meaning} Here: {form}."
    return whole


def _parts(model: type[BaseModel]) -> set[type[BaseModel]]:
    below = {part for field in model.model_fields.values() for part in models_in(field.annotation)}
    return {model}.union(*map(_parts, below))
