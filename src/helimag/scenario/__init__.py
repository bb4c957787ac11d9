"""Scenarios: device, fluid, magnets, drive, workspace and run, as frozen models that read and write TOML.

Numbers are SI (angles in radians) once inside. In a file every physical value is text with a unit; from Python a bare
number is taken as SI.
"""

from helimag.scenario._device import (
    CylinderHead,
    Device,
    Helix,
    Hydrodynamics,
    Part,
    SphereHead,
    SpheroidHead,
    Weight,
)
from helimag.scenario._fields import (
    Acceleration,
    Angle,
    AngularRate,
    Frequency,
    Length,
    Quantity,
    Size,
    Time,
)
from helimag.scenario._files import load, parse, preset_names
from helimag.scenario._path import Path
from helimag.scenario._scenario import MARKS, Scenario, messages
from helimag.scenario._surroundings import Drive, Fluid, Magnet, Run, Walls, Workspace
from helimag.scenario.inputs import Input

__all__ = [
    "MARKS",
    "Acceleration",
    "Angle",
    "AngularRate",
    "CylinderHead",
    "Device",
    "Drive",
    "Fluid",
    "Frequency",
    "Helix",
    "Hydrodynamics",
    "Input",
    "Length",
    "Magnet",
    "Part",
    "Path",
    "Quantity",
    "Run",
    "Scenario",
    "Size",
    "SphereHead",
    "SpheroidHead",
    "Time",
    "Walls",
    "Weight",
    "Workspace",
    "load",
    "messages",
    "parse",
    "preset_names",
]
