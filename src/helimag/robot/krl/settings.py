"""The controller's settings that a programme may change: what each may be, and what each is when nothing is said."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from helimag.errors import InputError
from helimag.robot.krl.values import Reference, Value, Word, single, split

Setting = float | str


@dataclass(frozen=True)
class Number:
    """A number above ``above`` and up to ``most``; ``whole`` where the controller takes no other."""

    above: float
    most: float
    whole: bool = False

    def checked(self, name: str, value: Value) -> Setting:
        """The value, if it fits."""
        if isinstance(value, (bool, str, dict)) or not self.above < value <= self.most:
            raise InputError(f"{name} must be a number above {self.above:g} and up to {self.most:g}; got {value!r}")
        if self.whole and value != int(value):
            raise InputError(f"{name} must be a whole number; got {value!r}")
        return single(value)


@dataclass(frozen=True)
class Choice:
    """One of a few words; others are refused with the reason."""

    words: tuple[str, ...]
    otherwise: str

    def checked(self, name: str, value: Value) -> Setting:
        """The value, if it fits."""
        if not isinstance(value, Word) or value not in self.words:
            raise InputError(f"{name} must be {' or '.join(self.words)}: {self.otherwise}; got {value!r}")
        return str(value)


_PERCENT = Number(0, 100, whole=True)
_ANGULAR = Number(0, 1e4)
_SHARE = Number(-1e-9, 100)
KINDS: Mapping[str, Number | Choice] = {
    "$VEL.CP": Number(0, 3.0),
    "$VEL.ORI1": _ANGULAR,
    "$VEL.ORI2": _ANGULAR,
    "$ACC.CP": Number(0, 100),
    "$ACC.ORI1": Number(0, 1e6),
    "$ACC.ORI2": Number(0, 1e6),
    "$APO.CDIS": Number(-1e-9, 1e3),
    "$APO.CORI": Number(-1e-9, 180),
    "$APO.CVEL": _SHARE,
    "$APO.CPTP": _SHARE,
    "$ADVANCE": Number(-1, 5, whole=True),
    "$OV_PRO": _PERCENT,
    "$IPO_MODE": Choice(("#BASE",), "motion in the tool's frame is not followed"),
    "$ORI_TYPE": Choice(("#VAR", "#CONSTANT"), "turns by the wrist's joints are not followed"),
    "$CIRC_TYPE": Choice(("#PATH", "#BASE"), "other turns on an arc are not followed"),
    "$LOAD.M": Number(0, 1e3),
    **{f"$LOAD.CM.{part}": Number(-1e4, 1e4) for part in "XYZ"},
    **{f"$LOAD.CM.{part}": Number(-360, 360) for part in "ABC"},
    **{f"$LOAD.J.{part}": Number(-1e-9, 1e4) for part in "XYZ"},
    **{f"$VEL_AXIS[{i}]": _PERCENT for i in range(1, 7)},
    **{f"$ACC_AXIS[{i}]": _PERCENT for i in range(1, 7)},
}
# what BAS (#INITMOV,0) leaves, as far as it does not hang on a controller's own data
DEFAULTS: Mapping[str, Setting] = {
    "$ADVANCE": 3.0,
    "$IPO_MODE": "#BASE",
    "$ORI_TYPE": "#VAR",
    "$CIRC_TYPE": "#BASE",
    **{f"$ACC_AXIS[{i}]": 100.0 for i in range(1, 7)},
}
FRAMES = ("$BASE", "$TOOL")
_GROUPS = ("$VEL", "$ACC", "$APO", "$LOAD", "$LOAD.CM", "$LOAD.J")
# settings without effect on a programme that runs forwards, and what their values are
IDLE: Mapping[str, tuple[type, str]] = {"$BWDSTART": (bool, "TRUE or FALSE"), "$H_POS": (dict, "joint angles")}


@dataclass
class Settings:
    """What is set at one point of a programme.

    ``assumed`` are the settings that neither the programme nor BAS (#INITMOV,0) has made: a controller has there what
    ran before left.
    """

    values: dict[str, Setting] = field(default_factory=lambda: dict(DEFAULTS))
    frames: dict[str, dict[str, float]] = field(default_factory=dict)
    override: float | None = None  # percent; None where the programme does not set it
    assumed: set[str] = field(default_factory=lambda: set(DEFAULTS))

    def reset(self) -> None:
        """What BAS (#INITMOV,0) does; the override stays."""
        self.values, self.frames, self.assumed = dict(DEFAULTS), {}, set()

    def write(self, reference: Reference, value: Value) -> None:
        """Carry out ``$name = value``.

        Raises
        ------
        InputError
            Where the value is out of bounds, or the setting is not one that helimag follows.
        """
        name = str(reference)
        if reference.name in FRAMES and reference.index is None:
            self._frame(reference, value)
        elif name in _GROUPS and isinstance(value, dict):
            for part, number in value.items():
                self.write(Reference(reference.name, None, (*reference.parts, part)), number)
        elif name == "$OV_PRO":
            self.override = float(KINDS[name].checked(name, value))
        elif name in KINDS:
            self.values[name] = KINDS[name].checked(name, value)
            self.assumed.discard(name)
        elif name in IDLE:
            kind, words = IDLE[name]
            if not isinstance(value, kind):
                raise InputError(f"{name} must be {words}; got {value!r}")
        else:
            raise InputError(f"{name} may change how the arm moves, and is not a setting that helimag follows")

    def _frame(self, reference: Reference, value: Value) -> None:
        if not reference.parts:
            if not isinstance(value, dict):
                raise InputError(f"{reference} must be a frame; got {value!r}")
            split(value)
            foreign = set(value) - set("XYZABC")
            if foreign:
                raise InputError(f"{reference} must be a frame; {', '.join(sorted(foreign))} does not belong to one")
            self.frames[reference.name] = {part: single(number) for part, number in value.items()}
            return
        if isinstance(value, (bool, str, dict)) or reference.parts[0] not in "XYZABC" or len(reference.parts) > 1:
            raise InputError(f"{reference} must be a number, and one of X, Y, Z, A, B, C; got {value!r}")
        if reference.name not in self.frames:
            raise InputError(f"{reference.name} must be set as a whole before {reference}")
        self.frames[reference.name] = {**self.frames[reference.name], reference.parts[0]: single(value)}

    def forget(self, *names: str) -> None:
        """Leave settings to the controller, whose own data the programme does not state; of groups, all parts."""
        groups = tuple(f"{name}." for name in names)
        for name in [known for known in self.values if known in names or known.startswith(groups)]:
            del self.values[name]

    def read(self, reference: Reference) -> Value:
        """The value of ``$name`` in an expression.

        Raises
        ------
        InputError
            Where the programme has not set it, so that it hangs on the controller.
        """
        name = str(reference)
        if name == "$NULLFRAME":
            return dict.fromkeys("XYZABC", 0.0)
        if name == "$OV_PRO":
            return 100 if self.override is None else int(self.override)
        if reference.name in self.frames and reference.index is None:
            frame = self.frames[reference.name]
            if not reference.parts:
                return dict(frame)
            if len(reference.parts) == 1 and reference.parts[0] in frame:
                return frame[reference.parts[0]]
        value = self.values.get(name)
        if value is None:
            raise InputError(f"{name} is not set by the programme: what it is hangs on the controller")
        return Word(value) if isinstance(value, str) else value

    def needed(self, name: str) -> float:
        """A number that must be set before a motion.

        Raises
        ------
        InputError
            Where it is not.
        """
        value = self.values.get(name)
        if not isinstance(value, float):
            raise InputError(f"{name} must be set to a positive number before this motion")
        return value

    def word(self, name: str) -> str:
        """A word that is set, or stands when nothing is said."""
        return str(self.values[name])

    @property
    def speed_share(self) -> float:
        """The override as a share; all of it where the programme does not set it."""
        return 1.0 if self.override is None else self.override / 100.0
