"""The boundary solver against what is known: closed forms, measured helices, an enclosing body; with its time.

Prints the tables of docs/theory/drag.md. Takes about five minutes on one core.
"""

import csv
import time
from pathlib import Path

import numpy as np

import helimag as hm
from helimag.hydrodynamics.boundary.device import device_surfaces
from helimag.hydrodynamics.boundary.mesh import joined
from helimag.hydrodynamics.boundary.refine import extrapolated, refined
from helimag.hydrodynamics.boundary.solve import Plane, surface_resistance
from helimag.hydrodynamics.boundary.surfaces import head_surface, sphere
from helimag.hydrodynamics.bounds import enclosing_resistance
from helimag.hydrodynamics.heads import spheroid
from helimag.hydrodynamics.resistive_force import gray_hancock, helix_resistance, lighthill
from helimag.scenario import Device, Helix, SpheroidHead, Weight

TABLE = Path(__file__).parents[1] / "tests" / "data" / "rodenborn2013.csv"
RADIUS, WIRE, LENGTH = 6.3e-3, 0.397e-3, 0.130
UP = (0.0, 0.0, 1.0)
solved = {}


def series(height, kind):
    """Drag of a unit ball straight to a plane over 6 pi mu: H. Brenner, Chem. Eng. Sci. 16 (1961) 242."""
    a, n = np.arccosh(height), np.arange(1, 40)
    two = 2 * n + 1
    if kind == "floor":
        top = 2 * np.sinh(two * a) + two * np.sinh(2 * a)
        term = top / (4 * np.sinh((n + 0.5) * a) ** 2 - two**2 * np.sinh(a) ** 2)
    else:
        top = 4 * np.cosh((n + 0.5) * a) ** 2 + two**2 * np.sinh(a) ** 2
        term = top / (2 * np.sinh(two * a) - two * np.sinh(2 * a))
    return 4 / 3 * np.sinh(a) * np.sum(n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (term - 1))


def pair_series(gap):
    """Drag of each of two unit balls in line over 6 pi mu: M. Stimson and G. B. Jeffery, Proc. R. Soc. A 111, 110."""
    a, n = np.arccosh(gap / 2), np.arange(1, 40)
    two = 2 * n + 1
    top = 4 * np.sinh((n + 0.5) * a) ** 2 - two**2 * np.sinh(a) ** 2
    term = top / (2 * np.sinh(two * a) + two * np.sinh(2 * a))
    return 4 / 3 * np.sinh(a) * np.sum(n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (1 - term))


def row(name, surfaces, entry, exact, plane=None):
    """One closed form: relative errors of two resolutions and of what they extrapolate to."""
    coarse, fine = surfaces
    key = coarse.corners.tobytes(), plane
    if key not in solved:  # one solution serves several rows
        matrices = [surface_resistance(mesh, plane) for mesh in surfaces]
        solved[key] = *matrices, extrapolated(*matrices, (len(fine) / len(coarse)) ** 0.5)
    errors = [100 * (matrix[entry] / exact - 1) for matrix in solved[key]]
    print(f"| {name} | {len(coarse)}, {len(fine)} | " + " | ".join(f"{error:+.3f} %" for error in errors) + " |")


def closed_forms():
    print("| body | triangles | coarse | fine | extrapolated |\n|---|---|---|---|---|")
    balls = [sphere(4), sphere(6)]
    row("ball, drag", balls, (0, 0), 6 * np.pi)
    row("ball, spin", balls, (3, 3), 8 * np.pi)
    for ratio in (0.2, 0.5, 2.0, 5.0):
        exact = np.diag(spheroid(ratio, 1.0, 1.0))
        surfaces = [head_surface(SpheroidHead(length=2 * ratio, diameter=2.0), n) for n in (4, 6)]
        for name, k in (("drag along", 0), ("drag across", 1), ("spin", 3), ("turning", 4)):
            row(f"spheroid 1 : {ratio:g}, {name}", surfaces, (k, k), exact[k])
    for gap in (0.5, 1.0):
        shift = np.array([2.0 + gap, 0.0, 0.0])
        pair = [joined([ball, ball.moved(np.eye(3), shift)]) for ball in (sphere(3), sphere(4))]
        row(f"two balls, gap {gap:g} radii, along", pair, (0, 0), 12 * np.pi * pair_series(2.0 + gap))
    for kind in ("floor", "surface"):
        for gap in (0.5, 1.0, 3.0):
            exact = 6 * np.pi * series(1 + gap, kind)
            row(f"ball to a {kind}, gap {gap:g} radii", balls, (2, 2), exact, Plane(kind, UP, 1 + gap))
    for height, drag, spin in ((1.5431, 1.5675, 1.0998), (2.3524, 1.3079, 1.0250)):
        plane = Plane("floor", UP, height)
        row(f"ball along a floor, gap {height - 1:.3f} radii", balls, (0, 0), 6 * np.pi * drag, plane)
        row(f"ball spinning along a floor, gap {height - 1:.3f} radii", balls, (3, 3), 8 * np.pi * spin, plane)


def near_contact():
    """How the ball's drag straight to a plane errs as the gap closes: the limit of the method near walls."""
    print("\n| gap / radius | floor, 320 | 720 | 1280 triangles | surface, 1280 |\n|---|---|---|---|---|")
    for gap in (0.5, 0.2, 0.1, 0.05):
        errors = []
        for kind, n in (("floor", 4), ("floor", 6), ("floor", 8), ("surface", 8)):
            value = surface_resistance(sphere(n), Plane(kind, UP, 1 + gap))[2, 2]
            errors.append(100 * (value / (6 * np.pi * series(1 + gap, kind)) - 1))
        print(f"| {gap:g} | " + " | ".join(f"{error:+.2f} %" for error in errors) + " |")


