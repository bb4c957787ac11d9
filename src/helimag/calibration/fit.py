"""What a calibration found: samples of the posterior, in and out of netCDF, and what they say."""

import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from helimag import quantities as q
from helimag.calibration.plan import CalibrationPlan
from helimag.errors import InputError
from helimag.notebook import summary
from helimag.runs import versions, write_netcdf
from helimag.runs.netcdf import read_netcdf
from helimag.scenario import Input, Scenario

if TYPE_CHECKING:
    import xarray

Floats = NDArray[np.float64]

FORMAT = "helimag calibration 1"
SHARES = (0.05, 0.5, 0.95)
NUMBERS = ("evidence", "evidence_sd", "evaluations")


@dataclass(frozen=True)
class Posterior:
    """Samples of the posterior, each as likely, with the plan that they answer.

    Attributes
    ----------
    plan
        With its scenarios in full, so that the file tells all by itself.
    names, units
        Of the free inputs (k).
    samples
        (n, k), SI.
    loglikelihood, logprior
        (n,): of each sample; the prior's density but for a constant.
    prior
        (3, k): 5, 50 and 95 % of each prior, SI.
    labels, data_units
        Of the numbers that were observed (m).
    observed, sd
        (m,): what was observed, and how well.
    side
        (m,): 0; -1 where all below what was observed is as good, +1 where all above is.
    predicted
        (n, m): the same numbers at each sample.
    evidence, evidence_sd
        Natural logarithm of the evidence, and its standard deviation.
    evaluations
        How often the likelihood was computed.
    """

    plan: CalibrationPlan
    names: tuple[str, ...]
    units: tuple[str, ...]
    samples: Floats
    loglikelihood: Floats
    logprior: Floats
    prior: Floats
    labels: tuple[str, ...]
    data_units: tuple[str, ...]
    observed: Floats
    sd: Floats
    side: Floats
    predicted: Floats
    evidence: float
    evidence_sd: float
    evaluations: int

    def __repr__(self) -> str:
        return f"<Posterior {self.plan.name}: {len(self.samples)} samples of {', '.join(self.names)}>"

    def _repr_html_(self) -> str:
        """For notebooks: 5, 50 and 95 % of each input, in the unit that files use."""
        told = {}
        for i, name in enumerate(self.names):
            scale, unit = shown_unit(self, i)
            low, middle, high = self.quantiles[:, i] / scale
            told[name] = f"{middle:.5g} {unit} ({low:.5g} to {high:.5g})"
        told["log evidence"] = f"{self.evidence:.1f} \N{PLUS-MINUS SIGN} {self.evidence_sd:.1f}"
        return summary(f"{self.plan.name}: {len(self.samples)} samples", told)

    @cached_property
    def quantiles(self) -> Floats:
        """5, 50 and 95 % of each free input (3, k), SI."""
        return np.asarray(np.quantile(self.samples, SHARES, axis=0))

    @property
    def place(self) -> int:
        """Of the sample whose posterior density is highest."""
        return int(np.argmax(self.loglikelihood + self.logprior))

    @property
    def best(self) -> Floats:
        """The sample whose posterior density is highest (k,)."""
        return np.asarray(self.samples[self.place])

    @property
    def off(self) -> Floats:
        """Predicted less observed (n, m), in standard deviations of the data; nought where it is as good."""
        off = (self.predicted - self.observed) / self.sd
        return np.where(off * self.side > 0.0, 0.0, off)

    def likely(self, loglikelihood: float, *, level: float = 0.9) -> bool:
        """Whether values of that log-likelihood lie in the region of highest density that holds ``level`` of all.

        Density is that over the priors' own unit cube, where the prior is even: there the likelihood alone orders it.

        Returns
        -------
        bool
            True of the likeliest samples.
        """
        return bool(loglikelihood >= np.quantile(self.loglikelihood, 1.0 - level))

    def draws(self, count: int, random: np.random.Generator) -> Floats:
        """Some of the samples (count, k): each at most once more than any other.

        Returns
        -------
        ndarray
            (count, k), SI.
        """
        whole, rest = divmod(count, len(self.samples))
        order = random.permutation(len(self.samples))
        return np.asarray(self.samples[np.concatenate([np.tile(order, whole), order[:rest]]).astype(int)])

    def dataset(self) -> "xarray.Dataset":
        """As labelled arrays.

        Returns
        -------
        xarray.Dataset
            SI, with units and meanings as attributes.
        """
        import xarray

        said = {
            "samples": (("sample", "input"), self.samples, "samples of the posterior, SI; each as likely"),
            "loglikelihood": (("sample",), self.loglikelihood, "natural logarithm of the likelihood"),
            "logprior": (("sample",), self.logprior, "logarithm of the prior's density, but for a constant"),
            "prior": (("share", "input"), self.prior, "quantiles of the priors, SI"),
            "quantiles": (("share", "input"), self.quantiles, "quantiles of the posterior, SI"),
            "observed": (("datum",), self.observed, "what was observed, SI"),
            "observed_sd": (("datum",), self.sd, "its standard deviation, SI"),
            "side": (("datum",), self.side, "-1, +1 where all below, above what was observed is as good; else 0"),
            "predicted": (("sample", "datum"), self.predicted, "the same numbers of each sample's runs, SI"),
        }
        coordinates = {
            "input": list(self.names),
            "input_units": ("input", list(self.units)),
            "share": list(SHARES),
            "label": ("datum", list(self.labels)),
            "datum_units": ("datum", list(self.data_units)),
        }
        attributes: dict[str, Any] = {
            "Conventions": "CF-1.11",
            "format": FORMAT,
            "plan": self.plan.to_toml(),
            "versions": versions(),
        } | {name: getattr(self, name) for name in NUMBERS}
        data = {name: (dims, values, {"long_name": words}) for name, (dims, values, words) in said.items()}
        return xarray.Dataset(data, coordinates, attributes)

    def save(self, path: str | Path) -> None:
        """Write netCDF that xarray, MATLAB (``ncread``) and any HDF5 reader open.

        Raises
        ------
        FileError
            Where the file cannot be written; nothing is left behind.
        """
        write_netcdf(self.dataset(), path)

    @classmethod
    def load(cls, path: str | Path) -> "Posterior":
        """Read what :meth:`save` wrote.

        Returns
        -------
        Posterior
            As it was saved.

        Raises
        ------
        FileError
            Where the file cannot be read.
        InputError
            Where it is no calibration, or damaged.
        """
        dataset = read_netcdf(path)
        if dataset.attrs.get("format") != FORMAT:
            raise InputError(f"{path} is not a calibration; make one with helimag calibrate")
        try:
            return _checked(_read(dataset))
        except (KeyError, TypeError, ValueError) as error:
            reason = f"{type(error).__name__}: {error}" if not isinstance(error, InputError) else str(error)
            raise InputError(f"{path} is a damaged calibration: {' '.join(reason.split())[:300]}") from None


