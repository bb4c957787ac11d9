"""The package's shape: who imports whom, what is forbidden, and that public names are documented."""

import ast
import importlib
import inspect
import re
from pathlib import Path

import pytest

import helimag as hm

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "helimag"
MODULES = sorted(PACKAGE.rglob("*.py"))

# what a room may import of the others
RULES = {
    "errors": set(),
    "files": {"errors"},
    "quantities": {"errors"},
    "scenario": {"errors", "files", "quantities"},
    "physics": {"errors"},
    "runs": {"errors", "files", "quantities"},
    "hydrodynamics": {"errors", "scenario"},
    "engine": {"errors", "scenario", "physics", "hydrodynamics", "runs"},
    "orbits": {"errors", "files", "scenario", "physics", "runs", "engine"},
    "design": {"errors", "scenario", "runs", "engine", "orbits"},
}
# everything else, from the ground up: a room imports only from lower ones
STOREYS = [
    {*RULES},
    {"cite", "doctor", "robot", "sweeps", "calibrate"},
    {"vision"},
    {"plots"},
    {"reproduce", "studio"},
    {"cli"},
    {"__main__", "__init__"},
]
PICTURES = {"cli": {"reproduce", "plots", "studio"}, "reproduce": {"plots"}, "studio": {"plots"}, "__main__": {"cli"}}


# rooms inside a room, from the ground up: each imports from lower ones only, and by what they export
INNER = {"orbits": ["strobe", "curves", "slow_flow", "beside_runs", "datasets"]}


def room_of(parts):
    return parts[0] if parts else "__init__"


def imports(path):
    """Rooms of helimag that a file imports anywhere in it, functions included; and outside packages."""
    inside, outside = set(), set()
    tree = ast.parse(path.read_text(encoding="utf-8"))
    typing_only = {
        node
        for branch in ast.walk(tree)
        if isinstance(branch, ast.If) and ast.unparse(branch.test) == "TYPE_CHECKING"
        for node in ast.walk(branch)
    }
    for node in ast.walk(tree):
        if node in typing_only:
            continue
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [f"{node.module}.{a.name}" if node.module == "helimag" else node.module for a in node.names]
        else:
            continue
        for name in names:
            head, *rest = name.split(".")
            if head == "helimag":
                inside.add(room_of(rest))
            else:
                outside.add(head)
    return inside, outside


def own_room(path):
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return room_of(parts)


GRAPH = {}
for _path in MODULES:
    GRAPH.setdefault(own_room(_path), set()).update(imports(_path)[0])
for _room, _targets in GRAPH.items():
    _targets.discard(_room)


def test_every_room_is_known():
    assert GRAPH.keys() <= set().union(*STOREYS), "give the new room its storey here and in the documentation"
    assert GRAPH.keys() >= RULES.keys() | {"cli"}


@pytest.mark.parametrize("room", sorted(RULES))
def test_core_rooms_import_only_what_they_may(room):
    assert GRAPH[room] <= RULES[room]


@pytest.mark.parametrize("room", sorted(GRAPH))
def test_imports_point_downwards(room):
    storey = {name: i for i, names in enumerate(STOREYS) for name in names}
    above = {target for target in GRAPH[room] if storey[target] > storey[room]}
    assert not above
    if room in PICTURES or room == "__init__":
        return
    assert not GRAPH[room] & {"cli", "studio", "plots", "reproduce"}


def test_import_graph_is_acyclic():
    done, path = set(), []

    def visit(room):
        assert room not in path, " -> ".join([*path, room])
        if room in done or room not in GRAPH:
            return
        path.append(room)
        for target in sorted(GRAPH[room] - {"__init__"}):
            visit(target)
        path.pop()
        done.add(room)

    for room in sorted(GRAPH):
        visit(room)


