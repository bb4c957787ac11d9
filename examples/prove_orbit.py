"""A theorem instead of a multiplier: prove that an orbit exists and attracts, write the certificate and check it."""

from pathlib import Path

import helimag as hm
from helimag.proof import check_file

scenario = hm.load("paper/fig3c").replaced({"drive.frequency": "2.5 Hz"})
orbit = hm.find_orbit(scenario)
proof = hm.prove(orbit)
print(proof.reason)

assert proof.proved
assert proof.bound < 1.0
assert proof.certificate is not None

# somebody else reads the file, and takes nothing on trust
proof.certificate.save("orbit.json")
claims = check_file("orbit.json").claims
print(f"the slowest decay is known to {claims.multipliers[0].radius:.1g} of itself a turn")
assert claims == proof.certificate.claims

# one digit of the weight changed: refused
text = Path("orbit.json").read_text(encoding="utf-8")
Path("forged.json").write_text(text.replace('net_weight = \\"', 'net_weight = \\"1', 1), encoding="utf-8")
try:
    check_file("forged.json")
except hm.InputError as refusal:
    print(f"the changed one is refused: {refusal}")
else:
    raise SystemExit("a changed certificate was accepted")
