"""What a short command costs: processor time of whole commands, and of the imports that it does or does not wait for.

Each is a process of its own, kernels and caches warm; the least of some repeats, user and system together.
"""

import os
import subprocess
import sys

REPEATS = 5
COMMANDS = {
    "helimag --help": ["-m", "helimag", "--help"],
    "helimag simulate paper/fig3c --no-orbit": ["-m", "helimag", "simulate", "paper/fig3c", "--no-orbit"],
    "the same, --no-accuracy": ["-m", "helimag", "simulate", "paper/fig3c", "--no-orbit", "--no-accuracy"],
}
WAITED_FOR = ("helimag.cli", "helimag.scenario", "warp", "helimag.engine")
NOT_WAITED_FOR = ("pint", "scipy.integrate", "xarray")
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def seconds(words: list[str]) -> float:
    """Least processor time of ``python WORDS`` (s)."""
    taken = []
    for _ in range(REPEATS):
        before = os.times()
        subprocess.run([sys.executable, *words], check=True, **QUIET)
        after = os.times()
        used = after.children_user + after.children_system - before.children_user - before.children_system
        taken.append(used)
    return min(taken)


def main() -> None:
    """Print the table."""
    seconds(COMMANDS["helimag simulate paper/fig3c --no-orbit"])  # kernels are compiled once
    for name, words in COMMANDS.items():
        print(f"{name:42s} {seconds(words):.2f} s")
    empty = seconds(["-c", "import numpy"])
    print(f"{'import numpy':42s} {empty:.2f} s; on top of it:")
    for module in (*WAITED_FOR, *NOT_WAITED_FOR):
        waited = "" if module in WAITED_FOR else "   (not waited for)"
        print(f"  import {module:35s} {seconds(['-c', f'import numpy, {module}']) - empty:.2f} s{waited}")
    collected = seconds(["-c", "import helimag.engine, helimag.cli"])
    uncollected = seconds(["-c", "import gc; gc.set_threshold(200_000); import helimag.engine, helimag.cli"])
    print(f"{'looking for garbage while importing':42s} {collected - uncollected:.2f} s")


if __name__ == "__main__":
    main()
