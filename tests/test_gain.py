"""Gain, verdict, wobble and attack angle on heights made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from helimag.errors import InputError
from helimag.outcomes import End, Reason, Verdict
from helimag.runs import Heights, SlowTimes, judge, judge_each
from helimag.runs.trajectory import Trajectory

TIME = np.linspace(0.0, 1800.0, 1801)
GAP = 0.150
SLOW = SlowTimes(lap=200.0, fold=150.0)  # 1000 s decide


def heights(mean, *, end=End.HORIZON, amplitude=0.0, time=TIME, attack=0.0, square=None, slips=0, slow=SLOW):
    mean = np.broadcast_to(np.asarray(mean, float), time.shape).copy()
    attack = np.broadcast_to(np.asarray(attack, float), time.shape).copy()
    return Heights(
        time=time.copy(),
        low=mean - amplitude,
        high=mean + amplitude,
        mean=mean,
        attack=attack,
        attack_square=attack**2 if square is None else square,
        slips=slips,
        initial_gap=GAP,
        end=end,
        slow=slow,
    )


def test_runs_judged_together_are_judged_as_by_themselves():
    """Bit for bit, whichever run is beside which; means of the attack angle beside sums made here, sample by sample."""
    random = np.random.default_rng(3)
    runs = []
    for count in random.choice([1, 21, 100, 101], 60).tolist():
        time = np.sort(random.uniform(0.0, 100.0, count))
        mean = random.choice([1e-6, 1e-3]) * random.normal(size=count).cumsum() - random.choice([0.0, 1e-3]) * time
        end, square = random.choice([End.HORIZON, End.CONTACT, End.FALL]), random.normal(size=count) ** 2
        runs.append(heights(mean, time=time, end=End.of(end), attack=random.normal(size=count), square=square + 4.0))
    runs[3].low[0], runs[7].attack[-1] = np.nan, np.inf
    runs[5] = replace(runs[5], initial_gap=0.0)
    together = judge_each(runs)
    assert [place for place, said in enumerate(together.said) if said is None] == [3, 5, 7]
    for place, run in enumerate(runs):
        number = {name: values[place] for name, values in together.numbers.items()}
        if together.said[place] is None:
            assert np.isnan(list(number.values())).all()
            with pytest.raises(InputError):
                judge(run)
            continue
        alone, (cause, told) = judge(run), together.said[place]
        assert (alone.cause, alone.reason) == (cause, cause.text(**told))
        for name in number.keys() - {"height_change"}:
            value = getattr(alone, name)
            assert np.array_equal(number[name], np.nan if value is None else value, equal_nan=True), name
        assert number["height_change"] == run.mean[-1] - run.mean[0]
        assert alone.output == max(run.high) - min(run.low)
        late = [i for i in range(len(run.time)) if run.time[i] >= (run.time[0] + run.time[-1]) / 2.0]
        spans = [run.time[i] - run.time[i - 1] if i else 0.0 for i in late] if run.time.size > 1 else [1.0]
        mean, square = (
            sum(s * values[i] for s, i in zip(spans, late, strict=True)) / sum(spans)
            for values in (run.attack, run.attack_square)
        )
        assert alone.attack_angle == pytest.approx(mean, rel=1e-12, abs=1e-15)
        assert alone.wobble == pytest.approx(np.sqrt(max(square - mean**2, 0.0)), rel=1e-10)


def test_gain_is_the_range_of_heights_over_the_initial_gap():
    result = judge(heights(0.01 * np.sin(TIME), amplitude=0.002))
    assert result.output == pytest.approx(0.024, rel=1e-3)
    assert result.gain == result.output / 0.150
    assert result.input == GAP


def test_bounded():
    settled = judge(heights(-0.02 * (1 - np.exp(-TIME / 100.0)), amplitude=0.003))
    assert settled.verdict is Verdict.BOUNDED
    assert settled.escape_time is None
    assert "settled" in settled.reason
    assert judge(heights(0.0)).verdict is Verdict.BOUNDED


def test_swinging_steadily_is_bounded():
    assert judge(heights(0.02 * np.sin(2 * np.pi * TIME / 200.0))).verdict is Verdict.BOUNDED


@pytest.mark.parametrize(
    "mean",
    [
        -0.03 * TIME / 1800.0,  # steadily down
        0.03 * TIME / 1800.0,  # steadily up
        -0.03 * (1 - np.exp(-TIME / 2000.0)),  # settling, but far from it
        1e-4 * np.exp(TIME / 300.0),  # running away
    ],
)
def test_drifting(mean):
    result = judge(heights(mean))
    assert result.verdict is Verdict.DRIFTING
    assert result.escape_time is None
    assert ("rises" if mean[-1] > 0 else "sinks") in result.reason or "swings ever more" in result.reason


@pytest.mark.parametrize("period", [200.0, 100.0, 40.0])
def test_swinging_ever_more_is_drifting(period):
    result = judge(heights(0.01 * np.exp((TIME - 1800) / 600.0) * np.sin(2 * np.pi * TIME / period)))
    assert result.verdict is Verdict.DRIFTING
    assert "swings ever more" in result.reason


def test_fell_with_the_time_it_passed_the_line():
    result = judge(heights(-0.150 * TIME / 1800.0))
    assert result.verdict is Verdict.FELL
    assert result.escape_time == pytest.approx(900.0, abs=2.0)


def test_deep_but_coming_back_has_not_fallen():
    mean = np.where(TIME < 900, -0.1 * TIME / 900, -0.1 * (1800 - TIME) / 900)
    assert judge(heights(mean)).verdict is not Verdict.FELL
    # deep and steady is not falling either
    assert judge(heights(-0.1 * (1 - np.exp(-TIME / 50.0)))).verdict is Verdict.BOUNDED


def test_end_of_a_fall():
    result = judge(heights(-0.300 * TIME / 1800.0, end=End.FALL))
    assert result.verdict is Verdict.FELL
    assert result.escape_time == pytest.approx(450.0, abs=2.0)


def test_attracted():
    result = judge(heights(0.1 * (TIME / 1800.0) ** 4, end=End.CONTACT))
    assert result.verdict is Verdict.ATTRACTED
    assert result.escape_time == 1800.0
    assert "1800.0 s" in result.reason


@pytest.mark.parametrize("end", [End.FLOOR, End.SURFACE, End.WALL])
def test_wall_limited(end):
    result = judge(heights(0.0, end=end))
    assert result.verdict is Verdict.WALL_LIMITED
    assert str(end) in result.reason


def test_wobble_and_attack_angle_are_those_of_the_second_half():
    attack = np.where(TIME < 900.0, 1.0, -0.1 + 0.05 * np.sqrt(2.0) * np.sin(2 * np.pi * TIME / 37.0))
    result = judge(heights(0.0, attack=attack))
    assert result.attack_angle == pytest.approx(-0.1, abs=2e-3)
    assert result.wobble == pytest.approx(0.05, abs=1e-3)


def test_wobble_within_samples_counts():
    """Means of the square over each interval hold what happens between samples."""
    result = judge(heights(0.0, attack=0.2, square=np.full(TIME.shape, 0.2**2 + 0.03**2)))
    assert result.wobble == pytest.approx(0.03, rel=1e-9)


def test_uneven_samples_weigh_by_their_time():
    time = np.array([0.0, 1.0, 2.0, 3.0, 10.0])
    attack = np.array([0.0, 0.0, 0.0, 0.0, 0.7])
    assert judge(heights(0.0, time=time, attack=attack)).attack_angle == pytest.approx(0.7)


def test_measured_heights_have_nothing_between_frames():
    """A trajectory of time and position alone is judged by the same code."""
    position = np.zeros((TIME.size, 3))
    position[:, 2] = -0.02 * (1 - np.exp(-TIME / 100.0))
    known = {"initial_gap": GAP, "end": "horizon"}
    measured = Trajectory.from_arrays(TIME, {"position": position}, known)
    assert measured.verdict is Verdict.UNDECIDED
    assert measured.judgement.cause is Reason.SLOWNESS_UNKNOWN
    slow = Trajectory.from_arrays(TIME, {"position": position}, known | {"fold_time": 150.0, "lap_time": 200.0})
    assert slow.verdict is Verdict.BOUNDED
    assert measured.gain == pytest.approx(0.02 / 0.150, rel=1e-6)
    assert measured.judgement.slips == 0


@pytest.mark.parametrize("count", [1, 2, 3])
def test_very_short_runs_are_judged(count):
    result = judge(heights(0.0, time=TIME[:count]))
    assert result.verdict is Verdict.UNDECIDED
    assert result.cause is Reason.TOO_SHORT
    assert np.isfinite([result.gain, result.wobble, result.attack_angle]).all()


@pytest.mark.parametrize("name", ["time", "low", "high", "mean", "attack", "attack_square"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, None])
def test_what_is_not_finite_or_empty_is_refused(name, bad):
    run = heights(0.0)
    values = getattr(run, name)
    if bad is None:
        object.__setattr__(run, name, values[:0])
    else:
        values[5] = bad
    with pytest.raises(InputError, match=name):
        judge(run)


@pytest.mark.parametrize("gap", [0.0, -0.1, np.nan])
def test_gap_must_be_positive(gap):
    run = heights(0.0)
    object.__setattr__(run, "initial_gap", gap)
    with pytest.raises(InputError, match="gain"):
        judge(run)


def test_a_few_samples_do_not_tell_whether_a_run_has_settled():
    for count, verdict in ((20, Verdict.UNDECIDED), (21, Verdict.BOUNDED)):
        result = judge(heights(0.0, time=np.linspace(0.0, 1800.0, count)))
        assert result.verdict is verdict
        assert ("too few" in result.reason) == (count == 20)


def test_angles_of_the_second_half_are_means_over_time_not_over_samples():
    """Beside a sum by hand over intervals of all lengths; a run of one sample has that sample's."""
    random = np.random.default_rng(4)
    time = np.concatenate([[0.0], np.cumsum(random.uniform(0.1, 10.0, 400))])
    attack, more = random.normal(0.2, 0.1, time.size), random.uniform(0.01, 0.02, time.size)
    result = judge(heights(0.0, time=time, attack=attack, square=attack**2 + more))
    late = [i for i in range(1, time.size) if time[i] >= time[-1] / 2.0]
    total = sum(time[i] - time[i - 1] for i in late)
    mean = sum((time[i] - time[i - 1]) * attack[i] for i in late) / total
    square = sum((time[i] - time[i - 1]) * (attack[i] ** 2 + more[i]) for i in late) / total
    assert result.attack_angle == pytest.approx(mean, rel=1e-12)
    assert result.wobble == pytest.approx(np.sqrt(square - mean**2), rel=1e-9)
    alone = judge(heights(0.0, time=np.array([5.0]), attack=0.3, end=End.CONTACT))
    assert alone.attack_angle == pytest.approx(0.3, rel=1e-15)
