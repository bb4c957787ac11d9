"""One reader of TOML: whatever the text, a dictionary or one clear refusal. One writer of CSV."""

import csv
import io

import pytest

from helimag.errors import InputError
from helimag.files import csv_text, toml_tables


def test_tables_are_read():
    assert toml_tables('a = 1\n[b]\nc = "x"', "it") == {"a": 1, "b": {"c": "x"}}


@pytest.mark.parametrize("text", ["a =", "a = " + "[" * 5000, "a = " + "1" * 5000])
def test_what_is_not_toml_is_refused_by_name(text):
    with pytest.raises(InputError, match=r"it .*TOML"):
        toml_tables(text, "it")


def test_text_that_a_spreadsheet_would_carry_out_is_text():
    """Formulas get an apostrophe in front, numbers of either sign stay numbers, and all else is as it was."""
    formulas = ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "\uff1d1"]
    rows = list(csv.reader(io.StringIO(csv_text([formulas, [-1.5, +2, None, "a-b", 'say "=1"', "a,b"]]))))
    assert rows[0] == ["'" + cell.replace("\r", " ") for cell in formulas]
    assert rows[1] == ["-1.5", "2", "", "a-b", 'say "=1"', "a,b"]
