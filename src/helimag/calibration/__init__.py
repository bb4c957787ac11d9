"""Which device agrees with what was observed: plans, a posterior over free inputs, and what it predicts."""

from helimag.calibration.calibrating import calibrate
from helimag.calibration.drawing import check_device, drawn
from helimag.calibration.findings import Findings, findings
from helimag.calibration.fit import Posterior, as_json, is_fit, shown_unit
from helimag.calibration.next_run import Worth, worths
from helimag.calibration.numbers import NUMBERS
from helimag.calibration.plan import (
    CalibrationPlan,
    Candidate,
    Ending,
    Experiment,
    Free,
    ObservedNumber,
    Track,
    load_plan,
    parse_plan,
)
from helimag.calibration.prediction import DRAWS, Prediction, height_bands, predict
from helimag.calibration.problem import PreparedPlan, prepared
from helimag.ensembles import Noise

__all__ = [
    "DRAWS",
    "NUMBERS",
    "CalibrationPlan",
    "Candidate",
    "Ending",
    "Experiment",
    "Findings",
    "Free",
    "Noise",
    "ObservedNumber",
    "Posterior",
    "Prediction",
    "PreparedPlan",
    "Track",
    "Worth",
    "as_json",
    "calibrate",
    "check_device",
    "drawn",
    "findings",
    "height_bands",
    "is_fit",
    "load_plan",
    "parse_plan",
    "predict",
    "prepared",
    "shown_unit",
    "worths",
]
