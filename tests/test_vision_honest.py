"""Vision that knows when it does not know: oblique rigs, spoilt calibrations, depths, uncertainties, other programs."""

import json
import resource
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

pytest.importorskip("cv2")
pytest.importorskip("av")

import av
import cv2

from helimag.errors import FileError, InputError
from helimag.runs import Trajectory, import_track
from helimag.runs.measurement import attack_windows
from helimag.runs.smoothing import sharpened, smooth
from helimag.vision import (
    Board,
    Calibration,
    Effects,
    Film,
    FilmWriter,
    Rig,
    Session,
    Shape,
    calibrate,
    paper_rig,
    render_run,
    render_session,
    staged,
    track,
)
from helimag.vision.calibration.lenses import read_lens
from helimag.vision.calibration.shared_errors import excess, widening
from helimag.vision.silhouette import outline, silhouette
from helimag.vision.tracking.alignment import _mean_sd
from helimag.vision.tracking.assembly import _Joined, _spread
from helimag.vision.tracking.detection import blobs, measure
from helimag.vision.tracking.drawings import Errors, _roll
from helimag.vision.tracking.noise import frame_noise, turning
from helimag.vision.tracking.search import Sighting
from helimag.vision.tracking.uncertainty import taken_away
from helimag.vision.tracking.views import RETURNING, PreparedView, returning

ANGLE = np.radians(25.0)
SEED = 2


@pytest.fixture(scope="module")
def true_rig() -> Rig:
    return paper_rig(seed=SEED, angle=ANGLE)


@pytest.fixture(scope="module")
def session(true_rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return render_session(true_rig, tmp_path_factory.mktemp("session"), seed=SEED, own=6, shared=3, oil=8)


@pytest.fixture(scope="module")
def calibration(session: Path) -> Calibration:
    return calibrate(Session.load(session))


def test_oblique_cameras_stand_as_asked(true_rig: Rig) -> None:
    for camera in true_rig.cameras:
        assert camera.wall is not None
        angle = np.degrees(np.arccos(camera.rotation[2] @ camera.wall.normal))
        assert angle == pytest.approx(25.0, abs=2.0)
        assert np.all(np.isfinite(camera.project(np.array([[0.0, 0.0, 0.0], [0.16, 0.0, 0.0]]))))
    with pytest.raises(InputError, match="angle must be from 0 to"):
        paper_rig(angle=1.2)


def test_oblique_cameras_calibrate_and_say_how_well(calibration: Calibration, true_rig: Rig) -> None:
    points = np.random.default_rng(0).uniform([0.02, -0.02, -0.035], [0.14, 0.02, 0.002], (200, 3))
    found, _ = calibration.rig.triangulate(*(camera.project(points) for camera in true_rig.cameras))
    off = np.linalg.norm(found - points, axis=1)
    assert off.max() < 0.012e-3
    assert calibration.report["position_sd_mm"] < 0.004
    assert max(calibration.report["joint_rms_px"].values()) < 0.02
    assert calibration.report["oil_index"] == pytest.approx(1.40, abs=2e-3)
    shifts = calibration.rig.shifts(found)
    covariance = np.einsum("kni,knj->nij", shifts, shifts)
    chi = np.einsum("ni,nij,nj->n", found - points, np.linalg.inv(covariance), found - points)
    assert 0.1 < chi.mean() < 9.0  # one rig: its error is common to all points


def spoilt(change: Callable[[dict[str, Any]], None]) -> Callable[[Path], None]:
    def edit(folder: Path) -> None:
        data = tomllib.loads((folder / "calibration.toml").read_text())
        change(data)
        (folder / "calibration.toml").write_text(tomli_w.dumps(data))

    return edit


def swapped(*media: str) -> Callable[[Path], None]:
    def edit(folder: Path) -> None:
        for medium in media:
            (folder / medium / "front").rename(folder / medium / "other")
            (folder / medium / "below").rename(folder / medium / "front")
            (folder / medium / "other").rename(folder / medium / "below")

    return edit


def few(medium: str, kept: int) -> Callable[[Path], None]:
    def edit(folder: Path) -> None:
        for view in ("front", "below"):
            for file in sorted((folder / medium / view).glob("*.png"))[kept:]:
                file.unlink()

    return edit


def move_tank(data: dict[str, Any]) -> None:
    for end in ("low", "high"):
        data["tank"][end][1] = f"{float(data['tank'][end][1].split()[0]) + 5.0} mm"


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (
            spoilt(lambda data: data["tank"].update(indices=[1.0, 1.49, 1.47])),
            r"an oil of index 1\.(399|40).* 1\.47 is given",
        ),
        (spoilt(lambda data: data["tank"].update(indices=[1.0, 1.49, 1.385])), r"an oil of index 1\.(399|40)"),
        (spoilt(lambda data: data["board"].update(square="10 mm")), r"markers' sides are 0\.7|the pictures show it"),
        (spoilt(lambda data: data["board"].update(columns=7)), "check .board. against the printed one"),
        (spoilt(move_tank), r"the pictures show it [45]\.\d mm and"),
        (swapped("oil"), "the pictures in the tank must fit|far off"),
        (swapped("air", "oil"), "check which folder is whose"),
        (few("air", 4), "take more"),
        (few("oil", 3), "share at least one picture in air and 5 in the tank"),
        (spoilt(lambda data: data.update(accuracy="0.002 mm")), r"0\.002 mm is claimed"),
    ],
)
def test_spoilt_calibrations_are_refused(
    spoil: Callable[[Path], None], message: str, session: Path, tmp_path: Path
) -> None:
    shutil.copytree(session.parent, tmp_path / "spoilt")
    spoil(tmp_path / "spoilt")
    with pytest.raises(InputError, match=message):
        calibrate(Session.load(tmp_path / "spoilt" / "calibration.toml"))


