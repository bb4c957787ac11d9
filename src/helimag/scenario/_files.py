"""Scenarios from presets and TOML files."""

from importlib import resources
from pathlib import Path
from typing import Any

from helimag.errors import InputError
from helimag.files import text_of, toml_tables
from helimag.scenario._refusals import meant
from helimag.scenario._scenario import Scenario, validated


def parse(text: str, source: str = "scenario", *, folder: Path | None = None) -> Scenario:
    """Read a scenario from TOML text; ``source`` names it in messages, ``folder`` is where its files lie.

    Returns
    -------
    Scenario
        Checked.

    Raises
    ------
    InputError
        Where the text is not TOML or not a scenario.
    """
    data = toml_tables(text, source)
    if "device" not in data and ("axis" in data or "free" in data):
        what = "sweep" if "axis" in data else "calibration"
        raise InputError(
            f"{source} is the plan of a {what}, not a scenario: a scenario has a device, a fluid and a drive"
        )
    if folder is not None:
        _place_files(data, folder)
    try:
        return validated(data, in_file=True)
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def _place_files(data: dict[str, Any], folder: Path) -> None:
    """Let the name of a body's file, which counts from the scenario's folder, count from the working folder."""
    device = data.get("device")
    body = device.get("body") if isinstance(device, dict) else None
    if isinstance(body, dict) and isinstance(body.get("file"), str):
        body["file"] = str(folder / body["file"])


def _preset_folder() -> Any:
    return resources.files("helimag") / "presets"


def preset_names() -> list[str]:
    """Names of the presets, such as ``paper/fig3c``.

    Returns
    -------
    list of str
        In order of the alphabet.

    Examples
    --------
    >>> import helimag as hm
    >>> [name for name in hm.preset_names() if name.startswith("paper/fig3")]
    ['paper/fig3a', 'paper/fig3b', 'paper/fig3c']
    """
    folders = (folder for folder in _preset_folder().iterdir() if folder.is_dir())
    return sorted(
        f"{folder.name}/{file.name.removesuffix('.toml')}"
        for folder in folders
        for file in folder.iterdir()
        if file.name.endswith(".toml")
    )


def as_scenario(scenario: Scenario | str | Path) -> Scenario:
    """A scenario as it is, or loaded by its name or path.

    Returns
    -------
    Scenario
        Such as functions work with.

    Raises
    ------
    FileError, InputError
        As :func:`load` raises them, and where it is something else altogether.
    """
    if isinstance(scenario, (str, Path)):
        return load(scenario)
    if not isinstance(scenario, Scenario):
        raise InputError(
            f"a scenario must be what helimag.load gives, or a name that it takes; got {type(scenario).__name__}"
        )
    return scenario


def load(scenario: str | Path) -> Scenario:
    """Load a scenario: the name of a preset, or the path of a TOML file.

    Parameters
    ----------
    scenario
        Such as ``"paper/fig3c"`` or ``"my-run.toml"``.

    Returns
    -------
    Scenario
        With every value in SI.

    Raises
    ------
    FileError
        Where there is no such preset and no such readable file.
    InputError
        Where the file is not a scenario.

    Examples
    --------
    >>> import helimag as hm
    >>> scenario = hm.load("paper/fig3c")
    >>> scenario.drive.frequency  # Hz
    3.3
    >>> scenario.provenance["device.weight.net_weight"].partition(":")[0]
    'fitted'
    """
    if str(scenario) in preset_names():
        return parse((_preset_folder() / f"{scenario}.toml").read_text(encoding="utf-8"), str(scenario))
    path = Path(scenario)
    neither = f"scenario must be a preset (see 'helimag presets') or a TOML file; '{scenario}' is neither"
    neither += meant(str(scenario), preset_names())
    return parse(text_of(path, missing=neither), str(path), folder=path.parent)
