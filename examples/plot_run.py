"""Draw a run, write figure and film, and check that what was written is what was meant."""

import tempfile
from pathlib import Path

import av
import numpy as np
from matplotlib.image import imread

import helimag as hm
from helimag import plots

run = hm.simulate(hm.load("paper/fig3c"), duration="300 s")
figure = plots.draw_run(run)

with tempfile.TemporaryDirectory() as folder:
    picture, drawing, film = (Path(folder) / f"fig3c.{suffix}" for suffix in ("png", "pdf", "mp4"))
    plots.save(figure, picture)
    plots.save(figure, drawing)
    plots.animate(run, film)
    dots = imread(picture)
    with av.open(str(film)) as opened:
        frames = sum(1 for _ in opened.decode(video=0))
        seconds = opened.duration / av.time_base
    left = sorted(path.name for path in Path(folder).iterdir())

# 180 mm wide at 300 dots an inch, and neither blank nor full
assert abs(dots.shape[1] - 180.0 / 25.4 * 300.0) <= 1.0, dots.shape
ink = float(np.mean(dots[:, :, :3].min(axis=2) < 0.9))
assert 0.005 < ink < 0.5, ink
# 12 s at 25 frames a second, whatever the run's length
assert frames == 300
assert abs(seconds - 12.0) < 0.1, seconds
# nothing half-written beside them
assert left == ["fig3c.mp4", "fig3c.pdf", "fig3c.png"]
