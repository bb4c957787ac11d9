"""The command that lays a measured and a simulated run side by side: compare."""

from pathlib import Path
from typing import Literal

from helimag.cli._common import PLAIN, Common
from helimag.cli._outputs import (
    FIGURE,
    Drawing,
    FigureSize,
    Outputs,
    check_outputs,
    files_report,
    print_files,
    write_outputs,
)
from helimag.cli._shared import print_json


def compare(
    measured: Path,
    simulated: Path,
    *,
    align: Literal["fit", "start", "none"] = "fit",
    output: Outputs = None,
    size: FigureSize = None,
    common: Common = PLAIN,
) -> None:
    """Compare a measured run with a simulated one: difference with uncertainty, gain and verdict side by side.

    Parameters
    ----------
    measured
        A trajectory file, such as "vision track" wrote.
    simulated
        A trajectory file, such as "simulate" wrote.
    align
        How the simulated run is brought to the measured one: "fit" turns it about the vertical, moves it and shifts it
        in time; "start" moves its start; "none" leaves it.
    output
        Write a figure of both (.png, .svg, .pdf) to this file. May be repeated.
    """
    from helimag.runs import Trajectory, interval_text
    from helimag.runs import compare as lay_side_by_side

    check_outputs(output, FIGURE, size=size)
    comparison = lay_side_by_side(Trajectory.load(measured), Trajectory.load(simulated), align=align)
    write_outputs(
        output, {FIGURE: Drawing(lambda plots, size: plots.draw_comparison(comparison, size=size))}, size=size
    )
    numbers = comparison.numbers
    if common.json:
        print_json(numbers | files_report(output))
        return
    ours, theirs = numbers["measured"], numbers["simulated"]
    within = interval_text(ours["gain_95"], 4)
    if not comparison.really_measured:
        print(f"note          the run taken as measured is a simulation itself ({ours['source']}: {measured.name})")
    for doubt in numbers["doubts"]:
        print(f"note          {doubt}")
    print(f"{'':14s}{'measured':>12s}{'simulated':>12s}")
    print(f"{'gain':14s}{ours['gain']:12.4f}{theirs['gain']:12.4f}   measured {within}")
    print(f"{'|y| (mm)':14s}{1e3 * ours['output_y_m']:12.3f}{1e3 * theirs['output_y_m']:12.3f}")
    print(f"{'verdict':14s}{ours['verdict']:>12s}{theirs['verdict']:>12s}")
    print(
        f"difference    {1e3 * numbers['difference_rms_m']:.3f} mm rms, "
        f"{1e3 * numbers['difference_worst_m']:.3f} mm at most, over "
        f"{numbers['samples']} samples from {numbers['from_s']:.2f} s to {numbers['until_s']:.2f} s"
    )
    for name, left in numbers["left_out_s"].items():
        if left > 0.0:
            print(
                f"common time   {left:.2f} s of the {name} run lie outside it and do not count, in the verdict neither"
            )
    shift = ", ".join(f"{1e3 * value:.2f}" for value in numbers["translation_m"])
    print(f"alignment     {numbers['time_shift_s']:.2f} s, {numbers['yaw_deg']:.2f} deg about z, {shift} mm")
    print_files(output)
