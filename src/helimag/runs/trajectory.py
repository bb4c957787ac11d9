"""A run, simulated or measured: labelled arrays with units and provenance, in and out of netCDF."""

import json
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from helimag.errors import InputError
from helimag.notebook import summary
from helimag.outcomes import End, Limit, Verdict, cf_masks
from helimag.runs.gain import Judgement, judge
from helimag.runs.heights import Heights, SlowTimes
from helimag.runs.leading import leading_end, path_cosine
from helimag.runs.netcdf import read_netcdf, write_netcdf
from helimag.runs.touches import Touch, touches_from
from helimag.runs.validation import check_run

if TYPE_CHECKING:
    import xarray

Floats = NDArray[np.float64]

# name: dimensions, unit, meaning. The lab frame has z up; body axes are the device's own, x towards the nose.
VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "position": (("time", "axis"), "m", "centre of the head, lab frame"),
    "quaternion": (("time", "component"), "1", "rotation from body to lab, scalar first"),
    "long_axis": (("time", "axis"), "1", "unit vector from helix to head, lab frame"),
    "attack_angle": (("time",), "rad", "elevation of the long axis above the horizontal; negative points down"),
    "rpm_position": (("time", "axis"), "m", "centre of the rotating permanent magnet, lab frame"),
    "rpm_moment": (("time", "axis"), "A m2", "moment of the rotating permanent magnet, lab frame"),
    "field": (("time", "axis"), "T", "flux density at the head, lab frame"),
    "phase_lag": (("time",), "rad", "angle about the long axis from the device's moment to the field"),
    "gap": (("time",), "m", "distance between the centres of head and magnet"),
    "height_low": (("time",), "m", "lowest head since the sample before"),
    "height_high": (("time",), "m", "highest head since the sample before"),
    "height_mean": (("time",), "m", "mean height of the head since the sample before"),
    "attack_mean": (("time",), "rad", "mean attack angle since the sample before"),
    "attack_mean_square": (("time",), "rad2", "mean squared attack angle since the sample before"),
    "slips": (("time",), "1", "turns slipped against the field so far"),
    "walls": (("time",), "1", "walls that pushed since the sample before, as bits"),
    "contact_count": (("wall",), "1", "how often the device came to each wall"),
    "contact_first": (("wall",), "s", "when it first did; 0 where it never did"),
    "contact_last": (("wall",), "s", "when each wall last pushed; 0 where it never did"),
    "contact_total": (("wall",), "s", "how long each wall pushed"),
    "position_covariance": (
        ("time", "axis", "other_axis"),
        "m2",
        "covariance of the measured position, frame to frame",
    ),
    "position_noise": (("time", "axis"), "m", "standard deviation of the measured position from frame to frame"),
    "attack_angle_sd": (("time",), "rad", "standard deviation of the measured attack angle"),
    "misfit": (("time",), "1", "disagreement of the two views, squared, over what is typical"),
    "segment": (("time",), "1", "number of the stretch without gaps that a measured sample belongs to"),
}


class Unlabelled(dict[str, Floats]):
    """A run's arrays by name, and its attributes: a dataset before xarray, which is slow to import, has seen it."""

    def __init__(self, arrays: Mapping[str, Floats], attrs: Mapping[str, Any]) -> None:
        super().__init__(arrays)
        self.attrs = dict(attrs)


def _labelled(columns: Unlabelled) -> "xarray.Dataset":
    """The columns with axes, units and meanings."""
    import xarray

    coordinates = {
        "time": ("time", columns["time"], {"units": "s", "long_name": "time since the start"}),
        "axis": ["x", "y", "z"],
        "component": ["w", "x", "y", "z"],
    }
    data = {
        name: (VARIABLES[name][0], values, {"units": VARIABLES[name][1], "long_name": VARIABLES[name][2]})
        for name, values in columns.items()
        if name != "time"
    }
    dataset = xarray.Dataset(data, coordinates, columns.attrs)
    if "walls" in columns:
        dataset = dataset.assign_coords(wall=[str(wall) for wall in Limit])
        dataset["walls"].attrs |= cf_masks(Limit)
    return dataset


