"""Proofs: that an orbit exists, alone, and attracts, by enclosures; certificates of them, and their check."""

from helimag.proof.carrying import certificate_of, line, require_covered, require_proof_of, with_certificate
from helimag.proof.certificate import Certificate, Claims, certificate_in, check, check_file, read_certificate
from helimag.proof.exact import require_provable
from helimag.proof.proving import Proof, named_inputs, prove, sentence
from helimag.proof.theorem import Disc
from helimag.proof.tolerance import tolerated

__all__ = [
    "Certificate",
    "Claims",
    "Disc",
    "Proof",
    "certificate_in",
    "certificate_of",
    "check",
    "check_file",
    "line",
    "named_inputs",
    "prove",
    "read_certificate",
    "require_covered",
    "require_proof_of",
    "require_provable",
    "sentence",
    "tolerated",
    "with_certificate",
]
