"""Damaged netCDF files of runs: read as what they say, or refused in a line; never an exception of a library's."""

import copy
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import helimag as hm
from helimag.runs import write_netcdf
from helimag.vision import Rig, paper_rig

RUN = hm.Trajectory.from_arrays(
    np.arange(5.0),
    {"position": np.ones((5, 3)), "quaternion": np.tile([1.0, 0.0, 0.0, 0.0], (5, 1)), "slips": np.zeros(5)},
    {"name": "run", "source": "simulated", "initial_gap": 0.1, "end": "horizon"},
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.nc"
    RUN.save(path)
    return path


@given(
    flips=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=20),
    keep=st.floats(0.0, 1.0) | st.none(),
)
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
def test_damaged_bytes(whole, flips, keep):
    content = bytearray(whole.read_bytes())
    for place, value in flips:
        content[place % len(content)] = value
    damaged = whole.with_name("damaged.nc")
    damaged.write_bytes(content[: None if keep is None else int(keep * len(content))])
    try:
        run = hm.Trajectory.load(damaged)
    except hm.HelimagError as error:
        assert str(damaged) in str(error)  # noqa: PT017
    else:
        assert np.isfinite(run.dataset["position"].values).all()


def test_no_changed_byte_passes(whole):
    """A file that HDF5 reads as other numbers, or over which it sits for ever, is refused by its checksum."""
    content = whole.read_bytes()
    damaged = whole.with_name("damaged.nc")
    for place in range(0, len(content) - 80, 211):
        damaged.write_bytes(content[:place] + bytes([content[place] ^ 0x10]) + content[place + 1 :])
        with pytest.raises(hm.HelimagError, match=r"damaged\.nc is damaged: its content does not have the checksum"):
            hm.Trajectory.load(damaged)
    damaged.write_bytes(content[:-7])
    with pytest.raises(hm.HelimagError, match="is damaged"):
        hm.Trajectory.load(damaged)


def test_what_other_programs_wrote_has_no_checksum_and_others_read_what_has_one(whole, tmp_path):
    import h5py

    with h5py.File(whole) as file:
        assert np.array_equal(file["position"][:], np.ones((5, 3)))
    (tmp_path / "plain.nc").write_bytes(whole.read_bytes()[:-80])
    assert hm.Trajectory.load(tmp_path / "plain.nc").dataset.equals(RUN.dataset)


def test_what_other_programs_change_or_add_is_read(whole, tmp_path):
    """HDF5 cuts the checksum off when it writes."""
    import h5py
    import xarray

    path = tmp_path / "changed.nc"
    path.write_bytes(whole.read_bytes())
    with h5py.File(path, "r+") as file:
        file["position"][0] = 2.0
    xarray.Dataset({"remark": ("time", np.arange(5.0))}).to_netcdf(path, mode="a", engine="h5netcdf")
    found = hm.Trajectory.load(path).dataset
    assert found["position"].values[:2].tolist() == [[2.0] * 3, [1.0] * 3]
    assert found["remark"].values.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_a_clock_whose_offset_is_not_known_is_read(tmp_path):
    """Tracks without a clock's offset say so by -1."""
    write_netcdf(RUN.dataset.assign_attrs(source="measured", clock_offset_sd=-1.0), tmp_path / "a.nc")
    assert hm.Trajectory.load(tmp_path / "a.nc").attributes["clock_offset_sd"] == -1.0


def stated(dataset, name, units):
    """The same numbers, said to be in other units."""
    dataset = dataset.copy()
    dataset[name].attrs = {"units": units}
    return dataset


