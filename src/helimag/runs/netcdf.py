"""Datasets into netCDF and out of it: a full disk or a damaged file is an error of ours, never the HDF5 library's."""

import io
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from helimag.errors import FileError
from helimag.files import bytes_of, replacing

if TYPE_CHECKING:
    import xarray

SEAL = b"\nhelimag sha256 "  # and 64 digits behind the HDF5 content: readers of HDF5 pass over what follows its end
SEALED = len(SEAL) + 64
EXPANSION = 1000  # bytes of numbers that a byte of file may hold; more, and its sizes are damaged


def write_netcdf(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write netCDF that xarray, MATLAB (``ncread``) and any HDF5 reader open.

    The file is made in memory and written as a whole, beside first, then renamed: the HDF5 library may end the process
    where it cannot write. Behind its content stands a checksum: a damaged file may read as other numbers, and keeps the
    HDF5 library busy for ever, out of reach of Ctrl-C.

    Raises
    ------
    FileError
        Where the file cannot be written; nothing is left behind.
    """
    import h5netcdf
    import h5py
    from xarray.backends import H5NetCDFStore

    content = io.BytesIO()
    with h5netcdf.File(content, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file))
    with h5py.File(content, "r+") as whole:
        _fix_texts(whole)
        whole.visititems(lambda _, part: _fix_texts(part))
    with replacing(path) as beside, beside.open("wb") as written, content.getbuffer() as whole_content:
        written.write(whole_content)
        written.write(SEAL + sha256(whole_content).hexdigest().encode())


def unsealed(content: bytes, path: Path) -> bytes:
    """The content without the checksum; what other programs wrote has none.

    Raises
    ------
    FileError
        Where the two do not agree.
    """
    place = content.rfind(SEAL, max(0, len(content) - SEALED))
    if place < 0:
        return content
    inner = content[:place]
    if content[place + len(SEAL) :] != sha256(inner).hexdigest().encode():
        raise FileError(f"{path} is damaged: its content does not have the checksum that it was written with")
    return inner


def _fix_texts(part: Any) -> None:
    """Attributes that are text, as strings of fixed length: MATLAB and Octave read no others everywhere."""
    import h5py

    for name in list(part.attrs):
        kind = part.attrs.get_id(name)
        if kind.shape == () and h5py.check_string_dtype(kind.dtype) is not None and kind.dtype == object:
            text = part.attrs[name].encode() or b"\0"
            del part.attrs[name]
            part.attrs.create(name, np.bytes_(text), dtype=h5py.string_dtype("utf-8", len(text)))


def read_netcdf(path: str | Path) -> "xarray.Dataset":
    """Read a netCDF file into memory.

    Returns
    -------
    xarray.Dataset
        Loaded; the file is closed.

    Raises
    ------
    FileError
        Where it is not there, is no netCDF, or is damaged.
    """
    import h5py
    import xarray

    place = Path(path)
    if place.is_dir():
        raise FileError(f"{path} is a directory; name a file in it")
    try:
        content = unsealed(bytes_of(path), place)
        with h5py.File(io.BytesIO(content)) as whole:  # where this fails in h5netcdf, it complains once more when freed
            whole.attrs.get("_nc3_strict")
        with xarray.open_dataset(io.BytesIO(content), engine="h5netcdf", decode_timedelta=False) as opened:
            numbers = sum(int(np.prod(one.shape, dtype=object)) for one in opened.variables.values())
            if numbers > EXPANSION * len(content):
                raise FileError(f"{path} is damaged: it claims to hold {numbers:.2g} numbers")
            return opened.load()
    except FileError:
        raise
    except Exception as error:  # noqa: BLE001  a damaged file makes the libraries raise whatever they raise
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise FileError(f"{path} cannot be read as netCDF: {reason}") from None
