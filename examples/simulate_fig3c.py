"""Run the paper's Fig. 3(C), judge it, write it, and read it back."""

import math
import tempfile
from pathlib import Path

import helimag as hm

scenario = hm.load("paper/fig3c")
run = hm.simulate(scenario)
print(run)

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "fig3c.nc"
    run.save(path)
    again = hm.Trajectory.load(path)

# inside for the whole half hour, at a gain well below 1 (the paper: 0.252; this preset: near 0.41, and still drifting)
assert run.judgement.end_time == scenario.run.duration
assert run.verdict in ("bounded", "drifting")
assert 0.35 < run.gain < 0.45
# the nose points down nearly all the time: thrust does not carry the device, the magnet's pull does
attack = math.degrees(run.judgement.attack_angle)
assert -15.0 < attack < -8.0, attack
# what was read is what was written
assert again.gain == run.gain
assert (again.final_state == run.final_state).all()