def test_a_run_in_milliseconds_is_not_read_as_one_in_seconds(tmp_path):
    """Ten seconds that another program has written in ms came out as ten thousand, and bounded."""
    run = hm.simulate(hm.load("nose-first/fig3c"), duration=5.0).dataset
    milliseconds = stated(run.assign_coords(time=1e3 * run["time"]), "time", "ms")
    write_netcdf(milliseconds, tmp_path / "ms.nc")
    with pytest.raises(hm.HelimagError, match="time must be in s; its units are 'ms'"):
        hm.Trajectory.load(tmp_path / "ms.nc")
    for units in ("second", "sec", "s"):
        write_netcdf(stated(run, "time", units), tmp_path / "s.nc")
        assert str(hm.Trajectory.load(tmp_path / "s.nc").verdict) == "undecided"


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda d: d.assign_attrs(initial_gap=np.nan), "initial_gap must be a finite number"),
        (lambda d: d.assign_attrs(initial_gap="wide"), "initial_gap must be a finite number"),
        (lambda d: d.assign_attrs(end="soon"), "end must be one of"),
        (lambda d: d.drop_vars("position"), "needs position"),
        (lambda d: d.isel(axis=[0, 1]), "3 entries along axis"),
        (lambda d: d.assign(slips=("axis", np.zeros(3))), "slips must have the dimensions time"),
        (lambda d: d.assign_coords(time=np.zeros(5)), "time must hold finite seconds"),
        (lambda d: d.isel(time=[]), "time must hold finite seconds"),
        (lambda d: d.assign(position=d["position"] * np.nan), "position must be known"),
        (lambda d: d.assign(quaternion=d["quaternion"] * 2.0), "length 1"),
        (lambda d: d.assign(slips=d["slips"] + 1e300), "sensible numbers"),
        (lambda d: d.assign_attrs(fold_time="long"), "fold_time must be a finite number above 0; got 'long'"),
        (lambda d: d.assign_attrs(lap_time=np.nan), "lap_time must be a finite number above 0; got nan"),
        (lambda d: d.assign_attrs(fold_time=-143.0), "fold_time must be a finite number above 0; got -143.0"),
        (lambda d: d.assign_attrs(initial_gap=1e-300), "sensible height of the magnet above the device"),
        (lambda d: d.assign_attrs(initial_gap=1e300), "initial_gap must be a finite number"),
        (lambda d: d.assign_attrs(film_end="late"), "film_end must be a finite number"),
        (lambda d: stated(d, "position", "mm"), "position must be in m; its units are 'mm'"),
        (lambda d: stated(d, "time", "ms"), "time must be in s; its units are 'ms'"),
        (lambda d: stated(d, "slips", "turn"), "slips must be in 1; its units are 'turn'"),
        (lambda d: d.isel(axis=[2, 1, 0]), "axis must be labelled x, y, z; got z, y, x"),
        (lambda d: d.isel(component=[1, 2, 3, 0]), "component must be labelled w, x, y, z; got x, y, z, w"),
        (lambda d: d.assign(slips=d["slips"] * np.nan).assign_attrs(source="imported"), "slips must be known at every"),
        (
            lambda d: d.assign(height_low=("time", np.ones(5)), height_high=("time", np.zeros(5))),
            "height_low must be below height_mean",
        ),
    ],
)
def test_what_no_run_can_be_is_refused(tmp_path, spoil, words):
    write_netcdf(spoil(RUN.dataset), tmp_path / "a.nc")
    with pytest.raises(hm.HelimagError, match=words):
        hm.Trajectory.load(tmp_path / "a.nc")


# what numbers of a file may be changed to
WILD = [None, -1, 1e308, 1e-320, float("nan"), float("inf"), "x", [], {}, [[1.0]], 10**400]


def places(content, path=()):
    """Where something stands in nested JSON."""
    entries = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    for key, value in entries:
        yield (*path, key)
        yield from places(value, (*path, key))


def changed(content, path, value):
    new = copy.deepcopy(content)
    at = new
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return new


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    path = tmp_path_factory.mktemp("rig") / "rig.json"
    paper_rig(seed=1).save(path)
    return path


def test_no_changed_number_of_a_rig_passes(rig, tmp_path):
    """By its checksum; and without one, what no cameras and no tank can be is refused all the same."""
    content = json.loads(rig.read_text())
    plain = {key: value for key, value in content.items() if key != "sha256"}
    target = tmp_path / "changed.json"
    target.write_text(json.dumps(plain))
    assert Rig.load(target).cameras[0].size == Rig.load(rig).cameras[0].size
    for path in places(plain):
        target.write_text(json.dumps(changed(content, path, 1.25)))
        with pytest.raises(hm.InputError, match="changed since; who means that takes its sha256 out"):
            Rig.load(target)
        if path[0] in {"notes", "variants"} or path[-1] in {"name", "wall"}:
            continue
        for value in WILD:
            target.write_text(json.dumps(changed(plain, path, value)))
            try:
                Rig.load(target)
            except hm.InputError as error:
                assert str(error).startswith(f"{target} is not a calibrated pair of cameras")  # noqa: PT017
            else:
                assert value in {-1, 1e-320} if isinstance(value, float | int) else False, (path, value)


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("cameras", 0, "rotation", 0, 0), 0.5, "camera 'front': rotation must be a turn"),
        (("cameras", 1, "matrix_px", 0, 0), -800.0, "matrix_px must be"),
        (("cameras", 0, "wall", "indices", 2), 14.7, "wall.indices must be between 1 and 3; got 14.7"),
        (("cameras", 0, "wall", "thickness_m"), 4.0, "wall.thickness_m must be up to 1 m"),
        (("cameras", 0, "size_px", 1), 0, "size_px must be between 1 and 100000"),
        (("tank_m", 0, 0), 0.9, "tank_m must be its lowest and its highest corner"),
        (("accuracy_m",), -1e-4, "accuracy_m must be between 0 and 1 m"),
    ],
)
def test_what_no_rig_can_be_is_named(rig, tmp_path, path, value, words):
    content = json.loads(rig.read_text())
    del content["sha256"]
    (tmp_path / "a.json").write_text(json.dumps(changed(content, path, value)))
    with pytest.raises(hm.InputError, match=words):
        Rig.load(tmp_path / "a.json")