@pytest.fixture(scope="module")
def wobbling(true_rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    run = staged("wobbling", duration=8.0, seed=SEED)
    effects = Effects(seed=SEED, clock_offset=0.1)
    return render_run(run, true_rig, tmp_path_factory.mktemp("films"), effects=effects, start=3.0, duration=1.2)


def test_oblique_runs_are_tracked_with_honest_uncertainty(wobbling: dict[str, Path], calibration: Calibration) -> None:
    run = track(wobbling["front"], wobbling["below"], calibration.rig, initial_gap=0.102)
    truth = Trajectory.load(wobbling["truth"])
    place = np.abs(truth.dataset["time"].values[None] - run.dataset["time"].values[:, None]).argmin(axis=1)
    off = run.dataset["position"].values - truth.dataset["position"].values[place]
    assert np.sqrt(np.mean(np.sum(off**2, axis=1))) < 0.04e-3
    covariance = run.dataset["position_covariance"].values
    chi = np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariance), off).mean()
    assert 0.5 < chi < 9.0  # of one run; benchmarks/vision_seeds.py has the mean over many
    angle = truth.dataset["attack_angle"].values[place]
    assert attack_windows(run, count=1).wobble[0] == pytest.approx(angle.std(), rel=0.05)
    lean = run.dataset["attack_angle"].values - angle
    assert 0.3 < np.sqrt(np.mean(lean**2)) / run.dataset["attack_angle_sd"].values.mean() < 2.5


def test_the_clock_is_told_to_a_fraction_of_a_millisecond(wobbling: dict[str, Path], true_rig: Rig) -> None:
    """The device moves by 100 px/s, and its ends are found to some hundredths of a pixel."""
    run = track(wobbling["front"], wobbling["below"], true_rig, initial_gap=0.102)
    off = abs(float(run.dataset.attrs["clock_offset"]) - 0.1)
    assert off < 0.5e-3
    assert 0.1e-3 < float(run.dataset.attrs["clock_offset_sd"]) < 0.4e-3
    assert off < 3.0 * float(run.dataset.attrs["clock_offset_sd"])


def test_films_in_the_wrong_order_are_refused(wobbling: dict[str, Path], true_rig: Rig) -> None:
    with pytest.raises(InputError, match=r"px apart|never found|never agree|in both views"):
        track(wobbling["below"], wobbling["front"], true_rig, initial_gap=0.102)


@pytest.mark.parametrize("bits", [8, 10, 12, 16])
def test_every_bit_depth_gives_the_same_pictures(bits: int, tmp_path: Path) -> None:
    picture = np.tile(np.arange(0, 250, 5, dtype=np.uint8), (40, 1))
    with FilmWriter(tmp_path / "film", (50, 40), pictures=".tiff", bits=bits) as film:
        for index in range(3):
            film.write(picture, index / 30)
    raw = cv2.imread(str(tmp_path / "film" / "000000.tiff"), cv2.IMREAD_UNCHANGED)
    assert int(raw.max()) == 245 << (bits - 8)
    assert all(np.array_equal(shown, picture) for _, shown in Film(tmp_path / "film").frames())
    (tmp_path / "film" / "000001.tiff").unlink()
    cv2.imwrite(str(tmp_path / "film" / "000001.tiff"), picture.astype(np.float32))
    with pytest.raises(InputError, match="must have pixels of 8 to 16 bits"):
        list(Film(tmp_path / "film").frames())


