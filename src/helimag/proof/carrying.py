"""Certificates that travel: in a run's file, and as a line of a programme's header."""

from functools import lru_cache

from helimag.errors import InputError
from helimag.proof.certificate import Certificate, check, read_certificate
from helimag.runs.trajectory import Trajectory
from helimag.scenario import Scenario, parse

ATTRIBUTE = "proof_certificate"


def require_covered(certificate: Certificate, scenario: Scenario) -> None:
    """Refuse a certificate of another scenario.

    Raises
    ------
    InputError
        Where it is about other inputs.
    """
    if not certificate.covers(scenario):
        raise InputError(
            f"the certificate is about '{certificate.scenario.name}' at other inputs than '{scenario.title}'; prove "
            "this scenario's own orbit (helimag orbit ... --prove --certificate FILE)"
        )


def require_proof_of(certificate: Certificate, scenario: Scenario) -> None:
    """Refuse a certificate of another scenario, and one whose claims do not follow from its tube; seconds, once.

    Raises
    ------
    InputError
        Where it is about other inputs, or claims what is not proved.
    """
    require_covered(certificate, scenario)
    _proved_again(certificate.text())


@lru_cache(maxsize=16)
def _proved_again(text: str) -> None:
    check(read_certificate(text))


def with_certificate(run: Trajectory, certificate: Certificate) -> Trajectory:
    """The run with the certificate of its scenario in the attribute ``proof_certificate``, as text.

    Returns
    -------
    Trajectory
        A copy.

    Raises
    ------
    InputError
        Where the run is none of a scenario, or the certificate is about another or claims what is not proved.
    """
    require_proof_of(certificate, _scenario_of(run))
    return Trajectory(run.dataset.assign_attrs({ATTRIBUTE: certificate.text()}))


def _scenario_of(run: Trajectory) -> Scenario:
    if run.scenario_toml is None:
        raise InputError("a certificate goes with a simulated run; this one has no scenario")
    return parse(run.scenario_toml, "the run's scenario")


def certificate_of(run: Trajectory) -> Certificate | None:
    """The certificate that a run carries, its hash compared; None where it has none.

    Returns
    -------
    Certificate or None
        Not proved again.

    Raises
    ------
    InputError
        Where it was changed, or is about another scenario.
    """
    text = run.dataset.attrs.get(ATTRIBUTE)
    if text is None:
        return None
    certificate = read_certificate(str(text))
    require_covered(certificate, _scenario_of(run))
    return certificate


def line(certificate: Certificate) -> str:
    """What a programme's header says of a proof."""
    claims = certificate.claims
    what = "proved for all time in the model" if claims.proved else "not proved to attract and keep clear"
    return f"Orbit {what}, certificate sha256 {certificate.hash}"