def _read(dataset: "xarray.Dataset") -> Posterior:
    def numbers(name: str, *dimensions: str) -> Floats:
        if dataset[name].dims != dimensions:
            raise InputError(f"'{name}' must have the dimensions {', '.join(dimensions)}")
        return np.asarray(dataset[name].values, dtype=np.float64)

    def words(name: str) -> tuple[str, ...]:
        return tuple(str(word) for word in dataset[name].values.tolist())

    return Posterior(
        plan=CalibrationPlan.model_validate(tomllib.loads(str(dataset.attrs["plan"]))),
        names=words("input"),
        units=words("input_units"),
        samples=numbers("samples", "sample", "input"),
        loglikelihood=numbers("loglikelihood", "sample"),
        logprior=numbers("logprior", "sample"),
        prior=numbers("prior", "share", "input"),
        labels=words("label"),
        data_units=words("datum_units"),
        observed=numbers("observed", "datum"),
        sd=numbers("observed_sd", "datum"),
        side=numbers("side", "datum"),
        predicted=numbers("predicted", "sample", "datum"),
        evidence=float(dataset.attrs["evidence"]),
        evidence_sd=float(dataset.attrs["evidence_sd"]),
        evaluations=int(dataset.attrs["evaluations"]),
    )


def _checked(fit: Posterior) -> Posterior:
    """The fit, whose parts agree and are numbers."""
    if fit.names != tuple(free.title for free in fit.plan.free):
        raise InputError("its inputs are not those of its plan")
    if fit.samples.shape[0] < 2:
        raise InputError("it must have at least two samples")
    for name in ("samples", "loglikelihood", "logprior", "prior", "observed", "sd", "side", "predicted"):
        if not np.all(np.isfinite(getattr(fit, name))):
            raise InputError(f"its {name} are not all finite")
    if not np.all(fit.sd > 0.0):
        raise InputError("its standard deviations are not all above zero")
    return fit


def whole(plan: CalibrationPlan, bases: tuple[Scenario, ...]) -> CalibrationPlan:
    """The plan with its runs' scenarios in full, so that it stands by itself."""
    runs = tuple(
        run.model_copy(update={"base": base, "changes": {}}) for run, base in zip(plan.run, bases, strict=True)
    )
    return plan.model_copy(update={"run": runs})


def as_json(fit: Posterior) -> dict[str, Any]:
    """What was found as plain numbers, SI."""
    low, middle, high = fit.quantiles
    inputs = [
        {
            "input": name,
            "unit": unit,
            "p05": float(low[i]),
            "p50": float(middle[i]),
            "p95": float(high[i]),
            "best": float(fit.best[i]),
            "prior_p05": float(fit.prior[0, i]),
            "prior_p50": float(fit.prior[1, i]),
            "prior_p95": float(fit.prior[2, i]),
        }
        for i, (name, unit) in enumerate(zip(fit.names, fit.units, strict=True))
    ]
    return {"inputs": inputs, "evidence": fit.evidence, "evidence_sd": fit.evidence_sd, "evaluations": fit.evaluations}


def shown_unit(fit: Posterior, place: int) -> tuple[float, str]:
    """SI value and name of the unit in which files give a free input; 1 and nothing of a factor."""
    free = fit.plan.free[place]
    base = fit.plan.run[0].base
    if free.factor or not isinstance(base, Scenario):
        return 1.0, ""
    kind = Input(free.input).kind(base)
    return (1.0, "") if kind is None else (q.parse(f"1 {kind.shown}", kind), kind.shown)


def is_fit(path: str | Path) -> bool:
    """Whether a file is a calibration, damaged or not.

    Returns
    -------
    bool
        False of any other netCDF file.

    Raises
    ------
    FileError
        Where it cannot be read.
    """
    return bool(read_netcdf(path).attrs.get("format") == FORMAT)
