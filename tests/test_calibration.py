"""Calibration: plans read and refused, smooth ends of runs, known devices found again, files, predictions, commands."""

import json
import math
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import helimag as hm
from helimag import calibration as cal
from helimag.calibration.escapes import ENDS, log_stay, log_time, ways
from helimag.calibration.problem import prepared
from helimag.engine import DOP853, advance
from helimag.errors import FileError, InputError
from helimag.outcomes import End
from helimag.scenario import parse

sys.path.insert(0, str(Path(__file__).parent.parent / "benchmarks"))
import calibration_kills

# a light, quick device: ten turns of the magnet, half a second of drag theory
BASE = hm.load("paper/table1-row1").replaced(
    {
        "device.hydrodynamics.model": "lighthill",
        "device.hydrodynamics.tolerance": None,
        "workspace": {},
        "run.duration": 6.0,
        "run.interval": 0.25,
        "provenance": {},
    }
)
TRUTH = {"fluid.viscosity": 1.05, "device.weight.net_weight": 52e-6}
SDS = {"rise": 8e-5, "attack_angle": math.radians(1.0), "speed": 3e-5}


def observations(scenario, random):
    """What a lab would measure of a scenario: each number with an error drawn from its sd."""
    (history,) = advance([scenario])
    numbers = {what: cal.NUMBERS[what].value(history, scenario.run.duration) for what in SDS}
    return [
        {"what": what, "value": numbers[what] + sd * random.standard_normal(), "sd": sd, "source": "drawn"}
        for what, sd in SDS.items()
    ]


FREE = [
    {"input": "fluid.viscosity", "prior": "normal", "mean": "1 Pa s", "sd": "0.1 Pa s", "low": "0.5 Pa s"},
    {"input": "device.weight.net_weight", "prior": "uniform", "low": "40 uN", "high": "60 uN"},
]


def plan_of(observed, *, free=FREE, particles=64, seed=0, base=BASE, **more):
    run = {"name": "row1", "base": base, "observed": observed}
    return cal.CalibrationPlan.model_validate({"run": [run], "free": free, "particles": particles, "seed": seed} | more)


@pytest.fixture(scope="module")
def known():
    return plan_of(observations(hm.scenario.varied(BASE, TRUTH), np.random.default_rng(0)))


@pytest.fixture(scope="module")
def fit(known):
    return cal.calibrate(known)


# ends of runs ----------------------------------------------------------------------------------------------------


def ended(**changes):
    (history,) = advance([BASE.replaced({"run.duration": 300.0, "run.interval": 0.5, **changes})])
    return history


@pytest.fixture(scope="module")
def runs():
    """One for each end, by its name."""
    heavy, light = {"device.weight.net_weight": 4e-4}, {"device.weight.net_weight": 1e-6}
    return {
        "attracted": ended(**light),
        "fell": ended(**heavy),
        "floor": ended(**heavy, **{"workspace.floor": -0.03}),
        "surface": ended(**light, **{"workspace.surface": 0.02}),
        "wall": ended(**{"workspace.walls.x": (-0.05, 0.03), "drive.velocity": (0.005, 0.0, 0.0)}),
    }


@pytest.mark.parametrize("what", ["attracted", "floor", "surface", "wall"])
def test_the_way_to_an_end_is_nought_there(runs, what):
    """The engine's own events are the oracle: where it stopped a run, nothing of the way to that end is left."""
    history = runs[what]
    assert history.status is ENDS[what]
    left = ways(history.scenario, float(history.time[-1]), history.states[-1])[ENDS[what]]
    assert abs(left) < 2e-5
    assert log_time(history, ENDS[what]) == pytest.approx(math.log(history.time[-1]))
    assert log_stay(history) == pytest.approx(math.log(history.time[-1]))


def test_a_device_falls_where_it_passes_half_the_gap(runs):
    history = runs["fell"]
    when = math.exp(log_time(history, End.FALL))
    line = history.states[0, 2] - 0.5 * 0.102
    assert np.interp(when, history.time, history.states[:, 2]) == pytest.approx(line, abs=1e-5)
    assert log_stay(history) == log_time(history, End.FALL)
    assert history.judge().escape_time == pytest.approx(when, abs=1.1)  # the judgement takes a later sample


