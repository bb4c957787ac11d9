"""What the robot commands print."""

from collections import Counter
from pathlib import Path
from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from helimag.robot import ArmPlan, Deviation, Playback
    from helimag.runs import Judgement
    from helimag.runs.trajectory import Trajectory

SHOWN = 10  # differences


def judged(run: "Trajectory") -> dict[str, Any]:
    """Gain, verdict and end of a run as plain data."""
    judgement = run.judgement
    return {
        "gain": judgement.gain,
        "verdict": str(judgement.verdict),
        "reason": judgement.reason,
        "end_time_s": judgement.end_time,
        "final_state": run.final_state.tolist(),
    }


def deviation_data(found: "Deviation", plan: "ArmPlan", playback: "Playback") -> dict[str, Any]:
    """A programme's deviations from its plan as plain data."""
    return {
        "position_m": found.position,
        "axis_rad": found.axis,
        "timing": found.timing,
        "duration_s": found.duration,
        "planned_duration_s": plan.duration,
        "differences": list(found.differences),
        "override_set": playback.override_set,
        "acceptable": found.acceptable,
    }


def print_deviation(found: "Deviation", plan: "ArmPlan", playback: "Playback", source: Path) -> None:
    """A programme's deviations from its plan in words."""
    print(f"{source} against the plan of {plan.scenario.title}")
    print(f"  position  within {1e6 * found.position:.3f} um")
    print(f"  attitude  within {found.axis:.2e} rad")
    print(f"  timing    within {100.0 * found.timing:.4f} %  ({found.duration:.2f} s, planned {plan.duration:.2f} s)")
    if not playback.override_set:
        print("  override  not set by the programme; taken as 100 %")
    for difference in found.differences[:SHOWN]:
        print(f"  differs   {difference}")
    if len(found.differences) > SHOWN:
        print(f"  differs   in {len(found.differences) - SHOWN} more places")


def outcome_data(kind: str, runs: "Sequence[Judgement]") -> dict[str, Any]:
    """One kind of error as plain data."""
    return {"kind": kind, "gains": [each.gain for each in runs], "verdicts": [str(each.verdict) for each in runs]}


def print_outcome(kind: str, runs: "Sequence[Judgement]") -> None:
    """One kind of error in words."""
    gains = [each.gain for each in runs]
    tally = Counter(each.verdict for each in runs)
    counts = ", ".join(f"{count} {verdict}" for verdict, count in tally.items())
    spread = f"+- {stdev(gains):.4f}" if len(gains) > 1 else "(one run)"
    print(f"  {kind:16s} gain {fmean(gains):.4f} {spread:9s}   {counts}")


def print_plan(found: dict[str, Any]) -> None:
    """The feasibility report in words."""
    print(
        f"{found['scenario']} with {found['arm']}, cell '{found['cell']}': "
        f"{'feasible' if found['feasible'] else 'NOT feasible'}"
    )
    if found["offence"] is not None:
        print(f"  {found['offence']['text']}")
        for remedy in found["remedies"]:
            print(f"  remedy    {remedy}")
    if "with_unwinding" in found:
        other = found["with_unwinding"]
        outcome = (
            f"feasible with {other['unwindings']} unwindings, {other['duration_s']:.1f} s"
            if other["feasible"]
            else "not feasible"
        )
        print(f"  --unwind  {outcome}")
    tool = found["tool"]
    print(
        f"  tool      motor's axis {tool['motor_axis']} the rotation axis, turned "
        f"{tool['roll_deg']:.0f} deg, branch {tool['branch']}"
    )
    print(f"  duration  {found['duration_s']:.1f} s, {found['laps']:.2f} laps, {len(found['unwindings'])} unwindings")
    margins = found["margins"]
    if margins is not None:
        joints = ", ".join(f"{name} {value:.0f}" for name, value in margins["joint_limits_deg"].items())
        print(f"  margins   joints (deg) {joints}; singularity {margins['singularity_deg']:.0f} deg")
        near = ", ".join(f"{name} {value:.0f} mm" for name, value in margins["obstacles_mm"].items())
        print(
            f"            fastest joint at {100.0 * margins['largest_share_of_joint_speed']:.1f} % of its speed; {near}"
        )
