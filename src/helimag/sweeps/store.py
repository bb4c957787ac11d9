"""The store of a sweep: one zarr dataset, committed chunk by chunk, checked by checksums.

A chunk of runs is one zarr chunk of each variable. Its files are written one by one, each beside and then renamed; last
comes its row of ``checksum``, which commits it. A chunk without that row does not count and is computed again.
"""

import asyncio
import contextlib
import hashlib
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from helimag.errors import FileError, InputError, MissingExtra
from helimag.outcomes import Reason, Verdict, cf_flags
from helimag.runs.trajectory import versions
from helimag.scenario import Input
from helimag.sweeps.cautions import sweep_cautions
from helimag.sweeps.compute import HASH_BYTES, Kept, Rows
from helimag.sweeps.kept import identity_hash
from helimag.sweeps.resolved import ResolvedPlan

if TYPE_CHECKING:
    import xarray

CHECKSUM = "checksum"
FURTHER = ("byte", "axis", "component", "chunk", "file")  # dimensions beside the plan's own and time
UNFINISHED = "*.partial"  # what zarr calls a file until it is whole
MADE_BY = ("helimag", "warp-lang")  # whose versions decide the numbers


class Store:
    """An open store; use :meth:`opened`."""

    def __init__(self, path: Path, resolved: ResolvedPlan) -> None:
        import zarr

        self.path = path
        self.resolved = resolved
        self.names = [name for name in variables(resolved) if name != CHECKSUM]
        always: Any = {"write_empty_chunks": True}  # so that a file that is not there is known to be lost
        try:
            self._arrays = {
                name: zarr.open_array(path / name, mode="r+").with_config(always) for name in (*self.names, CHECKSUM)
            }
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RuntimeError) as error:
            why = " ".join(str(error).split())[:200]
            raise FileError(f"{path} is damaged: {why}") from None
        self._check_chunks()
        self.done: set[int] = {chunk for chunk in range(len(resolved.chunks)) if self._is_committed(chunk)}

    def _check_chunks(self) -> None:
        """Raise FileError where a variable does not lie in the chunks of the verdicts, or they have no checksums."""
        lengths, grid = tuple(self.resolved.shape.values()), self.resolved.chunk_shape
        for name in self.names:
            array = self._arrays[name]
            if (array.shape[: len(lengths)], array.chunks[: len(grid)]) != (lengths, grid):
                raise FileError(f"{self.path} is damaged: {name} and verdict do not lie in the same chunks of the plan")
        if self._arrays[CHECKSUM].shape != (len(self.resolved.chunks), len(self.names)):
            raise FileError(f"{self.path} is damaged: {CHECKSUM} has not a row for each of its chunks")

    @classmethod
    @contextmanager
    def opened(cls, path: Path, resolved: ResolvedPlan) -> Iterator[Self]:
        """Open the store of a plan, making it where there is none; only one process at a time may have it.

        Raises
        ------
        FileError
            Where it cannot be made, read or written, is in use, or a committed chunk is damaged.
        InputError
            Where it belongs to another plan, or to other versions.
        """
        _needs_zarr()
        if not path.exists():
            _create(path, resolved)
        resolved = replace(resolved, method=resolved.plan.method or _method(path))
        check_same_plan(path, resolved)
        with _locked(path):
            store = cls(path, replace(resolved, chunking=_chunking(path, resolved)))
            if len(store.done) < len(store.resolved.chunks):
                _check_writable(path)
                for rest in path.rglob(UNFINISHED):
                    rest.unlink()
            yield store

    def commit(self, chunk: int, rows: Rows) -> None:
        """Write a chunk's rows (runs first) and, when all are on file, its checksums."""
        extent = self.resolved.extent(chunk)
        shaped = {name: rows[name].reshape(*extent, *rows[name].shape[1:]) for name in self.names}
        self._write(chunk, self.resolved.block(chunk), shaped)
        sums = np.array([[checksum(self._file(name, chunk)) for name in self.names]], np.uint64)
        self._write(chunk, (slice(chunk, chunk + 1),), {CHECKSUM: sums})
        self.done.add(chunk)

    def read(self, chunk: int, name: str) -> NDArray[np.generic]:
        """A variable of a committed chunk, runs first."""
        values = np.asarray(self._arrays[name][self.resolved.block(chunk)])
        return values.reshape(-1, *values.shape[len(self.resolved.shape) :])

    def _write(self, chunk: int, where: tuple[slice, ...], values: Rows) -> None:
        """Write a chunk of some variables at once: one after the other, most of the time goes into waiting for each."""
        from zarr.core.sync import sync

        async def written() -> list[BaseException | None]:
            writes = [self._arrays[name].async_array.setitem(where, each) for name, each in values.items()]
            return await asyncio.gather(*writes, return_exceptions=True)

        for name, failure in zip(values, sync(written()), strict=True):
            if isinstance(failure, OSError):
                raise FileError(
                    f"{self._file(name, chunk)} cannot be written: {failure.strerror or failure}; what was committed "
                    "is unharmed: remove the cause and run the same command again"
                )
            if failure is not None:
                raise failure

    def _is_committed(self, chunk: int) -> bool:
        """Whether a chunk is whole on file; damage raises."""
        file = self._file(CHECKSUM, chunk)
        if not file.exists():
            return False
        damaged = file
        try:
            sums = np.asarray(self._arrays[CHECKSUM][chunk])
            for name, expected in zip(self.names, sums, strict=True):
                damaged = self._file(name, chunk)
                if checksum(damaged) != int(expected):
                    raise ValueError("its checksum does not match")
        except FileNotFoundError:
            raise FileError(f"{damaged} is missing; {_remedy(file)}") from None
        except (ValueError, RuntimeError, OSError) as error:
            raise FileError(f"{damaged} is damaged: {error}; {_remedy(file)}") from None
        return True

    def _file(self, name: str, chunk: int) -> Path:
        """Where zarr keeps a chunk of a variable."""
        if name == CHECKSUM:
            return self.path / name / "c" / str(chunk) / "0"
        index = self.resolved.chunks[chunk]
        further = self._arrays[name].ndim - len(index)  # which no chunk divides
        return self.path.joinpath(name, "c", *map(str, (*index, *([0] * further))))


