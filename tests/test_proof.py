"""Proofs of orbits, certificates, and their check: what is proved, that nothing else is, and that changes are seen."""

import copy
import json
import math
from dataclasses import replace
from fractions import Fraction
from itertools import combinations_with_replacement

import numpy as np
import pytest

pytest.importorskip("flint")

import command_line
import helimag as hm
import oracles
from helimag.engine import advance
from helimag.errors import FileError, InputError
from helimag.orbits.strobe import chart, to_lab, to_moving
from helimag.proof import (
    Certificate,
    Proof,
    certificate_in,
    certificate_of,
    check,
    check_file,
    check_row,
    growing,
    grown,
    named_inputs,
    prove,
    read_certificate,
    sentence,
    tolerated,
    with_certificate,
)
from helimag.proof import certificate as certificates
from helimag.proof.balls import arithmetic
from helimag.proof.bounds import straights_of
from helimag.proof.exact import parts, written
from helimag.proof.motion import product
from helimag.proof.sealing import digest
from helimag.proof.tolerance import PATHS
from helimag.proof.waves import Waves
from helimag.robot import load_cell, plan
from helimag.robot.programme import programme_texts

# the device of today's Fig. 3(C), nose first; and set D2, tail first
CELL = load_cell().model_copy(update={"obstacle": ()})  # the circle begins outside the tank of the default one
BAR = {"2.5 Hz 12.7": (2.5, 12.7), "2.0 Hz 14": (2.0, 14.0), "2.5 Hz 8": (2.5, 8.0), "3.0 Hz 10": (3.0, 10.0)}


def scenario_at(frequency: float, pitch: float, **changes: object) -> hm.Scenario:
    scenario = oracles.scenario_of(oracles.case(**changes))
    return scenario.replaced({"drive.frequency": f"{frequency} Hz", "drive.pitch": f"{pitch} deg"})


def tail_first() -> hm.Scenario:
    device = {
        "left": False, "yaw": -0.031, "wire": 0.1938e-3, "head": 0.553e-3, "weight": 51.6e-6, "gravity_center": -3.8e-3,
        "viscosity": 1.65,
    }  # fmt: skip
    return scenario_at(3.3, -12.7, **device).replaced({"drive.yaw_rate": "-1.8 deg/s"})


@pytest.fixture(scope="module")
def orbit() -> hm.Orbit:
    scenario = scenario_at(2.5, 12.7).replaced({"drive.yaw_rate": "1.8 deg/s"})
    return hm.find_orbit(scenario, near=np.array([-7.6e-3, -12.8e-3, -11.9e-3, -0.026, -0.2, -0.491, 0.847]))


@pytest.fixture(scope="module")
def proof(orbit: hm.Orbit) -> Proof:
    return prove(orbit)


@pytest.fixture(scope="module")
def certificate(proof: Proof) -> Certificate:
    assert proof.certificate is not None
    return proof.certificate


@pytest.fixture(scope="module")
def light(certificate: Certificate) -> Certificate:
    """A fiftieth of that tube, time cut more coarsely: what a check costs is a third."""
    wide = certificate.tube
    small = {name: tuple(0.02 * radius for radius in getattr(wide, name)) for name in ("radii", "entry")}
    tube = replace(wide, spans=64, order=12, fine=20, coarse=6, rough=1, **small)
    claims = certificates.claims_of(certificate.scenario, {}, tube)
    assert claims is not None
    assert claims.proved
    return replace(certificate, tube=tube, claims=claims)


def lengths_in(certificate: Certificate, state: np.ndarray) -> np.ndarray:
    """Lengths by block, over the entry's radii, of the coordinates of a state as a turn begins."""
    tube = certificate.tube
    curve = tube.waves.values(np.zeros(1))[:7, 0]
    w, *vector = product(curve[3:] * [1, -1, -1, -1] / np.linalg.norm(curve[3:]), state[3:])
    sigma = np.array(vector) / (abs(w) + 1.0) * np.sign(w)
    return lengths_of(certificate, np.concatenate([state[:3] / 0.01 - curve[:3], 4.0 * sigma]), tube.entry)


