"""What the commands about maps, flows and basins print: as one JSON object, and in words."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from helimag.cli._outputs import files_report, print_files
from helimag.cli._shared import print_json

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from helimag.orbits import (
        Agreement,
        AveragingError,
        Basin,
        BoundaryCurve,
        Counterpart,
        FixedPoint,
        Orbit,
        SlowFlow,
        StabilityMap,
    )

    Floats = NDArray[np.float64]


def _complex(rates: "Sequence[complex] | NDArray[np.complex128]") -> list[list[float]]:
    return [[rate.real, rate.imag] for rate in rates]


def print_map(result: "StabilityMap", boundary: "list[BoundaryCurve]", output: list[Path] | None, json: bool) -> None:
    """Counts, the steadiest node and the boundary."""
    import numpy as np

    from helimag.scenario import Input

    total, found, stable = result.found.size, int(result.found.sum()), int(result.stable.sum())
    best = None
    if stable:
        i, j = np.unravel_index(int(np.argmin(np.where(result.stable, result.growth, np.inf))), result.growth.shape)
        best = [float(result.values[0][i]), float(result.values[1][j]), float(result.growth[i, j])]
    if json:
        inputs = [
            {"path": path, "low": float(values[0]), "high": float(values[-1]), "nodes": int(values.size)}
            for path, values in zip(result.paths, result.values, strict=True)
        ]
        steadiest = None if best is None else {"values": best[:2], "growth_per_s": best[2]}
        counts = {"nodes": total, "with_orbit": found, "stable": stable, "steadiest": steadiest}
        print_json(
            {"inputs": inputs, **counts, "boundary": [_curve_report(curve) for curve in boundary]}
            | files_report(output)
        )
        return
    given = [Input(path) for path in result.paths]
    names = " and ".join(each.name for each in given)
    print(f"{result.scenario.title}: an orbit is stable at {stable} of {total} nodes of {names}")
    if best is None:
        print(
            "  nowhere stable in these ranges: widen them; whether the device can be held: docs/howto/another-device.md"
        )
    else:
        where = ", ".join(f"{g.name} {g.show(result.scenario, v)}" for g, v in zip(given, best, strict=False))
        print(f"  steadiest     {where}: the slowest motion decays in {-1.0 / best[2]:.4g} s")
    for curve in boundary:
        spans = ", ".join(
            f"{each.name} {each.show(result.scenario, values.min())} to {each.show(result.scenario, values.max())}"
            for each, values in zip(given, (curve.first, curve.second), strict=True)
        )
        ends = f"; ends: {curve.ends[0]}, {curve.ends[1]}" if any(curve.ends) else ""
        print(f"  boundary      {curve.kind}, {len(curve.first)} points: {spans}{ends}")
    print_files(output)


def _curve_report(curve: "BoundaryCurve") -> dict[str, Any]:
    import numpy as np

    return {
        "kind": str(curve.kind),
        "ends": list(curve.ends),
        "first": curve.first.tolist(),
        "second": curve.second.tolist(),
        "swing_per_s": [value if np.isfinite(value) else None for value in curve.swing.tolist()],
    }


def flow_report(
    flow: "SlowFlow",
    orbit: "Orbit",
    pairs: "list[Counterpart]",
    listed: int,
    errors: "list[tuple[float, AveragingError]]",
) -> dict[str, Any]:
    import numpy as np

    from helimag import orbits

    rates = orbits.averaged_rates(flow, orbit)
    return {
        "box_m": [[float(axis[0]), float(axis[-1])] for axis in flow.axes],
        "nodes": int(flow.settled.size),
        "settled": int(flow.settled.sum()),
        "orbit_m": orbit.position.tolist(),
        "averaged_rates_per_s": _complex(rates) if np.isfinite(rates).all() else None,
        "floquet_rates_per_s": _complex(orbit.rates[:3]),
        "fixed_points": [_point_report(pair.point, pair.orbit) for pair in pairs if pair.point is not None],
        "orbits_without_fixed_point_m": [
            pair.orbit.position.tolist() for pair in pairs if pair.point is None and pair.orbit is not None
        ],
        "orbits_of_other_sense": listed - sum(pair.orbit is not None for pair in pairs),
        "averaging_error": [
            {
                "from_orbit_m": away,
                "compared_s": float(error.time[-1]),
                "mean_m": error.mean,
                "worst_m": error.worst,
            }
            for away, error in errors
        ],
    }


def _point_report(point: "FixedPoint", orbit: "Orbit | None") -> dict[str, Any]:
    import numpy as np

    beside = None
    if orbit is not None:
        beside = {
            "position_m": orbit.position.tolist(),
            "rates_per_s": _complex(orbit.rates[:3]),
            "stable": orbit.stable,
            "distance_m": float(np.linalg.norm(orbit.position - point.position)),
        }
    return {
        "position_m": point.position.tolist(),
        "kind": point.kind,
        "stable": point.stable,
        "rates_per_s": _complex(point.rates),
        "error_m": point.error if np.isfinite(point.error) else None,
        "orbit": beside,
    }


def print_flow(name: str, orbit: "Orbit", report: dict[str, Any]) -> None:
    """What :func:`flow_report` says, in words."""
    print(f"{name}: {orbit.text}")
    print(f"  grid          {report['nodes']} nodes, at {report['settled']} of which the device keeps in step")
    if report["averaged_rates_per_s"] is not None:
        print(f"  rates         averaged {_shown(report['averaged_rates_per_s'])} per second")
        print(f"                Floquet  {_shown(report['floquet_rates_per_s'])} per second")
    for point in report["fixed_points"]:
        exact = "of unknown error" if point["error_m"] is None else f"exact to {_length(point['error_m'])}"
        print(f"  fixed point   {_place(point['position_m'])}, {point['kind']}; {exact}")
        beside = point["orbit"]
        if beside is None:
            print("                no orbit was found beside it")
            continue
        print(
            f"                {'stable' if beside['stable'] else 'unstable'} orbit {_length(beside['distance_m'])} away"
        )
        print(f"                averaged {_shown(point['rates_per_s'])} per second")
        print(f"                Floquet  {_shown(beside['rates_per_s'])} per second")
    for place in report["orbits_without_fixed_point_m"]:
        print(f"  orbit         {_place(place)} without a fixed point beside it")
    if report["orbits_of_other_sense"]:
        print(f"  not in it     {report['orbits_of_other_sense']} orbits with the nose the other way")
    for error in report["averaging_error"]:
        print(
            f"  error         {_length(error['mean_m'])} on average, {_length(error['worst_m'])} at most, beside a "
            f"full run of {error['compared_s']:.0f} s from {_length(error['from_orbit_m'])} off the orbit"
        )


def _shown(rates: list[list[float]]) -> str:
    return ", ".join(f"{a:.4g} ± {b:.4g}i" if b > 0.0 else f"{a:.4g}" for a, b in rates if b >= 0.0)


def _place(position: list[float]) -> str:
    x, y, z = (1e3 * value for value in position)
    return f"({x:.2f}, {y:.2f}, {z:.2f}) mm"


def _length(length: float) -> str:
    if length < 1e-8:
        return "less than 10 nm"
    return f"{1e3 * length:.2g} mm" if length >= 1e-5 else f"{1e6 * length:.2g} um"


def print_basin(
    caught: "Basin",
    compared: "Agreement | None",
    box: "tuple[Floats, Floats]",
    output: list[Path] | None,
    json: bool,
) -> None:
    from helimag.runs.shares import in_percent

    share, interval = caught.share, caught.interval
    if json:
        agreed = None
        if compared is not None:
            agreed = {
                "starts": int(compared.starts.size),
                "share": compared.share,
                "interval": list(compared.interval),
                **compared.counts,
            }
        tally = {name: int((caught.ends == name).sum()) for name in dict.fromkeys(caught.ends.tolist())}
        print_json(
            {
                "engine": caught.engine,
                "attitude": caught.attitude,
                "box_m": [[float(a), float(b)] for a, b in zip(*box, strict=True)],
                "starts": int(caught.ends.size),
                "volume_m3": caught.volume,
                "captured_share": share,
                "captured_share_95": list(interval),
                "ends": tally,
                "duration_s": caught.duration,
                "longest_decay_s": -1.0 / caught.orbit.growth,
                "reaches_edge": caught.reaches_edge,
                "agreement": agreed,
            }
            | files_report(output)
        )
        return
    print(f"{caught.orbit.scenario.title}: {caught.text}")
    sides = " x ".join(f"{1e3 * side:.0f}" for side in box[1] - box[0])
    low, high = map(in_percent, interval)
    print(f"  captured      {in_percent(share)} % of the box of {sides} mm; {low} to {high} %, with 95 % confidence")
    if caught.hasty:
        decay = -1.0 / caught.orbit.growth
        print(f"  runs          end before the orbit's longest decay time, {decay:.0f} s: the rest may come yet")
    if caught.reaches_edge:
        print("  box           the basin goes on beyond it: the volume is that within, choose a larger --box for more")
    if compared is not None:
        print(f"  checked       {compared.text}")
    print_files(output)
