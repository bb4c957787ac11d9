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
    Inertia,
    Length,
    Mass,
    Quantity,
    Size,
    Time,
)
from helimag.scenario._files import as_scenario, load, parse, preset_names
from helimag.scenario._kept import check_kept, same_version
from helimag.scenario._meanings import meanings, schema
from helimag.scenario._path import Path
from helimag.scenario._refusals import messages, model_of, models_in
from helimag.scenario._remanence import REMANENCE
from helimag.scenario._scenario import MARKS, Scenario, validated
from helimag.scenario._surroundings import PAPER_TANK, Drive, Fluid, Magnet, Run, Walls, Workspace
from helimag.scenario.inputs import Input, check_apart, drive_inputs, scalar_inputs, varied
from helimag.scenario.parameters import Parameters
from helimag.scenario.priors import LogUniform, Normal, Prior, Uniform

__all__ = [
    "MARKS",
    "PAPER_TANK",
    "REMANENCE",
    "Acceleration",
    "Angle",
    "AngularRate",
    "Body",
    "CylinderHead",
    "Device",
    "Drive",
    "Fluid",
    "Frequency",
    "Helix",
    "Hydrodynamics",
    "Inertia",
    "Input",
    "Length",
    "LogUniform",
    "Magnet",
    "Mass",
    "Normal",
    "Parameters",
    "Part",
    "Path",
    "Prior",
    "Quantity",
    "Run",
    "Scenario",
    "Size",
    "SphereHead",
    "SpheroidHead",
    "Time",
    "Uniform",
    "Walls",
    "Weight",
    "Workspace",
    "as_scenario",
    "check_apart",
    "check_kept",
    "drive_inputs",
    "load",
    "meanings",
    "messages",
    "model_of",
    "models_in",
    "parse",
    "preset_names",
    "same_version",
    "scalar_inputs",
    "schema",
    "validated",
    "varied",
]
