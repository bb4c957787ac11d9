"""Closed curves as finite sums of cosines and sines, evaluated in balls: at a time, over a span, as series in time."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from helimag.proof.balls import exact, flint

if TYPE_CHECKING:
    from flint import arb, arb_mat

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Waves:
    """Functions of time in turns: component i is the sum of ``cos[i, j] cos(pi j s) + sin[i, j] sin(pi j s)``.

    Even j repeat after a turn, odd ones come back with the other sign. The floats are meant exactly.
    """

    cos: Floats
    sin: Floats

    @property
    def count(self) -> int:
        """How many functions these are."""
        return len(self.cos)

    def values(self, times: Floats) -> Floats:
        """The functions (n, times) in floats."""
        angle = np.pi * np.outer(np.arange(self.cos.shape[1]), times)
        return np.asarray(self.cos @ np.cos(angle) + self.sin @ np.sin(angle))

    def slopes(self, times: Floats) -> Floats:
        """Their derivatives (n, times) in floats."""
        order = np.pi * np.arange(self.cos.shape[1])
        angle = np.outer(order, times)
        return np.asarray((self.sin * order) @ np.cos(angle) - (self.cos * order) @ np.sin(angle))

    def lowest(self, harmonics: int) -> "Waves":
        """The same without harmonics above so many half turns in a turn."""
        return Waves(self.cos[:, : harmonics + 1], self.sin[:, : harmonics + 1])

    @cached_property
    def matrix(self) -> "arb_mat":
        """The coefficients (n, 2 harmonics) as balls of radius zero, cosines first."""
        rows = [[exact(float(value)) for value in row] for row in np.hstack([self.cos, self.sin])]
        return flint().arb_mat(rows)

    def series(self, at: "arb", order: int) -> "arb_mat":
        """Taylor coefficients (n, order) around every time of a ball."""
        return self.matrix * basis(self.cos.shape[1], at, order)


def basis(harmonics: int, at: "arb", order: int) -> "arb_mat":
    """Taylor coefficients (2 harmonics, order) of all cosines, then sines, around every time of a ball."""
    library = flint()
    pi = library.arb.pi()
    cosines, sines = [], []
    for j in range(harmonics):
        (sin, cos), power = (pi * j * at).sin_cos(), library.arb(1)
        cosine, sine = [], []
        for n in range(order):
            if n:
                power = power * (pi * j) / n
            # each derivative is a quarter turn ahead
            c, s = ((cos, sin), (-sin, cos), (-cos, -sin), (sin, -cos))[n % 4]
            cosine.append(power * c)
            sine.append(power * s)
        cosines.append(cosine)
        sines.append(sine)
    return library.arb_mat(cosines + sines)
