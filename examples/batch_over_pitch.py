"""How much pitch is forgiven at 2.5 Hz? One batch over all cores; the verdict tells more than the gain."""

import helimag as hm

base = hm.load("paper/fig3c").replaced({"drive.frequency": "2.5 Hz"})
pitches = range(0, 31, 3)
runs = hm.simulate_many([base.replaced({"drive.pitch": f"{pitch} deg"}) for pitch in pitches])

print("pitch   gain  verdict")
for pitch, run in zip(pitches, runs, strict=True):
    print(f"{pitch:2d} deg  {run.gain:5.3f}  {run.judgement.reason}")

verdicts = {pitch: run.verdict for pitch, run in zip(pitches, runs, strict=True)}
bounded = [pitch for pitch, verdict in verdicts.items() if verdict == "bounded"]
# there is a band of bounded pitch, and it is one piece
assert bounded, verdicts
assert bounded == list(range(bounded[0], bounded[-1] + 1, 3)), verdicts
# with too little or too much pitch the device leaves
assert not {"bounded", "drifting"} & {verdicts[0], verdicts[30]}, verdicts
# a batch gives the same numbers as single runs
assert hm.simulate(base.replaced({"drive.pitch": "12 deg"})).gain == runs[4].gain