def lengths_of(certificate: Certificate, z: np.ndarray, radii) -> np.ndarray:
    """The same of deviations (6,), over some radii; the coordinates by repeated substitution."""
    tube = certificate.tube
    frame = tube.waves.values(np.zeros(1))[7:, 0].reshape(6, 6).T
    bent = np.zeros((6, 6, 6))
    values = tube.bent.values(np.zeros(1))[:, 0].reshape(-1, 6)
    for n, (a, b) in enumerate(combinations_with_replacement(range(6), 2)):
        bent[:, a, b] = bent[:, b, a] = values[n]
    y = np.linalg.solve(frame, z)
    for _ in range(20):
        y = np.linalg.solve(frame, z - np.einsum("iab,a,b->i", bent, y, y) / 2.0)
    return np.array([np.linalg.norm(y[list(rows)]) / r for rows, r in zip(tube.columns, radii, strict=True)])


def test_the_orbit_is_proved(proof: Proof) -> None:
    assert proof.proved
    assert proof.existence
    assert proof.stability
    assert proof.bound < 1.0
    assert 0.0 < proof.box < 1e-8
    assert "tends to the orbit for ever" in proof.reason
    assert 1e-4 < proof.certificate.claims.basin < 1e-3
    assert proof.certificate.claims.basin_turned == pytest.approx(math.radians(1e3 * proof.certificate.claims.basin))


def test_multipliers_of_the_box_hold_those_in_floats(proof: Proof, orbit: hm.Orbit) -> None:
    claims = proof.certificate.claims
    for discs in (claims.multipliers, claims.tube_multipliers):
        for multiplier in orbit.multipliers:
            distances = [
                abs(complex(multiplier.real, abs(multiplier.imag)) - complex(d.real, d.imag)) - d.radius for d in discs
            ]
            assert min(distances) <= 0.0
    # and as tightly that the slowest decay is known to four digits
    slowest = claims.multipliers[0]
    assert slowest.radius < 1e-4 * (1.0 - abs(complex(slowest.real, slowest.imag))) * 50.0
    assert proof.bound >= max(abs(orbit.multipliers)) - 1e-9


def test_the_curve_is_the_orbit(certificate: Certificate, orbit: hm.Orbit) -> None:
    """The place claimed holds the orbit that Newton's method found, to the integration's own error."""
    at = certificate.tube.waves.values(np.zeros(1))[:3, 0] * 0.01
    assert np.all(np.abs(at - orbit.position) <= np.array(certificate.claims.box) + 10.0 * orbit.position_error + 1e-10)


def test_starts_on_the_edge_of_the_basin_come_in(certificate: Certificate, orbit: hm.Orbit) -> None:
    """Runs of the engine from random starts of the proved ball, at its edge: nearer after a while, as proved."""
    rng = np.random.default_rng(5)
    claims, scenario = certificate.claims, orbit.scenario
    starts = []
    for _ in range(3):
        away, axis = rng.normal(size=3), rng.normal(size=3)
        by = np.concatenate([away / np.linalg.norm(away) * claims.basin / 0.15, axis / np.linalg.norm(axis)])
        by[3:] *= claims.basin_turned
        starts.append(chart.moved(orbit.state[None], by[None], np.array([0.15]))[0])
    turns = 4000
    period = 1.0 / scenario.drive.frequency
    run = scenario.replaced({"run.duration": turns * period, "run.interval": turns * period})
    lab = to_lab(scenario, np.zeros(3), np.array(starts))
    for start, history in zip(starts, advance([run] * 3, initial_states=lab, tolerance=1e-11), strict=True):
        end = to_moving(scenario, history.time[-1:], history.states[-1:])[0]
        # the slowest swing alone has decayed by exp(-0.86) by then, what is fast has gone
        assert np.all(lengths_in(certificate, end) < 0.7 * lengths_in(certificate, start).max())


