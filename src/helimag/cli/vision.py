"""Commands about films: vision render, calibrate, track, import."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from helimag.cli._common import PLAIN, Common
from helimag.cli._outputs import (
    CLIP,
    DATA,
    FIGURE,
    RIG,
    FigureSize,
    Folder,
    Outputs,
    check_folder,
    check_outputs,
    files_report,
    print_files,
    write_outputs,
)
from helimag.cli._shared import LARGEST_SEED, print_json, progress_bar, whole
from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.runs.trajectory import Trajectory

app = App(name="vision", help="Two cameras: render synthetic films, calibrate, track, import tracks.")


@app.command
def render(
    run: Path,
    *,
    output: Folder,
    kind: Literal["mp4", "avi", "png", "tiff"] = "mp4",
    start: str = "0 s",
    duration: str | None = None,
    dropped: float = 0.0,
    clock_offset: str = "0 s",
    reflection: float = 0.35,
    bubble: str = "0 mm",
    angle: str = "0 deg",
    bits: Annotated[int, whole(1, 64)] = 8,
    boards: Annotated[bool, Parameter(negative="--no-boards")] = True,
    seed: Annotated[int, whole(0, LARGEST_SEED)] = 0,
    common: Common = PLAIN,
) -> None:
    """Film a simulated run as two cameras would see it through the tank's walls, with the truth beside it.

    Parameters
    ----------
    run
        A trajectory file with a sample at least every 0.05 s: simulate --interval "0.02 s" -o RUN.nc.
    output
        Folder for the films, truth.nc, true-rig.json, and the pictures of the board with calibration.toml.
    kind
        H.264, MJPEG, or folders of pictures.
    start
        Of the part of the run to film.
    duration
        Of that part. Default: to the run's end.
    dropped
        Share of the frames that are lost.
    clock_offset
        How far the second camera's clock is ahead.
    reflection
        Contrast of the mirror image in the oil's surface.
    bubble
        Diameter of a bubble that crosses both views at half time.
    angle
        Between the cameras' axes and the normals of the walls.
    bits
        A pixel of the films: 8; for png and tiff up to 16, for mp4 8 or 10.
    boards
        Whether to render the pictures for a calibration too.
    seed
        Of the rig and of all that is random.
    """
    check_folder(output)
    from helimag import quantities as q
    from helimag import vision
    from helimag.runs.trajectory import Trajectory

    effects = vision.Effects(
        dropped=dropped,
        clock_offset=q.parse(clock_offset, q.TIME),
        reflection=reflection,
        bubble=q.parse(bubble, q.LENGTH),
        bits=bits,
        seed=seed,
    )
    rig = vision.paper_rig(seed=seed, angle=q.parse(angle, q.ANGLE))
    begin, length = q.parse(start, q.TIME), None if duration is None else q.parse(duration, q.TIME)
    film = Trajectory.load(run)
    with progress_bar(f"filming {run.name}") as progress:
        paths = vision.render_run(
            film, rig, output, effects=effects, kind=f".{kind}", start=begin, duration=length, progress=progress
        )
    rig.save(output / "true-rig.json")
    if boards:
        with progress_bar("photographing the board") as progress:
            paths["calibration"] = vision.render_session(rig, output, seed=seed, progress=progress)
    if common.json:
        print_json({name: str(path) for name, path in paths.items()} | files_report(paths.values()))
        return
    print(f"{run.name} as {', '.join(paths)}")
    print_files(paths.values())


@app.command
def calibrate(
    session: Path,
    *,
    output: Outputs = None,
    ignore_refraction: Annotated[bool, Parameter(negative="")] = False,
    common: Common = PLAIN,
) -> None:
    """Calibrate two cameras and the walls that they look through from pictures of a board.

    Parameters
    ----------
    session
        calibration.toml: board, tank, datum and folders of pictures.
    output
        Calibrated rig to write (.json). Without it, only report.
    ignore_refraction
        Take light to go straight. For comparison only.
    """
    import sys

    from helimag import vision

    check_outputs(output, RIG)
    with progress_bar("calibrating") as progress:
        result = vision.calibrate(vision.Session.load(session), refraction=not ignore_refraction, progress=progress)
    write_outputs(output, {RIG: result.rig.save})
    if common.json:
        print_json({**result.report, "warnings": result.warnings} | files_report(output))
        return
    _print_calibration(result.report)
    print_files(output)
    for warning in result.warnings:
        print(f"warning: {warning}", file=sys.stderr)


def _print_calibration(report: dict[str, Any]) -> None:
    for name, rms in report["intrinsics_rms_px"].items():
        joint = f", joint fit {report['joint_rms_px'][name]:.3f} px" if "joint_rms_px" in report else ""
        print(f"{name:12s}intrinsics {rms:.3f} px rms{joint}")
    for name, wall in report.get("walls", {}).items():
        print(
            f"{name:12s}wall at {wall['distance_mm']:.2f} ± {wall['distance_sd_mm']:.2f} mm, "
            f"{wall['tilt_to_camera_deg']:.2f} deg off the optical axis"
        )
    if "oil_index" in report:
        print(f"oil         index {report['oil_index']:.4f}")
    print(
        f"held out    {1e3 * report['held_out_rms_mm']:.0f} µm rms, scale within "
        f"{100 * report['held_out_scale_error']:.3f} %"
    )


@app.command
def track(
    first: Path,
    second: Path,
    *,
    rig: Path,
    gap: str | None = None,
    scenario: str | None = None,
    output: Outputs = None,
    size: FigureSize = None,
    rate: float | None = None,
    clock_offset: str | None = None,
    review: Path | None = None,
    common: Common = PLAIN,
) -> None:
    """Track the device through two films and judge the run by the same code as a simulated one.

    Parameters
    ----------
    first
        The film of the rig's first camera: .mp4, .avi, or a folder of PNG or TIFF pictures.
    second
        That of its second camera.
    rig
        What calibrate wrote.
    gap
        Height of the magnet above the device at the start, such as "102 mm": the input of the gain.
    scenario
        Preset or TOML file of the run; gives the gap and the device's shape.
    output
        Trajectory (.nc) or figure (.png, .svg, .pdf) to write. May be repeated. Without it, only judge.
    rate
        Frames a second, where the films do not say.
    clock_offset
        How far the second clock is ahead. Default: found from the films.
    review
        Clip to write (.mp4, .avi): both views with the track drawn on, and the path in space.
    """
    from helimag import quantities as q
    from helimag import vision

    check_outputs(output, DATA, FIGURE, size=size)
    clips = [] if review is None else [review]
    check_outputs(clips, CLIP, option="--review")
    for film in (first, second):
        if review is not None and review.resolve() == film.resolve():
            raise InputError(f"--review must not be one of the films; got '{review}'")
    gap_length, shape, toml = _known(gap, scenario)
    calibrated = vision.Rig.load(rig)
    with progress_bar("tracking") as progress:
        run = vision.track(
            first,
            second,
            calibrated,
            initial_gap=gap_length,
            shape=shape,
            clock_offset=None if clock_offset is None else q.parse(clock_offset, q.TIME),
            rate=rate,
            scenario=toml,
            name=output[0].stem if output else f"{first.stem} and {second.stem}",
            progress=progress,
        )
    _write(run, output, size)
    if review is not None:
        with progress_bar("drawing the clip") as progress:
            vision.review(run, first, second, calibrated, review, shape=shape, rate=rate, progress=progress)
    _tell(run, output, common.json, clips)


@app.command(name="import")
def import_(track: Path, *, gap: str, output: Outputs = None, size: FigureSize = None, common: Common = PLAIN) -> None:
    """Make a trajectory of a track from another tool, and judge it.

    Parameters
    ----------
    track
        CSV with the columns time, x, y, z and, where known, attack_angle, x_sd, y_sd, z_sd; each head names its
        unit: x [mm].
    gap
        Height of the magnet above the device at the start, such as "102 mm".
    output
        Trajectory (.nc) or figure (.png, .svg, .pdf) to write. May be repeated. Without it, only judge.
    """
    from helimag import quantities as q
    from helimag.runs.imported import import_track

    check_outputs(output, DATA, FIGURE, size=size)
    run = import_track(track, initial_gap=q.parse(gap, q.LENGTH))
    _write(run, output, size)
    if not common.json:
        print(run.dataset.attrs["source"])
    _tell(run, output, common.json)


def _known(gap: str | None, scenario: str | None) -> tuple[float, Any, str | None]:
    """Initial gap (m), shape and text of the scenario, from the options that were given."""
    from helimag import quantities as q

    if scenario is None:
        if gap is None:
            raise InputError("--gap or --scenario must be given: the gain needs the height of the magnet at the start")
        return q.parse(gap, q.LENGTH), None, None
    from helimag.engine import initial_gap
    from helimag.scenario import load
    from helimag.vision import Shape

    known = load(scenario)
    length = initial_gap(known) if gap is None else q.parse(gap, q.LENGTH)
    return length, Shape.of(known.device), known.to_toml()


def _write(run: "Trajectory", output: list[Path] | None, size: FigureSize) -> None:
    from helimag.cli.runs import run_writers

    write_outputs(output, run_writers(run), size=size)


def _tell(run: "Trajectory", output: list[Path] | None, json: bool, beside: list[Path] | None = None) -> None:
    import sys

    from helimag.runs import interval_text
    from helimag.runs.measurement import report

    numbers = report(run)
    written = [*(output or ()), *(beside or ())]
    if json:
        print_json(numbers | files_report(written))
        return
    extent = interval_text(numbers["output_y_95_m"], 3, per=1e3, unit=" mm")
    print(f"{run.dataset.attrs['name']}: {numbers['verdict']}, {numbers['reason']}")
    print(f"  gain          {numbers['gain']:.4f}, {interval_text(numbers['gain_95'], 4)}")
    print(f"  |y|           {1e3 * numbers['output_y_m']:.3f} mm, {extent}")
    if "attack_angle_deg" in numbers:
        print(
            f"  attack angle  {numbers['attack_angle_deg']:.2f} deg, wobble {numbers['wobble_deg']:.2f} deg "
            f"(second half)"
        )
    lost = sum(until - begin for begin, until, _ in numbers["gaps"])
    print(f"  samples       {numbers['samples']}, {len(numbers['gaps'])} gaps, {lost:.2f} s together")
    for begin, until, reason in [gap for gap in numbers["gaps"] if gap[1] - gap[0] > 0.5][:8]:
        print(f"    gap         {begin:.2f} s to {until:.2f} s: {reason}")
    print_files(written)
    for warning in numbers["warnings"]:
        print(f"warning: {warning}", file=sys.stderr)