def _chunking(path: Path, resolved: ResolvedPlan) -> tuple[int, ...]:
    """Runs of a chunk of a store along each dimension."""
    try:
        head = json.loads((path / "verdict" / "zarr.json").read_text(encoding="utf-8"))
        found = tuple(int(size) for size in head["chunk_grid"]["configuration"]["chunk_shape"])
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise FileError(f"{path / 'verdict' / 'zarr.json'} is damaged: {error}") from None
    if len(found) != len(resolved.shape) or min(found) < 1:
        raise FileError(f"{path / 'verdict' / 'zarr.json'} is damaged: its chunks do not lie along the plan's axes")
    return found


def checksum(file: Path) -> int:
    """First 8 bytes of a file's SHA-256."""
    return int.from_bytes(hashlib.sha256(file.read_bytes()).digest()[:8])


def _remedy(file: Path) -> str:
    return f"remove {file} and run the same command again: this chunk alone is computed anew"


def kept_of(resolved: ResolvedPlan) -> Kept:
    """How a plan's points are run, and what is kept of them."""
    return Kept(sample_times(resolved), resolved.devices, resolved.method)


def sample_times(resolved: ResolvedPlan) -> NDArray[np.float64] | None:
    """When trajectories are kept (s); None where they are not."""
    interval: float | None = resolved.plan.trajectory
    if interval is None:
        return None
    times = np.arange(math.floor(resolved.longest / interval * (1.0 + 1e-12)) + 1) * interval
    return np.asarray(times, dtype=np.float64)


def variables(resolved: ResolvedPlan) -> dict[str, tuple[tuple[str, ...], Any, Any, dict[str, object]]]:
    """Every array that is written on the way: dimensions, type, fill value, attributes."""
    dims = tuple(resolved.shape)
    found: dict[str, tuple[tuple[str, ...], Any, Any, dict[str, object]]] = {}
    for name, (unit, meaning) in Kept(devices=resolved.devices).scalars.items():
        found[name] = (dims, np.float64, np.nan, {"units": unit, "long_name": meaning})
    for name, flags in (("verdict", cf_flags(Verdict)), ("reason", cf_flags(Reason))):
        found[name] = (dims, np.int8, 0, {"long_name": name, **flags})
    digest: dict[str, object] = {"long_name": "SHA-256 of the scenario, byte by byte", "units": "1"}
    found["scenario_hash"] = ((*dims, "byte"), np.uint8, 0, digest)
    if resolved.plan.trajectory is not None:
        place: dict[str, object] = {"units": "m", "long_name": "centre of the head, lab frame; none after the end"}
        turn: dict[str, object] = {
            "units": "1",
            "long_name": "rotation from body to lab (w, x, y, z); none after the end",
        }
        found["position"] = ((*dims, "time", "axis"), np.float64, np.nan, place)
        found["quaternion"] = ((*dims, "time", "component"), np.float64, np.nan, turn)
    for axis in resolved.axes:
        if not axis.values:
            found[axis.name] = (("point",), np.float64, np.nan, axis_attributes(axis.field, axis.kind))
    meaning = "first 8 bytes of the SHA-256 of each chunk's files, by variable; none where not committed"
    found[CHECKSUM] = (("chunk", "file"), np.uint64, 0, {"long_name": meaning})
    return found


