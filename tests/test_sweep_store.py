"""The store: labelled, atomic by chunk, resumed bit for bit, and clear about what is wrong with it."""

import csv
import fcntl
import gc
import json
import math
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

import helimag
from helimag import FileError, InputError, load
from helimag.engine import kernels
from helimag.outcomes import Reason, Verdict
from helimag.sweeps import counts, estimate, export, load_sweep, parse_plan, resolve, resolved, trial
from helimag.sweeps.kept import identity_hash
from helimag.sweeps.run import sweep
from helimag.sweeps.store import Store

sys.path.insert(0, str(Path(__file__).parent.parent / "benchmarks"))
import sweep_kills

PLAN = """
name = "store"
base = "nose-first/fig3c"
duration = "60 s"
samples = 20

[[axis]]
field = "drive.frequency"
values = ["2 Hz", "3 Hz"]

[[axis]]
field = "drive.distance"
start = "10 mm"
stop = "160 mm"
count = 31
"""


def written(path: Path, text: str = PLAN) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def done(tmp_path_factory) -> Path:
    """A finished store; the first distances are refused (the device would touch the magnet)."""
    store = tmp_path_factory.mktemp("store") / "done.zarr"
    helimag.sweep(parse_plan(PLAN), out=store)
    return store


def copy(store: Path, to: Path) -> Path:
    for name, content in sweep_kills.files(store).items():
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        (to / name).write_bytes(content)
    return to


def test_the_dataset_is_labelled_in_si_with_flags_as_cf_has_them(done):
    with xarray.open_dataset(done, engine="zarr", consolidated=False) as dataset:
        assert dataset["gain"].dims == ("frequency", "distance")
        for name, unit in {
            "frequency": "Hz",
            "pitch": "rad",
            "distance": "m",
            "yaw_rate": "rad/s",
            "speed": "m/s",
        }.items():
            assert dataset.coords[name].attrs["units"] == unit
        assert float(dataset["yaw_rate"]) == load("nose-first/fig3c").drive.yaw_rate
        assert dataset["verdict"].attrs["flag_values"] == [verdict.flag for verdict in Verdict]
        words = dataset["verdict"].attrs["flag_meanings"].split()
        assert words == [
            "not-computed",
            "bounded",
            "drifting",
            "attracted",
            "fell",
            "wall-limited",
            "failed",
            "undecided",
        ]
        assert dataset["verdict"].dtype == np.int8
        assert len(dataset["reason"].attrs["flag_meanings"].split()) == len(Reason)
        for name in ("end_time", "escape_time", "slips", "wobble", "attack_angle", "output"):
            assert "units" in dataset[name].attrs
        assert parse_plan(dataset.attrs["plan"]).axis[1].count == 31
        assert json.loads(dataset.attrs["versions"])["helimag"]


def test_rows_agree_with_single_runs_and_failures_stay(done):
    dataset = load_sweep(done)
    assert dataset["verdict"].size == 62
    failed = dataset["verdict"] == Verdict.FAILED
    near = dataset["distance"] <= load("nose-first/fig3c").contact_distance
    assert int(near.sum()) > 0
    np.testing.assert_array_equal(failed.any("frequency"), near)
    assert np.all(dataset["reason"].values[failed.values] == Reason.SCENARIO_REFUSED)
    assert np.isnan(dataset["gain"].values[failed.values]).all()
    design = resolve(parse_plan(PLAN))
    for i, j in ((0, 8), (0, 30), (1, 12)):
        values = {"drive.frequency": float(dataset.frequency[i]), "drive.distance": float(dataset.distance[j])}
        scenario = design.scenario(values)
        run = helimag.simulate(scenario, refine=False)
        cell = dataset.isel(frequency=i, distance=j)
        assert float(cell.gain) == run.gain
        assert Verdict(int(cell.verdict)).name == run.verdict.name
        assert float(cell.end_time) == run.judgement.end_time
        assert bytes(cell.scenario_hash.values).hex() == scenario.hash


