"""The second camera's clock: told by lines of sight that meet and by the roll, and what it is off by.

Views are made by projecting a device's ends, without pictures; errors put into them are the oracle of what is claimed.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from helimag.vision import Camera, Rig, Shape, paper_rig, staged
from helimag.vision.synthetic.rendering import FilmedMotion
from helimag.vision.tracking.alignment import Offset, at
from helimag.vision.tracking.clock import Clock, Views, by_meeting, by_rolls, clock_rates, combined, told
from helimag.vision.tracking.detection import HALF, along_and_across
from helimag.vision.tracking.drawings import from_nose, phases
from helimag.vision.tracking.pose import DevicePoses, oriented, solve
from helimag.vision.tracking.search import Sighting
from helimag.vision.tracking.uncertainty import Deviations, covariances
from helimag.vision.tracking.views import PreparedView, Roll

Floats = NDArray[np.float64]

AHEAD = 0.1234  # s
SHAPE = Shape()
FRESH = np.array([0.03, 0.01, 0.05, 0.02])  # px
LASTING = np.array([0.02, 0.012, 0.05, 0.01])
FRAMES = np.arange(5, 55)
RATE = 2.0 * np.pi * 3.5


@pytest.fixture(scope="module")
def rig() -> Rig:
    """Aslant by 25 deg, with two variants: one camera shifted along the tank, the other's focal length off."""
    exact = paper_rig(seed=2, angle=np.radians(25.0))
    one, two = exact.cameras
    aside = replace(one, translation=one.translation + np.array([5e-6, 0.0, 0.0]))
    longer = replace(two, matrix=two.matrix * np.array([[1.0002], [1.0002], [1.0]]))
    return replace(exact, variants=((aside, two), (one, longer)))


def seen(camera: Camera, time: Floats, ahead: float, off: Floats) -> Sighting:
    """Rows of a view whose clock is ahead, with its four numbers off all along (px)."""
    head, turn = FilmedMotion(staged("falling", duration=10.0, seed=3)).pose(time - ahead + 4.0)
    nose, tail = (camera.project(head + reach * turn[:, :, 0]) for reach in (SHAPE.nose, SHAPE.tail))
    along = (nose - tail) / np.linalg.norm(nose - tail, axis=1, keepdims=True)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    nose, tail = nose + off[0] * along, tail + off[2] * along
    rows = np.zeros((time.size, 13))
    rows[:, :2] = (nose + tail) / 2.0 + off[1] * across
    rows[:, 2:4] = (nose - tail) / 2.0 + off[3] * across
    rows[:, 4:8] = np.hypot(FRESH, LASTING)
    return Sighting(time, rows)


def views(rig: Rig, off: Floats | None = None) -> Views:
    """Both views, the second not triggered with the first, with all eight numbers off all along (px)."""
    time = np.arange(60) / 30.0
    off = np.zeros(8) if off is None else off
    first = seen(rig.cameras[0], time, 0.0, off[:4])
    second = seen(rig.cameras[1], time + AHEAD + 0.011, AHEAD, off[4:])
    return PreparedView(first, FRESH, LASTING, None), PreparedView(second, FRESH, LASTING, None)


def meeting(rig: Rig, off: Floats | None = None, length: float = SHAPE.length) -> Clock:
    clock = by_meeting(views(rig, off), FRAMES, length, rig, AHEAD - 3e-3)
    assert clock is not None
    return clock


def test_lines_of_sight_that_meet_tell_the_clock_whatever_the_device_s_length_looks_like(rig: Rig) -> None:
    for length in (SHAPE.length, SHAPE.length + 0.1e-3):
        assert meeting(rig, length=length).value == pytest.approx(AHEAD, abs=3e-6)


def test_what_a_number_is_off_by_all_along_goes_through_to_the_clock(rig: Rig) -> None:
    base = meeting(rig)
    for number in range(8):
        found = meeting(rig, 0.05 * np.eye(8)[number]).value - base.value
        assert found == pytest.approx(0.05 * base.numbers[number], rel=0.03, abs=3e-6)
    assert base.numbers[0] > 4e-3  # s/px: the device moves by some 100 px/s
    assert base.sd**2 == pytest.approx(
        base.own**2 + np.sum((base.numbers * np.tile(LASTING, 2)) ** 2) + np.sum(base.variants**2)
    )


def test_a_rig_that_is_off_is_off_in_the_clock_as_claimed(rig: Rig) -> None:
    base = meeting(rig)
    for pair, claimed in zip(rig.variants, base.variants, strict=True):
        truly = views(replace(rig, cameras=pair))  # filmed by the variant, told with the rig
        clock = by_meeting(truly, FRAMES, SHAPE.length, rig, AHEAD)
        assert clock is not None
        assert clock.value - base.value == pytest.approx(claimed, rel=0.03)
        assert abs(claimed) > 2e-5