def flag_attributes(meanings: list[str]) -> dict[str, object]:
    """CF attributes of a flag variable with values 0, 1, ..."""
    return {"flag_values": list(range(len(meanings))), "flag_meanings": " ".join(meanings)}


def axis_attributes(field: str, kind: Any) -> dict[str, object]:
    return {"units": kind.si if kind else "1", "long_name": field, "shown_in": kind.shown if kind else "1"}


def _coordinates(resolved: ResolvedPlan) -> dict[str, Any]:
    """Axes with values, and the drive's other inputs as single numbers."""
    found: dict[str, Any] = {}
    for axis in resolved.axes:
        if axis.values and isinstance(axis.values[0], str):
            words = sorted({str(value) for value in axis.values})
            codes = np.array([words.index(str(value)) for value in axis.values], np.int8)
            flags = flag_attributes([word.replace(" ", "_") for word in words])
            found[axis.name] = (axis.dimension, codes, {"long_name": axis.field, **flags})
        elif axis.values:
            found[axis.name] = (axis.dimension, np.array(axis.values, float), axis_attributes(axis.field, axis.kind))
    swept = {axis.name for axis in resolved.axes}
    for given in (Input(f"drive.{name}") for name in ("frequency", "pitch", "distance", "yaw_rate", "speed")):
        if given.label not in swept:
            found[given.label] = (
                (),
                given.value(resolved.base),
                axis_attributes(given.path, given.kind(resolved.base)),
            )
    times = sample_times(resolved)
    if times is not None:
        found["time"] = ("time", times, {"units": "s", "long_name": "time since the start"})
    return found


def check_names(resolved: ResolvedPlan) -> None:
    """Raise InputError where a dimension that the plan names has the name of something else in the store."""
    named = [axis for axis in resolved.axes if axis.bounds is None]  # the others lie along the dimension of points
    own = {axis.name for axis in named if axis.name == axis.dimension}
    taken = {*variables(resolved), *_coordinates(resolved), *FURTHER, "time", "point"} - own
    for axis in named:
        if axis.dimension != axis.name and axis.dimension in taken:
            raise InputError(
                f"axis '{axis.field}': zip must not be '{axis.dimension}', which a sweep's result has already; "
                "choose another name"
            )


def _template(resolved: ResolvedPlan) -> "xarray.Dataset":
    """The dataset without results."""
    import xarray

    times = sample_times(resolved)
    lengths = {
        **resolved.shape,
        "byte": HASH_BYTES,
        "axis": 3,
        "component": 4,
        "time": 0 if times is None else times.size,
    }
    lengths |= {"chunk": len(resolved.chunks), "file": len(variables(resolved)) - 1}
    data = {
        name: (dims, np.broadcast_to(np.asarray(fill, kind), [lengths[dim] for dim in dims]), attributes)
        for name, (dims, kind, fill, attributes) in variables(resolved).items()
    }
    attributes = {
        "Conventions": "CF-1.11",
        "title": resolved.plan.name,
        "source": "simulated by helimag",
        "plan": resolved.plan.to_toml(),
        "scenario": resolved.base.to_toml(),
        "identity": json.dumps(resolved.identity, sort_keys=True),
        "plan_hash": plan_hash(resolved),
        "method": resolved.method,
        "versions": versions(),
        "validity_warnings": json.dumps([caution.as_dict() for caution in sweep_cautions(resolved)]),
        "checksum_files": " ".join(name for name in variables(resolved) if name != CHECKSUM),
    }
    return xarray.Dataset(data, _coordinates(resolved), attributes)


def plan_hash(resolved: ResolvedPlan) -> str:
    """SHA-256 of all that decides the runs."""
    return identity_hash(resolved.identity)