@pytest.mark.parametrize("what", ["attracted", "fell", "floor", "surface", "wall"])
def test_times_go_on_smoothly_beyond_the_horizon(runs, what):
    """A horizon just before and just after the end give the same time; one much before, a later one, and finite."""
    history, end = runs[what], ENDS[what]
    when = math.exp(log_time(history, end))
    before, after, early = advance(
        [history.scenario.replaced({"run.duration": when * share}) for share in (1.0 - 1e-5, 1.0 + 1e-5, 0.5)]
    )
    assert log_time(before, end) == pytest.approx(math.log(when), abs=0.03)
    assert log_time(after, end) == pytest.approx(math.log(when), abs=0.02)
    assert math.log(0.5 * when) < log_time(early, end) < math.log(0.5 * when) + 2.0


def test_another_end_is_further_away_the_sooner_it_came(runs):
    """Of two devices that fall, neither was attracted; the one that fell first is further from it."""
    sooner = ended(**{"device.weight.net_weight": 8e-4})
    assert sooner.time[-1] < runs["fell"].time[-1]
    assert math.log(300.0) < log_time(runs["fell"], End.CONTACT) < log_time(sooner, End.CONTACT) < 20.0


@pytest.mark.parametrize(("what", "good"), [("attracted", "light"), ("fell", "heavy"), ("stays", "middle")])
def test_no_end_is_impossible_and_the_right_device_likelier(what, good):
    """Over four decades of weight each likelihood is finite, and highest where the device does what was seen."""
    base = BASE.replaced({"run.duration": 60.0, "run.interval": 0.5, "fluid.viscosity": 0.3})
    seen = {"what": what, "source": "seen"} | ({"time": 60.0} if what == "stays" else {})
    problem = prepared(plan_of([seen], free=[FREE[1] | {"low": "1 uN", "high": "1000 uN"}], base=base))
    weights = {"light": 1e-6, "middle": 50e-6, "heavy": 1e-3}
    found, _ = problem.evaluate(np.array([[weight] for weight in weights.values()]))
    assert np.isfinite(found).all()
    assert list(weights)[int(np.argmax(found))] == good
    assert np.ptp(found) > 1.0


# the likelihood ----------------------------------------------------------------------------------------------------


def test_the_likelihood_is_that_of_normal_errors(known):
    """Written out: sum of normal log-densities of what the runs give, from SciPy."""
    from scipy import stats

    problem = prepared(known)
    values = np.array([[1.0, 50e-6], [1.1, 45e-6]])
    found, _ = problem.evaluate(values)
    for row, each in zip(values, found, strict=True):
        changes = {"fluid.viscosity": row[0], "device.weight.net_weight": row[1]}
        (history,) = advance([BASE.replaced(changes)])
        run = hm.simulate(BASE.replaced(changes)).dataset
        place = run["position"].values
        numbers = {
            "rise": place[-1, 2] - place[0, 2],
            "attack_angle": history.judge().attack_angle,
            "speed": np.hypot(*(place[-1, :2] - place[0, :2])) / 6.0,
        }
        wanted = sum(stats.norm(numbers[one.what], one.sd).logpdf(one.value) for one in known.run[0].observed)
        assert each == pytest.approx(wanted, rel=1e-9)


def test_other_numbers_are_those_of_the_judgement():
    """And half of a run's are those of a run half as long, where both take the same steps."""
    (history,) = advance([BASE], method=DOP853)
    judgement = history.judge()
    of = {what: observable.value(history, 6.0) for what, observable in cal.NUMBERS.items()}
    assert of["output"] == pytest.approx(judgement.output, rel=1e-12)
    assert of["gain"] == pytest.approx(judgement.gain, rel=1e-12)
    assert of["attack_angle"] == pytest.approx(judgement.attack_angle, rel=1e-12)
    assert of["depth"] == pytest.approx(-history.heights.low.min(), rel=1e-12)
    half = cal.NUMBERS["output"].value(history, 3.0)
    (short,) = advance([BASE.replaced({"run.duration": 3.0})], method=DOP853)
    assert half == pytest.approx(short.judge().output, rel=1e-6)