def test_a_run_whose_numbers_break_down_is_a_failed_row(tmp_path):
    axis = '[[axis]]\nfield = "device.weight.net_weight"\nvalues = ["28 uN", "1e300 N"]\n'
    text = PLAN.partition("[[axis]]")[0] + axis
    dataset = helimag.sweep(parse_plan(text), out=tmp_path / "s.zarr")
    assert dataset["verdict"].values.tolist()[0] != Verdict.FAILED
    assert dataset["verdict"].values.tolist()[1] == Verdict.FAILED
    assert dataset["reason"].values.tolist()[1] == Reason.NUMBERS_BROKE_DOWN


def test_reasons_say_what_the_judgement_says(tmp_path):
    text = PLAN.replace("60 s", "1800 s").partition("[[axis]]")[0] + (
        '[[axis]]\nfield = "drive.frequency"\nvalues = ["2.5 Hz", "3.3 Hz"]\n\n'
        '[[axis]]\nfield = "drive.pitch"\nvalues = ["0 deg", "10 deg", "14 deg", "16.5 deg", "18.5 deg"]\n'
    )
    dataset = helimag.sweep(parse_plan(text), out=tmp_path / "s.zarr")
    design = resolve(parse_plan(text))
    phrases = {
        Reason.SETTLED: "has settled",
        Reason.STILL_RISES: "still rises",
        Reason.STILL_SINKS: "still sinks",
        Reason.SWINGS_EVER_MORE: "swings ever more",
        Reason.PULLED_INTO_MAGNET: "pulled into the magnet",
        Reason.FELL_BEHIND: "fell behind",
        Reason.MOVES_ON: "not less and less",
        Reason.SWINGS_ON: "do not die out",
    }
    seen = set()
    runs = helimag.simulate_many(
        [design.scenario(point) for c in range(len(design.chunks)) for point in design.points(c)], refine=False
    )
    for flag, run in zip(dataset["reason"].values.ravel(), runs, strict=True):
        assert phrases[Reason(flag)] in run.judgement.reason
        assert run.judgement.cause is Reason(flag)
        seen.add(Reason(flag))
    assert seen >= {Reason.SETTLED, Reason.STILL_RISES, Reason.PULLED_INTO_MAGNET, Reason.FELL_BEHIND}


def test_too_few_samples_are_stored_as_such(tmp_path):
    """1200 s with a sample each two minutes: the sentence said so, but the store said that it swings ever more."""
    text = 'trajectory = "120 s"\n' + PLAN.replace('"60 s"', '"1200 s"').partition("[[axis]]")[0]
    text += '[[axis]]\nfield = "drive.pitch"\nvalues = ["12 deg", "12.7 deg"]\n'
    dataset = helimag.sweep(parse_plan(text), out=tmp_path / "s.zarr")
    assert dataset.sizes["time"] == 11
    assert dataset["end_time"].values.tolist() == [1200.0, 1200.0]
    words = dataset["reason"].attrs["flag_meanings"].split()
    assert [words[flag] for flag in dataset["reason"].values] == ["too-few-samples"] * 2
    assert np.all(dataset["verdict"] == Verdict.UNDECIDED)


def test_stores_of_before_mean_what_they_meant(tmp_path):
    """Words and numbers as 0.1.0 wrote them at first: without the reasons that came later."""
    old = tmp_path / "old.zarr"
    helimag.sweep(parse_plan(PLAN.replace("60 s", "1800 s").replace("count = 31", "count = 4")), out=old)
    words = (
        "not-computed settled still-rises still-sinks swings-ever-more pulled-into-magnet fell-behind reached-floor "
        "reached-surface reached-wall numbers-broke-down scenario-refused"
    )
    form = json.loads((old / "reason" / "zarr.json").read_text(encoding="utf-8"))
    form["attributes"] |= {"flag_values": list(range(12)), "flag_meanings": words}
    written(old / "reason" / "zarr.json", json.dumps(form))
    dataset = load_sweep(old)
    assert dataset["reason"].attrs["flag_meanings"] == words
    flags = dataset["reason"].values.ravel()
    assert len(set(flags)) > 2
    export(dataset, tmp_path / "old.csv")
    with (tmp_path / "old.csv").open(encoding="utf-8") as file:
        assert [row["reason"] for row in csv.DictReader(file)] == [words.split()[flag] for flag in flags]