def test_ten_bits_of_h264_are_read(tmp_path: Path) -> None:
    with FilmWriter(tmp_path / "deep.mp4", (64, 48), bits=10) as film:
        for index in range(4):
            film.write(np.full((48, 64), 130, np.uint8), index / 30)
    shown = [picture for _, picture in Film(tmp_path / "deep.mp4").frames()]
    assert len(shown) == 4
    assert np.abs(shown[-1].astype(int) - 130).max() <= 2


@pytest.mark.parametrize("seed", range(12))
def test_noise_is_no_device_and_no_traceback(seed: int) -> None:
    """Signed weights: sums of squares may be negative, profiles may have no end."""
    random = np.random.default_rng(seed)
    for _ in range(40):
        dark = random.normal(0.0, 0.3, (60, 90)).astype(np.float32)
        if seed % 2:
            dark = cv2.GaussianBlur(dark, (0, 0), 2.0) * 4.0
        for blob in blobs(dark, 0.1, 3.0):
            seen = measure(dark, *blob, head_length=5.0, turns=4.8)
            assert seen is None or np.all(np.isfinite(seen.row[:10]))
        everything = (slice(0, 60), slice(0, 90), np.ones((60, 90), bool))
        measure(dark, *everything, head_length=5.0, turns=4.8)


def test_a_silhouette_covers_what_the_shape_covers() -> None:
    """A thick straight wire with a round end and a ball, from the side: areas in closed form."""
    camera = paper_rig(seed=0).without_refraction().cameras[0]
    shape = Shape(helix_radius=1e-9, wire_radius=0.4e-3)
    position, rotation = np.array([0.08, 0.0, -0.02]), np.eye(3)
    box = outline(camera, position[None], rotation[None], shape)
    assert box is not None
    area = silhouette(camera, position, rotation, shape, box).sum() / float(camera.scale(position[None])[0]) ** 2
    # the wire begins at the ball's rim, and both ends are round
    wire = 2.0 * 0.4e-3 * shape.helix_length + np.pi * 0.4e-3**2
    y = np.linspace(-0.36e-3, 0.36e-3, 20001)
    ball = np.sqrt(0.36e-3**2 - y**2)
    overlap = np.trapezoid(np.maximum(0.0, np.minimum(ball, 0.36e-3) - np.maximum(-ball, 0.36e-3 - 0.0)), y)
    begin = -0.36e-3 + np.sqrt(0.4e-3**2 - y**2)  # the wire's round end reaches into the ball
    overlap += np.trapezoid(np.clip(np.minimum(begin, ball) + ball, 0.0, None), y)
    assert area == pytest.approx(wire + np.pi * 0.36e-3**2 - overlap, rel=0.01)


def test_sharpened_keeps_a_swing_and_counts_its_noise() -> None:
    time = np.arange(400) / 30.0
    swing = np.sin(2.0 * np.pi * 3.5 * time)[:, None]
    once, _ = smooth(time, swing, 1.0 / 30.0)
    twice, weights = sharpened(time, swing, 1.0 / 30.0)
    inner = slice(20, -20)
    assert once[inner].std() / swing[inner].std() == pytest.approx(0.982, abs=2e-3)
    assert twice[inner].std() / swing[inner].std() == pytest.approx(1.0, abs=5e-4)
    noise = np.random.default_rng(0).standard_normal((400, 300))
    left, _ = sharpened(time, noise, 1.0 / 30.0)
    assert left[inner].var() == pytest.approx(np.sum(weights[200] ** 2), rel=0.02)


