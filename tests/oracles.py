"""The model once more, in plain NumPy and SciPy, written from its description, not from the package.

A case is a plain dictionary of SI numbers; :func:`scenario_of` writes it as a scenario file, for the package to read.
"""

from itertools import pairwise

import numpy as np
from scipy.integrate import quad_vec, solve_ivp

import helimag as hm
from helimag.scenario import parse

# Fig. 3(C) of the paper, with the effective values of the preset
BASE = {
    "length": 0.0117,
    "diameter": 0.00094,
    "pitch": 0.00259,
    "wire": 0.0002128,
    "left": True,
    "rft": "lighthill",
    "head": 0.0003603,
    "viscosity": 1.0,
    "fluid_density": 971.0,
    "moment": 6.23e-4,
    "weight": 28.28e-6,
    "gravity_center": -2.189e-3,
    "densities": None,  # of helix and head, instead of the two above
    "magnets": [((0.0, 0.0, 0.0), 18.89)],
    "frequency": 3.3,
    "beta": np.radians(12.7),
    "distance": 0.150,
    "yaw": np.radians(1.8),
    "velocity": (0.0, 0.0, 0.0),
    "about": "origin",
    "start": (0.0, -0.045, 0.0),
    "matrix": None,  # a given resistance
}
GRAVITY = 9.80665


def case(**changes):
    """The base case with changes."""
    assert not changes.keys() - BASE.keys(), "no such parameter"
    return BASE | changes


def scenario_of(c, extra=""):
    """The case as the package reads it, through the text of a file."""
    if c["densities"] is None:
        weight = f'net_weight = "{c["weight"]!r} N"\ngravity_center = "{c["gravity_center"]!r} m"'
    else:
        weight = f'helix_density = "{c["densities"][0]!r} kg/m^3"\nhead_density = "{c["densities"][1]!r} kg/m^3"'
    if c["matrix"] is None:
        hydrodynamics = f'model = "{c["rft"]}"'
    else:
        hydrodynamics = f'model = "matrix"\nresistance = {np.asarray(c["matrix"], float).tolist()}'
    magnets = "\n".join(
        f'[[magnet]]\nmoment = "{moment!r} A m^2"\nradius = "17.5 mm"\nheight = "20 mm"\noffset = {_metres(offset)}'
        for offset, moment in c["magnets"]
    )
    return parse(f"""
[device]
magnetic_moment = "{c["moment"]!r} A m^2"
[device.helix]
length = "{c["length"]!r} m"
outer_diameter = "{c["diameter"]!r} m"
pitch = "{c["pitch"]!r} m"
wire_radius = "{c["wire"]!r} m"
handedness = "{"left" if c["left"] else "right"}"
[device.head]
shape = "sphere"
radius = "{c["head"]!r} m"
[device.weight]
{weight}
[device.hydrodynamics]
{hydrodynamics}
[fluid]
viscosity = "{c["viscosity"]!r} Pa s"
density = "{c["fluid_density"]!r} kg/m^3"
{magnets}
[drive]
frequency = "{c["frequency"]!r} Hz"
pitch = "{float(c["beta"])!r} rad"
distance = "{c["distance"]!r} m"
yaw_rate = "{float(c["yaw"])!r} rad/s"
velocity = {_metres(c["velocity"], "m/s")}
pitch_about = "{c["about"]}"
start = {_metres(c["start"])}
{extra}
""")


def _metres(vector, unit="m"):
    return [f"{float(x)!r} {unit}" for x in vector].__repr__().replace("'", '"')


def run(c, duration, **options):
    """The package's trajectory of a case."""
    return hm.simulate(scenario_of(c), duration=duration, **options)


# ---------------------------------------------------------------------------------------------------- hydrodynamics


def drag_per_length(c):
    """Along and across the wire: the two classical sets of coefficients."""
    turn = np.hypot(c["pitch"], 2 * np.pi * (c["diameter"] / 2 - c["wire"]))
    mu, a = c["viscosity"], c["wire"]
    if c["rft"] == "lighthill":
        q = 0.18 * turn
        return 2 * np.pi * mu / np.log(q / a), 4 * np.pi * mu / (np.log(q / a) + 0.5)
    ratio = 2 * c["pitch"] / a
    return 2 * np.pi * mu / (np.log(ratio) - 0.5), 4 * np.pi * mu / (np.log(ratio) + 0.5)


def resistance(c):
    """6x6 about the head's centre: load of each unit motion, by adaptive quadrature along the wire."""
    if c["matrix"] is not None:
        return np.asarray(c["matrix"], float)
    along, across = drag_per_length(c)
    radius, k, chi = c["diameter"] / 2 - c["wire"], 2 * np.pi / c["pitch"], 1.0 if c["left"] else -1.0
    matrix = np.zeros((6, 6))

    def loads(u):
        place = np.array([-c["head"] - u, radius * np.cos(k * u), chi * radius * np.sin(k * u)])
        slope = np.array([-1.0, -radius * k * np.sin(k * u), chi * radius * k * np.cos(k * u)])
        ds = np.linalg.norm(slope)
        t = slope / ds
        columns = []
        for motion in np.eye(6):
            velocity = motion[:3] + cross(motion[3:], place)
            tangential = t * (t @ velocity)
            force = along * tangential + across * (velocity - tangential)
            columns.append(np.concatenate([force, cross(place, force)]) * ds)
        return np.array(columns).T

    edges = np.append(np.arange(0.0, c["length"], c["pitch"]), c["length"])
    for low, high in pairwise(edges):
        matrix += quad_vec(loads, low, high, epsrel=1e-12, epsabs=1e-25)[0]
    drag, spin = 6 * np.pi * c["viscosity"] * c["head"], 8 * np.pi * c["viscosity"] * c["head"] ** 3
    return matrix + np.diag([drag] * 3 + [spin] * 3)


