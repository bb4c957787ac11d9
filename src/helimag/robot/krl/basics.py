"""The calls of BAS that everyday programmes are full of, as far as they are arithmetic."""

from helimag.errors import InputError
from helimag.robot.krl.settings import Settings
from helimag.robot.krl.values import Reference, Value, Variables, Word

_FRAMES = {"#TOOL": ("$TOOL", "TOOL_DATA"), "#BASE": ("$BASE", "BASE_DATA")}


def bas(arguments: list[Value], settings: Settings, store: Variables) -> None:
    """Carry out BAS (#COMMAND, value).

    Raises
    ------
    InputError
        Where what it does hangs on the controller's own data, or is not one of the commands that are followed.
    """
    if not arguments or not isinstance(arguments[0], Word) or len(arguments) > 2:
        raise InputError("expected BAS (#COMMAND, value)")
    command, value = str(arguments[0]), arguments[1] if len(arguments) == 2 else 0
    match command:
        case "#INITMOV":
            if value != 0:
                raise InputError(f"expected BAS (#INITMOV,0); got {value!r}")
            settings.reset()
        case "#VEL_CP":
            settings.write(Reference("$VEL", None, ("CP",)), value)
        case "#ACC_CP":
            settings.write(Reference("$ACC", None, ("CP",)), value)
        case "#VEL_PTP" | "#ACC_PTP":
            _all_axes(f"${command[1:4]}_AXIS", value, settings)
        case "#TOOL" | "#BASE":
            _numbered(command, value, settings, store)
        case "#FRAMES":
            _frames(settings, store)
        case "#CP_PARAMS":
            _frames(settings, store)
            _path_data(settings, store)
            settings.write(Reference("$VEL", None, ("CP",)), value)
        case "#PTP_PARAMS":
            _frames(settings, store)
            _joint_data(settings, store)
            _all_axes("$VEL_AXIS", value, settings)
        case "#CP_DAT":
            _path_data(settings, store)
        case "#PTP_DAT":
            _joint_data(settings, store)
        case _:
            raise InputError(f"BAS ({command}) is not in the subset that helimag reads")


def _all_axes(name: str, value: Value, settings: Settings) -> None:
    for i in range(1, 7):
        settings.write(Reference(name, i), value)


def _numbered(command: str, number: Value, settings: Settings, store: Variables) -> None:
    """$TOOL or $BASE from the numbered frames; number 0 is the null frame."""
    target, table = _FRAMES[command]
    if isinstance(number, (bool, str, dict)) or number != int(number) or not 0 <= number < 1000:
        raise InputError(f"expected the number of a frame in {table}; got {number!r}")
    if number == 0:
        settings.write(Reference(target), dict.fromkeys("XYZABC", 0.0))
    else:
        settings.write(Reference(target), store.read(Reference(table, int(number))))
    if command == "#TOOL":
        settings.forget("$LOAD")  # it becomes the controller's own LOAD_DATA


def _frames(settings: Settings, store: Variables) -> None:
    """What FDAT_ACT says: tool, base, and in which of them the path is made."""
    for command, part in (("#TOOL", "TOOL_NO"), ("#BASE", "BASE_NO")):
        _numbered(command, store.read(Reference("FDAT_ACT", None, (part,))), settings, store)
    settings.write(Reference("$IPO_MODE"), store.read(Reference("FDAT_ACT", None, ("IPO_FRAME",))))


def _path_data(settings: Settings, store: Variables) -> None:
    """What LDAT_ACT says. Most of it is a share of the controller's own data, so it is not known after it."""
    settings.write(Reference("$APO", None, ("CDIS",)), store.read(Reference("LDAT_ACT", None, ("APO_DIST",))))
    data = store.read(Reference("LDAT_ACT"))
    for part, name in (("ORI_TYP", "$ORI_TYPE"), ("CIRC_TYP", "$CIRC_TYPE")):
        if isinstance(data, dict) and part in data:
            settings.write(Reference(name), data[part])
    settings.forget("$ACC", "$APO.CORI", "$VEL")


def _joint_data(settings: Settings, store: Variables) -> None:
    """What PDAT_ACT says."""
    _all_axes("$ACC_AXIS", store.read(Reference("PDAT_ACT", None, ("ACC",))), settings)
    data = store.read(Reference("PDAT_ACT"))
    by_way = isinstance(data, dict) and data.get("APO_MODE") == "#CDIS"
    rounding = store.read(Reference("PDAT_ACT", None, ("APO_DIST",)))
    settings.write(Reference("$APO", None, ("CDIS" if by_way else "CPTP",)), rounding)