def test_trajectories_on_request_hold_the_states_of_the_single_run(tmp_path):
    text = 'trajectory = "7 s"\n' + PLAN.replace("31", "4")
    dataset = helimag.sweep(parse_plan(text), out=tmp_path / "s.zarr")
    assert dataset["position"].dims == ("frequency", "distance", "time", "axis")
    np.testing.assert_array_equal(dataset["time"], np.arange(9) * 7.0)
    scenario = load("nose-first/fig3c").replaced({"drive.frequency": "3 Hz", "drive.distance": "160 mm"})
    run = helimag.simulate(scenario, duration="60 s", interval="7 s")
    states = dataset.isel(frequency=1, distance=3)
    np.testing.assert_array_equal(states["position"], run.dataset["position"][:9])
    np.testing.assert_array_equal(states["quaternion"], run.dataset["quaternion"][:9])
    assert run.dataset.sizes["time"] == 10  # the tenth is the end at 60 s, which is not a multiple of 7 s


def test_export_to_netcdf_and_csv(done, tmp_path):
    dataset = load_sweep(done)
    export(dataset, tmp_path / "s.nc")
    export(dataset, tmp_path / "s.csv")
    with xarray.open_dataset(tmp_path / "s.nc", engine="h5netcdf") as back:
        xarray.testing.assert_identical(back.load()["gain"], dataset["gain"].load())
        assert back["verdict"].attrs["flag_meanings"].startswith("not-computed bounded")
    with (tmp_path / "s.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 62
    row = next(row for row in rows if row["frequency (Hz)"] == "3.0" and row["distance (m)"] == "0.16")
    assert float(row["gain (1)"]) == float(dataset.gain.sel(frequency=3.0, distance=0.16))
    assert row["verdict"] == "undecided"
    assert re.fullmatch("[0-9a-f]{64}", row["scenario_hash"])
    with pytest.raises(InputError, match=r"ending in .nc or .csv"):
        export(dataset, tmp_path / "s.xls")


def test_a_finished_store_is_left_as_it_is(done, monkeypatch):
    before = sweep_kills.files(done)
    monkeypatch.setattr("helimag.sweeps.engines.compute", lambda *_: pytest.fail("computed again"))
    helimag.sweep(parse_plan(PLAN), out=done)
    assert sweep_kills.files(done) == before


def test_killed_and_resumed_is_the_same_bit_for_bit_and_nothing_is_computed_twice(tmp_path):
    # the same with 20 kills: benchmarks/sweep_kills.py
    found = sweep_kills.torture(tmp_path, kills=3, count=80)
    assert found["kills"] == 3
    assert found["repeated"] == 0
    assert found["same"]


def test_interrupted_by_the_user_it_leaves_a_store_to_go_on_with(tmp_path, done):
    plan = parse_plan(PLAN)

    def interrupt(progress):
        if progress.done >= 16:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(plan, out=tmp_path / "s.zarr", progress=interrupt)
    assert 16 <= sum(n for name, n in counts(load_sweep(tmp_path / "s.zarr")).items() if name != "not-computed") < 62
    sweep(plan, out=tmp_path / "s.zarr")
    assert sweep_kills.files(tmp_path / "s.zarr") == sweep_kills.files(done)


def test_control_c_ends_the_command_with_one_line_and_status_130(tmp_path):
    plan = written(tmp_path / "plan.toml", PLAN.replace("60 s", "1800 s"))
    command = [sys.executable, "-m", "helimag", "sweep", str(plan), "-o", str(tmp_path / "s.zarr")]
    child = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "s.zarr").exists():
        assert child.poll() is None
    child.send_signal(signal.SIGINT)
    message = child.communicate(timeout=300)[1]  # it may be compiling, which nothing interrupts
    assert child.returncode == 130
    assert "Traceback" not in message
    assert "interrupted; run the same command again" in message
    counts(load_sweep(tmp_path / "s.zarr"))


