"""What all tests share: a command line to run, and independence of what this machine has compiled before."""

import importlib.util
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import command_line

# a shell starts what it runs in the background deaf to Ctrl-C, and so would be the programmes that tests interrupt
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="session")
def nothing_said_of_compiling() -> Iterator[None]:
    """Tests compare stderr; whether kernels must be compiled first depends on the machine and on the tests before."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("helimag.engine.patience.announce", lambda _: None)
        yield


@pytest.fixture
def helimag() -> Callable[..., command_line.Said]:
    """Run a command line in this process: (status, stdout, stderr)."""
    return command_line.run


@pytest.fixture(scope="session")
def random_runs():
    """The module benchmarks/random_runs.py."""
    place = Path(__file__).parents[1] / "benchmarks" / "random_runs.py"
    spec = importlib.util.spec_from_file_location("random_runs", place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
