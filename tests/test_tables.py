"""CSV tables of logs and tracks: what is read, whatever it is written with, and what is refused, with its line."""

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from helimag import quantities as q
from helimag.errors import FileError, InputError
from helimag.robot import load_cell
from helimag.robot.logs import read_log, unwrapped
from helimag.runs import import_track, read_table

TABLES = Path(__file__).parent / "data" / "tables"
KINDS = {"time": q.TIME, "x": q.LENGTH, "x_sd": q.LENGTH, "pitch": q.ANGLE}
PLAIN = "time [s],x [mm]\n0,1.5\n1,2.5\n"


def read(path, text, *, encoding="utf-8", needed=("time", "x"), gaps=()):
    path.write_bytes(text.encode(encoding))
    return read_table(path, KINDS, needed=needed, gaps=gaps)


@pytest.mark.parametrize("name", ["log-case", "log-paren", "log-semicolon-comma", "log-upper"])
def test_logs_are_read_by_one_rule(name):
    log = read_log(TABLES / f"{name}.csv", load_cell())
    assert log.time == pytest.approx(0.012 * np.arange(12), abs=1e-15)
    expected = np.stack([0.825e-3 * log.time, np.zeros(12), np.full(12, 0.102)], axis=1)
    assert log.tool[:, :3, 3] == pytest.approx(expected, abs=1e-9)
    axis = [math.cos(math.radians(13.0)), 0.0, math.sin(math.radians(13.0))]  # B = -13 deg turns x upwards
    assert log.tool[:, :3, 0] == pytest.approx(np.tile(axis, (12, 1)), abs=1e-12)


def test_a_track_with_semicolons_and_decimal_commas():
    run = import_track(TABLES / "trk-semicolon.csv", initial_gap=0.102)
    time = run.dataset["time"].values
    assert time[-1] == pytest.approx(59 / 30.0, abs=1e-5)
    drift = np.stack([0.8e-3 * time, 0.03e-3 * time, -0.3e-3 * time], axis=1)
    assert run.dataset["position"].values == pytest.approx(drift, abs=2e-8)  # the file has five decimals of mm


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("log-dup-col", "log-dup-col.csv: line 3: the column 'x' is there twice; its heads are 'time [s]', 'x [mm]'"),
        ("trk-dup-x", "trk-dup-x.csv: line 1: the column 'x' is there twice; its heads are 'time [s]', 'x [mm]'"),
    ],
)
def test_a_column_given_twice_is_refused(name, words):
    path = TABLES / f"{name}.csv"
    read = partial(read_log, cell=load_cell()) if name.startswith("log") else partial(import_track, initial_gap=0.102)
    with pytest.raises(InputError) as caught:
        read(path)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        (PLAIN, "utf-8"),
        (PLAIN, "utf-8-sig"),
        (PLAIN.replace("\n", "\r\n"), "utf-8"),
        (PLAIN.replace("\n", "\r"), "utf-8"),
        (PLAIN.replace(",", "\t"), "utf-8"),
        (PLAIN.replace(",", ";").replace(".", ","), "utf-8"),
        (PLAIN.replace(",", "\t").replace(".", ","), "utf-8"),
        (PLAIN.replace(",", ";") + ";\n;;\n", "utf-8"),
        ("# gemessen in Z\u00fcrich, 21 \u00b0C\n" + PLAIN, "cp1252"),
        (PLAIN.replace("x [mm]", " X ( mm ) "), "utf-8"),
        (PLAIN.replace("time [s],x [mm]", "time / s,x/mm"), "utf-8"),
        (PLAIN.replace("x [mm]", "x\u00a0[\u339c]"), "utf-8"),
        (PLAIN, "utf-16"),
        ("sep=;\n" + PLAIN.replace(",", ";").replace(".", ","), "cp1252"),
        (",,,\n" + PLAIN, "utf-8"),
        (PLAIN.replace("1.5", "\u00a01.5\u2009"), "utf-8"),
        (PLAIN.replace("\n1,", "\n\n  # later\n1 , "), "utf-8"),
        (PLAIN.replace("1,2.5", '"1","2.5",'), "utf-8"),
        ("note,time [s],x [mm],u [px]\na,0,1.5,\nb,1,2.5,7\n", "utf-8"),
    ],
)
def test_a_table_is_the_same_however_it_is_written(text, encoding, tmp_path):
    table = read(tmp_path / "t.csv", text, encoding=encoding)
    assert table.values.keys() == {"time", "x"}
    assert table.values["time"].tolist() == [0.0, 1.0]
    assert table.values["x"] == pytest.approx([1.5e-3, 2.5e-3], abs=1e-18)


