"""How many frame pairs a second are tracked, decoding included: two 1280 x 1024 H.264 views.

Run: python benchmarks/track_rate.py [SECONDS]. Real time is 30 pairs a second. Processor time is shown too, since a
busy
machine says more about itself than about the tracker; two cores give at most twice the pairs a processor second.
"""

import resource
import sys
import tempfile
import time

from helimag.vision import Camera, Effects, paper_rig, render_run, staged, track

REAL_TIME = 30.0


def main() -> None:
    duration = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    rig = paper_rig(seed=0)
    camera: Camera = rig.cameras[0]
    with tempfile.TemporaryDirectory() as folder:
        films = render_run(staged("wobbling", duration=duration), rig, folder, effects=Effects(clock_offset=0.1))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        wall, processor = time.perf_counter(), time.process_time()
        run = track(films["front"], films["below"], rig, initial_gap=0.102)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    pairs = int(run.dataset.attrs["frames_first"])
    print(f"{pairs} pairs of {camera.size[0]} x {camera.size[1]}, {run.dataset.sizes['time']} samples")
    print(f"{pairs / wall:.1f} pairs a second of wall time, {pairs / processor:.1f} a second of processor time")
    print(f"peak memory {before / 1024:.0f} MB before tracking, {after / 1024:.0f} MB after")
    sys.exit(int(2.0 * pairs / processor < REAL_TIME))


if __name__ == "__main__":
    main()