def helices():
    lines = [line for line in TABLE.read_text().splitlines() if not line.startswith("#")]
    print("\n| pitch / R | | experiment | boundary | off | slender body | off | Gray-Hancock | Lighthill |")
    print("|---|---|---|---|---|---|---|---|---|")
    for case in csv.DictReader(lines):
        pitch = float(case["pitch_over_R"])
        helix = Helix(length=LENGTH, pitch=pitch * RADIUS, wire_radius=WIRE, outer_diameter=2 * (RADIUS + WIRE))
        start = time.process_time()
        device = Device(magnetic_moment=1.0, helix=helix, weight=Weight(net_weight=0.0, gravity_center=0.0))
        solution = refined(device_surfaces(device), 0.02)
        seconds = time.process_time() - start
        rft = [helix_resistance(helix, 0.0, *model(helix, 1.0)) for model in (gray_hancock, lighthill)]
        for name, entry, power in (("thrust", (0, 3), 2), ("torque", (3, 3), 3), ("drag", (0, 0), 1)):
            ours, gray, light = (abs(m[entry]) / RADIUS**power for m in (solution.resistance, *rft))
            measured, slender = float(case[f"{name}_exp"]), float(case[f"{name}_sbt"])
            print(
                f"| {pitch:g} | {name} | {measured:g} | {ours:.4g} | {100 * (ours / measured - 1):+.1f} % | "
                f"{slender:g} | {100 * (ours / slender - 1):+.1f} % | {100 * (gray / measured - 1):+.0f} % | "
                f"{100 * (light / measured - 1):+.0f} % |"
            )
        error = 100 * solution.error_estimate
        print(f"|  | triangles {solution.triangles}, estimated error {error:.1f} %, {seconds:.0f} s |")


def preset():
    """The preset's matrix beside resistive-force theory and the enclosing spheroid, and what it costs."""
    scenario = hm.load("nose-first/fig3c")
    device, fluid = scenario.device, scenario.fluid
    start = time.process_time()
    solution = refined(device_surfaces(device), 0.01)
    seconds = time.process_time() - start
    matrices = hm.resistance(device, fluid), solution.resistance * fluid.viscosity, enclosing_resistance(device, fluid)
    print("\n| nose-first/fig3c | Lighthill | boundary | enclosing spheroid |\n|---|---|---|---|")
    names = {"drag along (N s/m)": (0, 0), "drag across": (1, 1), "thrust (N s)": (0, 3), "roll (N m s)": (3, 3)}
    for name, entry in names.items():
        print(f"| {name} | " + " | ".join(f"{matrix[entry]:.4g}" for matrix in matrices) + " |")
    print(f"\ntriangles {solution.triangles}, estimated error {100 * solution.error_estimate:.2f} %")
    print(f"{seconds:.1f} s of one core")
    for count, level in zip(solution.triangles, solution.levels, strict=True):
        print(f"{count:6d}: " + "  ".join(f"{fluid.viscosity * level[entry]:.5g}" for entry in names.values()))


def blobs():
    """The other candidate: a ball covered with Rotne-Prager-Yamakawa blobs, against the triangles, as many unknowns."""
    print("\n| points | blobs, drag | blobs, spin | triangles, drag | triangles, spin |\n|---|---|---|---|---|")
    for n in (2, 4, 6):
        mesh = sphere(n)
        centers = mesh.centroids / np.linalg.norm(mesh.centroids, axis=1)[:, None]
        blob = multiblob(centers, 0.5 * np.sqrt(4 * np.pi / len(mesh)))
        ours = surface_resistance(mesh)
        exact = 6 * np.pi, 8 * np.pi
        values = [m[k, k] / e - 1 for m in (blob, ours) for k, e in zip((0, 3), exact, strict=True)]
        print(f"| {len(mesh)} | " + " | ".join(f"{100 * value:+.3f} %" for value in values) + " |")


def multiblob(points, radius):
    """Resistance of blobs that touch (J. Rotne and S. Prager 1969; overlapping ones H. Yamakawa 1970)."""
    r = points[:, None] - points
    d = np.linalg.norm(r, axis=2) + np.eye(len(points))
    unit = r / d[:, :, None]
    far = d >= 2 * radius
    one = np.where(far, 3 / 4 * radius / d + radius**3 / (2 * d**3), 1 - 9 / 32 * d / radius)
    two = np.where(far, 3 / 4 * radius / d - 3 * radius**3 / (2 * d**3), 3 / 32 * d / radius)
    np.fill_diagonal(one, 1.0)
    np.fill_diagonal(two, 0.0)
    green = one[:, :, None, None] * np.eye(3) + two[:, :, None, None] * unit[:, :, :, None] * unit[:, :, None, :]
    n = len(points)
    green = green.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n) / (6 * np.pi * radius)
    motion = np.zeros((n, 3, 6))
    for k, axis in enumerate(np.eye(3)):
        motion[:, :, k] = axis
        motion[:, :, 3 + k] = np.cross(axis, points)
    motion = motion.reshape(3 * n, 6)
    return motion.T @ np.linalg.solve(green, motion)


if __name__ == "__main__":
    closed_forms()
    near_contact()
    blobs()
    preset()
    helices()