def test_errors_that_a_picture_s_corners_share_widen_the_covariance_as_they_should() -> None:
    """Beside the covariance of least squares under the true errors, in closed form; independent ones widen nothing."""
    random = np.random.default_rng(3)
    pictures, rows, shared, own = 40, 20, 8, 3
    jacobian = np.zeros((pictures * rows, shared + own * pictures))
    picture = np.repeat(np.arange(pictures), rows)
    common = random.standard_normal((pictures, rows))
    jacobian[:, :shared] = random.standard_normal((pictures * rows, shared)) + 2.0 * np.repeat(
        random.standard_normal((pictures, shared)), rows, axis=0
    ) * common.reshape(-1, 1)
    for number in range(pictures):
        at = shared + own * number
        jacobian[picture == number, at : at + own] = random.standard_normal((rows, own))
    inverse = np.linalg.inv(jacobian.T @ jacobian)
    hat = jacobian @ inverse @ jacobian.T
    for strength in (0.0, 0.7):
        spread = np.kron(np.eye(pictures), np.ones((rows, rows))) * np.outer(common.ravel(), common.ravel())
        errors = np.eye(picture.size) + strength**2 * spread
        true = (inverse @ jacobian.T @ errors @ jacobian @ inverse)[:shared, :shared]
        found = []
        for _ in range(8):
            noise = random.standard_normal(picture.size)
            noise += strength * np.repeat(random.standard_normal(pictures), rows) * common.ravel()
            found.append(widening(jacobian, noise - hat @ noise, picture, shared))
        variance = np.trace(errors - hat @ errors) / (picture.size - jacobian.shape[1])
        due = np.trace(np.linalg.solve(inverse[:shared, :shared], true)) / shared / variance
        assert np.mean(found) == pytest.approx(due, rel=0.2)
        assert due == pytest.approx(1.0) if strength == 0.0 else due > 2.0


def test_a_datum_seen_badly_is_less_certain() -> None:
    random = np.random.default_rng(4)
    jacobian = random.standard_normal((4000, 6))
    noise = 2.0 * random.standard_normal(4000)
    taken = jacobian @ np.linalg.lstsq(jacobian, noise, rcond=None)[0]
    more = excess(jacobian, noise - taken, 1.0)
    assert np.diag(more) == pytest.approx(3.0 / 4000.0, rel=0.2)
    assert not excess(jacobian, (noise - taken) / 3.0, 1.0).any()


def test_legacy_boards_calibrate_and_plain_ones_are_named(tmp_path: Path) -> None:
    straight = paper_rig(seed=3)
    legacy = render_session(straight, tmp_path, seed=3, own=6, shared=2, oil=6, board=Board(legacy=True))
    assert calibrate(Session.load(legacy)).report["held_out_rms_mm"] < 0.05
    plain = np.kron(1 - np.indices((6, 8)).sum(0) % 2, np.ones((90, 90))).astype(np.uint8) * 255
    picture = cv2.copyMakeBorder(plain, 242, 242, 280, 280, cv2.BORDER_CONSTANT, value=200)
    for file in tmp_path.glob("*/*/*.png"):
        cv2.imwrite(str(file), picture)
    with pytest.raises(InputError, match="show a plain chessboard"):
        calibrate(Session.load(legacy))


MATRIX, BENT = np.array([[2500.0, 0.0, 640.0], [0.0, 2501.0, 512.0], [0.0, 0.0, 1.0]]), [-0.12, 0.09, 5e-4, -4e-4, 0.0]


def test_lenses_of_opencv_and_matlab_are_read(tmp_path: Path) -> None:
    from scipy.io import savemat

    storage = cv2.FileStorage(str(tmp_path / "lens.yml"), cv2.FILE_STORAGE_WRITE)
    storage.write("camera_matrix", MATRIX)
    storage.write("distortion_coefficients", np.array([BENT]))
    storage.release()
    one_based = MATRIX + np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    lens = {"RadialDistortion": BENT[:2], "TangentialDistortion": BENT[2:4]}
    (tmp_path / "new.json").write_text(json.dumps(lens | {"K": one_based.tolist()}))
    (tmp_path / "pair.json").write_text(
        json.dumps({"CameraParameters1": {}, "CameraParameters2": lens | {"IntrinsicMatrix": one_based.T.tolist()}})
    )
    savemat(tmp_path / "lens.mat", lens | {"IntrinsicMatrix": one_based.T})
    for name in ("lens.yml", "new.json", "pair.json", "lens.mat"):
        matrix, distortion = read_lens(tmp_path / name, 2)
        assert np.allclose(matrix, MATRIX, atol=1e-9), name
        assert np.allclose(distortion, BENT, atol=1e-12), name


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("ros.yaml", "camera_matrix:\n  rows: 3\n", "must be a file of OpenCV's FileStorage.* it has camera_matrix"),
        ("a.json", '{"focal": 3}', "it has focal; in MATLAB: s = toStruct"),
        ("a.json", "{", "is not JSON"),
        ("a.mat", "MATLAB", "is not a .mat file"),
        ("a.txt", "x", "must be a .yml"),
        ("a.json", '{"K": [[0,0,0]], "RadialDistortion": [0,0], "TangentialDistortion": [0,0]}', "3 x 3"),
    ],
)
def test_what_is_no_lens_is_refused(name: str, text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message):
        read_lens(tmp_path / name, 1)


