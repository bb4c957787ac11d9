"""Orbits, maps, flows and basins as labelled datasets with units and provenance, and into netCDF.

Every file is flat: numbers with units, CF flags for what is one of a few words, and no text but in attributes, so that
xarray, MATLAB (``ncread``) and any HDF5 reader open it. ``axis`` runs over x, y, z, ``component`` over w, x, y, z.
"""

from helimag.orbits.datasets.along_inputs import branches_dataset, map_dataset, orbits_dataset
from helimag.orbits.datasets.around_orbits import basin_dataset, flow_dataset
from helimag.orbits.datasets.beside_runs import Along, comparison_dataset
from helimag.orbits.datasets.reading import Known, KnownFlow, KnownMap, content_of, known_in
from helimag.orbits.datasets.variables import Content, save_dataset

__all__ = [
    "Along",
    "Content",
    "Known",
    "KnownFlow",
    "KnownMap",
    "basin_dataset",
    "branches_dataset",
    "comparison_dataset",
    "content_of",
    "flow_dataset",
    "known_in",
    "map_dataset",
    "orbits_dataset",
    "save_dataset",
]
