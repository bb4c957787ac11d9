"""The command line. Thin: each command imports what it needs when it runs, so that --help is instant."""

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, CycloptsError, Parameter

from helimag.errors import HelimagError, InputError, RunError

if TYPE_CHECKING:
    from helimag.scenario import Scenario
    from helimag.trajectory import Trajectory

app = App(
    name="helimag",
    help="Simulate and judge open-loop runs of magnetic helical devices under a rotating permanent magnet.",
    version_flags=["--version"],
    result_action="return_value",
)

ScenarioName = Annotated[str, Parameter(help="Name of a preset, or path of a TOML file.")]
Changes = Annotated[
    list[str] | None,
    Parameter(
        name="--set",
        negative="",
        consume_multiple=False,
        help='Change a field, such as --set drive.pitch="15 deg". May be repeated.',
    ),
]
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object on stdout and nothing else.")]
Output = Annotated[Path | None, Parameter(name=["--output", "-o"])]


def main() -> None:
    """Run the command line: exit status 0 done, 1 a run failed, 2 bad input."""
    try:
        app(exit_on_error=False, print_error=False)
    except RunError as error:
        _fail(str(error), 1)
    except HelimagError as error:
        _fail(str(error), 2)
    except CycloptsError as error:
        _fail(" ".join(str(error).split()), 2)
    except KeyboardInterrupt:
        _fail("interrupted", 130)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(1)


def _fail(message: str, status: int) -> None:
    print("helimag: " + " ".join(message.split()), file=sys.stderr)
    sys.exit(status)