def weight_and_place(c):
    """Net weight (N) and where along the axis it acts (m), from the parts where densities are given."""
    if c["densities"] is None:
        return c["weight"], c["gravity_center"]
    radius = c["diameter"] / 2 - c["wire"]
    contour = c["length"] / c["pitch"] * np.hypot(c["pitch"], 2 * np.pi * radius)
    volumes = np.array([np.pi * c["wire"] ** 2 * contour, 4 / 3 * np.pi * c["head"] ** 3])
    places = np.array([-c["head"] - c["length"] / 2, 0.0])
    excess = (np.array(c["densities"]) - c["fluid_density"]) * volumes
    return GRAVITY * excess.sum(), (excess * places).sum() / excess.sum()


# --------------------------------------------------------------------------------------------------------- kinematics


def turn(axis, angle):
    """Rotation matrix about a coordinate axis."""
    cos, sin = np.cos(angle), np.sin(angle)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = cos
    matrix[i, j], matrix[j, i] = -sin, sin
    return matrix


def cross(a, b):
    """Vector product; ten times as fast as NumPy's for single vectors."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def matrix_of(q):
    """Rotation matrix of a quaternion w, x, y, z (Euler-Rodrigues)."""
    w, x, y, z = np.asarray(q) / np.linalg.norm(q)
    matrix = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2 * w * matrix + 2 * matrix @ matrix


def quaternion_of(matrix):
    """Quaternion w, x, y, z of a rotation matrix, from the eigenvector of Bar-Itzhack's symmetric matrix."""
    m = np.asarray(matrix)
    k = np.array(
        [
            [m[0, 0] + m[1, 1] + m[2, 2], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [0, m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [0, 0, m[1, 1] - m[0, 0] - m[2, 2], m[1, 2] + m[2, 1]],
            [0, 0, 0, m[2, 2] - m[0, 0] - m[1, 1]],
        ]
    )
    return np.linalg.eigh(k + np.triu(k, 1).T)[1][:, -1]


def rpm(c, t):
    """Positions of the magnets (n, 3) and their common moment axis at time t."""
    yaw = turn("z", c["yaw"] * t)
    arm = yaw @ turn("y", -c["beta"])
    above = np.add(c["start"], [0, 0, c["distance"]])
    centre = (arm if c["about"] == "origin" else yaw) @ above + np.array(c["velocity"]) * t
    spin = 2 * np.pi * c["frequency"] * t
    return np.array([centre + arm @ np.array(o) for o, _ in c["magnets"]]), arm @ [0, np.cos(spin), np.sin(spin)]


# ------------------------------------------------------------------------------------------------------------- dynamics


def field_and_force(r, big, m):
    """Field of a dipole ``big`` at ``r`` and the force on the dipole ``m`` there."""
    d2 = r @ r
    d = np.sqrt(d2)
    field = 1e-7 * (3 * r * (r @ big) / d2 - big) / (d2 * d)
    force = 3e-7 / d2**2 / d * (r @ m * big + r @ big * m + big @ m * r - 5 * (r @ m) * (r @ big) * r / d2)
    return field, force


def loads(c, t, position, rotation):
    """Force and torque (lab) on the device about the centre of its head, drag excepted."""
    places, axis = rpm(c, t)
    m = c["moment"] * rotation[:, 1]
    force, torque = np.zeros(3), np.zeros(3)
    for place, (_, moment) in zip(places, c["magnets"], strict=True):
        field_j, force_j = field_and_force(position - place, moment * axis, m)
        force += force_j
        torque += cross(m, field_j)
    weight, at = weight_and_place(c)
    down = np.array([0.0, 0.0, -weight])
    return force + down, torque + cross(at * rotation[:, 0], down)


def right_hand_side(c):
    """Rates of (position, quaternion) as a function of time and state."""
    mobility = np.linalg.inv(resistance(c))
    weight, place = weight_and_place(c)
    c = c | {"densities": None, "weight": weight, "gravity_center": place}

    def rates(t, y):
        rotation = matrix_of(y[3:])
        force, torque = loads(c, t, y[:3], rotation)
        motion = mobility @ np.concatenate([rotation.T @ force, rotation.T @ torque])
        omega = rotation @ motion[3:]
        w, v = y[3], y[4:]
        # rotation by omega in the lab: q' = (0, omega) q / 2
        return np.concatenate([rotation @ motion[:3], [-omega @ v / 2], (w * omega + cross(omega, v)) / 2])

    return rates


def start_of(c):
    """Level along x, at the start."""
    return np.array([*c["start"], 1.0, 0.0, 0.0, 0.0])


def solve(c, times, state=None, events=None, rtol=1e-12):
    """States at ``times`` by SciPy's DOP853: (n, 7)."""
    y0 = start_of(c) if state is None else np.asarray(state, float)
    return solve_ivp(
        right_hand_side(c),
        (0.0, times[-1]),
        y0,
        method="DOP853",
        t_eval=times,
        rtol=rtol,
        atol=[1e-2 * rtol] * 3 + [rtol] * 4,
        events=events,
    )


def states_of(trajectory):
    """Positions and quaternions of a trajectory (n, 7)."""
    data = trajectory.dataset
    return np.concatenate([data.position.values, data.quaternion.values], axis=1)


def attitude_difference(a, b):
    """Largest entry of the difference between two attitudes given as quaternions."""
    return np.abs(matrix_of(a) - matrix_of(b)).max()
