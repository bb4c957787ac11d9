"""The check of a certificate stands by itself: nothing that searches for tubes has a part in it."""

import ast
from pathlib import Path

import helimag

PROOF = Path(helimag.__file__).parent / "proof"
SEARCH = {"guess", "bending", "extent", "sampling", "proving", "tolerance", "growing"}


def imported(module: str) -> set[str]:
    """Modules of the room that one imports, anywhere in it."""
    tree = ast.parse((PROOF / f"{module}.py").read_text(encoding="utf-8"))
    froms = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    names = [node.module for node in froms]
    names += [f"{node.module}.{alias.name}" for node in froms if node.module == "helimag.proof" for alias in node.names]
    names += [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    return {name.removeprefix("helimag.proof.") for name in names if name and name.startswith("helimag.proof.")}


def test_the_check_imports_nothing_of_the_search() -> None:
    needed, new = set(), {"certificate", "row"}
    while new:
        needed |= new
        new = set().union(*(imported(each) for each in new)) - needed
    assert {"theorem", "bounds", "field", "tube", "clearance", "exact", "motion"} <= needed
    assert not needed & SEARCH
    assert {path.stem for path in PROOF.glob("*.py")} - needed - SEARCH == {"__init__", "carrying"}