def test_a_mat_file_of_version_7_3_is_named_as_such(tmp_path: Path) -> None:
    """HDF5 behind a block of 512 bytes, which begins with MATLAB's text, ends with version and byte order at 124."""
    import h5py

    with h5py.File(tmp_path / "lens.mat", "w", userblock_size=512) as file:
        file["K"] = MATRIX
    with (tmp_path / "lens.mat").open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    with pytest.raises(InputError, match=r"lens\.mat is a \.mat file of version 7\.3; save it with '-v7'"):
        read_lens(tmp_path / "lens.mat", 1)


def test_a_known_lens_needs_few_pictures_in_air(session: Path, true_rig: Rig, tmp_path: Path) -> None:
    shutil.copytree(session.parent, tmp_path / "known")
    for camera in true_rig.cameras:
        storage = cv2.FileStorage(str(tmp_path / "known" / f"{camera.name}.yml"), cv2.FILE_STORAGE_WRITE)
        storage.write("camera_matrix", camera.matrix)
        storage.write("distortion_coefficients", camera.distortion)
        storage.release()
        for file in (tmp_path / "known" / "air" / camera.name).glob(f"{camera.name}*.png"):
            file.unlink()
    spoilt(lambda data: [view.update(lens=f"{view['name']}.yml") for view in data["camera"]])(tmp_path / "known")
    known = calibrate(Session.load(tmp_path / "known" / "calibration.toml"))
    assert known.report["pictures"]["air"] == 3
    assert known.report["held_out_rms_mm"] < 0.05
    assert max(known.report["intrinsics_rms_px"].values()) < 0.2


TABLES = {
    "TrackMate": "LABEL,TRACK_ID,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T\nLabel,Track ID,X,Y,Z,T\n"
    ",,(mm),(mm),(mm),(sec)\nID1,0,1,2,-3,0.1\nID0,0,0,2,-1,0\nID2,0,2,2,-5,0.2\n",
    "Tracker": "#multi:\n,mass_A,,\nt (s),x (mm),y (mm),z (mm)\n0,0,2,-1\n0.1,1,2,-3\n0.2,2,2,-5\n",
    "MATLAB": "time_s,x_mm,y_mm,z_mm\n0,0,2,-1\n0.1,1,2,-3\n0.2,2,2,-5\n",
}


