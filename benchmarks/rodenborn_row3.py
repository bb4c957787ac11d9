"""Why the third of Rodenborn's helices is missed by a tenth: finer surfaces, closed ends, other readings of its table.

B. Rodenborn et al., PNAS 110 (2013) E338, Fig. 2: pitch 15.241 R, filament radius 0.397 mm, 130 mm long. Every row is
the boundary solver's error against the experiment on one reading of the geometry; nothing is adjusted to it. The last
rows say what it would take. Takes about three minutes on one core.
"""

import csv
from pathlib import Path

import numpy as np

from helimag.hydrodynamics.boundary.mesh import Mesh, joined
from helimag.hydrodynamics.boundary.refine import extrapolated
from helimag.hydrodynamics.boundary.solve import Plane, surface_resistance
from helimag.hydrodynamics.boundary.surfaces import sphere, wire_surface
from helimag.scenario import Helix

TABLE = Path(__file__).parents[1] / "tests" / "data" / "rodenborn2013.csv"
RADIUS, WIRE, LENGTH = 6.3e-3, 0.397e-3, 0.130
ENTRIES = {"thrust": ((0, 3), 2), "torque": ((3, 3), 3), "drag": ((0, 0), 1)}


def surface(helix: Helix, fineness: int, *, closed: bool) -> Mesh:
    """The wire, its flat ends closed by balls of its radius where asked for."""
    wire = wire_surface(helix, 0.0, fineness)
    if not closed:
        return wire
    wave = 2.0 * np.pi / helix.pitch
    ball, parts = sphere(2).corners * helix.wire_radius, [wire]
    for u in (0.0, helix.length):
        end = np.array([-u, helix.radius * np.cos(wave * u), helix.radius * np.sin(wave * u)])
        parts.append(Mesh(ball + end, np.zeros(len(ball), dtype=np.intp)))
    return joined(parts)


def row(
    name: str,
    case: dict[str, str],
    *,
    radius: float = RADIUS,
    wire: float = WIRE,
    length: float = LENGTH,
    finenesses: tuple[int, ...] = (5, 7),
    closed: bool = False,
    plane: Plane | None = None,
) -> None:
    """Solve one reading on two surfaces, extrapolate, and print its errors."""
    pitch = float(case["pitch_over_R"]) * RADIUS
    helix = Helix(length=length, pitch=pitch, wire_radius=wire, outer_diameter=2.0 * (radius + wire))
    meshes = [surface(helix, fineness, closed=closed) for fineness in finenesses]
    matrices = [surface_resistance(mesh, plane) for mesh in meshes]
    counts = [len(mesh) for mesh in meshes]
    best = extrapolated(*matrices[-2:], (counts[-1] / counts[-2]) ** 0.5)
    shown = [name, ", ".join(map(str, counts))]
    for quantity, (entry, power) in ENTRIES.items():
        off = abs(best[entry]) / RADIUS**power / float(case[f"{quantity}_exp"]) - 1.0
        shown.append(f"{100.0 * off:+.1f} %")
    print("| " + " | ".join(shown) + " |", flush=True)


def main() -> None:
    """Print the table."""
    lines = [line for line in TABLE.read_text().splitlines() if not line.startswith("#")]
    case = list(csv.DictReader(lines))[2]
    slender = [100.0 * (float(case[f"{name}_sbt"]) / float(case[f"{name}_exp"]) - 1.0) for name in ENTRIES]
    print("| reading | triangles | thrust | torque | drag |\n|---|---|---|---|---|")
    print("| slender-body theory of the table | | " + " | ".join(f"{off:+.1f} %" for off in slender) + " |")
    row("as published", case)
    row("finer", case, finenesses=(7, 10))
    row("ends closed by half balls", case, closed=True)
    row("R to the outside of the wire", case, radius=RADIUS - WIRE)
    row("R to the inside of the wire", case, radius=RADIUS + WIRE)
    row("longer by one radius", case, length=LENGTH + RADIUS)
    row("wire a tenth thicker", case, wire=1.1 * WIRE)
    row("wire half as thick again", case, wire=1.5 * WIRE)
    row("longer by a tenth", case, length=1.1 * LENGTH)
    for away in (0.05, 0.1):
        row(f"a wall along it, {1e3 * away:.0f} mm away", case, plane=Plane("floor", (0.0, 0.0, 1.0), away))


if __name__ == "__main__":
    main()
