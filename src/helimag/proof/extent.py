"""How wide a tube may be, as floats suggest it from second and third derivatives. The enclosures decide."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from helimag.proof.bending import Moving, Sampled
from helimag.proof.guess import Guess
from helimag.proof.motion import LENGTH, TURN_PER_LENGTH
from helimag.proof.tube import N
from helimag.proof.waves import Floats

ROOM = 8.0  # for fast blocks, whose radii cost the slow ones little
FAST = 20.0  # times the slowest decay: so fast a block comes into the tube from further off
WIDER = 3.0  # third derivatives as they are enclosed, beside what they are
STEPS = 200


@dataclass(frozen=True)
class Extent:
    """Radii of a tube's outer box by block, and those of a ball of starts, in which fast blocks are further off."""

    radii: Floats
    entry: Floats
    ball: float  # radius of the ball, m


@dataclass(frozen=True)
class Norms:
    """Largest norms on the curve of second (blocks^3) and third (blocks^4) derivatives, by block.

    ``around`` is how far into each block a ball of starts of 1 m reaches as a turn begins.
    """

    rate: Floats
    second: Floats
    third: Floats
    around: Floats

    @property
    def slow(self) -> Floats:
        """Which blocks decay slowly."""
        return np.asarray(self.rate < FAST * self.rate.min())


def norms_of(guess: Guess, at: Sampled, motion: Moving) -> Norms:
    """What limits a tube around a guess, in its coordinates."""
    parts = [slice(a, b) for a, b in pairwise((*guess.blocks, N))]
    second = [[[length(motion.second[i, j, k]) for k in parts] for j in parts] for i in parts]
    third = [[[[length(motion.third[i, j, k, n]) for n in parts] for k in parts] for j in parts] for i in parts]
    across = np.linalg.inv(at.frame[:, :, 0])
    weight = np.array([1.0 / float(LENGTH)] * 3 + [TURN_PER_LENGTH] * 3)
    halves = slice(3), slice(3, N)  # place and attitude, each of which may be off by all of it
    around = np.array([sum(np.linalg.norm((across[i] * weight)[:, half]) for half in halves) for i in parts])
    return Norms(np.abs(guess.decay), np.array(second), np.array(third), around)


def length(derivatives: Floats) -> float:
    """Greatest length of derivatives, over time."""
    return float(np.sqrt((derivatives**2).sum(axis=tuple(range(derivatives.ndim - 1))).max()))


def extent_of(norms: Norms) -> Extent:
    """The widest outer box that floats suggest: widest in the blocks that decay slowly.

    Fast blocks get what the slow ones stir up in them; a start may be further off in them, and comes in.
    """

    def widest(radii: Floats) -> float:
        """By what these radii may be multiplied, and all within come nearer: see :mod:`helimag.proof.theorem`."""
        one = np.einsum("ijk,j,k->i", norms.second, radii, radii) / radii / 2.0
        two = WIDER * np.einsum("ijkl,j,k,l->i", norms.third, radii, radii, radii) / radii / 6.0
        return float((2.0 * norms.rate / (one + np.sqrt(one**2 + 4.0 * two * norms.rate))).min())

    def ball(radii: Floats) -> float:
        """How large a ball of starts, in slow blocks, a tube of these relative radii allows."""
        return widest(radii) * float((radii / norms.around)[norms.slow].min())

    radii, step = norms.around.copy(), 2.0
    for _ in range(STEPS):
        steps = [np.where(np.arange(len(radii)) == i, step**sign, 1.0) for i in range(len(radii)) for sign in (1, -1)]
        best = max((radii * each for each in steps), key=ball)
        if ball(best) > ball(radii) * 1.001:
            radii = best
        elif step < 1.05:
            break
        else:
            step = float(np.sqrt(step))
    found = ball(radii)
    return Extent(radii * widest(radii) * np.where(norms.slow, 1.0, ROOM), norms.around * found, found)