def test_a_track_is_its_positions(tmp_path):
    """The run itself as the track, moved by three standard deviations in y: 9/2 of each sample, whichever its clock."""
    base = BASE.replaced({"drive.start": (1e-3, 2e-3, 0.0)})
    run = hm.simulate(base)
    run.dataset["position"][:, 1] += 3e-4
    run.save(tmp_path / "track.nc")
    track = {"what": "track", "file": str(tmp_path / "track.nc"), "sd": 1e-4, "samples": 8, "source": "camera"}
    values = np.array([[1.0, 50.5147e-6]])

    def loss(align):
        problem = prepared(plan_of([track | {"align": align}], base=base))
        (found,), _ = problem.evaluate(values)
        (expected,) = problem.flat
        return found + np.log(1e-4 * np.sqrt(2.0 * np.pi)) * expected.observed.size, expected.observed.size

    assert loss("none") == (pytest.approx(-0.5 * 9.0 * 8, abs=1e-6), 24)
    assert loss("start")[0] == pytest.approx(0.0, abs=1e-6)


def test_factors_and_inputs_of_some_runs_only():
    """A factor multiplies each run's own value; what belongs to one run leaves the other alone."""
    free = [
        {"input": "magnet.moment", "prior": "uniform", "low": 0.9, "high": 1.1, "factor": True},
        {"input": "drive.start.z", "prior": "uniform", "low": "-1 mm", "high": "1 mm", "runs": ["two"]},
    ]
    stays = [{"what": "stays", "source": "seen"}]
    two = {"name": "two", "base": BASE, "changes": {"magnet.moment": "10 A m^2"}, "observed": stays}
    plan = cal.CalibrationPlan.model_validate(
        {"run": [{"name": "one", "base": BASE, "observed": stays}, two], "free": free}
    )
    one, other = prepared(plan).scenarios_at([1.05, 5e-4])
    assert (one.magnet[0].moment, other.magnet[0].moment) == (pytest.approx(1.05 * 18.89), pytest.approx(10.5))
    assert (one.drive.start[2], other.drive.start[2]) == (0.0, 5e-4)
    assert prepared(plan).units == ("1", "m")


# fits --------------------------------------------------------------------------------------------------------------


def test_known_devices_are_found_again():
    """Six random devices, each observed with errors: the 90 % region holds the truth in four or more (six random cases
    do so with a probability of 98 %; the seed is fixed). ``benchmarks/calibration.py`` does thirty."""
    random = np.random.default_rng(5)
    problem = prepared(plan_of([{"what": "stays", "source": "seen"}]))
    held = 0
    for seed in range(6):
        truth = problem.from_unit(random.random(2))
        scenario = hm.scenario.varied(BASE, dict(zip(TRUTH, truth.tolist(), strict=True)))
        plan = plan_of(observations(scenario, random), seed=seed, particles=40)
        (at_truth,), _ = prepared(plan).evaluate(truth[None])
        held += cal.calibrate(plan).likely(float(at_truth))
    assert 4 <= held <= 6


def test_a_posterior_is_that_of_a_grid(known, fit):
    """Mean and deviation of each input beside sums over a fine grid of the prior's probability."""
    problem = prepared(known)
    shares = (np.arange(24) + 0.5) / 24
    cells = problem.from_unit(np.stack(np.meshgrid(shares, shares), axis=-1).reshape(-1, 2))
    found, _ = problem.evaluate(cells)
    weights = np.exp(found - found.max())
    mean = np.average(cells, weights=weights, axis=0)
    deviation = np.sqrt(np.average((cells - mean) ** 2, weights=weights, axis=0))
    np.testing.assert_allclose((fit.samples.mean(axis=0) - mean) / deviation, 0.0, atol=0.5)
    np.testing.assert_allclose(fit.samples.std(axis=0) / deviation, 1.0, atol=0.35)


