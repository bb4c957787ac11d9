"""Getting a Warp kernel ready, with a word to the user where that takes long."""

import sys
import threading

import warp as wp

from helimag.errors import FileError, InputError

PATIENCE = 0.7  # s before saying something


def announce() -> None:
    """Say that kernels are being compiled: the only word on stderr that depends on the machine's past."""
    print("helimag: compiling its kernels for this machine, once (about ten seconds) ...", file=sys.stderr)


def ready(kernel: wp.Kernel, device: str) -> None:
    """Compile or load ``kernel`` for ``device``; where that takes seconds, as once on each machine, stderr says so.

    Raises
    ------
    InputError
        Where this machine has no such device.
    FileError
        Where the compiled kernel cannot be kept.
    """
    known = [str(d) for d in wp.get_devices()]
    if device not in known and not (device == "cuda" and len(known) > 1):
        raise InputError(f"device must be one of this machine's, {', '.join(known)}; got '{device}'")
    target = wp.get_device(device)
    note = threading.Timer(PATIENCE, announce)
    note.daemon = True
    note.start()
    try:
        kernel.module.load(target)
    except OSError as error:
        place = wp.config.kernel_cache_dir
        raise FileError(
            f"compiled kernels cannot be kept in {place}: {error.strerror or error}; make room there, or let "
            "WARP_CACHE_PATH name another folder"
        ) from None
    finally:
        note.cancel()
