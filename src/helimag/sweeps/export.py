"""Reading a sweep's store back, and writing it as netCDF or CSV."""

import json
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from helimag.errors import FileError, InputError
from helimag.files import csv_text, replacing
from helimag.outcomes import Reason, Verdict
from helimag.runs import write_netcdf
from helimag.sweeps.compute import SCALARS, SPREAD
from helimag.sweeps.kept import check_kept_plan
from helimag.sweeps.plan import parse_plan
from helimag.sweeps.store import CHECKSUM, attributes_of, checksum

if TYPE_CHECKING:
    import xarray

NETCDF = (".nc", ".nc4", ".h5")  # which is HDF5


def load_sweep(path: str | Path) -> "xarray.Dataset":
    """Open a sweep's store, finished or not; values are read when used.

    Parameters
    ----------
    path
        The store that :func:`helimag.sweep` wrote.

    Returns
    -------
    xarray.Dataset
        Labelled, SI (angles in radians).

    Raises
    ------
    FileError
        Where it cannot be read or a chunk is damaged; the message names the file.
    """
    import xarray

    place = Path(path)
    attributes = attributes_of(place)
    check_whole(place, attributes)
    try:
        check_kept_plan(attributes)
    except InputError as error:
        raise FileError(f"{path}: {error}") from None
    with _damage(place):
        opened = xarray.open_dataset(place, engine="zarr", consolidated=False, decode_timedelta=False)
        opened = opened.drop_vars(CHECKSUM)
        chosen = [name for name in opened.data_vars if "shown_in" in opened[name].attrs]
        opened = opened.set_coords(chosen)
        for coordinate in opened.coords.values():  # small, and under no checksum: read at once
            coordinate.load()
        _check_shapes(place, opened)
    return opened


def swept_in(dataset: "xarray.Dataset") -> "xarray.Dataset":
    """A sweep that :func:`export` wrote as netCDF, as :func:`load_sweep` gives its store.

    Returns
    -------
    xarray.Dataset
        SI, over the plan's axes.

    Raises
    ------
    InputError
        Where the dataset is none.
    """
    missing = [name for name in (*SCALARS, "verdict", "reason") if name not in dataset]
    missing += [name for name in ("plan", "scenario", "title") if not isinstance(dataset.attrs.get(name), str)]
    if missing:
        raise InputError(f"a sweep needs {', '.join(missing)}")
    check_kept_plan(dataset.attrs)
    swept = dataset.set_coords([name for name in dataset.data_vars if "shown_in" in dataset[name].attrs])
    _check_values(swept)
    return swept


def _check_values(dataset: "xarray.Dataset") -> None:
    """Refuse a sweep with values that are none, axes that are missing, or results that do not lie along them."""
    dims = dataset["verdict"].dims
    for name in (*scalar_names(dataset), "verdict", "reason"):
        if dataset[name].dims != dims or dataset[name].dtype.kind not in "fi" or not dataset[name].size:
            raise InputError(f"a sweep's {name} must lie along its axes")
    for name, kind in (("verdict", Verdict), ("reason", Reason)):
        if dataset[name].dtype.kind != "i" or not np.isin(dataset[name].values, [each.flag for each in kind]).all():
            raise InputError(f"a sweep's {name} must be one of those that helimag gives; another is there")
    along = {coordinate.attrs.get("long_name"): coordinate for coordinate in dataset.coords.values()}
    for field in (line.field for line in parse_plan(dataset.attrs["plan"]).axis):
        if field not in along:
            raise InputError(f"a sweep needs the values of {field}, along which its plan goes")
        if along[field].dtype.kind == "f" and not np.isfinite(along[field].values).all():
            raise InputError(f"a sweep's {field} must hold numbers; some are none")


@contextmanager
def _damage(path: Path) -> Iterator[None]:
    """What reading a damaged file may raise, as one line that names it."""
    try:
        yield
    except FileError:
        raise
    except FileNotFoundError as error:
        raise FileError(f"{path} is damaged: {error.filename or error} is missing") from None
    except (OSError, ValueError, KeyError, TypeError, IndexError, AttributeError, RuntimeError, OverflowError) as error:
        why = " ".join(str(error).split())[:200] or type(error).__name__
        raise FileError(f"{path} is damaged: {why}") from None


def _check_shapes(path: Path, dataset: "xarray.Dataset") -> None:
    """Raise FileError where a result does not lie along the plan's axes, or a coordinate holds what is no number."""
    dims = dataset["verdict"].dims
    for name in (*scalar_names(dataset), "verdict", "reason"):
        if dataset[name].dims != dims or dataset[name].dtype.kind not in "fi":
            raise FileError(f"{path} is damaged: {name} does not lie along the sweep's axes")
    for label, coordinate in dataset.coords.items():
        if coordinate.dtype.kind == "f" and label in dims and not np.isfinite(coordinate.values).all():
            raise FileError(f"{path} is damaged: {label} holds values that are no numbers")