def test_a_fit_in_and_out_of_its_file(fit, tmp_path):
    import xarray

    fit.save(tmp_path / "fit.nc")
    with xarray.open_dataset(tmp_path / "fit.nc", engine="h5netcdf") as opened:
        assert opened["samples"].dims == ("sample", "input")
        assert opened["input"].values.tolist() == ["fluid.viscosity", "device.weight.net_weight"]
    again = cal.Posterior.load(tmp_path / "fit.nc")
    for name in ("samples", "loglikelihood", "logprior", "prior", "observed", "sd", "side", "predicted"):
        assert np.array_equal(getattr(again, name), getattr(fit, name)), name
    assert again.plan.run[0].base == BASE
    assert (again.names, again.labels, again.evidence) == (fit.names, fit.labels, fit.evidence)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda data: data.assign_attrs(format="else"), "is not a calibration"),
        (lambda data: data.assign_attrs(plan="= ="), "damaged"),
        (lambda data: data.assign_attrs(plan=data.attrs["plan"].replace("net_weight", "gravity_center")), "damaged"),
        (lambda data: data.drop_vars("samples"), "damaged"),
        (lambda data: data.assign(samples=data["samples"] * np.nan), "not all finite"),
        (lambda data: data.isel(sample=slice(1)), "two samples"),
        (lambda data: data.assign(samples=data["samples"].T), "dimensions"),
    ],
)
def test_a_damaged_fit_is_refused(fit, tmp_path, damage, said):
    from helimag.runs import write_netcdf

    write_netcdf(damage(fit.dataset()), tmp_path / "bad.nc")
    with pytest.raises(InputError, match=said):
        cal.Posterior.load(tmp_path / "bad.nc")


class StoppedError(Exception):
    """Raised by a test's own progress."""


def test_a_stopped_calibration_goes_on_to_the_same_numbers(known, fit, tmp_path):
    steps = []

    def stop(done):
        steps.append(done)
        if len(steps) == 5:
            raise StoppedError

    with pytest.raises(StoppedError):
        cal.calibrate(known, output=tmp_path / "fit.nc", progress=stop)
    assert (tmp_path / "fit.nc.partial").exists()
    assert not (tmp_path / "fit.nc").exists()
    with pytest.raises(FileError, match="another plan"):
        cal.calibrate(known.model_copy(update={"seed": 9}), output=tmp_path / "fit.nc")
    after = []
    again = cal.calibrate(known, output=tmp_path / "fit.nc", progress=after.append)
    assert np.array_equal(again.samples, fit.samples)
    assert again.evaluations == fit.evaluations
    assert after == sorted(after)
    assert after[-1] == 1.0
    assert not (tmp_path / "fit.nc.partial").exists()
    (tmp_path / "fit.nc.partial").write_bytes(b"PK nothing")
    with pytest.raises(FileError, match="cannot be read"):
        cal.calibrate(known, output=tmp_path / "fit.nc")


def test_killed_and_resumed_is_the_same_bit_for_bit(tmp_path):
    """The same with 20 kills: ``benchmarks/calibration_kills.py``. What a killed writer left beside is cleared away."""
    (tmp_path / ".killed.nc.partial.abc.part").write_bytes(b"half")
    (tmp_path / ".other.nc.abc.part").write_bytes(b"of another")
    found = calibration_kills.torture(tmp_path, kills=2, particles=40)
    assert found["kills"] == 2
    assert found["resumed"]
    assert found["same"]
    assert found["odd"] == []
    assert found["left"] == [".other.nc.abc.part"]


def test_what_the_data_cannot_tell():
    """The product of both moments counts, so that they trade off; a floor far below does nothing at all."""
    free = [
        {"input": "device.magnetic_moment", "prior": "log-uniform", "low": "0.5 mA m^2", "high": "0.7 mA m^2"},
        {"input": "magnet.moment", "prior": "log-uniform", "low": "15 A m^2", "high": "23 A m^2"},
        {"input": "workspace.floor", "prior": "uniform", "low": "-2 m", "high": "-1 m"},
    ]
    (history,) = advance([BASE])
    rise = cal.NUMBERS["rise"].value(history, 6.0)
    observed = [{"what": "rise", "value": rise, "sd": 2e-5, "source": "drawn"}]
    found = cal.findings(cal.calibrate(plan_of(observed, free=free)))
    assert "workspace.floor" in found.open
    assert [(one, two) for one, two, r in found.tied if r < -0.8] == [("device.magnetic_moment", "magnet.moment")]
    said = " ".join(found.sentences)
    assert "workspace.floor: the data tell nothing beyond the prior" in said
    assert "device.magnetic_moment and magnet.moment trade off against each other" in said


def test_an_observation_that_no_device_fits_is_named(fit):
    from dataclasses import replace

    moved = replace(fit, observed=fit.observed + np.array([1.0, 0.0, 0.0]))
    assert [label for label, _ in cal.findings(moved).missed] == ["row1: rise"]
    assert cal.findings(fit).missed == ()
    good = replace(moved, side=np.array([-1.0, 0.0, 0.0]))  # all below is as good
    assert cal.findings(good).missed == ()


