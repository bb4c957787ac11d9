"""Where the magnet is at the stages of a step."""

import math

import numpy as np
import pytest
import warp as wp

import helimag as hm
from helimag.engine import DOP853, advance, tableau
from helimag.engine.control import pack_controls
from helimag.engine.medium import OPEN_WATER
from helimag.engine.packing import pack_drives
from helimag.engine.poses import LONGEST, StageSpins, build_stage_spins, poses_of
from helimag.engine.stages import STAGES
from helimag.physics.kinematics import ArmMotion, RpmPose, rpm_pose

SHARES = (*tableau.C[:STAGES], 1.0)


def test_stages_of_a_step_are_at_cosines_and_sines_of_their_angles():
    stage_spins = build_stage_spins()

    @wp.kernel(enable_backward=False, module="unique")
    def each(angles: wp.array(dtype=wp.float64), found: wp.array(dtype=StageSpins)):
        found[wp.tid()] = stage_spins(angles[wp.tid()])

    angles = np.linspace(-1.0, 1.0, 41) * 2.0 * math.pi * LONGEST
    found = wp.zeros(len(angles), dtype=StageSpins, device="cpu")
    wp.launch(each, dim=len(angles), inputs=[wp.array(angles, dtype=wp.float64, device="cpu"), found], device="cpu")
    parts = np.outer(angles, SHARES)
    cosines, sines = found.numpy().transpose(1, 0, 2)
    np.testing.assert_allclose(cosines, np.cos(parts), rtol=0.0, atol=3e-16)
    np.testing.assert_allclose(sines, np.sin(parts), rtol=4e-16, atol=0.0)


def test_poses_at_stages_are_those_of_their_times():
    poses = poses_of(rpm_pose)
    instant, ahead, at_stage = poses.instant, poses.ahead, poses.at_stage

    @wp.kernel(enable_backward=False, module="unique")
    def both(drive: wp.array(dtype=ArmMotion), h: wp.float64, found: wp.array(dtype=RpmPose)):
        i = wp.tid()
        shares = wp.static(wp.types.vector(length=STAGES, dtype=wp.float64)(*SHARES[:STAGES]))
        t = wp.float64(700.0)
        found[2 * i] = at_stage(drive[0], instant(drive[0], t), ahead(drive[0], h), i, shares[i] * h)
        found[2 * i + 1] = rpm_pose(drive[0], t + shares[i] * h)

    run = hm.load("paper/fig3c").replaced(
        {"drive.pitch": 0.2, "drive.yaw_rate": 0.9, "drive.velocity": (0.0, 0.0, 1e-3)}
    )
    found = wp.zeros(2 * STAGES, dtype=RpmPose, device="cpu")
    step = LONGEST / run.drive.frequency
    wp.launch(both, dim=STAGES, inputs=[pack_drives([run], "cpu"), step, found], device="cpu")
    for part in ("position", "spin", "rotation"):
        ours, theirs = found.numpy()[part][::2], found.numpy()[part][1::2]
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=3e-12)  # of spins of 14,000 rad, with rounded times
        assert np.ptp(theirs, axis=0).max() > 1e-3


@pytest.mark.parametrize(("frequency", "yaw_rate"), [(3.3, 0.03), (-2.0, 0.0), (0.5, 8.0), (0.5, -8.0)])
def test_no_step_goes_on_farther_than_the_series_do(frequency, yaw_rate):
    """Neither by the spin nor by a yaw that is faster."""
    run = hm.load("paper/fig3c").replaced({"drive.frequency": frequency, "drive.yaw_rate": yaw_rate})
    (control,) = pack_controls([run], 1.0, OPEN_WATER.longest_step)
    fastest = max(2.0 * math.pi * abs(frequency), abs(yaw_rate))
    assert control["longest"] * fastest == pytest.approx(2.0 * math.pi * LONGEST)


@pytest.mark.parametrize("tolerance", [1e-5, 3e-7])
def test_slips_that_long_steps_pass_over_are_counted(tolerance):
    """At 870 s the field swings past nearly along the device's axis, where ends of steps miss seven slips and more."""
    run = hm.load("paper/fig3b").replaced({"run.duration": 905.0})
    coarse, fine = (advance([run], method=DOP853, tolerance=value)[0] for value in (tolerance, 1e-10))
    assert fine.slips[-1] > 2400
    assert abs(coarse.slips[-1] - fine.slips[-1]) < 6
