"""Boxes of inputs in a row: what they make up, that there is no gap, and that nothing else is let through."""

import copy
import json
import time
from dataclasses import replace
from fractions import Fraction

import pytest

pytest.importorskip("flint")

import proof_cells
from helimag.errors import InputError
from helimag.proof import Row, check_file, check_row, growing, grown, read_any, read_row, row_sentence
from helimag.proof import row as rows
from helimag.proof.sealing import digest, sealed
from proof_cells import CLAIMS, WITHIN, cell


@pytest.fixture
def row() -> Row:
    """Three cells of 4 thousandths of a degree to each side, that overlap by a thousandth or touch; one is narrower."""
    narrow = WITHIN | {"drive.frequency": "3e-04"}
    return Row("drive.pitch", (cell("12.693"), cell("12.7", narrow, bound=0.99999), cell("12.708", clearance=0.13)))


def test_the_box_is_what_the_cells_make_up(row: Row) -> None:
    """In rational numbers, from the decimals: along the row from end to end, across it what all have in common."""
    assert row.box == {
        "drive.frequency": (Fraction("2.4997"), Fraction("2.5003")),
        "drive.pitch": (Fraction("12.689"), Fraction("12.712")),
    }
    assert row.content()["box"] == {"drive.frequency": ["2.4997", "2.5003"], "drive.pitch": ["12.689", "12.712"]}
    assert row.bound == 0.99999
    assert row.clearance == 0.13


def test_a_row_comes_back(row: Row, tmp_path) -> None:
    row.save(tmp_path / "row.json")
    text = (tmp_path / "row.json").read_text(encoding="utf-8")
    again = read_row(text)
    assert isinstance(read_any(text), Row)
    assert again.text() == text == row.text()
    assert again.hash == row.hash
    assert again.cells[1].claims == row.cells[1].claims
    assert [path.name for path in tmp_path.iterdir()] == ["row.json"]


def test_the_sentence_says_the_box_and_what_holds_in_all_of_it(row: Row) -> None:
    words = row_sentence(row)
    assert "drive.pitch from 12.689 to 12.712 deg" in words
    assert "drive.frequency from 2.4997 to 2.5003 Hz" in words
    assert "by at most 0.999990" in words or "by at most 0.999991" in words
    assert "at least 130 mm" in words
    assert "3 cells" in words


def moved(row: Row, n: int, pitch: str) -> Row:
    return replace(row, cells=(*row.cells[:n], cell(pitch), *row.cells[n + 1 :]))


