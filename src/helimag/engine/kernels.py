"""Getting a Warp kernel ready, with a word to the user where that takes long."""

import threading
from collections.abc import Callable

import warp as wp

from helimag.engine.patience import announced
from helimag.errors import FileError, InputError

COMPILING = "compiling a kernel for this machine and keeping it ({}) ..."
TAKES_ON_CPU, TAKES_ON_GPU = "about ten seconds", "up to some minutes"
MAKING = threading.RLock()


def check_device(device: str) -> None:
    """Refuse a device that this machine does not have.

    Raises
    ------
    InputError
        Where it has none of that name.
    """
    known = [str(d) for d in wp.get_devices()]
    if device not in known and not (device == "cuda" and len(known) > 1):
        raise InputError(f"device must be one of this machine's, {', '.join(known)}; got '{device}'")


def ready(build: Callable[[], wp.Kernel], device: str) -> wp.Kernel:
    """The kernel that ``build`` makes, compiled or loaded for ``device``; where that takes seconds, stderr says so.

    One thread at a time: Warp's modules, and the kernels kept for a system, are not made for two.

    Returns
    -------
    wp.Kernel
        Loaded, so that a launch takes no time but its own.

    Raises
    ------
    InputError
        Where this machine has no such device.
    FileError
        Where the compiled kernel cannot be kept.
    """
    check_device(device)
    target = wp.get_device(device)
    try:
        with MAKING:
            kernel = build()
            told = COMPILING.format(TAKES_ON_CPU if target.is_cpu else TAKES_ON_GPU)
            with announced(told, log=f"a kernel of {kernel.module.name} made ready for {device}"):
                # as a launch will ask for it; the module's own load compiles for blocks of 256 threads, which none on a
                # CPU has, and each launch would compile again, out of this lock
                wp.force_load(target, modules=[kernel.module], max_workers=0)
    except OSError as error:
        place = wp.config.kernel_cache_dir
        raise FileError(
            f"compiled kernels cannot be kept in {place}: {error.strerror or error}; make room there, or let "
            "WARP_CACHE_PATH name another folder"
        ) from None
    return kernel