def test_a_rig_without_variants_is_trusted_to_its_accuracy_only(rig: Rig) -> None:
    """Off by the accuracy in either view along the way: two of sqrt(2) um, at 16 mm/s."""
    plain = replace(rig, variants=())
    exact, rough = meeting(plain), meeting(replace(plain, accuracy=1e-4))
    assert rough.sd > exact.sd
    assert np.sqrt(rough.sd**2 - exact.sd**2) == pytest.approx(np.sqrt(2.0) * 1e-4 / 16e-3, rel=0.15)


def test_noise_of_the_clock_is_as_claimed(rig: Rig) -> None:
    random = np.random.default_rng(1)
    found, claimed = [], 0.0
    for _ in range(24):
        one, two = views(rig)
        noisy = []
        for view in (one, two):
            rows, noise = view.sighting.rows.copy(), FRESH * random.standard_normal((60, 4))
            along = rows[:, HALF] / np.linalg.norm(rows[:, HALF], axis=1, keepdims=True)
            across = np.stack([-along[:, 1], along[:, 0]], axis=1)
            middle, half = (noise[:, [0]] + noise[:, [2]]) / 2.0, (noise[:, [0]] - noise[:, [2]]) / 2.0
            rows[:, :2] += middle * along + noise[:, [1]] * across
            rows[:, HALF] += half * along + noise[:, [3]] * across
            noisy.append(view._replace(sighting=Sighting(view.sighting.time, rows)))
        clock = by_meeting((noisy[0], noisy[1]), FRAMES, SHAPE.length, rig, AHEAD)
        assert clock is not None
        found.append(clock.value - AHEAD)
        claimed = clock.own
    assert np.std(found) == pytest.approx(claimed, rel=0.4)
    assert abs(np.mean(found)) < 4.0 * claimed / np.sqrt(24)


def test_a_device_at_rest_tells_no_clock(rig: Rig) -> None:
    one, two = views(rig)
    still = [
        view._replace(sighting=Sighting(view.sighting.time, np.repeat(view.sighting.rows[:1], 60, axis=0)))
        for view in (one, two)
    ]
    clock = by_meeting((still[0], still[1]), FRAMES, SHAPE.length, rig, AHEAD)
    assert clock is None or clock.sd > 1.0
    assert by_meeting((one, two), FRAMES[:6], SHAPE.length, rig, AHEAD) is None


def fitted(rig: Rig, both: Views, ahead: float) -> tuple[DevicePoses, Floats]:
    """Poses at an offset, and by how much the numbers change with it (px/s)."""
    first, second = (view.sighting for view in both)
    rows = (first.rows[FRAMES], at(second, first.time[FRAMES] + ahead))
    poses = oriented(solve(rig, *rows, SHAPE.length), np.ones(FRAMES.size), SHAPE.length / 2.0 - SHAPE.nose)
    moved = along_and_across(clock_rates(second, first.time[FRAMES], ahead), rows[1][:, HALF])
    return poses, np.concatenate([np.zeros_like(moved), moved], axis=1)


@pytest.mark.parametrize("number", range(8))
def test_a_number_s_error_moves_the_head_itself_and_by_way_of_the_clock_as_claimed(rig: Rig, number: int) -> None:
    """Along the way the two cancel in part: where the clock makes the views meet, the other view's number counts."""
    plain, size = replace(rig, variants=()), 0.05 * np.eye(8)[number]
    clock = meeting(plain)
    poses, rates = fitted(plain, views(plain), clock.value)
    moved, _ = fitted(plain, views(plain, size), meeting(plain, size).value)
    shift = moved.head - poses.head
    none, lasting = np.zeros((FRAMES.size, 8)), np.tile(size, (FRAMES.size, 1))
    claimed = covariances(
        plain, SHAPE, poses, Deviations(none, lasting, rates), clock._replace(own=0.0), np.ones(FRAMES.size)
    ).head
    expected = np.einsum("ni,nj->nij", shift, shift)
    assert np.abs(claimed - expected).max() < 0.08 * np.abs(expected).max() + 1e-14


