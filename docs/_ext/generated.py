"""Parts of the reference that are written from the code, as MyST text: no name, unit or default is typed twice."""

import inspect
import json
import pkgutil
import re
import tomllib
import types
from collections.abc import Iterator
from enum import Enum
from importlib import import_module, resources
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Union, get_args, get_origin

import gallery  # from this folder

import helimag
from helimag.physics import kinematics
from helimag.scenario import Scenario, meanings, models_in, preset_names
from helimag.scenario._device import Part
from helimag.scenario._fields import Quantity

ROOMS_OF_FORMULAS = ("physics", "hydrodynamics", "outcomes", "runs.gain", "quantities")


def release() -> str:
    try:
        return version("helimag")
    except PackageNotFoundError:
        return "not installed"


def is_model(thing: object) -> bool:
    return inspect.isclass(thing) and issubclass(thing, Part)


def original(thing: Any) -> Any:
    """The Python function or class behind a Warp function or structure; anything else as it is."""
    import warp as wp

    if isinstance(thing, wp.Function):
        return thing.func
    return thing.cls if isinstance(thing, type(kinematics.ArmMotion)) and not inspect.isclass(thing) else thing


def formula_modules() -> Iterator[types.ModuleType]:
    """The public modules of the rooms that hold formulas."""
    for room in ROOMS_OF_FORMULAS:
        module = import_module(f"helimag.{room}")
        yield module
        for inner in pkgutil.iter_modules(getattr(module, "__path__", [])):
            if not inner.name.startswith("_"):
                yield import_module(f"{module.__name__}.{inner.name}")


def plain(docstring: str | None) -> str:
    """A docstring's text without Sphinx roles, for a Markdown page."""
    return re.sub(r":\w+:`~?([^`]+)`", r"`\1`", inspect.cleandoc(docstring or "")).replace("``", "`")


def unwrap_warp() -> None:
    """Put the Python originals in the place of Warp's functions and structures, so that autodoc sees their docstrings.

    Only for a process that builds documentation: the modules cannot make kernels afterwards.
    """
    for name in helimag.__all__:
        getattr(helimag, name)  # so that all that builds on the formulas has them already
    for module in list(formula_modules()):  # all of them made before any is changed
        for key, value in list(vars(module).items()):
            setattr(module, key, original(value))


