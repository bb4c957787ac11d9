"""Ensembles: copies drawn as stated, the same with the same seed, run as by hand, counted with Wilson's interval."""

import numpy as np
import pytest

from helimag import InputError, Perturbation, RunError, ensemble, load, simulate
from helimag.ensembles import ensembles
from helimag.runs.shares import in_percent, wilson
from helimag.scenario import Normal, Uniform

SHORT = load("nose-first/fig3c").replaced({"run.duration": "20 s"})
BOTH = Perturbation({"drive.pitch": Uniform(0.1, 0.3), "fluid.viscosity": Normal(1.0, 0.1)}, displacement=1e-5)


@pytest.fixture(scope="module")
def found():
    return ensemble(SHORT, BOTH, runs=6, seed=1, threads=1)


def test_seeds_repeat(found):
    again, other = (ensemble(SHORT, BOTH, runs=6, seed=seed, threads=1) for seed in (1, 2))
    assert again.rows == found.rows
    assert again.judgement == found.judgement
    assert not np.any(other.gains == found.gains)


def test_copies_are_drawn_as_stated(found):
    random = np.random.default_rng(1)
    shares, moved = random.random((6, 2)), random.standard_normal((6, 3))
    pitches = [row["drive.pitch"] for row in found.rows]
    np.testing.assert_allclose(pitches, 0.1 + 0.2 * shares[:, 0], rtol=1e-15)
    starts = np.array([[row[f"start_{axis}"] for axis in "xyz"] for row in found.rows])
    np.testing.assert_allclose(starts - SHORT.drive.start, 1e-5 * moved, atol=1e-16)


def test_a_row_is_the_run_that_it_names(found):
    row = found.rows[2]
    scenario = SHORT.replaced({path: row[path] for path in ("drive.pitch", "fluid.viscosity")})
    start = np.array([row["start_x"], row["start_y"], row["start_z"], 1.0, 0.0, 0.0, 0.0])
    alone = simulate(scenario, initial_state=start)
    assert row["gain"] == pytest.approx(alone.gain, rel=1e-12)
    assert row["verdict"] == alone.verdict
    assert found.judgement.gain == pytest.approx(simulate(SHORT).gain, rel=1e-12)
    assert found.gains[2] == row["gain"]


def test_shares_and_their_intervals(found):
    assert sum(found.verdicts.values()) == 6
    assert sum(share for share, _, _ in found.shares.values()) == pytest.approx(1.0)
    assert all(low <= share <= high for share, low, high in found.shares.values())
    assert found.text.startswith("of 6 copies ")


def test_wilsons_interval():
    """Solves its definition: the ends are the shares that lie 1.96 standard deviations from what was seen."""
    for share, total in ((0.9, 60), (0.5, 10), (0.125, 32)):
        for end in wilson(share, total):
            assert abs(share - end) == pytest.approx(1.96 * np.sqrt(end * (1.0 - end) / total), rel=1e-9)
    assert wilson(0.0, 10)[0] == 0.0
    assert wilson(1.0, 10)[1] == 1.0


@pytest.mark.parametrize(
    ("share", "shown"),
    [(0.0, "0"), (1.0, "100"), (0.5, "50"), (0.974, "97"), (0.996, "99.6"), (1999 / 2000, "99.95"), (1 / 4000, "0.03")],
)
def test_a_share_is_all_or_none_only_where_it_is(share, shown):
    assert in_percent(share) == shown


def test_several_scenarios_draw_one_after_the_other():
    """The perturbed runs of Fig. 3: one stream of normal displacements through all scenarios."""
    other = SHORT.replaced({"drive.start": (0.0, -0.04, 0.0)})
    pair = ensembles([SHORT, other], Perturbation(displacement=1e-5), runs=3, seed=3, threads=1)
    random = np.random.default_rng(3)
    for each, scenario in zip(pair, (SHORT, other), strict=True):
        starts = np.array([copy.states[0, :3] for copy in each.copies])
        np.testing.assert_array_equal(starts, scenario.drive.start + 1e-5 * random.standard_normal((3, 3)))
        np.testing.assert_array_equal(each.nominal.states[0, :3], scenario.drive.start)


def test_what_does_not_fit_is_named():
    for wrong, words in (
        (Perturbation, "priors of inputs, a displacement, or both"),
        (lambda: Perturbation(displacement=-1.0), "zero or more"),
        (lambda: ensemble(SHORT, BOTH, runs=0), "at least one copy"),
        (lambda: ensemble(SHORT, Perturbation({"drive.start": Uniform(0.0, 1.0)})), "single number"),
        (lambda: ensemble(SHORT, Perturbation({"drive.distance": Normal(0.0, 1.0)})), "drive.distance must"),
    ):
        with pytest.raises(InputError, match=words):
            wrong()


def test_a_run_that_breaks_down_is_no_verdict():
    broken = SHORT.replaced({"device.weight.net_weight": 1e300})
    with pytest.raises(RunError, match="broke down"):
        ensemble(broken, Perturbation(displacement=1e-6), runs=1)
