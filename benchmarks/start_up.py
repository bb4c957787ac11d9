"""What a short command costs: processor time of whole commands, of what none can do without, and of each part.

Each is a process of its own, kernels and bytecode kept from the time before; the least of some rounds, in which all
take their turn, user and system together.
"""

import os
import resource
import subprocess
import sys
import tempfile

ROUNDS = 7
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
RUN = ["-m", "helimag", "simulate", "paper/fig3c", "--no-orbit"]
AS_COMMANDS_DO = "import gc; gc.set_threshold(200_000); "  # see helimag.cli.main
WARP = "import numpy, warp; warp.config.quiet = True; warp.init()"
PROCESSES = {
    "helimag --version": ["-m", "helimag", "--version"],
    "helimag --help": ["-m", "helimag", "--help"],
    "helimag simulate paper/fig3c --no-orbit": RUN,
    "the same, --no-accuracy": [*RUN, "--no-accuracy"],
    "Python alone": ["-c", ""],
    "numpy": ["-c", "import numpy"],
    "numpy and Warp, started": ["-c", f"{AS_COMMANDS_DO}{WARP}; gc.freeze()"],
    "the same, garbage looked for at the end": ["-c", AS_COMMANDS_DO + WARP],
    "the same, and while importing": ["-c", WARP],
}
IMPORTS = ("helimag.cli", "helimag.scenario", "helimag.engine")
NOT_WAITED_FOR = ("pint", "scipy.integrate", "xarray")
# the run and the one that its accuracy is known by, in a process where all is ready
INSIDE = """
import time, helimag
from helimag.engine import accuracy_of, advance
scenario = helimag.load("paper/fig3c")
advance([scenario.replaced({"run.duration": 1.0})], threads=1)
clock = time.process_time
begun = clock()
(history,) = advance([scenario], threads=1)
ran = clock()
accuracy_of(history)
print(ran - begun, clock() - ran)
"""


def used(words: list[str], settings: dict[str, str]) -> float:
    """Processor time of ``python WORDS`` (s)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *words], check=True, env=settings, **QUIET)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def least(processes: dict[str, list[str]], settings: dict[str, str]) -> dict[str, float]:
    """Least processor time of each (s)."""
    for words in processes.values():
        used(words, settings)  # kernels and bytecode are compiled once
    rounds = [{name: used(words, settings) for name, words in processes.items()} for _ in range(ROUNDS)]
    return {name: min(each[name] for each in rounds) for name in processes}


def inside(settings: dict[str, str]) -> tuple[float, float]:
    """Processor time of the run and of the finer one (s)."""
    words = [sys.executable, "-c", INSIDE]
    rounds = [subprocess.run(words, check=True, env=settings, capture_output=True, text=True) for _ in range(ROUNDS)]
    run, finer = zip(*(map(float, done.stdout.split()) for done in rounds), strict=True)
    return min(run), min(finer)


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as bytecode:
        settings = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        settings["PYTHONPYCACHEPREFIX"] = bytecode
        imports = {
            f"import {name}": ["-c", f"{AS_COMMANDS_DO}import numpy, {name}; gc.freeze()"]
            for name in (*IMPORTS, *NOT_WAITED_FOR)
        }
        found = least(PROCESSES | imports, settings)
        run, finer = inside(settings)
    for name in PROCESSES:
        print(f"{name:42s} {found[name]:.2f} s")
    print(f"{'the run, and that with finer steps':42s} {run:.2f} s and {finer:.2f} s")
    print("on top of numpy:")
    for name in imports:
        waited = "   (not waited for)" if name.split()[1] in NOT_WAITED_FOR else ""
        print(f"  {name:40s} {found[name] - found['numpy']:.2f} s{waited}")


if __name__ == "__main__":
    main()