def test_modules_are_acyclic_within_rooms_too():
    """File by file, imports at module level only."""
    graph = {}
    for path in MODULES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        name = ".".join(("helimag", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
        graph[name] = {
            target
            for node in tree.body
            if isinstance(node, ast.ImportFrom) and node.module.startswith("helimag.")
            for target in (node.module, *(f"{node.module}.{a.name}" for a in node.names))
        }
    state = {}

    def visit(name, trail):
        assert state.get(name) != "open", " -> ".join([*trail, name])
        if name not in graph or name in state:
            return
        state[name] = "open"
        for target in graph[name]:
            # a package's __init__ imports its own parts; that is no cycle
            if not f"{name}.".startswith(f"{target}."):
                visit(target, [*trail, name])
        state[name] = "done"

    for name in graph:
        visit(name, [])


def imported_names(path):
    """Every name that a file imports from helimag, functions and types included: module, name or None, line."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "helimag":
            yield from ((node.module, alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((a.name, None, node.lineno) for a in node.names if a.name.split(".")[0] == "helimag")


def named(path):
    """Modules and packages that a file names, with lines: ``from helimag.a import b`` names ``helimag.a.b`` too."""
    for module, name, line in imported_names(path):
        yield module.split("."), line
        if name is not None:
            yield [*module.split("."), name], line


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_no_private_module_of_another_room_is_imported(path):
    own = own_room(path)
    for parts, line in named(path):
        if len(parts) > 2 and parts[1] != own:
            private = [part for part in parts[2:] if part.startswith("_")]
            assert not private, f"line {line}: {'.'.join(parts)}"


@pytest.mark.parametrize("room", sorted(INNER))
def test_inner_rooms_import_from_lower_ones_by_what_they_export(room):
    order = INNER[room]
    folders = {p.name for p in (PACKAGE / room).iterdir() if p.is_dir() and (p / "__init__.py").exists()}
    assert folders == set(order)
    for path in MODULES:
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        if parts[0] != room or len(parts) < 3:
            continue
        for module, name, line in imported_names(path):
            _, *into = module.split(".")
            if into[:1] != [room] or into[1:2] == [parts[1]]:
                continue
            where = f"{path.relative_to(PACKAGE)}, line {line}: {module} {name}"
            assert len(into) == 2, where
            assert order.index(into[1]) < order.index(parts[1]), where
            exported = importlib.import_module(module).__all__
            assert name in exported, where


@pytest.mark.parametrize("room", [*sorted(INNER), "design"])
def test_nobody_outside_imports_what_a_room_does_not_export(room):
    exported = set(importlib.import_module(f"helimag.{room}").__all__)
    for path in MODULES:
        if own_room(path) == room:
            continue
        for module, name, line in imported_names(path):
            if module.split(".")[1:2] == [room]:
                where = f"{path.relative_to(PACKAGE)}, line {line}: {module} {name}"
                assert module == f"helimag.{room}", where
                assert name in exported, where


@pytest.mark.parametrize("package", ["pint", "nicegui", "magpylib", "matplotlib"])
def test_outside_packages_have_one_home(package):
    homes = {
        "pint": {"quantities"},
        "nicegui": {"studio"},
        "magpylib": set(),
        "matplotlib": {"plots", "reproduce"},
    }[package]
    users = {own_room(path) for path in MODULES if package in imports(path)[1]}
    assert users <= homes


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_nothing_forbidden_in(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        assert not isinstance(node, ast.Assert), f"line {node.lineno}: assert"
        assert not (isinstance(node, ast.ExceptHandler) and node.type is None), f"line {node.lineno}: bare except"
        assert not (isinstance(node, ast.ImportFrom) and node.names[0].name == "*"), f"line {node.lineno}: star import"
        if isinstance(node, ast.ExceptHandler) and all(isinstance(n, ast.Pass) for n in node.body):
            pytest.fail(f"line {node.lineno}: an error passed over in silence")


@pytest.mark.parametrize("name", hm.__all__)
def test_public_names_are_documented(name):
    thing = getattr(hm, name)
    text = inspect.getdoc(thing)
    assert text
    assert len(text.splitlines()[0]) > 10
    if inspect.isclass(thing):
        return
    sections = re.split(r"^(\w[\w ]*)\n-+$", text, flags=re.MULTILINE)
    parameters = dict(zip(sections[1::2], sections[2::2], strict=True)).get("Parameters", "")
    documented = {n.strip() for line in parameters.splitlines() if line and line[0] != " " for n in line.split(",")}
    assert documented == set(inspect.signature(thing).parameters)


def test_all_is_what_dir_shows():
    assert sorted(hm.__all__) == dir(hm)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = hm.nothing