def test_a_rig_s_error_moves_the_head_itself_and_by_way_of_the_clock_as_claimed(rig: Rig) -> None:
    clock = meeting(rig)
    poses, rates = fitted(rig, views(rig), clock.value)
    expected = np.zeros((FRAMES.size, 3, 3))
    for pair in rig.variants:
        truly = views(replace(rig, cameras=pair))
        found = by_meeting(truly, FRAMES, SHAPE.length, rig, AHEAD)
        assert found is not None
        shift = fitted(rig, truly, found.value)[0].head - poses.head
        expected += np.einsum("ni,nj->nij", shift, shift)
    none = np.zeros((FRAMES.size, 8))
    claimed = covariances(
        rig, SHAPE, poses, Deviations(none, none, rates), clock._replace(own=0.0), np.ones(FRAMES.size)
    ).head
    # a shift of the head is that of a point seen, not of a device of known length
    assert np.abs(claimed - expected).max() < 0.2 * np.abs(expected).max()
    assert claimed[:, 0, 0] == pytest.approx(expected[:, 0, 0], rel=0.1)


def rolling_views(rig: Rig, off: tuple[float, float] = (0.0, 0.0)) -> Views:
    """Views that show a roll, which counts from an end that may be off (px); the second turns the other way round."""
    made = []
    for view, ahead, by_end, wrong in zip(views(rig), (0.0, AHEAD), (0.38, -0.36), off, strict=True):
        time = view.sighting.time
        angle = (RATE * (time - ahead) + by_end * wrong + np.pi) % (2.0 * np.pi) - np.pi
        made.append(view._replace(roll=Roll(time, angle, 0.005, by_end)))
    return made[0], made[1]


def test_an_end_that_is_off_turns_the_roll_and_shifts_its_clock_as_claimed(rig: Rig) -> None:
    met = Offset(AHEAD + 2e-3, 1e-3, True)
    base = by_rolls(rolling_views(rig), rig, met)
    assert base is not None
    assert base.value == pytest.approx(AHEAD, abs=1e-9)
    assert base.own == pytest.approx(np.sqrt(2.0) * 0.005 / RATE, rel=1e-3)
    for number, off in ((0, (0.02, 0.0)), (4, (0.0, 0.02))):
        moved = by_rolls(rolling_views(rig, off), rig, met)
        assert moved is not None
        assert moved.value - AHEAD == pytest.approx(0.02 * base.numbers[number], rel=1e-6)
    assert base.sd == pytest.approx(np.hypot(base.own, 0.02 * np.hypot(0.38, 0.36) / RATE), rel=1e-3)
    assert by_rolls(views(rig), rig, met) is None


def test_a_coil_counted_from_an_end_turns_with_it() -> None:
    """A coil cos(k s + 0.3) seen between ends at 0 and 80 px, and with the head's end 0.5 px further on."""
    pitch, forward = 16.0, np.array([[80.0, 0.0]])
    rows = np.zeros((2, 13))
    for row, end in zip(rows, (80.0, 80.5), strict=True):
        middle = end / 2.0
        row[2] = end / 2.0
        coil = np.exp(1j * (2.0 * np.pi / pitch * middle + 0.3))
        row[10], row[11] = coil.real, coil.imag
    turned = phases(from_nose(rows, np.repeat(forward, 2, axis=0), 80.0 / pitch))
    assert np.angle(np.exp(1j * (turned[1] - turned[0]))) == pytest.approx(2.0 * np.pi / pitch * 0.5, abs=1e-9)


def test_two_tellings_are_weighed_by_what_they_do_not_share() -> None:
    """Against the generalised least squares of the two values; with one that knows nothing new, the other stays."""
    lasting = np.tile(LASTING, 2)
    random = np.random.default_rng(4)
    one = Clock(0.1, True, 1e-4, 5e-3 * random.standard_normal(8), np.array([1e-4, 0.0]), lasting)
    two = Clock(0.101, True, 4e-4, 5e-3 * random.standard_normal(8), np.array([0.0, 2e-4]), lasting)
    parts = np.array([[*(c.numbers * lasting), *c.variants] for c in (one, two)])
    covariance = parts @ parts.T + np.diag([one.own**2, two.own**2])
    weights = np.linalg.solve(covariance, np.ones(2))
    weights /= weights.sum()
    both = combined(one, two)
    assert np.all(weights > 0.0)
    assert both.value == pytest.approx(weights @ [0.1, 0.101], rel=1e-12)
    assert both.sd**2 == pytest.approx(weights @ covariance @ weights)
    assert both.sd < min(one.sd, two.sd)
    worse = one._replace(numbers=2.0 * one.numbers, own=1e-3)  # a negative weight would be least
    assert combined(one, worse).value == one.value
    assert combined(worse, one).sd == pytest.approx(one.sd)


def test_an_offset_that_is_given_hangs_on_nothing(rig: Rig) -> None:
    clock = told(0.25, 1e-3, rig)
    assert (clock.value, clock.sd, clock.found) == (0.25, 1e-3, True)
    assert clock.variants.shape == (2,)
