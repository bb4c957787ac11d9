"""What the command orbit needs for --prove, and its subcommand check."""

from pathlib import Path
from typing import TYPE_CHECKING

from helimag.cli._common import PLAIN, Common
from helimag.cli._outputs import check_target
from helimag.cli._shared import print_json
from helimag.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from helimag.orbits import Orbit
    from helimag.proof import Certificate, Proof
    from helimag.runs.trajectory import Trajectory
    from helimag.scenario import Scenario


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


def check_provable(scenario: "Scenario") -> None:
    """Refuse a scenario of which nothing can be proved, and a missing library, before any work."""
    from helimag import proof

    proof.require_provable(scenario)


def proved(orbit: "Orbit", certificate: Path | None) -> "Proof":
    """Prove an orbit, and write its certificate where there is one."""
    from helimag import proof

    found = proof.prove(orbit)
    if certificate is not None and found.certificate is not None:
        found.certificate.save(certificate)
    return found


def tolerated(proof: "Proof", path: Path | None, progress: "Callable[[float], None]") -> "Certificate | None":
    """The certificate of a box of inputs around a proof, written in its place; None where there is none."""
    from helimag.proof import tolerated as widened

    if proof.certificate is None or not proof.proved:
        return None
    box = widened(proof.certificate, progress=progress)
    if box is not None and path is not None:
        box.save(path)
    return box


def checked_for(path: Path, scenario: "Scenario") -> "Certificate":
    """The certificate of a scenario, its claims proved again; another's is refused."""
    from helimag import proof

    certificate = proof.certificate_in(path)
    proof.require_proof_of(certificate, scenario)
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
    from helimag.cli._proof_reports import claims_report, within_report
    from helimag.proof import check_file, named_inputs, sentence

    found = check_file(certificate)
    if common.json:
        print_json(
            {
                "scenario": found.scenario.name,
                "sha256": found.hash,
                **claims_report(found.claims),
                **within_report(found),
            }
        )
        return
    print(f"{certificate}: holds; {found.scenario.name}: {sentence(found.claims, named_inputs(found))}")
