"""Fig. 3 of the paper: the computed runs do what the published ones do, within the differences that are stated."""

import csv
import json

import numpy as np
import pytest

from helimag.engine import advance
from helimag.ensembles import Perturbation
from helimag.errors import FileError, InputError
from helimag.outcomes import End
from helimag.reproduce import fig3
from helimag.reproduce._table import DISPLACEMENT
from helimag.runs.gain import Heights, gain_until
from helimag.runs.trajectory import Trajectory
from helimag.scenario import load

PERTURBED = 10  # enough for a majority; the command runs 32


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("paper") / "made" / "fig3"


@pytest.fixture(scope="module")
def result(folder):
    done = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("helimag.reproduce._fig3.PERTURBED", PERTURBED)
        result = fig3(folder, progress=done.append)
    assert done == sorted(done)
    assert done[-1] == 1.0
    return result


@pytest.fixture(scope="module")
def rows(result):
    return {(row["run"].removeprefix("paper/fig3"), row["quantity"]): row for row in result.comparison}


def test_published_values_are_the_papers(rows):
    published = {key: row["published"] for key, row in rows.items()}
    assert published == {
        ("a", "verdict"): "attracted",
        ("a", "escape time"): 1300.0,
        ("a", "gain at 1400 s"): 1.247,
        ("b", "verdict"): "fell",
        ("b", "escape time"): 650.0,
        ("b", "gain at 700 s"): 0.914,
        ("c", "verdict"): "bounded",
        ("c", "gain at 1800 s"): 0.252,
    }
    assert all("section II-B" in row["source"] for row in rows.values())


def test_all_three_cases_are_as_published_and_so_is_every_perturbed_run(result, rows):
    """The paper: A attracted at about 1300 s, B falls with a gain of 0.914 at 700 s, C on an orbit with 0.252."""
    a, b, c = result.rows
    assert [case["case"] for case in result.rows] == ["A", "B", "C"]
    assert [case["verdict"] for case in result.rows] == ["attracted", "fell", "bounded"]
    assert a["escape_time_s"] == pytest.approx(1300.0, rel=0.05)
    assert b["gain_700_s"] == pytest.approx(0.914, rel=0.10)
    assert c["gain"] == pytest.approx(0.252, rel=0.15)
    assert c["orbit_stable"] is True
    assert a["orbit_stable"] is b["orbit_stable"] is None
    assert c["outlook"] == "coming to a stable orbit"
    for case in result.rows:
        assert case["perturbed_with_the_same_verdict"] == case["perturbed"] == PERTURBED
    assert [case["leads"] for case in result.rows] == ["helix", "head", "helix"]
    assert rows["a", "verdict"]["perturbed"] == f"{PERTURBED} of {PERTURBED} attracted"
    assert "touches the magnet" in rows["a", "gain at 1400 s"]["remark"]
    assert "Not the same event" in rows["b", "escape time"]["remark"]


def test_rows_and_comparison_are_of_the_same_runs(result, rows, folder):
    for case, name in zip(result.rows, "abc", strict=True):
        run = Trajectory.load(folder / f"fig3{name}.nc")
        assert run.gain == pytest.approx(case["gain"], rel=1e-12)
        assert rows[name, "verdict"]["computed"] == case["verdict"]
    assert rows["c", "gain at 1800 s"]["computed"] == pytest.approx(result.rows[2]["gain"])


def test_differences_are_computed_less_published(rows):
    for row in rows.values():
        if isinstance(row["published"], str):
            assert row["difference"] == ("none" if row["computed"] == row["published"] else "differs")
        else:
            assert row["difference"] == pytest.approx(row["computed"] - row["published"])


def test_perturbed_runs_are_apart_but_near(rows):
    escape = rows["a", "escape time"]
    assert 0.5 < escape["perturbed_q95"] - escape["perturbed_q05"] < 60.0


def test_files_are_whole_and_all(result, folder):
    names = {path.name for path in folder.iterdir()}
    assert names == {"fig3.png", "fig3.svg", "fig3.pdf", "fig3.csv", "fig3.json", "fig3a.nc", "fig3b.nc", "fig3c.nc"}
    assert {path.name for path in result.files} == names
    assert (folder / "fig3.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "fig3.svg").read_text().rstrip().endswith("</svg>")
    assert (folder / "fig3.pdf").read_bytes().rstrip().endswith(b"%%EOF")
    assert json.loads((folder / "fig3.json").read_text()) == {"rows": result.rows, "comparison": result.comparison}
    with (folder / "fig3.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [float(row["published"]) for row in table if row["quantity"] != "verdict"] == [
        row["published"] for row in result.comparison if row["quantity"] != "verdict"
    ]


def test_text_shows_both_values_and_every_remark(result):
    words = " ".join(result.text.split())
    for row in result.comparison:
        assert " ".join(row["remark"].split()) in words
        if not isinstance(row["published"], str) and not row["unit"]:
            assert f"{row['published']:.3f}" in words
            assert f"{row['computed']:.3f}" in words
    assert "fitted" in words


def test_a_file_in_the_folders_place_is_refused(tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(FileError, match="is a file; name a folder"):
        fig3(tmp_path / "out")


def test_displacements_are_those_stated():
    start = load("paper/fig3b").drive.start
    copies = Perturbation(displacement=DISPLACEMENT).copies(load("paper/fig3b"), 20000, np.random.default_rng(1))
    np.testing.assert_allclose(copies.states[:, :3].mean(axis=0), start, atol=1.5e-6)
    np.testing.assert_allclose(copies.states[:, :3].std(axis=0), 50e-6, rtol=0.03)
    np.testing.assert_array_equal(copies.states[:, 3:], np.tile([0.0, 0.0, 1.0, 0.0], (20000, 1)))


def heights(low, high):
    count = len(low)
    return Heights(
        time=np.arange(float(count)),
        low=np.array(low),
        high=np.array(high),
        mean=np.zeros(count),
        attack=np.zeros(count),
        attack_square=np.zeros(count),
        slips=0,
        initial_gap=0.1,
        end=End.HORIZON,
    )


def test_gain_until_a_time_counts_samples_up_to_it():
    run = heights([0.0, -0.02, -0.01, -0.05], [0.0, 0.01, 0.03, 0.0])
    assert gain_until(run, 0.0) == 0.0
    assert gain_until(run, 1.5) == pytest.approx(0.3)
    assert gain_until(run, 2.0) == pytest.approx(0.5)
    assert gain_until(run, 100.0) == pytest.approx(0.8)
    with pytest.raises(InputError, match="before the first sample at 0 s; got -1 s"):
        gain_until(run, -1.0)


def test_gain_until_the_end_is_the_gain():
    history = advance([load("paper/fig3c").replaced({"run.duration": 50.0})])[0]
    assert gain_until(history.heights, 50.0) == history.judge().gain
