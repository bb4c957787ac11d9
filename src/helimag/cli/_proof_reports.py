"""What the commands about proofs print."""

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from helimag.proof import Claims, Proof


def claims_report(claims: "Claims") -> dict[str, Any]:
    """All that a certificate claims, by name and unit."""
    return {
        "proved": claims.proved,
        "existence": claims.existence,
        "stability": claims.stability,
        "instability": claims.instability,
        "bound": claims.bound,
        "box_m": max(claims.box),
        "box_half_widths_m": list(claims.box),
        "tube_half_widths_m": list(claims.tube),
        "basin_m": claims.basin if claims.stability else None,
        "basin_deg": math.degrees(claims.basin_turned) if claims.stability else None,
        "clearance_m": claims.clearance,
        "multipliers": [asdict(disc) for disc in claims.multipliers],
        "tube_multipliers": [asdict(disc) for disc in claims.tube_multipliers],
    }


def proof_report(proof: "Proof") -> dict[str, Any]:
    """A proof, or why there is none."""
    report: dict[str, Any] = {
        "proved": proof.proved,
        "existence": proof.existence,
        "stability": proof.stability,
        "bound": proof.bound if math.isfinite(proof.bound) else None,
        "box_m": proof.box if math.isfinite(proof.box) else None,
    }
    if proof.certificate is not None:
        report |= claims_report(proof.certificate.claims) | {"certificate_sha256": proof.certificate.hash}
    return report | {"reason": proof.reason, "seconds": proof.seconds}