@pytest.mark.parametrize("program", TABLES)
def test_tables_of_other_programs_are_the_same_track(program: str, tmp_path: Path) -> None:
    (tmp_path / "track.csv").write_text(TABLES[program])
    run = import_track(tmp_path / "track.csv", initial_gap=0.1)
    assert np.allclose(run.dataset["position"].values, [[0, 2e-3, -1e-3], [1e-3, 2e-3, -3e-3], [2e-3, 2e-3, -5e-3]])
    assert np.allclose(run.dataset["time"].values, [0.0, 0.1, 0.2])
    assert str(run.dataset.attrs["source"]).endswith(f"a table of {program}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("scorer,net,net,net\nbodyparts,head,head,head\ncoords,x,y,likelihood\n0,1,2,0.9\n1,1,2,0.9\n", "DeepLabCut"),
        (
            "scorer,net,net,net\nindividuals,a,a,a\nbodyparts,head,head,head\ncoords,x,y,likelihood\n0,1,2,0.9\n",
            "DeepLabCut",
        ),
        (
            "scorer,net,net,net\nbodyparts,head,head,head\ncoords,x,y,z\n0,1,2,3\n1,1,2,3\n",
            "DeepLabCut in space, without times and units",
        ),
        ('<?xml version="1.0"?>\n<Tracks from="TrackMate v7.11.1">\n', "an XML file and no table; of TrackMate"),
        ("pt1_X,pt1_Y,pt1_Z\n1,2,3\n2,3,4\n", r"DLTdv \(x, y, z\)"),
        ("time [s],x [m],y [m],z [m]\n0,1e300,0,0\n1,0,0,0\n", "line 2: x must be at most 100000 mm either way; got"),
        ("time [s],x [m],y [m],z [m]\n0,1,0,0\n1,0,0,-150\n", "line 3: z must be at most 100000 mm"),
        (
            "time [s],x [m],y [m],z [m],x_sd [mm],y_sd [mm],z_sd [mm]\n0,1,0,0,1,-1,1\n1,0,0,0,1,1,1\n",
            "line 2: y_sd must be not negative and at most 1000 mm; got '-1 mm'",
        ),
        ("time [s],x [m],y [m],z [m],attack_angle [deg]\n0,1,0,0,91\n1,0,0,0,1\n", "attack_angle must be at most 90"),
        ("pt1_cam1_X,pt1_cam1_Y\n1,2\n2,3\n", "DLTdv .places in the cameras' pictures"),
        (",mass_A,\nt (s),x (m),y (m)\n0,1,2\n1,1,2\n", "Tracker in a plane"),
        ("t,x,y,z\n0,1,2,3\n1,1,2,3\n", "Tracker without units"),
        (TABLES["TrackMate"].replace("(mm)", "(pixel)"), "TrackMate in s.*pixel|TrackMate in sec, pixel"),
        (TABLES["TrackMate"].replace("ID1,0,", "ID1,7,"), "must hold one track"),
    ],
)
def test_other_programs_tables_that_are_no_track_are_named(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "track.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        import_track(tmp_path / "track.csv", initial_gap=0.1)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_roll_of_drawings_is_told_by_terms_and_how_well(sense: float) -> None:
    """Rolls off by a wave twice a turn and by tilt, and a zero that moves with blur: found; a wave thrice is not."""
    phase = 2.0 * np.pi * (np.arange(32) * 0.618034 % 1.0)
    tilt = np.sin(np.arange(32) * 2.4)
    told = sense * phase + 0.03 * np.cos(2 * phase) + 0.1 * tilt
    rolls = told + 0.02 * np.cos(3.0 * phase)
    tables = [np.stack([rolls + zero, phase, phase, tilt], axis=1) for zero in (3.10, 3.10 + 0.20)]
    found_sense, terms, roll_sd = _roll(tables, 0.25)
    errors = Errors(np.zeros((8, 4)), np.zeros(4), found_sense, terms, roll_sd)
    rows = np.full((32, 13), np.nan)
    rows[:, 10], rows[:, 11] = np.cos(phase), np.sin(phase)
    off = np.angle(np.exp(1j * (errors.rolls(rows, tilt) - told - 3.15)))
    assert found_sense == sense
    assert np.abs(off).max() < 0.012
    # eight terms of 32 drawings take a quarter of the scatter's variance; the rest tells it
    assert roll_sd == pytest.approx(0.02 / np.sqrt(2.0) * np.sqrt(8 / 32), rel=0.15)


def test_pictures_come_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    """Names without leading zeros: 10.tif comes after 9.tif."""
    for number in range(1, 13):
        cv2.imwrite(str(tmp_path / f"run_{number}.tif"), np.full((8, 8), 10 * number, np.uint8))
    assert [int(picture[0, 0]) for _, picture in Film(tmp_path, rate=30.0).frames()] == list(range(10, 130, 10))


def test_a_stack_and_a_broken_picture_are_refused_in_one_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    cv2.imwritemulti(str(tmp_path / "stack.tif"), [np.full((8, 8), 10, np.uint8)] * 3)
    with pytest.raises(InputError, match=r"stack\.tif is a picture or a stack of them, and no film"):
        Film(tmp_path / "stack.tif", rate=30.0)
    (tmp_path / "film").mkdir()
    (tmp_path / "film" / "0.tif").write_bytes(b"II*\0 no picture")
    with pytest.raises(FileError, match=r"0\.tif cannot be read as a picture"):
        Film(tmp_path / "film", rate=30.0)
    assert capfd.readouterr().err == ""  # OpenCV has nothing to add


def test_a_film_that_does_not_say_how_long_it_is_gives_a_few_frames_of_all(tmp_path: Path) -> None:
    """As Matroska does: not all frames are kept for the background. Brightness tells which frame one is."""
    with av.open(str(tmp_path / "film.mkv"), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"qp": "0"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for index in range(200):
            picture = np.full((48, 64), 20 + index, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="gray")))
        container.mux(stream.encode())
    film = Film(tmp_path / "film.mkv")
    assert film.announced == 0
    shown = np.array([float(np.mean(picture)) - 20.0 for picture in film.sample(8)])
    assert 8 <= shown.size < 16
    assert np.diff(shown) == pytest.approx(16.0, abs=1.5)
    assert shown[0] < 2.0
    assert shown[-1] > 180.0