def test_another_plan_is_refused_with_the_difference_named(done):
    before = sweep_kills.files(done)
    for change, words in (
        (("160 mm", "161 mm"), "axis.1.stop is '160 mm' there and '161 mm' here"),
        (("60 s", "61 s"), "scenario.run.duration is '60 s' there and '61 s' here"),
        (("samples = 20", "samples = 30"), "samples is 20 there and 30 here"),
    ):
        with pytest.raises(InputError) as caught:
            helimag.sweep(parse_plan(PLAN.replace(*change)), out=done)
        assert words in str(caught.value)
        assert str(done) in str(caught.value)
    helimag.sweep(parse_plan(PLAN.replace('name = "store"', 'name = "renamed"')), out=done)
    assert sweep_kills.files(done) == before


def test_other_versions_are_refused(done, tmp_path):
    store = copy(done, tmp_path / "s.zarr")
    found = json.loads((store / "zarr.json").read_text(encoding="utf-8"))
    theirs = json.loads(found["attributes"]["versions"])
    found["attributes"]["versions"] = json.dumps({**theirs, "helimag": "9.9.9"})
    (store / "zarr.json").write_text(json.dumps(found), encoding="utf-8")
    with pytest.raises(InputError, match=r"begun with helimag 9\.9\.9"):
        helimag.sweep(parse_plan(PLAN), out=store)


@pytest.mark.parametrize("damage", ["flip", "cut", "gone", "marker"])
def test_a_damaged_chunk_is_named_the_rest_unharmed_and_it_alone_is_computed_again(done, tmp_path, damage):
    store = copy(done, tmp_path / "s.zarr")
    file = store / ("checksum/c/2/0" if damage == "marker" else "gain/c/0/2")
    content = file.read_bytes()
    match damage:
        case "flip" | "marker":
            file.write_bytes(bytes([content[0] ^ 1]) + content[1:])
        case "cut":
            file.write_bytes(content[:-1])
        case "gone":
            file.unlink()
    before = sweep_kills.files(store)
    for use in (lambda: helimag.sweep(parse_plan(PLAN), out=store), lambda: load_sweep(store)):
        with pytest.raises(FileError) as caught:
            use()
        assert str(file if damage != "marker" else store / "checksum") in str(caught.value)
    assert sweep_kills.files(store) == before
    (store / "checksum/c/2/0").unlink()  # the remedy that the message names
    helimag.sweep(parse_plan(PLAN), out=store)
    assert sweep_kills.files(store) == sweep_kills.files(done)


def test_a_store_in_use_is_refused(done):
    from helimag.sweeps.store import Store

    with Store.opened(done, resolve(parse_plan(PLAN))), pytest.raises(FileError, match="in use by another sweep"):
        helimag.sweep(parse_plan(PLAN), out=done)


