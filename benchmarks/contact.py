"""Walls that hold: what they cost, how the step converges, and how little the closing time matters.

A device pressed to the surface by the paper's drive taps it several times a turn of the magnet.
"""

import time

import numpy as np

from helimag.engine import DOP853, History, advance, contact
from helimag.scenario import Scenario, load

CLOSING_TIMES = (1 / 16, 1 / 32, 1 / 64, 1 / 128)
TOLERANCES = (1e-4, 1e-5, 3e-7, 1e-8, 1e-9)


def timed(scenario: Scenario, tries: int = 5) -> tuple[History, float]:
    """A run and the least CPU time that it took (s)."""
    best, history = np.inf, advance([scenario], threads=1, method=DOP853)[0]
    for _ in range(tries):
        begun = time.process_time()
        history = advance([scenario], threads=1, method=DOP853)[0]
        best = min(best, time.process_time() - begun)
    return history, best


def main() -> None:
    """Print three tables."""
    free = load("nose-first/fig3c").replaced({"run.duration": "3000 s", "workspace.floor": "-1 m"})
    pressed = load("nose-first/table1-row2").replaced({"run.duration": "190 s", "workspace.contact": "hold"})
    runs = {"stops, far": free, "holds, far": free.replaced({"workspace.contact": "hold"}), "holds, tapping": pressed}
    for name, scenario in runs.items():
        history, took = timed(scenario)
        turns = scenario.run.duration * scenario.drive.frequency
        print(
            f"{name:15s} {history.steps / turns:5.1f} steps a turn, {history.rejected / turns:4.1f} rejected, "
            f"{1e6 * took / history.steps:.2f} us a step, {sum(touch.count for touch in history.touches)} contacts"
        )
    short = pressed.replaced({"run.duration": "100 s"})
    finest = advance([short], tolerance=1e-12)[0]
    exact = finest.states[-1, :3]
    print(f"the run below: 100 s with {sum(touch.count for touch in finest.touches)} contacts")
    for tolerance in TOLERANCES:
        history = advance([short], tolerance=tolerance)[0]
        error = np.linalg.norm(history.states[-1, :3] - exact)
        print(f"tolerance {tolerance:.0e}: {history.steps} steps, error {error:.1e} m after 100 s")
    usual, ends = contact.CLOSING_TIME, {}
    for share in CLOSING_TIMES:
        contact.CLOSING_TIME = share
        history = advance([short])[0]
        ends[share] = history.states
        print(f"closing time 1/{1 / share:.0f} turn: {history.steps} steps, {history.rejected} rejected")
    contact.CLOSING_TIME = usual
    for share in CLOSING_TIMES[:-1]:
        off = np.abs(ends[share][:, :3] - ends[CLOSING_TIMES[-1]][:, :3]).max(axis=0)
        print(f"1/{1 / share:.0f} beside 1/128 turn: up to {1e6 * off[2]:.2f} um in height, {1e6 * off[0]:.2f} along x")


if __name__ == "__main__":
    main()
