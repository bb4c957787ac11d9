"""How fast the studio follows the hand: 200 moves of a slider, and whether 1,000 moves leave its memory as it was.

A real Chromium drags the pitch slider step by step; each time is from the slider's event in the page to the verdict and
the picture of that move in the page, the first that a person sees of it and the one of the whole run. Also: how long
the first page takes, and which hosts were asked. Prints a table; run it on a machine that does nothing else.
"""

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import browser

MOVES = 200
LONG = 1000 if len(sys.argv) < 2 else int(sys.argv[1])  # moves over which memory is watched
WARM = 20

# waits for a move's verdict and picture, and notes when the first and the whole came
WATCH = """
() => {
  window.marks = [];
  const verdict = document.querySelector('[data-testid=verdict]');
  const slider = document.querySelector('[data-testid=slider-drive-pitch]');
  window.move = (value) => new Promise((done) => {
    const before = +verdict.dataset.number;
    const begun = performance.now();
    let first = null;
    const look = () => {
      const number = +verdict.dataset.number;
      if (number > before && +document.body.dataset.picture >= number) {
        first = first ?? performance.now() - begun;
        if (verdict.dataset.stage !== 'FIRST') return done([first, performance.now() - begun]);
      }
      if (performance.now() - begun > 20000) return done([NaN, NaN]);
      requestAnimationFrame(look);
    };
    slider.value = value;
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    requestAnimationFrame(look);
  });
}
"""


def memory(process: str) -> float:
    """Resident memory of a process (MB)."""
    text = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    return float(next(line for line in text.splitlines() if line.startswith("VmRSS")).split()[1]) / 1024.0


def server_process(port: str) -> str:
    """The process that serves a port."""
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        words = place.read_bytes().split(b"\0")
        if b"studio" in words and port.encode() in words:
            return place.parent.name
    raise SystemExit("the studio's process was not found")


def value(i: int) -> float:
    """A pitch (deg) that differs from the one before, back and forth as a hand goes."""
    there = i % 120
    return round(10.0 + 0.1 * min(there, 120 - there), 1)


def main() -> None:
    """Measure, and print."""
    lacking = browser.lacking()
    if lacking is not None:
        raise SystemExit(lacking)
    with browser.served() as address, browser.chromium() as chromium:
        port = address.split(":")[2].rstrip("/")
        server = server_process(port)
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        hosts = set()
        page.on("request", lambda request: hosts.add(request.url.split("/")[2]))
        begun = time.perf_counter()
        page.goto(address)
        page.wait_for_selector('[data-testid="verdict"][data-stage="WHOLE"], [data-stage="AFTERWARDS"]')
        opened = time.perf_counter() - begun
        second = chromium.new_page(viewport={"width": 1280, "height": 800})
        begun = time.perf_counter()
        second.goto(address)
        second.wait_for_selector('[data-testid="verdict"][data-stage]')
        again = time.perf_counter() - begun
        second.close()
        page.evaluate(WATCH)
        for i in range(WARM):
            page.evaluate("v => window.move(v)", value(i))
        times = 1e-3 * np.array([page.evaluate("v => window.move(v)", value(i)) for i in range(WARM, WARM + MOVES)])
        print(f"first page, verdict included     {opened:6.2f} s; a second tab {again:.2f} s", flush=True)
        for name, column in (("first verdict and picture", times[:, 0]), ("those of the whole run", times[:, 1])):
            median, p95 = 1e3 * np.percentile(column, [50, 95])
            print(f"{name:32s} {median:6.0f} ms median, {p95:.0f} ms at p95, of {MOVES} moves", flush=True)
        heap = "performance.memory.usedJSHeapSize / 1048576"
        memories, tools = [], page.context.new_cdp_session(page)
        for i in range(LONG):
            page.evaluate("v => window.move(v)", value(i))
            if i % 100 == 99:
                tools.send("HeapProfiler.collectGarbage")  # or the heap is what was not yet looked through
                memories.append((memory(server), page.evaluate(heap)))
    if not memories:
        return
    served, drawn = np.array(memories).T
    growth = served[-1] / served[0] - 1.0
    print(f"server's memory over {LONG} moves   {served[0]:6.0f} MB to {served[-1]:.0f} MB ({growth:+.1%})")
    print(f"page's heap                      {drawn[0]:6.0f} MB to {drawn[-1]:.0f} MB")
    print(f"hosts asked                      {', '.join(sorted(hosts))}")


if __name__ == "__main__":
    main()
