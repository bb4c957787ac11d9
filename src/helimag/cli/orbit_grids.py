"""Commands about what is around an orbit: the map over two inputs, the slow flow, and the basin of attraction."""

from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from helimag.cli._common import PLAIN, Common
from helimag.cli._orbit_reports import flow_report, print_basin, print_flow, print_map
from helimag.cli._outputs import (
    DATA,
    FIGURE,
    Drawing,
    FigureSize,
    Outputs,
    check_outputs,
    files_report,
    print_files,
    stored,
    write_outputs,
)
from helimag.cli._shared import (
    Changes,
    ScenarioName,
    input_range,
    print_json,
    progress_bar,
    quantity,
    scenario_from,
    whole,
)
from helimag.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from helimag.orbits import Orbit
    from helimag.scenario import Scenario

    Floats = NDArray[np.float64]

STARTS = 9  # a side, of the basin that the flow's picture shows
DEFAULT_STARTS = {"full": 7, "averaged": 11}  # a side

Box = Annotated[
    str | None,
    Parameter(
        allow_leading_hyphen=True,
        help="How far to go from the orbit on each side, such as '50 mm', or ranges of x, y and z in the moving frame, "
        "such as '-60 mm..40 mm, -70 mm..40 mm, -60 mm..40 mm'. Default: 0.36 of drive.distance on each side.",
    ),
]


def map_(
    scenario: ScenarioName,
    *,
    vary: Annotated[
        list[str],
        Parameter(
            negative="",
            consume_multiple=False,
            help='An input with its range, such as --vary drive.pitch="4 deg..20 deg". To be given twice.',
        ),
    ],
    changes: Changes = None,
    nodes: Annotated[int, whole(2, 1000)] = 40,
    output: Outputs = None,
    size: FigureSize = None,
    common: Common = PLAIN,
) -> None:
    """Map where an orbit is stable over two inputs, with the exact boundary.

    Parameters
    ----------
    nodes
        Values of each input.
    output
        Write a figure (.png, .svg, .pdf) or the data (.nc) to this file. May be repeated.
    """
    if len(vary) != 2:
        raise InputError(f"--vary must be given twice, with two inputs and their ranges; got {len(vary)}")
    check_outputs(output, FIGURE, DATA, size=size)
    import numpy as np

    from helimag import orbits

    chosen = scenario_from(scenario, changes)
    spans = [_span(chosen, text) for text in vary]
    if spans[0][0] == spans[1][0]:
        raise InputError(f"--vary must name two different inputs; got {spans[0][0]} twice")
    grids = [(path, np.linspace(low, high, nodes)) for path, (low, high) in spans]
    with progress_bar(f"mapping {chosen.title}") as progress:
        watch = orbits.Watch(progress)
        seeds = orbits.seeds_within(chosen, dict(spans), progress=watch.part(0.0, 0.1))
        result = orbits.stability_map(chosen, grids[0], grids[1], seeds=seeds, progress=watch.part(0.1, 0.5))
        curves = orbits.boundary_of(result, progress=watch.part(0.5, 1.0))
    write_outputs(
        output,
        {
            FIGURE: Drawing(lambda plots, size: plots.draw_stability(result, curves, size=size)),
            DATA: stored(lambda: orbits.map_dataset(result, curves)),
        },
        size=size,
    )
    print_map(result, curves, output, common.json)


def flow(
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    box: Box = None,
    nodes: Annotated[int, whole(4, 100)] = 13,
    output: Outputs = None,
    size: FigureSize = None,
    common: Common = PLAIN,
) -> None:
    """Work out the slow flow around an orbit: how the device drifts, where it stands still, and how exact that is.

    Parameters
    ----------
    nodes
        Of the flow's grid along each side.
    output
        Write a figure (.png, .svg, .pdf) or the data (.nc) to this file. May be repeated.
    """
    check_outputs(output, FIGURE, DATA, size=size)
    from helimag import orbits

    chosen = scenario_from(scenario, changes)
    span = _read_box(box)
    with progress_bar(f"slow flow of {chosen.title}") as progress:
        watch = orbits.Watch(progress)
        orbit = orbits.find_orbit(chosen, progress=watch.part(0.0, 0.05))
        low, high = _corners(span, orbit)
        shape = nodes, nodes, nodes
        result = orbits.slow_flow(orbit, low=low, high=high, shape=shape, progress=watch.part(0.05, 0.55))
        points = orbits.fixed_points(result, progress=watch.part(0.55, 0.6))
        listed = orbits.list_orbits(chosen, low=list(low), high=list(high), progress=watch.part(0.6, 0.85))
        pairs = orbits.counterparts(points, listed, result)
        errors = orbits.averaging_errors(result, orbit, progress=watch.part(0.85, 0.9))
        caught = None
        if orbit.stable:
            starts = STARTS, STARTS, STARTS
            caught = orbits.basin(orbit, low=low, high=high, shape=starts, flow=result, progress=watch.part(0.9, 1.0))
    write_outputs(
        output,
        {
            FIGURE: Drawing(lambda plots, size: plots.draw_flow(result, orbit, caught, fixed_points=points, size=size)),
            DATA: stored(lambda: orbits.flow_dataset(result, orbit, pairs, caught)),
        },
        size=size,
    )
    report = flow_report(result, orbit, pairs, len(listed), errors)
    if common.json:
        print_json(report | files_report(output))
    else:
        print_flow(result.scenario.title, orbit, report)
        print_files(output)