def test_the_clearance_is_that_of_the_orbit(certificate: Certificate, orbit: hm.Orbit) -> None:
    """The magnet is what is nearest: the gap between it and the head, a little less what the tube is wide."""
    scenario = orbit.scenario
    states, _ = hm.orbits.strobe.Problem([scenario]).advance(
        np.zeros(40, dtype=np.int64), np.repeat(orbit.state[None], 40, axis=0), np.full(40, 20), np.zeros(40),
        np.linspace(0.0, 1.0, 40),
    )  # fmt: skip
    arm = hm.orbits.strobe.Problem([scenario]).arm[0]
    gap = np.linalg.norm(states[:, :3] - arm, axis=1).min() - scenario.contact_distance
    assert certificate.claims.clearance <= gap
    assert certificate.claims.clearance == pytest.approx(gap, abs=5.0 * max(certificate.claims.tube))


def test_walls_too_near_are_not_cleared(light: Certificate, orbit: hm.Orbit) -> None:
    """A floor that the tube reaches is never passed over: nothing is proved then, and said why."""
    low = orbit.height_range[0]
    floor = orbit.scenario.replaced({"workspace.floor": low})
    claims = certificates.claims_of(floor, {}, light.tube)
    assert claims.stability
    assert claims.clearance < 0.0
    assert not claims.proved


def test_the_ball_of_starts_lies_in_the_region_that_all_comes_in_from(certificate: Certificate) -> None:
    """Coordinates of random starts on its edge, found by Newton's method: within the entry's radii."""
    tube, claims, rng = certificate.tube, certificate.claims, np.random.default_rng(8)
    nearest = 0.0
    for _ in range(200):
        away, axis = rng.normal(size=3), rng.normal(size=3)
        rodrigues = math.tan(claims.basin_turned / 4.0) * axis / np.linalg.norm(axis)
        z = np.concatenate([away / np.linalg.norm(away) * claims.basin / 0.01, 4.0 * rodrigues])
        nearest = max(nearest, *lengths_of(certificate, z, tube.entry))
    assert 0.5 < nearest <= 1.0


# ---------------------------------------------------------------------------------------------------- certificates


