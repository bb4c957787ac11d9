"""Published beside computed: the rows of a table, as text, CSV and JSON."""

import json
import textwrap
import tomllib
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from helimag.engine import History
from helimag.ensembles import Ensemble
from helimag.files import csv_text, replacing
from helimag.orbits import Outlook
from helimag.runs.gain import gain_until

Row = dict[str, Any]

DISPLACEMENT = 50e-6  # m, of the perturbed runs: standard deviation along each axis

COLUMNS = ("run", "quantity", "published", "computed", "difference", "5 %", "50 %", "95 %", "")
WIDTHS = (12, 14, 10, 10, 10, 8, 8, 8, 5)
FITTED = (
    "Wire radius, head radius, net weight and centre of gravity are not in the paper, nor which end leads: the presets "
    "start with the helix first, and their values were fitted to the outcomes of Fig. 3. So was a viscosity of 1.65 "
    "Pa s where the paper has 1 Pa s: with the published one C's gain stayed at or below 0.18 in that search."
)


def published(figure: str) -> list[Row]:
    """What the paper states, with where it does."""
    text = (resources.files("helimag.reproduce") / f"{figure}.toml").read_text(encoding="utf-8")
    entries: list[Row] = tomllib.loads(text)["published"]
    return entries


def fig3_rows(ensembles: Sequence[Ensemble]) -> list[Row]:
    """One row for each published value of Fig. 3."""
    by_name = {ensemble.scenario.name: ensemble for ensemble in ensembles}
    return [_row(entry, by_name[entry["run"]]) for entry in published("fig3")]


def _row(entry: Row, ensemble: Ensemble) -> Row:
    if entry["quantity"] == "verdict":
        values: Row = _verdict(ensemble)
    else:
        values = _numbers(entry, ensemble)
    computed, expected = values["computed"], entry["value"]
    if isinstance(expected, str):
        difference: Any = "none" if computed == expected else "differs"
    else:
        difference = None if computed is None else computed - expected
    name = entry["quantity"] + (f" at {entry['at']:g} s" if "at" in entry else "")
    return {
        "run": entry["run"],
        "quantity": name,
        "unit": entry.get("unit", ""),
        "published": expected,
        "computed": computed,
        "difference": difference,
        "perturbed": values.get("perturbed"),
        "perturbed_q05": values.get("q05"),
        "perturbed_q50": values.get("q50"),
        "perturbed_q95": values.get("q95"),
        "remark": _remark(entry, ensemble),
        "source": entry["source"],
    }


def _verdict(ensemble: Ensemble) -> Row:
    counts = ensemble.verdicts.most_common()
    return {
        "computed": str(ensemble.judgement.verdict),
        "perturbed": ", ".join(f"{count} of {len(ensemble.copies)} {name}" for name, count in counts),
    }


def _numbers(entry: Row, ensemble: Ensemble) -> Row:
    """Value of the run, and quantiles over those perturbed runs that have one."""

    def value(history: History) -> float | None:
        if entry["quantity"] == "gain":
            return gain_until(history.heights, entry["at"])
        return history.judge().escape_time

    found = [number for number in map(value, ensemble.copies) if number is not None]
    low, middle, high = np.quantile(found, (0.05, 0.5, 0.95)).tolist() if found else (None, None, None)
    count = f"{len(found)} of {len(ensemble.copies)}"
    return {"computed": value(ensemble.nominal), "perturbed": count, "q05": low, "q50": middle, "q95": high}


def _remark(entry: Row, ensemble: Ensemble) -> str:
    """What a reader must know to weigh a difference."""
    judgement = ensemble.judgement
    match entry["run"], entry["quantity"]:
        case "paper/fig3a", "gain" if judgement.end_time < entry["at"]:
            return (
                f"The computed run, and its gain with it, ends where the device touches the magnet, at "
                f"{judgement.end_time:.1f} s. Followed up to the magnet's centre it would be "
                f"{_gain_to_magnet(ensemble):.3f}."
            )
        case "paper/fig3b", "escape time":
            return (
                "Not the same event: the paper names the time from which the gap is too large, without a criterion; "
                "computed is when the head passes half the initial gap below its start for good, which it does before "
                "it has fallen as far as the published gain says."
            )
    return ""


