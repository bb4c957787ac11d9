"""Which end of the device leads: the cosine between its nose (helix to head) and where it goes."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CLEAR = 0.5  # of the cosine: below that the device goes sideways rather than along its axis


def path_cosine(position: Floats, long_axis: Floats) -> float:
    """Mean cosine between nose and velocity relative to the fluid, weighted by the way gone; nan of a run at rest.

    Parameters
    ----------
    position, long_axis
        Of the samples, (n, 3) in m and (n, 3); samples that are not finite are left out.

    Returns
    -------
    float
        In [-1, 1]: positive where the head leads.
    """
    finite = np.isfinite(position).all(axis=1) & np.isfinite(long_axis).all(axis=1)
    gone = np.diff(position[finite], axis=0)
    nose = (long_axis[finite][1:] + long_axis[finite][:-1]) / 2.0
    way = float(np.linalg.norm(gone, axis=1).sum())
    return float(np.sum(nose * gone)) / way if way > 0.0 else float("nan")


def leading_end(cosine: float) -> str:
    """The end in front: ``"head"``, ``"helix"``, or ``"neither"`` where a cosine is small or not known.

    Returns
    -------
    str
        The word.

    Examples
    --------
    >>> leading_end(-0.98), leading_end(0.1)
    ('helix', 'neither')
    """
    if cosine > CLEAR:
        return "head"
    return "helix" if cosine < -CLEAR else "neither"
