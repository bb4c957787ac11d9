"""Sphinx configuration. Builds without a network, and pages ask no other host for anything: MathJax comes with them."""

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

import generated  # from the folder just named
import geometry

project = "helimag"
author = "The helimag developers"
copyright = f"2026, {author}"
release = generated.release()

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
]
exclude_patterns = ["_build", "_ext", "reference/generated"]

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_dmath_double_inline = True
myst_heading_anchors = 4

napoleon_google_docstring = False
napoleon_numpy_docstring = True
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_typehints_format = "short"

html_theme = "furo"
html_title = "helimag"
html_static_path = ["_static"]
html_css_files = ["wide.css"]


def without_model_signature(_app: object, what: str, _name: str, thing: Any, *_rest: object) -> tuple[str, None] | None:
    """A scenario model's keys are in a table of their own; its signature would list pydantic's validators."""
    return ("", None) if what == "class" and generated.is_model(thing) else None


def setup(app: Any) -> None:
    generated.unwrap_warp()
    folder = Path(__file__).parent / "reference" / "generated"
    generated.write(folder)
    geometry.draw(folder / "geometry.svg")
    app.connect("autodoc-process-signature", without_model_signature)
