"""A scenario explained before it is run: forces, balance, step-out, swimming, sinking, which end leads."""

from helimag.diagnosis.along import Forces, forces_along
from helimag.diagnosis.scenario import Diagnosis, Travel, diagnose
from helimag.diagnosis.text import as_json, as_text

__all__ = ["Diagnosis", "Forces", "Travel", "as_json", "as_text", "diagnose", "forces_along"]
