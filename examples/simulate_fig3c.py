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

# inside for the whole half hour and settled, at a gain well below 1 (the paper: 0.252)
assert run.judgement.end_time == scenario.run.duration
assert run.verdict == "bounded"
assert 0.22 < run.gain < 0.25
# it swims helix first, as it starts: the magnetic head trails
assert run.leading_end == "helix"
attack = math.degrees(run.judgement.attack_angle)
# the head hangs lower than the helix, so that swimming helix first carries part of the weight
assert -16.0 < attack < -11.0, attack
# what was read is what was written
assert again.gain == run.gain
assert (again.final_state == run.final_state).all()