def test_units_in_latin_1_and_names_with_blanks(tmp_path):
    table = read(
        tmp_path / "t.csv", "Time (ms);X-SD [cm];pitch (\u00b0)\n0;1;90\n500;-2e-1;-45\n", encoding="cp1252", needed=()
    )
    assert table.values["time"] == pytest.approx([0.0, 0.5])
    assert table.values["x_sd"] == pytest.approx([0.01, -0.002])
    assert table.values["pitch"] == pytest.approx([math.pi / 2.0, -math.pi / 4.0])


def test_a_minus_of_typesetters_is_one(tmp_path):
    assert read(tmp_path / "t.csv", "time [s],x [mm]\n0,\u22121.5\n1,2\n").values["x"][0] == pytest.approx(-1.5e-3)


SPOTS = (
    "LABEL,TRACK_ID,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T\nLabel,Track ID,X,Y,Z,T\n,,(mm),(mm),(mm),(sec)\n"
    "a,0,1,2,3,0\nb,0,1,2,3,1\n"
)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("b,0,1,2,3,1", "b,0,1,2", "line 5: column 1, 'time [s]', must be a finite number; got nothing"),
        ("b,0,1,2,3,1", "b,0,1,2,3,late", "line 5: column 1, 'time [s]', must be a finite number; got 'late'"),
        ("LABEL,", "POSITION_X,", "must have POSITION_X once; it has POSITION_X, TRACK_ID, POSITION_X"),
        (SPOTS[SPOTS.index("Label") :], "", "must have a line of units"),
        ("(mm),(mm),(mm),(sec)", "", "line 1: the unit of column 'time [T]'"),
    ],
)
def test_a_table_of_trackmate_that_is_cut_or_spoilt_is_refused_with_its_line(old, new, words, tmp_path):
    (tmp_path / "t.csv").write_text(SPOTS)
    assert import_track(tmp_path / "t.csv", initial_gap=0.1).dataset["time"].size == 2
    (tmp_path / "t.csv").write_text(SPOTS.replace(old, new))
    with pytest.raises(InputError) as caught:
        import_track(tmp_path / "t.csv", initial_gap=0.1)
    assert words in str(caught.value)


def test_empty_cells_are_nan_only_where_they_may_be(tmp_path):
    text = "# run: 7\ntime [s],x [mm]\n0,\n1,NaN\n\n2,na\n3,4\n"
    table = read(tmp_path / "t.csv", text, gaps=("x",))
    assert np.isnan(table.values["x"]).tolist() == [True, True, True, False]
    assert table.lines.tolist() == [3, 4, 6, 7]
    assert table.comments == (" run: 7",)
    with pytest.raises(InputError, match=r"line 3: column 2, 'x \[mm\]', must be a finite number; got nothing"):
        read(tmp_path / "t.csv", text)
    with pytest.raises(InputError, match="line 5: time must rise"):
        read(tmp_path / "t.csv", "time [s],x [mm]\n0,1\n1,1\n\n1,1\n").check_rises("time")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("# nothing\n\n", "is empty"),
        ("time [s],x [mm]\n0,1\n", "two rows or more; it has 1"),
        ("time,x [mm]\n0,1\n1,1\n", "line 1: column 'time' must name its unit, such as 'time [s]'"),
        ("#\ntime [s],x []\n0,1\n1,1\n", "line 2: column 'x []' must name its unit"),
        ("time [s],x [deg]\n0,1\n1,1\n", "line 1: the unit of column 'x [deg]' must be a length"),
        ("time [s],y [mm]\n0,1\n1,1\n", "it lacks x; its heads are 'time [s]', 'y [mm]'"),
        (",".join(f"u{i}" for i in range(20)) + "\n1\n1\n", "it lacks time, x; its heads are 'u0', 'u1', 'u2'"),
        (",".join(f"u{i}" for i in range(20)) + "\n1\n1\n", "'u11' and 8 more"),
        ("time [s],x [mm],X (m)\n0,1,1\n1,1,1\n", "the column 'x' is there twice"),
        ("time [s],x [mm]\n0,1\n0,5,1\n", "line 3: there are 3 cells below 2 heads; numbers with a decimal comma"),
        ("time [s],x [mm]\n0,1\n1,inf\n", "line 3: column 2, 'x [mm]', must be a finite number; got 'inf'"),
        ("time [s],x [mm]\n0,1\n1\n", "line 3: column 2, 'x [mm]', must be a finite number; got nothing"),
        ("time [s],x [mm]\n0,1\n1,1_000\n", "got '1_000'"),
        ('time [s],x [mm]\n0,1\n1,"2,5"\n', "got '2,5'"),
        ("time [s];x [mm]\n0;1,5\n1;1.234,5\n", "got '1.234,5'"),
        ("time [s];x [mm]\n0;1,5\n0.5;2\n", "line 3: '0.5' and '1,5' (line 2) do not have the same decimal mark"),
        ("time [s]\0,x [mm]\n0,1\n1,1\n", "is not a text file"),
        (";;;\n;;\n", "holds nothing but separators"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_line(text, words, tmp_path):
    with pytest.raises(InputError) as caught:
        read(tmp_path / "t.csv", text)
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"{tmp_path / 't.csv'}: ")


