"""Samples within a step: the polynomial beside SciPy's own, runs beside those that step to each sample."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scipy.integrate import DOP853 as SCIPY_DOP853

import helimag as hm
import oracles
from helimag.engine import DOP853, KEPT, Control, system_of
from helimag.engine.dense import build_course, state_at
from helimag.engine.methods import build_dop853
from helimag.engine.packing import pack_bodies, pack_drives, pack_magnets
from helimag.engine.system import build_rates
from helimag.physics.balance import OpenWater, Swimmer
from helimag.physics.kinematics import ArmMotion, State
from helimag.physics.magnetics import FieldSource

LONG = 0.005  # s: a sixtieth of a turn


def test_states_within_a_step_are_scipys():
    """One step of DOP853 and its dense output, with the equations as the oracles have them."""
    case = oracles.case()
    run = oracles.scenario_of(case)
    system = system_of(run)
    trial, course, rates = build_dop853(system), build_course(system), build_rates(system)

    @wp.kernel(enable_backward=False, module="unique")
    def stepped(
        body: wp.array(dtype=Swimmer),
        drive: wp.array(dtype=ArmMotion),
        magnets: wp.array(dtype=FieldSource),
        start: wp.array(dtype=State),
        shares: wp.array(dtype=wp.float64),
        found: wp.array(dtype=State),
    ):
        kept = wp.zeros(shape=KEPT, dtype=State)
        t, h, here, control = wp.float64(0.1), wp.float64(LONG), OpenWater(), Control()
        k0 = rates(body[0], here, drive[0], magnets, t, start[0])
        end, error = trial(body[0], here, drive[0], magnets, control, t, h, start[0], k0, kept)
        way = course(body[0], here, drive[0], magnets, t, h, start[0], kept)
        for i in range(shares.shape[0]):
            found[i] = state_at(way, t + shares[i] * h)
        found[shares.shape[0]] = end

    shares = np.linspace(0.0, 1.0, 21)
    start = oracles.start_of(case)
    inputs = [
        wp.array(pack_bodies([run]), dtype=Swimmer, device="cpu"),
        pack_drives([run], "cpu"),
        wp.array(pack_magnets([run])[0], dtype=FieldSource, device="cpu"),
        wp.array(start[None], dtype=State, device="cpu"),
        wp.array(shares, dtype=wp.float64, device="cpu"),
    ]
    out = wp.zeros(shares.size + 1, dtype=State, device="cpu")
    wp.launch(stepped, dim=1, inputs=[*inputs, out], device="cpu")
    found = out.numpy()

    theirs = SCIPY_DOP853(oracles.right_hand_side(case), 0.1, start, 1.0, first_step=LONG, rtol=1.0, atol=1e9)
    theirs.step()
    assert theirs.t == pytest.approx(0.1 + LONG, abs=1e-15)
    expected = theirs.dense_output()(0.1 + LONG * shares).T
    expected[:, 3:] /= np.linalg.norm(expected[:, 3:], axis=1, keepdims=True)
    print(abs(found[:-1] - expected).max(0), abs(found[-2] - found[-1]).max(0), abs(expected[-1] - expected[0]))
    assert np.abs(found[:-1, :3] - expected[:, :3]).max() < 1e-14
    assert np.abs(found[:-1, 3:] - expected[:, 3:]).max() < 1e-9
