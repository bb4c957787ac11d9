"""Measured beside simulated: known shifts are found, gains and verdicts agree, uncertainty is carried."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from command_line import Said
from helimag.cli import app
from helimag.engine import simulate
from helimag.errors import InputError
from helimag.runs.comparison import compare
from helimag.runs.measurement import attack_windows, output, unseen
from helimag.runs.trajectory import Trajectory
from helimag.scenario import load
from helimag.vision import staged


def noisy(
    run: Trajectory,
    spread: float,
    *,
    every: int = 3,
    yaw: float = 0.0,
    move: tuple[float, ...] = (0, 0, 0),
    late: float = 0.0,
    seed: int = 0,
) -> Trajectory:
    """A run as a measurement might give it: fewer samples, noise, another frame, another clock."""
    time = run.dataset["time"].values[::every]
    cos, sin = np.cos(yaw), np.sin(yaw)
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    position = run.dataset["position"].values[::every] @ turn.T + np.array(move)
    position = position + np.random.default_rng(seed).normal(0.0, spread, position.shape)
    variables = {
        "position": position,
        "position_covariance": np.broadcast_to(spread**2 * np.eye(3), (time.size, 3, 3)),
        "attack_angle": run.dataset["attack_angle"].values[::every],
        "attack_angle_sd": np.full(time.size, 1e-3),
    }
    return Trajectory.from_arrays(time + late, variables, {"name": "m", "initial_gap": 0.102, "end": "horizon"})


def test_known_alignment_is_found() -> None:
    simulated = staged("wobbling", duration=8.0)
    measured = noisy(simulated, 1e-5, yaw=0.1, move=(0.003, -0.002, 0.001), late=0.0)
    found = compare(measured, simulated, align="fit")
    assert found.yaw == pytest.approx(0.1, abs=1e-4)
    assert found.time_shift == 0.0
    assert found.numbers["difference_rms_m"] == pytest.approx(1e-5 * np.sqrt(3.0), rel=0.1)
    assert found.numbers["share_within_95"] == pytest.approx(0.95, abs=0.03)


def test_delay_beyond_the_common_start_is_found() -> None:
    simulated = staged("wobbling", duration=8.0)
    measured = noisy(simulated, 1e-6)
    cut = Trajectory(measured.dataset.isel(time=slice(50, None)))  # the film begins 1.5 s into the run
    found = compare(cut, simulated, align="fit")
    assert found.time_shift == pytest.approx(0.0, abs=0.03)
    assert found.numbers["difference_rms_m"] < 5e-5


def test_alignment_at_the_start_and_none() -> None:
    simulated = staged("held", duration=4.0)
    measured = noisy(simulated, 0.0, move=(0.001, 0.0, 0.002), late=7.0)
    assert compare(measured, simulated, align="start").translation == pytest.approx([0.001, 0.0, 0.002], abs=1e-9)
    with pytest.raises(InputError, match="overlap in time"):
        compare(measured, simulated, align="none")
    with pytest.raises(InputError, match="fit, start or none"):
        compare(measured, simulated, align="best")  # type: ignore[arg-type]


def test_gain_does_not_depend_on_the_alignment() -> None:
    simulated = staged("falling", duration=4.0)
    measured = noisy(simulated, 0.0, every=1, yaw=0.3, move=(0.1, 0.2, 0.3))
    numbers = compare(measured, simulated).numbers
    assert numbers["measured"]["gain"] == pytest.approx(numbers["simulated"]["gain"], rel=1e-12)
    assert numbers["agrees"]


def test_runs_that_differ_do_not_agree() -> None:
    found = compare(noisy(staged("held", duration=4.0), 1e-5), staged("falling", duration=4.0))
    assert not found.agrees
    assert found.numbers["difference_rms_m"] > 1e-3


@pytest.mark.parametrize("spread", [5e-6, 5e-5])
def test_interval_of_the_output_covers_the_truth(spread: float) -> None:
    run = staged("held", duration=6.0)
    true = output(noisy(run, 0.0)).value
    sizes = [output(noisy(run, spread, seed=seed)) for seed in range(40)]
    assert sum(size.low <= true <= size.high for size in sizes) >= 38
    assert np.mean([size.high - size.low for size in sizes]) < 20.0 * spread  # and is of use


def test_windows_of_the_attack_angle() -> None:
    run = staged("wobbling", duration=8.0)
    windows = attack_windows(run, count=4)
    assert np.degrees(windows.mean) == pytest.approx(-6.0, abs=0.6)
    assert np.degrees(windows.wobble) == pytest.approx(7.5 / np.sqrt(2.0), rel=0.05)
    with pytest.raises(InputError, match="count"):
        attack_windows(run, count=0)


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simulated = staged("wobbling", duration=4.0)
    simulated.save(tmp_path / "s.nc")
    noisy(simulated, 1e-5).save(tmp_path / "m.nc")
    app(["compare", str(tmp_path / "m.nc"), str(tmp_path / "s.nc"), "--json"])
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["measured"]["verdict"] == numbers["simulated"]["verdict"]
    low, high = numbers["measured"]["gain_95"]
    assert low < numbers["measured"]["gain"] < high
    assert numbers["agrees"] == (low <= numbers["simulated"]["gain"] <= high)
    app(["compare", str(tmp_path / "m.nc"), str(tmp_path / "s.nc")])
    assert "verdict" in capsys.readouterr().out


def test_figure() -> None:
    pytest.importorskip("matplotlib")
    from helimag.plots.compare import draw_comparison

    simulated = staged("wobbling", duration=4.0)
    figure = draw_comparison(compare(noisy(simulated, 1e-5), simulated, align="none"))
    height = figure.axes[2]
    drawn = np.concatenate([line.get_ydata() for line in height.lines[:1]])
    assert drawn.min() == pytest.approx(1e3 * simulated.dataset["position"].values[:, 2].min(), abs=0.05)


def test_what_no_frame_shows_lengthens_a_steady_fall_by_a_frame_at_each_end() -> None:
    time = np.arange(20) / 30.0
    assert unseen(time, -5e-3 * time, 1.0 / 30.0) == pytest.approx(2.0 * 5e-3 / 30.0)
    assert unseen(time, np.full(20, 0.01), 1.0 / 30.0) == pytest.approx(0.0, abs=1e-15)


def test_a_turn_inside_a_gap_is_allowed_for() -> None:
    time = np.array([0.0, 0.1, 0.2, 0.8, 0.9, 1.0])
    height = np.array([0.0, 1e-3, 2e-3, 2e-3, 1e-3, 0.0])
    assert 1e-3 < unseen(time, height, 0.1) < 4e-3


def cut(run: Trajectory, first: int, last: int | None = None) -> Trajectory:
    return Trajectory(run.dataset.isel(time=slice(first, last)))


def test_only_the_common_time_is_set_beside_each_other() -> None:
    """A run that falls after the film's end: gain and verdict are those of what the film shows, on both sides."""
    simulated = staged("falling", duration=8.0)
    film = cut(noisy(simulated, 0.0, every=1), 0, 100)
    found = compare(film, simulated, align="none")
    z = simulated.dataset["position"].values[:100, 2]
    assert found.simulated_output == pytest.approx(np.ptp(z), rel=1e-12)
    assert found.simulated_gain == pytest.approx(found.measured_gain.value, rel=1e-12)
    assert np.ptp(simulated.dataset["position"].values[:, 2]) > 2.0 * np.ptp(z)
    numbers = found.numbers
    time = simulated.dataset["time"].values
    assert numbers["left_out_s"]["simulated"] == pytest.approx(time[-1] - time[99])
    assert numbers["left_out_s"]["measured"] == 0.0
    assert numbers["simulated"]["verdict"] == numbers["measured"]["verdict"]


