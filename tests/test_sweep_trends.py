"""The four trends that the paper reads from its Fig. 4 (section II-C), computed on the preset at 2, 2.5 and 3 Hz.

Pitch and distance are swept about the preset's own inputs (150 mm, 12.7 deg, 1.8 deg/s); yaw rate at the pitch of least
gain of its frequency, as in the paper's procedure. "Bounded" is the verdict, not a gain below one.
"""

import math

import numpy as np
import pytest

import helimag
from helimag import Plan
from helimag.outcomes import Verdict
from helimag.sweeps import Axis

HERTZ = ("2 Hz", "2.5 Hz", "3 Hz")
FREQUENCIES = Axis(field="drive.frequency", values=HERTZ)


def swept(folder, *axes, duration="1800 s"):
    return helimag.sweep(Plan(base="nose-first/fig3c", duration=duration, axis=axes), out=folder / "s.zarr").load()


@pytest.fixture(scope="module")
def pitches(tmp_path_factory):
    axis = Axis(field="drive.pitch", start="0 deg", stop="18 deg", step="0.5 deg")
    return swept(tmp_path_factory.mktemp("pitch"), FREQUENCIES, axis)


@pytest.fixture(scope="module")
def distances(tmp_path_factory):
    axis = Axis(field="drive.distance", start="130 mm", stop="170 mm", step="2 mm")
    return swept(tmp_path_factory.mktemp("distance"), FREQUENCIES, axis)


@pytest.fixture(scope="module")
def yaw_rates(tmp_path_factory, pitches):
    best = tuple(f"{math.degrees(value):.6g} deg" for value in least_gain(pitches, "pitch")[1])
    return swept(
        tmp_path_factory.mktemp("yaw"),
        Axis(field="drive.frequency", values=HERTZ, zip="case"),
        Axis(field="drive.pitch", values=best, zip="case"),
        Axis(field="drive.yaw_rate", start="0.8 deg/s", stop="2.2 deg/s", step="0.1 deg/s"),
        duration="3600 s",  # at 1800 s, runs at low rates are still rising to their level
    )


def bounded(data):
    return data["verdict"].values == Verdict.BOUNDED


def least_gain(data, name):
    """Least gain among bounded runs at each frequency, and where it is."""
    gain = np.where(bounded(data), data["gain"].values, np.inf)
    return gain.min(axis=1), data[name].values[gain.argmin(axis=1)]


def falls(values):
    return bool(np.all(np.diff(values) < 0.0))


def test_the_bounded_pitch_falls_as_frequency_rises(pitches):
    highest = [pitches["pitch"].values[row].max() for row in bounded(pitches)]
    assert falls(highest), np.degrees(highest)
    assert falls(least_gain(pitches, "pitch")[1]), np.degrees(least_gain(pitches, "pitch")[1])


def test_the_bounded_range_of_pitch_narrows(pitches):
    assert falls(bounded(pitches).sum(axis=1)), bounded(pitches).sum(axis=1)


def test_the_bounded_range_of_distance_narrows(distances):
    assert falls(bounded(distances).sum(axis=1)), bounded(distances).sum(axis=1)


def test_the_least_gain_is_smaller_at_low_frequency(pitches, distances):
    assert falls(-least_gain(pitches, "pitch")[0])
    assert falls(-least_gain(distances, "distance")[0])


def test_the_least_yaw_rate_that_stays_bounded_rises_with_frequency(yaw_rates):
    least = [yaw_rates["yaw_rate"].values[row].min() for row in bounded(yaw_rates)]
    assert falls(-np.array(least)), np.degrees(least)
    assert min(least) > yaw_rates["yaw_rate"].values[0]  # below each lies a rate that is not bounded
