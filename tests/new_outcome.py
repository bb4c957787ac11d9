"""A trial, run on its own by test_outcomes.py: new outcomes are added to the vocabulary alone, and used everywhere.

The vocabulary's text gets one more line for each; then runs are judged so, stored, exported, drawn and reported.
"""

import json
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np

import helimag
from helimag import outcomes

LINES = {
    "Reason": 'LIES_STILL = ({flag}, "lies-still", Verdict.STRANDED, "lies still after {{time:.0f}} s")',
    "Verdict": 'STRANDED = ({flag}, "stranded", True, True, "the device lies still")',
    "BasinEnd": 'STRANDED = ({flag}, "stranded", "lies still")',
}


def add_outcomes() -> None:
    """Put the longer vocabulary in the place of helimag's, before anything else imports it."""
    file = Path(outcomes.__file__)
    source = file.read_text(encoding="utf-8")
    for family, line in LINES.items():
        head, begin, rest = source.partition(f"class {family}(Term):")
        body, end, tail = rest.partition("\n\n\n")
        source = f"{head}{begin}{body}\n    {line.format(flag=len(getattr(outcomes, family)))}{end}{tail}"
    longer = types.ModuleType("helimag.outcomes")
    exec(compile(source, str(file), "exec"), longer.__dict__)
    sys.modules["helimag.outcomes"] = helimag.outcomes = longer


def hover_of(figure: Any) -> str:
    """The last line of what a page says of the first of its runs."""
    runs = next(trace for trace in figure.data if trace.text is not None)
    return str(np.ravel(runs.text)[0]).rpartition("<br>")[2]


def main(folder: Path) -> dict[str, object]:
    add_outcomes()
    from helimag.cli.runs import _report
    from helimag.orbits import Basin, Orbit, OrbitComparison, basin_dataset, comparison_dataset
    from helimag.orbits.datasets import Along
    from helimag.outcomes import BasinEnd, OrbitStatus, Reason
    from helimag.plots import draw_basin, draw_sweep, interactive_sweep
    from helimag.runs import gain
    from helimag.sweeps import boundary_line, counts, export, nodes_of, parse_plan

    gain._cause = lambda run: (Reason.LIES_STILL, {"time": run.time[-1]}, None)
    plan = parse_plan((folder / "plan.toml").read_text(encoding="utf-8"))
    data = helimag.sweep(plan, out=folder / "s.zarr").load()
    export(data, folder / "s.csv")
    nodes = nodes_of(data)
    blank, false = np.full(nodes.verdicts.shape, np.nan), np.zeros(nodes.verdicts.shape, bool)
    compared = OrbitComparison(nodes.verdicts, blank, blank, np.full((*blank.shape, 7), np.nan), false, false)
    inputs = {axis.field: Along(axis.dimension, "1", axis.values) for axis in nodes.axes}
    beside = comparison_dataset(compared, nodes.base, inputs, nodes.dimensions)["verdict"]
    scenario = helimag.load("nose-first/fig3c")
    run = helimag.simulate(scenario, duration="1 s")
    state = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    known = {"state": state, "multipliers": np.full(6, 0.5 + 0.0j), "rates": np.full(6, -0.1 + 0.0j)}
    orbit = Orbit(scenario=scenario, status=OrbitStatus.FOUND, **known)
    places = np.stack(np.meshgrid(*[[-0.01, 0.01]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    basin = Basin(orbit, (2, 2, 2), places, np.zeros(8, bool), np.array([BasinEnd.STRANDED] * 8), 0.0, 1.0, "full")
    ends = basin_dataset(basin)["end"]
    return {
        "store": {name: list(data[name].attrs["flag_values"])[-1] for name in ("verdict", "reason")},
        "words": {name: data[name].attrs["flag_meanings"].split()[-1] for name in ("verdict", "reason")},
        "stored": sorted(set(data["verdict"].values.ravel().tolist())),
        "counts": counts(data),
        "csv": (folder / "s.csv").read_text(encoding="utf-8").splitlines()[1].split(",")[-3:-1],
        "boundary": len(boundary_line(data, "stranded").points),
        "plan": parse_plan(plan.to_toml() + '[boundary]\nbudget = 16\nverdict = "stranded"\n').boundary.verdict,
        "nodes": sorted(set(nodes.verdicts.ravel().tolist())),
        "beside": [
            beside.attrs["flag_meanings"].split()[-1],
            int(beside.attrs["flag_values"][-1]),
            int(beside.values.max()),
        ],
        "report": [_report(run)["verdict"], _report(run)["reason"]],
        "repr": repr(run),
        "legend": [text.get_text() for legend in draw_sweep(data).legends for text in legend.get_texts()],
        "hover": hover_of(interactive_sweep(data)),
        "basin": [ends.attrs["flag_meanings"].split()[-1], int(ends.attrs["flag_values"][-1]), int(ends.values.max())],
        "basin_legend": draw_basin(basin).legends[0].get_texts()[0].get_text(),
    }


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(Path(sys.argv[1]))))