def test_a_measurement_longer_than_the_simulation_is_cut_too() -> None:
    simulated = staged("falling", duration=8.0)
    found = compare(noisy(simulated, 0.0, every=1), cut(simulated, 50, 120), align="none")
    z = simulated.dataset["position"].values[50:120, 2]
    assert found.measured_output.value == pytest.approx(np.ptp(z), rel=1e-12)
    assert found.simulated_output == pytest.approx(np.ptp(z), rel=1e-12)
    assert found.numbers["agrees"]


def test_extremes_before_the_common_time_do_not_count() -> None:
    """What was recorded between samples belongs to the interval before a sample: the first one's lies outside."""
    simulated = staged("held", duration=4.0)
    height = simulated.dataset["position"].values[:, 2]
    low, high = height - 1e-6, height + 1e-6
    low[60] = height[60] - 0.05
    recorded = Trajectory(simulated.dataset.assign(height_low=("time", low), height_high=("time", high)))
    found = compare(cut(noisy(simulated, 0.0, every=1), 60), recorded, align="none")
    assert found.simulated_output < 2e-3


def test_a_simulation_in_place_of_a_measurement_is_named(capsys, tmp_path) -> None:
    simulated = staged("held", duration=4.0)
    simulated.save(tmp_path / "run.nc")
    measured = Trajectory(simulated.dataset.assign_attrs(source="measured"))
    measured.save(tmp_path / "film.nc")
    assert compare(measured, simulated).really_measured
    assert not compare(simulated, simulated).really_measured
    for name, said in (("run.nc", True), ("film.nc", False)):
        app(["compare", str(tmp_path / name), str(tmp_path / "run.nc")])
        assert ("the run taken as measured is a simulation itself" in capsys.readouterr().out) is said