def test_the_next_run_is_the_one_that_is_most_open(fit):
    """A longer run leaves more open than the same again, since the rise goes on."""
    from dataclasses import replace

    candidates = (
        cal.Candidate(name="the same", base=BASE),
        cal.Candidate(name="longer", base=BASE, changes={"run.duration": 12.0}),
    )
    first, second = cal.worths(replace(fit, plan=fit.plan.model_copy(update={"candidate": candidates})), draws=8)
    assert (first.name, second.name) == ("longer", "the same")
    assert first.told[first.most] == pytest.approx(0.5 * np.log1p((first.spread[first.most] / SDS[first.most]) ** 2))
    assert cal.NUMBERS[first.most].words in first.text
    assert len(cal.worths(fit, draws=2)) == 7


# predictions -------------------------------------------------------------------------------------------------------


def test_a_prediction_is_the_runs_of_the_samples(fit):
    found = cal.predict(BASE, fit, draws=12, seed=1)
    again = cal.predict(BASE, fit, draws=12, seed=1)
    assert found.numbers == again.numbers
    drawn = fit.draws(12, np.random.default_rng(1))
    for row, values in zip(found.runs.rows, drawn, strict=True):
        assert [row["fluid.viscosity"], row["device.weight.net_weight"]] == values.tolist()
    ends = [hm.simulate(hm.scenario.varied(BASE, dict(zip(TRUTH, v.tolist(), strict=True)))) for v in drawn]
    heights = [run.dataset["position"].values[-1, 2] for run in ends]
    np.testing.assert_allclose(found.heights[:, -1], np.quantile(heights, [0.05, 0.5, 0.95]), atol=1e-9)
    assert sum(each["probability"] for each in found.numbers["outcomes"]) == pytest.approx(1.0)


def test_noise_widens_the_bands(fit):
    still, noisy = (
        cal.predict(BASE, fit, draws=16, noise=noise)
        for noise in (cal.Noise(), cal.Noise({"drive.pitch": math.radians(1.0)}, 2e-4))
    )
    spans = [np.ptp(found.heights[:, 0]) for found in (still, noisy)]
    assert spans[0] == 0.0
    assert 3e-4 < spans[1] < 1e-3  # of 2e-4 in height at the start, 5 to 95 % is 6.6e-4
    pitches = np.array([row["drive.pitch"] for row in noisy.runs.rows])
    assert 0.5 < np.degrees(pitches.std()) < 1.6


def test_what_a_scenario_cannot_have_is_refused(fit):
    free = [FREE[0] | {"input": "device.weight.head_density", "mean": "1 kg/m^3", "sd": "1 kg/m^3", "low": "0 kg/m^3"}]
    with pytest.raises(InputError, match="head_density"):
        prepared(plan_of([{"what": "stays", "source": "seen"}], free=free))
    with pytest.raises(InputError, match="at least one draw"):
        cal.predict(BASE, fit, draws=0)


# plans and commands ------------------------------------------------------------------------------------------------

TEXT = """
particles = 32
[[run]]
name = "row1"
base = "BASE"
[[run.observed]]
what = "rise"
value = "0.2 mm"
sd = "0.05 mm"
source = "camera"
[[run.observed]]
what = "stays"
time = "6 s"
source = "seen"
[[free]]
input = "device.weight.net_weight"
prior = "uniform"
low = "40 uN"
high = "60 uN"
"""


@pytest.fixture
def place(tmp_path):
    (tmp_path / "base.toml").write_text(BASE.to_toml(), encoding="utf-8")
    (tmp_path / "plan.toml").write_text(TEXT.replace("BASE", "base.toml"), encoding="utf-8")
    return tmp_path


