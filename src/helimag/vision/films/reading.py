"""Films in: video files and folders of PNG or TIFF, frame by frame with their times."""

import re
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from helimag.errors import FileError, InputError
from helimag.vision.films._av import av
from helimag.vision.films.pictures import Picture, bits_of, eight_bits, gray, read_raw
from helimag.vision.films.times import read_times

Frame = tuple[float, Picture]

_PARTS = re.compile(r"(\d+)")
PICTURES = (".png", ".tif", ".tiff")
TOLD = 8  # pictures of a folder that tell how many bits it has
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
        if self.path.is_file() and self.path.suffix.lower() in PICTURES:
            raise InputError(
                f"{self.path} is a picture or a stack of them, and no film; give a folder of PNG or TIFF pictures, one "
                f"a frame"
            )
        self._pictures = _pictures(self.path) if self.path.is_dir() else []
        self._times = self._listed_times()
        self.predicted = False  # from one another, with loss, as H.264 does and MJPEG does not
        if self.path.is_dir():
            self._check_folder()
            self.bits = self._check_depth()
            height, width = read_raw(self._pictures[0]).shape
            self.size = (width, height)
            self.announced = len(self._pictures)
        else:
            with _opened(self.path) as container:
                stream = container.streams.video[0]
                self.size = (int(stream.codec_context.width), int(stream.codec_context.height))
                self.announced = int(stream.frames)
                codec = stream.codec_context.codec
                self.predicted = bool(codec.lossy and not codec.intra_only)
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

    def _check_depth(self) -> int:
        chosen = np.unique(np.linspace(0, len(self._pictures) - 1, TOLD).astype(int))
        return bits_of([read_raw(self._pictures[i]) for i in chosen])

    def frames(self) -> Iterator[Frame]:
        """Each frame with its time (s), decoded when it is asked for.

        Yields
        ------
        tuple of float and ndarray
            The time, and the picture (height, width) in 8 bits.

        Raises
        ------
        FileError
            Where the film breaks off or cannot be decoded.
        """
        if self._pictures:
            for index, file in enumerate(self._pictures):
                picture = eight_bits(read_raw(file), self.bits)
                if picture.shape != (self.size[1], self.size[0]):
                    raise FileError(f"{file} is of another size than the pictures before it")
                yield self._time(index), picture
            return
        count = 0
        try:
            with _opened(self.path) as container:
                for frame in container.decode(video=0):
                    yield self._time(count, frame), gray(frame)
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
            return [eight_bits(read_raw(self._pictures[i]), self.bits) for i in chosen]
        pictures = []
        try:
            with _opened(self.path) as container:
                stream = container.streams.video[0]
                if self.duration_units <= 0 or self.announced <= 2 * count:
                    return _spread((gray(frame) for frame in container.decode(stream)), count)
                known: set[int] = set()
                for place in np.linspace(0.0, 0.98, count):
                    wanted = self.start + int(place * self.duration_units)
                    container.seek(wanted, stream=stream)
                    frames = container.decode(stream)
                    frame = next(frames)
                    # a film of few key frames would show a few frames many times: go on to the one that is wanted
                    while frame.pts in known and frame.pts < wanted and (later := next(frames, None)) is not None:
                        frame = later
                    known.add(frame.pts)
                    pictures.append(gray(frame))
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


def _spread(pictures: Iterator[Picture], count: int) -> list[Picture]:
    """``count`` pictures or up to twice as many, evenly out of a stream of any length; no more are ever held."""
    kept: list[Picture] = []
    stride = 1
    for index, picture in enumerate(pictures):
        if index % stride == 0:
            kept.append(picture)
        if len(kept) == 2 * count:
            kept, stride = kept[::2], 2 * stride
    return kept


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


def _pictures(folder: Path) -> list[Path]:
    """In the order of the numbers in their names: 2.png comes before 10.png."""
    files = [file for file in folder.iterdir() if file.suffix.lower() in PICTURES and not file.name.startswith(".")]
    return sorted(files, key=lambda file: [int(part) if part.isdecimal() else part for part in _PARTS.split(file.name)])
