"""The device's outline as a camera sees it: the share of each pixel that it covers."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from helimag.vision.cameras import Camera
from helimag.vision.shape import Shape

Floats = NDArray[np.float64]
Box = tuple[int, int, int, int]

FINE = 4  # rays each way of a pixel that the outline crosses
EDGE = 0.75  # distance of a pixel's centre from the outline from which it lies on one side (px)
DENSE = 12  # points a millimetre of wire: a third of a wire's radius apart


def outline(camera: Camera, position: Floats, rotation: Floats, shape: Shape, margin: float = 8.0) -> Box | None:
    """Box of pixels (left, top, right, bottom) around the device; None where the camera cannot see it.

    Parameters
    ----------
    position, rotation
        (n, 3) in m and (n, 3, 3) from body to lab: the poses that the box must hold.
    """
    ends = np.stack([position + rotation[..., 0] * reach for reach in (shape.nose, shape.tail)])
    pixels = camera.project(ends).reshape(-1, 2)
    if not np.all(np.isfinite(pixels)):
        return None
    room = margin + shape.width * float(camera.scale(position[:1])[0])
    left, top = np.floor(pixels.min(axis=0) - room).astype(int)
    right, bottom = np.ceil(pixels.max(axis=0) + room).astype(int) + 1
    return int(left), int(top), int(right), int(bottom)


def silhouette(camera: Camera, position: Floats, rotation: Floats, shape: Shape, box: Box) -> Floats:
    """Share of each pixel of a box that the device covers, without blur: (bottom - top, right - left).

    A ray meets the wire where it passes the wire's centreline at less than its radius, and the head,
    an ellipsoid of revolution, where it passes inside its outline. Pixels on the outline are
    divided into a fine grid.

    Parameters
    ----------
    position, rotation
        (3,) of the head's centre in m, and (3, 3) from body to lab.
    """
    left, top, right, bottom = box
    pixels = np.stack(np.meshgrid(np.arange(left, right, dtype=float), np.arange(top, bottom, dtype=float)), axis=-1)
    scale = float(camera.scale(position[None])[0])
    count = 1 + int(DENSE * 1e3 * shape.helix_length * np.hypot(1.0, 2.0 * np.pi * shape.helix_radius / shape.pitch))
    wire = KDTree(camera.project(shape.wire(count) @ rotation.T + position))
    head = _head(camera, position, rotation[:, 0], shape, scale)

    def inside(rays: Floats) -> Floats:
        """How deep rays pass inside the outline (px, negative outside, no less than -2)."""
        near, _ = wire.query(rays, distance_upper_bound=shape.wire_radius * scale + 2.0)
        return np.asarray(np.maximum(np.maximum(shape.wire_radius * scale - near, -2.0), head(rays)))

    depth = inside(pixels.reshape(-1, 2))
    covered = (depth > 0.0).astype(float)
    edge = np.flatnonzero(np.abs(depth) < EDGE)
    steps = (np.arange(FINE) + 0.5) / FINE - 0.5
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    fine = inside((pixels.reshape(-1, 2)[edge][:, None] + grid).reshape(-1, 2))
    covered[edge] = np.clip(0.5 + FINE * fine, 0.0, 1.0).reshape(-1, FINE * FINE).mean(axis=1)
    return np.asarray(covered.reshape(bottom - top, right - left))


def _head(camera: Camera, position: Floats, axis: Floats, shape: Shape, scale: float) -> Callable[[Floats], Floats]:
    """How deep rays pass inside the head's outline (px), about."""
    centre, ahead = camera.project(np.stack([position, position + 1e-4 * axis]))
    seen = (ahead - centre) / 1e-4  # pixels a metre along the axis, foreshortened
    size = max(float(np.linalg.norm(seen)), 1e-9)
    along, cosine = seen / size, min(size / scale, 1.0)
    reach = scale * np.hypot(shape.head_reach * cosine, shape.head_radius * np.sqrt(1.0 - cosine**2))
    radius = scale * shape.head_radius
    frame = np.stack([along / reach, np.array([-along[1], along[0]]) / radius], axis=1)

    def inside(rays: Floats) -> Floats:
        return np.asarray(min(reach, radius) * (1.0 - np.linalg.norm((rays - centre) @ frame, axis=-1)))

    return inside
