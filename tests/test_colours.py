"""Colours on the pixels of a figure, as eyes see them that lack a kind of cone.

The oracle is apart from the code: the matrices of Machado, Oliveira and Fernandes, IEEE Trans. Vis. Comput. Graph. 15
(2009) 1291, for eyes without one kind of cone, and CIE 1976 colour differences; a just noticeable one is 2.3.
"""

from itertools import combinations

import numpy as np
import pytest
import xarray
from matplotlib.backends.backend_agg import FigureCanvasAgg

import helimag as hm
from helimag.outcomes import Verdict
from helimag.plots import draw_sweep
from helimag.sweeps import Axis

EYES = {
    "all cones": np.eye(3),
    "no L": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no M": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "no S": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
WHITE = np.array([0.95047, 1.0, 1.08883])
APART = 15.0  # six times what can just be told


def seen(pixel, eyes):
    """CIE L*a*b* of an sRGB pixel."""
    share = np.asarray(pixel) / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    x = TO_XYZ @ np.clip(np.asarray(EYES[eyes]) @ linear, 0.0, 1.0) / WHITE
    root = np.where(x > 216 / 24389, np.cbrt(x), (24389 / 27 * x + 16) / 116)
    return np.array([116 * root[1] - 16, 500 * (root[0] - root[1]), 200 * (root[1] - root[2])])


@pytest.fixture(scope="module")
def pixels(tmp_path_factory) -> dict[str, np.ndarray]:
    """Of a map with a row of cells of each verdict, a pixel in the middle of each."""
    shown = [verdict for verdict in Verdict if verdict != Verdict.NOT_COMPUTED]
    pitch = Axis(field="drive.pitch", start="1 deg", stop=f"{len(shown)} deg", count=len(shown))
    frequency = Axis(field="drive.frequency", values=("2 Hz", "3 Hz"))
    plan = hm.Plan(base="nose-first/fig3c", duration="0.2 s", samples=20, axis=(frequency, pitch))
    data: xarray.Dataset = hm.sweep(plan, out=tmp_path_factory.mktemp("colours") / "s.zarr").load()
    data["verdict"].values[:] = [verdict.flag for verdict in shown]
    figure = draw_sweep(data)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    picture = np.asarray(canvas.buffer_rgba())[::-1, :, :3]
    (axes,) = figure.axes
    found = {}
    for row, verdict in enumerate(shown):
        x, y = axes.transData.transform((2.2, 1.0 + row)).astype(int)
        found[str(verdict)] = picture[y, x]
    return found


@pytest.mark.parametrize("eyes", EYES)
def test_verdicts_are_told_apart_by_all_eyes(pixels, eyes):
    pairs = {
        (a, b): float(np.linalg.norm(seen(pixels[a], eyes) - seen(pixels[b], eyes))) for a, b in combinations(pixels, 2)
    }
    assert len(pairs) >= 21
    assert {pair: off for pair, off in pairs.items() if off < APART} == {}