def _create(path: Path, resolved: ResolvedPlan) -> None:
    """Make an empty store beside and rename it, so that it is there as a whole or not at all."""
    from zarr.codecs import Crc32cCodec, ZstdCodec

    codecs = (ZstdCodec(level=3), Crc32cCodec())
    encoding: dict[str, Any] = {}
    for name, (dims, _, fill, _) in variables(resolved).items():
        further = {"byte": HASH_BYTES, "axis": 3, "component": 4, "chunk": 1, "file": len(variables(resolved)) - 1}
        sizes = dict(zip(resolved.shape, resolved.chunk_shape, strict=True)) | further
        times = sample_times(resolved)
        sizes["time"] = 1 if times is None else times.size
        encoding[name] = {"chunks": tuple(sizes[dim] for dim in dims), "compressors": codecs, "fill_value": fill}
        if np.isnan(float(fill)):
            encoding[name] |= {"_FillValue": fill}
            del encoding[name]["fill_value"]
    for name, (dims, values, _) in _coordinates(resolved).items():
        sized = {"chunks": np.shape(values)} if dims else {}
        encoding[name] = {"compressors": codecs, **sized}  # coordinates have no row of checksums: theirs is the codec's
    with _folder_beside(path) as beside:
        _template(resolved).to_zarr(beside, mode="w", zarr_format=3, encoding=encoding, consolidated=False)
        mask = os.umask(0)
        os.umask(mask)
        beside.chmod(0o777 & ~mask)
        beside.rename(path)


@contextmanager
def _folder_beside(path: Path) -> Iterator[Path]:
    """A new folder beside a path, gone afterwards unless renamed; those of killed processes are removed."""
    prefix, suffix = f".{path.name}.", ".part"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for left in path.parent.iterdir():
            if left.name.startswith(prefix) and left.name.endswith(suffix) and left.is_dir():
                with contextlib.suppress(FileError), _locked(left):  # in use: by a process that is making it now
                    shutil.rmtree(left, ignore_errors=True)
        beside = Path(tempfile.mkdtemp(dir=path.parent, prefix=prefix, suffix=suffix))
    except OSError as error:
        raise FileError(f"{path} cannot be made: {error.strerror}") from None
    try:
        with _locked(beside):
            yield beside
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"{path} cannot be made: {error.strerror or error}") from None
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def attributes_of(path: Path) -> dict[str, Any]:
    """A store's attributes.

    Raises
    ------
    FileError
        Where it is not a sweep's store.
    """
    try:
        found = json.loads((path / "zarr.json").read_text(encoding="utf-8"))["attributes"]
        json.loads(found["identity"])
    except FileNotFoundError:
        raise FileError(f"{path} is not a sweep's store: it has no zarr.json") from None
    except (KeyError, TypeError, ValueError):
        raise FileError(f"{path / 'zarr.json'} is damaged, or not of a sweep's store") from None
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror}") from None
    return dict(found)


def _identity(path: Path) -> dict[str, Any]:
    """All that decides the runs of a store; one that does not say by which method they are made steps them directly."""
    return {"method": "direct", **json.loads(attributes_of(path)["identity"])}


def _method(path: Path) -> str:
    """By which method the runs of a store are made."""
    return str(_identity(path)["method"])


def check_same_plan(path: Path, resolved: ResolvedPlan) -> None:
    """Raise InputError, naming the first difference, where a store belongs to another plan."""
    there, here = _identity(path), json.loads(json.dumps(resolved.identity))
    changed = [key for key in sorted({*there, *here}) if there.get(key) != here.get(key)]
    if changed:
        key, more = changed[0], f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
        raise InputError(
            f"{path} holds another plan: {key} is {there.get(key)!r} there and {here.get(key)!r} here{more}; "
            "give this plan a store of its own"
        )
    ours, theirs = json.loads(versions()), json.loads(attributes_of(path)["versions"])
    for name in MADE_BY:
        if ours[name] != theirs.get(name):
            raise InputError(
                f"{path} was begun with {name} {theirs.get(name)}, this is {ours[name]}: their results must not mix; "
                "give this plan a store of its own"
            )


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold the store against other processes; the lock ends with the process, however it ends."""
    try:
        import fcntl
    except ImportError:  # not on Windows
        yield
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FileError(f"{path} is in use by another sweep; wait for it, or give this one its own store") from None
        yield
    finally:
        os.close(handle)


def _check_writable(path: Path) -> None:
    probe = path / "probe.partial"
    try:
        probe.write_bytes(b"\0")
        probe.unlink()
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror}") from None


def _needs_zarr() -> None:
    try:
        import zarr  # noqa: F401
    except ImportError:
        raise MissingExtra.of("a sweep's store", "zarr", "sweeps") from None
