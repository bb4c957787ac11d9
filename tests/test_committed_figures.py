"""Pictures that are committed are made by a command, and the nightly tests say which of them are stale."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS / "_ext"))
import gallery  # noqa: E402

GALLERY = {f"_static/gallery/{shown.name}.png": shown for shown in gallery.SHOWN}
OTHERS = {
    "_static/fig3.png": "helimag reproduce fig3 -o out",
    **{
        f"theory/figures/{name}.png": "python benchmarks/orbit_figures.py"
        for name in ("basin", "branch", "flow", "stability")
    },
    "theory/figures/peers.png": "python benchmarks/peers/figure.py docs/theory/figures/peers.png",
    "theory/figures/why-it-stays.png": "python benchmarks/why_it_stays.py docs/theory/figures/why-it-stays.png",
    **{f"_static/studio{name}.png": "make pictures" for name in ("", "-1920x1080", "-820x1180", "-ensemble", "-map")},
}
OFF = 0.004  # of full scale, in the mean over the pixels: fonts and libraries differ by less


def test_every_committed_picture_has_its_command():
    committed = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.png") if "_build" not in path.parts}
    assert committed == GALLERY.keys() | OTHERS.keys()


def off(one: Path, other: Path) -> float:
    """How far two pictures are apart, in the mean over the pixels; 1 where their sizes differ."""
    with Image.open(one) as a, Image.open(other) as b:
        if a.size != b.size:
            return 1.0
        first, second = (np.asarray(each.convert("L"), dtype=float) / 255.0 for each in (a, b))
    return float(np.abs(first - second).mean())


@pytest.mark.nightly
@pytest.mark.parametrize("name", GALLERY)
def test_the_gallery_is_what_its_commands_make(name, tmp_path):
    gallery.draw(GALLERY[name], tmp_path)
    assert off(tmp_path / Path(name).name, DOCS / name) < OFF, "stale: make gallery, and look at it"


@pytest.mark.nightly
def test_the_figure_of_the_readme_is_what_its_command_makes(tmp_path):
    words = [sys.executable, "-m", "helimag", "reproduce", "fig3", "-o", str(tmp_path), "--quiet"]
    subprocess.run(words, check=True)
    assert off(tmp_path / "fig3.png", DOCS / "_static" / "fig3.png") < OFF, "stale: " + OTHERS["_static/fig3.png"]


def test_a_stale_picture_is_seen(tmp_path):
    """A line that moves, a title that is new, another size: each is more than fonts and libraries do."""
    from matplotlib.figure import Figure

    def drawn(name, high, title, width=6.0):
        figure = Figure(figsize=(width, 4.0))
        figure.subplots().plot([0.0, 1.0], [0.0, high])
        figure.suptitle(title)
        figure.savefig(tmp_path / name)
        return tmp_path / name

    made = drawn("a.png", 1.0, "one")
    assert off(made, drawn("b.png", 1.0, "one")) == 0.0
    assert off(made, drawn("c.png", 1.0, "one", width=6.1)) == 1.0
    assert off(made, drawn("d.png", -1.0, "another title")) > OFF