def numbers_in(value, path=()):
    """Paths of all numbers, flags and texts of a certificate's content."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield from numbers_in(each, (*path, key))
    elif isinstance(value, list):
        for i, each in enumerate(value):
            yield from numbers_in(each, (*path, i))
    else:
        yield path


def changed(value):
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    if isinstance(value, float):
        return math.nextafter(value, math.inf)
    digit = next((i for i, letter in enumerate(value) if letter.isdigit()), None)
    if digit is None:
        return value + "x"
    return value[:digit] + str((int(value[digit]) + 1) % 10) + value[digit + 1 :]


def put(content, path, by):
    at = content
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = by(at[path[-1]])


def test_a_certificate_comes_back_and_holds(certificate: Certificate, tmp_path) -> None:
    path = tmp_path / "orbit.json"
    certificate.save(path)
    again = certificate_in(path)
    assert again.text() == certificate.text()
    assert again.claims == certificate.claims
    assert again.hash == certificate.hash


def test_a_certificate_with_any_one_number_changed_is_refused(light: Certificate) -> None:
    """Every number, by one bit, flag and text; of the thousands that functions are made of some of each."""
    content = json.loads(light.text())
    paths = [path for n, path in enumerate(numbers_in(content)) if len(path) < 4 or path[0] != "tube" or n % 61 == 0]
    assert {path[:2] for path in paths} == {path[:2] for path in numbers_in(content)}
    assert len(paths) > 150
    sealed = content.pop("sha256")
    for i, path in enumerate(paths):
        if path == ("sha256",):
            continue
        original = _at(content, path)
        put(content, path, changed)
        assert digest(content) != sealed, path
        if i % 7 == 0 or path[0] != "tube":
            with pytest.raises(InputError):
                read_certificate(json.dumps(content | {"sha256": sealed}))
        put(content, path, lambda _, value=original: value)
    assert read_certificate(json.dumps(content | {"sha256": sealed})).text() == light.text()
    with pytest.raises(InputError):
        read_certificate(json.dumps(content | {"sha256": changed(sealed)}))


def test_every_digit_of_the_scenario_counts(light: Certificate) -> None:
    content = json.loads(light.text())
    text = content["scenario"]
    for i, letter in enumerate(text):
        if letter.isdigit():
            content["scenario"] = text[:i] + str((int(letter) + 1) % 10) + text[i + 1 :]
            with pytest.raises(InputError):
                read_certificate(json.dumps(content))


def _at(content, path):
    for key in path:
        content = content[key]
    return content


def resealed(content) -> str:
    """The text of a content that somebody changed who also knows how its hash is made."""
    rest = {key: value for key, value in content.items() if key != "sha256"}
    return json.dumps(rest | {"sha256": digest(rest)})


def test_no_claim_is_believed(light: Certificate, monkeypatch) -> None:
    """With the hash made anew: any other claim is refused, as the claims are drawn again from the tube.

    The enclosures do not depend on the claims, so they are made once here.
    """
    made = certificates.claims_of(light.scenario, {}, light.tube)
    assert made == light.claims
    monkeypatch.setattr(certificates, "claims_of", lambda *_, **__: made)
    content = json.loads(light.text())
    for path in list(numbers_in(content["claims"])):
        forged = copy.deepcopy(content)
        put(forged, ("claims", *path), changed)
        with pytest.raises(InputError, match="does not prove"):
            check(read_certificate(resealed(forged)))


@pytest.mark.parametrize(
    "change",
    [
        lambda c: c.update(scenario=c["scenario"].replace('net_weight = "28.28 uN"', 'net_weight = "28.29 uN"')),
    ],
    ids=["weight"],
)
def test_what_is_not_so_is_not_proved_with_the_hash_made_anew(light: Certificate, change) -> None:
    content = json.loads(light.text())
    before = copy.deepcopy(content)
    change(content)
    assert content != before
    with pytest.raises(InputError, match="prove"):
        check(read_certificate(resealed(content)))


BROKEN = {
    "not closed": {"odd": (True, False, False, False)},
    "no radius": {"radii": (0.0, 1e-5, 1e-5, 1e-5)},
    "not a number": {"radii": (math.nan, 1e-5, 1e-5, 1e-5)},
    "columns left out": {"blocks": (1, 2, 3, 4)},
    "a block of three": {"blocks": (0, 3), "radii": (1e-5,) * 2, "entry": (1e-5,) * 2, "odd": (False,) * 2,
                         "decay": (-1.0,) * 2, "swing": (0.0,) * 2},
    "no time": {"spans": 0},
    "no third derivatives": {"rough": 0},
    "second-order terms left out": {"bent": Waves(np.zeros((6 * 20, 1)), np.zeros((6 * 20, 1)))},
    "second-order terms of half a wave": {"bent": Waves(np.full((6 * 21, 2), 1e-9), np.zeros((6 * 21, 2)))},
    "second-order terms that are no numbers": {"bent": Waves(np.full((6 * 21, 1), np.nan), np.zeros((6 * 21, 1)))},
    "a block without radius": {"radii": (1e-5,) * 3},
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_a_tube_that_is_none_is_refused(certificate: Certificate, name) -> None:
    with pytest.raises(InputError, match="not one"):
        check(replace(certificate, tube=replace(certificate.tube, **BROKEN[name])))


def test_a_curve_that_does_not_come_back_is_refused(certificate: Certificate) -> None:
    waves = certificate.tube.waves
    cos = waves.cos.copy()
    cos[0, 1] = 1e-12  # half a wave in a turn
    with pytest.raises(InputError, match="not one"):
        check(replace(certificate, tube=replace(certificate.tube, waves=Waves(cos, waves.sin))))


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", "null", '{"sha256": "0"}', '{"format": "helimag proof 5", "sha256": 1}']
)
def test_what_is_no_certificate_is_refused(text: str, tmp_path) -> None:
    with pytest.raises(InputError):
        read_certificate(text)
    with pytest.raises(FileError):
        check_file(tmp_path / "nothing.json")


def with_tolerance(certificate: Certificate, path: str, width: object) -> Certificate:
    """A certificate whose maker says that an input may be off, the curve not leaning with it."""
    still = Waves(np.zeros((7, 1)), np.zeros((7, 1)))
    return replace(certificate, within={path: width}, tube=replace(certificate.tube, lean=still))


@pytest.mark.parametrize(
    ("path", "width"),
    [
        ("magnet.radius", "5"),  # acts by floats only: the enclosures would not see it
        ("workspace.floor", "100"),
        ("device.weight.helix_density", "1"),  # not given here
        ("drive.frequency", "-0.1"),
        ("drive.frequency", "0"),
        ("drive.frequency", "nan"),
        ("drive.frequency", 1e-5),
    ],
)
def test_a_tolerance_that_no_enclosure_sees_is_refused(certificate: Certificate, path, width) -> None:
    with pytest.raises(InputError, match="tolerance"):
        check(with_tolerance(certificate, path, width))


def test_a_tolerance_of_a_weight_that_is_not_given_is_refused(certificate: Certificate) -> None:
    densities = {"device.weight": {"helix_density": "1100 kg/m^3", "head_density": "7500 kg/m^3"}}
    other = replace(certificate, scenario=certificate.scenario.replaced(densities))
    with pytest.raises(InputError, match="not given"):
        check(with_tolerance(other, "device.weight.net_weight", "0.1"))


def test_no_starts_beyond_the_tube_where_inputs_may_be_off(certificate: Certificate) -> None:
    """What leads into the tube is enclosed of the inputs' middle values alone: such a tube must not reach out."""
    off = with_tolerance(certificate, "drive.frequency", "1e-05")
    narrow = replace(off.tube, bent=Waves(np.zeros((0, 1)), np.zeros((0, 1))), entry=off.tube.radii)
    assert certificates._fits(narrow, 1)
    assert not certificates._fits(replace(narrow, entry=off.tube.entry), 1)
    assert not certificates._fits(replace(narrow, entry=tuple(r / 2.0 for r in narrow.radii)), 1)