class Trajectory:
    """A run as a labelled dataset, with its gain and verdict. Treat it as frozen.

    Parameters
    ----------
    dataset
        At least ``time`` (s) and ``position`` (m), and the attributes ``initial_gap`` (m) and ``end``.
    """

    def __init__(self, dataset: "xarray.Dataset | Unlabelled") -> None:
        missing = [name for name in ("time", "position") if name not in dataset]
        missing += [name for name in ("initial_gap", "end") if name not in dataset.attrs]
        if missing:
            raise InputError(f"a trajectory needs {', '.join(missing)}")
        self._given = dataset

    @classmethod
    def from_arrays(cls, time: Floats, variables: dict[str, Floats], attributes: dict[str, object]) -> Self:
        """Build from plain arrays named as in ``VARIABLES`` (SI); axes, units and meanings are labelled when asked.

        Returns
        -------
        Trajectory
            Simulated or measured, as the attributes say.
        """
        return cls(Unlabelled({"time": time, **variables}, {"Conventions": "CF-1.11", **attributes}))

    @cached_property
    def dataset(self) -> "xarray.Dataset":
        """The run as labelled arrays."""
        return _labelled(self._given) if isinstance(self._given, Unlabelled) else self._given

    @property
    def attributes(self) -> Mapping[str, Any]:
        """Name, source, scenario and what else goes with the whole run, as in ``dataset.attrs``."""
        return self._held.attrs

    @property
    def _held(self) -> "xarray.Dataset | Unlabelled":
        """What the run is read from: once there is a dataset, from that, which its user may have changed."""
        return self.dataset if "dataset" in self.__dict__ else self._given

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a trajectory that :meth:`save` wrote.

        Returns
        -------
        Trajectory
            As it was saved.

        Raises
        ------
        FileError
            Where the file cannot be read.
        InputError
            Where it is not a trajectory, or holds what no run can: times that do not rise, numbers that are none.
        """
        dataset = read_netcdf(path)
        try:
            run = cls(dataset)
            check_run(dataset, VARIABLES)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        return run

    def save(self, path: str | Path) -> None:
        """Write netCDF that xarray, MATLAB (``ncread``), Octave and any HDF5 reader open.

        Gain, verdict and reason go with it as attributes, worked out anew whenever a run is written.

        Raises
        ------
        FileError
            Where the file cannot be written; nothing is left behind.
        """
        write_netcdf(self.dataset.assign_attrs(self._told()), path)

    def noted(self, **attributes: str | float) -> "Trajectory":
        """The same run with further attributes.

        Returns
        -------
        Trajectory
            A copy.
        """
        return type(self)(self.dataset.assign_attrs(attributes))

    def _told(self) -> dict[str, str | float]:
        """The judgement as attributes; nothing of a run that cannot be judged."""
        try:
            judgement = self.judgement
        except InputError:
            return {}
        return {
            "gain": judgement.gain,
            "output_y": judgement.output,
            "input_u": judgement.input,
            "verdict": str(judgement.verdict),
            "reason": judgement.reason,
        }

    @cached_property
    def judgement(self) -> Judgement:
        """Gain, verdict and what goes with them (SI, radians)."""
        return judge(self.heights)

    @property
    def gain(self) -> float:
        """Range of heights over the initial height difference to the magnet (eq. 6)."""
        return self.judgement.gain

    @property
    def verdict(self) -> Verdict:
        """The verdict: how the run is judged."""
        return self.judgement.verdict

    @property
    def heights(self) -> Heights:
        """What a judgement needs; what happens between samples is taken from the samples where it was not recorded."""
        height = self._values("position")[:, 2]
        attack = self._values("attack_angle", np.zeros_like(height))
        slips = self._values("slips", np.zeros_like(height))
        return Heights(
            time=self._values("time"),
            low=self._values("height_low", height),
            high=self._values("height_high", height),
            mean=self._values("height_mean", height),
            attack=self._values("attack_mean", attack),
            attack_square=self._values("attack_mean_square", attack**2),
            slips=int(slips[-1]) if slips.size else 0,
            initial_gap=float(self.attributes["initial_gap"]),
            end=End.of(self.attributes["end"]),
            slow=self._slow_times,
            touches=self.touches,
        )

    @property
    def touches(self) -> tuple[Touch, ...]:
        """Contacts with each wall that held the device; none where walls stop a run."""
        if "contact_count" not in self._held:
            return ()
        names = ("count", "first", "last", "total")
        return touches_from({name: self._values(f"contact_{name}") for name in names})

    @property
    def _slow_times(self) -> SlowTimes | None:
        """Those of the scenario, where they are known."""
        fold, lap = (self.attributes.get(name) for name in ("fold_time", "lap_time"))
        return None if fold is None else SlowTimes(lap=None if lap is None else float(lap), fold=float(fold))

    @cached_property
    def leading_cosine(self) -> float:
        """Mean cosine between nose and velocity, weighted by the way gone: 1 head first, -1 helix first.

        nan where the run holds no attitudes, or the device stays in its place.
        """
        nowhere = np.full_like(self._values("position"), np.nan)
        return path_cosine(self._values("position"), self._values("long_axis", nowhere))

    @property
    def leading_end(self) -> str:
        """The end in front: ``"head"``, ``"helix"``, or ``"neither"``."""
        return leading_end(self.leading_cosine)

    @property
    def final_state(self) -> Floats:
        """Head position (m) and quaternion w, x, y, z at the end: (7,)."""
        return np.concatenate([self._values("position")[-1], self._values("quaternion")[-1]])

    @property
    def scenario_toml(self) -> str | None:
        """The scenario that was run, as TOML; None for a measured run without one."""
        text = self.attributes.get("scenario")
        return None if text is None else str(text)

    def _values(self, name: str, otherwise: Floats | None = None) -> Floats:
        held = self._held
        if name not in held and otherwise is not None:
            return otherwise
        return np.asarray(held[name], dtype=np.float64)

    def __repr__(self) -> str:
        judgement = self.judgement
        return f"<Trajectory {self.attributes.get('name', '')}: gain {judgement.gain:.3f}, {judgement.reason}>"

    def _repr_html_(self) -> str:
        """For notebooks: the judgement; the arrays are in ``dataset``."""
        judgement = self.judgement
        told = {
            "verdict": f"{judgement.verdict}: {judgement.reason}",
            "gain": f"{judgement.gain:.3f} (y {1e3 * judgement.output:.2f} mm, u {1e3 * judgement.input:.2f} mm)",
            "leads": self.leading_end,
            "source": str(self.attributes.get("source", "unknown")),
            "scenario": str(self.attributes.get("scenario_hash", "unknown"))[:12],
        }
        return summary(str(self.attributes.get("name", "a run")), told)


def versions() -> str:
    """Versions of what made a result, as JSON: helimag, Warp, NumPy, Python."""
    import platform
    from importlib.metadata import version

    found = {name: version(name) for name in ("helimag", "warp-lang", "numpy")}
    return json.dumps({**found, "python": platform.python_version()})
