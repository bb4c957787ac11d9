"""A run as the page draws it: arrays of 32-bit numbers in one packet, behind a line that says what they are."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from helimag.diagnosis import forces_along
from helimag.geometry import CHIRALITY, helix_line, magnet_motion
from helimag.runs import Trajectory
from helimag.scenario import CylinderHead, Device, Scenario, parse

Floats = NDArray[np.float64]

MOST = 900  # samples that a picture has
FORCES = 181  # instants at which forces are computed; they change slowly


@dataclass(frozen=True)
class Picture:
    """Header and arrays (n,) or (n, k) of one run."""

    header: dict[str, Any]
    arrays: dict[str, Floats]

    @property
    def packet(self) -> bytes:
        """Length of the header (4 bytes), the header as JSON, blanks up to a multiple of 4, then all arrays."""
        columns = {name: list(values.shape) for name, values in self.arrays.items()}
        head = json.dumps({**self.header, "columns": columns}).encode()
        head += b" " * (-len(head) % 4)
        body = b"".join(np.ascontiguousarray(values, dtype="<f4").tobytes() for values in self.arrays.values())
        return len(head).to_bytes(4, "little") + head + body


def pictured(run: Trajectory) -> Picture:
    """A simulated run thinned to what a page can show: lengths in mm, angles in degrees, forces in uN."""
    scenario = parse(run.scenario_toml or "")
    data = {str(name): np.asarray(values.values) for name, values in run.dataset.data_vars.items()}
    time = np.asarray(run.dataset["time"].values, dtype=np.float64)
    chosen = np.unique(np.linspace(0, time.size - 1, min(MOST, time.size)).round().astype(int))
    poses = magnet_motion(scenario.drive)(time[chosen])
    slips = np.diff(data["slips"][chosen], prepend=data["slips"][0]) > 0
    arrays = {
        "time": time[chosen],
        "position": 1e3 * data["position"][chosen],
        "nose": data["long_axis"][chosen],
        "magnet": 1e3 * poses.position,
        "axis": poses.axis,
        "across": poses.rotation[:, :, 1],
        "spin": np.remainder(poses.spin, 2.0 * np.pi),
        "low": 1e3 * data["height_low"][chosen],
        "high": 1e3 * data["height_high"][chosen],
        "gap": 1e3 * data["gap"][chosen],
        "attack": np.degrees(data["attack_mean"][chosen]),
        "lag": np.where(slips, np.nan, np.degrees(data["phase_lag"][chosen])),
        **_forces(scenario, time, data),
    }
    return Picture(_header(scenario, run), arrays)


def _forces(scenario: Scenario, time: Floats, data: dict[str, Floats]) -> dict[str, Floats]:
    some = np.unique(np.linspace(0, time.size - 1, min(FORCES, time.size)).round().astype(int))
    found = forces_along(scenario, time[some], data["position"][some], data["long_axis"][some])
    return {
        "forces_time": time[some],
        "pull": 1e6 * found.pull[:, 2],
        "weight": 1e6 * found.weight[:, 2],
        "thrust": 1e6 * found.thrust[:, 2],
        "thrust_vector": 1e6 * found.thrust,
        "field_axis": found.field_axis,
    }


def _header(scenario: Scenario, run: Trajectory) -> dict[str, Any]:
    magnets = [
        {
            "radius": 1e3 * magnet.radius,
            "height": 1e3 * magnet.height,
            "offset": [1e3 * x for x in magnet.offset],
            "phase": magnet.phase or 0.0,
        }
        for magnet in scenario.magnet
    ]
    workspace = scenario.workspace
    box = [[None if not np.isfinite(x) else 1e3 * x for x in corner] for corner in workspace.box]
    return {
        "title": scenario.title,
        "verdict": str(run.verdict),
        "frequency": scenario.drive.frequency,
        "duration": scenario.run.duration,
        "start": 1e3 * float(scenario.drive.start[2]),
        "magnets": magnets,
        "box": box,
        "device": _device(scenario.device),
    }


def _device(device: Device) -> dict[str, Any]:
    """The device in its own frame (mm): the wire's centreline, its thickness, the head's outline about the axis."""
    shape: dict[str, Any] = {"wire": [], "wire_radius": 0.0, "profile": [], "length": 1e3 * device.length}
    if device.helix is not None:
        helix = device.helix
        along = np.linspace(0.0, helix.length, int(16 * helix.length / helix.pitch) + 2)
        line = helix_line(
            along,
            radius=helix.radius,
            pitch=helix.pitch,
            chirality=CHIRALITY[helix.handedness],
            behind=device.helix_start,
        )
        shape |= {"wire": (1e3 * line).round(4).tolist(), "wire_radius": 1e3 * helix.wire_radius}
    head = device.head
    if isinstance(head, CylinderHead):
        reach, radius = 1e3 * head.reach, 1e3 * head.radius
        shape["profile"] = [[-reach, 0.0], [-reach, radius], [reach, radius], [reach, 0.0]]
    elif head is not None:
        polar = np.linspace(0.0, np.pi, 17)
        outline = np.stack([-head.reach * np.cos(polar), head.radius * np.sin(polar)], axis=1)
        shape["profile"] = (1e3 * outline).round(5).tolist()
    if device.body is not None:
        shape["triangles"] = (1e3 * np.asarray(device.body.corners)).reshape(-1).round(4).tolist()
    return shape


def overlaid(run: Trajectory) -> Picture:
    """A run to lay over the live one, simulated or measured: what it has of time, place, gap and attack angle."""
    data = run.dataset
    time = np.asarray(data["time"].values, dtype=np.float64)
    chosen = np.unique(np.linspace(0, time.size - 1, min(MOST, time.size)).round().astype(int))
    position = 1e3 * np.asarray(data["position"].values)[chosen]
    arrays = {"time": time[chosen], "position": position}
    scales = {"gap": ("gap", 1e3), "attack": ("attack_angle", 180.0 / np.pi), "lag": ("phase_lag", 180.0 / np.pi)}
    for name, (variable, scale) in scales.items():
        if variable in data:
            arrays[name] = scale * np.asarray(data[variable].values, dtype=np.float64)[chosen]
    arrays |= {"low": position[:, 2], "high": position[:, 2]}
    return Picture({"title": str(data.attrs.get("name", "run"))}, arrays)
