"""What makes a fit of all pictures less certain than independent corners would: shared errors, a datum seen badly."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LEAST = 1e-12  # of the largest eigenvalue: smaller ones are directions that the pictures do not tell
ALONE = 1e-6  # share that other pictures must have in a direction for one picture's error in it to be told
CHANCE = 2.0  # standard deviations that independent errors reach by chance; what is found within them is none


def widening(jacobian: Floats, residuals: Floats, picture: NDArray[np.int64], shared: int) -> float:
    """Variance of the values that all pictures share over that which independent residuals would give; 1 or more.

    Blur, light and a bent board move neighbouring corners alike, so a picture tells less than its corners' number says.
    Each picture's own pull on the shared values, less what its pose takes up, shows by how much: the covariance that is
    robust to errors common to a cluster, with the leverage of small numbers of clusters taken out (CR2 of Bell and
    McCaffrey, Survey Methodology 28, 169, 2002), averaged over all directions. With independent errors that
    is 1 on average, and its variance is 2 sum(share^2) / directions^2, each picture having a share in what is known of
    each direction. Where chance explains what was found, 1 comes back: to raise all that is less to 1, and no more,
    would widen honest fits by a tenth.

    Parameters
    ----------
    jacobian, residuals
        (n, k) and (n,), weighted.
    picture
        (n,): number of the picture that a residual is of.
    shared
        How many columns are shared; after them come as many for every picture's pose.
    """
    poses = int(picture.max()) + 1
    own = (jacobian.shape[1] - shared) // poses
    pulls, weights = [], []
    for number in range(poses):
        rows = picture == number
        at = shared + own * number
        taken, _ = np.linalg.qr(jacobian[rows, at : at + own])
        rest = jacobian[rows, :shared] - taken @ (taken.T @ jacobian[rows, :shared])
        pulls.append(rest.T @ residuals[rows])
        weights.append(rest.T @ rest)
    total = np.sum(weights, axis=0)
    size = 1.0 / np.sqrt(np.maximum(np.diag(total), 1e-300))
    values, vectors = np.linalg.eigh(total * np.outer(size, size))
    told = values > LEAST * values[-1]
    root = vectors[:, told] / np.sqrt(values[told]) * size[:, None]
    noise = float(residuals @ residuals) / max(1, residuals.size - jacobian.shape[1])
    found, chance = 0.0, 0.0
    for pull, weight in zip(pulls, weights, strict=True):
        shares, ways = np.linalg.eigh(root.T @ weight @ root)
        found += float(np.sum((ways.T @ (root.T @ pull)) ** 2 / np.maximum(1.0 - shares, ALONE)))
        chance += 2.0 * float(np.sum(shares**2))
    count = int(told.sum())
    factor, sd = found / (noise * count), float(np.sqrt(chance)) / count
    return float(factor) if factor > 1.0 + CHANCE * sd else 1.0


def excess(jacobian: Floats, residuals: Floats, variance: float) -> Floats:
    """Covariance (k, k) of a picture's own pose beyond what the usual variance of a residual gives; zero or more.

    A board that stands aslant is seen less sharply than most. Of the picture that defines the lab frame that counts in
    full, since every point hangs on its pose, where it is more than chance explains.

    Parameters
    ----------
    jacobian, residuals
        (n, k) and (n,): of the picture alone.
    variance
        Of a residual in all pictures.
    """
    freedom = max(1, residuals.size - jacobian.shape[1])
    more = float(residuals @ residuals) / freedom - variance
    if not more > CHANCE * np.sqrt(2.0 / freedom) * variance:
        more = 0.0
    return np.asarray(more * np.linalg.inv(jacobian.T @ jacobian))