def test_a_read_only_store_gives_one_clear_line(done, tmp_path):
    store = copy(done, tmp_path / "s.zarr")
    (store / "checksum/c/2/0").unlink()
    for path in [store, *store.rglob("*")]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    plan = written(tmp_path / "plan.toml")
    # permissions do not stop root: a child that has loaded everything goes on as nobody
    code = """
import os, sys
from pathlib import Path
import helimag
plan, store, warm = sys.argv[1:]
helimag.sweep(plan, out=warm)
if os.geteuid() == 0:
    for folder in Path(store).parents:
        folder.chmod(folder.stat().st_mode | 0o055)
        if folder.parent == Path("/tmp") or folder.parent == Path("/"):
            break
    os.setuid(65534)
for out in (store, store + "/new.zarr"):
    try:
        helimag.sweep(plan, out=out)
    except helimag.FileError as error:
        print(error)
"""
    arguments = [str(plan), str(store), str(tmp_path / "warm.zarr")]
    found = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    lines = found.stdout.splitlines()
    assert lines[0] == f"{store} cannot be written: Permission denied"
    assert lines[1] == f"{store}/new.zarr cannot be made: Permission denied"
    for path in [store, *store.rglob("*")]:
        path.chmod(0o755 if path.is_dir() else 0o644)
    load_sweep(store)


