"""What the commands about proofs print."""

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from helimag.proof import Certificate, Claims, Proof, Row


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
        "basin_m": claims.basin or None if claims.stability else None,
        "basin_deg": math.degrees(claims.basin_turned) or None if claims.stability else None,
        "clearance_m": claims.clearance,
        "multipliers": [asdict(disc) for disc in claims.multipliers],
        "tube_multipliers": [asdict(disc) for disc in claims.tube_multipliers],
    }


def within_report(certificate: "Certificate") -> dict[str, Any]:
    """The inputs that may be off, in words of the scenario's file; nothing where the decimals hold."""
    from helimag.proof import named_inputs

    if not certificate.within:
        return {}
    return {"within": dict(certificate.within), "within_text": named_inputs(certificate)}


def row_report(row: "Row") -> dict[str, Any]:
    """A row of boxes: the box that they make up, in the units of the scenario's file, and what holds in all of it."""
    from helimag.proof import row_sentence

    return {
        "proved": all(cell.claims.proved for cell in row.cells),
        "along": row.along,
        "box": {path: [float(end) for end in ends] for path, ends in row.box.items()},
        "cells": len(row.cells),
        "bound": row.bound,
        "clearance_m": row.clearance,
        "reason": row_sentence(row),
    }


def box_report(box: "Certificate | Row") -> dict[str, Any]:
    """A box of inputs, of one cell or of a row of them."""
    from helimag.proof import Row

    if isinstance(box, Row):
        return row_report(box)
    return claims_report(box.claims) | within_report(box)


def box_sentence(box: "Certificate | Row") -> str:
    """What is proved of it, in words."""
    from helimag.proof import Row, named_inputs, row_sentence, sentence

    return row_sentence(box) if isinstance(box, Row) else sentence(box.claims, named_inputs(box))


def proof_report(proof: "Proof", box: "Certificate | Row | None" = None) -> dict[str, Any]:
    """A proof, or why there is none; with a box of inputs where one was proved around it."""
    report: dict[str, Any] = {
        "proved": proof.proved,
        "existence": proof.existence,
        "stability": proof.stability,
        "bound": proof.bound if math.isfinite(proof.bound) else None,
        "box_m": proof.box if math.isfinite(proof.box) else None,
    }
    if proof.certificate is not None:
        report |= claims_report(proof.certificate.claims) | {"certificate_sha256": proof.certificate.hash}
    if box is not None:
        report["tolerance"] = box_report(box) | {"certificate_sha256": box.hash}
    return report | {"reason": proof.reason, "seconds": proof.seconds}
