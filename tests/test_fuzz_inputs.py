"""Odd scenarios, plans, tables, options and stores: read, or refused in one line; no exception of Python's, no run.

2,000 cases in all. What is accepted must mean what it says: written out and read again it is the same.
"""

import json
import math
import shutil
import string
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import helimag as hm
from helimag.robot import load_cell, read_log
from helimag.runs import import_track
from helimag.scenario import parse
from helimag.sweeps import parse_plan, resolve

DATA = Path(__file__).parent / "data" / "tables"
ODD = [  # a few of each kind that has gone wrong somewhere
    "1e999", "-1e999", "nan", "'nan mm'", "'inf Hz'", "0", "-1", "1e-320", "'1e400 mm'", "'-0 mm'", "''", "' '",
    "true", "[]", "{}", "[[[]]]", "'12'", "'12 parsec'", "'1 mm; DROP'", "'=1+1'", "'\\u0000'", "'\\ud7ff'",
    "'١٢ mm'", "'1,5 mm'", "'1 mm 2 mm'", "99999999999999999999", "1979-05-27", "'x'", "'../../etc/passwd'",
    "['1 mm', '2 mm']", "['1 mm', '2 mm', 'nan mm']", "'5 mm..1 mm'", "'1e308 deg'", "'--help'", "'9' ", "0x10",
    "'3.3 Hz\\n'", "'" + "9" * 400 + " mm'",
]  # fmt: skip
SILENT = {"deadline": None, "derandomize": True, "database": None, "suppress_health_check": list(HealthCheck)}
PLAN = """
name = "p"
base = "nose-first/fig3c"
duration = "2 s"
samples = 20
[[axis]]
field = "drive.frequency"
values = ["2 Hz", "3 Hz"]
[[axis]]
field = "drive.pitch"
start = "1 deg"
stop = "19 deg"
step = "6 deg"
"""


@cache
def preset(name):
    return hm.load(name).to_toml()


@st.composite
def changed(draw, text):
    """A file's text with some of its lines changed: other values or keys; lines lost, doubled, moved, cut or spoilt."""
    lines = text.splitlines()
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(lines) - 1))
        how = draw(st.sampled_from(["value", "value", "value", "key", "lost", "double", "swap", "cut", "byte"]))
        key, sign, _ = lines[at].partition("=")
        match how:
            case "value":
                lines[at] = f"{key}= {draw(st.sampled_from(ODD))}" if sign else lines[at]
            case "key":
                lines[at] = f"{draw(st.text(string.ascii_letters + '._-', max_size=12))} = {draw(st.sampled_from(ODD))}"
            case "lost":
                lines[at] = ""
            case "double":
                lines.insert(at, lines[at])
            case "swap":
                lines[at], lines[-1 - at] = lines[-1 - at], lines[at]
            case "cut":
                lines[at] = lines[at][: draw(st.integers(0, len(lines[at])))]
            case _:
                lines[at] += draw(st.text(max_size=5))
    return "\n".join(lines)


def refused_or(make, *given_to_it):
    """What is made, or None where it is refused in one line; whatever else is raised fails the test."""
    try:
        return make(*given_to_it)
    except hm.HelimagError as error:
        assert str(error).strip()  # noqa: PT017
        return None


@pytest.mark.parametrize("name", ["nose-first/fig3c", "paper/table1-row1"])
def test_odd_scenarios(name):
    @settings(max_examples=350, **SILENT)
    @given(text=changed(preset(name)))
    def hold(text):
        scenario = refused_or(parse, text, "odd.toml")
        if scenario is not None:
            again = parse(scenario.to_toml(), "again")
            assert again.hash == scenario.hash
            assert all(
                math.isfinite(v) for v in (*scenario.drive.start, scenario.run.duration, scenario.drive.distance)
            )

    hold()


@settings(max_examples=350, **SILENT)
@given(text=changed(PLAN))
def test_odd_plans(text):
    plan = refused_or(parse_plan, text, "odd.toml")
    resolved = None if plan is None else refused_or(resolve, plan)
    if resolved is not None:
        assert resolve(parse_plan(plan.to_toml(), "again")).identity == resolved.identity


