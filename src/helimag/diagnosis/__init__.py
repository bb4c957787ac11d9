"""A scenario explained before it is run: forces, balance, step-out, swimming, sinking, which end leads."""

from helimag.diagnosis.scenario import Diagnosis, Travel, diagnose
from helimag.diagnosis.text import as_json, as_text

__all__ = ["Diagnosis", "Travel", "as_json", "as_text", "diagnose"]
