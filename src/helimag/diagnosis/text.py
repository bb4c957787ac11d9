"""A diagnosis in words, and as JSON."""

import math
from typing import Any

from helimag.diagnosis.scenario import Diagnosis, Travel
from helimag.geometry import magnet_start


def as_text(found: Diagnosis) -> str:
    """Lines for people: forces, motion, which end leads, where values come from, checks."""
    drive = found.scenario.drive
    pull, net = (", ".join(f"{round(1e6 * x, 2) + 0.0:.2f}" for x in force) for force in (found.pull, found.net_force))
    lines = [
        f"{found.scenario.title}: at the start, {1e3 * found.start_distance:.1f} mm from the magnet",
        f"  magnets       {_moment(found)}",
        f"  pull          ({pull}) uN, mean over a turn in step",
        f"  net weight    {1e6 * found.net_weight:.2f} uN; net force ({net}) uN",
        f"  balance       {_balance(found)}",
        f"  step-out      {found.step_out_frequency:.2f} Hz at least, {found.margin:.2f} times the drive's frequency",
        f"  roll          relaxes at {found.roll_rates[0]:.0f} to {found.roll_rates[1]:.0f} per s",
        f"  swimming      {1e3 * abs(found.advance):.3f} mm a turn, {1e3 * found.swimming_speed:.3f} mm/s at "
        f"{abs(drive.frequency):g} Hz{_in_step(found)}",
        f"  sinking       {1e3 * found.sinking[0]:.3f} mm/s level, {1e3 * found.sinking[1]:.3f} mm/s upright",
        f"  start         {_travel(found.at_start)}",
        f"  settled axis  {_travel(found.settled)}",
    ]
    lines += [f"  walls         {walls}"] if (walls := _walls(found)) else []
    lines += [f"  {mark:13s} {', '.join(paths)}" for mark, paths in found.sources.items() if paths]
    lines += [
        f"  {'holds' if check.holds else 'DOES NOT HOLD':13s} {check.name}: {check.message}" for check in found.checks
    ]
    return "\n".join(lines)


def _moment(found: Diagnosis) -> str:
    total, half = found.moment
    if half is None:
        return f"{total:.4g} A m^2, how well known is not said"
    return f"{total:.4g} ± {half:.2g} A m^2; field, pull and step-out share its {100.0 * half / total:.2g} %"


def _in_step(found: Diagnosis) -> str:
    """That swimming supposes what step-out does not promise; nothing where it does."""
    return "" if found.margin >= 1.0 else ", were it in step"


def _balance(found: Diagnosis) -> str:
    if found.balance_distance is None:
        return "nowhere straight below the magnet"
    height = round(1e3 * (magnet_start(found.scenario.drive)[2] - found.balance_distance), 1) + 0.0  # never -0.0
    return f"{1e3 * found.balance_distance:.1f} mm straight below the magnet, at a height of {height:.1f} mm"


def _walls(found: Diagnosis) -> str:
    """What floor, surface and walls do to a device that comes to them; nothing where there are none."""
    workspace = found.scenario.workspace
    if not workspace.bounded:
        return ""
    if not workspace.holds:
        return "stop a run that comes to them"
    pull = f"; the surface holds each end with {1e6 * workspace.surface_pull:.3g} uN" if workspace.surface_pull else ""
    return f"hold a device that comes to them, without friction{pull}"


def _travel(travel: Travel) -> str:
    nose, thrust = (math.degrees(math.asin(max(-1.0, min(1.0, float(v[2]))))) for v in (travel.nose, travel.thrust))
    leads = "the drive stands still" if travel.leads is None else f"{travel.leads} first as the drive carries it"
    way = "level" if abs(thrust) < 0.05 else "up" if thrust > 0.0 else "down"
    slope = way if way == "level" else f"{abs(thrust):.1f} deg {way}"
    return f"nose at {nose:+.1f} deg, {leads}; swims {travel.swims} first, thrust {slope}"


def as_json(found: Diagnosis) -> dict[str, Any]:
    """One object, SI, angles in degrees where the name says so."""
    low, high = found.roll_rates
    return {
        "name": found.scenario.title,
        "start_distance_m": found.start_distance,
        "magnet_moment_a_m2": found.moment[0],
        "magnet_moment_uncertainty_a_m2": found.moment[1],
        "pull_n": found.pull.tolist(),
        "net_weight_n": found.net_weight,
        "net_force_n": found.net_force.tolist(),
        "balance_distance_m": found.balance_distance,
        "field_t": list(found.field),
        "step_out_frequency_hz": found.step_out_frequency,
        "step_out_margin": found.margin,
        "roll_rates_per_s": [low, high],
        "advance_per_turn_m": found.advance,
        "swimming_speed_m_per_s": found.swimming_speed,
        "sinking_level_m_per_s": found.sinking[0],
        "sinking_upright_m_per_s": found.sinking[1],
        "walls": "hold" if found.scenario.workspace.holds else "stop" if found.scenario.workspace.bounded else None,
        "at_start": _travel_json(found.at_start),
        "settled": _travel_json(found.settled),
        "sources": found.sources,
        "checks": [{**check.as_dict(), "holds": check.holds} for check in found.checks],
    }


def _travel_json(travel: Travel) -> dict[str, Any]:
    return {
        "nose": travel.nose.tolist(),
        "leads": travel.leads,
        "swims": travel.swims,
        "thrust": travel.thrust.tolist(),
    }
