"""Datasets into netCDF and out of it: a full disk or a damaged file is an error of ours, never the HDF5 library's."""

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from helimag.errors import FileError
from helimag.files import replacing

if TYPE_CHECKING:
    import xarray

EXPANSION = 1000  # bytes of numbers that a byte of file may hold; more, and its sizes are damaged


def write_netcdf(dataset: "xarray.Dataset", path: str | Path) -> None:
    """Write netCDF that xarray, MATLAB (``ncread``) and any HDF5 reader open.

    The file is made in memory and written as a whole, beside first, then renamed: the HDF5 library may end the process
    where it cannot write.

    Raises
    ------
    FileError
        Where the file cannot be written; nothing is left behind.
    """
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    content = io.BytesIO()
    with h5netcdf.File(content, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file))
    with replacing(path) as beside:
        beside.write_bytes(content.getbuffer())


def read_netcdf(path: str | Path) -> "xarray.Dataset":
    """Read a netCDF file into memory.

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
        content = place.read_bytes()
        with h5py.File(io.BytesIO(content)) as whole:  # where this fails in h5netcdf, it complains once more when freed
            whole.attrs.get("_nc3_strict")
        with xarray.open_dataset(io.BytesIO(content), engine="h5netcdf", decode_timedelta=False) as opened:
            numbers = sum(int(np.prod(one.shape, dtype=object)) for one in opened.variables.values())
            if numbers > EXPANSION * len(content):
                raise FileError(f"{path} is damaged: it claims to hold {numbers:.2g} numbers")
            return opened.load()
    except FileNotFoundError:
        raise FileError(f"there is no file '{path}'") from None
    except FileError:
        raise
    except Exception as error:  # noqa: BLE001  a damaged file makes the libraries raise whatever they raise
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise FileError(f"{path} cannot be read as netCDF: {reason}") from None
