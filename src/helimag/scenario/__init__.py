"""Scenarios: device, fluid, magnets, drive, workspace and run, as frozen models that read and write TOML.

Numbers are SI (angles in radians) once inside. In a file every physical value is text with a unit; from Python a bare
number is taken as SI.
"""

from helimag.scenario._body import Body
from helimag.scenario._device import (
    CylinderHead,
    Device,
    Helix,
    Hydrodynamics,
    SphereHead,
    SpheroidHead,
    Weight,
)
from helimag.scenario._files import load, parse, preset_names
from helimag.scenario._path import Path
from helimag.scenario._scenario import MARKS, Scenario
from helimag.scenario._surroundings import Drive, Fluid, Magnet, Run, Walls, Workspace
from helimag.scenario.inputs import Input

__all__ = [
    "MARKS",
    "Body",
    "CylinderHead",
    "Device",
    "Drive",
    "Fluid",
    "Helix",
    "Hydrodynamics",
    "Input",
    "Magnet",
    "Path",
    "Run",
    "Scenario",
    "SphereHead",
    "SpheroidHead",
    "Walls",
    "Weight",
    "Workspace",
    "load",
    "parse",
    "preset_names",
]
