"""Processes that are killed with SIGKILL at random moments: what the measurements of resuming share."""

import random
import signal
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass
class Killer:
    """Kills processes, so many in all."""

    kills: int
    chance: random.Random
    landed: int = 0

    def end(self, child: subprocess.Popen[bytes], ready: Callable[[], bool], *, share: float, within: float) -> int:
        """Kill a process, if there are kills left, and wait for its end; its exit status.

        In a ``share`` of the cases up to ``within`` s after it is ``ready``, otherwise at any moment since its start.
        """
        if self.landed < self.kills:
            if self.chance.random() < share:
                while not ready() and child.poll() is None:
                    time.sleep(0.002)
                time.sleep(self.chance.uniform(0.0, within))
            else:
                time.sleep(self.chance.uniform(0.2, 2.0))
            child.send_signal(signal.SIGKILL)
        status = child.wait()
        self.landed += status == -signal.SIGKILL
        return status