def check_whole(path: Path, attributes: dict[str, object]) -> None:
    """Compare the committed chunks with their checksums; raises FileError naming the file that does not fit."""
    import zarr

    for folder in path.iterdir():
        if folder.is_dir():  # zarr passes over an array without a readable head
            with _damage(folder / "zarr.json"):
                json.loads((folder / "zarr.json").read_text(encoding="utf-8"))["shape"]
    with _damage(path / CHECKSUM):
        sums = np.asarray(zarr.open_array(path / CHECKSUM, mode="r")[:])
    with _damage(path):
        names = str(attributes["checksum_files"]).split()
    grids = {}
    for name in names:
        with _damage(path / name / "zarr.json"):
            grids[name] = _chunk_files(path / name, len(sums))
    if sums.ndim != 2 or sums.shape[1] != len(names) or any(len(grid) != len(sums) for grid in grids.values()):
        raise FileError(f"{path} is damaged: its chunks are not those of its plan")
    for chunk in np.flatnonzero(sums.any(axis=1)):
        for name, expected in zip(names, sums[chunk], strict=True):
            file = grids[name][chunk]
            if not file.exists() or checksum(file) != int(expected):
                raise FileError(
                    f"{file} is {'damaged' if file.exists() else 'missing'}; remove "
                    f"{path / CHECKSUM / 'c' / str(chunk)} and run the sweep again: this chunk alone is computed anew"
                )


def _chunk_files(array: Path, count: int) -> list[Path]:
    """Files of an array's chunks, in the order of the sweep's chunks."""
    form = json.loads((array / "zarr.json").read_text(encoding="utf-8"))
    steps = [
        -(-n // size) for n, size in zip(form["shape"], form["chunk_grid"]["configuration"]["chunk_shape"], strict=True)
    ]
    return [array.joinpath("c", *map(str, index)) for index in np.ndindex(*steps)][:count]


def axis_names(dataset: "xarray.Dataset") -> list[str]:
    """Names of the coordinates that a sweep runs through, in the plan's order."""
    along = set(dataset["verdict"].dims)
    names = [str(n) for n, c in dataset.coords.items() if c.dims and set(c.dims) <= along and c.attrs.get("long_name")]
    order = [line.field for line in parse_plan(dataset.attrs["plan"]).axis]
    return sorted(names, key=lambda name: order.index(dataset[name].attrs["long_name"]))


def scalar_names(dataset: "xarray.Dataset") -> list[str]:
    """Names of the numbers that a sweep holds of each point: those of devices only where it ran some."""
    return [*SCALARS, *(SPREAD if next(iter(SPREAD)) in dataset else ())]


def counts(dataset: "xarray.Dataset") -> dict[str, int]:
    """How many runs of each verdict, what failed and what is missing included."""
    found = Counter(dataset["verdict"].values.ravel().tolist())
    return {str(verdict): found[verdict.flag] for verdict in Verdict if found[verdict.flag]}


def export(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write a sweep as ``.nc`` (netCDF) or ``.csv`` (one line a run, SI, angles in radians).

    Raises
    ------
    FileError
        Where the file cannot be written; nothing is left behind.
    InputError
        Where the name says neither.
    """
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in (*NETCDF, ".csv"):
        raise InputError(f"a sweep is exported to a file ending in .nc or .csv; got '{path}'")
    if kind in NETCDF:
        write_netcdf(dataset.drop_encoding(), target)
        return
    with replacing(target) as beside:
        _write_csv(dataset, beside)


def _write_csv(dataset: "xarray.Dataset", path: Path) -> None:
    """One line a computed run: axes, verdict and reason as words, scalars, the scenario's hash."""
    axes = axis_names(dataset)
    shape = dataset["verdict"]
    columns = {name: dataset[name].broadcast_like(shape).transpose(*shape.dims).values.ravel() for name in axes}
    columns |= {name: dataset[name].values.ravel() for name in scalar_names(dataset)}
    words = {
        name: dataset[name].attrs["flag_meanings"].split() for name in axes if "flag_meanings" in dataset[name].attrs
    }
    flags, reasons = shape.values.ravel(), dataset["reason"].values.ravel()
    hashes = dataset["scenario_hash"].values.reshape(flags.size, -1)
    units = {name: dataset[name].attrs.get("units", "1") for name in columns}
    rows: list[list[object]] = [
        [*(f"{name} ({units[name]})" for name in columns), "verdict", "reason", "scenario_hash"]
    ]
    for i in np.flatnonzero(flags != Verdict.NOT_COMPUTED):
        cells = [words[name][values[i]] if name in words else _cell(values[i]) for name, values in columns.items()]
        found = [str(Verdict.of(flags[i])), str(Reason.of(reasons[i])), hashes[i].tobytes().hex()]
        rows.append([*cells, *found])
    path.write_text(csv_text(rows), encoding="utf-8")


def _cell(value: float) -> float | None:
    return None if np.isnan(value) else float(value)