@pytest.mark.parametrize(
    "change",
    [
        lambda c: c["tube"].update(spans=float(c["tube"]["spans"])),
        lambda c: c["tube"]["radii"].__setitem__(0, "1e-5"),
        lambda c: c["tube"]["blocks"].__setitem__(0, False),
        lambda c: c["tube"].update(odd=3),
        lambda c: c["tube"].update(cos=c["tube"]["cos"][0], sin=c["tube"]["sin"][0]),
        lambda c: c["tube"]["cos"][0].__setitem__(0, 10**400),
        lambda c: c.update(within=["drive.pitch"]),
    ],
    ids=["spans", "radius", "block", "odd", "one function", "too large", "within"],
)
def test_what_is_of_another_type_is_refused(certificate: Certificate, change) -> None:
    """With the hash made anew; in one clear line, and before anything is enclosed."""
    content = json.loads(certificate.text())
    change(content)
    with pytest.raises(InputError, match="certificate"):
        check(read_certificate(resealed(content)))


def test_a_key_that_stands_twice_is_refused(certificate: Certificate) -> None:
    """Readers differ in which of two they take: what a person reads first must be what was checked."""
    text = certificate.text()
    assert '"claims": {' in text
    twice = text.replace(
        '"claims": {', '"claims": {"existence": true, "stability": true, "basin": 1.0},\n"claims": {', 1
    )
    with pytest.raises(InputError, match="twice"):
        read_certificate(twice)