def table(head: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def directive(kind: str, name: str, *options: str) -> str:
    body = "".join(f"\n   {option}" for option in options)
    return f"```{{eval-rst}}\n.. {kind}:: {name}{body}\n```\n"


def documented(home: str, name: str, thing: object) -> str:
    """The autodoc directive for a function, class or enumeration."""
    if not inspect.isclass(thing):
        return directive("autofunction", f"{home}.{name}")
    options = [":members:"]
    if issubclass(thing, Exception):
        options.append(":show-inheritance:")
    if issubclass(thing, Enum):
        options.append(":undoc-members:")
    if is_model(thing):
        options.append(":exclude-members: model_config")
    return directive("autoclass", f"{home}.{name}", *options) + fields(thing)


def fields(structure: type) -> str:
    """A table of a structure's fields, with the comments beside them in the source; empty where none has one."""
    rows = re.findall(r"^    (\w+): ([\w.]+)(?: *# (.*))?$", inspect.getsource(structure), flags=re.MULTILINE)
    if not any(comment for _, _, comment in rows):
        return ""
    return "\n" + table(("field", "type", "meaning"), ((f"`{n}`", f"`{t}`", c) for n, t, c in rows))


def public_names() -> str:
    """Every name of ``helimag.__all__``, by the module it lives in."""
    parts = []
    for room in sorted(set(helimag._HOMES.values())):
        names = [name for name in helimag.__all__ if helimag._HOMES[name] == room]
        parts.append(f"## {room}\n\n{plain(import_module(f'helimag.{room}').__doc__)}\n")
        parts += [
            f"### `helimag.{name}`\n\n{documented(f'helimag.{room}', name, getattr(helimag, name))}" for name in names
        ]
    return "\n".join(parts)


def scenario_models() -> str:
    """The models that a scenario is made of."""
    from helimag import scenario

    names = [name for name in scenario.__all__ if is_model(getattr(scenario, name)) and name not in helimag.__all__]
    return "\n".join(documented("helimag.scenario", name, getattr(scenario, name)) for name in names)


def formulas() -> str:
    """Every public function and structure of the rooms that hold formulas, but for public names."""
    shown = {getattr(helimag, name) for name in helimag.__all__}
    parts = []
    for module in formula_modules():
        home = module.__name__
        parts.append(f"## `{home}`\n\n{plain(module.__doc__)}\n")
        for name, value in vars(module).items():
            thing = original(value)
            own = getattr(thing, "__module__", None) == home and not name.startswith("_")
            if own and (inspect.isfunction(thing) or inspect.isclass(thing)) and thing not in shown and thing.__doc__:
                parts.append(documented(home, name, thing))
    return "\n".join(parts)


def kind_of(annotation: object, schema: dict[str, Any]) -> str:
    """What may stand in the file: the wording of the JSON schema, in short."""
    if "$ref" in schema or "discriminator" in schema:
        return "table"
    if "anyOf" in schema:
        return " or ".join(kind_of(annotation, option) for option in schema["anyOf"] if option.get("type") != "null")
    if "enum" in schema:
        return ", ".join(f'`"{value}"`' for value in schema["enum"])
    if "const" in schema:
        return f'`"{schema["const"]}"`'
    if schema.get("type") == "array":
        if "prefixItems" in schema:
            first = kind_of(annotation, schema["prefixItems"][0])
            return f"array of {len(schema['prefixItems'])}, each {first}"
        inner = kind_of(annotation, schema.get("items", {}))
        return "table, or array of tables" if inner == "table" else f"array, each {inner}"
    if "examples" in schema:
        return f'{schema["description"]}, such as `"{schema["examples"][0]}"`'
    others = {"string": "text", "object": "table", "number": "number", "boolean": "`true` or `false`"}
    return others.get(str(schema.get("type")), "value")


def sign_of(annotation: object, metadata: list[object]) -> str:
    """What a quantity's number must be, where not any number will do."""
    for mark in [*metadata, *getattr(annotation, "__metadata__", ())]:
        if isinstance(mark, Quantity):
            return "" if mark.sign == "any" else f"; {mark.sign}"
    return next(filter(None, (sign_of(inner, []) for inner in get_args(annotation))), "")


def default_of(model: type[Part], name: str) -> str:
    """A field's default as a file would write it."""
    field = model.model_fields[name]
    if field.is_required():
        return "needed"
    value = field.get_default(call_default_factory=True)
    if value is None or isinstance(value, Part) or value == {}:
        return "optional"
    written = model.__pydantic_serializer__.to_python(
        model.model_construct(**{name: value}), mode="json", warnings=False
    )
    return f"`{json.dumps(written[name])}`"


def scenario_keys(model: type[Part] = Scenario, path: str = "") -> str:
    """Tables of all keys of a scenario file, from the models and their JSON schema."""
    schema = model.model_json_schema()
    told = meanings(model)
    rows = []
    below = []
    for name, field in model.model_fields.items():
        kind = kind_of(field.annotation, schema["properties"][name]) + sign_of(field.annotation, field.metadata)
        rows.append((f"`{name}`", told[name], kind, default_of(model, name)))
        union = get_origin(field.annotation) in (Union, types.UnionType)
        for inner in models_in(field.annotation):
            deeper = f"{path}.{name}".lstrip(".")
            shape = (
                f' with `{next(iter(inner.model_fields))} = "{inner.model_fields["shape"].default}"`'
                if (union and "shape" in inner.model_fields)
                else ""
            )
            below.append(scenario_keys(inner, deeper).replace(f"## `[{deeper}]`", f"## `[{deeper}]`{shape}", 1))
    title = f"## `[{path}]`" if path else "## Top level"
    about = plain(model.__doc__)
    return f"{title}\n\n{about}\n\n{table(('key', 'meaning', 'value', 'default'), iter(rows))}\n" + "\n".join(below)


def trajectory_variables() -> str:
    """The variables of a trajectory file."""
    from helimag.runs.trajectory import VARIABLES

    rows = (
        (f"`{name}`", ", ".join(dimensions), f"`{unit}`", meaning)
        for name, (dimensions, unit, meaning) in VARIABLES.items()
    )
    return table(("variable", "dimensions", "units", "meaning"), rows)


def commands() -> str:
    """The command line, from its own help."""
    from helimag.cli import app

    text = app.generate_docs(output_format="markdown")
    first = re.search(r"^## `?helimag ", text, flags=re.MULTILINE)
    assert first is not None, "the command line's generated help has changed its headings"
    return text[first.start() :]


def as_text(value: Any) -> str:
    """A TOML value in words."""
    if isinstance(value, dict):
        return "; ".join(f"{key}: {as_text(inner)}" for key, inner in value.items())
    return ", ".join(value) if isinstance(value, list) else str(value)


def preset_values(name: str) -> dict[str, tuple[str, str, str]]:
    """Values of a preset's file by path, each with its mark and source."""
    data = tomllib.loads((resources.files("helimag") / "presets" / f"{name}.toml").read_text(encoding="utf-8"))
    values = {}
    for path, mark in data["provenance"].items():
        value: Any = data
        for step in path.split("."):
            value = value[step]
        kind, _, source = mark.partition(": ")
        values[path] = (as_text(value), kind, source)
    return values


def preset_marks() -> str:
    """All values of one preset, and of the others those that differ from it."""
    first = "paper/fig3c"
    base = preset_values(first)
    parts = []
    for name in [first, *(name for name in preset_names() if name != first)]:
        values = preset_values(name)
        shown = values if name == first else {path: v for path, v in values.items() if base.get(path) != v}
        rows = ((f"`{path}`", *value) for path, value in shown.items())
        note = "All values." if name == first else f"As `{first}`, except for:"
        parts.append(f"## `{name}`\n\n{note}\n\n{table(('field', 'value', 'mark', 'source'), rows)}")
    return "\n".join(parts)


PARTS = {
    "api.md": public_names,
    "cli.md": commands,
    "formulas.md": formulas,
    "gallery.md": gallery.page,
    "map.toml": lambda: gallery.MAP,
    "presets.md": preset_marks,
    "models.md": scenario_models,
    "scenario.md": scenario_keys,
    "trajectory.md": trajectory_variables,
}


def write(folder: Path) -> None:
    """Write all parts, touching only what has changed so that Sphinx rebuilds no more than it must."""
    folder.mkdir(exist_ok=True)
    for name, part in PARTS.items():
        text = part()
        target = folder / name
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.write_text(text, encoding="utf-8")
