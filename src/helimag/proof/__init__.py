"""Proofs: that an orbit exists, alone, and attracts, by enclosures; certificates of them, and their check."""

from helimag.proof.carrying import certificate_of, line, require_covered, require_proof_of, with_certificate
from helimag.proof.certificate import Certificate, Claims, certificate_in, check, read_certificate
from helimag.proof.exact import TOLERATED, require_provable
from helimag.proof.growing import grown
from helimag.proof.proving import Proof, named_inputs, prove, row_sentence, sentence
from helimag.proof.row import Row, check_file, check_row, read_any, read_row
from helimag.proof.theorem import Disc
from helimag.proof.tolerance import tolerated

__all__ = [
    "TOLERATED",
    "Certificate",
    "Claims",
    "Disc",
    "Proof",
    "Row",
    "certificate_in",
    "certificate_of",
    "check",
    "check_file",
    "check_row",
    "grown",
    "line",
    "named_inputs",
    "prove",
    "read_any",
    "read_certificate",
    "read_row",
    "require_covered",
    "require_proof_of",
    "require_provable",
    "row_sentence",
    "sentence",
    "tolerated",
    "with_certificate",
]
