"""The gallery: what was typed for each picture. ``make gallery`` types it again, the page shows it.

python docs/_ext/gallery.py FOLDER [NAME...]
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from PIL import Image

WIDE = 1400  # pixels of a picture at most
MAP = """name = "gain by pitch and frequency"
base = "paper/fig3c"

[[axis]]
field = "drive.frequency"
start = "2 Hz"
stop = "4 Hz"
count = 12

[[axis]]
field = "drive.pitch"
start = "2 deg"
stop = "24 deg"
count = 16
"""


class Shown(NamedTuple):
    """A picture: its name, what it shows, the page that tells more, what is typed, the file that comes out."""

    name: str
    title: str
    page: str
    commands: tuple[str, ...]
    picture: str


SHOWN = (
    Shown(
        "run",
        "A run: where it went, how high, how it hung, whether it kept in step",
        "howto/plot.md",
        ("helimag simulate paper/fig3c -o c.nc", "helimag plot c.nc -o c.png"),
        "c.png",
    ),
    Shown(
        "map",
        "Which inputs keep it: verdicts and gains over two of them",
        "howto/sweep.md",
        ("helimag sweep map.toml -o map.zarr", "helimag plot map.zarr -o map.png"),
        "map.png",
    ),
    Shown(
        "slide",
        "The same run on a slide: 16:9, with large words",
        "howto/plot.md",
        ("helimag simulate paper/fig3c -o c.nc", "helimag plot c.nc -o slide.png --size slide"),
        "slide.png",
    ),
    Shown(
        "small",
        "The same map in a column of a paper",
        "howto/plot.md",
        ("helimag sweep map.toml -o map.zarr", "helimag plot map.zarr -o small.png --size small"),
        "small.png",
    ),
    Shown(
        "table1",
        "The paper's experiment: seven straight runs, measured and computed",
        "howto/reproduce.md",
        ("helimag reproduce table1 -o table1",),
        "table1/table1.png",
    ),
    Shown(
        "branch",
        "Orbits over an input: where they are stable, and where that ends",
        "howto/orbit.md",
        (
            'helimag orbit paper/fig3c --set drive.frequency="2.5 Hz"'
            ' --vary drive.pitch --from "4 deg" --to "24 deg" -o branch.png',
        ),
        "branch.png",
    ),
    Shown(
        "stability",
        "Stability over two inputs, with its exact boundary",
        "howto/orbit.md",
        (
            'helimag orbit map paper/fig3c --vary drive.pitch="4 deg..20 deg" --vary drive.frequency="2 Hz..3.5 Hz"'
            " --nodes 24 -o stability.png",
        ),
        "stability.png",
    ),
    Shown(
        "cell",
        "A circle under the arm: the cell, before anything moves",
        "howto/robot-programme.md",
        ("helimag robot check paper/fig3c --cell wide --set run.duration='180 s' -o circle.png",),
        "circle-cell.png",
    ),
    Shown(
        "compare",
        "Two cameras: the measured run beside the simulated one",
        "howto/track-two-cameras.md",
        (
            'helimag simulate paper/table1-row1 --duration "6 s" --interval "0.02 s" --no-orbit -o run.nc',
            "helimag vision render run.nc -o films",
            "helimag vision calibrate films/calibration.toml -o rig.json",
            "helimag vision track films/front.mp4 films/below.mp4 --rig rig.json --scenario paper/table1-row1"
            " -o measured.nc",
            "helimag compare measured.nc run.nc -o compare.png",
        ),
        "compare.png",
    ),
)


def page() -> str:
    """The gallery as MyST text for a page in ``docs/``."""
    parts = ["::::{container} gallery"]
    for shown in SHOWN:
        typed = "\n".join(f"$ {command}" for command in shown.commands)
        parts.append(
            f":::{{container}} shown\n[![{shown.title}](_static/gallery/{shown.name}.png)]({shown.page})\n\n"
            f"[{shown.title}]({shown.page})\n\n```console\n{typed}\n```\n:::"
        )
    return "\n\n".join([*parts, "::::"]) + "\n"


def draw(shown: Shown, folder: Path) -> None:
    """Type what a picture needs, in a folder of its own, and keep the picture."""
    with tempfile.TemporaryDirectory() as place:
        (Path(place) / "map.toml").write_text(MAP, encoding="utf-8")
        for command in shown.commands:
            sys.stderr.write(f"{command}\n")
            world = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
            done = subprocess.run(command, shell=True, cwd=place, env=world, stdout=subprocess.DEVNULL, check=False)
            if done.returncode:
                raise SystemExit(f"{command}: exit status {done.returncode}")
        with Image.open(Path(place) / shown.picture) as picture:
            picture.thumbnail((WIDE, WIDE), Image.Resampling.LANCZOS)
            picture.convert("RGB").save(folder / f"{shown.name}.png", optimize=True)


def main() -> None:
    """Draw the pictures named, or all."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    wanted = sys.argv[2:] or [shown.name for shown in SHOWN]
    for shown in SHOWN:
        if shown.name in wanted:
            draw(shown, folder)


if __name__ == "__main__":
    main()