@settings(max_examples=450, **SILENT)
@given(data=st.data(), table=st.sampled_from(sorted(path.name for path in DATA.glob("*.csv"))))
def test_odd_tables(data, table, tmp_path_factory):
    text = (DATA / table).read_bytes().decode("latin-1")
    text = "\n".join(text.splitlines()[:12])
    content = data.draw(changed(text.replace(",", "=", 1)))
    cells = data.draw(st.lists(st.sampled_from([*ODD, "=1+1", "1e5", ";", ",,", "\t", '"']), max_size=3))
    content = content.replace("=", ",", 1) + "\n" + ",".join(cells)
    path = tmp_path_factory.getbasetemp() / "odd.csv"
    path.write_bytes(content.encode(data.draw(st.sampled_from(["utf-8", "utf-16", "utf-8-sig"])), "replace"))
    refused_or(lambda: read_log(path, load_cell()))
    track = refused_or(lambda: import_track(path, initial_gap=0.1))
    if track is not None:
        assert (track.dataset["time"].diff("time") > 0.0).all()


COMMANDS = [
    ("presets",), ("resistance", "nose-first/fig3c"), ("cite", "nose-first/fig3c"), ("simulate",),
    ("simulate", "none"), ("sweep",), ("sweep", "none.toml"), ("orbit",), ("orbit", "map", "nose-first/fig3c"),
    ("orbit", "basin", "none"), ("design", "none"), ("plot", "."), ("plot", "none.nc"), ("robot", "check"),
    ("robot", "read-back", "none.src"), ("robot", "jitter", "nose-first/fig3c"), ("compare", "a", "b"),
    ("vision", "calibrate", "none"), ("vision", "track"), ("vision", "import", "none.csv"), ("reproduce", "fig9"),
    ("doctor", "none"), (),
]  # fmt: skip
OPTIONS = [
    "--set", "--duration", "--interval", "-o", "--output", "--json", "--cell", "--unwind", "--vary", "--from",
    "--to", "--nodes", "--box", "--seed", "--draws", "--export", "--engine", "--all", "--name", "--angle",
    "--quiet", "--verbose", "--bits", "--rate", "--nothing", "--help", "-", "--",
]  # fmt: skip
VALUES = [
    "", " ", "0", "-1", "1e999", "nan", "5 s", "drive.pitch=", "=", "drive.pitch=15 deg", 'drive.pitch="15"',
    "drive..pitch=1", "a=b=c", "x" * 300, "\x00", "../..", "/", "é", "[[", "drive.pitch=[1,", "no.such=1",
    "drive.pitch=1..2", "run.duration=true", "fig3c.png", "a.nc", "\udc80",
]  # fmt: skip


@settings(max_examples=380, **SILENT)
@given(
    command=st.sampled_from(COMMANDS),
    words=st.lists(st.tuples(st.sampled_from(OPTIONS), st.sampled_from(VALUES)), min_size=1, max_size=3),
)
def test_odd_options(command, words, tmp_path_factory):
    """Status 0, 1 or 2, one line of refusal at most, no traceback; nothing here may get as far as a run."""
    import command_line

    place = tmp_path_factory.getbasetemp()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        for module in ("running", "simulation"):
            patch.setattr(f"helimag.engine.{module}.advance", _ran, raising=False)
        status, _, err = command_line.run(*command, *(part for pair in words for part in pair))
    assert status in {0, 1, 2}, err
    assert "Traceback" not in err
    lines = [line for line in err.splitlines() if not line.startswith("helimag: warning: ")]
    assert len(lines) <= 1, err


def _ran(*_given, **_named):
    raise hm.RunError("a run was begun")


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("stores") / "store.zarr"
    hm.sweep(parse_plan(PLAN.replace('step = "6 deg"', 'step = "18 deg"')), out=path)
    return path


@settings(max_examples=120, **SILENT)
@given(data=st.data())
def test_damaged_stores(store, data):
    """A file of a store cut, spoilt, emptied or gone: the same numbers, or one line that names the store."""
    files = sorted(path.relative_to(store) for path in store.rglob("*") if path.is_file())
    damaged = store.with_name("damaged.zarr")
    shutil.rmtree(damaged, ignore_errors=True)
    shutil.copytree(store, damaged)
    file = damaged / data.draw(st.sampled_from(files))
    content = bytearray(file.read_bytes())
    match data.draw(st.sampled_from(["cut", "flip", "gone", "junk", "json"])):
        case "cut":
            file.write_bytes(content[: data.draw(st.integers(0, len(content) - 1))])
        case "flip":
            content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
            file.write_bytes(content)
        case "gone":
            file.unlink()
        case "junk":
            file.write_bytes(data.draw(st.binary(max_size=60)))
        case _:
            file.write_text(json.dumps(data.draw(st.sampled_from([{}, [], None, {"attributes": {}}, {"shape": "x"}]))))
    found = refused_or(hm.load_sweep, damaged)
    if found is not None and file.parts[-2] == "c" and file.parts[-3] != "checksum":
        assert found.equals(hm.load_sweep(store))