@contextmanager
def _progress(what: str) -> Iterator[Callable[[float], None]]:
    """A progress bar with an estimate on stderr, which appears when the work has taken a second."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(what, total=1.0)
    begun = time.monotonic()

    def report(done: float) -> None:
        if not bar.live.is_started and time.monotonic() - begun > 1.0:
            bar.start()
        bar.update(task, completed=done)

    try:
        yield report
    finally:
        if bar.live.is_started:
            bar.stop()


def _print_json(data: object) -> None:
    print(json.dumps(data, indent=2, allow_nan=False))


def _scenario(name: str, changes: list[str] | None, extra: dict[str, object] | None = None) -> "Scenario":
    from helimag.scenario import load

    fields: dict[str, object] = {}
    for change in changes or []:
        path, equals, value = change.partition("=")
        if not equals:
            raise InputError(f'--set must be a field and a value such as drive.pitch="15 deg"; got {change!r}')
        fields[path.strip()] = _value(value.strip())
    fields |= {path: value for path, value in (extra or {}).items() if value is not None}
    scenario = load(name)
    return scenario.replaced(fields) if fields else scenario


def _value(text: str) -> object:
    """The value of --set: TOML where it is an array or table, plain text otherwise."""
    if text[:1] in "[{":
        import tomllib

        try:
            return tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError as error:
            raise InputError(f"--set has a value that is not TOML: {text} ({error})") from None
    return text.strip("\"'")


@app.command
def presets(name: str | None = None, *, schema: Annotated[bool, Parameter(negative="")] = False) -> None:
    """List the presets, or print one as TOML.

    Parameters
    ----------
    name
        A preset to print, every value with its unit and its mark: published, fitted or assumed.
    schema
        Print the JSON schema of scenario files instead.
    """
    from helimag.scenario import Scenario, load, preset_names

    if schema:
        _print_json(Scenario.model_json_schema())
    elif name is not None:
        print(load(name).to_toml(), end="")
    else:
        for preset in preset_names():
            scenario = load(preset)
            drive = scenario.drive
            speed = sum(v * v for v in drive.velocity) ** 0.5
            print(
                f"{preset:20s} {drive.frequency:g} Hz, pitch {_deg(drive.pitch):g} deg, {1e3 * drive.distance:g} mm, "
                f"yaw {_deg(drive.yaw_rate):g} deg/s, {1e3 * speed:g} mm/s, {scenario.run.duration:g} s"
            )


@app.command
def simulate(
    scenario: ScenarioName,
    *,
    changes: Changes = None,
    duration: str | None = None,
    interval: str | None = None,
    output: Output = None,
    device: str = "cpu",
    json: Json = False,
) -> None:
    """Run a scenario and judge it.

    Parameters
    ----------
    duration
        How long, such as "100 s", instead of the scenario's own.
    interval
        Time between samples in the result, such as "0.1 s".
    output
        Write the trajectory to this netCDF file.
    device
        "cpu", or a CUDA device such as "cuda".
    """
    from helimag.simulation import simulate as run

    chosen = _scenario(scenario, changes, {"run.duration": duration, "run.interval": interval})
    with _progress(f"simulating {chosen.name}") as progress:
        trajectory = run(chosen, device=device, progress=progress)
    if output is not None:
        trajectory.save(output)
    if json:
        _print_json(_report(trajectory))
    else:
        _print_summary(chosen, trajectory, output)


def _report(trajectory: "Trajectory") -> dict[str, Any]:
    judgement = trajectory.judgement
    return {
        "gain": judgement.gain,
        "output_y_m": judgement.output,
        "input_u_m": judgement.input,
        "verdict": str(judgement.verdict),
        "reason": judgement.reason,
        "end_time_s": judgement.end_time,
        "escape_time_s": judgement.escape_time,
        "slips": judgement.slips,
        "wobble_deg": _deg(judgement.wobble),
        "attack_angle_deg": _deg(judgement.attack_angle),
        "final_state": trajectory.final_state.tolist(),
        "wall_time_s": trajectory.dataset.attrs["wall_time"],
    }


def _print_summary(scenario: "Scenario", trajectory: "Trajectory", output: Path | None) -> None:
    judgement = trajectory.judgement
    print(f"{scenario.name}: {judgement.verdict}, {judgement.reason}")
    print(f"  gain          {judgement.gain:.3f}  (y {1e3 * judgement.output:.2f} mm, u {1e3 * judgement.input:.2f} mm)")
    print(f"  attack angle  {_deg(judgement.attack_angle):.1f} deg, wobble {_deg(judgement.wobble):.1f} deg (second half)")
    print(f"  slips         {judgement.slips}")
    guesses = [f"{path} {mark.partition(':')[0]}" for path, mark in scenario.provenance.items() if "published" not in mark]
    if guesses:
        print(f"  not published {', '.join(guesses)}")
    if output is not None:
        print(f"  written to    {output}")


def _deg(angle: float) -> float:
    return angle * 57.29577951308232


@app.command
def resistance(scenario: ScenarioName, *, changes: Changes = None, json: Json = False) -> None:
    """Print the device's 6x6 resistance about the head's centre, translation first (SI)."""
    from helimag import hydrodynamics

    chosen = _scenario(scenario, changes)
    matrix = hydrodynamics.resistance(chosen.device, chosen.fluid)
    model = chosen.device.hydrodynamics.model
    if json:
        mobility = hydrodynamics.mobility(matrix)
        _print_json({"resistance": matrix.tolist(), "mobility": mobility.tolist(), "model": model})
        return
    print(f"{chosen.name}, {model}: force (N), torque (N m) per velocity (m/s), angular velocity (rad/s)")
    for row in matrix:
        print("  ".join(f"{entry:12.4e}" for entry in row))


@app.command
def plot(
    run: Path,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    animate: Path | None = None,
) -> None:
    """Draw a run's path and time series, or an animation.

    Parameters
    ----------
    run
        A trajectory file, such as simulate wrote with -o.
    output
        Figure to write: .png, .svg or .pdf. Default: the run's name with .png.
    animate
        Film to write instead: .mp4.
    """
    from helimag import plots
    from helimag.trajectory import Trajectory

    trajectory = Trajectory.load(run)
    if animate is not None:
        with _progress(f"filming {run.name}") as progress:
            plots.animate(trajectory, animate, progress=progress)
        print(animate)
    if output is not None or animate is None:
        target = output or run.with_suffix(".png")
        plots.save(plots.draw_run(trajectory), target)
        print(target)


@app.command
def reproduce(
    what: Literal["fig3"], *, output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("."), json: Json = False
) -> None:
    """Compute a figure of the paper and print it beside the published values.

    Parameters
    ----------
    what
        Which figure.
    output
        Folder for the figure, the table and the runs.
    """
    from helimag import reproduce as book

    with _progress(f"reproducing {what}") as progress:
        result = book.fig3(output, progress=progress)
    if json:
        _print_json(result.rows)
    else:
        print(result.text)


@app.command
def doctor(*, json: Json = False) -> None:
    """Check this installation: versions, devices, and a short run against states from an independent code."""
    from helimag.doctor import examine

    report = examine()
    if json:
        _print_json(report.findings)
    else:
        print(report.text)
    if not report.healthy:
        raise RunError("the check run does not match the reference states: see 'helimag doctor'")


if __name__ == "__main__":
    main()
