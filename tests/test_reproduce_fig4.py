"""Fig. 4 by the paper's procedure, in small: what is handed on, what is drawn, what is written."""

import json

import numpy as np
import pytest

from helimag import quantities as q
from helimag.outcomes import Verdict
from helimag.reproduce._fig4 import Fig4Input, fig4, stays, trends
from helimag.sweeps import load_sweep

INPUTS = (
    Fig4Input("drive.pitch", q.ANGLE, 8.0, 17.0, 3.0),
    Fig4Input("drive.distance", q.LENGTH, 146.0, 154.0, 4.0),
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fig4")
    seen = []
    result = fig4(folder, frequencies=(2.5, 3.0), inputs=INPUTS, fine_runs=5, progress=seen.append)
    assert seen[-1] == pytest.approx(1.0)
    return folder, result


def test_each_pass_starts_from_the_values_of_least_gain_before_it(made):
    folder, result = made
    held = {"pitch": np.radians(12.7), "distance": 0.15}
    for frequency in (2.5, 3.0):
        for name in ("pitch", "distance"):
            stores = [
                load_sweep(folder / "fig4-sweeps" / f"{frequency:g}Hz-{name}-{part}.zarr") for part in ("wide", "fine")
            ]
            other = {"pitch": "distance", "distance": "pitch"}[name]
            for store in stores:
                assert float(store["frequency"]) == frequency
                assert float(store[other]) == pytest.approx(held[other], rel=1e-12)
            values, gain, flags = (
                np.concatenate([store[key].values for store in stores]) for key in (name, "gain", "verdict")
            )
            gain = np.where(stays(gain, flags), gain, np.inf)
            assert np.isfinite(gain.min())
            held[name] = values[gain.argmin()]
            (row,) = [row for row in result.rows if row["frequency_hz"] == frequency and row["input"] == name]
            assert row["best"] == held[name]
            assert row["least_gain"] == gain.min()


def test_the_fine_pass_lies_around_the_bounded_set(made):
    folder, _ = made
    wide, fine = (load_sweep(folder / "fig4-sweeps" / f"2.5Hz-pitch-{part}.zarr") for part in ("wide", "fine"))
    inside = wide["pitch"].values[stays(wide["gain"].values, wide["verdict"].values)]
    step = np.radians(3.0)
    low, high = max(inside.min() - step, np.radians(8.0)), min(inside.max() + step, np.radians(17.0))
    assert (fine["pitch"].values[0], fine["pitch"].values[-1]) == pytest.approx((low, high), rel=1e-9)
    assert fine.sizes["pitch"] == 5


def test_figure_table_and_rows_are_written_and_a_second_call_finds_all_runs_done(made, monkeypatch):
    folder, result = made
    for suffix in ("png", "svg", "pdf", "csv"):
        assert (folder / f"fig4.{suffix}").stat().st_size > 500
    found = json.loads((folder / "fig4.json").read_text(encoding="utf-8"))
    assert found == {"panels": result.rows, "trends": result.trends}
    monkeypatch.setattr("helimag.sweeps.engines.compute", lambda *_: pytest.fail("computed again"))
    again = fig4(folder, frequencies=(2.5, 3.0), inputs=INPUTS, fine_runs=5)
    assert again.rows == result.rows


def test_trends_are_read_from_the_rows():
    def row(frequency, name, high, extent, low, gain):
        names = ("frequency_hz", "input", "bounded_to", "bounded_extent", "bounded_from", "least_gain")
        return dict(zip(names, (frequency, name, high, extent, low, gain), strict=True))

    rows = [row(2.0, "pitch", 0.3, 0.2, 0.1, 0.20), row(3.0, "pitch", 0.2, 0.2, 0.1, 0.25)]
    rows += [row(2.0, "yaw_rate", 1, 1, 0.02, 0.2), row(3.0, "yaw_rate", 1, 1, None, 0.3)]
    holds = {trend["published"].partition(" (")[0]: trend["holds"] for trend in trends(rows)}
    assert holds == {
        "the bounded pitch falls": True,
        "the bounded range of pitch narrows": False,
        "the least gain rises": True,
        "the least bounded yaw rate rises": False,
    }


def test_bounded_is_what_the_paper_calls_so():
    flags = np.array([verdict.flag for verdict in Verdict])
    inside = {
        str(verdict) for verdict, kept in zip(Verdict, stays(np.full(flags.size, 0.9), flags), strict=True) if kept
    }
    assert inside == {"bounded", "drifting", "undecided"}
    assert not stays(np.full(flags.size, 1.1), flags).any()


def test_a_trend_is_told_by_ranks_and_one_small_step_back_does_not_break_it():
    def rows(numbers):
        keys = ("frequency_hz", "input", "bounded_to", "bounded_extent", "least_gain")
        return [dict(zip(keys, (f, "pitch", x, x, 0.1), strict=True)) for f, x in enumerate(numbers, 2)]

    def told(numbers):
        return next(trend for trend in trends(rows(numbers)) if trend["published"].startswith("the bounded pitch"))

    wavy = told([6.0, 5.0, 3.0, 4.0, 2.0, 1.0])
    assert (wavy["holds"], wavy["at_every_step"]) == (True, False)
    assert wavy["rank_correlation"] == pytest.approx(1.0 - 6.0 * 2.0 / (6.0 * 35.0) - 2.0 + 12.0 * 2.0 / (6.0 * 35.0))
    assert not told([1.0, 5.0, 3.0, 4.0, 2.0, 1.5])["holds"]
    assert not told([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])["holds"]
