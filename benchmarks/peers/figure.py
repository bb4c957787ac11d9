"""Draw what `python benchmarks/peers` measured: work against precision, a line a code.

python benchmarks/peers/figure.py FILE.png
"""

import json
import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("agg")

import matplotlib.pyplot as plt

RESULTS = Path(__file__).parent.parent / "results" / "peers.json"
OURS, OTHERS = (
    ("#b2182b", "#f4a582"),
    ("#053061", "#4393c3", "#92c5de", "#1b7837", "#a6dba0", "#762a83", "#c2a5cf", "#777777"),
)


def best(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Points that no other one beats in error and in time, by error."""
    return sorted(p for p in points if not any(q != p and q[0] <= p[0] and q[1] <= p[1] for q in points))


def main() -> None:
    found = json.loads(RESULTS.read_text(encoding="utf-8"))
    figure, axes = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
    colors = {True: iter(OURS), False: iter(OTHERS)}
    for name in dict.fromkeys(point["code"] for point in found["curves"]):
        points = best([(p["error"], p["seconds"]) for p in found["curves"] if p["code"] == name])
        ours = name.startswith("helimag")
        axes.loglog(*zip(*points, strict=True), "o-" if ours else ".-", lw=2.2 if ours else 1.2, label=name,
                    color=next(colors[ours]))  # fmt: skip
    axes.set_xlabel("error of the head's place after 100 s (m)")
    axes.set_ylabel("CPU time a run (s)")
    axes.set_title(f"{found['preset']}, 1800 s, one core", fontsize=10)
    axes.grid(which="major", alpha=0.3)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    figure.savefig(sys.argv[1], dpi=160)
    print(sys.argv[1])


if __name__ == "__main__":
    main()
