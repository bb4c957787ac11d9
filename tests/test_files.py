"""One reader of TOML: whatever the text, a dictionary or one clear refusal. One writer of CSV."""

import csv
import io
import os
import sys
import threading

import pytest

from helimag import files
from helimag.errors import FileError, InputError
from helimag.files import bytes_of, csv_text, text_of, toml_tables


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


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of Unix")
@pytest.mark.parametrize(("many", "whole"), [(1000, True), (1001, False)])
def test_a_pipe_is_read_to_its_end_if_it_has_one(tmp_path, monkeypatch, many, whole):
    """As a shell gives for <(command); what gives more than any file of ours has is refused."""
    monkeypatch.setattr(files, "MOST_PIPED", 1000)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(b"x" * many,), daemon=True)
    writer.start()
    if whole:
        assert bytes_of(pipe) == b"x" * many
    else:
        with pytest.raises(FileError, match="a pipe that gives more than"):
            bytes_of(pipe)
    writer.join(60.0)
    assert not writer.is_alive()


@pytest.mark.skipif(sys.platform == "win32", reason="devices of Unix")
@pytest.mark.parametrize("device", ["/dev/zero", "/dev/null", "/dev/full"])
def test_a_device_is_no_file(device):
    with pytest.raises(FileError, match=f"^{device} cannot be read: it is a device, and no file$"):
        text_of(device)
