"""What the commands about orbits and their branches print: as one JSON object, and in words."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from helimag.cli._outputs import files_report, print_files
from helimag.cli._proof_reports import box_sentence, proof_report
from helimag.cli._shared import degrees, leading_words, print_json

if TYPE_CHECKING:
    from helimag.orbits import Branch, Orbit
    from helimag.proof import Certificate, Proof, Row
    from helimag.scenario import Scenario

Warnings = list[dict[str, Any]]


def orbit_report(orbit: "Orbit") -> dict[str, Any]:
    return {
        "found": orbit.found,
        "stable": orbit.stable,
        "status": str(orbit.status),
        "reason": orbit.text,
        "position_m": orbit.position.tolist() if orbit.found else None,
        "from_magnet": orbit.side if orbit.found else None,
        "state": orbit.state.tolist() if orbit.found else None,
        "multipliers": [[m.real, m.imag] for m in orbit.multipliers],
        "rates_per_s": [[r.real, r.imag] for r in orbit.rates],
        "attack_angle_deg": degrees(orbit.attack_angle) if orbit.found else None,
        "wobble_deg": degrees(orbit.wobble) if orbit.found else None,
        "leads": orbit.leading_end if orbit.found else None,
        "leading_cosine": orbit.leading_cosine if math.isfinite(orbit.leading_cosine) else None,
        "radius_m": orbit.radius if math.isfinite(orbit.radius) else None,
        "speed_m_per_s": orbit.speed if orbit.found else None,
        "position_error_m": orbit.position_error if math.isfinite(orbit.position_error) else None,
    }


def print_orbit(
    orbit: "Orbit",
    files: list[Path],
    warnings: Warnings,
    json: bool,
    proof: "Proof | None" = None,
    box: "Certificate | Row | None" = None,
) -> None:
    proved = {} if proof is None else {"proof": proof_report(proof, box)}
    if json:
        print_json(orbit_report(orbit) | proved | {"warnings": warnings} | files_report(files))
        return
    print(f"{orbit.scenario.title}: {orbit.text}")
    if orbit.found:
        rates = ", ".join(_shown(rate) for rate in orbit.rates if rate.imag >= 0.0)
        print(f"  rates         {rates} per second")
        print(
            f"  attack angle  {degrees(orbit.attack_angle):.1f} deg, wobble {degrees(orbit.wobble):.1f} deg over a turn"
        )
        print(f"  leads         {leading_words(orbit.leading_end, orbit.leading_cosine)}")
        circle = f"radius {1e3 * orbit.radius:.2f} mm, " if math.isfinite(orbit.radius) else ""
        print(f"  path          {circle}speed {1e3 * orbit.speed:.3f} mm/s")
        print(f"  place         known to {float(f'{1e9 * orbit.position_error:.1g}'):g} nm in the integration")
    if proof is not None:
        print(f"  {'proved' if proof.proved else 'proof':13} {proof.reason} ({proof.seconds:.0f} s)")
    if box is not None:
        print(f"  {'proved':13} {box_sentence(box)}")
    print_files(files)


def _shown(rate: complex) -> str:
    return f"{rate.real:.4g} ± {rate.imag:.4g}i" if rate.imag > 0.0 else f"{rate.real:.4g}"


def print_orbits(scenario: "Scenario", found: "list[Orbit]", files: list[Path], warnings: Warnings, json: bool) -> None:
    if json:
        print_json({"orbits": [orbit_report(orbit) for orbit in found], "warnings": warnings} | files_report(files))
        return
    print(f"{scenario.title}: {len(found)} orbits found")
    for orbit in found:
        print(f"  {orbit.text}")
    print_files(files)


def print_branches(
    orbit: "Orbit", path: str, branches: "list[Branch]", files: list[Path], warnings: Warnings, json: bool
) -> None:
    from helimag import orbits

    segments = [segment for branch in branches for segment in orbits.stable_segments(branch)]
    if json:
        intervals = [{"low": s.low, "high": s.high, "why_low": s.why_low, "why_high": s.why_high} for s in segments]
        print_json(
            {
                "input": path,
                "stable_intervals": intervals,
                "branches": [_branch_report(branch) for branch in branches],
                "warnings": warnings,
            }
            | files_report(files)
        )
        return
    print(f"{orbit.scenario.title}: {orbit.text}")
    for segment in segments:
        print(f"  {segment.text}")
    if not segments:
        print("  nowhere stable in this range, as far as the search goes")
    for branch in branches:
        print("  branch " + branch.text.replace("\n", "\n  "))
    print_files(files)


def _branch_report(branch: "Branch") -> dict[str, Any]:
    return {
        "changes": [{"kind": str(event.kind), "value": event.value} for event in branch.events],
        "ends": list(branch.ends),
        "points": [
            {
                "value": point.value,
                "position_m": point.orbit.position.tolist(),
                "stable": point.orbit.stable,
                "leading_rate_per_s": [point.orbit.rates[0].real, point.orbit.rates[0].imag],
            }
            for point in branch.points
        ],
    }
