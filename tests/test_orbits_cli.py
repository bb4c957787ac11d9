"""The orbit commands: what they print, and one clear line with status 2 for bad input."""

import json

import pytest

import command_line
from helimag.design import candidates, full_runs, robust_inputs

pytestmark = pytest.mark.filterwarnings("ignore:Cyclopts application invoked without tokens")  # as from a shell
SCENARIO = ["nose-first/fig3c", "--set", "drive.frequency=2.5 Hz"]


def run(_monkeypatch, _capsys, *words):
    return command_line.run(*words)


def test_orbit_as_json(monkeypatch, capsys):
    status, out, _ = run(monkeypatch, capsys, "orbit", *SCENARIO, "--json")
    report = json.loads(out)
    assert status == 0
    assert report["found"]
    assert report["stable"]
    assert report["status"] == "found"
    assert report["position_m"] == pytest.approx([-7.58e-3, -12.77e-3, -11.92e-3], abs=1e-5)
    assert report["rates_per_s"][0] == pytest.approx([-0.00053, 0.0310], rel=0.03)
    assert len(report["rates_per_s"]) == 6
    assert report["attack_angle_deg"] == pytest.approx(-21.5, abs=0.1)


def test_branch_is_printed_and_drawn(monkeypatch, capsys, tmp_path):
    figure = tmp_path / "pitch.png"
    limits = ["--vary", "drive.pitch", "--from", "12 deg", "--to", "18 deg"]
    status, out, _ = run(monkeypatch, capsys, "orbit", *SCENARIO, *limits, "-o", str(figure))
    assert status == 0
    assert "stable for pitch between 12 deg (end of the range) and 15.419 deg (fold)" in out
    assert figure.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["orbit", "nose-first/fig3c", "--vary", "drive.pitch"], "--from and --to"),
        (["orbit", "nose-first/fig3c", "--from", "8 deg"], "--vary"),
        (
            ["orbit", "nose-first/fig3c", "--all", "--vary", "drive.pitch", "--from", "8 deg", "--to", "9 deg"],
            "--all lists",
        ),
        (["orbit", *SCENARIO, "--vary", "drive.pitch", "--from", "-1 mm", "--to", "9 deg"], "must be an angle"),
        (["orbit", *SCENARIO, "--vary", "drive.pith", "--from", "8 deg", "--to", "9 deg"], "not a field"),
        (["orbit", "nose-first/fig3c", "--set", 'drive.velocity=["1 mm/s","0 m/s","0 m/s"]'], "drive.yaw_rate"),
        (["design", "nose-first/fig3c", "--limit", "drive.pitch"], "--limit must be"),
        (["design", "nose-first/fig3c", "--speed", "3 mm"], "velocity"),
    ],
)
def test_bad_input_is_one_line(monkeypatch, capsys, words, said):
    status, out, err = run(monkeypatch, capsys, *words)
    assert status == 2
    assert out == ""
    assert said in err
    assert err.count("\n") == 1


def test_the_outlook_can_be_left_out(monkeypatch, capsys):
    words = ["simulate", *SCENARIO, "--duration", "60 s"]
    status, out, _ = run(monkeypatch, capsys, *words)
    assert status == 0
    assert "for all time  inside for 60 s, coming to the stable orbit" in out
    _, out, _ = run(monkeypatch, capsys, *words, "--json")
    report = json.loads(out)
    assert report["outlook"] == "coming to a stable orbit"
    assert report["orbit_stable"] is True
    assert report["orbit_position_m"] == pytest.approx([-7.58e-3, -12.77e-3, -11.92e-3], abs=1e-5)
    _, out, _ = run(monkeypatch, capsys, *words, "--json", "--no-orbit")
    assert not {"outlook", "orbit_stable"} & json.loads(out).keys()


def test_all_orbits_are_listed(monkeypatch, capsys):
    """The stable one first, and the unstable ones around it."""
    status, out, _ = run(monkeypatch, capsys, "orbit", *SCENARIO, "--all")
    assert status == 0
    first, *lines = out.splitlines()
    assert first == f"nose-first/fig3c, drive.frequency 2.5 Hz: {len(lines)} orbits found"
    assert len(lines) > 1
    assert "(-7.58, -12.77, -11.92) mm" in lines[0]
    assert ["unstable" in line for line in lines] == [False] + [True] * (len(lines) - 1)


def test_a_straight_run_has_no_circle(monkeypatch, capsys):
    straight = ["--set", "drive.yaw_rate=0 deg/s", "--set", 'drive.velocity=["0.5 mm/s", "0 mm/s", "0 mm/s"]']
    status, out, _ = run(monkeypatch, capsys, "orbit", *SCENARIO, *straight, "--json")
    report = json.loads(out)
    assert status == 0
    assert report["found"]
    assert report["radius_m"] is None
    assert report["speed_m_per_s"] == 5e-4
    status, _, err = run(monkeypatch, capsys, "design", *SCENARIO, *straight, "--radius", "10 mm")
    assert (status, err.count("\n")) == (2, 1)
    assert "circular" in err


def test_no_orbit_has_a_reason_in_the_list_too(monkeypatch, capsys):
    status, out, _ = run(monkeypatch, capsys, "orbit", "nose-first/table1-row1", "--all")
    assert status == 0
    assert "0 orbits" in out
    assert "wall-limited" in out


def test_options_are_named_where_their_quantity_is_wrong(monkeypatch, capsys):
    for words, option in ((["design", "--speed", "1 mm"], "--speed"), (["orbit", "flow", "--box", "abc"], "--box")):
        status, _, err = run(monkeypatch, capsys, *words[:-2], "nose-first/fig3c", *words[-2:])
        assert (status, err.count("\n")) == (2, 1)
        assert f"{option} must be" in err


def test_design_as_json(monkeypatch, capsys):
    for module, name, value in (
        (candidates, "SAMPLES", 16),
        (candidates, "SOLVED", 6),
        (robust_inputs, "CANDIDATES", 1),
        (robust_inputs, "POLISHES", 1),
        (full_runs, "LONGEST_RUN", 3000.0),
    ):
        monkeypatch.setattr(module, name, value)
    limits = ["--limit", "drive.frequency=2 Hz..3.2 Hz", "--limit", "drive.pitch=6 deg..16 deg"]
    status, out, err = run(
        monkeypatch, capsys, "design", *SCENARIO, "--speed", "0.45 mm/s", *limits, "--runs", "4", "--json"
    )
    assert (status, err) == (0, "")
    report = json.loads(out)
    assert report["runs"] == {"bounded": 4}
    assert report["orbit"]["position_error_m"] < 1e-6
