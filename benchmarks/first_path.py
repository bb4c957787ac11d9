"""The README's path as a first user walks it: a fresh clone, empty home and caches, each step timed and listened to.

python benchmarks/first_path.py [LOG]

Steps run on a terminal of their own, as they would for a person. Says how long each took and the longest that it was
silent, and ends with status 1 where a step failed or was silent for more than LIMIT seconds. All that was shown goes
into LOG. Needs the package index that pip is set up for.
"""

import fcntl
import os
import pty
import re
import select
import shutil
import struct
import subprocess
import sys
import tempfile
import termios
import time
from pathlib import Path
from typing import IO, NamedTuple

ROOT = Path(__file__).parents[1]
LIMIT = 5.0  # s of silence
KEPT = (
    "PATH",
    "LANG",
    "PIP_CONFIG_FILE",
    "PIP_INDEX_URL",
    "SSL_CERT_FILE",
    "REQUESTS_CA_BUNDLE",
    "http_proxy",
    "https_proxy",
)


class Step(NamedTuple):
    """What was run, and how it went: exit status, seconds, the longest silence (s) and the line before that."""

    command: str
    status: int
    seconds: float
    silence: float
    before: str


def steps(readme: str) -> list[str]:
    """The README's commands in order, with those of the environment that make demo has made."""
    blocks = re.findall(r"^```(?:console|bash)\n(.*?)^```", readme, re.DOTALL | re.MULTILINE)
    lines = [line.removeprefix("$ ").partition(" #")[0].strip() for block in blocks for line in block.splitlines()]
    return [line for line in lines if line.startswith(("make demo", ".venv/bin/helimag "))]


def python_of(readme: str) -> str:
    """The README's Python, as it stands."""
    return "\n".join(re.findall(r"^```python\n(.*?)^```", readme, re.DOTALL | re.MULTILINE))


def walked(command: str, folder: Path, environment: dict[str, str], log: IO[bytes]) -> Step:
    """Run a command on a terminal and listen."""
    log.write(f"\n$ {command}\n".encode())
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
    begun = heard = time.monotonic()
    process = subprocess.Popen(
        ["bash", "-c", command], cwd=folder, env=environment, stdin=theirs, stdout=theirs, stderr=theirs
    )
    os.close(theirs)
    longest, before, last = 0.0, "", b""
    while True:
        ready, _, _ = select.select([ours], [], [], 0.1)
        now = time.monotonic()
        if ready:
            try:
                said = os.read(ours, 65536)
            except OSError:  # the other end of a terminal has been closed
                said = b""
            if now - heard > longest:
                longest, before = now - heard, last.decode(errors="replace").strip()
            if not said:
                break
            heard, last = now, (last + said).replace(b"\r", b"\n").rstrip().split(b"\n")[-1][-200:]
            log.write(said)
    os.close(ours)
    return Step(command, process.wait(), time.monotonic() - begun, longest, before)


def fresh(folder: Path) -> dict[str, str]:
    """The environment of a user who has just been given an account."""
    home = folder / "home"
    home.mkdir()
    kept = {name: os.environ[name] for name in KEPT if name in os.environ}
    for place in (Path.home() / ".config" / "pip" / "pip.conf", Path.home() / ".pip" / "pip.conf"):
        if "PIP_CONFIG_FILE" not in kept and place.is_file():  # where pip finds packages is the machine's business
            kept["PIP_CONFIG_FILE"] = str(place)
    homes = {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache"), "WARP_CACHE_PATH": str(home / "kernels")}
    return {**kept, **homes, "MPLCONFIGDIR": str(home / "matplotlib"), "TERM": "xterm", "PYTHON": sys.executable}


def main() -> int:
    log_path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.gettempdir()) / "first_path.log"
    folder = Path(tempfile.mkdtemp(prefix="first-path-"))
    environment = fresh(folder)
    try:
        with log_path.open("wb") as log:
            found = [walked(f"git clone --quiet --progress {ROOT} clone", folder, environment, log)]
            clone = folder / "clone"
            readme = (clone / "README.md").read_text(encoding="utf-8")
            (clone / "readme.py").write_text(python_of(readme), encoding="utf-8")
            for command in [*steps(readme), ".venv/bin/python readme.py"]:
                found.append(walked(command, clone, environment, log))
        size = subprocess.run(
            ["du", "-sm", clone / ".venv"], capture_output=True, text=True, check=False
        ).stdout.split()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    for step in found:
        print(f"{step.seconds:7.1f} s  silent {step.silence:4.1f} s  status {step.status}  {step.command}")
        if step.silence > LIMIT:
            print(f"           after: {step.before}")
    whole = sum(step.seconds for step in found)
    print(f"{whole:7.1f} s in all; .venv {size} MB; all that was shown: {log_path}")
    return int(any(step.status != 0 or step.silence > LIMIT for step in found))


if __name__ == "__main__":
    sys.exit(main())
