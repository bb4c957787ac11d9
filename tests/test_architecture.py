"""The package's shape: who imports whom, what is forbidden, and that public names are documented."""

import ast
import importlib
import inspect
import re
from collections import Counter
from pathlib import Path

import pytest

import helimag as hm

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "helimag"
MODULES = sorted(PACKAGE.rglob("*.py"))


def rooms_on_the_page():
    """The table of docs/architecture.md: what each room may import of those above it."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.split("## Rooms")[1].split("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \| .+ \| ([^|]+) \|$", table, flags=re.MULTILINE)
    return {room: set() if allowed == "-" else set(allowed.split(", ")) for room, allowed in rows}


RULES = rooms_on_the_page()

# rooms inside rooms: what each may import of its sisters
INSIDE = {
    "vision": {
        "_cv": set(),
        "refraction": set(),
        "shape": set(),
        "rig_checks": {"refraction"},
        "cameras": {"_cv", "refraction", "rig_checks"},
        "silhouette": {"shape", "cameras"},
        "films": {"_cv"},
        "calibration": {"_cv", "refraction", "shape", "cameras", "films"},
        "tracking": {"_cv", "refraction", "shape", "cameras", "silhouette", "films", "calibration"},
        "synthetic": {"_cv", "refraction", "shape", "cameras", "silhouette", "films", "calibration"},
    },
    "orbits": {
        "strobe": set(),
        "curves": {"strobe"},
        "averaged": {"strobe"},
        "beside_runs": {"strobe", "curves", "averaged"},
        "datasets": {"strobe", "curves", "averaged", "beside_runs"},
    },
}


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


def test_the_page_shows_every_room():
    assert RULES.keys() == GRAPH.keys() - {"__init__", "__main__"}, "give the new room its row in docs/architecture.md"


@pytest.mark.parametrize("room", sorted(RULES))
def test_rooms_import_what_the_page_says(room):
    assert GRAPH[room] - {"__init__"} <= RULES[room]
    order = list(RULES)
    assert all(order.index(target) < order.index(room) for target in RULES[room]), "a row names a room below it"


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_no_room_reaches_into_another(path):
    """What a module or a name with a leading underscore holds is its own room's business."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module.startswith("helimag."):
            steps = [*node.module.split(".")[1:], *(alias.name for alias in node.names)]
            hidden = [step for step in steps if step.startswith("_") and not step.startswith("__")]
            assert not hidden or steps[0] == own_room(path), f"line {node.lineno}: {hidden}"


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


@pytest.mark.parametrize("room", sorted(INSIDE))
def test_rooms_inside_a_room_import_one_way(room):
    """And a sister's parts only through what it exports, if it is a folder."""
    found = {}
    for path in (PACKAGE / room).rglob("*.py"):
        own = path.relative_to(PACKAGE / room).with_suffix("").parts[0]
        if own == "__init__":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.ImportFrom) and node.module.startswith(f"helimag.{room}")):
                continue
            sister, *deeper = node.module.split(".")[2:] or [node.names[0].name]
            if sister != own:
                found.setdefault(own, set()).add(sister)
                assert not deeper, f"{path}: import it from helimag.{room}.{sister}"
    assert found.keys() <= INSIDE[room].keys()
    for own, sisters in found.items():
        assert sisters <= INSIDE[room][own], own


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


@pytest.mark.parametrize("room", ["orbits", "design"])
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
    parameters = sections(thing).get("Parameters", "")
    documented = {n.strip() for line in parameters.splitlines() if line and line[0] != " " for n in line.split(",")}
    assert documented == set(inspect.signature(thing).parameters)


def sections(function):
    """A docstring's parts by their heads."""
    parts = re.split(r"^(\w[\w ]*)\n-+$", inspect.getdoc(function) or "", flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def gives(function):
    """Whether a function returns something, by its annotation."""
    return inspect.signature(function).return_annotation not in (None, "None", inspect.Signature.empty)


def methods(cls):
    """A class' own public methods by name, class methods too."""
    for name, member in vars(cls).items():
        function = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
        if inspect.isfunction(function) and not name.startswith("_"):
            yield name, function


def offered():
    """Functions and methods of helimag itself and of all rooms: name, function, and what it was reached by."""
    for room in ("", *sorted({*hm._ROOMS, *RULES} - {"cli"})):
        module = importlib.import_module(f"helimag.{room}" if room else "helimag")
        for name in getattr(module, "__all__", [name for name in vars(module) if not name.startswith("_")]):
            thing = getattr(module, name)
            found = methods(thing) if inspect.isclass(thing) else [("", thing)] if inspect.isfunction(thing) else []
            for inner, function in found:
                if function.__module__.startswith("helimag"):
                    yield ".".join(part for part in (room, name, inner) if part), function, thing


# results that users are given, beside what helimag itself exports
GIVEN = {"Posterior", "Findings", "Devices", "Certificate", "SlowFlow", "StabilityMap", "OrbitComparison"}
OFFERED = {label: (function, thing) for label, function, thing in offered()}


def test_what_users_call_says_what_it_returns():
    """Every function and method of helimag's own names and of results; of the rooms, each that has any section."""
    own = {id(getattr(hm, name)) for name in hm.__all__}
    silent = []
    for label, (function, thing) in OFFERED.items():
        told = sections(function)
        asked = id(thing) in own or thing.__name__ in GIVEN or told
        if asked and gives(function) and not {"Returns", "Yields"} & told.keys():
            silent.append(label)
    assert len(OFFERED) > 250
    assert {thing.__name__ for _, thing in OFFERED.values()} >= GIVEN
    assert silent == []


def test_dir_shows_all_names_and_the_rooms():
    assert sorted({*hm.__all__, *hm._ROOMS, "__version__"}) == dir(hm)
    assert set(RULES) - set(hm._ROOMS) == {
        "cli",
        "design",
        "doctor",
        "engine",
        "files",
        "notebook",
        "physics",
        "studio",
    }
    assert all(getattr(hm, name) is not None for name in dir(hm))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = hm.nothing


# What is still to be mended, by name. A list may only shrink: a test fails as well where an entry is no longer needed.
STILL_TWICE: set[str] = set()
STILL_LONG: set[str] = set()
LONGEST = 60  # lines of a function, its docstring not counted
TREES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in MODULES}


