"""Films in and out: H.264 or MJPEG video files and folders of PNG or TIFF, frame by frame with their times."""

import csv
import itertools
import queue
import shutil
import threading
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError, InputError, MissingExtra
from helimag.vision._cv import cv2

try:
    import av
except ImportError:
    raise MissingExtra("films need PyAV; install it with: pip install 'helimag[vision]'") from None

Picture = NDArray[np.uint8]
Frame = tuple[float, Picture]

PICTURES = (".png", ".tif", ".tiff")
AHEAD = 8  # frames that a view's decoder may run ahead
COMPLETE = 0.99  # share of the frames that a file's header announces


class Film:
    """A film on disk: a video file, or a folder of numbered pictures.

    Times come, in this order, from ``NAME.times.csv`` beside a video or ``times.csv`` in a folder (one column
    ``time_s``,
    a row a frame), from the video's own time stamps, or from ``rate`` (frames a second; folders need one of the two).

    Raises
    ------
    FileError
        Where the film cannot be opened.
    InputError
        Where it has no frames or no times.
    """

    def __init__(self, path: str | Path, *, rate: float | None = None) -> None:
        self.path = Path(path)
        self.rate = rate
        if not self.path.exists():
            raise FileError(f"there is no film '{path}'; give a video file or a folder of PNG or TIFF pictures")
        self._pictures = _pictures(self.path) if self.path.is_dir() else []
        self._times = self._listed_times()
        if self.path.is_dir():
            self._check_folder()
            height, width = _read_picture(self._pictures[0]).shape
            self.size = (width, height)
            self.announced = len(self._pictures)
        else:
            with _opened(self.path) as container:
                stream = container.streams.video[0]
                self.size = (int(stream.codec_context.width), int(stream.codec_context.height))
                self.announced = int(stream.frames)
                self.start = int(stream.start_time or 0)
                self.time_base = Fraction(stream.time_base)
                self.duration_units = int(stream.duration or 0)
            if min(self.size) < 1:
                raise InputError(f"{self.path} holds no picture")

    def _listed_times(self) -> list[float] | None:
        beside = self.path / "times.csv" if self.path.is_dir() else self.path.with_suffix(".times.csv")
        return read_times(beside) if beside.exists() else None

    def _check_folder(self) -> None:
        if not self._pictures:
            raise InputError(f"{self.path} holds no PNG or TIFF picture")
        if self._times is None and self.rate is None:
            raise InputError(f"{self.path} has no times.csv; add one, or give the frames a second with --rate")
        if self._times is not None and len(self._times) != len(self._pictures):
            raise InputError(
                f"{self.path / 'times.csv'} must have a row a picture: it has {len(self._times)}, "
                f"and there are {len(self._pictures)} pictures"
            )

    def frames(self) -> Iterator[Frame]:
        """Each frame with its time (s), decoded when it is asked for.

        Raises
        ------
        FileError
            Where the film breaks off or cannot be decoded.
        """
        if self._pictures:
            for index, file in enumerate(self._pictures):
                picture = _read_picture(file)
                if picture.shape != (self.size[1], self.size[0]):
                    raise FileError(f"{file} is of another size than the pictures before it")
                yield self._time(index), picture
            return
        count = 0
        try:
            with _opened(self.path) as container:
                for frame in container.decode(video=0):
                    yield self._time(count, frame), _gray(frame)
                    count += 1
        except av.error.FFmpegError as error:
            raise FileError(f"{self.path} cannot be decoded after {count} frames: {error.strerror}") from None
        if count == 0:
            raise FileError(f"{self.path} holds no frame that can be decoded")
        if count < COMPLETE * self.announced:
            raise FileError(
                f"{self.path} is cut off: its header announces {self.announced} frames, and {count} can be decoded"
            )

    def sample(self, count: int) -> list[Picture]:
        """About ``count`` frames spread over the film, for the background; each decoded on its own."""
        if self._pictures:
            chosen = np.unique(np.linspace(0, len(self._pictures) - 1, count).astype(int))
            return [_read_picture(self._pictures[i]) for i in chosen]
        pictures = []
        try:
            with _opened(self.path) as container:
                stream = container.streams.video[0]
                if self.duration_units <= 0 or self.announced <= 2 * count:
                    stride = max(1, self.announced // count)
                    return [_gray(f) for i, f in enumerate(container.decode(stream)) if i % stride == 0]
                for place in np.linspace(0.0, 0.98, count):
                    container.seek(self.start + int(place * self.duration_units), stream=stream)
                    pictures.append(_gray(next(container.decode(stream))))
        except (av.error.FFmpegError, StopIteration) as error:
            reason = getattr(error, "strerror", None) or "it breaks off"
            raise FileError(f"{self.path} cannot be decoded: {reason}") from None
        return pictures

    def _time(self, index: int, frame: Any = None) -> float:
        if self._times is not None:
            if index >= len(self._times):
                raise FileError(f"{self.path} has more frames than its list of times has rows ({len(self._times)})")
            return self._times[index]
        if self.rate is not None:
            return index / self.rate
        if frame is None or frame.pts is None:
            raise InputError(f"{self.path} has no time stamps; give the frames a second with --rate")
        return float(frame.pts * frame.time_base)


def _opened(path: Path) -> Any:
    try:
        if path.stat().st_size == 0:
            raise FileError(f"{path} is empty")
        container = av.open(str(path))
    except av.error.FFmpegError as error:
        raise FileError(f"{path} cannot be opened as a video: {error.strerror}; it may be cut off") from None
    if not container.streams.video:
        container.close()
        raise FileError(f"{path} holds no video")
    container.streams.video[0].thread_type = "NONE"
    return container


def _gray(frame: Any) -> Picture:
    """Brightness of a frame, black at 0: (height, width)."""
    if frame.format.name not in ("yuv420p", "yuvj420p", "gray", "yuvj422p", "yuv422p", "yuvj444p"):
        return np.asarray(frame.to_ndarray(format="gray"))
    plane = frame.planes[0]
    picture = np.frombuffer(plane, np.uint8).reshape(frame.height, plane.line_size)[:, : frame.width]
    full = frame.format.name.startswith("yuvj") or frame.format.name == "gray" or frame.color_range == 2
    return picture if full else np.asarray(cv2.LUT(picture, _FULL_RANGE))


_FULL_RANGE = np.clip((np.arange(256) - 16) * 255.0 / 219.0 + 0.5, 0, 255).astype(np.uint8)


def _pictures(folder: Path) -> list[Path]:
    return sorted(
        file for file in folder.iterdir() if file.suffix.lower() in PICTURES and not file.name.startswith(".")
    )


def _read_picture(file: Path) -> Picture:
    picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH)
    if picture is None:
        raise FileError(f"{file} cannot be read as a picture")
    if picture.dtype == np.uint16:
        picture = (picture // 257).astype(np.uint8)
    return np.asarray(picture, dtype=np.uint8)


def read_times(path: Path) -> list[float]:
    """Times (s) of a film's frames: the column ``time_s`` of a CSV file.

    Raises
    ------
    InputError
        Where there is no such column, or the times do not rise.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            times = [float(row["time_s"]) for row in csv.DictReader(file)]
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{path} must have a column time_s with one number a row") from None
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror}") from None
    if not all(later > earlier for earlier, later in itertools.pairwise(times)):
        raise InputError(f"{path} must have times that rise from row to row")
    return times


def ahead(frames: Iterator[Frame]) -> Iterator[Frame]:
    """The same frames, decoded in a thread of their own a few frames ahead."""
    waiting: queue.Queue[Frame | BaseException | None] = queue.Queue(AHEAD)
    stopped = threading.Event()

    def put(item: Frame | BaseException | None) -> bool:
        while not stopped.is_set():
            try:
                waiting.put(item, timeout=0.2)
                return True
            except queue.Full:
                continue
        return False

    def work() -> None:
        try:
            if all(put(frame) for frame in frames):
                put(None)
        except BaseException as error:  # noqa: BLE001  handed to the consumer, who raises it
            put(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    try:
        while (item := waiting.get()) is not None:
            if isinstance(item, BaseException):
                raise item
            yield item
    finally:
        stopped.set()
        thread.join()


class FilmWriter:
    """Writes a film: .mp4 (H.264), .avi (MJPEG), or a folder of .png or .tiff pictures; renamed when complete.

    Parameters
    ----------
    path
        Of the film; a folder is named by ``path`` with the pictures' kind in ``pictures``.
    size
        Width and height (px).
    colour
        Whether frames are (height, width, 3) RGB instead of gray.
    quality
        H.264 rate factor: lower is better.
    """

    def __init__(
        self,
        path: str | Path,
        size: tuple[int, int],
        *,
        pictures: str | None = None,
        colour: bool = False,
        quality: int = 20,
        rate: float = 30.0,
    ) -> None:
        self.path = Path(path)
        self.pictures = pictures
        self.colour = colour
        self.times: list[float] = []
        self.rate = Fraction(rate).limit_denominator(1001)
        self.beside = self.path.with_name(f".part.{self.path.name}")
        if pictures is not None:
            shutil.rmtree(self.beside, ignore_errors=True)
            try:
                self.beside.mkdir(parents=True)
            except OSError as error:
                raise FileError(f"{path} cannot be written: {error.strerror}") from None
            return
        kinds: dict[str, tuple[str, dict[str, str], str]] = {
            ".mp4": ("libx264", {"crf": str(quality), "preset": "ultrafast", "g": "60"}, "yuv420p"),
            ".avi": ("mjpeg", {"qmin": "2", "qmax": "5"}, "yuvj420p"),
        }
        if self.path.suffix not in kinds:
            raise InputError(f"a film must be .mp4 (H.264) or .avi (MJPEG); got '{path}'")
        codec, options, pixels = kinds[self.path.suffix]
        try:
            self.container = av.open(str(self.beside), "w", format=self.path.suffix[1:])
        except (av.error.FFmpegError, OSError) as error:
            raise FileError(f"{path} cannot be written: {error.strerror}") from None
        self.stream = cast(Any, self.container).add_stream(codec, rate=self.rate, options=options)
        self.stream.width, self.stream.height = size
        self.stream.pix_fmt = pixels
        if self.path.suffix == ".mp4":
            self.stream.codec_context.time_base = Fraction(1, 90000)

    def write(self, picture: Picture, time: float) -> None:
        """Append a frame taken at a time (s), which must not be negative: players would leave it out."""
        if time < 0.0:
            raise InputError(f"a frame's time must not be negative; got {time} s")
        if self.pictures is not None:
            name = f"{len(self.times):06d}{self.pictures}"
            if not cv2.imwrite(str(self.beside / name), picture):
                raise FileError(f"{self.path / name} cannot be written")
        else:
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24" if self.colour else "gray")
            if self.path.suffix == ".mp4":
                frame.pts, frame.time_base = round(time * 90000), Fraction(1, 90000)
            else:
                frame.pts, frame.time_base = len(self.times), 1 / self.rate
            self.container.mux(self.stream.encode(frame))
        self.times.append(time)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if self.pictures is None:
            if kind is None:
                self.container.mux(self.stream.encode())
            self.container.close()
        if kind is not None:
            shutil.rmtree(self.beside, ignore_errors=True)
            self.beside.unlink(missing_ok=True)
            return
        if self.pictures is not None:
            write_times(self.beside / "times.csv", self.times)
            shutil.rmtree(self.path, ignore_errors=True)
        self.beside.replace(self.path)
        if self.pictures is None and self.path.suffix == ".avi":
            write_times(self.path.with_suffix(".times.csv"), self.times)


def write_times(path: Path, times: Sequence[float]) -> None:
    """Write the times (s) of a film's frames as CSV."""
    path.write_text("time_s\n" + "".join(f"{time:.6f}\n" for time in times), encoding="utf-8")


def together(
    first: Iterator[Frame], second: Iterator[Frame], watch: Callable[[float], None] | None = None
) -> Iterator[tuple[int, float, Picture]]:
    """Frames of two films in the order of their times: (0 or 1, time, picture)."""
    sources = (first, second)
    waiting: list[Frame | None] = [next(first, None), next(second, None)]
    while any(frame is not None for frame in waiting):
        which = min((i for i in (0, 1) if waiting[i] is not None), key=lambda i: waiting[i][0])  # type: ignore[index]
        time, picture = waiting[which]  # type: ignore[misc]
        if watch is not None:
            watch(time)
        yield which, time, picture
        waiting[which] = next(sources[which], None)
