"""Getting a Warp kernel ready, with a word to the user where that takes long."""

import sys
import threading

import warp as wp

PATIENCE = 0.7  # s before saying something


def ready(kernel: wp.Kernel, device: str) -> None:
    """Compile or load ``kernel`` for ``device``; where that takes seconds, as once on each machine, stderr says so."""
    note = threading.Timer(
        PATIENCE,
        print,
        ["helimag: compiling its kernels for this machine, once (about ten seconds) ..."],
        {"file": sys.stderr},
    )
    note.daemon = True
    note.start()
    try:
        kernel.module.load(wp.get_device(device))
    finally:
        note.cancel()
