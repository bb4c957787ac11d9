"""A lap of Fig. 3's circle as a robot programme: planned, written, read back, and simulated from its own text."""

import tempfile
from pathlib import Path

import numpy as np

import helimag as hm
from helimag import robot

cell = robot.load_cell("wide")
whole = robot.plan(hm.load("paper/fig3c"), cell)
print(whole.offence)
print(f"laps asked {whole.laps:.2f}, laps that the wrist allows {whole.laps_allowed:.2f}")

scenario = hm.load("paper/fig3c").replaced({"run.duration": "200 s", "run.interval": "1 s"})
lap = robot.plan(scenario, cell)
run = hm.simulate(scenario)
with tempfile.TemporaryDirectory() as folder:
    paths = robot.write_programme(lap, folder, run=run, name="lap", accept_unbounded=True)
    names = sorted(path.name for path in paths)
    src, dat = ((Path(folder) / f"lap.{suffix}").read_text() for suffix in ("src", "dat"))

playback = robot.play(src, dat, cell.arm, interval=0.25)
found = robot.deviation(lap, playback)
print(f"read back: {1e6 * found.position:.3f} um, {found.axis:.1e} rad, {100 * found.timing:.4f} % of the time")
replay = hm.simulate(robot.replayed(scenario, robot.log_of_playback(playback, scenario, cell), "lap.src"))
# the magnet is compared, not the device: while it slips against the field, a run of Fig. 3 amplifies any difference
apart = np.abs(replay.dataset.rpm_position.values - run.dataset.rpm_position.values).max()
turned = np.abs(replay.dataset.rpm_moment.values - run.dataset.rpm_moment.values).max() / scenario.magnet[0].moment
print(f"magnet in the simulated programme: within {1e6 * apart:.3f} um and {turned:.1e} rad of the plan")
print(f"gain as planned {run.gain:.3f}, of the programme {replay.gain:.3f}")

# nine laps do not fit into axis 6, one does
assert not whole.feasible
assert whole.offence is not None
assert whole.offence.joint == "A6"
assert 1.0 < whole.laps_allowed < 2.0
assert lap.feasible
# what was written is what was planned
assert names == ["lap.dat", "lap.src", "lap_motor.csv", "lap_path.csv", "lap_path.json", "lap_robodk.py"]
assert found.position < 1e-6
assert found.axis < 1e-6
assert found.timing < 1e-3
assert apart < 1e-6
assert turned < 1e-4
