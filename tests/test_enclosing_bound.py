"""The drag of an enclosing body bounds a device's drag; resistive-force theory of the paper's device breaks it."""

import numpy as np
import pytest

import helimag as hm
from helimag.hydrodynamics.bounds import enclosing_resistance, enclosing_spheroid, moved, violates
from helimag.hydrodynamics.heads import ball, head_resistance, spheroid
from helimag.hydrodynamics.resistive_force import centerline
from helimag.scenario import CylinderHead, SphereHead, SpheroidHead

HEADS = [
    SphereHead(radius=3.6e-4),
    SphereHead(radius=2e-3),
    SpheroidHead(length=4e-3, diameter=8e-4),
    CylinderHead(length=1e-3, diameter=3e-3),
]


def device_with(head):
    return hm.load("nose-first/fig3c").device.model_copy(update={"head": head})


@pytest.mark.parametrize("head", HEADS)
def test_spheroid_holds_every_point_of_the_device(head):
    """Points on wire and head, made from their definitions, lie inside."""
    device = device_with(head)
    center, axial, radial = enclosing_spheroid(device)
    line, tangents, _ = centerline(device.helix, head.reach)
    rng = np.random.default_rng(1)
    sideways = np.cross(tangents, rng.normal(size=line.shape))
    wire = line + device.helix.wire_radius * sideways / np.linalg.norm(sideways, axis=1)[:, None]
    s = np.linspace(-1.0, 1.0, 201)
    profile = {"sphere": np.sqrt(1 - s * s), "spheroid": np.sqrt(1 - s * s), "cylinder": np.ones_like(s)}[head.shape]
    nose = np.stack([head.reach * s, head.radius * profile, 0 * s], axis=1)
    for points in (wire, nose):
        inside = ((points[:, 0] - center) / axial) ** 2 + (points[:, 1] ** 2 + points[:, 2] ** 2) / radial**2
        assert inside.max() < 1.0 + 1e-12
    assert radial < 4.0 * max(head.radius, device.helix.outer_diameter / 2)  # and it is no wasteful bound


@pytest.mark.parametrize("head", HEADS)
def test_the_head_alone_is_below_the_bound_in_every_motion(head):
    fluid = hm.load("nose-first/fig3c").fluid
    bound = enclosing_resistance(device_with(head), fluid)
    size = np.sqrt(np.outer(np.diag(bound), np.diag(bound)))
    assert np.linalg.eigvalsh((bound - head_resistance(head, fluid.viscosity)) / size).min() > 0.0


def test_resistive_force_theory_of_the_presets_breaks_it():
    scenario = hm.load("nose-first/fig3c")
    bound = enclosing_resistance(scenario.device, scenario.fluid)
    rft = hm.resistance(scenario.device, scenario.fluid)
    assert violates(rft, bound)
    assert rft[0, 0] > 2.0 * bound[0, 0]
    assert not violates(ball(1e-4, scenario.fluid.viscosity), bound)


def test_moved_is_the_motion_of_the_other_point():
    """Force and torque about the origin of a body that turns about it, worked out from its own centre."""
    matrix, place = spheroid(2.0, 1.0, 1.0), np.array([0.3, -0.7, 1.1])
    v, w = np.array([0.2, 0.5, -0.4]), np.array([1.0, -0.3, 0.6])
    local = matrix @ np.concatenate([v + np.cross(w, place), w])
    expected = np.concatenate([local[:3], local[3:] + np.cross(place, local[:3])])
    np.testing.assert_allclose(moved(matrix, place) @ np.concatenate([v, w]), expected, rtol=1e-14)