def _gain_to_magnet(ensemble: Ensemble) -> float:
    """Gain of a run that is followed from its lowest point up to the magnet's centre: the start, u above it, and u."""
    heights = ensemble.nominal.heights
    return 1.0 + (ensemble.scenario.drive.start[2] - float(heights.low.min())) / heights.initial_gap


def as_text(rows: Sequence[Row]) -> str:
    """A table for the terminal, remarks below it."""
    notes: list[str] = []
    lines = [" " * sum(WIDTHS[:5]) + "  perturbed runs", _line(COLUMNS)]
    lines.append("-" * len(lines[-1]))
    for row in rows:
        mark = ""
        if row["remark"]:
            notes.append(row["remark"])
            mark = f"({len(notes)})"
        numbers = [_shown(row[name], row["unit"]) for name in ("published", "computed", "difference")]
        if row["quantity"] == "verdict":
            counted = _line([row["run"], row["quantity"], *numbers, row["perturbed"]])
            lines.append(counted + (f"  {mark}" if mark else ""))
        else:
            spread = [_shown(row[f"perturbed_q{level}"], row["unit"]) for level in ("05", "50", "95")]
            lines.append(_line([row["run"], row["quantity"], *numbers, *spread, mark]))
    paragraphs = [f"({i}) {note}" for i, note in enumerate(notes, 1)] + [
        FITTED,
        f"Perturbed runs start {1e6 * DISPLACEMENT:g} um (standard deviation along each axis) beside the preset's "
        "start, under the same magnet path. Quantiles are over those that have the value.",
    ]
    wrapped = [textwrap.fill(text, 100, subsequent_indent="    " if text[0] == "(" else "") for text in paragraphs]
    return "\n".join([*(line.rstrip() for line in lines), "", *wrapped])


def _line(cells: Sequence[str]) -> str:
    return " ".join(f"{cell:<{width}}" for cell, width in zip(cells, WIDTHS, strict=False))


def _shown(value: Any, unit: str) -> str:
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return f"{value:.1f} {unit}" if unit else f"{value:.3f}"


def case_rows(ensembles: Sequence[Ensemble], outlooks: Sequence[Outlook], leads: Sequence[str]) -> list[Row]:
    """One row for each case of Fig. 3: what its run does, what follows, and whether the perturbed runs do the same."""
    rows = []
    for case, ensemble, outlook, end in zip("ABC", ensembles, outlooks, leads, strict=True):
        judgement, heights = ensemble.judgement, ensemble.nominal.heights
        orbit = outlook.orbit
        rows.append(
            {
                "case": case,
                "scenario": ensemble.scenario.name,
                "verdict": str(judgement.verdict),
                "escape_time_s": judgement.escape_time,
                "gain_700_s": gain_until(heights, 700.0),
                "gain": judgement.gain,
                "orbit_stable": orbit.stable if orbit is not None and orbit.found else None,
                "outlook": str(outlook.future),
                "leads": end,
                "perturbed": len(ensemble.copies),
                "perturbed_with_the_same_verdict": ensemble.verdicts[judgement.verdict],
            }
        )
    return rows


def write_csv(rows: Sequence[Row], path: Path) -> None:
    """Write the rows as CSV, one line of names first."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with replacing(path) as beside:
        beside.write_text(csv_text([columns, *([row.get(key) for key in columns] for row in rows)]), encoding="utf-8")


def write_json(found: Row, path: Path) -> None:
    """Write what was found as one JSON object."""
    with replacing(path) as beside:
        beside.write_text(json.dumps(found, indent=2, allow_nan=False) + "\n", encoding="utf-8")
