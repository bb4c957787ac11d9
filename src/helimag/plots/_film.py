"""A run as a film."""

from collections.abc import Callable, Iterable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError, InputError, MissingExtra
from helimag.files import replacing
from helimag.plots._quantities import Shown, shown
from helimag.plots._scene import FILM, HEIGHT, WIDTH, Scene, enlargement
from helimag.plots._style import styled
from helimag.runs.trajectory import Trajectory

Floats = NDArray[np.float64]

SECONDS = 12.0
FRAMES_PER_SECOND = 25
SLOW_TURNS = 0.25  # turns a second of film at which a magnet too fast for the film seems to turn


def animate(trajectory: Trajectory, path: str | Path, *, progress: Callable[[float], None] | None = None) -> None:
    """Write a film of a run: magnet, field at the device, device, path and height; 12 s whatever the run's length.

    Where the magnet turns too fast for the film, frames are chosen among the samples so that it seems to turn slowly,
    as under a stroboscope, and the film says so.

    Parameters
    ----------
    trajectory
        The run; what it does not hold is left out.
    path
        Ends in .mp4 (H.264).
    progress
        Called with the fraction done.

    Raises
    ------
    InputError
        Where the suffix is another, or the run has nothing that can be drawn.
    FileError
        Where the file cannot be written; nothing is left behind.
    MissingExtra
        Where PyAV is not installed.
    """
    if Path(path).suffix.lower() != ".mp4":
        raise InputError(f"a film's file must end in .mp4; got '{path}'")
    report = progress or (lambda _: None)
    run = shown(trajectory)
    samples = chosen_samples(run, round(SECONDS * FRAMES_PER_SECOND))
    with replacing(path) as beside, styled(), mpl.rc_context(FILM):
        scene = Scene(trajectory, remark(run))
        pictures = _reported((scene.frame(sample) for sample in samples), len(samples), report)
        _encode(pictures, beside, path)


def check_filming() -> None:
    """Refuse films where they cannot be made.

    Raises
    ------
    MissingExtra
        Where PyAV is not installed.
    """
    try:
        import av  # noqa: F401
    except ImportError:
        raise MissingExtra.of("filming", "av", "plots") from None


def _reported(
    pictures: Iterable[NDArray[np.uint8]], count: int, report: Callable[[float], None]
) -> Iterable[NDArray[np.uint8]]:
    for done, picture in enumerate(pictures, 1):
        yield picture
        report(done / count)


def chosen_samples(run: Shown, count: int) -> NDArray[np.int64]:
    """Samples to show, one a frame, evenly over the run; in each frame's share of time the one whose magnet suits best.

    The last frame is the last sample. A run with fewer samples than frames shows some of them more than once.
    """
    edges = np.linspace(run.time[0], run.time[-1], count + 1)
    whole = np.flatnonzero(np.isfinite(run.position).all(axis=1))
    times = run.time[whole]
    first = np.searchsorted(times, edges[:-1])
    past = np.searchsorted(times, edges[1:])
    chosen = np.clip(first, 0, whole.size - 1)
    if run.scenario is not None and strobed(run):
        turns = np.mod(run.scenario.drive.frequency * times, 1.0)
        for frame in np.flatnonzero(past - first > 1):
            wanted = SLOW_TURNS * frame / FRAMES_PER_SECOND
            off = np.abs(np.mod(turns[first[frame] : past[frame]] - wanted + 0.5, 1.0) - 0.5)
            chosen[frame] = first[frame] + int(np.argmin(off))
    chosen[-1] = whole.size - 1
    return whole[chosen]


def strobed(run: Shown) -> bool:
    """Whether the magnet turns more than a quarter turn between frames that are evenly spaced."""
    if run.scenario is None:
        return False
    frames = SECONDS * FRAMES_PER_SECOND
    return abs(run.scenario.drive.frequency) * float(run.time[-1] - run.time[0]) / frames > 0.25


def remark(run: Shown) -> str:
    """What a viewer must know so as not to be misled."""
    lines = [f"The film runs {float(run.time[-1] - run.time[0]) / SECONDS:.3g} times as fast as the device."]
    if strobed(run) and run.scenario is not None:
        lines.append(
            f"The magnet makes {abs(run.scenario.drive.frequency):g} turns a second: its turning and the device's roll "
            "are shown as under a stroboscope, single instants that seem to follow each other slowly."
        )
    scale = enlargement(run)
    if scale > 1:
        lines[0] += f" On the left the device is drawn {scale} times its size."
    if run.magnet is not None:
        lines[0] += " The magnet's north half is red."
    return "\n".join(lines)


def _encode(pictures: Iterable[NDArray[np.uint8]], beside: Path, path: str | Path) -> None:
    """Write pictures (height, width, 3) as H.264 in an MP4 container."""
    check_filming()
    import av

    try:
        with av.open(str(beside), "w", format="mp4") as container:
            stream = container.add_stream(
                "libx264", rate=FRAMES_PER_SECOND, options={"crf": "20", "preset": "veryfast"}
            )
            stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
            for picture in pictures:
                container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
            container.mux(stream.encode())
    except av.FFmpegError as error:
        raise FileError(f"{path} cannot be written: {error.strerror}") from None
