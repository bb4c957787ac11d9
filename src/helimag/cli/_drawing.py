"""The options that go with --ensemble: what differs from run to run beside the device, and how many are drawn.

A command takes them as one parameter, ``errors: ErrorOptions = NO_ERRORS`` or ``drawing: DrawOptions = NO_DRAWING``.
"""

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from helimag.cli._shared import LARGEST_SEED, quantity, whole
from helimag.errors import InputError

if TYPE_CHECKING:
    from helimag.ensembles import Noise
    from helimag.scenario import Scenario


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ErrorOptions:
    """Errors of each run with an ensemble; None where they are left out."""

    noise: Annotated[
        list[str] | None,
        Parameter(
            negative="",
            consume_multiple=False,
            help="With an ensemble: an input's error from run to run, a standard deviation such as "
            'drive.pitch="0.2 deg". May be repeated.',
        ),
    ] = None
    displacement: Annotated[
        str | None,
        Parameter(
            help='With an ensemble: the standard deviation, such as "50 um", along each axis of where the device is '
            "released."
        ),
    ] = None
    seed: Annotated[int | None, whole(0, LARGEST_SEED, help="With an ensemble: of the draws; 0 if left out.")] = None

    def check_unused(self) -> None:
        """Refuse them without an ensemble."""
        for field in fields(self):
            if getattr(self, field.name) is not None:
                raise InputError(f"--{field.name} goes with --ensemble only")

    @property
    def deviations(self) -> dict[str, str]:
        """Standard deviations of inputs, as text by path."""
        texts: dict[str, str] = {}
        for each in self.noise or []:
            path, equals, sd = each.partition("=")
            if not equals:
                raise InputError(
                    f"--noise must be an input and its standard deviation, drive.pitch='0.2 deg'; got {each!r}"
                )
            texts[path.strip()] = sd.strip().strip("\"'")
        return texts

    def noise_in(self, scenario: "Scenario") -> "Noise":
        """Errors of each run of a scenario."""
        from helimag import quantities
        from helimag.ensembles import noise_of

        moved = 0.0 if self.displacement is None else quantity("--displacement", self.displacement, quantities.LENGTH)
        return noise_of(scenario, self.deviations, moved, "--noise")


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class DrawOptions(ErrorOptions):
    """The same, and how many devices are drawn."""

    draws: Annotated[
        int | None,
        whole(
            1,
            100_000,
            help="With an ensemble: how many devices; if left out, 100 of one run and 32 of each point of a sweep.",
        ),
    ] = None

    @property
    def table(self) -> dict[str, object]:
        """What is given, as a plan's [ensemble] has it."""
        given = {
            "draws": self.draws,
            "seed": self.seed,
            "displacement": self.displacement,
            "noise": self.deviations or None,
        }
        return {key: value for key, value in given.items() if value is not None}


NO_ERRORS, NO_DRAWING = ErrorOptions(), DrawOptions()
