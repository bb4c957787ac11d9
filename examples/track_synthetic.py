"""Film a staged run through plexiglass and oil, calibrate from a board, track, and check against the truth."""

import tempfile
from pathlib import Path

import numpy as np

from helimag.runs.measurement import output
from helimag.runs.trajectory import Trajectory
from helimag.vision import Effects, Session, calibrate, paper_rig, render_run, render_session, score, staged, track

GAP = 0.102  # height of the magnet above the device at the start (m)


def main() -> None:
    rig = paper_rig(seed=0)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        calibration = calibrate(Session.load(render_session(rig, folder, own=7, shared=3, oil=8)))
        effects = Effects(dropped=0.05, clock_offset=0.1)
        films = render_run(staged("wobbling", duration=6.0), rig, folder, effects=effects, start=2.0, duration=1.5)
        run = track(films["front"], films["below"], calibration.rig, initial_gap=GAP)
        truth = Trajectory.load(films["truth"])
    result, size = score(run, truth), output(run)
    print(f"held-out boards   {1e3 * calibration.report['held_out_rms_mm']:.0f} um rms")
    print(f"head              {1e6 * result.position_rms:.0f} um rms, {1e6 * result.position_worst:.0f} um at worst")
    print(f"attack angle      {np.degrees(result.attack_rms):.2f} deg rms")
    print(f"|y|               {1e3 * size.value:.3f} mm, 95 % {1e3 * size.low:.3f} to {1e3 * size.high:.3f} mm")
    print(f"truth             {1e3 * truth.judgement.output:.3f} mm")
    assert result.position_rms < 0.15e-3
    assert result.position_worst < 0.4e-3
    assert np.degrees(result.attack_rms) < 1.0
    assert size.low <= truth.judgement.output <= size.high


if __name__ == "__main__":
    main()
