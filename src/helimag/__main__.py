"""``python -m helimag`` and the command ``helimag``: what a stop means from the first import to the last."""

import contextlib
import os
import sys

INTERRUPTED = 130


def main() -> None:
    """Run the command line. Ctrl-C while it is still being read ends as it does later.

    Once all is said and cleared away, an interrupted process ends at once: the interpreter's own end, with all that a
    run has loaded, would keep the user waiting as long again.
    """
    try:
        from helimag.cli import main as run

        run()
    except KeyboardInterrupt:
        with contextlib.suppress(OSError, AttributeError):  # standard error may be closed
            sys.stderr.write("helimag: interrupted\n")
            sys.stderr.flush()
        os._exit(INTERRUPTED)
    except SystemExit as end:
        if end.code == INTERRUPTED:
            os._exit(INTERRUPTED)
        raise


if __name__ == "__main__":
    main()
