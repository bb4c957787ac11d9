"""What surrounds a device: how it answers a load, in open water or elsewhere."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import warp as wp

from helimag.engine.poses import LONGEST
from helimag.errors import InputError
from helimag.physics.balance import OpenWater, nothing_again, nothing_near, open_water
from helimag.scenario import Scenario


def _nothing_around(scenarios: Sequence[Scenario], device: str) -> wp.array:
    """Surroundings of devices in open water."""
    return wp.zeros(len(scenarios), dtype=OpenWater, device=device)


class Alike(Enum):
    """Where a medium answers alike, so that the answer repeats itself in a frame that moves along."""

    NOWHERE = "nowhere"
    SIDEWAYS = "sideways"  # wherever it is moved level or turned about the vertical
    EVERYWHERE = "everywhere"


@wp.func
def unheld(surroundings: Any) -> Any:
    """Surroundings of which no wall holds the device: all of them."""
    return surroundings


@dataclass(frozen=True)
class Medium:
    """What surrounds the device, and how it answers a load there.

    Attributes
    ----------
    response
        ``response(body, here, position, rotation, load)``: velocity (m/s) and angular velocity (rad/s) that a load
        (N, N m) gives the device, all in the body frame: its mobility, which may depend on where it is. Linear in the
        load, but where walls hold.
    local
        ``local(surroundings, position, rotation, sheets)``: what ``response`` needs to know of the surroundings there
        (``here``), some of it on ``sheets``, where ``response`` may write too. It is asked once a step, about the
        step's middle: for what costs too much to ask at every stage, and what of it changes within a step, by some
        twenty degrees of the magnet, ``response`` can tell.
    pack
        ``pack(scenarios, device)``: an array of surroundings, one a scenario, on the device; those of a scenario that
        is in another medium are never looked at.
    touched
        ``touched(here, state, rates)``: bits of the walls that push a device whose state has these rates; None
        where no wall does.
    alike
        Where it answers alike. A medium that does not say so is none to leap over turns in.
    clear, beyond
        The same medium as long as the device keeps clear of walls that hold, None for itself; and
        ``beyond(surroundings)``: what surrounds the device then.
    again
        ``again(surroundings, position, rotation, sheets, look, known)``: ``local`` on row ``look`` of ``sheets``; where
        it is ``known`` (not zero) from a turn of the magnet much like this one, from what that left there. None for a
        medium that is as soon asked anew.
    longest_step
        Longest step (turns of the magnet): for how long what ``local`` told holds, but for what ``response`` knows; a
        third at most, as far as :mod:`helimag.engine.poses` goes.
    lanes
        Whether ``response`` is known to be said over lanes, see :mod:`helimag.engine.lanes`.
    """

    response: wp.Function = open_water
    local: wp.Function = nothing_near
    pack: Callable[[Sequence[Scenario], str], wp.array] = _nothing_around
    touched: wp.Function | None = None
    alike: Alike = Alike.NOWHERE
    clear: "Medium | None" = None
    beyond: wp.Function = unheld
    again: wp.Function | None = None
    longest_step: float = 0.125
    lanes: bool = False

    def __post_init__(self) -> None:
        if not 0.0 < self.longest_step <= LONGEST:
            raise InputError(
                f"longest_step must be greater than zero and at most {LONGEST:.3g} turns of the magnet; "
                f"got {self.longest_step:g}"
            )

    @property
    def surroundings_type(self) -> Any:
        """Structure that describes the surroundings of a run."""
        return self.local.input_types["surroundings"]

    @property
    def here_type(self) -> Any:
        """Structure that describes them at a place."""
        return self.response.input_types["here"]


OPEN_WATER = Medium(alike=Alike.EVERYWHERE, again=nothing_again, longest_step=LONGEST, lanes=True)
