"""The same drive with the helix first and with the head first: one stays on a stable orbit, the other leaves."""

import helimag as hm

preset = hm.load("paper/fig3c")
runs = {end: hm.simulate(preset.replaced({"drive.heading": end})) for end in ("helix", "head")}
for end, run in runs.items():
    print(f"{end:5s} first: {run.judgement.reason}; {run.leading_end} leads, cosine {run.leading_cosine:+.2f}")

assert preset.drive.heading == "helix"
assert runs["helix"].verdict == "bounded"
assert runs["helix"].leading_end == "helix"
assert not runs["head"].verdict.inside

# at the start the long axis points from helix to head: backwards where the helix leads, the drive going along x
assert runs["helix"].dataset.long_axis.values[0, 0] == -1.0
assert runs["head"].dataset.long_axis.values[0, 0] == 1.0

# a whole attitude may be given instead; the run is the same to rounding
angles = preset.replaced({"drive.heading": ["180 deg", "0 deg", "180 deg"], "run.duration": "60 s"})
same = (
    hm.simulate(angles).dataset.position.values[-1] - hm.simulate(preset, duration="60 s").dataset.position.values[-1]
)
print(f"a minute from the same attitude in angles: {1e9 * abs(same).max():.1g} nm apart")
assert abs(same).max() < 1e-6
