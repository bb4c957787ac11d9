"""What an uploaded netCDF file may be: numbers of its own, no more than fit, and none of another file.

HDF5, which netCDF is made of, can say "these numbers are in that file" in three ways: links, external storage and
virtual datasets. A reader follows them without a word. So whoever may choose the file could choose others with it.
"""

import io
from typing import TYPE_CHECKING, Any

from helimag.errors import InputError

if TYPE_CHECKING:
    import h5py

MOST_UNPACKED = 256 * 2**20  # bytes of all numbers and names; a stored half-hour run has under three megabytes
MOST_PARTS = 500  # variables and groups


def check_netcdf(content: bytes) -> None:
    """Look at a file's structure, and read none of its numbers.

    Raises
    ------
    InputError
        Where it is no HDF5, refers to other files, or would take too much memory.
    """
    import h5py

    try:
        with h5py.File(io.BytesIO(content)) as file:
            size = sum(_size(part) for part in _parts(file))
    except InputError:
        raise
    except Exception as error:  # noqa: BLE001  a damaged file makes the library raise whatever it raises
        reason = " ".join(str(error).split())[:160] or type(error).__name__
        raise InputError(f"the file cannot be read as netCDF: {reason}") from None
    if size > MOST_UNPACKED:
        raise InputError(f"the file holds more than {MOST_UNPACKED // 2**20} MB of numbers when it is unpacked")


def _parts(file: "h5py.File") -> list[Any]:
    """All datasets; every link on the way is looked at before it is followed."""
    import h5py

    found, groups, seen = [], [file], 0
    while groups:
        group = groups.pop()
        for name in group:
            seen += 1
            if seen > MOST_PARTS:
                raise InputError(f"the file has more than {MOST_PARTS} parts")
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise InputError("the file must not link to elsewhere")
            part = group[name]
            if isinstance(part, h5py.Group):
                groups.append(part)
            elif isinstance(part, h5py.Dataset):
                found.append(part)
    return found


def _size(part: Any) -> int:
    """Bytes of a dataset when it is unpacked."""
    if part.external or part.is_virtual:
        raise InputError("the file must hold its numbers itself, not name another file for them")
    size = int(part.dtype.itemsize)
    for length in part.shape or ():
        size *= int(length)
    return size


def attribute_of(content: bytes, name: str) -> str:
    """A text that a file carries; empty where it has none of that name. For a file that was checked."""
    import h5py

    with h5py.File(io.BytesIO(content)) as file:
        try:
            found = file.attrs.get(name, "")
        except OSError as error:
            raise InputError(f"the file's '{name}' cannot be read: {error}") from None
    if isinstance(found, bytes):  # text of fixed length
        return found.decode("utf-8", "replace").rstrip("\0")
    return found if isinstance(found, str) else ""