def test_a_tube_too_wide_for_series_is_refused_in_a_line(certificate: Certificate) -> None:
    """The region holds the magnet's own place, and attitudes all round: enclosures know nothing there."""
    wide = replace(certificate.tube, radii=(1e3,) * 4, entry=(1e3,) * 4, spans=2)
    with pytest.raises(InputError, match="proves nothing"):
        check(replace(certificate, tube=wide))


def test_no_certificate_is_about_drag_near_walls(certificate: Certificate, monkeypatch) -> None:
    """The same device in open water has a certificate; that says nothing of one whose drag depends on the place."""
    drag = oracles.resistance(oracles.case())
    monkeypatch.setattr(certificates, "resistance", lambda *_: drag)
    floor = certificate.scenario.replaced({"workspace.floor": -0.2})
    open_water = floor.replaced({"device.hydrodynamics": {"model": "boundary"}})
    about = replace(certificate, scenario=certificates.settled(open_water))
    assert about.covers(open_water)
    near = floor.replaced({"device.hydrodynamics": {"model": "boundary", "near_walls": True}})
    assert not about.covers(near)


def test_sentences_are_rounded_outward(certificate: Certificate) -> None:
    """What is said in words is no more than what is proved."""
    claims = replace(
        certificate.claims, box=(3e-10, 4.0e-10, 1e-14), basin=3.6789e-6, basin_turned=math.radians(0.00369),
        clearance=0.142999, bound=0.9999610000000001,
    )  # fmt: skip
    words = sentence(claims)
    assert "within 0.501 nm of the curve given as a turn begins" in words  # the box is of then only
    assert "within 3.67 um and 0.0036 deg of that curve" in words
    assert "at least 142 mm" in words
    assert "in its own norm, by at most 0.999962" in words


def test_another_orbit_than_the_one_given_is_not_proved(orbit: hm.Orbit) -> None:
    """Newton's method leads from beside an orbit to it; of what was given nothing is proved."""
    result = prove(replace(orbit, state=orbit.state + np.array([2e-4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])))
    assert not result.existence
    assert result.certificate is None
    assert "another" in result.reason


# --------------------------------------------------------------------------------------------- runs, programmes, CLI


def test_a_run_carries_the_certificate(light: Certificate, orbit: hm.Orbit, tmp_path) -> None:
    run = hm.simulate(orbit.scenario.replaced({"run.duration": "5 s"}))
    assert certificate_of(run) is None
    with_certificate(run, light).save(tmp_path / "run.nc")
    again = hm.Trajectory.load(tmp_path / "run.nc")
    assert certificate_of(again).text() == light.text()
    other = hm.simulate(orbit.scenario.replaced({"run.duration": "5 s", "drive.pitch": "12.8 deg"}))
    with pytest.raises(InputError, match="other inputs"):
        with_certificate(other, light)


def test_a_programme_names_the_certificate(light: Certificate, orbit: hm.Orbit) -> None:
    short = plan(orbit.scenario.replaced({"run.duration": "20 s"}), CELL)
    texts = programme_texts(short, certificate=light, accept_unbounded=True, name="proved")
    assert f"certificate sha256 {light.hash}" in texts["proved.src"]
    other = plan(orbit.scenario.replaced({"run.duration": "20 s", "drive.pitch": "12.8 deg"}), CELL)
    with pytest.raises(InputError, match="other inputs"):
        programme_texts(other, certificate=light, accept_unbounded=True)


def test_nothing_forged_travels(light: Certificate, orbit: hm.Orbit, monkeypatch) -> None:
    """A claim changed by somebody who makes the hash anew gets into no run's file and no programme's header.

    What the enclosures prove of the tube does not depend on the claims, and is known from above.
    """
    monkeypatch.setattr(certificates, "claims_of", lambda *_, **__: light.claims)
    content = json.loads(light.text())
    put(content, ("claims", *next(iter(numbers_in(content["claims"])))), changed)
    forged = read_certificate(resealed(content))
    run = hm.simulate(orbit.scenario.replaced({"run.duration": "5 s"}))
    with pytest.raises(InputError, match="does not prove"):
        with_certificate(run, forged)
    short = plan(orbit.scenario.replaced({"run.duration": "20 s"}), CELL)
    with pytest.raises(InputError, match="does not prove"):
        programme_texts(short, certificate=forged, accept_unbounded=True, name="forged")


