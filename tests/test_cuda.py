"""The kernels on a GPU: the same runs as on the CPU. Without one, that they compile for it, and a clear refusal."""

import numpy as np
import pytest
import warp as wp

import helimag as hm
from command_line import run as helimag
from helimag.engine import DOP853, MULTIREVOLUTION, advance, system_of
from helimag.engine.loop import build_advance
from helimag.engine.observe import build_observe
from helimag.orbits.strobe.period import build_pass

GPU = wp.is_cuda_available()
needs_gpu = pytest.mark.skipif(not GPU, reason="no CUDA device on this machine")
SHORT = hm.load("paper/fig3c").replaced({"run.duration": "20 s"})
IN_TANK = SHORT.replaced({"workspace.floor": "-50 mm", "workspace.surface": "30 mm"})
HELD = IN_TANK.replaced({"workspace.contact": "hold", "drive.start.z": "-49 mm"})

NEAR = IN_TANK.replaced({"device.hydrodynamics.model": "boundary", "device.hydrodynamics.near_walls": True})


def same(one, other, within=1e-9):
    """Whether two batches of histories end alike; the processors round differently."""
    for a, b in zip(one, other, strict=True):
        assert (a.status, a.time.size) == (b.status, b.time.size)
        assert np.abs(a.states - b.states).max() < within


@needs_gpu
@pytest.mark.parametrize("scenario", [SHORT, IN_TANK, HELD, NEAR], ids=["open water", "tank", "held", "near walls"])
def test_a_run_is_the_same_on_the_gpu(scenario):
    same(*(advance([scenario], method=DOP853, device=device) for device in ("cuda", "cpu")))


@needs_gpu
def test_leaps_are_the_same_on_the_gpu():
    """Less closely than steps: how far a leap goes is a whole number, by an error that is rounded differently."""
    long = SHORT.replaced({"run.duration": "100 s"})
    same(*(advance([long], device=device) for device in ("cuda", "cpu")), within=1e-8)


@needs_gpu
def test_a_batch_of_different_runs_is_the_same_on_the_gpu():
    batch = [SHORT.replaced({"drive.frequency": f"{2.0 + 0.05 * i} Hz"}) for i in range(40)] + [HELD]
    same(*(advance(batch, method=DOP853, device=device) for device in ("cuda", "cpu")))


@needs_gpu
def test_a_run_goes_from_the_command_to_the_gpu(tmp_path):
    found = helimag(
        "simulate", "paper/fig3c", "--duration=20 s", "--device=cuda", "--no-orbit", "-o", tmp_path / "r.nc"
    )
    assert found.code == 0
    there = hm.Trajectory.load(tmp_path / "r.nc").dataset.position.values
    assert np.abs(there - hm.simulate(SHORT).dataset.position.values).max() < 1e-8


@pytest.mark.skipif(GPU, reason="this machine has a CUDA device")
@pytest.mark.parametrize("device", ["cuda", "cuda:0"])
def test_without_a_gpu_it_is_refused_in_one_line(device):
    with pytest.raises(hm.InputError, match=rf"device must be one of this machine's, cpu; got '{device}'"):
        advance([SHORT], device=device)


def compiled(kernel, folder):
    """What a kernel's code for a GPU enters by: by Warp's own compiler, which needs none."""
    (made,) = wp.compile_aot_module(kernel.module, arch=80, module_dir=folder, use_ptx=True)
    return " ".join(line for line in made.read_text(encoding="utf-8").splitlines() if ".visible .entry" in line)


@pytest.mark.parametrize("scenario", [SHORT, HELD, NEAR], ids=["open water", "walls that hold", "drag near walls"])
def test_formulas_compile_for_a_gpu_that_is_not_there(scenario, tmp_path):
    """What only a CPU's compiler takes is found without a GPU."""
    assert "observe_" in compiled(build_observe(system_of(scenario)), tmp_path)


@pytest.mark.nightly
@pytest.mark.parametrize("scenario", [SHORT, HELD], ids=["open water", "walls that hold"])
@pytest.mark.parametrize("method", [DOP853, MULTIREVOLUTION], ids=["direct", "leaps"])
def test_the_time_loop_compiles_for_a_gpu_that_is_not_there(scenario, method, tmp_path):
    assert "advance_" in compiled(build_advance(system_of(scenario), method), tmp_path)


@pytest.mark.nightly
def test_the_map_of_a_turn_compiles_for_a_gpu_that_is_not_there(tmp_path):
    assert "pass" in compiled(build_pass(system_of(SHORT), DOP853, False), tmp_path)