def twice(trees):
    """Names of classes that more than one file defines."""
    seen = Counter(node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    return {name for name, count in seen.items() if count > 1}


def length(function):
    """Lines of a function without its docstring."""
    first = function.body[0]
    has = ast.get_docstring(function, clean=False) is not None
    return function.end_lineno - function.lineno + 1 - (first.end_lineno - first.lineno + 1 if has else 0)


def messages(tree):
    """Texts with words in raise statements, with their lines; what is filled in reads ``X``."""
    for statement in ast.walk(tree):
        if not isinstance(statement, ast.Raise):
            continue
        nodes = list(ast.walk(statement))
        whole = [node for node in nodes if isinstance(node, ast.JoinedStr)]
        parts = {id(inner) for node in whole for inner in ast.walk(node) if inner is not node}
        for node in nodes:
            text = None
            if isinstance(node, ast.JoinedStr):
                text = "".join(v.value if isinstance(v, ast.Constant) else "X" for v in node.values)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                text = node.value
            if text is not None and id(node) not in parts and re.search(r"[a-z]{2}", text):
                yield node.lineno, text


RAGGED = re.compile(r"\s\s|\n|^\s|\s$| [,;:)](?!\S)|[,;][A-Za-z]|\.$")


def unmentioned(trees, documented):
    """Functions and classes that no other line of the package names: neither called, nor registered, nor documented."""
    words = Counter(word for tree in trees for word in re.findall(r"\w+", ast.unparse(tree)))
    for tree in trees:
        for node in ast.walk(tree):
            if not isinstance(node, (ast.FunctionDef, ast.ClassDef)) or node.name.startswith("__"):
                continue
            registered = any(isinstance(decorator, ast.Call) for decorator in node.decorator_list)
            if words[node.name] == 1 and not registered and node.name not in documented:
                yield node.name


def test_no_class_name_exists_twice():
    assert twice(TREES.values()) == STILL_TWICE


def test_functions_are_short():
    long = {
        f"{path.relative_to(PACKAGE)}: {node.name}"
        for path, tree in TREES.items()
        for node in ast.walk(tree)
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and length(node) > LONGEST
    }
    assert long == STILL_LONG


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_messages_are_not_ragged(path):
    for line, text in messages(TREES[path]):
        assert not RAGGED.search(text), f"line {line}: {text!r}"


def test_nothing_is_dead():
    pages = "\n".join(page.read_text(encoding="utf-8") for page in ROOT.glob("docs/**/*.md"))
    assert set(unmentioned(TREES.values(), set(re.findall(r"\w+", pages)))) == set()


def test_the_police_sees_what_it_looks_for():
    """Each rule on a few lines that break it, beside lines that do not."""
    one, two = ast.parse("class A: pass\nclass B: pass"), ast.parse("class A: pass")
    assert twice([one, two]) == {"A"}
    body = "\n".join(["    x = 1"] * 60)
    (fits,) = ast.parse(f'def f():\n    """What.\n\n    More.\n    """\n{body[:-10]}').body
    (over,) = ast.parse(f"def f():\n{body}").body
    assert length(fits) <= LONGEST < length(over)
    bad = ["an  x", " an", "an ", "an ; x", "an,x", "an\nx", "It ends."]
    good = ["an x must be y; got 3", "an x, y", "line 3: c", "must end in .nc or .csv"]
    tree = ast.parse("\n".join(f"raise E({text!r})" for text in bad + good) + "\nraise E(f'{a} is  {b}')")
    found = [text for _, text in messages(tree) if RAGGED.search(text)]
    assert found == [*bad, "X is  X"]
    dead = ast.parse("def used(): pass\ndef unused(): used()\n@app.command()\ndef a(): pass\ndef told(): pass")
    assert list(unmentioned([dead], {"told"})) == ["unused"]