def test_command_proves_and_checks(proof: Proof, tmp_path, monkeypatch) -> None:
    """From a scenario's file to a certificate that is read back; the proof itself is the one above."""
    monkeypatch.setattr("helimag.proof.prove", lambda _, *, progress: progress(1.0) or proof)
    (tmp_path / "s.toml").write_text(scenario_at(2.5, 12.7).replaced({"drive.yaw_rate": "1.8 deg/s"}).to_toml())
    path = tmp_path / "c.json"
    said = command_line.run("orbit", tmp_path / "s.toml", "--prove", "--certificate", path, "--json")
    assert said.status == 0, said.err
    report = json.loads(said.out)["proof"]
    assert report["proved"] is report["existence"] is report["stability"] is True
    assert report["bound"] < 1.0
    assert 0.0 < report["box_m"] < 1e-8
    assert report["seconds"] > 0.0
    assert "an orbit exists" in report["reason"]
    assert report["certificate_sha256"] == read_certificate(path.read_text()).hash


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--prove", "--all"), "leave out --all"),
        (("--certificate", "c.json"), "add --prove"),
        (("--tolerance",), "add --prove"),
        (("--prove", "--certificate", "c.txt"), ".json"),
        (("--prove", "--certificate", "nowhere/c.json"), "no folder"),
        (("--prove", "--set", "magnet.field=cylinder"), "magnet.field"),
    ],
)
def test_command_refuses_at_once(words, told) -> None:
    said = command_line.run("orbit", "paper/fig3c", *words)
    assert said.status == 2
    assert told in said.err


def test_no_orbit_is_no_proof() -> None:
    found = hm.Orbit(scenario=scenario_at(2.5, 12.7), status=hm.orbits.OrbitStatus.NO_ORBIT)
    result = prove(found)
    assert not result.proved
    assert not result.existence
    assert result.certificate is None
    assert "no orbit was found" in result.reason


# ----------------------------------------------------------------------------------------------------------- nightly


@pytest.mark.nightly
@pytest.mark.parametrize("name", BAR)
def test_the_four_orbits(name: str) -> None:
    scenario = scenario_at(*BAR[name]).replaced({"drive.yaw_rate": "1.8 deg/s"})
    result = prove(hm.find_orbit(scenario))
    assert result.proved, result.reason
    assert result.seconds < 60.0
    assert result.certificate.claims.basin >= 1e-4
    assert result.certificate.claims.basin_turned >= math.radians(0.1)
    assert check(result.certificate) == result.certificate.claims


def test_a_box_of_inputs_is_said_in_words(certificate: Certificate) -> None:
    """No ball of starts is claimed of it: each value of the inputs has a tube of its own."""
    box = replace(certificate, within={"drive.frequency": "5.3e-04", "device.weight.net_weight": "9.0e-03"})
    named = named_inputs(box)
    assert named == "drive.frequency off by up to 5.3e-04 Hz, device.weight.net_weight off by up to 9.0e-03 uN"
    words = sentence(replace(box.claims, basin=0.0, basin_turned=0.0), named)
    assert words.startswith(f"with {named}, all at once and whatever their values, an orbit exists within")
    assert "every start in that tube tends to the orbit for ever" in words
    assert " 0 " not in words