def test_a_full_disk_names_the_file_and_keeps_what_was_committed(tmp_path, done):
    store = tmp_path / "s.zarr"
    plan = written(tmp_path / "plan.toml")
    # stands for a full disk: the system refuses every file that grows beyond the limit, from the third chunk on
    code = """
import resource, signal, sys
from helimag.cli import main
from helimag.sweeps.store import Store
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
commit, seen = Store.commit, []
def limited(self, chunk, rows):
    seen.append(chunk)
    if len(seen) == 3:
        resource.setrlimit(resource.RLIMIT_FSIZE, (16, resource.RLIM_INFINITY))
    commit(self, chunk, rows)
Store.commit = limited
main()
"""
    command = [sys.executable, "-c", code, "sweep", str(plan), "-o", str(store)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.returncode == 2, found.stderr
    assert re.search(rf"{re.escape(str(store))}/gain/c/\d+/\d+ cannot be written: File too large", found.stderr)
    assert "Traceback" not in found.stderr
    assert sum(counts(load_sweep(store)).values()) - counts(load_sweep(store))["not-computed"] == 16
    helimag.sweep(parse_plan(PLAN), out=store)
    assert sweep_kills.files(store) == sweep_kills.files(done)


def test_searches_for_cycles_are_as_often_after_a_sweep_as_before(tmp_path):
    def interrupt(_):
        raise KeyboardInterrupt

    before = gc.get_threshold()
    with pytest.raises(KeyboardInterrupt):
        sweep(parse_plan(PLAN), out=tmp_path / "s.zarr", progress=interrupt)
    assert gc.get_threshold() == before


def test_what_is_no_store_is_refused(tmp_path):
    (tmp_path / "file").write_text("x", encoding="utf-8")
    (tmp_path / "folder").mkdir()
    for name in ("file", "folder"):
        with pytest.raises(FileError, match=name):
            helimag.sweep(parse_plan(PLAN), out=tmp_path / name)
    with pytest.raises(FileError, match=r"no zarr\.json"):
        load_sweep(tmp_path / "none.zarr")


def test_the_estimate_of_time_and_disk_is_of_the_right_size(tmp_path, monkeypatch):
    monkeypatch.setattr(trial, "TRIAL_SECONDS", 20.0)  # on a busy machine, too
    plan = parse_plan(PLAN.replace("10 mm", "130 mm").replace("60 s", "900 s"))
    guess = estimate(plan, threads=1)
    assert guess.runs == 62
    clocks = []
    helimag.sweep(plan, out=tmp_path / "s.zarr", threads=1, progress=lambda p: clocks.append(p.seconds))
    assert 0.2 < guess.seconds / clocks[-1] < 5.0  # other work on the machine takes its share of either
    used = sum(path.lstat().st_blocks * 512 for path in (tmp_path / "s.zarr").rglob("*"))
    assert guess.whole
    assert guess.bytes == pytest.approx(used, rel=0.25)


def test_no_kernel_is_compiled_while_a_trial_is_timed(monkeypatch):
    """Runs beside others have another kernel than a run by itself, and long ones another than short ones."""
    asked, timed = [], []

    def ready(build, device):
        asked.append(made := kernels.ready(build, device))
        return made

    def seconds(*given):
        before = set(asked)
        taken = timed_seconds(*given)
        timed.append(set(asked) - before)
        return taken

    timed_seconds = trial._seconds
    monkeypatch.setattr("helimag.engine.running.ready", ready)
    monkeypatch.setattr(trial, "_seconds", seconds)
    monkeypatch.setattr(trial, "TRIAL_SECONDS", 20.0)
    assert estimate(parse_plan(PLAN.replace("60 s", "900 s")), threads=1).whole
    assert timed == [set(), set()]
    assert len(set(asked)) > 1


def test_runs_too_long_for_a_trial_are_begun_only(monkeypatch):
    monkeypatch.setattr(trial, "TRIAL_SECONDS", 1e-3)
    guess = estimate(parse_plan(PLAN.replace("10 mm", "130 mm").replace("60 s", "900 s")), threads=1)
    assert (guess.whole, guess.trial_runs) == (False, 8)


def test_a_store_with_chunks_of_another_size_is_gone_on_with(tmp_path, monkeypatch):
    """As versions with other rules have left them: it keeps its chunks, and holds what a store of today holds."""
    text = PLAN.replace('duration = "60 s"', 'duration = "1 s"')
    monkeypatch.setattr(resolved, "CHUNKS", 4)
    old, design = tmp_path / "old.zarr", resolve(parse_plan(text))
    assert design.chunk_shape == (1, 11)
    seen = []

    def stopped(self, chunk, rows):
        if len(seen) == 3:
            raise KeyboardInterrupt
        seen.append(chunk)
        commit(self, chunk, rows)

    commit = Store.commit
    with monkeypatch.context() as interrupted:
        interrupted.setattr(Store, "commit", stopped)
        with pytest.raises(KeyboardInterrupt):
            sweep(parse_plan(text), out=old)
    monkeypatch.undo()
    assert resolve(parse_plan(text)).chunk_shape == (1, 8)
    begun = []
    found = sweep(parse_plan(text), out=old, progress=lambda p: begun.append(p.found))
    assert begun[0] == sum(math.prod(design.extent(chunk)) for chunk in seen)
    anew = sweep(parse_plan(text), out=tmp_path / "new.zarr")
    xarray.testing.assert_identical(found.load(), anew.load())


def test_a_store_goes_on_with_the_method_that_it_was_begun_with(done, tmp_path):
    """Also one that does not name it: from before there were leaps, so of direct steps."""
    direct = 'method = "direct"\n' + PLAN
    store, whole = tmp_path / "s.zarr", sweep(parse_plan(direct), out=tmp_path / "whole.zarr").load()
    assert not np.array_equal(whole["gain"], load_sweep(done)["gain"], equal_nan=True)
    copy(tmp_path / "whole.zarr", store)
    found = json.loads((store / "zarr.json").read_text(encoding="utf-8"))
    identity = json.loads(found["attributes"]["identity"])
    assert found["attributes"].pop("method") == identity.pop("method") == "direct"
    found["attributes"] |= {"identity": json.dumps(identity), "plan_hash": identity_hash(identity)}
    (store / "zarr.json").write_text(json.dumps(found), encoding="utf-8")
    (store / "checksum/c/2/0").unlink()  # a chunk that was not committed
    again = sweep(parse_plan(PLAN), out=store).load()
    for name in ("gain", "output", "attack_angle"):
        np.testing.assert_array_equal(again[name], whole[name])
    with pytest.raises(InputError, match="method is 'direct' there and 'multirevolution' here"):
        sweep(parse_plan(direct.replace("direct", "multirevolution")), out=store)
    with pytest.raises(InputError, match="method must be one of multirevolution, direct; got 'euler'"):
        parse_plan(direct.replace("direct", "euler"))


def test_chunks_of_a_store_that_do_not_lie_along_the_plan_are_damage(done, tmp_path):
    copy(done, tmp_path)
    head = tmp_path / "verdict" / "zarr.json"
    form = json.loads(head.read_text())
    form["chunk_grid"]["configuration"]["chunk_shape"] = [8]
    head.write_text(json.dumps(form))
    with pytest.raises(FileError, match="its chunks do not lie along the plan's axes"):
        sweep(parse_plan(PLAN), out=tmp_path)


def test_the_command_estimates_runs_reports_and_exports(tmp_path):
    plan = written(tmp_path / "plan.toml")
    command = [sys.executable, "-m", "helimag", "sweep", str(plan)]
    dry = subprocess.run([*command, "--dry-run"], capture_output=True, text=True, check=True)
    assert dry.stdout.startswith("62 runs; about")
    assert not (tmp_path / "s.zarr").exists()
    options = ["-o", str(tmp_path / "s.zarr"), "--json", "-o", str(tmp_path / "s.csv")]
    found = json.loads(subprocess.run([*command, *options], capture_output=True, text=True, check=True).stdout)
    assert found["runs"] == 62
    assert sum(found["counts"].values()) == 62
    assert (tmp_path / "s.csv").exists()
    bad = subprocess.run(command, capture_output=True, text=True, check=False)
    assert bad.returncode == 2
    assert "--output must name one file that ends in .zarr" in bad.stderr


def test_what_a_killed_beginning_of_a_store_left_is_removed_and_one_in_use_is_not(tmp_path):
    """Folders beside the store: of a process that was killed, of one that is making it now, and of another store."""
    left, busy, other = (tmp_path / name for name in (".s.zarr.dead.part", ".s.zarr.busy.part", ".t.zarr.dead.part"))
    for folder in (left, busy, other):
        (folder / "gain").mkdir(parents=True)
    handle = os.open(busy, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        plan = parse_plan(PLAN.replace("count = 31", "count = 2").replace('duration = "60 s"', 'duration = "1 s"'))
        helimag.sweep(plan, out=tmp_path / "s.zarr")
    finally:
        os.close(handle)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".s.zarr.busy.part", ".t.zarr.dead.part", "s.zarr"]


def test_a_spoilt_coordinate_is_noticed(done, tmp_path):
    """Coordinates have no row of checksums; a bit that is turned in one must not move a run to another input."""
    store = copy(done, tmp_path / "spoilt.zarr")
    file = store / "frequency" / "c" / "0"
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(content)
    with pytest.raises(FileError, match="is damaged"):
        helimag.load_sweep(store)


@pytest.mark.parametrize(
    ("name", "key", "value"),
    [
        ("verdict", "chunk_shape", [2, 20]),
        ("gain", "chunk_shape", [1, 1]),
        ("verdict", "chunk_shape", ["a", 1]),
        ("checksum", "shape", [1, 15]),
        ("gain", "shape", [1, 1]),
    ],
)
def test_a_store_whose_variables_lie_in_other_chunks_is_damaged_in_one_line(done, tmp_path, name, key, value):
    """Its chunks' shape is read from it, so that stores of other rules go on; nothing is written by a wrong one."""
    store = tmp_path / "s.zarr"
    copy(done, store)
    (store / "checksum" / "c" / "1" / "0").unlink()
    head = store / name / "zarr.json"
    form = json.loads(head.read_text("utf-8"))
    (form if key == "shape" else form["chunk_grid"]["configuration"])[key] = value
    head.write_text(json.dumps(form), encoding="utf-8")
    before = sweep_kills.files(store)
    with pytest.raises(FileError, match="is damaged") as refusal:
        helimag.sweep(parse_plan(PLAN), out=store)
    assert len(str(refusal.value).splitlines()) == 1
    assert sweep_kills.files(store) == before
