"""Frames of two films together, decoded ahead of their use."""

import queue
import threading
from collections.abc import Callable, Iterator

from helimag.vision.films.pictures import Picture
from helimag.vision.films.reading import Frame

AHEAD = 8  # frames that a view's decoder may run ahead


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