@pytest.mark.nightly
def test_inputs_may_be_off(certificate: Certificate) -> None:
    """A box of four inputs, none of no width; and at its corners the orbit is where the certificate says."""
    wide = tolerated(certificate)
    assert wide is not None
    assert set(wide.within) == set(PATHS)
    assert all(float(width) > 0.0 for width in wide.within.values())
    assert check(wide) == wide.claims
    assert max(wide.claims.box) > 10.0 * max(certificate.claims.box)
    for path, least in zip(PATHS, (5e-4, 4e-3, 3e-2, 9e-3), strict=True):  # as the theory page says, with room
        assert float(wide.within[path]) > least
    middle = certificate.tube.waves.values(np.zeros(1))[:3, 0] * 0.01
    for signs in ((1, 1, 1, 1), (1, -1, 1, -1), (-1, -1, 1, 1)):
        changes = {}
        for path, sign in zip(wide.within, signs, strict=True):
            number, unit = parts(written(certificate.scenario, path))
            changes[path] = f"{float(number) + sign * float(wide.within[path])!r} {unit}"
        found = hm.find_orbit(certificate.scenario.replaced(changes), near=_state_near(certificate))
        assert found.stable
        assert np.all(np.abs(found.position - middle) <= np.array(wide.claims.box) + 1e-10)

    row = grown(wide, "drive.pitch", seconds=1.0)
    assert len(row.cells) == 2
    assert check_row(row) is row
    low, high = row.box["drive.pitch"]
    # a cell is two widths long; its neighbour is tried as long, and then four fifths of that
    assert float(high - low) > 3.5 * float(wide.within["drive.pitch"])


def test_a_neighbours_tube_is_around_the_orbit_there(light: Certificate) -> None:
    """At another pitch nothing moves on the curve, and to first order nothing where it leans: at one time of a turn."""
    within = {"drive.pitch": "1e-03"}
    scenario = growing._moved(replace(light, within=within), "drive.pitch", 1, Fraction("1e-03"))
    assert 12.7019 < math.degrees(scenario.drive.pitch) < 12.702
    tube = growing._tube_around(scenario, light.tube, within)
    assert tube.radii == light.tube.radii
    with arithmetic():
        there = straights_of(certificates.dynamics_of(scenario, within), tube, [5])[5]
        before = straights_of(certificates.dynamics_of(scenario, within), replace(tube, waves=light.tube.waves), [5])[5]
    still, leaning = (max(float(row[n].abs_upper()) for row in there.push) for n in (0, 1))
    assert still < 1e-9
    assert leaning < 1e-6
    assert max(float(row[0].abs_upper()) for row in before.push) > 1e-6


def _state_near(certificate: Certificate) -> np.ndarray:
    at = certificate.tube.waves.values(np.zeros(1))[:7, 0]
    return np.concatenate([0.01 * at[:3], at[3:]])


@pytest.mark.nightly
def test_tail_first_is_proved_too() -> None:
    result = prove(hm.find_orbit(tail_first()))
    assert result.proved, result.reason


@pytest.mark.nightly
def test_an_unstable_orbit_exists_and_is_not_proved_stable() -> None:
    found = [each for each in hm.orbits.list_orbits(scenario_at(3.3, 12.0)) if not each.stable]
    assert found
    result = prove(found[0])
    assert result.existence
    assert not result.stability
    assert not result.proved
    assert result.bound > 1.0
    assert result.certificate.claims.instability
    # the outermost disc lies outside the unit circle as a whole
    assert max(abs(complex(d.real, d.imag)) - d.radius for d in result.certificate.claims.multipliers) > 1.0


@pytest.mark.nightly
def test_near_a_fold_it_says_no() -> None:
    """The stable stretch in pitch ends in a fold at 15.41904 deg."""
    scenario = scenario_at(2.5, 12.7).replaced({"drive.yaw_rate": "1.8 deg/s"})
    start = hm.find_orbit(scenario)
    interval = hm.orbits.stable_interval(start, "drive.pitch", math.radians(10.0), math.radians(18.0))
    assert interval.why_high == "fold"
    near = hm.find_orbit(scenario.replaced({"drive.pitch": interval.high - math.radians(1e-7)}), near=start)
    result = prove(near)
    assert not result.proved
    assert "not proved" in result.reason
