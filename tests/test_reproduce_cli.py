"""`helimag reproduce`: files only where they are asked for, and where they went."""

import json

import pytest

from command_line import run


@pytest.fixture(autouse=True)
def few_perturbed(monkeypatch, tmp_path):
    monkeypatch.setattr("helimag.reproduce._straight.PERTURBED", 1)
    monkeypatch.chdir(tmp_path)


def test_without_a_folder_nothing_is_kept(tmp_path):
    said = run("reproduce", "table1", "--json")
    report = json.loads(said.out)
    assert said.status == 0
    assert [row["row"] for row in report["rows"]] == list(range(1, 8))
    assert report["files"] == []
    assert list(tmp_path.iterdir()) == []


def test_with_a_folder_the_last_lines_say_where_the_figure_and_all_else_is(tmp_path):
    said = run("reproduce", "fig5", "-o", "out")
    assert said.status == 0
    named = [line.removeprefix("  written to    ") for line in said.out.splitlines() if line.startswith("  written to")]
    assert named[0] == "out/fig5.png"
    assert {tmp_path / name for name in named} == set((tmp_path / "out").iterdir())


def test_sweeps_that_take_minutes_are_never_thrown_away(tmp_path):
    said = run("reproduce", "fig4")
    assert (said.status, said.out) == (2, "")
    assert "--output must name a folder" in said.err
    assert list(tmp_path.iterdir()) == []
