"""The vocabulary of outcomes: its numbers and words, what follows from a member, and that a new one is one line."""

import json
import string
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray

from helimag import InputError, outcomes
from helimag.engine import attempts, events, recording
from helimag.outcomes import BasinEnd, End, Future, OrbitStatus, Reason, Verdict, Why
from helimag.plots import _portraits, sweeps
from helimag.runs import Heights, SlowTimes, judge
from helimag.sweeps import Boundary

FAMILIES = [Verdict, Reason, End, OrbitStatus, BasinEnd, Future, Why]
# what files of 0.1.0 hold, by number from zero; new members come after these
STORED = {
    Verdict: "not-computed bounded drifting attracted fell wall-limited failed",
    Reason: "not-computed settled still-rises still-sinks swings-ever-more pulled-into-magnet fell-behind "
    "reached-floor reached-surface reached-wall numbers-broke-down scenario-refused",
    BasinEnd: "captured stayed attracted fell wall-limited out_of_step left broke_down not_run",
    End: "running horizon contact fall floor surface wall not-finite",
}


@pytest.mark.parametrize("family", STORED)
def test_numbers_in_files_keep_their_meaning(family):
    words = STORED[family].split()
    assert [str(family(flag)).replace(" ", "_") for flag in range(len(words))] == words


def test_reasons_for_a_difference_are_numbered_from_one():
    words = ["starts outside the basin", "slow drift", "horizon too short", "judged too soon", "other attractor"]
    assert [str(Why(flag)) for flag in range(1, 6)] == words


@pytest.mark.parametrize("family", FAMILIES)
def test_members_are_numbered_without_gaps_and_say_something(family):
    flags = [member.flag for member in family]
    assert flags == list(range(flags[0], flags[0] + len(family)))
    assert len(set(outcomes.cf_flags(family)["flag_meanings"].split())) == len(family)
    for member in family:
        fields = [name for text in (member.sentence, member.remedy) for _, name, _, _ in string.Formatter().parse(text)]
        numbers = {name: 1.0 for name in fields if name}
        assert member.text(**numbers).strip()
        assert "{" not in member.text(**numbers)


def test_a_member_is_its_word_and_its_number():
    flags = np.array([4, 1, 0], np.int8)
    words = np.array(["fell", "bounded", ""])
    for equal in (flags == Verdict.FELL, flags == Verdict.FELL, words == Verdict.FELL):
        assert equal.tolist() == [True, False, False]
    assert (flags != Verdict.FELL).tolist() == (words != Verdict.FELL).tolist() == [False, True, True]
    assert (xarray.DataArray(flags) == Verdict.FELL).values.tolist() == [True, False, False]
    assert Verdict.FELL == "fell" == f"{Verdict.FELL}"
    assert Verdict.FELL == 4
    assert Verdict.FELL != 3
    assert Verdict.FELL != "fall"
    assert Verdict.FELL != End.FALL
    assert {Verdict.FELL: 1}["fell"] == 1
    assert json.dumps({"verdict": Verdict.FELL}) == '{"verdict": "fell"}'
    for value in ("fell", 4, np.int8(4), np.str_("fell"), Verdict.FELL):
        assert Verdict.of(value) is Verdict.FELL
    with pytest.raises(InputError, match=r"verdict must be one of not-computed, bounded, .*; got 'stuck'"):
        Verdict.of("stuck")


@pytest.mark.parametrize("end", End)
def test_what_an_end_implies(end):
    """The verdict on a run that swings on evenly, ended so: by the physics of each end, not by the table."""
    time = np.arange(101.0) * 10.0
    flat = np.full(101, 0.05)
    run = Heights(
        time=time,
        low=flat,
        high=flat,
        mean=flat,
        attack=flat,
        attack_square=flat**2,
        slips=0,
        initial_gap=0.1,
        end=end,
        slow=SlowTimes(lap=200.0, fold=150.0),
    )
    judgement = judge(run)
    expected = {
        "contact": ("attracted", "pulled-into-magnet", "attracted", "attracted"),
        "fall": ("fell", "fell-behind", "left the box", "fell"),
        "floor": ("wall-limited", "reached-floor", "wall-limited", "wall-limited"),
        "surface": ("wall-limited", "reached-surface", "wall-limited", "wall-limited"),
        "wall": ("wall-limited", "reached-wall", "wall-limited", "wall-limited"),
        "not-finite": ("failed", "numbers-broke-down", "broke down", "broke down"),
    }.get(str(end), ("bounded", "settled", None, None))
    assert (judgement.verdict, judgement.cause, end.search, end.basin) == expected
    assert (judgement.escape_time is None) == (end.cause is None)


@pytest.mark.parametrize("end", End)
def test_kernels_compare_with_the_same_numbers(end):
    constants = {getattr(module, end.name) for module in (attempts, events, recording) if hasattr(module, end.name)}
    assert constants == {end.flag}, "made where such an end is found"


def test_tables_of_those_who_show_outcomes_are_complete():
    for table, family in ((sweeps.COLOURS, Verdict), (_portraits.ENDS, BasinEnd)):
        assert list(table) == list(family)
        assert len(set(table.values())) == len(family), "two look the same"


@pytest.mark.parametrize("verdict", Verdict)
def test_a_plan_may_ask_for_the_boundary_of_what_is_judged(verdict):
    if verdict.judged:
        assert Boundary(budget=16, verdict=verdict).verdict == str(verdict)
        return
    with pytest.raises(ValueError, match=f"must be one of bounded, .*; got '{verdict}'"):
        Boundary(budget=16, verdict=str(verdict))


def test_a_new_outcome_is_one_line(tmp_path):
    """A verdict, its reason and an end in a basin, added to the vocabulary alone: all who use it know them."""
    axes = (("drive.pitch", "4 deg", "16 deg", 9), ("drive.frequency", "2 Hz", "3 Hz", 3))
    (tmp_path / "plan.toml").write_text(
        'base = "nose-first/fig3c"\nduration = "1 s"\nsamples = 20\n'
        + "".join(f'[[axis]]\nfield = "{f}"\nstart = "{a}"\nstop = "{b}"\ncount = {n}\n' for f, a, b, n in axes)
    )
    script = Path(__file__).with_name("new_outcome.py")
    done = subprocess.run(
        [sys.executable, "-W", "error", script, tmp_path], capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    verdict, reason, end = len(Verdict), len(Reason), len(BasinEnd)
    assert told == {
        "store": {"verdict": verdict, "reason": reason},
        "words": {"verdict": "stranded", "reason": "lies-still"},
        "stored": [verdict],
        "counts": {"stranded": 27},
        "csv": ["stranded", "lies-still"],
        "boundary": 0,
        "plan": "stranded",
        "nodes": ["stranded"],
        "beside": ["stranded", verdict, verdict],
        "report": ["stranded", "lies still after 1 s"],
        "repr": told["repr"],
        "legend": ["stranded"],
        "hover": "stranded, lies-still",
        "basin": ["stranded", end, end],
        "basin_legend": "stranded (8)",
    }
    assert "lies still after 1 s" in told["repr"]