@pytest.mark.parametrize("start", [0.0, 0.01233, 0.371234])
def test_an_mp4_keeps_the_times_of_its_frames(start: float, tmp_path: Path) -> None:
    """Within half a unit of 1/90000 s; with the usual movie timescale the first frame's time is rounded to 1 ms."""
    times = start + np.arange(6) / 30.0
    with FilmWriter(tmp_path / "film.mp4", (64, 48)) as film:
        for time in times:
            film.write(np.full((48, 64), 130, np.uint8), float(time))
    read = np.array([time for time, _ in Film(tmp_path / "film.mp4").frames()])
    assert np.abs(read - times).max() < 6e-6


def test_films_say_whether_their_frames_are_predicted(tmp_path: Path) -> None:
    for name, kind in (("a.mp4", None), ("a.avi", None), ("a", ".png")):
        with FilmWriter(tmp_path / name, (64, 48), pictures=kind) as film:
            for index in range(4):
                film.write(np.full((48, 64), 130, np.uint8), index / 30)
    assert [Film(tmp_path / name).predicted for name in ("a.mp4", "a.avi", "a")] == [True, False, False]


@pytest.mark.parametrize("rate_factor", [14, 32])
def test_uncertainty_follows_the_compression(
    rate_factor: int, wobbling: dict[str, Path], true_rig: Rig, tmp_path: Path
) -> None:
    """The same film compressed less and more: heights are off by 2 and 6 um or so, and as much is claimed."""
    films = []
    for name in ("front", "below"):
        source = Film(wobbling[name])
        films.append(tmp_path / f"{name}.mp4")
        with FilmWriter(films[-1], source.size, quality=rate_factor) as film:
            for time, picture in source.frames():
                film.write(picture, time)
    run = track(films[0], films[1], true_rig, initial_gap=0.102)
    truth = Trajectory.load(wobbling["truth"])
    place = np.abs(truth.dataset["time"].values[None] - run.dataset["time"].values[:, None]).argmin(axis=1)
    off = (run.dataset["position"].values - truth.dataset["position"].values[place])[:, 2]
    claimed = np.sqrt(run.dataset["position_covariance"].values[:, 2, 2].mean())
    assert 0.4 < np.sqrt(np.mean(off**2)) / claimed < 1.7
    assert bool(claimed > 4e-6) is (rate_factor > 20)


def test_noise_of_a_swinging_device_is_its_noise() -> None:
    """A swing at 3.5 Hz with lost frames around: the noise found is what was added, not what a polynomial misses."""
    random = np.random.default_rng(0)
    time = np.arange(150) / 30.0
    time = time[random.uniform(size=150) > 0.06]
    rows = np.ones((time.size, 13))
    swing = 2.0 * np.pi * 3.5 * time
    rows[:, 10], rows[:, 11] = np.cos(swing), np.sin(swing)
    rows[:, 0] = 100.0 * time + 0.02 * random.standard_normal(time.size)
    rows[:, 1] = 4.0 * np.sin(swing) + 0.02 * random.standard_normal(time.size)
    rows[:, 2], rows[:, 3] = 45.0, 5.0 * np.cos(swing) + 0.03 * random.standard_normal(time.size)
    found = frame_noise(time, rows, 1.0 / 30.0)
    assert found[1] == pytest.approx(0.02, rel=0.3)
    assert found[3] == pytest.approx(0.03, rel=0.3)


def test_the_turn_is_told_from_the_coil_with_frames_lost_and_a_wobble() -> None:
    """Phases swing by 0.2 rad with the turn, as a wobbling device's do; a device that does not turn has no rate."""
    time = np.delete(np.arange(60) / 30.0, [7, 20, 21, 40])
    turn = 2.0 * np.pi * 3.5 * time
    rows = np.ones((time.size, 13))
    phase = 1.0 - turn + 0.2 * np.sin(turn)
    rows[:, 10], rows[:, 11] = np.cos(phase), np.sin(phase)
    assert turning(time, rows, 1.0 / 30.0) == pytest.approx(-2.0 * np.pi * 3.5, rel=2e-3)
    assert turning(time, np.ones((time.size, 13)), 1.0 / 30.0) == pytest.approx(0.0, abs=1e-12)


