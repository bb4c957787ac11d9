"""What to cite, and a methods paragraph that says how a run was made."""

from helimag.scenario import Scenario

REFERENCES = {
    "model": "Input-Output Boundedness of a Magnetically-Actuated Helical Device (model, gain, the runs of Fig. 3)",
    "lighthill": "J. Lighthill, Flagellar hydrodynamics, SIAM Review 18 (1976) 161",
    "gray-hancock": "J. Gray and G. J. Hancock, Propulsion of sea-urchin spermatozoa, J. Exp. Biol. 32 (1955) 802",
    "boundary": "S. Kim and S. J. Karrila, Microhydrodynamics: Principles and Selected Applications, 1991",
    "dop853": "E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993",
    "warp": "M. Macklin, Warp: a high-performance Python framework for GPU simulation and graphics, 2022",
}


def citations(scenario: Scenario) -> list[str]:
    """References for a run of this scenario, the model first."""
    model = scenario.device.hydrodynamics.model
    keys = ["model", *([model] if model in REFERENCES else []), "dop853", "warp"]
    return [REFERENCES[key] for key in keys]


def methods(scenario: Scenario, version: str) -> str:
    """Describe a run of this scenario in sentences for a paper, assumptions and fitted values included."""
    device, drive, magnet = scenario.device, scenario.drive, scenario.magnet[0]
    drag = {
        "lighthill": "resistive-force theory with Lighthill's coefficients",
        "gray-hancock": "resistive-force theory with the coefficients of Gray and Hancock",
        "boundary": "a Galerkin boundary-element solution of Stokes flow around the whole device",
        "matrix": "a given resistance matrix",
    }[device.hydrodynamics.model]
    field = {"dipole": "a point dipole", "cylinder": "a uniformly magnetised cylinder (multipoles up to order 15)"}
    pitch = {"origin": "turned about the lab's origin", "magnet": "turned about the magnet's centre"}
    count = "the magnet" if len(scenario.magnet) == 1 else f"{len(scenario.magnet)} magnets, each"
    by_mark: dict[str, list[str]] = {}
    for path, mark in scenario.provenance.items():
        by_mark.setdefault(mark.partition(":")[0], []).append(path)
    marked = "; ".join(
        f"{mark}: {', '.join(paths)}" for mark, paths in sorted(by_mark.items()) if mark in {"fitted", "assumed"}
    )
    sentences = [
        f"The device was simulated with helimag {version} (scenario hash {scenario.hash[:12]}).",
        f"Its six degrees of freedom follow the quasi-static balance of magnetic, gravitational and viscous loads: "
        f"{drag} for the helix, and {count} taken as {field[magnet.field]}.",
        f"The magnet turned at {drive.frequency:g} Hz, its axis {pitch[drive.pitch_about]}.",
        f"The equations were integrated for {scenario.run.duration:g} s by an adaptive Runge-Kutta method of order 8.",
    ]
    if marked:
        sentences.append(f"Values that are not published or measured: {marked}.")
    return " ".join(sentences)
