"""What a magnet's field model costs, and how far a cylinder is off magpylib's by distance from its surface."""

import time

import magpylib
import numpy as np
import warp as wp

import helimag as hm
from helimag.engine import DOP853
from helimag.engine.packing import pack_magnets
from helimag.engine.simulation import advance
from helimag.physics import magnetics

SHAPES = {"35 x 20 mm": (17.5e-3, 20e-3), "35 x 4 mm": (17.5e-3, 4e-3), "20 x 20 mm": (10e-3, 20e-3)}
SHAPES |= {"20 x 50 mm": (10e-3, 50e-3), "10 x 60 mm": (5e-3, 60e-3)}


@wp.kernel(enable_backward=False)
def fields_of(
    magnets: wp.array(dtype=magnetics.FieldSource), places: wp.array(dtype=wp.vec3d), fields: wp.array(dtype=wp.vec3d)
):
    i = wp.tid()
    field, force = magnetics.cylinder(magnets[0], places[i], wp.vec3d(0.0, 0.0, 1.0), wp.vec3d(1.0, 0.0, 0.0))
    fields[i] = field


def cost(scenario: hm.Scenario) -> float:
    """Process time of one evaluation of the right-hand side (s), within a run."""
    advance([scenario.replaced({"run.duration": "1 s"})], threads=1, method=DOP853)
    best = float("inf")
    for _ in range(9):
        begun = time.process_time()
        (run,) = advance([scenario], threads=1, method=DOP853)
        best = min(best, (time.process_time() - begun) / (12 * (run.steps + run.rejected)))
    return best


def error(scenario: hm.Scenario, diameters: float) -> float:
    """Largest relative error of the field over a surface that many diameters away from the cylinder's own."""
    magnet = scenario.magnet[0]
    volume = np.pi * magnet.radius**2 * magnet.height
    exact = magpylib.magnet.Cylinder(
        polarization=(0, 0, 4e-7 * np.pi * magnet.dipole_moment / volume),
        dimension=(2 * magnet.radius, magnet.height),
    )
    angles = np.linspace(0.0, np.pi / 2, 200)
    gap = 2.0 * magnet.radius * diameters
    corner = np.stack([magnet.radius + gap * np.sin(angles), 0 * angles, magnet.height / 2 + gap * np.cos(angles)], 1)
    lid = np.linspace(0.0, 1.0, 100)[:, None] * [magnet.radius, 0.0, 0.0] + [0.0, 0.0, magnet.height / 2 + gap]
    places = np.concatenate([corner, lid])
    found = wp.zeros(len(places), dtype=wp.vec3d, device="cpu")
    magnets = wp.array(pack_magnets([scenario])[0], dtype=magnetics.FieldSource, device="cpu")
    wp.launch(fields_of, len(places), [magnets, wp.array(places, dtype=wp.vec3d, device="cpu"), found], device="cpu")
    theirs = exact.getB(places)
    return float((np.linalg.norm(found.numpy() - theirs, axis=1) / np.linalg.norm(theirs, axis=1)).max())


def main() -> None:
    """Print the table."""
    base = hm.load("nose-first/fig3c").replaced({"run.duration": "200 s"})
    print(f"dipole:                {1e9 * cost(base):4.0f} ns per evaluation of the right-hand side")
    for name, (radius, height) in SHAPES.items():
        shape = base.replaced({"magnet.field": "cylinder", "magnet.radius": radius, "magnet.height": height})
        slices = int(pack_magnets([shape])[0]["slices"][0])
        errors = ", ".join(f"{error(shape, away):.0e} at {away:g}" for away in (0.5, 1.0, 2.0))
        print(f"cylinder, {name}: {1e9 * cost(shape):4.0f} ns ({slices} slices); field off by {errors} diameters away")


if __name__ == "__main__":
    main()