REFUSED = {
    "a gap": (lambda row: moved(row, 2, "12.7081"), "without a gap"),
    "one inside another": (
        lambda row: replace(row, cells=(row.cells[0], cell("12.693", WITHIN | {"drive.pitch": "3e-3"}))),
        "ascending",
    ),
    "the other way round": (lambda row: replace(row, cells=row.cells[::-1]), "ascending"),
    "a cell twice": (lambda row: replace(row, cells=(row.cells[0], *row.cells)), "ascending"),
    "no cells": (lambda row: replace(row, cells=()), "no cells"),
    "an input without tolerance": (lambda row: replace(row, along="drive.distance"), "same inputs"),
    "other inputs in one": (
        lambda row: replace(row, cells=(*row.cells[:2], cell("12.708", {"drive.pitch": "4e-3"}))),
        "same inputs",
    ),
    "another weight in one": (
        lambda row: replace(
            row,
            cells=(
                *row.cells[:2],
                replace(row.cells[2], scenario=row.cells[2].scenario.replaced({"device.weight.net_weight": "28.3 uN"})),
            ),
        ),
        "differ in drive.pitch",
    ),
    "another frequency in one": (
        lambda row: replace(
            row,
            cells=(
                *row.cells[:2],
                replace(row.cells[2], scenario=row.cells[2].scenario.replaced({"drive.frequency": "2.5001 Hz"})),
            ),
        ),
        "differ in drive.pitch",
    ),
    "a width that takes for ever to read": (
        lambda row: replace(row, cells=(cell("12.693", WITHIN | {"drive.pitch": "1e+999999999"}), *row.cells[1:])),
        "tolerance",
    ),
    "a width of more digits than Python reads": (
        lambda row: replace(row, cells=(cell("12.693", WITHIN | {"drive.pitch": "1" * 5000}), *row.cells[1:])),
        "tolerance",
    ),
    "a width that is none": (
        lambda row: replace(row, cells=(cell("12.693", WITHIN | {"drive.pitch": "1/0"}), *row.cells[1:])),
        "tolerance",
    ),
    "a tolerance that nothing sees": (
        lambda row: replace(
            row, cells=tuple(replace(each, within={**each.within, "magnet.radius": "1"}) for each in row.cells)
        ),
        "tolerance",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_cells_that_make_up_no_box_are_refused(row: Row, name: str, monkeypatch) -> None:
    """Before any cell is enclosed, and in one line; also as a text whose maker knows how the hash is made."""
    monkeypatch.setattr(rows, "check", lambda *_, **__: pytest.fail("nothing is to be enclosed"))
    change, told = REFUSED[name]
    forged, begun = change(row), time.perf_counter()
    with pytest.raises(InputError, match=told):
        check_row(forged)
    content = row.content() | {"along": forged.along, "cells": [each.content() for each in forged.cells]}
    with pytest.raises(InputError):
        read_row(sealed(content))
    assert time.perf_counter() - begun < 5.0


def test_any_one_field_changed_is_refused(row: Row) -> None:
    """Every field, of the thousands of numbers that functions are made of some of each: the hash is another one."""
    content = row.content()
    recorded = row.hash
    paths = [path for n, path in enumerate(_leaves(content)) if len(path) < 6 or path[2] != "tube" or n % 97 == 0]
    assert {path[:4] for path in paths} == {path[:4] for path in _leaves(content) if path[2:3] != ("tube",)} | {
        path[:4] for path in paths if path[2:3] == ("tube",)
    }
    for path in paths:
        before = _put(content, path)
        assert digest(content) != recorded, path
        _put(content, path, before)
    assert digest(content) == recorded
    forged = content | {"along": "drive.frequency"}
    with pytest.raises(InputError, match="changed"):
        read_row(json.dumps(forged | {"sha256": recorded}))


def test_a_field_of_the_row_changed_with_the_hash_made_anew_is_refused(row: Row, monkeypatch) -> None:
    """What the cells do not say of themselves, and what each of them claims: that is compared with what is proved."""
    content = row.content()
    own = [path for path in _leaves(content) if path[0] != "cells"]
    assert {path[0] for path in own} == {"format", "along", "box"}
    for path in own:
        forged = copy.deepcopy(content)
        _put(forged, path)
        with pytest.raises(InputError):
            read_any(sealed(forged))
    for forged in (content | {"more": 1}, {key: value for key, value in content.items() if key != "box"}):
        with pytest.raises(InputError):
            read_row(sealed(forged))
    # what a check of each cell finds, were it enclosed
    proved = {each.content()["scenario"]: each.claims for each in row.cells}
    monkeypatch.setattr("helimag.proof.certificate.claims_of", lambda about, *_, **__: proved[about.to_toml()])
    assert check_row(read_row(row.text())).text() == row.text()
    for path in _leaves(content["cells"][1]["claims"]):
        forged = copy.deepcopy(content)
        _put(forged, ("cells", 1, "claims", *path))
        with pytest.raises(InputError):
            check_row(read_row(sealed(forged)))


def _leaves(value, path=()):
    if isinstance(value, (dict, list)):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _leaves(each, (*path, key))
    else:
        yield path


def _put(content, path, new=None):
    """Change one field, or give it this value; what it was before."""
    for key in path[:-1]:
        content = content[key]
    old = content[path[-1]]
    content[path[-1]] = _other(old) if new is None else new
    return old


def _other(old):
    if isinstance(old, bool):
        return not old
    if isinstance(old, (int, float)):
        return old + 1
    digit = next((i for i, letter in enumerate(old) if letter.isdigit()), None)
    return old + "x" if digit is None else old[:digit] + str((int(old[digit]) + 1) % 10) + old[digit + 1 :]


def test_every_cell_is_proved_again(row: Row, monkeypatch, tmp_path) -> None:
    asked, heard = [], []

    def check(certificate, *, progress):
        asked.append(certificate)
        progress(0.5)
        return certificate.claims

    monkeypatch.setattr(rows, "check", check)
    row.save(tmp_path / "row.json")
    found = check_file(tmp_path / "row.json", progress=heard.append)
    assert [each.hash for each in asked] == [each.hash for each in row.cells]
    assert found.text() == row.text()
    assert heard == pytest.approx([1 / 6, 3 / 6, 5 / 6])
    with pytest.raises(InputError, match="cell 2 is not"):
        check_row(replace(row, cells=(row.cells[0], replace(row.cells[1], claims=replace(CLAIMS, stability=False)))))


@pytest.mark.parametrize("begin", [None, '{"format": "helimag proof row 2", "sha256": 1}', "[]", "", '{"format": []}'])
def test_what_is_no_row_is_refused(begin) -> None:
    with pytest.raises(InputError):
        read_any(begin or proof_cells.cell("12.7").text().replace("helimag proof 4", "helimag proof row 1"))


# ------------------------------------------------------------------------------------------------------ how it grows


def stand_in(monkeypatch, holds) -> list[float]:
    """Let a cell be proved where ``holds`` says so of its pitch and half width (deg); the widths that were tried."""
    tried = []
    monkeypatch.setattr(growing, "now", lambda: float(len(tried)))  # a cell that is tried takes a second

    def proved_within(scenario, widths, shape, progress):
        pitch = round(scenario.drive.pitch * 180.0 / 3.141592653589793, 9)
        tried.append(float(widths["drive.pitch"]))
        progress(0.5)
        found = replace(cell("12.7"), scenario=scenario, within=widths, tube=shape)
        return found if holds(pitch, tried[-1]) else None

    monkeypatch.setattr(growing, "_tube_around", lambda _scenario, like, _widths: like)
    monkeypatch.setattr(growing, "proved_within", proved_within)
    return tried


def test_a_row_grows_to_both_sides_until_its_time_is_over(monkeypatch) -> None:
    """Side by side without a gap, whatever the decimals; and each time there is more, it is kept."""
    stand_in(monkeypatch, lambda *_: True)
    kept, heard = [], []
    row = grown(cell("12.7"), "drive.pitch", seconds=5.2, progress=heard.append, keep=kept.append)
    rows.require_row(row)
    low, high = row.box["drive.pitch"]
    assert len(row.cells) == 1 + 5
    assert sum(each.scenario.drive.pitch > cell("12.7").scenario.drive.pitch for each in row.cells) == 3
    assert float(high - low) == pytest.approx(8e-3 * len(row.cells), rel=1e-2)
    assert row.box["drive.frequency"] == (Fraction("2.4995"), Fraction("2.5005"))
    assert [len(each.cells) for each in kept] == list(range(2, len(row.cells) + 1))
    assert heard == sorted(heard)
    assert 0.0 <= heard[0] <= heard[-1] <= 1.0


def test_a_row_ends_where_no_cell_is_proved(monkeypatch) -> None:
    """Narrower cells are tried before a side is given up; the other side goes on."""
    tried = stand_in(monkeypatch, lambda pitch, width: 12.68 < pitch < 12.71 and (pitch > 12.69 or width < 3.5e-3))
    row = grown(cell("12.7"), "drive.pitch", seconds=60.0)
    rows.require_row(row)
    ends = [float(each) for each in row.box["drive.pitch"]]
    assert 12.67 < ends[0] < 12.69
    assert 12.71 < ends[1] < 12.718
    assert min(tried) < 0.65 * 4e-3


def test_no_time_is_one_cell(monkeypatch) -> None:
    stand_in(monkeypatch, lambda *_: pytest.fail("no cell is to be begun"))
    assert len(grown(cell("12.7"), "drive.pitch", seconds=0.0).cells) == 1


def test_a_row_is_along_an_input_with_tolerance() -> None:
    with pytest.raises(InputError, match=r"drive\.frequency, drive\.pitch"):
        grown(cell("12.7"), "drive.distance", seconds=1.0)
