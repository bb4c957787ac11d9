"""What every command offers alike: help, --json, --quiet, --verbose, and -o. The tests walk over all commands."""

import json
import re
import sys
from pathlib import Path

import pytest

from command_line import run
from helimag.cli import app


def commands(level=app, words=()):
    """Every command: its words and its options."""
    for name in level:
        if name.startswith("-"):
            continue
        inner = level[name]
        if inner.default_command is not None:
            yield (*words, name), inner.assemble_argument_collection(parse_docstring=True)
        yield from commands(inner, (*words, name))


ALL = dict(commands())
IDS = [" ".join(words) for words in ALL]
MAP = ("--vary", "drive.pitch=4 deg..9 deg", "--vary", "drive.frequency=2 Hz..3 Hz")
# what each command that writes needs beside -o; no input need exist, as outputs are looked at before
WRITING = {
    ("simulate",): ("paper/fig3c",),
    ("sweep",): ("plan.toml",),
    ("orbit",): ("paper/fig3c",),
    ("orbit", "map"): ("paper/fig3c", *MAP),
    ("orbit", "flow"): ("paper/fig3c",),
    ("orbit", "basin"): ("paper/fig3c",),
    ("orbit", "against"): ("store.zarr",),
    ("design",): ("paper/fig3c",),
    ("calibrate",): ("plan.toml",),
    ("plot",): ("run.nc",),
    ("reproduce",): ("fig3",),
    ("robot", "check"): ("paper/fig3c",),
    ("robot", "program"): ("paper/fig3c",),
    ("robot", "replay"): ("log.csv", "paper/fig3c"),
    ("compare",): ("measured.nc", "simulated.nc"),
    ("vision", "render"): ("run.nc",),
    ("vision", "calibrate"): ("calibration.toml",),
    ("vision", "track"): ("a.mp4", "b.mp4", "--rig", "rig.json", "--gap", "0.1 m"),
    ("vision", "import"): ("track.csv", "--gap", "0.1 m"),
}
FOLDERS = {("reproduce",), ("robot", "program"), ("vision", "render")}  # whose -o names a folder
FILES = sorted(set(WRITING) - FOLDERS)


def names(options):
    return {name for option in options for name in option.names}


def test_the_walk_finds_the_commands():
    assert {("simulate",), ("orbit",), ("orbit", "map"), ("robot", "read-back"), ("vision", "import")} <= set(ALL)


@pytest.mark.parametrize("options", ALL.values(), ids=IDS)
def test_every_command_speaks_as_it_is_asked_to(options):
    assert {"--json", "--quiet", "--verbose"} <= names(options)


@pytest.mark.parametrize("options", ALL.values(), ids=IDS)
def test_every_option_has_help(options):
    silent = [option.name for option in options if option.show and not option.parameter.help]
    assert silent == []


def test_every_command_that_writes_is_tried_here():
    assert {words for words, options in ALL.items() if "--output" in names(options)} == set(WRITING)


def test_every_command_that_draws_takes_the_size_of_the_figure_and_no_other():
    drawing = {("reproduce",)} | {words for words in FILES if ".png" in output_help(words)}
    assert len(drawing) > 12
    assert {words for words, options in ALL.items() if "--size" in names(options)} == drawing


def output_help(words):
    return next(option.parameter.help for option in ALL[words] if "--output" in option.names)


@pytest.mark.parametrize("words", [words for words in WRITING if "--size" in names(ALL[words])], ids=" ".join)
def test_a_size_without_a_figure_is_refused(words, empty):
    outputs = ["result.nc"] if words not in FOLDERS and ".nc" in output_help(words) else []
    said = run(*words, *WRITING[words], *(part for output in outputs for part in ("-o", output)), "--size", "small")
    if words == ("plot",) and not outputs:  # left out, it is a figure
        return
    assert (said.status, said.out) == (2, "")
    assert said.err.startswith("helimag: --size is for figures: --output must name ")
    assert list(empty.iterdir()) == []


def said_of(words, *outputs):
    return run(*words, *WRITING[words], *(part for output in outputs for part in ("-o", output)))