def basin(
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    engine: Literal["full", "averaged"] = "full",
    attitude: Literal["settled", "released"] = "settled",
    box: Box = None,
    nodes: Annotated[int | None, whole(2, 100)] = None,
    duration: str | None = None,
    check: Annotated[int, whole(1, 100_000)] = 60,
    output: Outputs = None,
    size: FigureSize = None,
    common: Common = PLAIN,
) -> None:
    """Find from which places a device that is released comes to the stable orbit: volume, tally and picture.

    Parameters
    ----------
    engine
        "full" runs, or the "averaged" model: faster, less exact, and held against full runs from some of the starts.
    attitude
        With which the device is released: "settled" is that to which it settles when held at the start, "released" that
        of the scenario's own start, as "simulate" releases it. Full runs only.
    nodes
        Starts along each side; default 7 with full runs, 11 with the averaged model.
    duration
        Of each run, such as "2400 s"; default the orbit's longest decay time, within 1200 s and 20,000 s.
    check
        How many starts of the averaged model are also judged by full runs.
    output
        Write a figure (.png, .svg, .pdf) or the data (.nc) to this file. May be repeated.
    """
    starts = DEFAULT_STARTS[engine] if nodes is None else nodes
    check_outputs(output, FIGURE, DATA, size=size)
    if engine == "averaged" and attitude != "settled":
        raise InputError("--attitude released needs full runs: the averaged model knows settled attitudes only")
    from helimag import orbits

    chosen = scenario_from(scenario, changes)
    lasting = _duration(duration)
    span = _read_box(box)
    shape = starts, starts, starts
    with progress_bar(f"basin of {chosen.title}") as progress:
        watch = orbits.Watch(progress)
        orbit = orbits.find_orbit(chosen, progress=watch.part(0.0, 0.1))
        low, high = _corners(span, orbit)
        compared = None
        if engine == "full":
            caught = orbits.basin(
                orbit,
                low=low,
                high=high,
                shape=shape,
                duration=lasting,
                attitude=attitude,
                progress=watch.part(0.1, 1.0),
            )
        else:
            caught = orbits.basin_by_flow(
                orbit, low=low, high=high, shape=shape, duration=lasting, progress=watch.part(0.1, 0.65)
            )
            compared = orbits.agreement(caught, starts=check, progress=watch.part(0.65, 1.0))
    write_outputs(
        output,
        {
            FIGURE: Drawing(lambda plots, size: plots.draw_basin(caught, size=size)),
            DATA: stored(lambda: orbits.basin_dataset(caught, compared)),
        },
        size=size,
    )
    print_basin(caught, compared, (low, high), output, common.json)


def _span(scenario: "Scenario", text: str) -> tuple[str, tuple[float, float]]:
    """One --vary as path and range, both ends of which the scenario can have."""
    path, (low, high) = input_range("--vary", scenario, text)
    if not low < high:
        raise InputError(f"--vary must have a range from low to high; got {text!r}")
    return path, (low, high)


def _duration(text: str | None) -> float | None:
    from helimag import quantities

    if text is None:
        return None
    value = quantities.parse(text, quantities.TIME)
    if not value > 0.0:
        raise InputError(f"--duration must be positive; got '{text}'")
    return value


def _read_box(text: str | None) -> "float | tuple[Floats, Floats] | None":
    """A box as how far it reaches (m), as corners (m), or None where it is left to the command."""
    import numpy as np

    from helimag import quantities as q

    if text is None:
        return None
    if ".." not in text:
        reach = quantity("--box", text, q.LENGTH)
        if not reach > 0.0:
            raise InputError(f"--box must reach farther than nothing; got '{text}'")
        return reach
    ends = [side.split("..") for side in text.split(",")]
    if len(ends) != 3 or any(len(pair) != 2 for pair in ends):
        raise InputError(
            f"--box must have three ranges such as '-60 mm..40 mm, -70 mm..40 mm, 0 mm..40 mm'; got '{text}'"
        )
    low, high = np.array([[q.parse(end.strip(), q.LENGTH) for end in pair] for pair in ends]).T
    if not np.all(low < high):
        raise InputError(f"--box must have ranges from low to high; got '{text}'")
    return low, high


def _corners(span: "float | tuple[Floats, Floats] | None", orbit: "Orbit") -> "tuple[Floats, Floats]":
    from helimag.orbits import box_around

    around = box_around(orbit, reach=None if isinstance(span, tuple) else span)
    return span if isinstance(span, tuple) else around