SPARE = {
    "a column behind that is empty": "time [s],x [mm],note\n0,1,5,\n1,2,5,\n",
    "a column behind that is not written": "time [s],x [mm],note\n0,1,5\n1,2,5\n",
    "two decimal commas and two columns": "time [s],x [mm],quality,note\n0,0,1,5\n1,5,2,5\n",
    "some rows without": "time [s],x [mm],note\n0,1,5\n1,2\n",
    "a first column that is none": "frame,time [s],x [mm],note\n1,0,1,5\n2,1,2,5\n",
    "all whole numbers": "time [s],x [mm],frame\n0,1,1\n1,2,2\n",
    "exponents": "time [s],x [mm],frame\n0,1e0,1\n1,2e0,2\n",
    "a fraction too many": "time [s],x [mm],note\n0,012,0,5\n1,5,2,5\n",
}


@pytest.mark.parametrize("name", SPARE)
def test_decimal_commas_between_commas_never_shift_a_number(name, tmp_path):
    """What may be a fraction is never read as the next column's number."""
    with pytest.raises(InputError, match=r"line \d: .* (decimal comma|decimal ones)") as caught:
        read(tmp_path / "t.csv", SPARE[name])
    assert str(caught.value).count("\n") == 0


@pytest.mark.parametrize(
    "text",
    [
        "time [s],x [mm],frame\n0.0,1,1\n1,2,2\n",
        "time [s],x [mm],note\n0,1.0,\n1,2,late\n",
        "time [s];x [mm];note\n0,0;1\n1;2;7\n",
        "time [s]\tx [mm]\tnote\n0\t1\t\n1\t2\t7\n",
        "frame,time [s],x [mm]\n7,0,1\n8,1,2\n",
        "time [s],x [mm],\n0,1,\n1,2,\n",
        "time [s],x [mm]\n0,1,\n1,2,\n",
        "time [s],x [mm],\n0,1\n1,2\n",
    ],
)
def test_spare_columns_whose_numbers_are_clear_are_passed_over(text, tmp_path):
    found = read(tmp_path / "t.csv", text)
    assert found.values["time"].tolist() == [0.0, 1.0]
    assert found.values["x"].tolist() == [0.001, 0.002]


def test_files_that_cannot_be_opened(tmp_path):
    with pytest.raises(FileError, match="there is no file"):
        read_table(tmp_path / "none.csv", KINDS, needed=("x",))
    with pytest.raises(FileError, match="cannot be read"):
        read_table(tmp_path, KINDS, needed=("x",))


def test_a_log_states_its_frames_in_any_case_and_a_track_names_the_row_without_a_number(tmp_path):
    text = (TABLES / "log-case.csv").read_text().replace("Frame: Lab", "FRAME:  elbow")
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(InputError, match=r"'# frame: lab' or 'base'; got 'elbow'"):
        read_log(tmp_path / "log.csv", load_cell())
    (tmp_path / "t.csv").write_text(
        "time [s],x [mm],y [mm],z [mm],attack angle [deg]\n0,0,0,0,1\n1,,,,\n2,0,0,0,\n3,0,0,0,1\n"
    )
    with pytest.raises(InputError, match="line 4: attack_angle must have a number"):
        import_track(tmp_path / "t.csv", initial_gap=0.1)


def test_a_motor_angle_within_a_turn_is_unwrapped_or_refused():
    even = np.radians(15.12) * np.arange(600)
    assert unwrapped(even % (2.0 * math.pi)) == pytest.approx(even, abs=1e-9)
    assert unwrapped(even).tolist() == even.tolist()
    with pytest.raises(InputError, match="its sense cannot be told"):
        unwrapped(np.radians(170.0) * np.arange(600) % (2.0 * math.pi))


def test_zeros_in_the_place_of_a_position_are_refused_and_a_way_through_the_origin_is_not(tmp_path):
    head, path = "time [s],x [mm],y [mm],z [mm]\n", tmp_path / "t.csv"
    path.write_text(head + "0,10,20,30\n1,10.1,20,30\n2,0,0,0\n3,10.3,20,30\n4,10.4,20,30\n")
    with pytest.raises(InputError, match="line 4: x, y and z are 0, far from the rows before and after; leave"):
        import_track(path, initial_gap=0.1)
    for through in ("0,0,0,0\n1,1,0,0\n2,2,0,0\n", "0,-1,0,0\n1,0,0,0\n2,0,0,0\n3,0,0,0\n4,0,0,-1\n"):
        path.write_text(head + through)
        assert import_track(path, initial_gap=0.1).dataset["time"].size == through.count("\n")