@pytest.fixture
def empty(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("words", FILES, ids=" ".join)
def test_an_unknown_suffix_is_refused_with_the_known_ones_which_help_names_too(words, empty):
    said = said_of(words, "result.xyz")
    assert (said.status, said.out) == (2, "")
    assert said.err.startswith("helimag: --output must end in .")
    assert said.err.endswith("; got 'result.xyz'\n")
    known = set(re.findall(r"\.\w+", said.err.split(";")[0]))
    (told,) = (option.parameter.help for option in ALL[words] if "--output" in option.names)
    assert known == set(re.findall(r"(?<=[( ])\.\w+", told))
    assert list(empty.iterdir()) == []


def good_name(words):
    """A name that the command takes."""
    if words in FOLDERS:
        return "result"
    told = output_help(words)
    found = re.search(r"\.\w+", told)
    return f"result{found.group() if found else '.nc'}"


@pytest.mark.parametrize("words", WRITING, ids=" ".join)
def test_a_folder_that_is_not_there_is_refused_before_anything_is_read(words, empty):
    name = f"new/{good_name(words)}"
    said = said_of(words, name)
    assert (said.status, said.out) == (2, "")
    assert said.err == f"helimag: {name} cannot be written: there is no folder 'new'\n"
    assert list(empty.iterdir()) == []


@pytest.mark.parametrize("words", WRITING, ids=" ".join)
def test_a_place_that_takes_no_files_is_refused_before_anything_is_read(words, empty):
    name = f"/proc/{good_name(words)}"
    said = said_of(words, name)
    assert (said.status, said.out) == (2, "")
    assert said.err.startswith(f"helimag: {name} cannot be written: ")
    assert list(empty.iterdir()) == []


@pytest.mark.parametrize("words", WRITING, ids=" ".join)
def test_a_folder_in_the_place_of_a_file_is_refused_and_the_other_way_round(words, empty):
    place = empty / good_name(words)
    store = place.suffix == ".zarr"
    if words in FOLDERS or store:
        place.write_text("keep me")
    else:
        place.mkdir()
    said = said_of(words, place.name)
    assert (said.status, said.out) == (2, "")
    kind = "is a file; name a folder" if words in FOLDERS or store else "is a directory; name a file in it"
    assert said.err == f"helimag: {place.name} {kind}\n"
    assert list(empty.iterdir()) == [place]


@pytest.mark.parametrize("words", WRITING, ids=" ".join)
def test_what_is_read_is_never_written_over(words, empty):
    """Whatever its suffix, and by whatever name: a link, a way around."""
    name = good_name(words)
    place = empty / name
    if place.suffix in {"", ".zarr"}:
        place.mkdir()
    else:
        place.write_text("keep me")
    (empty / "link").symlink_to(name)
    first, *rest = WRITING[words]
    if words == ("reproduce",):  # it reads nothing
        return
    for read in (name, f"./{name}", "link", place):
        said = run(*words, read, *rest, "-o", name)
        assert (said.status, said.out) == (2, "")
        assert said.err == f"helimag: --output names '{name}', which this command reads; name another file\n"
    assert place.is_dir() or place.read_text() == "keep me"


# what each command reads first, in words that follow it
READING = {words: rest[1:] for words, rest in WRITING.items() if words != ("reproduce",)} | {
    ("orbit", "check"): (),
    ("resistance",): (),
    ("robot", "read-back"): ("paper/table1-row1",),
    ("doctor",): (),
    ("cite",): (),
    ("presets",): (),
    ("studio",): ("--no-browser",),
}


@pytest.mark.skipif(sys.platform == "win32", reason="devices of Unix")
@pytest.mark.parametrize("place", ["/dev/zero", "/dev/full", ".", "/", "loop", "loop/run.nc", "a\0b", "x" * 300, ""])
@pytest.mark.parametrize("words", READING, ids=" ".join)
def test_what_is_no_file_is_refused_in_one_line(words, place, empty):
    """A device that never ends among them, a loop of links, and names that no file can have."""
    (empty / "loop").symlink_to("loop")
    name = good_name(words) if words in WRITING else ""
    outputs = ("-o", name) if words in WRITING and words not in FOLDERS else ("-o", "made") if name else ()
    said = run(*words, place, *READING[words], *outputs)
    assert (said.status, said.out) == (2, "")
    assert said.err.startswith("helimag: ")
    assert said.err.count("\n") == 1
    assert [path.name for path in empty.iterdir()] == ["loop"]


COUNTS = sorted(
    (words, name)
    for words, options in ALL.items()
    for option in options
    for name in option.names
    if option.hint in {int, int | None} and name.startswith("--")
)


def test_the_walk_finds_the_counts():
    assert {(("orbit", "map"), "--nodes"), (("sweep",), "--threads"), (("studio",), "--port")} <= set(COUNTS)


@pytest.mark.parametrize(
    "given", ["1.5", "1_000", "0x10", "\u0663", "1e3", "-1", "nan", "inf", "", " 7", "9" * 21, "9" * 5000]
)
@pytest.mark.parametrize(("words", "name"), COUNTS)
def test_a_count_is_written_in_digits_and_has_limits(words, name, given, empty):
    """1.5 was rounded to 2; a map of 10^21 nodes ended in a traceback."""
    needed = {("studio",): (), ("robot", "jitter"): ("paper/fig3c", "jitter.toml")}.get(words) or WRITING.get(words, ())
    folder = ("-o", "made") if words in FOLDERS else ()
    said = run(*words, *needed, *folder, f"{name}={given}")
    assert (said.status, said.out) == (2, "")
    assert f"{name} must be a whole number from " in said.err
    assert said.err.count("\n") == 1
    assert list(empty.iterdir()) == []


@pytest.mark.parametrize("words", FILES, ids=" ".join)
def test_a_file_that_is_there_may_be_named_but_once(words, empty):
    """It passes the look at the outputs: what is refused is the second name."""
    place = empty / good_name(words)
    if place.suffix != ".zarr":
        place.write_text("older")
    twice = said_of(words, place.name, place.name)
    assert twice.err == f"helimag: --output names '{place.name}' twice\n"


@pytest.mark.parametrize("words", WRITING, ids=" ".join)
def test_nothing_is_written_that_was_not_named(words, empty):
    """Commands that cannot do without an output say so; the others find no input."""
    if words in {("vision", "calibrate"), ("vision", "track"), ("vision", "import"), ("orbit", "against")}:
        said = run(*words, *WRITING[words])
        assert said.status == 2
    elif words == ("plot",):  # draws beside its input, under its name
        said = run(*words, *WRITING[words])
        assert said == (2, "", "helimag: there is no file 'run.nc'\n")
    elif words in {("calibrate",), ("sweep",), ("robot", "program"), ("vision", "render")}:
        said = run(*words, *WRITING[words])
        assert said.status == 2
        assert "--output" in said.err
    assert list(empty.iterdir()) == []


def test_quiet_prints_nothing_and_errors_all_the_same(empty):
    assert run("simulate", "paper/fig3c", "--duration", "7 s", "--quiet", "-o", "a.nc") == (0, "", "")
    assert [path.name for path in empty.iterdir()] == ["a.nc"]
    said = run("simulate", "nowhere", "--quiet")
    assert (said.status, said.out) == (2, "")
    assert said.err.count("\n") == 1


def test_quiet_json_is_the_object_alone():
    loud, still = (run("cite", "paper/fig3c", "--json", *more) for more in ((), ("--quiet",)))
    assert still.err == ""
    assert json.loads(still.out) == json.loads(loud.out)
    assert json.loads(still.out).keys() == {"scenario", "methods", "references"}


def test_verbose_says_what_is_done_and_how_long_it_takes_and_changes_no_result():
    words = ("simulate", "paper/fig3c", "--duration", "7 s", "--no-orbit", "--no-accuracy")
    plain, told = run(*words), run(*words, "--verbose")
    assert told.out == plain.out
    lines = told.err.splitlines()
    assert all(line.startswith("helimag: ") for line in lines)
    assert any("by the method 'DOP853, multi-revolution' on cpu" in line for line in lines)
    assert re.fullmatch(r"helimag: \d+\.\d\d s in all", lines[-1])
    assert not any("in all" in line for line in run(*words).err.splitlines())


def test_more_and_nothing_at_once_is_refused():
    said = run("presets", "--quiet", "--verbose")
    assert said == (2, "", "helimag: --quiet and --verbose contradict each other: leave one of them out\n")


def test_presets_as_one_object_and_a_preset_too():
    listed = json.loads(run("presets", "--json").out)["presets"]
    assert {"name", "frequency_hz", "pitch_deg"} <= listed[0].keys()
    assert json.loads(run("presets", "paper/fig3c", "--json").out)["drive"]["frequency"] == "3.3 Hz"


def stop(*_given, **_named):
    raise KeyboardInterrupt


def test_an_interrupted_sweep_says_how_to_go_on_even_when_quiet(monkeypatch, empty):
    plan = 'base = "paper/fig3c"\n[[axis]]\nfield = "drive.pitch"\nvalues = ["8 deg"]\n'
    (empty / "plan.toml").write_text(plan)
    monkeypatch.setattr("helimag.sweeps.sweep", stop)
    Path("plan.toml").write_text(
        'base = "paper/fig3c"\n[[axis]]\nfield = "drive.pitch"\nvalues = ["4 deg"]\n', encoding="utf-8"
    )
    said = run("sweep", "plan.toml", "-o", "s.zarr", "--quiet")
    assert said == (130, "", "helimag: interrupted; run the same command again to go on from what is in s.zarr\n")


def test_streams_are_given_back():
    before = sys.stdout, sys.stderr
    run("presets", "--quiet")
    assert (sys.stdout, sys.stderr) == before
