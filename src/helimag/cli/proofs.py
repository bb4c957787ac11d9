"""What the command orbit needs for --prove, and its subcommand check."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

from helimag.cli._common import PLAIN, Common
from helimag.cli._outputs import check_target
from helimag.cli._shared import print_json, progress_bar, quantity
from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.orbits import Orbit
    from helimag.proof import Certificate, Proof, Row
    from helimag.runs.trajectory import Trajectory
    from helimag.scenario import Scenario

ALONG = "drive.pitch"  # of the inputs with a tolerance the one that a laboratory sets least exactly, beside its width


def check_options(prove: bool, certificate: Path | None, tolerance: bool, many: bool) -> None:
    """Refuse what does not go with a proof, before any work."""
    if prove and many:
        raise InputError("--prove is about the orbit of one scenario: leave out --all and --vary")
    if tolerance and not prove:
        raise InputError("--tolerance widens a proof to a box of inputs: add --prove")
    if certificate is not None:
        if not prove:
            raise InputError("--certificate writes the certificate of a proof: add --prove")
        if certificate.suffix.lower() != ".json":
            raise InputError(f"--certificate must end in .json; got '{certificate}'")
        check_target(certificate)


def seconds_for(tolerance: bool, along: str | None, budget: str | None) -> float | None:
    """The time to take for a box of inputs; None where it is one cell."""
    if budget is None:
        if along is not None:
            raise InputError("--along says which way a box is made longer within a time: add --budget")
        return None
    if not tolerance:
        raise InputError("--budget is the time to take for a box of inputs: add --tolerance")
    from helimag import proof, quantities

    if along not in {None, *proof.TOLERATED}:
        raise InputError(f"--along must be one of {', '.join(proof.TOLERATED)}; got '{along}'")
    return quantity("--budget", budget, quantities.TIME)


def check_provable(scenario: "Scenario") -> None:
    """Refuse a scenario of which nothing can be proved, and a missing library, before any work."""
    from helimag import proof

    proof.require_provable(scenario)


def proved(orbit: "Orbit", path: Path | None) -> "Proof":
    """Prove an orbit, and write its certificate where there is one."""
    from helimag import proof

    with progress_bar(f"proving the orbit of {orbit.scenario.title}") as progress:
        found = proof.prove(orbit, progress=progress)
    if path is not None and found.certificate is not None:
        found.certificate.save(path)
    return found


def tolerated(
    proof: "Proof", path: Path | None, along: str | None, seconds: float | None
) -> "Certificate | Row | None":
    """The certificate of a box of inputs around a proof, written in its place; None where there is none.

    Where a time is given the box is made longer, cell by cell, and written each time.
    """
    if proof.certificate is None or not proof.proved:
        return None
    try:
        return _widened(proof.certificate, path, along or ALONG, seconds)
    except KeyboardInterrupt:
        if path is None:
            raise
        raise KeyboardInterrupt(f"what was proved before is in {path}") from None


def _widened(
    certificate: "Certificate", path: Path | None, along: str, seconds: float | None
) -> "Certificate | Row | None":
    from helimag import proof

    def keep(box: "Certificate | Row") -> None:
        if path is not None:
            box.save(path)

    begun = time.monotonic()
    with progress_bar(f"proving a box of inputs around {certificate.scenario.name}") as progress:
        box = proof.tolerated(certificate, progress=progress)
    if box is None:
        return None
    keep(box)
    left = 0.0 if seconds is None else seconds - (time.monotonic() - begun)
    if left <= 0.0:
        return box
    with progress_bar(f"proving more boxes along {along}") as progress:
        row = proof.grown(box, along, seconds=left, progress=progress, keep=keep)
    return row if len(row.cells) > 1 else box


def checked_for(path: Path, scenario: "Scenario") -> "Certificate":
    """The certificate of a scenario, its claims proved again; another's is refused."""
    from helimag import proof

    certificate = proof.certificate_in(path)
    with progress_bar(f"proving again what {path} claims") as progress:
        proof.require_proof_of(certificate, scenario, progress=progress)
    return certificate


def carried(run: "Trajectory", certificate: "Certificate") -> "Trajectory":
    """The run with its certificate in it."""
    from helimag import proof

    return proof.with_certificate(run, certificate)


def check(certificate: Path, *, common: Common = PLAIN) -> None:
    """Prove again what a certificate claims; exit status 2 where it was changed or claims what it does not prove.

    Parameters
    ----------
    certificate
        A file that ``helimag orbit ... --prove --certificate`` wrote.
    """
    from helimag.cli._proof_reports import box_report, box_sentence
    from helimag.proof import Row, check_file

    with progress_bar(f"proving again what {certificate} claims") as progress:
        found = check_file(certificate, progress=progress)
    name = (found.cells[0] if isinstance(found, Row) else found).scenario.name
    if common.json:
        print_json(
            {
                "scenario": name,
                "sha256": found.hash,
                **box_report(found),
            }
        )
        return
    print(f"{certificate}: holds; {name}: {box_sentence(found)}")