def test_a_track_without_standard_deviations_claims_no_interval(tmp_path: Path, helimag: Callable[..., Said]) -> None:
    rows = "\n".join(f"{0.1 * k:.1f},{0.8e-1 * k:.4f},0,{-0.03 * k:.4f}" for k in range(40))
    (tmp_path / "t.csv").write_text(f"time [s],x [mm],y [mm],z [mm]\n{rows}\n")
    said = helimag("vision", "import", tmp_path / "t.csv", "--gap", "102 mm", "-o", tmp_path / "t.nc")
    assert "95 % interval not known: the track has no standard deviations" in said.out
    assert "settled" not in said.out
    staged("held", duration=4.0).save(tmp_path / "s.nc")
    words = ("compare", tmp_path / "t.nc", tmp_path / "s.nc", "--align", "start")
    assert "measured 95 % interval not known" in helimag(*words).out
    numbers = json.loads(helimag(*words, "--json").out)
    assert numbers["measured"]["gain_95"] is numbers["measured"]["output_y_95_m"] is numbers["agrees"] is None
    assert numbers["measured"]["gain"] == pytest.approx(1.17 / 102.0, rel=1e-6)


def kept(run: Trajectory, begin: float, end: float, *, clock: float = 0.0) -> Trajectory:
    """The part of a run from one time to another (s), its clock put back by some time."""
    time = run.dataset["time"].values
    part = run.dataset.isel(time=(time >= begin - 1e-9) & (time <= end + 1e-9))
    return Trajectory(part.assign_coords(time=part["time"].values - clock))


def test_a_comparison_of_little_says_so(helimag: Callable[..., Said], tmp_path: Path) -> None:
    """Two runs that share 0.04 s; and a clock that the fit puts back by 1 s of 4 s. Whole ones are silent."""
    whole = staged("wobbling", duration=10.0)
    first, later = kept(whole, 0.0, 4.0), kept(whole, 3.96, 9.9)
    barely = compare(later, first, align="none")
    assert set(barely.doubts) == {"few samples", "little in common"}
    samples = barely.time.size
    assert samples < 10
    assert barely.doubts["few samples"] == f"only {samples} samples are set beside each other"
    assert f"{100.0 * np.ptp(barely.time) / 4.0:.0f} % of the shorter run" in barely.doubts["little in common"]
    shifted = compare(kept(whole, 1.0, 5.0, clock=1.0), first)
    assert shifted.time_shift == pytest.approx(-1.0)
    assert set(shifted.doubts) == {"clocks shifted"}
    assert "by 1.00 s, 33 % of the time" in shifted.doubts["clocks shifted"]
    assert compare(kept(whole, 1.0, 5.0), first, align="start").doubts == {}
    assert compare(kept(whole, 0.0, 4.0), first).doubts == {}
    later.save(tmp_path / "m.nc")
    first.save(tmp_path / "s.nc")
    words = ("compare", tmp_path / "m.nc", tmp_path / "s.nc", "--align", "none")
    for doubt in barely.doubts.values():
        assert f"note          {doubt}" in helimag(*words).out
        assert doubt in json.loads(helimag(*words, "--json").out)["doubts"]


def test_a_shift_that_is_not_bracketed_says_so() -> None:
    """The film begins 4 s into a run of which the first 5 s are known: half of them must stay, so 2.5 s is the last."""
    whole = staged("falling", duration=10.0)
    found = compare(kept(whole, 4.0, 9.0, clock=4.0), kept(whole, 0.0, 5.0))
    assert abs(found.time_shift) == pytest.approx(2.5, abs=0.06)
    assert "shift at its limit" in found.doubts


def test_runs_that_are_too_short_to_tell_do_not_agree_on_how_they_end() -> None:
    """The gains are the same; whether the device stays is not known of either."""
    run = simulate(load("paper/fig3c").replaced({"run.duration": 5.0}))
    covariance = np.broadcast_to(1e-12 * np.eye(3), (run.dataset.sizes["time"], 3, 3))
    measured = run.dataset.assign(position_covariance=(("time", "row", "column"), covariance))
    found = compare(Trajectory(measured.assign_attrs(source="measured")), run, align="none")
    low, high = found.measured_gain.interval or (0.0, 0.0)
    assert low <= found.simulated_gain <= high
    assert found.numbers["measured"]["verdict"] == found.numbers["simulated"]["verdict"] == "undecided"
    assert found.agrees is None