def test_what_prediction_leaves_out_returns_unless_the_device_swings_across() -> None:
    """Straight on: all of it. Across by 0.05 px: as good as all; by 3 px: a third, and along as before."""
    time = np.arange(90) / 30.0
    rows = np.ones((time.size, 13))
    rows[:, 2], rows[:, 3] = 45.0, 0.0
    fresh = np.full(4, 0.01)
    found = []
    for swing in (0.0, 0.05, 3.0):
        rows[:, 0], rows[:, 1] = 100.0 * time, 20.0 * time + np.sqrt(2.0) * swing * np.sin(2.0 * np.pi * 3.5 * time)
        found.append(returning(rows, fresh))
    assert found[0] == pytest.approx(RETURNING * 0.01, rel=1e-6)
    assert found[1] == pytest.approx(found[0], rel=2e-3)
    assert found[2][[0, 2]] == pytest.approx(found[0][[0, 2]])
    assert found[2][[1, 3]] == pytest.approx(found[0][[1, 3]] / np.sqrt(10.0), rel=0.25)  # a mean over 1.3 turns


def test_a_clock_that_is_off_turns_a_swinging_device() -> None:
    """What the second view's numbers move by in a standard deviation of the clock, from the swing's own speed."""
    time = np.arange(40) / 30.0
    rate, sd, lag = 2.0 * np.pi * 1.5, 2e-3, 0.01
    lean = 0.1 * np.sin(rate * time)
    rows = np.zeros((time.size, 13))
    rows[:, 0], rows[:, 1] = 100.0 * time, 3.0 * lean
    rows[:, 2], rows[:, 3] = 45.0 * np.cos(lean), 45.0 * np.sin(lean)
    one, two = (PreparedView(Sighting(time + late, rows), np.zeros(4), np.zeros(4), None) for late in (0.0, 0.01))
    views = (one, two)
    frames = np.arange(5, 35)
    joined = _Joined(frames, (rows[frames], rows[frames]), None, 0.0, 1.0, frames)  # type: ignore[arg-type]
    clock = sd * _spread(joined, views, lag).clock
    speed = 0.1 * rate * np.cos(rate * time[frames])
    assert not clock[:, :4].any()
    assert clock[:, 7] == pytest.approx(45.0 * speed * sd, rel=0.01, abs=1e-4)
    across = 3.0 * speed * np.cos(lean[frames]) - 100.0 * np.sin(lean[frames])
    assert clock[:, 5] == pytest.approx(across * sd, rel=0.01, abs=1e-4)
    along = 100.0 * np.cos(lean[frames]) + 3.0 * speed * np.sin(lean[frames])
    assert clock[:, 4] == pytest.approx(along * sd, rel=0.01, abs=1e-4)
    assert clock[:, 6] == pytest.approx(along * sd, rel=0.01, abs=1e-4)


def test_what_smoothing_takes_from_a_motion_counts_where_noise_does_not_explain_it() -> None:
    random = np.random.default_rng(1)
    rest, due = 0.1 * random.standard_normal((300, 2)), np.full((300, 2), 0.01)
    assert np.mean(taken_away(rest, due) > 0.0) < 0.01
    rest[100:110, 1] += 0.8 * (-1.0) ** np.arange(10)
    lost = taken_away(rest, due)
    assert lost[102:108, 1] == pytest.approx(0.64, rel=0.7)
    assert not lost[:, 0].any()


def test_the_mean_of_turns_forgets_what_returns() -> None:
    """A wave once a turn does not make the mean uncertain; noise does, by its root over the frames' number."""
    time = np.arange(240) / 30.0
    wave = 0.3 * np.sin(2.0 * np.pi * 3.5 * time)
    noise = 0.05 * np.random.default_rng(2).standard_normal(240)
    assert _mean_sd(wave + noise, time, 2.0 * np.pi * 3.5) == pytest.approx(0.05 / np.sqrt(240), rel=0.5)


@pytest.mark.parametrize(("name", "frames"), [("film.mp4", 3), ("film.mp4", 60), ("film.avi", 60)])
def test_a_film_that_the_disk_has_no_room_for_leaves_nothing(tmp_path, name, frames):
    """As it is written, or in the end, when an encoder gives what it has held back."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    noise = np.random.default_rng(0).integers(0, 255, (frames, 240, 320), dtype=np.uint8)

    def filmed():
        with FilmWriter(tmp_path / name, (320, 240)) as film:
            for number, picture in enumerate(noise):
                film.write(picture, number / 30.0)

    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        with pytest.raises(FileError, match="cannot be written"):
            filmed()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert list(tmp_path.iterdir()) == []
