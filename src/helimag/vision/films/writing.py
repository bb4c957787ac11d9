"""Films out: H.264 or MJPEG video files and folders of PNG or TIFF; beside first, renamed when complete."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from pathlib import Path
from typing import Any, Self, cast

import numpy as np

from helimag.errors import FileError, InputError
from helimag.vision._cv import cv2
from helimag.vision.films._av import av
from helimag.vision.films.pictures import Picture
from helimag.vision.films.times import write_times

TIMESCALE = 90_000  # units of time a second
DEEP = {10: "yuv420p10le"}  # pixel formats of H.264 by bits


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
    bits
        A pixel: 8, in a folder up to 16, in .mp4 8 or 10.
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
        bits: int = 8,
    ) -> None:
        self.path = Path(path)
        self.kind = self.path.suffix.lower()
        self.pictures = pictures
        self.colour = colour
        self.bits = bits
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
            ".mp4": ("libx264", {"crf": str(quality), "preset": "ultrafast", "g": "60"}, DEEP.get(bits, "yuv420p")),
            ".avi": ("mjpeg", {"qmin": "2", "qmax": "5"}, "yuvj420p"),
        }
        if self.kind not in kinds:
            raise InputError(f"a film must be .mp4 (H.264) or .avi (MJPEG); got '{path}'")
        codec, options, pixels = kinds[self.kind]
        with self._failing():
            # an .mp4 rounds the time of its first frame to the film's own units, which are 1 ms unless told otherwise
            fine = {"movie_timescale": str(TIMESCALE)} if self.kind == ".mp4" else {}
            self.container = av.open(str(self.beside), "w", format=self.kind[1:], options=fine)
        self.stream = cast(Any, self.container).add_stream(codec, rate=self.rate, options=options)
        self.stream.width, self.stream.height = size
        self.stream.pix_fmt = pixels
        if self.kind == ".mp4":
            self.stream.codec_context.time_base = Fraction(1, TIMESCALE)

    def write(self, picture: Picture, time: float) -> None:
        """Append a frame taken at a time (s), which must not be negative: players would leave it out."""
        if time < 0.0:
            raise InputError(f"a frame's time must not be negative; got {time} s")
        if self.pictures is not None:
            name = f"{len(self.times):06d}{self.pictures}"
            deep = picture if self.bits == 8 else picture.astype(np.uint16) << (self.bits - 8)
            if not cv2.imwrite(str(self.beside / name), deep):
                raise FileError(f"{self.path / name} cannot be written")
        else:
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24" if self.colour else "gray")
            if self.kind == ".mp4":
                frame.pts, frame.time_base = round(time * TIMESCALE), Fraction(1, TIMESCALE)
            else:
                frame.pts, frame.time_base = len(self.times), 1 / self.rate
            with self._failing():
                self.container.mux(self.stream.encode(frame))
        self.times.append(time)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        try:
            if kind is None:
                self._finish()
            elif self.pictures is None:
                with suppress(FileError), self._failing():  # what was raised before says why
                    self.container.close()
        finally:
            shutil.rmtree(self.beside, ignore_errors=True)
            self.beside.unlink(missing_ok=True)

    def _finish(self) -> None:
        """Write what is left, and put the film in its place."""
        with self._failing():
            if self.pictures is None:
                try:
                    self.container.mux(self.stream.encode())
                finally:
                    self.container.close()
            else:
                write_times(self.beside / "times.csv", self.times)
                shutil.rmtree(self.path, ignore_errors=True)
            self.beside.replace(self.path)
        if self.pictures is None and self.kind == ".avi":
            write_times(self.path.with_suffix(".times.csv"), self.times)

    @contextmanager
    def _failing(self) -> Iterator[None]:
        """What fails within, as an error that names the film."""
        try:
            yield
        except (av.error.FFmpegError, OSError) as error:
            raise FileError(f"{self.path} cannot be written: {error.strerror}") from None