def test_a_plan_reads_back_as_written(place):
    plan = cal.load_plan(place / "plan.toml")
    assert cal.parse_plan(plan.to_toml()) == plan
    assert prepared(plan).bases == (parse(BASE.to_toml()),)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"0.2 mm"', "0.2", "text with a unit"),
        ('"0.2 mm"', '"0.2 s"', "not in a unit of length"),
        ('"0.05 mm"', '"0 mm"', "sd must be above zero, by 1e-12 in SI units at least; got '0 mm'\n"),
        ('"0.05 mm"', '"1e-300 mm"', "sd must be above zero"),
        ('"rise"', '"height"', "must be one of output, gain"),
        ('source = "camera"', "", "source is missing"),
        ('source = "camera"', 'source = "camera"\ntime = "1 s"', "time is not a known key"),
        ('"6 s"', '"60 s"', "the run ends at 6 s; raise run.duration"),
        ('"uniform"', '"normal"', "a normal prior needs mean and sd"),
        ('"60 uN"', '"30 uN"', "finite low below its high"),
        ('"60 uN"', '"30 mm"', "not in a unit of force"),
        ('"60 uN"', "60", "must be a force such as"),
        ("net_weight", "weight", "net_weight"),
        ("BASE", "nowhere.toml", "nowhere.toml"),
        ("[[free]]", '[[free]]\nruns = ["row7"]', "names the run 'row7'"),
        ("[[free]]", "[[axis]]", "a sweep's plan"),
    ],
)
def test_a_plan_that_does_not_fit_says_so_in_one_line(place, helimag, old, new, said):
    text = TEXT.replace(old, new, 1).replace("BASE", "base.toml")
    (place / "plan.toml").write_text(text, encoding="utf-8")
    status, out, err = helimag("calibrate", str(place / "plan.toml"), "-o", str(place / "fit.nc"))
    assert (status, out) == (2, "")
    assert said in err
    assert len(err.splitlines()) == 1


def test_the_commands_from_plan_to_prediction(place, helimag):
    target = str(place / "fit.nc")
    status, out, err = helimag("calibrate", str(place / "plan.toml"), "-o", target, "--json")
    assert (status, err) == (0, "")
    report = json.loads(out)
    (found,) = report["inputs"]
    assert 40e-6 < found["p05"] < found["p50"] < found["p95"] < 60e-6
    assert report["findings"]["sentences"]
    assert report["next_runs"][0]["told_nats"]
    common = ("simulate", str(place / "base.toml"), "--ensemble", target, "--draws", "8")
    status, out, err = helimag(*common, "--noise", "drive.pitch=0.2 deg", "--displacement", "50 um", "--json")
    assert (status, err) == (0, "")
    told = json.loads(out)
    assert told["draws"] == 8
    assert len(told["height_m"]["p50"]) == len(told["time_s"]) == 201
    status, out, _ = helimag(*common)
    assert status == 0
    assert "height at the end" in out
    status, out, _ = helimag("plot", target, "-o", str(place / "fit.png"))
    assert status == 0
    assert (place / "fit.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--draws", "8"), "--draws goes with --ensemble only"),
        (("--ensemble", "base.toml"), "cannot be read as netCDF"),
        (("--ensemble", "none.nc"), "there is no file"),
        (("--ensemble", "fit.nc", "--noise", "drive.pitch"), "an input and its standard deviation"),
        (("--ensemble", "fit.nc", "--noise", "drive.pitch=-1 deg"), "above zero"),
        (("--ensemble", "fit.nc", "--displacement", "5 s"), "--displacement"),
        (("--ensemble", "fit.nc", "-o", "run.nc"), "--output writes one run"),
    ],
)
def test_options_of_a_prediction_that_do_not_fit(place, helimag, fit, monkeypatch, options, said):
    monkeypatch.chdir(place)
    fit.save(place / "fit.nc")
    status, out, err = helimag("simulate", "base.toml", *options)
    assert (status, out) == (2, "")
    assert said in err


def test_a_figure_has_a_panel_for_each_pair(fit):
    from helimag import plots

    figure = plots.draw_fit(fit)
    left, right = figure.subfigs
    assert len(left.axes) == 3  # two inputs, one pair
    (bands,) = right.axes
    assert [label.get_text() for label in bands.get_yticklabels()] == [
        "row1: rise",
        "row1: attack angle",
        "row1: speed",
    ]


def test_a_likelihood_takes_about_as_long_as_its_runs(known):
    """A hundred devices a call: no more than a few times what the runs themselves take."""
    problem = prepared(known)
    values = problem.from_unit(np.random.default_rng(0).random((64, 2)))
    batch = [scenario for row in values for scenario in problem.scenarios_at(row)]
    advance(batch[:2])
    begun = time.process_time()
    advance(batch)
    alone = time.process_time() - begun
    begun = time.process_time()
    problem.evaluate(values)
    assert time.process_time() - begun < 5.0 * alone + 0.2
